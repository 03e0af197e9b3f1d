#include "motions.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>

#include "arrays.h"
#include "ragdoll/error.h"
#include "ragdoll/hinge_tree.h"
#include "ragdoll/motion.h"
#include "ragdoll/symmetry.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace ragdoll::bindings {
namespace {

using InModes = In<double, nb::shape<-1, -1, 3>>;

void set_modes(MotionSettings& settings, const InModes& modes) {
  const double* given = modes.data();
  settings.modes.assign(modes.shape(0), std::vector<Vec3>(modes.shape(1)));
  for (std::vector<Vec3>& mode : settings.modes)
    for (Vec3& part : mode) {
      part = Vec3(given[0], given[1], given[2]);
      given += 3;
    }
}

Vec3 vector_of(const std::vector<double>& numbers) {
  if (numbers.size() != 3) throw Error("a vector has three numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace

void bind_motions(nb::module_& m) {
  nb::class_<MotionSettings>(m, "MotionSettings",
                             "What moves walkers; lengths in nm, angles in rad.")
      .def(nb::new_([](const std::string& kind, double size) {
             MotionSettings settings;
             settings.kind = motion_kind(kind);
             settings.size = size;
             return settings;
           }),
           "kind"_a = "gaussian", "size"_a = MotionSettings{}.size)
      .def_rw("persistence", &MotionSettings::persistence)
      .def_rw("hinge_angle", &MotionSettings::hinge_angle)
      .def_rw("hinge_share", &MotionSettings::hinge_share)
      .def_rw("hinge_reach", &MotionSettings::hinge_reach)
      .def_rw("mode_amplitude", &MotionSettings::mode_amplitude)
      .def_rw("mode_step", &MotionSettings::mode_step)
      .def_rw("thermal_step", &MotionSettings::thermal_step)
      .def_rw("memory", &MotionSettings::memory)
      .def_rw("away_step", &MotionSettings::away_step)
      .def_rw("away_spacing", &MotionSettings::away_spacing)
      .def_rw("sites", &MotionSettings::sites)
      .def_rw("site_of_joint", &MotionSettings::site_of_joint)
      .def("set_away",
           [](MotionSettings& self, const std::string& name) { self.away = away_from(name); })
      .def("set_modes", &set_modes, "modes"_a, "Directions (nmode, njoint, 3), of any length.")
      .def(
          "add_pull",
          [](MotionSettings& self, const std::vector<int>& joints,
             const std::vector<double>& vector) {
            self.pulls.push_back({joints, vector_of(vector), false, Vec3::Zero()});
          },
          "joints"_a, "vector"_a, "Joints that each step moves by a vector.")
      .def(
          "add_pull_towards",
          [](MotionSettings& self, const std::vector<int>& joints, const std::vector<double>& point,
             double step) {
            self.pulls.push_back({joints, Vec3(step, 0, 0), true, vector_of(point)});
          },
          "joints"_a, "point"_a, "step"_a,
          "Joints whose centroid each step moves towards a point, by `step` at most.");
  m.def("motion_names", &motion_names);
  m.def("check_motion", [](const std::string& name) { motion_kind(name); });
  m.def("check_away", [](const std::string& name) { away_from(name); });

  nb::class_<Symmetry>(m, "Symmetry", "Copies of one unit that move alike.")
      .def(nb::new_([](const std::vector<std::vector<int>>& copies, const InPoints& start) {
             return std::make_shared<Symmetry>(copies, points_of(start));
           }),
           "copies"_a, "start"_a, "The joints of each copy; where they are, (njoint, 3).")
      .def(
          "carry",
          [](const Symmetry& self, const InPoints& positions) {
            std::vector<Vec3> x = points_of(positions);
            self.carry(x);
            return out_points(x);
          },
          "positions"_a, "Positions with each copy placed as the first one says.")
      .def(
          "deviation",
          [](const Symmetry& self, const InPoints& positions) {
            return self.deviation(points_of(positions));
          },
          "positions"_a, "The most that a joint is away from where the first copy says, nm.");

  nb::class_<HingeTree>(m, "HingeTree", "Rotatable bonds between rigid units.")
      .def(nb::init<const Framework&>(), "framework"_a)
      .def_prop_ro("bonds", [](const HingeTree& tree) {
        std::vector<std::int32_t> joints;
        for (const Hinge& hinge : tree.hinges())
          joints.insert(joints.end(), {hinge.inner, hinge.outer});
        return out(joints, {tree.hinges().size(), 2});
      });
}

}  // namespace ragdoll::bindings
