// Cycles: the thesis' classes. One forced joint after the other: how many iterations `block` needs,
// and what 1- and 2-cycles cost beside R.

#include <algorithm>  // max, min, sort
#include <cmath>      // isfinite
#include <limits>     // infinity
#include <tuple>

#include "clock.h"  // Clock
#include "commands.h"
#include "network.h"            // worst_excess
#include "plain_loop.h"         // PlainLoop
#include "ragdoll/force_run.h"  // framework_of
#include "ragdoll/generate.h"   // generate_structure
#include "ragdoll/resolver.h"   // make_resolver
#include "record.h"             // Record

namespace benchmark {
namespace {

using ragdoll::Random;
using ragdoll::Vec3;

constexpr std::int64_t most_iterations = 10000;

Network network_of_class(const std::string& class_name, std::uint64_t index) {
  Random random(5, ragdoll::RandomStream::generate, index);
  ragdoll::StructureRequest request;
  request.class_name = class_name;
  request.joints = 10 + int(random.below(41));
  request.seed = 5;
  request.index = index;
  const ragdoll::Structure structure = generate_structure(request);
  return {class_name, framework_of(structure), structure.positions};
}

double mean_length(const ragdoll::Framework& framework) {
  double mean = 0;
  for (const ragdoll::Bar& bar : framework.bars())
    mean += bar.length / double(framework.bars().size());
  return mean;
}

/// Which joint moves where to.
struct Push {
  int joint;
  Vec3 by;
};

Push random_push(Random& random, int joints, double lo, double hi) {
  const int joint = int(random.below(std::uint64_t(joints)));
  const Vec3 direction(random.gaussian(), random.gaussian(), random.gaussian());
  return {joint, (lo + (hi - lo) * random.uniform()) * direction.normalized()};
}

std::unique_ptr<ragdoll::Resolver> block_resolver(const Network& network, double tolerance) {
  ragdoll::ResolverSettings settings;
  settings.solver = "block";
  settings.tolerance = tolerance;
  settings.max_iterations = most_iterations;
  return make_resolver(network.framework, settings);
}

// === Iterations

struct Tally {
  std::int64_t forces = 0, failed = 0, wrong = 0, iterations = 0, visits = 0, bars = 0;
};

/// Each force acts on what the one before it left; after a failure the structure is at rest again.
void push_around(const Network& network, double tolerance, int forces, Random& random,
                 Tally& tally) {
  const std::unique_ptr<ragdoll::Resolver> resolver = block_resolver(network, tolerance);
  const double unit = mean_length(*network.framework);
  Positions x = network.positions;
  bool resolved = true;
  for (int k = 0; k < forces; ++k) {
    const Push push = random_push(random, int(x.size()), 0.1 * unit, 20 * unit);
    x[std::size_t(push.joint)] += push.by;
    const ragdoll::Breakage breakage = {
        .roots = {&push.joint, 1}, .step = std::uint64_t(k), .only_roots_moved = resolved};
    const ragdoll::ResolveReport report = resolver->resolve(x, breakage);
    ++tally.forces;
    tally.iterations = std::max(tally.iterations, report.iterations);
    tally.visits += report.bar_visits;
    tally.bars += std::int64_t(network.framework->bars().size());
    // the tolerance is relative to lengths, and coordinates may be far larger than those
    if (report.converged && worst_excess(*network.framework, x, tolerance) > 1 + 1e-6)
      ++tally.wrong;
    resolved = report.converged;
    if (!resolved) {
      ++tally.failed;
      x = network.positions;
      resolved = false;
    }
  }
}

void measure_iterations(int forces) {
  constexpr int forces_each = 100;  // on a structure
  for (const char* class_name : {"tree", "1-cycle", "2-cycle", "n-cycle"})
    for (const double tolerance : {1e-2, 1e-3, 1e-6}) {
      Tally tally;
      Random random(6, ragdoll::RandomStream::perturbation, 0);
      const int structures = std::max(1, forces / 12 / forces_each);
      for (int k = 0; k < structures; ++k)
        push_around(network_of_class(class_name, std::uint64_t(k)), tolerance, forces_each, random,
                    tally);
      Record("block_iterations")
          .text("class", class_name)
          .number("tolerance", tolerance)
          .count("forces", tally.forces)
          .count("most_iterations", tally.iterations)
          .count("failed", tally.failed)
          .count("wrong", tally.wrong)
          .number("visits_per_bar", double(tally.visits) / double(tally.bars))
          .print();
    }
}

// === Times

/// Best seconds of each force.
struct Times {
  std::vector<double> ours, plain, lean, once;
};

void keep_best(double& best, double seconds) {
  best = std::min(best, seconds);
}

/// Ours goes from force to force, as a run does; R gets the same breaks, also one after the other,
/// so that each has its own code and data at hand. Nothing is remembered between repetitions but
/// the best times.
void race(const Network& network, int forces, std::uint64_t index, std::size_t first,
          Times& times) {
  constexpr double tolerance = 1e-6;
  const Clock clock;
  const std::unique_ptr<ragdoll::Resolver> resolver = block_resolver(network, tolerance);
  const double unit = mean_length(*network.framework);
  Random random(8, ragdoll::RandomStream::perturbation, index);
  Positions x = network.positions;
  std::vector<Positions> broken(std::size_t(forces), x);
  bool resolved = false;
  for (std::size_t k = 0; k < broken.size(); ++k) {
    const Push push = random_push(random, int(x.size()), 0.1 * unit, 2 * unit);
    x[std::size_t(push.joint)] += push.by;
    broken[k] = x;
    const ragdoll::Breakage breakage = {
        .roots = {&push.joint, 1}, .step = std::uint64_t(k), .only_roots_moved = resolved};
    keep_best(times.ours[first + k],
              clock.time_short([&] { resolved = resolver->resolve(x, breakage).converged; }));
    if (!resolved) x = network.positions;
  }
  for (auto [corrects, shuffles, seconds] :
       {std::tuple(Corrects::every_bar, Shuffles::each_iteration, &times.plain),
        std::tuple(Corrects::broken_bars, Shuffles::each_iteration, &times.lean),
        std::tuple(Corrects::every_bar, Shuffles::once, &times.once)}) {
    PlainLoop loop(*network.framework, tolerance, most_iterations, corrects, shuffles);
    for (std::size_t k = 0; k < broken.size(); ++k) {
      loop.load(broken[k]);
      keep_best((*seconds)[first + k], clock.time_short([&] { loop.resolve(); }));
    }
  }
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::size_t(share * double(values.size() - 1))];
}

void measure_times(int repetitions) {
  constexpr int structures = 20, forces = 50;
  for (const char* class_name : {"1-cycle", "2-cycle"}) {
    std::vector<Network> networks;
    for (std::uint64_t k = 0; k < structures; ++k)
      networks.push_back(network_of_class(class_name, k));
    const std::vector<double> never(structures * forces, std::numeric_limits<double>::infinity());
    Times times = {never, never, never, never};
    for (int repetition = 0; repetition < repetitions; ++repetition)
      for (std::size_t k = 0; k < structures; ++k) race(networks[k], forces, k, k * forces, times);
    for (const auto& [contender, seconds] :
         {std::pair("block", &times.ours), std::pair("plain", &times.plain),
          std::pair("plain lean", &times.lean), std::pair("plain once", &times.once)})
      Record("small_cycles")
          .text("class", class_name)
          .text("contender", contender)
          .number("p50_us", 1e6 * percentile(*seconds, 0.5))
          .number("p99_us", 1e6 * percentile(*seconds, 0.99))
          .print();
  }
}

}  // namespace

void measure_cycles(const Words& words) {
  measure_times(std::stoi(words.at(1)));
  measure_iterations(std::stoi(words.at(0)));
}

}  // namespace benchmark
