#include "ensembles.h"

#include <nanobind/stl/function.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>  // min
#include <memory>
#include <utility>  // move

#include "interruption.h"  // Interruption
#include "ragdoll/ensemble_resolver.h"
#include "ragdoll/walkers.h"
#include "settings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace ragdoll::bindings {
namespace {

using InConformers = In<double, nb::shape<-1, -1, 3>>;

nb::tuple resolve_conformers(EnsembleResolver& self, const InConformers& positions,
                             std::uint64_t first_step, const std::optional<InPoints>& box_vectors) {
  const std::size_t count = positions.shape(0), joints = positions.shape(1);
  if (joints != self.joint_count())
    throw Error("the conformers have " + std::to_string(joints) +
                " positions each, the framework " + std::to_string(self.joint_count()) + " joints");
  std::vector<Vec3> x(count * joints);
  const double* given = positions.data();
  for (std::size_t j = 0; j < x.size(); ++j)
    x[j] = Vec3(given[3 * j], given[3 * j + 1], given[3 * j + 2]);
  const std::optional<Box> box = box_of(box_vectors);
  std::vector<ResolveReport> reports;
  {
    const nb::gil_scoped_release release;
    // in parts, so that Ctrl-C is seen
    const std::size_t at_once = 64 * std::size_t(self.lanes());
    for (std::size_t first = 0; first < count; first += at_once) {
      const std::size_t part = std::min(at_once, count - first);
      for (ResolveReport& report :
           resolve_all(self, std::span(x).subspan(first * joints, part * joints),
                       first_step + first, box ? &*box : nullptr))
        reports.push_back(std::move(report));
      const nb::gil_scoped_acquire acquire;
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
    }
  }
  std::vector<double> flat;
  flat.reserve(3 * x.size());
  for (const Vec3& point : x) flat.insert(flat.end(), {point[0], point[1], point[2]});
  nb::list dicts;
  for (const ResolveReport& report : reports) dicts.append(report_dict(report));
  return nb::make_tuple(out(flat, {count, joints, 3}), dicts);
}

nb::dict dict_of(const WalkerState& state) {
  nb::dict d;
  d["positions"] = out_points(state.positions);
  d["steps"] = state.steps;
  d["accepted"] = state.accepted;
  d["motion"] = out(state.motion);
  return d;
}

WalkerState state_of(const nb::dict& d) {
  const auto motion = nb::cast<InVector<double>>(d["motion"]);
  return {points_of(nb::cast<InPoints>(d["positions"])), nb::cast<std::int64_t>(d["steps"]),
          nb::cast<std::int64_t>(d["accepted"]),
          std::vector<double>(motion.data(), motion.data() + motion.shape(0))};
}

nb::dict dict_of(const WalkReport& report) {
  nb::list walkers;
  for (const WalkerReport& walker : report.walkers) {
    nb::dict d;
    d["seed"] = walker.seed;
    d["frames"] = walker.frames;
    d["steps"] = walker.steps;
    d["rejected_steps"] = walker.rejected_steps;
    d["iterations"] = out(walker.iterations);
    d["last_rejection"] = walker.last_rejection;
    nb::dict low;
    for (const auto& [measure, count] : walker.low_frames) low[measure.c_str()] = count;
    d["low_frames"] = low;
    d["last_fault"] = walker.last_fault;
    d["state"] = dict_of(walker.state);
    walkers.append(d);
  }
  nb::dict d;
  d["walkers"] = walkers;
  d["solver"] = report.solver;
  d["instructions"] = report.instructions;
  d["lanes"] = report.lanes;
  d["threads"] = report.threads;
  d["interrupted"] = report.interrupted;
  return d;
}

nb::dict walk_from(std::shared_ptr<Framework> framework, const InPoints& start,
                   const nb::callable& take, int walkers, std::int64_t frames, std::int64_t stride,
                   std::int64_t attempts, const MotionSettings& motion,
                   std::shared_ptr<Symmetry> symmetry, const std::vector<nb::dict>& states,
                   const std::string& solver, const std::string& order,
                   const std::string& weighting, std::optional<double> tolerance,
                   std::optional<double> absolute_tolerance, long max_iterations,
                   std::uint64_t seed, const std::string& precision, bool mass_weights, int threads,
                   int lanes, const std::optional<InPoints>& box_vectors,
                   std::shared_ptr<QualityJudge> judge) {
  WalkSettings settings;
  settings.judge = std::move(judge);
  settings.resolver = settings_of(solver, order, weighting, tolerance, absolute_tolerance,
                                  max_iterations, seed, precision, mass_weights);
  settings.motion = motion;
  settings.symmetry = std::move(symmetry);
  for (const nb::dict& state : states) settings.states.push_back(state_of(state));
  settings.walkers = walkers;
  settings.frames = frames;
  settings.stride = stride;
  settings.attempts = attempts;
  settings.threads = threads;
  settings.lanes = lanes;
  const std::vector<Vec3> x = points_of(start);
  const std::optional<Box> box = box_of(box_vectors);
  Interruption interruption;
  const auto take_frame = [&](const WalkFrame& frame) {
    interruption.guard([&] {
      take(frame.walker, frame.steps, out_points(frame.positions), report_dict(frame.report));
    });
  };
  WalkReport report;
  {
    const nb::gil_scoped_release release;
    report = walk(std::move(framework), x, settings, box ? &*box : nullptr, take_frame,
                  [&] { return interruption.keep_going(); });
  }
  return dict_of(report);
}

}  // namespace

void bind_ensembles(nb::module_& m) {
  nb::class_<EnsembleResolver>(
      m, "EnsembleResolver",
      "Resolves many conformers of one framework side by side, one in each lane of the machine's\n"
      "vectors. What comes out is what Resolver gives with the same settings, bit for bit.")
      .def(nb::new_([](std::shared_ptr<Framework> framework, const std::string& solver,
                       const std::string& order, const std::string& weighting,
                       std::optional<double> tolerance, std::optional<double> absolute_tolerance,
                       long max_iterations, std::uint64_t seed, const std::string& precision,
                       bool mass_weights, int lanes) {
             return make_ensemble_resolver(
                        std::move(framework),
                        settings_of(solver, order, weighting, tolerance, absolute_tolerance,
                                    max_iterations, seed, precision, mass_weights),
                        lanes)
                 .release();
           }),
           "framework"_a, "solver"_a = "auto", "order"_a = "bfs_cycle", "weighting"_a = ".5/.5",
           "tolerance"_a = nb::none(), "absolute_tolerance"_a = nb::none(),
           "max_iterations"_a = ResolverSettings{}.max_iterations, "seed"_a = 0,
           "precision"_a = "double", "mass_weights"_a = false, "lanes"_a = 0,
           "As Resolver; precision: \"single\" or \"double\"; lanes: 0 takes as many as the\n"
           "machine's vectors hold.")
      .def_prop_ro("solver", &EnsembleResolver::solver, "The solver that works.")
      .def_prop_ro("lanes", &EnsembleResolver::lanes, "Conformers resolved at once.")
      .def_prop_ro("instructions", &EnsembleResolver::instructions,
                   "The instructions that work, or \"none\" where conformers are resolved in turn.")
      .def(
          "resolve_all", &resolve_conformers, "positions"_a, "first_step"_a = 0,
          "box_vectors"_a = nb::none(),
          "Resolves conformers (n, njoint, 3; nm), all joints of which may have moved. Conformer k "
          "is\nthe break of step first_step + k. Returns the resolved positions (n, njoint, 3; nm) "
          "and a list\nof n reports with converged, iterations, bar_visits, residual (relative), "
          "residual_nm, reason\nand worst; the input stays as it is. Python's lock is free "
          "meanwhile; one EnsembleResolver\nbelongs to one thread at a time.");

  m.def(
      "walk", &walk_from, "framework"_a, "start"_a, "take"_a, nb::kw_only(), "walkers"_a = 1,
      "frames"_a = 1, "stride"_a = 1, "attempts"_a = WalkSettings{}.attempts,
      "motion"_a = MotionSettings{}, "symmetry"_a = nb::none(),
      "states"_a = std::vector<nb::dict>(), "solver"_a = "auto", "order"_a = "bfs_cycle",
      "weighting"_a = ".5/.5", "tolerance"_a = nb::none(), "absolute_tolerance"_a = nb::none(),
      "max_iterations"_a = ResolverSettings{}.max_iterations, "seed"_a = 0,
      "precision"_a = "double", "mass_weights"_a = false, "threads"_a = 0, "lanes"_a = 0,
      "box_vectors"_a = nb::none(), "judge"_a = nb::none(),
      "Walks `walkers` replicas from `start` (njoint, 3; nm); walker k has seed + k. Calls\n"
      "take(walker, steps, positions, report) with each frame, first frames first. Returns a dict\n"
      "with what each walker did. Frames that a judge finds below its limits are counted and not "
      "given\nout. Ctrl-C ends it early: the dict says interrupted. Given the states of an earlier "
      "walk,\nwalkers go on from there.");
}

}  // namespace ragdoll::bindings
