// Numbering: `ordered` on the bonds of a peptide whose joints are numbered along it, and shuffled.

#include <algorithm>  // min, shuffle
#include <limits>     // infinity
#include <numeric>    // iota
#include <random>     // mt19937_64
#include <string>

#include "clock.h"  // Clock
#include "commands.h"
#include "network.h"           // network_of_bonds, breaks_of
#include "peptide.h"           // make_peptide
#include "ragdoll/resolver.h"  // make_resolver
#include "record.h"            // Record

namespace benchmark {
namespace {

constexpr double tolerance = 1e-3;
constexpr double deviation = 0.01;  // nm for each coordinate

/// The same structure; bars keep their order, as they would in a file.
Network shuffled(const Network& network) {
  std::vector<int> number(network.positions.size());
  std::iota(number.begin(), number.end(), 0);
  std::mt19937_64 random;
  std::shuffle(number.begin(), number.end(), random);
  Positions x(network.positions.size());
  for (std::size_t j = 0; j < x.size(); ++j) x[std::size_t(number[j])] = network.positions[j];
  std::vector<ragdoll::Bar> bars = network.framework->bars();
  for (ragdoll::Bar& bar : bars)
    bar.p = number[std::size_t(bar.p)], bar.q = number[std::size_t(bar.q)];
  return network_of_bars("shuffled", std::move(x), std::move(bars));
}

void measure(const char* numbering, const Network& network, ragdoll::OrderKind order,
             ragdoll::Precision precision) {
  constexpr double patience = 0.5;  // seconds
  constexpr int least = 3;          // the first one makes the order
  ragdoll::ResolverSettings settings;
  settings.solver = "ordered";
  settings.order = order;
  settings.precision = precision;
  settings.tolerance = tolerance;
  const auto resolver = make_resolver(network.framework, settings);
  const Positions broken = breaks_of(network, deviation, 1).front();
  const Clock clock;
  double best = std::numeric_limits<double>::infinity();
  std::int64_t visits = 0;
  double spent = 0;
  for (int k = 0; k < least || spent < patience; ++k) {
    Positions x = broken;
    const double seconds = clock.time([&] { visits = resolver->resolve(x, {}).bar_visits; });
    best = std::min(best, seconds);
    spent += seconds;
  }
  Record("numbering")
      .count("joints", network.framework->joint_count())
      .text("numbering", numbering)
      .text("order", name_of(order))
      .text("precision", name_of(precision))
      .count("visits", visits)
      .number("ms", 1e3 * best)
      .print();
}

}  // namespace

void measure_numbering(const Words& words) {
  using ragdoll::OrderKind, ragdoll::Precision;
  for (const std::string& joints : words) {
    const Network in_order = network_of_bonds(molecule_of(make_peptide(std::stoi(joints))));
    const Network scattered = shuffled(in_order);
    for (const Precision precision : {Precision::double_, Precision::single})
      for (const OrderKind order : {OrderKind::bfs_cycle, OrderKind::dfs_cycle}) {
        measure("along the chain", in_order, order, precision);
        measure("shuffled", scattered, order, precision);
      }
  }
}

}  // namespace benchmark
