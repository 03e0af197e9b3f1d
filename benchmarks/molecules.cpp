// Molecules: every joint displaced, all solvers beside the baselines; and conformers in a row.

#include <string>

#include "commands.h"
#include "contender.h"      // compete
#include "molecule_file.h"  // read_molecule, write_molecule
#include "peptide.h"        // make_peptide
#include "ragdoll/error.h"  // Error

namespace benchmark {
namespace {

using ragdoll::Precision;
using ragdoll::ResolverSettings;
using ragdoll::Tolerance;

constexpr double deviation = 0.01;  // nm for each coordinate

ResolverSettings settings_of(const char* solver, Tolerance tolerance,
                             Precision precision = Precision::double_) {
  ResolverSettings settings;
  settings.solver = solver;
  settings.tolerance = tolerance;
  settings.precision = precision;
  return settings;
}

void measure_network(const Network& network, Tolerance tolerance, int breaks, double seconds) {
  // a group of breaks fills every lane; those that come one at a time are its first ones
  const std::vector<Positions> group = breaks_of(network, deviation, 64);
  const std::vector<Positions> single(group.begin(), group.begin() + breaks);
  Contenders contenders = plain_contenders(network, tolerance);
  contenders.push_back(coloured_contender(network, tolerance));
  for (const char* solver : {"ordered", "newton", "auto"})
    contenders.push_back(solver_contender(solver, network, settings_of(solver, tolerance)));
  compete(network, single, contenders, tolerance, seconds);

  Contenders ensembles;
  for (const char* solver : {"ordered", "newton"}) {
    // sweeps to 1e-3 A take thousands of passes for each break of the group
    if (solver == std::string("ordered") && tolerance.absolute() && tolerance.value() < 1e-3)
      continue;
    for (const Precision precision : {Precision::double_, Precision::single}) try {
        ensembles.push_back(
            ensemble_contender(std::string(solver) + " ensemble " + name_of(precision), network,
                               settings_of(solver, tolerance, precision)));
      } catch (const ragdoll::Error&) {
        // a solver says itself which tolerances floats are too coarse for
      }
  }
  compete(network, group, ensembles, tolerance, seconds);
}

/// Bonds and 1-3 distances, as constraints that OpenMM could be given too.
Network network_of_angles(const ragdoll::Molecule& molecule) {
  const Network whole = network_of_molecule(molecule, false);
  std::vector<ragdoll::Bar> bars;
  for (const ragdoll::Bar& bar : whole.framework->bars())
    if (bar.kind != ragdoll::BarKind::planar) bars.push_back(bar);
  return network_of_bars("bonds and 1-3", whole.positions, std::move(bars));
}

}  // namespace

void measure_where_openmm_fails(const Words& words) {
  const ragdoll::Molecule molecule = read_molecule(words.at(0));
  const Network network =
      words.at(1) == "bonds" ? network_of_bonds(molecule) : network_of_angles(molecule);
  constexpr double relative = 6e-4;
  const std::vector<Positions> breaks = breaks_of(network, std::stod(words.at(2)), 8);
  Contenders contenders;
  for (const char* solver : {"newton", "auto"})
    contenders.push_back(solver_contender(solver, network, settings_of(solver, relative)));
  compete(network, breaks, contenders, relative, 0.01);
}

void measure_molecule(const Words& words) {
  const Network network = network_of_molecule(read_molecule(words.at(0)), false);
  for (const double angstrom : {1e-2, 1e-3})
    measure_network(network, Tolerance::nanometers(angstrom / 10), std::stoi(words.at(1)),
                    std::stod(words.at(2)));
}

void write_peptide(const Words& words) {
  write_molecule(words.at(1), molecule_of(make_peptide(std::stoi(words.at(0)))));
}

void measure_bonds(const Words& words) {
  const Network network = network_of_bonds(read_molecule(words.at(0)));
  for (const double relative : {6e-4, 1e-6})
    measure_network(network, relative, std::stoi(words.at(1)), std::stod(words.at(2)));
}

}  // namespace benchmark
