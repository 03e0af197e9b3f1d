#include "ragdoll/walkers.h"

#include <algorithm>  // clamp, max, min
#include <cmath>      // isfinite
#include <limits>     // numeric_limits
#include <thread>
#include <utility>  // move, swap

#include "ragdoll/ensemble_resolver.h"  // EnsembleResolver
#include "ragdoll/error.h"              // Error
#include "ragdoll/random.h"             // Random
#include "walk_board.h"                 // WalkBoard, Walker

namespace ragdoll {
namespace {

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
      end_step(lane, *walker);
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
    const WalkSettings& settings = plan_.settings;
    const std::uint64_t step = std::uint64_t(walker.report.steps);
    walker.trial = walker.good;
    Random random(walker.report.seed, RandomStream::perturbation, step);
    perturb(walker.trial, plan_.framework->fixed(), settings.perturbation, settings.size, random);
    resolver_->load(lane, walker.trial, {.step = step, .box = plan_.box});
  }

  void end_step(int lane, Walker& walker) {
    WalkerReport& done = walker.report;
    ResolveReport resolved = resolver_->unload(lane, walker.trial);
    ++done.steps;
    done.iterations.push_back(resolved.iterations);
    const int inverted = resolved.converged ? inverted_centres(*plan_.framework, walker.trial) : 0;
    if (!resolved.converged || inverted > 0) {
      ++done.rejected_steps;
      done.last_rejection = inverted > 0 ? std::to_string(inverted) + " inverted centre(s)"
                                         : name_of(resolved.reason) + ": " + resolved.worst;
      return;
    }
    std::swap(walker.good, walker.trial);
    if (++walker.accepted % plan_.settings.stride == 0)
      board_.add({walker.number, done.frames++, done.steps, std::move(resolved), walker.good});
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
  if (!(settings.size >= 0) || !std::isfinite(settings.size))
    throw Error("the size of the perturbation must be 0 nm or more");
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
  std::vector<Walker> walkers(std::size_t(settings.walkers));
  for (int k = 0; k < settings.walkers; ++k) {
    Walker& walker = walkers[std::size_t(k)];
    walker.number = k;
    walker.good.assign(start.begin(), start.end());
    walker.report.seed = plan.seed_of(k);
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
  for (Walker& walker : board.walkers()) report.walkers.push_back(std::move(walker.report));
  return report;
}

}  // namespace ragdoll
