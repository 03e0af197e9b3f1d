// The Python face of core's rigidity: hydrogen bonds, tethers, networks, dilution.

#include "rigidity.h"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "arrays.h"
#include "ragdoll/bond_network.h"
#include "ragdoll/dilution.h"
#include "ragdoll/error.h"
#include "ragdoll/hinge_groups.h"
#include "ragdoll/hydrogen_bonds.h"
#include "ragdoll/hydrophobic_tethers.h"
#include "ragdoll/rigidity.h"

namespace ragdoll::bindings {

using namespace nb::literals;

namespace {

constexpr const char* lock_names[bond_lock_count] = {"none",     "peptide",  "guanidinium",
                                                     "multiple", "aromatic", "primary_amide"};

using Indices = std::vector<std::int32_t>;

/// One value of each entry of a list.
template <class T, class List, class Get>
nb::object column(const List& list, Get get) {
  std::vector<T> values;
  values.reserve(list.size());
  for (const auto& entry : list) values.push_back(T(get(entry)));
  return out(values);
}

nb::dict find_hydrogen_bonds(const Molecule& molecule, double weakest, double hydrogen_acceptor,
                             double donor_acceptor, double least_angle_degree) {
  HydrogenBondOptions options;
  options.weakest = weakest;
  options.usual = {hydrogen_acceptor, donor_acceptor};
  options.least_angle_degree = least_angle_degree;
  std::vector<HydrogenBond> bonds;
  {
    nb::gil_scoped_release release;
    bonds = hydrogen_bonds(molecule, options);
  }
  Indices atoms;
  for (const HydrogenBond& b : bonds) atoms.insert(atoms.end(), {b.donor, b.hydrogen, b.acceptor});
  nb::dict d;
  d["atoms"] = out(atoms, {bonds.size(), 3});
  d["energies"] = column<double>(bonds, [](const auto& b) { return b.energy; });
  d["salt_bridge"] = column<std::uint8_t>(bonds, [](const auto& b) { return b.salt_bridge; });
  d["hydrogen_acceptor"] = column<double>(bonds, [](const auto& b) { return b.hydrogen_acceptor; });
  d["donor_acceptor"] = column<double>(bonds, [](const auto& b) { return b.donor_acceptor; });
  d["angles_degree"] = column<double>(bonds, [](const auto& b) { return b.angle_degree; });
  return d;
}

nb::dict find_tethers(const Molecule& molecule, double margin, double shortest) {
  std::vector<HydrophobicTether> tethers;
  {
    nb::gil_scoped_release release;
    tethers = hydrophobic_tethers(molecule, {margin, shortest});
  }
  Indices atoms;
  for (const HydrophobicTether& t : tethers) atoms.insert(atoms.end(), {t.a, t.b});
  nb::dict d;
  d["atoms"] = out(atoms, {tethers.size(), 2});
  d["distances"] = column<double>(tethers, [](const auto& t) { return t.distance; });
  d["bounds"] = column<double>(tethers, [](const auto& t) { return t.bound; });
  return d;
}

/// Bodies, bonds and bars as arrays, in the order of BondNetwork.
nb::dict make_bond_network(const Molecule& molecule, InPairs tethers, InPairs hydrogen_bonds,
                           const std::vector<std::string>& locks, int hydrogen_bond_bars,
                           int tether_bars) {
  std::vector<HydrophobicTether> tether_list(tethers.shape(0));
  for (std::size_t k = 0; k < tether_list.size(); ++k) {
    tether_list[k].a = tethers(k, 0);
    tether_list[k].b = tethers(k, 1);
  }
  std::vector<HydrogenBond> bond_list(hydrogen_bonds.shape(0));
  for (std::size_t k = 0; k < bond_list.size(); ++k) {
    bond_list[k].hydrogen = hydrogen_bonds(k, 0);
    bond_list[k].acceptor = hydrogen_bonds(k, 1);
  }
  BondNetworkOptions options;
  options.hydrogen_bond_bars = hydrogen_bond_bars;
  options.tether_bars = tether_bars;
  for (bool& lock : options.locks) lock = false;
  for (const std::string& name : locks) {
    int k = 1;
    while (k < bond_lock_count && name != lock_names[k]) ++k;
    if (k == bond_lock_count)
      throw Error("there is no lock '" + name +
                  "'; locks are peptide, guanidinium, multiple, aromatic and primary_amide");
    options.locks[k] = true;
  }
  const BondNetwork built = build_bond_network(molecule, tether_list, bond_list, options);
  Indices ends, bars;
  for (const BodyBond& bond : built.network.bonds) {
    ends.insert(ends.end(), {bond.a, bond.b});
    bars.push_back(bond.bars);
  }
  nb::dict d;
  d["bodies"] = built.network.bodies;
  d["ends"] = out(ends, {bars.size(), 2});
  d["bars"] = out(bars);
  d["covalent_bonds"] = built.covalent_bonds;
  d["locked_bonds"] = built.locked_bonds;
  return d;
}

/// A dilution and its network, for the hinge groups of a level.
class NetworkDilution {
 public:
  NetworkDilution(int bodies, InPairs ends, InVector<std::int32_t> bars, int fixed_bonds,
                  bool lock_leaves)
      : network_(read(bodies, ends, bars, lock_leaves)),
        fixed_bonds_(fixed_bonds),
        dilution_(make()) {}

  int level_count() const { return dilution_.level_count(); }

  nb::dict at(int level, bool groups) const {
    Rigidity r;
    std::vector<HingeGroup> found;
    {
      nb::gil_scoped_release release;
      r = dilution_.at(level);
      if (groups) {
        BodyBarNetwork present = network_;
        present.bonds.resize(std::size_t(fixed_bonds_ + level));
        found = hinge_groups(present, r);
      }
    }
    nb::dict d;
    d["degrees_of_freedom"] = r.degrees_of_freedom;
    d["floppy_modes"] = r.floppy_modes;
    d["separate_bodies"] = r.separate_bodies;
    d["redundant_bars"] = r.redundant_bars;
    d["cluster_of_body"] = out(Indices(r.cluster_of_body.begin(), r.cluster_of_body.end()));
    d["cluster_sizes"] = out(Indices(r.cluster_sizes.begin(), r.cluster_sizes.end()));
    d["region_of_body"] = out(Indices(r.region_of_body.begin(), r.region_of_body.end()));
    d["region_sizes"] = out(Indices(r.region_sizes.begin(), r.region_sizes.end()));
    d["hinges"] = out(Indices(r.hinges.begin(), r.hinges.end()));
    nb::list list;
    for (const HingeGroup& group : found)
      list.append(
          nb::make_tuple(group.freedom, out(Indices(group.hinges.begin(), group.hinges.end()))));
    d["hinge_groups"] = list;
    return d;
  }

 private:
  static BodyBarNetwork read(int bodies, const InPairs& ends, const InVector<std::int32_t>& bars,
                             bool lock_leaves) {
    check_size(bars, ends.shape(0), "bars");
    BodyBarNetwork network;
    network.bodies = bodies;
    network.lock_leaves = lock_leaves;
    for (std::size_t k = 0; k < ends.shape(0); ++k)
      network.bonds.push_back({ends(k, 0), ends(k, 1), bars(k)});
    return network;
  }

  Dilution make() const {
    nb::gil_scoped_release release;
    return Dilution(network_, fixed_bonds_);
  }

  BodyBarNetwork network_;
  int fixed_bonds_;
  Dilution dilution_;
};

}  // namespace

void bind_rigidity(nb::module_& m) {
  m.attr("KILOJOULE_PER_KILOCALORIE") = kilojoule_per_kilocalorie;
  m.def("hydrogen_bonds", &find_hydrogen_bonds, "molecule"_a, nb::kw_only(), "weakest"_a,
        "hydrogen_acceptor"_a, "donor_acceptor"_a, "least_angle_degree"_a,
        "Hydrogen bonds and salt bridges, strongest first; kJ/mol and nm.");
  m.def("hydrophobic_tethers", &find_tethers, "molecule"_a, nb::kw_only(), "margin"_a, "shortest"_a,
        "Non-polar pairs that touch; nm.");
  m.def("bond_network", &make_bond_network, "molecule"_a, "tethers"_a, "hydrogen_bonds"_a,
        nb::kw_only(), "locks"_a, "hydrogen_bond_bars"_a, "tether_bars"_a,
        "Covalent bonds, then tethers, then hydrogen bonds, with the bars of each.");
  nb::class_<NetworkDilution>(m, "Dilution", "The rigidity of a network by number of bonds.")
      .def(nb::init<int, InPairs, InVector<std::int32_t>, int, bool>(), "bodies"_a, "ends"_a,
           "bars"_a, "fixed_bonds"_a, "lock_leaves"_a)
      .def_prop_ro("level_count", &NetworkDilution::level_count)
      .def("at", &NetworkDilution::at, "level"_a, "groups"_a = false);
}

}  // namespace ragdoll::bindings
