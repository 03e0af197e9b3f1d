#include "newton_engine.h"

#include <algorithm>  // min, max
#include <cmath>      // cbrt, isfinite
#include <limits>     // epsilon
#include <optional>
#include <type_traits>  // conditional
#include <utility>      // move
#include <vector>

#include "newton_contacts.h"  // NewtonContacts

#if defined(__SSE__)
#include <xmmintrin.h>  // _mm_getcsr
#endif

// one set of instructions for each generation of machines is enough, and vectors have one length
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "newton_engine.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "newton_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {

constexpr std::int64_t first_sweeps = 1;

/// mu, relative to the stiffness of a bar. Far from the solution a small one goes too far; near it
/// a large one holds back. A float's digits bear no small one.
constexpr double first_mu = 1e-2, largest_mu = 1e8;
constexpr double smallest_mu = 1e-6, smallest_float_mu = 1e-3;

/// Pairs so much longer than they should be, relative to their length, resist turning. Nearer to
/// the solution that holds the steps back.
constexpr double far = 0.5;

/// Stagnation: so many steps that together did not take this share of the energy away.
constexpr int patience = 6;
constexpr double progress = 0.2;

/// What the tolerance is short by, so that rounding does not break what is just within it.
constexpr double margin = 32;  // epsilons

/// What fades along the factor becomes so small that the machine would take a hundred times longer
/// over each product.
class TinyNumbersAreZero {
 public:
#if defined(__SSE__)
  TinyNumbersAreZero() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | 0x8040);
  }
  ~TinyNumbersAreZero() {
    _mm_setcsr(before_);
  }
  TinyNumbersAreZero(const TinyNumbersAreZero&) = delete;
  TinyNumbersAreZero& operator=(const TinyNumbersAreZero&) = delete;

 private:
  unsigned before_;
#endif
};

template <class T, bool kSingle>
class Engine final : public NewtonEngine {
  using Kernel = NewtonKernel<T, kSingle>;
  static constexpr std::size_t N = Kernel::kLanes;
  using Measure = typename Kernel::Measure;

 public:
  explicit Engine(std::shared_ptr<const NewtonTask> task)
      : task_(std::move(task)),
        framework_(*task_->framework),
        settings_(task_->settings),
        plan_(task_->plan),
        tables_(make_tables()),
        kernel_(plan_, tables_, !framework_.contact_rule().empty()) {
    const double value = settings_.tolerance.value();
    const double epsilon = double(std::numeric_limits<T>::epsilon());
    limit_ = std::max(value - margin * epsilon, value / 2);
    // closer than this, floats creep and tremble; what is left is for doubles
    if (!std::is_same_v<T, double>) limit_ = std::max(limit_, 16 * margin * epsilon);
    for (Lane& lane : lanes_) lane.contacts.emplace(framework_.contact_rule());
    if (!framework_.contact_rule().empty()) looked_up_at_ = Field<T>(kernel_.x.size());
  }

  int lanes() const override { return int(N); }

  void load(int index, std::span<const Vec3> positions, const Box* box,
            std::int64_t max_iterations) override {
    Lane& lane = lanes_[std::size_t(index)];
    lane.stage = Stage::fresh;
    lane.looked_up = false;
    lane.pulled = true;
    lane.turning = lane.changed = false;
    lane.box = box;
    lane.max_iterations = max_iterations;
    lane.end = {};
    bool finite = true;
    if (!std::is_same_v<T, double> && plan_.moving > 0)
      lane.centre = positions[std::size_t(plan_.joint[std::size_t(plan_.moving / 2)])];
    for (int s = 0; s < plan_.joints; ++s) {
      const Vec3 point = positions[std::size_t(plan_.joint[std::size_t(s)])] - lane.centre;
      T* at = kernel_.x + std::size_t(s) * Kernel::kJoint + std::size_t(index);
      for (int c = 0; c < 3; ++c) {
        at[std::size_t(c) * N] = T(point[c]);
        finite = finite && std::isfinite(at[std::size_t(c) * N]);
      }
    }
    for (std::size_t e = std::size_t(plan_.moving) * Kernel::kJoint; e < kernel_.x.size(); ++e)
      kernel_.trial[e] = kernel_.x[e];
    if (!finite) finish(lane, StopReason::not_finite);
  }

  bool done(int lane) const override { return lanes_[std::size_t(lane)].stage == Stage::ended; }

  void iterate() override {
    const TinyNumbersAreZero flush;
    if (any(Stage::fresh)) start();
    if (any(Stage::descending)) step();
  }

  NewtonEnd unload(int index, std::span<Vec3> positions) override {
    Lane& lane = lanes_[std::size_t(index)];
    lane.stage = Stage::empty;
    const StopReason reason = lane.end.reason;
    if (reason != StopReason::not_finite && reason != StopReason::nothing_broken)
      copy_out(kernel_.x, std::size_t(index), plan_.moving, positions);
    if (!std::is_same_v<T, double> &&
        (reason == StopReason::within_tolerance || reason == StopReason::nothing_broken))
      check(lane, positions);
    return lane.end;
  }

 private:
  enum class Stage { empty, fresh, descending, ended };
  struct Lane {
    Stage stage = Stage::empty;
    const Box* box = nullptr;
    std::int64_t max_iterations = 0;
    Vec3 centre = Vec3::Zero();  ///< floats count from here
    double mu = 0, marked_energy = 0;
    int since_mark = 0;
    bool held_back = false;  ///< the step before was taken back
    bool changed = false;    ///< the energy is made of other rows than before
    bool pulled = true;      ///< volumes that the bars leave one value are rows
    bool turning = false;    ///< stretched pairs resist turning
    NewtonEnd end;
    std::optional<NewtonContacts> contacts;
    bool looked_up = false;  ///< its contacts were, at a place of looked_up_at_
  };

  NewtonTables<T> make_tables() const {
    NewtonTables<T> tables;
    const bool weighted = settings_.mass_weights;
    for (int s = 0; s < plan_.joints; ++s)
      tables.masses.push_back(weighted ? T(std::max(plan_.masses[std::size_t(s)], 1e-6)) : T(1));
    const auto readiness = [&](int slot) {
      return slot < plan_.moving ? 1 / double(tables.masses[std::size_t(slot)]) : 0.0;
    };
    const double epsilon = double(std::numeric_limits<T>::epsilon());
    for (const NewtonPlan::Pair& pair : plan_.pairs) {
      const double p = readiness(pair.p), q = readiness(pair.q);
      const double slack = settings_.tolerance.slack(pair.length);
      tables.pairs.push_back({pair.p, pair.q, T(pair.side), T(pair.length), T(1 / pair.length),
                              T(std::max(slack - margin * epsilon * pair.length, slack / 2)),
                              p > 0 ? T(p / (p + q)) : T(0), q > 0 ? T(q / (p + q)) : T(0)});
    }
    for (const NewtonPlan::Corners& v : plan_.volumes) {
      typename NewtonTables<T>::Corners corners{};
      const double edge = std::cbrt(v.scale);
      for (std::size_t i = 0; i < 4; ++i) {
        corners.slot[i] = v.slot[i];
        corners.share[i] = T(readiness(v.slot[i]));
      }
      const double slack = settings_.tolerance.volume_slack(v.scale);
      corners.slack = T(std::max(slack - margin * epsilon * v.scale, slack / 2));
      corners.lower = T(v.lower);
      corners.upper = T(v.upper);
      corners.pulled = std::isfinite(v.aim);
      corners.aim = std::isfinite(v.aim) ? T(v.aim) : T(0);
      corners.inverse_scale = T(1 / v.scale);
      corners.inverse_area = T(1 / (edge * edge));
      tables.volumes.push_back(corners);
    }
    return tables;
  }

  bool any(Stage stage) const {
    return std::any_of(lanes_.begin(), lanes_.end(),
                       [stage](const Lane& lane) { return lane.stage == stage; });
  }

  void copy_out(const Field<T>& from, std::size_t index, int slots, std::span<Vec3> to) const {
    for (int s = 0; s < slots; ++s)
      to[std::size_t(plan_.joint[std::size_t(s)])] = point_of(from, index, s);
  }

  Vec3 point_of(const Field<T>& from, std::size_t index, int slot) const {
    const T* at = from + std::size_t(slot) * Kernel::kJoint + index;
    return lanes_[index].centre + Vec3(double(at[0]), double(at[N]), double(at[2 * N]));
  }

  /// What floats found to be within tolerance, by doubles. Contacts of the rule are measured in
  /// doubles anyway.
  void check(Lane& lane, std::span<const Vec3> positions) {
    const auto [residual, residual_nm] = plan_.measure(positions);
    const bool contacts = !framework_.contact_rule().empty();
    // unbroken positions are not those that floats round them to
    if (contacts && lane.end.reason == StopReason::nothing_broken) {
      lane.contacts->look_up(positions, lane.box);
      lane.looked_up = false;
      const auto at = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
      lane.contacts->measure(at, lane.box);
    }
    lane.end.residual = std::max(residual, contacts ? lane.contacts->residual() : 0);
    lane.end.residual_nm = std::max(residual_nm, contacts ? lane.contacts->residual_nm() : 0);
    const double worst = settings_.tolerance.absolute() ? lane.end.residual_nm : lane.end.residual;
    if (!(worst <= settings_.tolerance.value())) lane.end.reason = StopReason::stagnated;
  }

  void evaluate(const Field<T>& at, Stage stage) {
    kernel_.evaluate(at, manner_, measure_);
    if (framework_.contact_rule().empty()) return;
    HWY_ALIGN T furthest2[N];
    if (stage == Stage::descending) kernel_.furthest(at, looked_up_at_, furthest2);
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      // positions that are no numbers cannot be sorted into cells
      if (lane.stage != stage || !std::isfinite(measure_.energy[k])) continue;
      constexpr double room = NewtonContacts::room * (1 - 1e-5);  // but for rounding
      const bool known =
          stage == Stage::descending && lane.looked_up && double(furthest2[k]) < room * room;
      if (!known) look_up(at, k);
      const auto point = [&](int joint) { return point_of(at, k, plan_.slot[std::size_t(joint)]); };
      lane.contacts->measure(point, lane.box);
      measure_.energy[k] += T(lane.contacts->energy());
      measure_.relative[k] = std::max(measure_.relative[k], T(lane.contacts->residual()));
      measure_.nanometers[k] = std::max(measure_.nanometers[k], T(lane.contacts->residual_nm()));
    }
  }

  void look_up(const Field<T>& at, std::size_t k) {
    Lane& lane = lanes_[k];
    positions_.resize(std::size_t(plan_.joints));
    copy_out(at, k, plan_.joints, positions_);
    lane.contacts->look_up(positions_, lane.box);
    lane.looked_up = true;
    const std::size_t end = std::size_t(plan_.moving) * Kernel::kJoint;
    for (std::size_t s = k; s < end; s += Kernel::kJoint)
      for (std::size_t c = 0; c < 3 * N; c += N) looked_up_at_[s + c] = at[s + c];
  }

  /// How the rows of a lane are made when they are next. Not before: those that others make
  /// necessary have to be what they were.
  void settle_manner(std::size_t k) {
    manner_.pulled[k] = lanes_[k].pulled;
    manner_.turning[k] = lanes_[k].turning;
  }

  void keep_measure(Lane& lane, std::size_t k) const {
    lane.end.energy = double(measure_.energy[k]);
    lane.end.residual = double(measure_.relative[k]);
    lane.end.residual_nm = double(measure_.nanometers[k]);
  }

  bool within(const Lane& lane) const {
    return (settings_.tolerance.absolute() ? lane.end.residual_nm : lane.end.residual) <= limit_;
  }

  static void finish(Lane& lane, StopReason reason) {
    lane.end.reason = reason;
    lane.stage = Stage::ended;
  }

  // === Sweeps

  void start() {
    HWY_ALIGN T mask[N], changed[first_sweeps][N];
    for (std::int64_t round = 0; round < first_sweeps; ++round) {
      for (std::size_t k = 0; k < N; ++k)
        mask[k] = lanes_[k].stage == Stage::fresh && round < lanes_[k].max_iterations;
      kernel_.sweep(mask, changed[round]);
    }
    for (std::size_t k = 0; k < N; ++k)
      if (lanes_[k].stage == Stage::fresh) settle_manner(k);
    evaluate(kernel_.x, Stage::fresh);
    bool again = false;
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      if (lane.stage != Stage::fresh) continue;
      keep_measure(lane, k);
      const std::int64_t sweeps = std::min(first_sweeps, lane.max_iterations);
      std::int64_t needed = sweeps;
      while (needed > 0 && changed[needed - 1][k] == 0) --needed;
      if (!std::isfinite(lane.end.energy)) {
        finish(lane, StopReason::not_finite);
      } else if (within(lane)) {
        lane.end.iterations = needed;
        finish(lane, needed == 0 ? StopReason::nothing_broken : StopReason::within_tolerance);
      } else {
        lane.end.iterations = sweeps;
        lane.stage = Stage::descending;
        lane.mu = first_mu;
        lane.marked_energy = lane.end.energy;
        lane.since_mark = 0;
        lane.held_back = false;
        lane.turning = lane.end.residual > far;
        if (!lane.turning) continue;
        settle_manner(k);
        again = true;
      }
    }
    if (again) evaluate(kernel_.x, Stage::descending);
  }

  // === Newton steps

  void step() {
    for (Lane& lane : lanes_) {
      if (lane.stage != Stage::descending) continue;
      if (lane.end.iterations == lane.max_iterations) {
        finish(lane, StopReason::max_iterations);
      } else {
        ++lane.end.iterations;
      }
    }
    enter_contacts();
    HWY_ALIGN T mu[N], predicted[N], positive[N], mask[N];
    for (std::size_t k = 0; k < N; ++k)
      mu[k] = lanes_[k].stage == Stage::descending ? T(lanes_[k].mu) : T(1);
    kernel_.solve(mu, predicted, positive);
    for (std::size_t k = 0; k < N; ++k) settle_manner(k);
    evaluate(kernel_.trial, Stage::descending);
    bool taken_back = false;
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      mask[k] = 0;
      if (lane.stage != Stage::descending) continue;
      const double energy = double(measure_.energy[k]);
      // nowhere to go: no gradient worth the name
      if (positive[k] != 0 && !(double(predicted[k]) > 1e-13 * lane.end.energy)) {
        give_up(lane);
        settle_manner(k);
        taken_back = true;
        continue;
      }
      const bool accepted = positive[k] != 0 && std::isfinite(energy) && energy < lane.end.energy;
      const double gain = accepted ? (lane.end.energy - energy) / double(predicted[k]) : 0;
      if (accepted) {
        mask[k] = 1;
        keep_measure(lane, k);
        if (within(lane)) {
          finish(lane, StopReason::within_tolerance);
          continue;
        }
      }
      adapt(lane, accepted, gain);
      if (lane.stage != Stage::descending || (accepted && !lane.changed)) continue;
      settle_manner(k);
      taken_back = true;
    }
    kernel_.accept(mask);
    // where a step was taken back, rows are those of the trial
    if (!taken_back) return;
    evaluate(kernel_.x, Stage::descending);
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      if (lane.stage != Stage::descending || !lane.changed) continue;
      lane.changed = false;
      keep_measure(lane, k);
      lane.marked_energy = lane.end.energy;
      lane.since_mark = 0;
      if (within(lane)) finish(lane, StopReason::within_tolerance);
    }
  }

  /// Pairs of the contact rule come and go, which must not change the pattern: instead of coupling
  /// its ends, each end is held twice as stiffly. That bounds the coupled matrix from above.
  void enter_contacts() {
    if (framework_.contact_rule().empty()) return;
    kernel_.factor().clear_extras();
    for (std::size_t k = 0; k < N; ++k) {
      const Lane& lane = lanes_[k];
      if (lane.stage != Stage::descending) continue;
      for (const NewtonContacts::Active& pair : lane.contacts->active()) {
        const int p = plan_.slot[std::size_t(pair.p)], q = plan_.slot[std::size_t(pair.q)];
        const T u[3] = {T(pair.u[0]), T(pair.u[1]), T(pair.u[2])};
        const T stiffness = p < plan_.moving && q < plan_.moving ? T(2) : T(1);
        if (p < plan_.moving) kernel_.factor().add_extra(p, k, u, stiffness, T(pair.row));
        if (q < plan_.moving) kernel_.factor().add_extra(q, k, u, stiffness, T(-pair.row));
      }
    }
  }

  /// A step that leads nowhere: once more without pulling at volumes, which bars that cannot all
  /// be met may be at odds with.
  static void give_up(Lane& lane) {
    if (!lane.pulled) return finish(lane, StopReason::stagnated);
    lane.pulled = false;
    lane.turning = true;
    lane.held_back = false;
    lane.changed = true;
    lane.mu = first_mu;
  }

  void adapt(Lane& lane, bool accepted, double gain) const {
    constexpr double floor = std::is_same_v<T, double> ? smallest_mu : smallest_float_mu;
    if (!accepted) {
      lane.mu *= 10;
      lane.turning = true;
    } else {
      if (gain < 0.25) {
        lane.mu *= 4;
      } else if (gain >= 0.5) {
        lane.mu = std::max(floor, lane.mu / (lane.held_back ? 2 : 10));
      }
      if (!lane.held_back) lane.turning = lane.turning && lane.end.residual > far;
    }
    lane.held_back = !accepted;
    if (lane.mu > largest_mu) {
      give_up(lane);
    } else if (lane.end.energy < (1 - progress) * lane.marked_energy) {
      lane.marked_energy = lane.end.energy;
      lane.since_mark = 0;
    } else if (++lane.since_mark == patience) {
      give_up(lane);
    }
  }

  std::shared_ptr<const NewtonTask> task_;
  const Framework& framework_;
  const ResolverSettings& settings_;
  const NewtonPlan& plan_;
  NewtonTables<T> tables_;
  Kernel kernel_;
  double limit_ = 0;
  std::array<Lane, N> lanes_;
  Measure measure_;
  typename Kernel::Manner manner_;
  Field<T> looked_up_at_;        ///< positions, as the kernel holds them
  std::vector<Vec3> positions_;  ///< scratch
};

std::unique_ptr<NewtonEngine> make_engine(std::shared_ptr<const NewtonTask> task,
                                          Precision precision, bool single) {
  if (precision == Precision::single) {
    if (single) return std::make_unique<Engine<float, true>>(std::move(task));
    return std::make_unique<Engine<float, false>>(std::move(task));
  }
  if (single) return std::make_unique<Engine<double, true>>(std::move(task));
  return std::make_unique<Engine<double, false>>(std::move(task));
}

const char* instructions() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll {

HWY_EXPORT(make_engine);
HWY_EXPORT(instructions);

NewtonTask::NewtonTask(std::shared_ptr<const Framework> framework_in,
                       const ResolverSettings& settings_in)
    : framework(std::move(framework_in)), settings(settings_in), plan(*framework) {}

std::unique_ptr<NewtonEngine> make_newton_engine(std::shared_ptr<const NewtonTask> task,
                                                 Precision precision, bool single) {
  return HWY_DYNAMIC_DISPATCH(make_engine)(std::move(task), precision, single);
}

std::string newton_instructions() {
  return HWY_DYNAMIC_DISPATCH(instructions)();
}

}  // namespace ragdoll
#endif
