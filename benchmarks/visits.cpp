// Visits: nanoseconds of a bar visit, `ordered` beside the plain loop, at the same order and at
// random.

#include <functional>

#include "clock.h"  // Clock
#include "commands.h"
#include "contender.h"   // Contender
#include "plain_loop.h"  // PlainLoop
#include "record.h"      // Record

namespace benchmark {
namespace {

constexpr double tolerance = 0.01;
constexpr double bar_length = 0.15;  // nm
constexpr int joints = 2000;

/// Each joint gets a bar to its parent, one bar length away in a random direction.
Network grown(const char* name, const std::function<int(int)>& parent) {
  ragdoll::Random random(1, ragdoll::RandomStream::generate, 0);
  Positions x = {ragdoll::Vec3::Zero()};
  std::vector<ragdoll::Bar> bars;
  for (int j = 1; j < joints; ++j) {
    const ragdoll::Vec3 direction(random.gaussian(), random.gaussian(), random.gaussian());
    const int p = parent(j);
    x.push_back(x[std::size_t(p)] + bar_length * direction.normalized());
    bars.push_back({p, j, (x.back() - x[std::size_t(p)]).norm()});
  }
  return network_of_bars(name, std::move(x), std::move(bars));
}

ragdoll::Order breadth_first(const ragdoll::Framework& framework) {
  const int root = ragdoll::MiddleJoint(framework.graph()).of(0);
  ragdoll::Random unused(0, ragdoll::RandomStream::order, 0);
  return order_of(framework.graph(), ragdoll::OrderKind::bfs_cycle, {&root, 1}, unused);
}

/// Best seconds of each break, and the visits of all.
struct Loop {
  std::string name;
  std::function<std::int64_t(const Positions&, double&)> resolve;  // returns visits
  double seconds = 0;
  std::int64_t visits = 0;
};

void measure(const Network& network, int repetitions) {
  const std::vector<Positions> breaks = breaks_of(network, 0.07 * bar_length, 4);
  const auto bars = std::int64_t(network.framework->bars().size());
  const Clock clock;
  const auto plain_loop = [&](const char* name, bool in_order) {
    auto loop =
        std::make_shared<PlainLoop>(*network.framework, tolerance, 100000, Corrects::broken_bars,
                                    in_order ? Shuffles::once : Shuffles::each_iteration);
    if (in_order) loop->set_order(breadth_first(*network.framework));
    return Loop{name, [&clock, bars, loop](const Positions& start, double& seconds) {
                  loop->load(start);
                  seconds = clock.time([&] { loop->resolve(); });
                  return (loop->iterations() + 1) * bars;
                }};
  };
  const auto ordered = [&](const char* name, ragdoll::OrderKind order) {
    ragdoll::ResolverSettings settings;
    settings.solver = "ordered";
    settings.order = order;
    settings.tolerance = tolerance;
    std::shared_ptr<ragdoll::Resolver> resolver = make_resolver(network.framework, settings);
    return Loop{name, [&clock, resolver](const Positions& start, double& seconds) {
                  Positions x = start;
                  std::int64_t visits = 0;
                  seconds = clock.time([&] { visits = resolver->resolve(x, {}).bar_visits; });
                  return visits;
                }};
  };
  std::vector<Loop> loops = {ordered("ordered_bfs_cycle", ragdoll::OrderKind::bfs_cycle),
                             ordered("ordered_random", ragdoll::OrderKind::random),
                             plain_loop("plain_bfs_cycle", true),
                             plain_loop("plain_random", false)};
  for (const Positions& start : breaks)
    for (Loop& loop : loops) loop.visits += loop.resolve(start, loop.seconds), loop.seconds = 0;
  // in turn, so that a busy machine slows all of them
  std::vector<std::vector<double>> best(loops.size(), std::vector<double>(breaks.size(), 1));
  for (int repetition = 0; repetition < repetitions; ++repetition)
    for (std::size_t k = 0; k < loops.size(); ++k)
      for (std::size_t b = 0; b < breaks.size(); ++b) {
        double seconds = 0;
        loops[k].resolve(breaks[b], seconds);
        best[k][b] = std::min(best[k][b], seconds);
      }
  for (std::size_t k = 0; k < loops.size(); ++k) {
    double seconds = 0;
    for (const double one : best[k]) seconds += one;
    Record("visits")
        .text("network", network.name)
        .count("bars", bars)
        .text("contender", loops[k].name)
        .number("ns_per_visit", 1e9 * seconds / double(loops[k].visits))
        .number("ms", 1e3 * seconds / double(breaks.size()))
        .print();
  }
}

}  // namespace

void measure_visits(const Words& words) {
  const int repetitions = std::stoi(words.at(0));
  ragdoll::Random random(2, ragdoll::RandomStream::generate, 0);
  measure(grown("tree", [&](int j) { return int(random.below(std::uint64_t(j))); }), repetitions);
  measure(grown("chain", [](int j) { return j - 1; }), repetitions);
}

}  // namespace benchmark
