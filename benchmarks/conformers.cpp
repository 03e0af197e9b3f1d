// Conformers: walkers that step, each from where its last accepted step left it, held by everything
// that holds a molecule; and what contacts add to a step.

#include <chrono>
#include <string>

#include "clock.h"  // Clock
#include "commands.h"
#include "molecule_file.h"    // read_molecule
#include "network.h"          // worst_excess
#include "ragdoll/walkers.h"  // walk
#include "record.h"           // Record

namespace benchmark {
namespace {

constexpr double deviation = 0.01;  // nm for each coordinate
constexpr auto tolerance = ragdoll::Tolerance::nanometers(1e-3);

/// Walks for about so many seconds, on one thread. Perturbations, contacts, and taking back what
/// is not resolved are in the time; looking at frames is not.
void measure(const Network& network, const char* solver, ragdoll::Precision precision,
             double seconds) {
  ragdoll::WalkSettings settings;
  settings.resolver.solver = solver;
  settings.resolver.tolerance = tolerance;
  settings.resolver.precision = precision;
  settings.resolver.max_iterations = 200;  // a walker that needs more tries another step
  settings.motion.size = deviation;
  settings.walkers = 64;
  settings.frames = 1000000;
  settings.threads = 1;
  const ragdoll::Framework& framework = *network.framework;
  std::int64_t inverted = 0, seen = 0;
  std::vector<Positions> looked_at;
  const auto start = std::chrono::steady_clock::now();
  const auto since = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  ragdoll::WalkReport report;
  const double spent = Clock().time([&] {
    report = walk(
        network.framework, network.positions, settings, nullptr,
        [&](const ragdoll::WalkFrame& frame) {
          inverted += inverted_centres(framework, frame.positions);
          if (seen++ % 16 == 0 && looked_at.size() < 200) looked_at.push_back(frame.positions);
        },
        [&] { return since() < seconds; });
  });
  std::int64_t steps = 0, rejected = 0, wrong = 0;
  for (const ragdoll::WalkerReport& walker : report.walkers) {
    steps += walker.steps;
    rejected += walker.rejected_steps;
  }
  for (const Positions& frame : looked_at)
    wrong += worst_excess(framework, frame, tolerance) > 1 + 1e-9 ? 1 : 0;
  Record("conformers")
      .text("network", network.name)
      .count("joints", framework.joint_count())
      .text("solver", solver)
      .text("works", report.solver)
      .text("precision", name_of(precision))
      .count("lanes", report.lanes)
      .text("instructions", report.instructions)
      .count("steps", steps)
      .count("accepted", steps - rejected)
      .count("wrong", wrong)
      .count("inverted", inverted)
      .number("ms_per_accepted", 1e3 * spent / double(steps - rejected))
      .number("ms_per_step", 1e3 * spent / double(steps))
      .print();
}

}  // namespace

void measure_conformers(const Words& words) {
  const ragdoll::Molecule molecule = read_molecule(words.at(0));
  const double seconds = std::stod(words.at(1));
  for (const bool contacts : {true, false}) {
    const Network network = network_of_molecule(molecule, contacts);
    for (const char* solver : {"auto", "ordered", "newton"})
      for (const auto precision : {ragdoll::Precision::double_, ragdoll::Precision::single})
        measure(network, solver, precision, seconds);
  }
}

}  // namespace benchmark
