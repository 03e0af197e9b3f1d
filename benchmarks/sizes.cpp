// Sizes: the same peptide, longer and longer. Iterations of `newton`, time of every solver, set-up.

#include <algorithm>  // min, max
#include <limits>     // infinity
#include <string>

#include "clock.h"  // Clock
#include "commands.h"
#include "contender.h"                // compete
#include "peptide.h"                  // make_peptide
#include "ragdoll/build_framework.h"  // build_framework
#include "ragdoll/resolver.h"         // make_resolver
#include "record.h"                   // Record

namespace benchmark {
namespace {

using ragdoll::Tolerance;

constexpr double deviation = 0.01;  // nm for each coordinate

ragdoll::ResolverSettings settings_of(const char* solver, Tolerance tolerance) {
  ragdoll::ResolverSettings settings;
  settings.solver = solver;
  settings.tolerance = tolerance;
  return settings;
}

/// @param largest_plain  joints up to which sweeps over all bars are worth waiting for
void measure_size(int joints, int largest_plain) {
  const Network network = network_of_molecule(molecule_of(make_peptide(joints)), false);
  const int count = std::clamp(20000 / joints, 1, 64);
  const std::vector<Positions> breaks = breaks_of(network, deviation, count);
  for (const double angstrom : {1e-2, 1e-3}) {
    const Tolerance tolerance = Tolerance::nanometers(angstrom / 10);
    Contenders contenders;
    if (angstrom == 1e-2 && joints <= largest_plain) {
      contenders = plain_contenders(network, tolerance);
      contenders.push_back(coloured_contender(network, tolerance));
      contenders.push_back(solver_contender("ordered", network, settings_of("ordered", tolerance)));
    }
    contenders.push_back(solver_contender("newton", network, settings_of("newton", tolerance)));
    compete(network, breaks, contenders, tolerance, joints > 200000 ? 1 : 0.3);
    if (joints > 100000) continue;
    // every lane has work
    Contenders lanes;
    lanes.push_back(
        ensemble_contender("newton ensemble", network, settings_of("newton", tolerance)));
    compete(network, breaks_of(network, deviation, std::max(16, count)), lanes, tolerance, 0.3);
  }
}

/// Bonds alone, as OpenMM can resolve them.
void measure_bonds_of_size(int joints) {
  constexpr double relative = 6e-4;
  const Network network = network_of_bonds(molecule_of(make_peptide(joints)));
  const std::vector<Positions> breaks = breaks_of(network, deviation, 16);
  ragdoll::ResolverSettings settings = settings_of("ordered", relative);
  Contenders contenders;
  contenders.push_back(solver_contender("ordered", network, settings));
  settings.precision = ragdoll::Precision::single;
  contenders.push_back(ensemble_contender("ordered ensemble single", network, settings));
  compete(network, breaks, contenders, relative, 0.1);
}

/// Seconds of the fastest of some repetitions.
template <class Action>
double fastest(int repetitions, Action&& action) {
  const Clock clock;
  double best = std::numeric_limits<double>::infinity();
  for (int k = 0; k < repetitions; ++k) best = std::min(best, clock.time(action));
  return best;
}

void print_setup(const char* network, const char* part, int joints, double seconds) {
  Record("setup")
      .text("network", network)
      .text("part", part)
      .count("joints", joints)
      .number("ms", 1e3 * seconds)
      .print();
}

/// Until a resolver is ready: what it does when it is made, and what its first iterations take
/// longer than those of a second break.
double fastest_setup(const Network& network, const char* solver, int repetitions) {
  const Clock clock;
  const Positions broken = breaks_of(network, deviation, 1).front();
  ragdoll::ResolverSettings settings = settings_of(solver, Tolerance::nanometers(1e-7));
  settings.max_iterations = 6;  // what is put off until it is needed is needed now
  constexpr double never = std::numeric_limits<double>::infinity();
  double made = never, first = never, second = never;
  for (int k = 0; k < repetitions; ++k) {
    std::unique_ptr<ragdoll::Resolver> resolver;
    made =
        std::min(made, clock.time([&] { resolver = make_resolver(network.framework, settings); }));
    for (double* best : {&first, &second}) {
      Positions x = broken;
      *best = std::min(*best, clock.time([&] { resolver->resolve(x, {}); }));
    }
  }
  return made + std::max(0.0, first - second);
}

void measure_setup_of(int joints) {
  const int repetitions = std::clamp(300000 / joints, 1, 5);
  const ragdoll::Molecule molecule = molecule_of(make_peptide(joints));
  const int count = int(molecule.atoms().size());
  for (const char* kind : {"bonds", "molecule"}) {
    const bool bonds = kind == std::string("bonds");
    Network network;
    print_setup(kind, "framework", count, fastest(repetitions, [&] {
                  network =
                      bonds ? network_of_bonds(molecule) : network_of_molecule(molecule, false);
                }));
    for (const char* solver : {"ordered", "newton", "block", "auto"}) {
      if (!bonds && solver == std::string("block")) continue;
      // a factor of more joints does not fit into the memory of every machine
      const bool factor = solver == std::string("newton") || solver == std::string("auto");
      if (count > 4000000 && factor) continue;
      print_setup(kind, solver, count, fastest_setup(network, solver, repetitions));
    }
  }
}

}  // namespace

void measure_sizes(const Words& words) {
  const int largest_plain = std::stoi(words.at(0));
  for (std::size_t k = 1; k < words.size(); ++k) {
    const int joints = std::stoi(words[k]);
    measure_size(joints, largest_plain);
    if (joints <= 100000) measure_bonds_of_size(joints);
  }
}

void measure_setup(const Words& words) {
  for (const std::string& joints : words) measure_setup_of(std::stoi(joints));
}

}  // namespace benchmark
