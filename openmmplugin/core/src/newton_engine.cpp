#include "newton_engine.h"

#include <algorithm>  // min, max, clamp
#include <cmath>      // isfinite
#include <limits>     // epsilon
#include <optional>
#include <type_traits>  // conditional
#include <utility>      // move
#include <vector>

#include "newton_contacts.h"  // NewtonContacts
#include "newton_tables.h"    // NewtonTables, make_newton_tables, newton_margin

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
constexpr double smallest_mu = 1e-6, smallest_float_mu = 5e-4;

/// While pairs beside the pattern are violated: a smaller one lets steps run into other pairs, and
/// every third step is taken back.
constexpr double smallest_mu_beside = 1e-2;

/// Of conjugate gradients: the smaller mu, the more rounds a step takes, and the fewer steps. What
/// a step may leave is what the one before left of the energy, from so much to so little.
constexpr double smallest_bulky_mu = 1e-4, first_accuracy = 0.3, best_accuracy = 0.1;

/// A step from within so many tolerances is corrected by its own factor, as long as the end is so
/// near and each time no more than this share of the energy is left. Lanes of floats wait for
/// memory, of which a correction needs as much as a step.
constexpr int most_corrections = 2;
constexpr double near_by = 60, at_hand = 8, quick = 0.25;

/// Pairs so much longer than they should be, relative to their length, resist turning. Nearer to
/// the solution that holds the steps back.
constexpr double far = 0.5;

/// Stagnation: so many steps that together did not take this share of the energy away.
constexpr int patience = 6;
constexpr double progress = 0.2;

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
  static constexpr bool kCorrects = std::is_same_v<T, double>;

 public:
  explicit Engine(std::shared_ptr<const NewtonTask> task)
      : task_(std::move(task)),
        framework_(*task_->framework),
        settings_(task_->settings),
        plan_(task_->plan),
        tables_(make_newton_tables<T>(plan_, settings_)),
        ruled_(!framework_.contact_rule().empty()),
        has_extras_(ruled_ || !plan_.far.empty()),
        kernel_(plan_, tables_, has_extras_ && !plan_.is_bulky) {
    if (!std::is_same_v<T, double>) exact_tables_ = make_newton_tables<double>(plan_, settings_);
    const double value = settings_.tolerance.value();
    const double epsilon = double(std::numeric_limits<T>::epsilon());
    limit_ = std::max(value - newton_margin * epsilon, value / 2);
    // closer than this, floats creep and tremble; what is left is for doubles
    if (!std::is_same_v<T, double>) limit_ = std::max(limit_, 16 * newton_margin * epsilon);
    for (Lane& lane : lanes_)
      lane.contacts.emplace(framework_.contact_rule(), plan_.far, plan_.joint);
    if (ruled_) looked_up_at_ = Field<T>(kernel_.x.size());
  }

  int lanes() const override { return int(N); }

  void load(int index, std::span<const Vec3> positions, const Box* box,
            std::int64_t max_iterations) override {
    Lane& lane = lanes_[std::size_t(index)];
    lane.stage = Stage::fresh;
    lane.looked_up = false;
    lane.pulled = true;
    lane.turning = lane.changed = false;
    lane.measured = true;
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
    if (!std::is_same_v<T, double> && (reason == StopReason::nothing_broken ||
                                       (reason == StopReason::within_tolerance && !all_move())))
      look_again(lane, positions);
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
    double accuracy = 0;  ///< of the next step, where it is made by conjugate gradients
    int since_mark = 0;
    bool held_back = false;  ///< the step before was taken back
    bool measured = true;    ///< its contacts are those of x, or of an accepted trial
    bool unjudged = false;   ///< ended by floats
    bool near = false;       ///< so close that a step is worth corrections
    bool changed = false;    ///< the energy is made of other rows than before
    bool pulled = true;      ///< volumes that the bars leave one value are rows
    bool turning = false;    ///< stretched pairs resist turning
    NewtonEnd end;
    std::optional<NewtonContacts> contacts;
    bool looked_up = false;  ///< its contacts were, at a place of looked_up_at_
    std::vector<NewtonContacts::Active> entered;  ///< those that the factor knows
  };

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

  /// What floats find to be within tolerance is measured in doubles. Pairs beside the pattern are
  /// anyway.
  void judge(Lane& lane, double residual, double residual_nm) const {
    lane.end.residual = std::max(residual, has_extras_ ? lane.contacts->residual() : 0);
    lane.end.residual_nm = std::max(residual_nm, has_extras_ ? lane.contacts->residual_nm() : 0);
    if (!(violation(lane.end) <= settings_.tolerance.value()))
      lane.end.reason = StopReason::stagnated;
  }

  /// Lanes that ended just now.
  void judge_ended() {
    if constexpr (!std::is_same_v<T, double>) {
      if (std::none_of(lanes_.begin(), lanes_.end(),
                       [](const Lane& lane) { return lane.unjudged; }))
        return;
      kernel_.measure_exactly(exact_tables_, exact_);
      for (std::size_t k = 0; k < N; ++k) {
        Lane& lane = lanes_[k];
        if (!lane.unjudged) continue;
        lane.unjudged = false;
        judge(lane, exact_.relative[k], exact_.nanometers[k]);
      }
    }
  }

  /// Unbroken positions are not those that floats round them to, nor are fixed joints.
  void look_again(Lane& lane, std::span<const Vec3> positions) {
    const auto [residual, residual_nm] = plan_.measure(positions);
    if (has_extras_) {
      if (ruled_) lane.contacts->look_up(positions, lane.box);
      lane.looked_up = false;
      lane.contacts->measure(
          [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; }, lane.box);
    }
    judge(lane, residual, residual_nm);
  }

  /// What `measure_` knows of a lane, pairs beside the pattern included.
  struct Found {
    double energy = 0, residual = 0, residual_nm = 0;
  };

  Found found(std::size_t k) const {
    return {double(measure_.energy[k]), double(measure_.relative[k]),
            double(measure_.nanometers[k])};
  }

  /// Finds the violated pairs beside the pattern, where a lane's rows were measured and
  /// find_moves() looked.
  void add_contacts(const Field<T>& at, std::size_t k) {
    // positions that are no numbers cannot be sorted into cells
    if (!has_extras_ || !std::isfinite(measure_.energy[k])) return;
    Lane& lane = lanes_[k];
    // since pairs were looked up, their joints may have moved further than they had room to
    constexpr double room = NewtonContacts::room * (1 - 1e-5);  // but for rounding
    if (ruled_ && (!lane.looked_up || !(double(furthest2_[k]) < room * room))) look_up(at, k);
    lane.contacts->measure(
        [&](int joint) { return point_of(at, k, plan_.slot[std::size_t(joint)]); }, lane.box);
    measure_.energy[k] += T(lane.contacts->energy());
    measure_.relative[k] = std::max(measure_.relative[k], T(lane.contacts->residual()));
    measure_.nanometers[k] = std::max(measure_.nanometers[k], T(lane.contacts->residual_nm()));
  }

  /// How far joints have moved since contacts were looked up.
  void find_moves(const Field<T>& at) {
    if (ruled_) kernel_.furthest(at, looked_up_at_, furthest2_);
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

  /// Of flat groups that may be either of two mirror images, the one that is nearer.
  void settle_mirrors(std::size_t k) {
    if (plan_.mirrors == 0) return;
    likeness_.assign(std::size_t(plan_.mirrors), 0.0);
    const auto at = [&](int slot) {
      const T* x = kernel_.x + std::size_t(slot) * Kernel::kJoint + k;
      return Vec3(double(x[0]), double(x[N]), double(x[2 * N]));
    };
    for (const NewtonPlan::Corners& v : plan_.volumes) {
      if (v.mirror < 0) continue;
      const double size = signed_volume(at(v.slot[0]), at(v.slot[1]), at(v.slot[2]), at(v.slot[3]));
      likeness_[std::size_t(v.mirror)] += v.aim / v.scale * (size / v.scale);
    }
    for (std::size_t g = 0; g < likeness_.size(); ++g)
      kernel_.mirror[g * N + k] = likeness_[g] < 0 ? T(-1) : T(1);
  }

  static void keep(const Found& found, Lane& lane) {
    lane.end.energy = found.energy;
    lane.end.residual = found.residual;
    lane.end.residual_nm = found.residual_nm;
  }

  /// The largest, as the tolerance measures it.
  template <class Violations>
  double violation(const Violations& of) const {
    return settings_.tolerance.absolute() ? of.residual_nm : of.residual;
  }
  template <class Violations>
  bool within(const Violations& of) const {
    return violation(of) <= limit_;
  }

  bool all_move() const { return plan_.moving == plan_.joints; }

  void finish(Lane& lane, StopReason reason) const {
    lane.end.reason = reason;
    lane.stage = Stage::ended;
    lane.unjudged = reason == StopReason::within_tolerance && all_move();
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
      if (lanes_[k].stage == Stage::fresh) {
        settle_manner(k);
        settle_mirrors(k);
      }
    kernel_.evaluate(kernel_.x, manner_, measure_);
    bool again = false;
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      if (lane.stage != Stage::fresh) continue;
      add_contacts(kernel_.x, k);
      keep(found(k), lane);
      const std::int64_t sweeps = std::min(first_sweeps, lane.max_iterations);
      std::int64_t needed = sweeps;
      while (needed > 0 && changed[needed - 1][k] == 0) --needed;
      if (!std::isfinite(lane.end.energy)) {
        finish(lane, StopReason::not_finite);
      } else if (within(lane.end)) {
        lane.end.iterations = needed;
        finish(lane, needed == 0 ? StopReason::nothing_broken : StopReason::within_tolerance);
      } else {
        lane.end.iterations = sweeps;
        lane.stage = Stage::descending;
        lane.mu = first_mu;
        lane.accuracy = first_accuracy;
        lane.marked_energy = lane.end.energy;
        lane.since_mark = 0;
        lane.held_back = false;
        lane.turning = lane.end.residual > far;
        if (!lane.turning) continue;
        settle_manner(k);
        again = true;
      }
    }
    if (again) kernel_.evaluate(kernel_.x, manner_, measure_);
    judge_ended();
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
    solve(mu, predicted, positive);
    bool near = false;
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      if (lane.stage != Stage::descending) continue;
      settle_manner(k);
      lane.near = kCorrects && !plan_.is_bulky && violation(lane.end) <= near_by * limit_;
      near = near || lane.near;
    }
    if (near) {
      kernel_.template evaluate<false>(kernel_.trial, manner_, measure_);
    } else {
      kernel_.evaluate(kernel_.trial, manner_, measure_);
    }
    find_moves(kernel_.trial);
    std::array<Found, N> tried;
    for (std::size_t k = 0; k < N; ++k) {
      if (lanes_[k].stage != Stage::descending) continue;
      add_contacts(kernel_.trial, k);
      tried[k] = found(k);
    }
    if (near) correct(positive, tried);

    bool again = near;
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      mask[k] = 0;
      if (lane.stage != Stage::descending) continue;
      const double energy = tried[k].energy;
      // nowhere to go: no gradient worth the name
      if (positive[k] != 0 && !(double(predicted[k]) > 1e-13 * lane.end.energy)) {
        lane.measured = false;
        give_up(lane);
        again = true;
      } else if (positive[k] != 0 && std::isfinite(energy) && energy < lane.end.energy) {
        mask[k] = 1;
        const double gain = (lane.end.energy - energy) / double(predicted[k]);
        lane.accuracy = std::clamp(energy / lane.end.energy, best_accuracy, first_accuracy);
        keep(tried[k], lane);
        if (within(lane.end)) {
          finish(lane, StopReason::within_tolerance);
        } else {
          adapt(lane, true, gain);
        }
      } else {
        lane.measured = false;
        adapt(lane, false, 0);
      }
      again = again || !lane.measured || lane.changed;
    }
    kernel_.accept(mask);
    judge_ended();
    if (again && any(Stage::descending)) prepare();
  }

  void solve(const T* mu, T* predicted, T* positive) {
    if constexpr (Kernel::kMakesGradients)
      if (plan_.is_bulky) kernel_.gradients().accuracy = lanes_[0].accuracy;
    kernel_.solve(mu, predicted, positive);
    if constexpr (Kernel::kMakesGradients)
      if (plan_.is_bulky) lanes_[0].end.passes += kernel_.gradients().passes();
  }

  /// Rows and gradients for the next step.
  void prepare() {
    for (std::size_t k = 0; k < N; ++k)
      if (!lanes_[k].measured || lanes_[k].changed) settle_manner(k);
    kernel_.evaluate(kernel_.x, manner_, measure_);
    find_moves(kernel_.x);
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      if (lane.stage != Stage::descending || (lane.measured && !lane.changed)) continue;
      add_contacts(kernel_.x, k);
      lane.measured = true;
      if (!lane.changed) continue;
      lane.changed = false;
      keep(found(k), lane);
      lane.marked_energy = lane.end.energy;
      lane.since_mark = 0;
    }
  }

  /// What a step leaves is of second order: as long as that shrinks quickly, the same factor takes
  /// it away too, for a part of what a new one costs. The gradients have to be the same as well:
  /// along what they leave free, the factor gives way to anything else.
  void correct(const T* positive, std::array<Found, N>& tried) {
    std::array<double, N> before;
    for (std::size_t k = 0; k < N; ++k) before[k] = lanes_[k].end.energy;
    HWY_ALIGN T mask[N];
    std::array<bool, N> wanted;
    for (std::size_t k = 0; k < N; ++k)
      wanted[k] = lanes_[k].stage == Stage::descending && lanes_[k].near && positive[k] != 0;
    for (int round = 0; round < most_corrections; ++round) {
      bool any = false;
      for (std::size_t k = 0; k < N; ++k) {
        wanted[k] = wanted[k] && tried[k].energy < quick * before[k] && !within(tried[k]) &&
                    violation(tried[k]) <= at_hand * limit_;
        any = any || wanted[k];
      }
      if (!any) return;
      pull_contacts(wanted);
      kernel_.correct();
      kernel_.template evaluate<false>(kernel_.corrected, manner_, measure_);
      find_moves(kernel_.corrected);
      for (std::size_t k = 0; k < N; ++k) {
        mask[k] = 0;
        if (!wanted[k]) continue;
        add_contacts(kernel_.corrected, k);
        const Found now = found(k);
        if (now.energy < tried[k].energy) {
          mask[k] = 1;
          before[k] = tried[k].energy;
          tried[k] = now;
        } else {
          wanted[k] = false;
          lanes_[k].measured = false;
        }
      }
      kernel_.keep_correction(mask);
    }
  }

  /// Pairs of the contact rule come and go, which must not change the pattern, and tethers far
  /// across would fill it: instead of coupling the ends, each end is held more stiffly. Twice as
  /// stiffly bounds the coupled matrix from above, and brings two ends that nothing else holds just
  /// to their bound; where others pull at them, a little beyond it makes steps fewer.
  void enter_contacts() {
    if (!has_extras_) return;
    if constexpr (Kernel::kMakesGradients)
      if (plan_.is_bulky) return couple_contacts();
    kernel_.entry().clear_extras();
    for (std::size_t k = 0; k < N; ++k) {
      Lane& lane = lanes_[k];
      if (lane.stage != Stage::descending) continue;
      lane.entered = lane.contacts->active();
      for (const NewtonContacts::Active& pair : lane.entered) {
        const int p = plan_.slot[std::size_t(pair.p)], q = plan_.slot[std::size_t(pair.q)];
        const T u[3] = {T(pair.u[0]), T(pair.u[1]), T(pair.u[2])};
        const bool both = p < plan_.moving && q < plan_.moving;
        const T stiffness = !both ? T(1) : is_loose(p) && is_loose(q) ? T(2) : T(1.25);
        if (p < plan_.moving) kernel_.entry().add_extra(p, k, u, stiffness, T(pair.row));
        if (q < plan_.moving) kernel_.entry().add_extra(q, k, u, stiffness, T(-pair.row));
      }
    }
  }

  /// A joint that no row of the pattern holds.
  bool is_loose(int slot) const {
    const std::size_t s = std::size_t(slot);
    return plan_.end_begin[s] == plan_.end_begin[s + 1] &&
           plan_.corner_begin[s] == plan_.corner_begin[s + 1];
  }

  /// Where there is no pattern, they are rows like others.
  void couple_contacts() {
    auto& rows = kernel_.gradients().contacts;
    rows.clear();
    for (const NewtonContacts::Active& pair : lanes_[0].contacts->active())
      rows.push_back({plan_.slot[std::size_t(pair.p)],
                      plan_.slot[std::size_t(pair.q)],
                      {pair.u[0], pair.u[1], pair.u[2]},
                      pair.row});
  }

  /// The rows that those which were entered have at the trial.
  void pull_contacts(const std::array<bool, N>& wanted) {
    if (!has_extras_) return;
    kernel_.entry().clear_pulls();
    for (std::size_t k = 0; k < N; ++k) {
      if (!wanted[k]) continue;
      const auto at = [&](int slot) {
        const T* x = kernel_.trial + std::size_t(slot) * Kernel::kJoint + k;
        return Vec3(double(x[0]), double(x[N]), double(x[2 * N]));
      };
      for (const NewtonContacts::Active& pair : lanes_[k].entered) {
        const int p = plan_.slot[std::size_t(pair.p)], q = plan_.slot[std::size_t(pair.q)];
        Vec3 d = at(q) - at(p);
        if (pair.of_rule && lanes_[k].box) d = lanes_[k].box->minimum_image(d);
        // as when it was entered, or nothing
        const double error = d.norm() - pair.bound, row = error * pair.row > 0 ? error : 0;
        const T u[3] = {T(pair.u[0]), T(pair.u[1]), T(pair.u[2])};
        if (p < plan_.moving) kernel_.entry().add_pull(p, k, u, T(row));
        if (q < plan_.moving) kernel_.entry().add_pull(q, k, u, T(-row));
      }
    }
  }

  /// Whether pairs beside the pattern are violated.
  bool beside(const Lane& lane) const { return has_extras_ && !lane.contacts->active().empty(); }

  /// A step that leads nowhere: once more without pulling at volumes, which bars that cannot all
  /// be met may be at odds with.
  void give_up(Lane& lane) const {
    if (!lane.pulled) return finish(lane, StopReason::stagnated);
    lane.pulled = false;
    lane.turning = true;
    lane.held_back = false;
    lane.changed = true;
    lane.mu = first_mu;
  }

  void adapt(Lane& lane, bool accepted, double gain) const {
    const double floor = plan_.is_bulky              ? smallest_bulky_mu
                         : beside(lane)              ? smallest_mu_beside
                         : std::is_same_v<T, double> ? smallest_mu
                                                     : smallest_float_mu;
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
  NewtonTables<double> exact_tables_;  ///< to judge what floats find
  bool ruled_;                         ///< there is a contact rule
  bool has_extras_;                    ///< there may be rows beside the pattern
  Kernel kernel_;
  double limit_ = 0;
  std::array<Lane, N> lanes_;
  Measure measure_;
  typename Kernel::Exact exact_;
  typename Kernel::Manner manner_;
  Field<T> looked_up_at_;        ///< positions, as the kernel holds them
  HWY_ALIGN T furthest2_[N];     ///< what find_moves() found, squared
  std::vector<Vec3> positions_;  ///< scratch
  std::vector<double> likeness_;
};

std::unique_ptr<NewtonEngine> make_engine(std::shared_ptr<const NewtonTask> task,
                                          Precision precision, bool single) {
  if (task->plan.is_bulky) return std::make_unique<Engine<double, true>>(std::move(task));
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
                       const ResolverSettings& settings_in, std::optional<double> most_products,
                       bool whole)
    : framework(std::move(framework_in)),
      settings(settings_in),
      plan(*framework, most_products.value_or(NewtonPlan::most_products(framework->joint_count())),
           whole) {}

std::unique_ptr<NewtonEngine> make_newton_engine(std::shared_ptr<const NewtonTask> task,
                                                 Precision precision, bool single) {
  return HWY_DYNAMIC_DISPATCH(make_engine)(std::move(task), precision, single);
}

std::string newton_instructions() {
  return HWY_DYNAMIC_DISPATCH(instructions)();
}

}  // namespace ragdoll
#endif
