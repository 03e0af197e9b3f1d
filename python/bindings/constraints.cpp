#include "constraints.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "ragdoll/build_framework.h"
#include "ragdoll/error.h"
#include "ragdoll/framework.h"
#include "ragdoll/place_hydrogens.h"
#include "settings.h"

namespace ragdoll::bindings {

using namespace nb::literals;

namespace {

template <class Pair>
std::vector<Pair> pairs_of(const InPairs& pairs, const InVector<double>& lengths) {
  check_size(lengths, pairs.shape(0), "lengths");
  std::vector<Pair> list(pairs.shape(0));
  for (std::size_t k = 0; k < list.size(); ++k) {
    list[k].p = pairs(k, 0);
    list[k].q = pairs(k, 1);
    list[k].length = lengths(k);
  }
  return list;
}

TorsionRegion region_of(const std::string& name) {
  if (name == "basin") return TorsionRegion::basin;
  if (name == "joined") return TorsionRegion::joined;
  throw Error("torsion region '" + name + "' is not known; choose one of: basin, joined");
}

}  // namespace

void bind_constraints(nb::module_& m) {
  nb::class_<ConstraintOptions>(m, "ConstraintOptions",
                                "What holds a framework beside covalent bonds. Lengths in nm, "
                                "energies in kJ/mol; what is not set has core's defaults.")
      .def(nb::init<>())
      .def_rw("hydrogen_bonds", &ConstraintOptions::hydrogen_bonds)
      .def_prop_rw(
          "hydrogen_bond_weakest",
          [](const ConstraintOptions& o) { return o.hydrogen_bond.weakest; },
          [](ConstraintOptions& o, double weakest) { o.hydrogen_bond.weakest = weakest; })
      .def(
          "set_hydrogen_bond_reach",
          [](ConstraintOptions& o, double hydrogen_acceptor, double donor_acceptor) {
            o.hydrogen_bond.usual = {hydrogen_acceptor, donor_acceptor};
          },
          "hydrogen_acceptor"_a, "donor_acceptor"_a)
      .def_prop_rw(
          "hydrogen_bond_angle_degree",
          [](const ConstraintOptions& o) { return o.hydrogen_bond.least_angle_degree; },
          [](ConstraintOptions& o, double angle) { o.hydrogen_bond.least_angle_degree = angle; })
      .def_rw("hydrogen_bond_room", &ConstraintOptions::hydrogen_bond_room)
      .def_rw("place_hydrogens", &ConstraintOptions::place_hydrogens)
      .def_rw("solvent_hydrogen_bonds", &ConstraintOptions::solvent_hydrogen_bonds)
      .def_rw("hydrophobic", &ConstraintOptions::hydrophobic)
      .def_prop_rw(
          "hydrophobic_margin",
          [](const ConstraintOptions& o) { return o.hydrophobic_tether.margin; },
          [](ConstraintOptions& o, double margin) { o.hydrophobic_tether.margin = margin; })
      .def_rw("stacking", &ConstraintOptions::stacking)
      .def_prop_rw(
          "stacking_distance", [](const ConstraintOptions& o) { return o.stacked_ring.distance; },
          [](ConstraintOptions& o, double distance) { o.stacked_ring.distance = distance; })
      .def_prop_rw(
          "stacking_angle_degree",
          [](const ConstraintOptions& o) { return o.stacked_ring.angle_degree; },
          [](ConstraintOptions& o, double angle) { o.stacked_ring.angle_degree = angle; })
      .def_prop_rw(
          "stacking_margin", [](const ConstraintOptions& o) { return o.stacked_ring.margin; },
          [](ConstraintOptions& o, double margin) { o.stacked_ring.margin = margin; })
      .def_rw("metals", &ConstraintOptions::metals)
      .def_rw("metal_slack", &ConstraintOptions::metal_slack)
      .def_rw("torsion_basins", &ConstraintOptions::torsion_basins)
      .def(
          "set_torsion_region",
          [](ConstraintOptions& o, const std::string& name) { o.torsion_region = region_of(name); },
          "name"_a)
      .def_rw("staggered", &ConstraintOptions::staggered)
      .def_rw("eclipsed_degree", &ConstraintOptions::eclipsed_degree)
      .def(
          "set_coordination",
          [](ConstraintOptions& o, const InPairs& pairs) {
            o.coordination.clear();
            for (std::size_t k = 0; k < pairs.shape(0); ++k)
              o.coordination.push_back({pairs(k, 0), pairs(k, 1), 0, BarKind::metal});
          },
          "pairs"_a, "(n, 2) further bonds of metals, at their present distances.")
      .def(
          "set_bars",
          [](ConstraintOptions& o, const InPairs& pairs, const InVector<double>& lengths) {
            o.bars = pairs_of<Bar>(pairs, lengths);
          },
          "pairs"_a, "lengths"_a, "(n, 2) atoms and (n) lengths; 0: the present distance.")
      .def(
          "set_tethers",
          [](ConstraintOptions& o, const InPairs& pairs, const InVector<double>& lengths) {
            o.tethers = pairs_of<Tether>(pairs, lengths);
          },
          "pairs"_a, "lengths"_a)
      .def(
          "set_contacts",
          [](ConstraintOptions& o, const InPairs& pairs, const InVector<double>& lengths) {
            o.contacts = pairs_of<Contact>(pairs, lengths);
          },
          "pairs"_a, "lengths"_a)
      .def(
          "add_conformation",
          [](ConstraintOptions& o, const InPoints& positions) {
            o.conformations.push_back(points_of(positions));
          },
          "positions"_a, "(natom, 3) nm that the constraints have to allow.")
      .def_rw("fixed", &ConstraintOptions::fixed);

  m.def(
      "place_hydrogens",
      [](const Molecule& molecule) {
        const Molecule placed = place_hydrogens(molecule);
        const std::size_t before = molecule.atoms().size(), bonds = molecule.bonds().size();
        std::vector<std::int32_t> parents;
        for (std::size_t k = bonds; k < placed.bonds().size(); ++k)
          parents.push_back(placed.bonds()[k].a);
        const auto& x = placed.positions();
        return nb::make_tuple(out(parents), out_points(std::vector<Vec3>(
                                                x.begin() + std::ptrdiff_t(before), x.end())));
      },
      "molecule"_a,
      "Hydrogens of N, O and S that the molecule lacks: the atoms that bear them, (n), and their "
      "places, (n, 3) nm.");

  m.def(
      "build_framework",
      [](const Molecule& molecule, bool contacts, double contact_scale, double heavy_allowance,
         double hydrogen_allowance, double planarity_degree,
         const std::optional<ConstraintOptions>& constraints,
         const std::optional<InPoints>& box_vectors) {
        const FrameworkOptions options{contacts,           contact_scale,    heavy_allowance,
                                       hydrogen_allowance, planarity_degree, constraints};
        const std::optional<Box> box = box_of(box_vectors);
        nb::gil_scoped_release release;
        return std::make_shared<Framework>(
            build_framework(molecule, options, box ? &*box : nullptr));
      },
      "molecule"_a, "contacts"_a = true, "contact_scale"_a = FrameworkOptions{}.contact_scale,
      "heavy_allowance"_a = FrameworkOptions{}.heavy_allowance,
      "hydrogen_allowance"_a = FrameworkOptions{}.hydrogen_allowance,
      "planarity_degree"_a = FrameworkOptions{}.planarity_degree, "constraints"_a = nb::none(),
      "box_vectors"_a = nb::none());
}

}  // namespace ragdoll::bindings
