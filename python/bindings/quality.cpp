#include "quality.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <memory>
#include <utility>  // move

#include "arrays.h"
#include "ragdoll/quality.h"
#include "ragdoll/quality_limits.h"
#include "settings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace ragdoll::bindings {
namespace {

template <std::size_t Width>
using InRows = In<std::int32_t, nb::shape<-1, nb::ssize_t(Width)>>;
using InValues = In<double, nb::shape<-1, 2>>;
using InFrames = In<double, nb::shape<-1, -1, 3>>;

template <std::size_t Width>
std::vector<std::array<int, Width>> rows_of(const InRows<Width>& array) {
  std::vector<std::array<int, Width>> rows(array.shape(0));
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t i = 0; i < Width; ++i) rows[k][i] = array(k, i);
  return rows;
}

std::shared_ptr<QualityCheck> make_check(
    const Molecule& molecule, const InRows<2>& ideal_bonds, const InValues& ideal_bond_values,
    const InRows<3>& ideal_angles, const InValues& ideal_angle_values, const InRows<4>& omegas,
    const InRows<5>& backbones, const InVector<std::int32_t>& alphas,
    const std::optional<InVector<double>>& ramachandran, double core, double allowed,
    const InPairs& bounds, const InVector<double>& bound_lengths,
    const InVector<std::int32_t>& bound_groups, int groups) {
  check_size(ideal_bond_values, ideal_bonds.shape(0), "ideal_bond_values");
  check_size(ideal_angle_values, ideal_angles.shape(0), "ideal_angle_values");
  check_size(bound_lengths, bounds.shape(0), "bound_lengths");
  check_size(bound_groups, bounds.shape(0), "bound_groups");
  QualityTerms terms;
  for (std::size_t k = 0; k < ideal_bonds.shape(0); ++k)
    terms.ideal_bonds.push_back(
        {ideal_bonds(k, 0), ideal_bonds(k, 1), ideal_bond_values(k, 0), ideal_bond_values(k, 1)});
  for (std::size_t k = 0; k < ideal_angles.shape(0); ++k)
    terms.ideal_angles.push_back({ideal_angles(k, 0), ideal_angles(k, 1), ideal_angles(k, 2),
                                  ideal_angle_values(k, 0), ideal_angle_values(k, 1)});
  terms.omegas = rows_of<4>(omegas);
  terms.backbones = rows_of<5>(backbones);
  terms.alphas.assign(alphas.data(), alphas.data() + alphas.shape(0));
  if (ramachandran)
    terms.ramachandran.emplace(
        std::vector<double>(ramachandran->data(), ramachandran->data() + ramachandran->shape(0)),
        core, allowed);
  for (std::size_t k = 0; k < bounds.shape(0); ++k)
    terms.bounds.push_back({bounds(k, 0), bounds(k, 1), bound_lengths(k), bound_groups(k)});
  terms.groups = groups;
  return std::make_shared<QualityCheck>(molecule, std::move(terms));
}

/// One number of each frame, of any type, as an array.
template <class T, class Get>
nb::object column(const std::vector<FrameQuality>& frames, Get get) {
  std::vector<T> values;
  values.reserve(frames.size());
  for (const FrameQuality& frame : frames) values.push_back(T(get(frame)));
  return out(values);
}

nb::dict columns(const std::vector<FrameQuality>& frames, int groups) {
  nb::dict d;
  const auto add = [&](const char* name, auto member) {
    using Value = std::remove_cvref_t<decltype(std::declval<FrameQuality>().*member)>;
    d[name] = column<Value>(frames, [member](const FrameQuality& f) { return f.*member; });
  };
  add("bond_rms", &FrameQuality::bond_rms);
  add("bond_max", &FrameQuality::bond_max);
  add("angle_rms", &FrameQuality::angle_rms);
  add("angle_max", &FrameQuality::angle_max);
  add("bond_rmsz", &FrameQuality::bond_rmsz);
  add("angle_rmsz", &FrameQuality::angle_rmsz);
  add("clashes", &FrameQuality::clashes);
  add("clash_worst", &FrameQuality::clash_worst);
  add("all_atom_clashes", &FrameQuality::all_atom_clashes);
  add("core", &FrameQuality::core);
  add("outliers", &FrameQuality::outliers);
  add("omega_rms", &FrameQuality::omega_rms);
  add("omega_max", &FrameQuality::omega_max);
  add("omegas_off", &FrameQuality::omegas_off);
  add("alphas_inverted", &FrameQuality::alphas_inverted);
  add("centres_inverted", &FrameQuality::centres_inverted);
  std::vector<double> excess;
  for (const FrameQuality& frame : frames)
    excess.insert(excess.end(), frame.excess.begin(), frame.excess.end());
  d["excess"] = out(excess, {frames.size(), std::size_t(groups)});
  return d;
}

nb::dict measure(const QualityCheck& self, const InFrames& frames,
                 const std::optional<InPoints>& box_vectors) {
  const std::size_t atoms = frames.shape(1);
  const std::optional<Box> box = box_of(box_vectors);
  std::vector<FrameQuality> measured;
  {
    const nb::gil_scoped_release release;
    std::vector<Vec3> x(atoms);
    const double* from = frames.data();
    for (std::size_t k = 0; k < frames.shape(0); ++k) {
      for (Vec3& point : x) {
        point = Vec3(from[0], from[1], from[2]);
        from += 3;
      }
      measured.push_back(self.measure(x, box ? &*box : nullptr));
    }
  }
  return columns(measured, self.terms().groups);
}

}  // namespace

void bind_quality(nb::module_& m) {
  nb::class_<QualityCheck>(m, "QualityCheck",
                           "Measures frames of a molecule: stereochemistry, clashes, backbone.")
      .def(nb::new_(&make_check), "molecule"_a, nb::kw_only(), "ideal_bonds"_a,
           "ideal_bond_values"_a, "ideal_angles"_a, "ideal_angle_values"_a, "omegas"_a,
           "backbones"_a, "alphas"_a, "ramachandran"_a = nb::none(), "core"_a = 0, "allowed"_a = 0,
           "bounds"_a, "bound_lengths"_a, "bound_groups"_a, "groups"_a,
           "Values are (n, 2): the mean (nm or degree) and its deviation. ramachandran: densities "
           "of a\nsquare grid, row by row, a row for each psi.")
      .def_prop_ro("heavy_count", &QualityCheck::heavy_count)
      .def_prop_ro("centre_count", &QualityCheck::centre_count)
      .def("measure", &measure, "frames"_a, "box_vectors"_a = nb::none(),
           "Of frames (n, natom, 3; nm): a dict of arrays (n,), and excess (n, groups); lengths in "
           "nm, angles in degrees.");

  nb::class_<QualityJudge>(m, "QualityJudge", "Judges frames by limits.")
      .def(nb::new_([](std::shared_ptr<QualityCheck> check, double bond_rms, double angle_rms,
                       double clash_growth, double outlier_growth, double omega_growth,
                       double inverted_centres, double core_loss, double excess) {
             return std::make_shared<QualityJudge>(
                 std::move(check),
                 QualityLimits{bond_rms, angle_rms, clash_growth, outlier_growth, omega_growth,
                               inverted_centres, core_loss, excess});
           }),
           "check"_a, nb::kw_only(), "bond_rms"_a = QualityLimits::none,
           "angle_rms"_a = QualityLimits::none, "clash_growth"_a = QualityLimits::none,
           "outlier_growth"_a = QualityLimits::none, "omega_growth"_a = QualityLimits::none,
           "inverted_centres"_a = QualityLimits::none, "core_loss"_a = QualityLimits::none,
           "excess"_a = QualityLimits::none)
      .def(
          "fault",
          [](const QualityJudge& self, const InPoints& frame,
             const std::optional<InPoints>& box_vectors) {
            const std::vector<Vec3> x = points_of(frame);
            const std::optional<Box> box = box_of(box_vectors);
            const nb::gil_scoped_release release;
            QualityFault fault = self.fault(x, box ? &*box : nullptr);
            return std::make_pair(std::move(fault.measure), std::move(fault.words));
          },
          "frame"_a, "box_vectors"_a = nb::none(),
          "Why a frame (natom, 3; nm), rounded to single precision, is below the limits: the "
          "measure "
          "and\nwords; both are empty where it is not.");
}

}  // namespace ragdoll::bindings
