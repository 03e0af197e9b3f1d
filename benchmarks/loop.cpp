// Loop: the inner loops, some repetitions of each, for callgrind to count their instructions. The
// difference between two numbers of repetitions is that of the loop alone.

#include <string>

#include "commands.h"
#include "network.h"                    // breaks_of
#include "peptide.h"                    // make_peptide
#include "ragdoll/contact_list.h"       // ContactList
#include "ragdoll/ensemble_resolver.h"  // make_ensemble_resolver
#include "record.h"                     // Record

namespace benchmark {
namespace {

using ragdoll::Vec3;

constexpr int joints = 1000;
constexpr double deviation = 0.01;  // nm for each coordinate

ragdoll::ResolverSettings settings_of(const char* solver) {
  ragdoll::ResolverSettings settings;
  settings.solver = solver;
  settings.tolerance = ragdoll::Tolerance::nanometers(1e-4);
  return settings;
}

/// What the repetitions did, as often as it is counted: visits, iterations times joints, ...
void print(const std::string& loop, const char* unit, double units) {
  Record("loop").text("loop", loop).text("unit", unit).number("units", units).print();
}

void sweep(int repetitions) {
  const Network network = network_of_bonds(molecule_of(make_peptide(joints)));
  const auto resolver = make_resolver(network.framework, settings_of("ordered"));
  const Positions broken = breaks_of(network, deviation, 1).front();
  double visits = 0;
  for (int k = 0; k < repetitions; ++k) {
    Positions x = broken;
    visits += double(resolver->resolve(x, {}).bar_visits);
  }
  print("ordered", "bar visit", visits);
}

void newton(int repetitions) {
  const Network network = network_of_molecule(molecule_of(make_peptide(joints)), false);
  const auto resolver = make_resolver(network.framework, settings_of("newton"));
  const Positions broken = breaks_of(network, deviation, 1).front();
  double iterations = 0;
  for (int k = 0; k < repetitions; ++k) {
    Positions x = broken;
    iterations += double(resolver->resolve(x, {}).iterations);
  }
  print("newton", "iteration and joint", iterations * network.framework->joint_count());
}

/// A group of breaks for each repetition, in lanes.
void ensemble(const char* solver, bool of_bonds, int repetitions) {
  const ragdoll::Molecule molecule = molecule_of(make_peptide(joints));
  const Network network =
      of_bonds ? network_of_bonds(molecule) : network_of_molecule(molecule, false);
  const auto resolver = make_ensemble_resolver(network.framework, settings_of(solver));
  Positions broken;
  for (const Positions& x : breaks_of(network, deviation, 16))
    broken.insert(broken.end(), x.begin(), x.end());
  double iterations = 0, visits = 0;
  for (int k = 0; k < repetitions; ++k) {
    Positions all = broken;
    for (const ragdoll::ResolveReport& report : resolve_all(*resolver, all)) {
      iterations += double(report.iterations);
      visits += double(report.bar_visits);
    }
  }
  const std::string loop = std::string(solver) + " ensemble";
  if (of_bonds)
    print(loop, "bar visit and conformer", visits);
  else
    print(loop, "iteration, joint and conformer", iterations * network.framework->joint_count());
}

void block(int repetitions) {
  const Network network = network_of_bonds(molecule_of(make_peptide(joints)));
  const auto resolver = make_resolver(network.framework, settings_of("block"));
  Positions x = network.positions;
  resolver->resolve(x, {});
  constexpr int forces = 200;
  for (int k = 0; k < repetitions * forces; ++k) {
    const int joint = (k * 37) % joints;
    x[std::size_t(joint)] += Vec3(0.1, 0.05, -0.08);
    resolver->resolve(x, {.roots = {&joint, 1}, .only_roots_moved = true});
  }
  print("block", "forced joint", double(repetitions) * forces);
}

/// The list made anew for each repetition, or kept because joints moved little.
void contacts(bool kept, int repetitions) {
  const Network network = network_of_molecule(molecule_of(make_peptide(joints)), true);
  ragdoll::ContactList list(network.framework->contact_rule(), 0.1);
  double pairs = 0;
  for (int k = 0; k < repetitions; ++k) {
    Positions x = network.positions;
    for (Vec3& joint : x) joint[0] += (kept ? 1e-3 : 1.0) * k;
    list.update(x, nullptr, 0.02);
    pairs += double(list.pairs().size());
  }
  print("contacts", kept ? "near pair of a list that is kept" : "near pair of a new list", pairs);
}

}  // namespace

void measure_loop(const Words& words) {
  const int repetitions = std::stoi(words.at(1));
  const std::string& loop = words.at(0);
  if (loop == "ordered") sweep(repetitions);
  if (loop == "newton") newton(repetitions);
  if (loop == "ordered-ensemble") ensemble("ordered", true, repetitions);
  if (loop == "newton-ensemble") ensemble("newton", false, repetitions);
  if (loop == "block") block(repetitions);
  if (loop == "contacts") contacts(false, repetitions);
  if (loop == "contacts-kept") contacts(true, repetitions);
}

}  // namespace benchmark
