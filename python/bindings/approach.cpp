#include "approach.h"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <utility>  // move

#include "arrays.h"
#include "interruption.h"  // Interruption
#include "ragdoll/approach.h"
#include "ragdoll/backbone_guide.h"
#include "ragdoll/common_framework.h"
#include "settings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace ragdoll::bindings {
namespace {

std::vector<int> joints_from(const InVector<std::int32_t>& joints) {
  return {joints.data(), joints.data() + joints.shape(0)};
}

nb::tuple common_framework_of(const Framework& framework, const InPoints& start,
                              const InVector<std::int32_t>& joints, const InPoints& other,
                              double margin, const std::optional<InPoints>& box_vectors) {
  const std::optional<Box> box = box_of(box_vectors);
  CommonBounds bounds;
  auto common = std::make_shared<Framework>(
      common_framework(framework, points_of(start), joints_from(joints), points_of(other), margin,
                       &bounds, box ? &*box : nullptr));
  nb::dict counts;
  counts["kept"] = bounds.kept;
  counts["widened"] = bounds.widened;
  counts["dropped"] = bounds.dropped;
  return nb::make_tuple(common, counts);
}

nb::dict approach_from(std::shared_ptr<Framework> framework, const InPoints& start,
                       const nb::callable& take, const InVector<std::int32_t>& joints,
                       const InPoints& target, const In<double, nb::shape<-1, -1>>& stages,
                       const InVector<std::int32_t>& sites, const MotionSettings& motion,
                       std::shared_ptr<BackboneGuide> guide, bool part_close_pairs,
                       std::size_t mended_stages, bool wander, double step, double spacing,
                       double widest, double close, double arrived, int retries,
                       const std::string& solver, const std::string& order,
                       const std::string& weighting, std::optional<double> tolerance,
                       std::optional<double> absolute_tolerance, long max_iterations,
                       std::uint64_t seed, const std::string& precision,
                       const std::optional<InPoints>& box_vectors) {
  ApproachSettings settings;
  settings.resolver = settings_of(solver, order, weighting, tolerance, absolute_tolerance,
                                  max_iterations, seed, precision, false);
  settings.joints = joints_from(joints);
  settings.target = points_of(target);
  for (std::size_t k = 0; k < stages.shape(0); ++k) {
    const double* row = stages.data() + k * stages.shape(1);
    settings.stages.emplace_back(row, row + stages.shape(1));
  }
  settings.sites = joints_from(sites);
  settings.motion = motion;
  settings.guide = std::move(guide);
  settings.part_close_pairs = part_close_pairs;
  settings.mended_stages = mended_stages;
  settings.wander = wander;
  settings.step = step;
  settings.spacing = spacing;
  settings.widest = widest;
  settings.close = close;
  settings.arrived = arrived;
  settings.retries = retries;
  const std::vector<Vec3> x = points_of(start);
  const std::optional<Box> box = box_of(box_vectors);
  Interruption interruption;
  const auto take_frame = [&](const ApproachFrame& frame) {
    interruption.guard([&] {
      nb::dict resolved = report_dict(frame.report);
      resolved["rmsd"] = frame.rmsd;
      resolved["target_rmsd"] = frame.target_rmsd;
      take(frame.steps, out_points(frame.positions), resolved);
    });
  };
  ApproachReport report;
  {
    const nb::gil_scoped_release release;
    report = approach(std::move(framework), x, settings, box ? &*box : nullptr, take_frame,
                      [&] { return interruption.keep_going(); });
  }
  nb::dict d;
  d["rmsd_start"] = report.rmsd_start;
  d["rmsd_end"] = report.rmsd_end;
  d["target_rmsd_end"] = report.target_rmsd_end;
  d["frames"] = report.frames;
  d["steps"] = report.steps;
  d["rejected_steps"] = report.rejected_steps;
  d["retries"] = report.retries;
  d["iterations"] = out(report.iterations);
  d["solver"] = report.solver;
  d["last_rejection"] = report.last_rejection;
  d["arrived"] = report.arrived;
  d["interrupted"] = report.interrupted;
  return d;
}

}  // namespace

void bind_approach(nb::module_& m) {
  const ApproachSettings usual;
  nb::class_<BackboneGuide>(m, "BackboneGuide",
                            "Turns peptide planes so that residues become plausible.")
      .def(nb::new_([](const InVector<double>& density, double core, double allowed,
                       const In<std::int32_t, nb::shape<-1, 7>>& residues,
                       const InVector<std::uint8_t>& to_core,
                       const std::vector<std::pair<std::pair<int, int>, std::vector<int>>>& planes,
                       double most) {
             check_size(to_core, residues.shape(0), "to_core");
             std::vector<GuidedResidue> guided;
             for (std::size_t k = 0; k < residues.shape(0); ++k)
               guided.push_back({residues(k, 0), residues(k, 1), residues(k, 2), residues(k, 3),
                                 residues(k, 4), residues(k, 5), residues(k, 6), to_core(k) != 0});
             std::vector<PeptidePlane> turned;
             for (const auto& [ends, atoms] : planes)
               turned.push_back({ends.first, ends.second, atoms});
             const RamachandranDensity map({density.data(), density.data() + density.shape(0)}, core,
                                       allowed);
             return std::make_shared<BackboneGuide>(map, std::move(guided), std::move(turned),
                                                    most);
           }),
           "density"_a, "core"_a, "allowed"_a, "residues"_a, "to_core"_a, "planes"_a, "most"_a,
           "density: a square map, one row for each psi; its levels. residues: C before, N, CA, C,\n"
           "N after, and the planes before and after, -1 for none (n, 7); to_core: led back to the\n"
           "core, not only out of the outliers (n). planes: ((CA, CA), atoms between that turn).\n"
           "most: that a plane turns at a time, rad.")
      .def(
          "move",
          [](const BackboneGuide& self, const InPoints& positions) {
            std::vector<Vec3> x = points_of(positions);
            self.move(x);
            return out_points(x);
          },
          "positions"_a, "Positions with planes turned.");
  m.def(
      "common_framework", &common_framework_of, "framework"_a, "start"_a, "joints"_a, "other"_a,
      "margin"_a = 0.03, "box_vectors"_a = nb::none(),
      "The framework less the bounds that a second conformation does not have, and how many were\n"
      "kept, widened and dropped. start (njoint, 3), other: places of `joints` (n, 3), nm.");
  m.def(
      "approach", &approach_from, "framework"_a, "start"_a, "take"_a, nb::kw_only(), "joints"_a,
      "target"_a, "stages"_a, "sites"_a, "motion"_a, "guide"_a = nb::none(),
      "part_close_pairs"_a = true, "mended_stages"_a = 0, "wander"_a = false, "step"_a = usual.step,
      "spacing"_a = usual.spacing, "widest"_a = usual.widest, "close"_a = usual.close,
      "arrived"_a = usual.arrived, "retries"_a = usual.retries, "solver"_a = "auto",
      "order"_a = "bfs_cycle", "weighting"_a = ".5/.5", "tolerance"_a = nb::none(),
      "absolute_tolerance"_a = nb::none(), "max_iterations"_a = ResolverSettings{}.max_iterations,
      "seed"_a = 0, "precision"_a = "double", "box_vectors"_a = nb::none(),
      "Moves `joints` towards `target` (n, 3; nm), lowering the RMSD weighted by each row of\n"
      "`stages` (nstage, n) in turn; `sites` are indices of joints that tell how near it is.\n"
      "Calls take(steps, positions, report) with each frame. Returns a dict of what was reached.");
}

}  // namespace ragdoll::bindings
