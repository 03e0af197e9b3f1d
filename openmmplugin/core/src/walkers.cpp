#include "ragdoll/walkers.h"

#include <algorithm>  // clamp, max, min
#include <limits>     // numeric_limits
#include <thread>
#include <utility>  // move, swap

#include "ragdoll/ensemble_resolver.h"  // EnsembleResolver
#include "ragdoll/error.h"              // Error
#include "ragdoll/random.h"             // Random
#include "walk_board.h"                 // WalkBoard, Walker

namespace ragdoll {
namespace {

/// Resolutions of one step at most until it is symmetric.
constexpr int most_rounds = 12;

Tolerance half(const Tolerance& tolerance) {
  const double value = tolerance.value() / 2;
  return tolerance.absolute() ? Tolerance::nanometers(value) : Tolerance(value);
}

/// What is the same for all threads.
struct Plan {
  std::shared_ptr<const Framework> framework;
  const WalkSettings& settings;
  const Box* box;
  std::int64_t most;  ///< steps of a walker
  bool own_seeds;     ///< the resolver draws random numbers, so that walkers cannot share one
  int lanes;          ///< of each ensemble

  std::uint64_t seed_of(int walker) const { return settings.resolver.seed + std::uint64_t(walker); }
  std::unique_ptr<EnsembleResolver> make_resolver_of(int walker) const {
    ResolverSettings own = settings.resolver;
    own.seed = seed_of(walker);
    if (settings.symmetry) own.tolerance = half(own.tolerance);
    return make_ensemble_resolver(framework, own, lanes);
  }
};

/// One thread: the lanes of an ensemble, each with a walker or free. A lane whose step has ended
/// takes the walker's next step at once.
class Crew {
 public:
  Crew(const Plan& plan, WalkBoard& board, std::unique_ptr<EnsembleResolver> resolver)
      : plan_(plan), board_(board), shared_(std::move(resolver)), resolver_(shared_.get()) {
    in_lane_.resize(std::size_t(resolver_->lanes()));
    news_ = board_.news() - 1;
  }

  void work() {
    while (!board_.stopped()) {
      const unsigned news = board_.news();
      bool busy = false;
      for (int lane = 0; lane < int(in_lane_.size()); ++lane) busy |= attend(lane, news != news_);
      news_ = news;
      if (busy)
        resolver_->iterate();
      else if (!board_.wait_for_news(news))
        return;
    }
  }

 private:
  /// Ends the step of a lane that is done and begins the next; whether the lane is loaded.
  bool attend(int lane, bool ask) {
    Walker*& walker = in_lane_[std::size_t(lane)];
    if (walker) {
      if (!resolver_->done(lane)) return true;
      const std::int64_t before = walker->report.frames;
      if (!end_step(lane, *walker)) return true;
      const WalkerReport& done = walker->report;
      if (done.frames == plan_.settings.frames || done.steps == plan_.most) {
        board_.end(*walker);
        walker = board_.next(nullptr);
      } else if (done.frames > before) {
        walker = board_.next(walker);
      }
    } else if (ask) {
      walker = board_.next(nullptr);
    }
    if (walker) begin_step(lane, *walker);
    return walker != nullptr;
  }

  void begin_step(int lane, Walker& walker) {
    if (plan_.own_seeds) {
      if (!walker.own) walker.own = plan_.make_resolver_of(walker.number);
      resolver_ = walker.own.get();
    }
    Random random(walker.report.seed, RandomStream::perturbation, step_of(walker));
    walker.trial = walker.good;
    walker.motion->move(walker.trial, random);
    if (plan_.settings.symmetry) plan_.settings.symmetry->carry(walker.trial);
    walker.rounds = 0;
    load(lane, walker);
  }

  void load(int lane, Walker& walker) {
    resolver_->load(lane, walker.trial, {.step = step_of(walker), .box = plan_.box});
  }

  static std::uint64_t step_of(const Walker& walker) {
    return std::uint64_t(walker.first_step + walker.report.steps);
  }

  /// Whether the step has ended; false: it has to be resolved once more.
  bool end_step(int lane, Walker& walker) {
    WalkerReport& done = walker.report;
    ResolveReport resolved = resolver_->unload(lane, walker.trial);
    if (plan_.settings.symmetry && resolved.converged && !make_symmetric(walker, resolved)) {
      load(lane, walker);
      return false;
    }
    ++done.steps;
    done.iterations.push_back(resolved.iterations);
    const int inverted = resolved.converged ? inverted_centres(*plan_.framework, walker.trial) : 0;
    if (!resolved.converged || inverted > 0) {
      ++done.rejected_steps;
      done.last_rejection = inverted > 0 ? std::to_string(inverted) + " inverted centre(s)"
                                         : name_of(resolved.reason) + ": " + resolved.worst;
      walker.motion->taken_back();
      return true;
    }
    walker.motion->kept(walker.good, walker.trial);
    std::swap(walker.good, walker.trial);
    if (++walker.accepted % plan_.settings.stride != 0) return true;
    if (plan_.settings.judge) {
      if (QualityFault fault = plan_.settings.judge->fault(walker.good, plan_.box)) {
        ++done.low_frames[fault.measure];
        done.last_fault = std::move(fault.words);
        return true;
      }
    }
    board_.add({walker.number, done.frames++, walker.first_step + done.steps, std::move(resolved),
                walker.good});
    return true;
  }

  /// Copies alike, and the constraints measured then; false where resolving once more may help.
  bool make_symmetric(Walker& walker, ResolveReport& resolved) const {
    plan_.settings.symmetry->average(walker.trial);
    const Tolerance& tolerance = plan_.settings.resolver.tolerance;
    const Violation worst = worst_violation(*plan_.framework, walker.trial, plan_.box, tolerance);
    resolved.residual = worst.relative;
    resolved.residual_nm = worst.nanometers;
    if ((tolerance.absolute() ? worst.nanometers : worst.relative) <= tolerance.value())
      return true;
    if (++walker.rounds < most_rounds) return false;
    resolved.converged = false;
    resolved.reason = StopReason::max_iterations;
    resolved.worst = worst.what;
    return true;
  }

  const Plan& plan_;
  WalkBoard& board_;
  std::unique_ptr<EnsembleResolver> shared_;
  EnsembleResolver* resolver_;    ///< the shared one, or the walker's own
  std::vector<Walker*> in_lane_;  ///< (nlane); null: free
  unsigned news_;                 ///< when free lanes asked for walkers last
};

/// Threads that end when this does.
class Threads {
 public:
  explicit Threads(WalkBoard& board) : board_(board) {}
  ~Threads() {
    board_.stop();
    for (std::thread& thread : threads_) thread.join();
  }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  template <class Work>
  void start(Work work) {
    threads_.emplace_back([this, work = std::move(work)] {
      try {
        work();
      } catch (...) {
        board_.fail(std::current_exception());
      }
    });
  }

 private:
  WalkBoard& board_;
  std::vector<std::thread> threads_;
};

void check(const Framework& framework, std::span<const Vec3> start, const WalkSettings& settings) {
  if (int(start.size()) != framework.joint_count())
    throw Error("there are " + std::to_string(start.size()) + " positions for " +
                std::to_string(framework.joint_count()) + " joints");
  if (settings.walkers < 1) throw Error("the number of walkers must be 1 or more");
  if (settings.frames < 1 || settings.stride < 1 || settings.attempts < 1)
    throw Error("frames, stride and attempts of a walk must be 1 or more");
  if (settings.threads < 0) throw Error("the number of threads must be 0 or more");
  if (!settings.states.empty() && int(settings.states.size()) != settings.walkers)
    throw Error("there are " + std::to_string(settings.states.size()) + " states for " +
                std::to_string(settings.walkers) + " walkers");
  for (const WalkerState& state : settings.states)
    if (state.positions.size() != start.size() || state.steps < 0 || state.accepted < 0)
      throw Error("the state of a walker does not belong to this framework");
}

/// As an integrator sees it: massless joints are fixed.
std::shared_ptr<const Framework> with_massless_fixed(std::shared_ptr<const Framework> framework) {
  FrameworkParts parts = framework->parts();
  for (std::size_t j = 0; j < parts.masses.size(); ++j)
    if (parts.masses[j] == 0) parts.fixed[j] = 1;
  if (parts.fixed == framework->fixed()) return framework;
  return std::make_shared<const Framework>(std::move(parts));
}

/// attempts * frames * stride, or as many as can be counted.
std::int64_t most_steps(const WalkSettings& settings) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  if (settings.frames > most / settings.attempts / settings.stride) return most;
  return settings.attempts * settings.frames * settings.stride;
}

bool draws_random_numbers(const ResolverSettings& settings) {
  return settings.custom_order.empty() &&
         (settings.order == OrderKind::random || settings.order == OrderKind::bfs_random);
}

/// So many conformers are resolved sooner one by one than in vectors that are nearly empty.
/// Measured on proteins: a step of one lane costs as much as 1.7 single ones of `ordered`, and 3 to
/// 4 of `newton`.
int too_few_for_lanes(const std::string& solver) {
  return solver == "newton" ? 3 : 1;
}

std::int64_t frames_ahead(const WalkSettings& settings, std::size_t joints) {
  const std::size_t round = std::size_t(settings.walkers) * joints * sizeof(Vec3);
  return std::clamp<std::int64_t>(std::int64_t(settings.waiting_bytes / round), 1,
                                  std::max<std::int64_t>(1, settings.frames_ahead));
}

}  // namespace

WalkReport walk(std::shared_ptr<const Framework> framework, std::span<const Vec3> start,
                const WalkSettings& settings, const Box* box,
                const std::function<void(const WalkFrame&)>& take,
                const std::function<bool()>& keep_going) {
  check(*framework, start, settings);
  const bool own_seeds = draws_random_numbers(settings.resolver);
  Plan plan{with_massless_fixed(std::move(framework)),
            settings,
            box,
            most_steps(settings),
            own_seeds,
            own_seeds ? 1 : settings.lanes};
  const MotionFactory make_motion = motion_factory(plan.framework, start, settings.motion);
  std::vector<Walker> walkers(std::size_t(settings.walkers));
  for (int k = 0; k < settings.walkers; ++k) {
    Walker& walker = walkers[std::size_t(k)];
    walker.number = k;
    walker.good.assign(start.begin(), start.end());
    walker.report.seed = plan.seed_of(k);
    walker.motion = make_motion(walker.report.seed);
    if (settings.states.empty()) continue;
    const WalkerState& state = settings.states[std::size_t(k)];
    walker.good = state.positions;
    walker.first_step = state.steps;
    walker.accepted = state.accepted;
    walker.motion->restore(state.motion);
  }

  // as many threads as there are lanes full of walkers
  std::unique_ptr<EnsembleResolver> resolver = plan.make_resolver_of(0);
  if (plan.lanes == 0 && settings.walkers <= too_few_for_lanes(resolver->solver())) {
    plan.lanes = 1;
    resolver = plan.make_resolver_of(0);
  }
  WalkReport report;
  report.solver = resolver->solver();
  report.instructions = resolver->instructions();
  report.lanes = resolver->lanes();
  const int cores = std::max(1, int(std::thread::hardware_concurrency()));
  report.threads = std::min(settings.threads > 0 ? settings.threads : cores,
                            (settings.walkers + report.lanes - 1) / report.lanes);

  WalkBoard board(std::move(walkers), settings.frames, frames_ahead(settings, start.size()));
  {
    Threads threads(board);
    for (int k = 0; k < report.threads; ++k) {
      if (!resolver) resolver = plan.make_resolver_of(0);
      threads.start(
          [crew = std::make_shared<Crew>(plan, board, std::move(resolver))] { crew->work(); });
    }
    while (!board.done() && !board.error()) {
      if (const std::optional<WalkFrame> frame = board.take()) take(*frame);
      if (keep_going && !keep_going()) {
        report.interrupted = true;
        break;
      }
    }
  }
  if (board.error()) std::rethrow_exception(board.error());
  while (const std::optional<WalkFrame> frame = board.take_left()) take(*frame);
  for (Walker& walker : board.walkers()) {
    WalkerReport& done = report.walkers.emplace_back(std::move(walker.report));
    done.state = {std::move(walker.good), walker.first_step + done.steps, walker.accepted,
                  walker.motion->state()};
  }
  return report;
}

}  // namespace ragdoll
