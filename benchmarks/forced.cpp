// Forced: one joint of the bonds of a peptide, at sizes at which a pass over all bars takes long.

#include <algorithm>  // min
#include <limits>     // infinity

#include "clock.h"  // Clock
#include "commands.h"
#include "peptide.h"           // make_peptide
#include "plain_loop.h"        // PlainLoop
#include "ragdoll/resolver.h"  // make_resolver
#include "record.h"            // Record

namespace benchmark {
namespace {

using ragdoll::Random;
using ragdoll::Vec3;

constexpr double tolerance = 1e-2;
constexpr double bar_length = 0.15;  // nm, about the mean

struct Push {
  int joint;
  Vec3 by;  // nm
};

/// 0.1 to 2 bar lengths.
Push random_push(Random& random, int joints) {
  const Vec3 direction(random.gaussian(), random.gaussian(), random.gaussian());
  const int joint = int(random.below(std::uint64_t(joints)));
  return {joint, bar_length * (0.1 + 1.9 * random.uniform()) * direction.normalized()};
}

Record record_of(const Network& network, const char* contender, std::int64_t forces) {
  return Record("forced")
      .count("joints", network.framework->joint_count())
      .count("bars", std::int64_t(network.framework->bars().size()))
      .text("contender", contender)
      .count("forces", forces);
}

void measure_ours(const char* solver, const Network& network) {
  constexpr int groups = 8, forces = 500;  // the best group: the others met a busy machine
  constexpr double patience = 3;           // seconds; a solver that looks at every bar gets no more
  ragdoll::ResolverSettings settings;
  settings.solver = solver;
  settings.tolerance = tolerance;
  const std::unique_ptr<ragdoll::Resolver> resolver = make_resolver(network.framework, settings);
  Random random(9, ragdoll::RandomStream::perturbation, 0);
  Positions x = network.positions;
  resolver->resolve(x, {});  // from here on the promise holds
  const Clock clock;
  double best = std::numeric_limits<double>::infinity();
  double spent = 0;
  std::int64_t done = 0, visits = 0, failed = 0;
  for (int group = 0; group < groups && spent < patience; ++group) {
    double seconds = 0;
    int k = 0;
    for (; k < forces && spent + seconds < patience; ++k) {
      const Push push = random_push(random, int(x.size()));
      x[std::size_t(push.joint)] += push.by;
      ragdoll::ResolveReport report;
      seconds += clock.time([&] {
        report = resolver->resolve(
            x, {.roots = {&push.joint, 1}, .step = std::uint64_t(k), .only_roots_moved = true});
      });
      visits += report.bar_visits;
      failed += report.converged ? 0 : 1;
    }
    best = std::min(best, seconds / k);
    spent += seconds;
    done += k;
  }
  record_of(network, solver, done)
      .count("failed", failed)
      .count("wrong", failed == 0 && worst_excess(*network.framework, x, tolerance) > 1 + 1e-6)
      .number("visits", double(visits) / double(done))
      .number("us", 1e6 * best)
      .print();
}

void measure_plain(const char* name, const Network& network, Shuffles shuffles) {
  const int bars = int(network.framework->bars().size());
  const int forces = std::max(2, 20000 / bars);
  PlainLoop plain(*network.framework, tolerance, 10000, Corrects::every_bar, shuffles);
  plain.load(network.positions);
  Random random(9, ragdoll::RandomStream::perturbation, 0);
  const Clock clock;
  double seconds = 0, visits = 0;
  for (int k = 0; k < forces; ++k) {
    const Push push = random_push(random, network.framework->joint_count());
    plain.move(push.joint, push.by);
    seconds += clock.time([&] { plain.resolve(); });
    visits += double(plain.iterations() + 1) * bars;
  }
  record_of(network, name, forces)
      .number("visits", visits / forces)
      .number("us", 1e6 * seconds / forces)
      .print();
}

}  // namespace

void measure_forced(const Words& words) {
  for (const std::string& joints : words) {
    const Network network = network_of_bonds(molecule_of(make_peptide(std::stoi(joints))));
    measure_ours("block", network);
    measure_ours("auto", network);
    if (network.framework->joint_count() > 2000000) continue;
    measure_plain("plain", network, Shuffles::each_iteration);
    measure_plain("plain once", network, Shuffles::once);
  }
}

}  // namespace benchmark
