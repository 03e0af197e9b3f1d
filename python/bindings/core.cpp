// The Python face of core: molecules, frameworks, orders, resolvers, measures.

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "approach.h"
#include "arrays.h"
#include "conformers.h"
#include "constraints.h"
#include "ensembles.h"
#include "method.h"
#include "motions.h"
#include "quality.h"
#include "ragdoll/break.h"
#include "ragdoll/contact_list.h"
#include "ragdoll/error.h"
#include "ragdoll/framework.h"
#include "ragdoll/geometry.h"
#include "ragdoll/molecule.h"
#include "ragdoll/order.h"
#include "ragdoll/resolver.h"
#include "ragdoll/superposition.h"
#include "ragdoll/weighting.h"
#include "rigidity.h"
#include "rings.h"
#include "settings.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace ragdoll;
using namespace ragdoll::bindings;

namespace {

Molecule make_molecule(InVector<std::int32_t> elements, InVector<std::int32_t> charges,
                       InVector<double> masses, InPoints positions, InPairs bonds,
                       InVector<std::uint8_t> bond_orders, const std::vector<std::string>& labels) {
  const std::size_t n = elements.shape(0), m = bonds.shape(0);
  check_size(charges, n, "charges");
  check_size(masses, n, "masses");
  check_size(bond_orders, m, "bond_orders");
  if (!labels.empty() && labels.size() != n) throw Error("labels do not have one entry per atom");
  std::vector<Atom> atoms(n);
  for (std::size_t i = 0; i < n; ++i)
    atoms[i] = {elements(i), charges(i), masses(i), labels.empty() ? "" : labels[i]};
  std::vector<Bond> list(m);
  for (std::size_t k = 0; k < m; ++k) {
    if (bond_orders(k) > std::uint8_t(BondOrder::dative))
      throw Error("bond order " + std::to_string(bond_orders(k)) + " is none of 0 to 5");
    list[k] = {bonds(k, 0), bonds(k, 1), BondOrder(bond_orders(k))};
  }
  return Molecule(std::move(atoms), std::move(list), points_of(positions));
}

std::shared_ptr<Framework> make_framework(
    InVector<double> masses, InPairs bars, InVector<double> bar_lengths,
    std::optional<InVector<std::uint8_t>> fixed, std::optional<InPairs> tethers,
    std::optional<InVector<double>> tether_lengths, std::optional<InPairs> contacts,
    std::optional<InVector<double>> contact_lengths, const std::vector<std::string>& labels) {
  FrameworkParts parts;
  parts.masses.assign(masses.data(), masses.data() + masses.shape(0));
  if (fixed) parts.fixed.assign(fixed->data(), fixed->data() + fixed->shape(0));
  check_size(bar_lengths, bars.shape(0), "bar_lengths");
  for (std::size_t k = 0; k < bars.shape(0); ++k)
    parts.bars.push_back({bars(k, 0), bars(k, 1), bar_lengths(k), BarKind::bond});
  const auto read_pairs = [](auto& pairs, auto& list, auto& lengths, const char* name) {
    if (!list) return;
    if (!lengths) throw Error(std::string(name) + " come with their lengths");
    check_size(*lengths, list->shape(0), name);
    for (std::size_t k = 0; k < list->shape(0); ++k)
      pairs.push_back({(*list)(k, 0), (*list)(k, 1), (*lengths)(k)});
  };
  read_pairs(parts.tethers, tethers, tether_lengths, "tethers");
  read_pairs(parts.contacts, contacts, contact_lengths, "contacts");
  parts.labels = labels;
  return std::make_shared<Framework>(std::move(parts));
}

template <class T, class Get>
nb::object volume_values(const Framework& f, Get get) {
  std::vector<T> values;
  for (const Volume& v : f.volumes()) values.push_back(T(get(v)));
  return out(values);
}

nb::object volume_joints(const Framework& f) {
  std::vector<std::int32_t> joints;
  for (const Volume& v : f.volumes()) joints.insert(joints.end(), {v.a, v.b, v.c, v.d});
  return out(joints, {f.volumes().size(), 4});
}

template <class Pair>
nb::object kinds_of(const std::vector<Pair>& pairs) {
  std::vector<std::uint8_t> kinds;
  for (const Pair& pair : pairs) kinds.push_back(std::uint8_t(pair.kind));
  return out(kinds);
}

nb::object held_bond_joints(const Framework& f) {
  std::vector<std::int32_t> joints;
  for (const HeldBond& b : f.held_bonds())
    joints.insert(joints.end(), {b.donor, b.hydrogen, b.acceptor});
  return out(joints, {f.held_bonds().size(), 3});
}

/// {"bars": {"bond": 12, ...}, "tethers": ..., "contacts": ..., "volumes": ...}, zeros included.
nb::dict constraint_counts(const Framework& f) {
  const auto count = [](const auto& all, auto first, int kinds) {
    using Kind = decltype(first);
    nb::dict d;
    for (int k = 0; k < kinds; ++k) {
      const auto is_kind = [k](const auto& one) { return int(one.kind) == k; };
      d[name_of(Kind(k)).c_str()] = std::count_if(all.begin(), all.end(), is_kind);
    }
    return d;
  };
  nb::dict d;
  d["bars"] = count(f.bars(), BarKind::bond, bar_kind_count);
  d["tethers"] = count(f.tethers(), TetherKind::user, tether_kind_count);
  d["contacts"] = count(f.contacts(), ContactKind::user, contact_kind_count);
  d["volumes"] = count(f.volumes(), VolumeKind::chirality, volume_kind_count);
  d["hydrogen_bonds"] = f.held_bonds().size();
  return d;
}

/// Pairs of the contact rule that are within `skin` of their bounds.
std::size_t count_contacts(const Framework& f, InPoints positions, double skin) {
  if (f.contact_rule().empty()) return f.contacts().size();
  const std::vector<Vec3> x = points_of(positions);
  check_size(positions, std::size_t(f.joint_count()), "positions");
  ContactList list(f.contact_rule(), skin);
  list.update(x, nullptr, 0);
  return list.pairs().size() + f.contacts().size();
}

nb::dict dict_of(const GeometryReport& report) {
  nb::dict d;
  d["bond_rms"] = report.bond_rms;
  d["bond_max"] = report.bond_max;
  d["bond_max_relative"] = report.bond_max_relative;
  d["bar_max"] = report.bar_max;
  d["bar_max_relative"] = report.bar_max_relative;
  d["angle_rms_degree"] = report.angle_rms_degree;
  d["omega_max_deviation_degree"] = report.omega_max_deviation_degree;
  d["contact_violations"] = report.contact_violations;
  d["contact_worst"] = report.contact_worst;
  d["tolerance_violations"] = report.tolerance_violations;
  nb::dict tethers, contacts;
  for (int k = 0; k < tether_kind_count; ++k)
    tethers[name_of(TetherKind(k)).c_str()] = report.tether_worst[std::size_t(k)];
  for (int k = 0; k < contact_kind_count; ++k)
    contacts[name_of(ContactKind(k)).c_str()] = report.held_contact_worst[std::size_t(k)];
  d["tether_worst"] = tethers;
  d["held_contact_worst"] = contacts;
  d["chirality_inverted"] = report.chirality_inverted;
  d["planar_inverted"] = report.planar_inverted;
  d["rmsd_last"] = report.rmsd_last;
  d["rmsd_max"] = report.rmsd_max;
  d["frames"] = report.frames;
  return d;
}

void bind_framework(nb::module_& m) {
  nb::class_<Molecule>(m, "Molecule", "Atoms, bonds and starting positions, as core sees them.")
      .def(
          "__init__",
          [](Molecule* self, InVector<std::int32_t> elements, InVector<std::int32_t> charges,
             InVector<double> masses, InPoints positions, InPairs bonds,
             InVector<std::uint8_t> bond_orders, const std::vector<std::string>& labels) {
            new (self) Molecule(
                make_molecule(elements, charges, masses, positions, bonds, bond_orders, labels));
          },
          "elements"_a, "charges"_a, "masses"_a, "positions"_a, "bonds"_a, "bond_orders"_a,
          "labels"_a = std::vector<std::string>());

  nb::class_<Framework>(
      m, "Framework", "Joints and the constraints that hold them. Lengths in nm, masses in dalton.")
      .def(nb::new_(&make_framework), "masses"_a, "bars"_a, "bar_lengths"_a, "fixed"_a = nb::none(),
           "tethers"_a = nb::none(), "tether_lengths"_a = nb::none(), "contacts"_a = nb::none(),
           "contact_lengths"_a = nb::none(), "labels"_a = std::vector<std::string>(),
           "A framework from arrays: bars (nbar, 2) int32 with their lengths in nm, and so on.")
      .def_prop_ro("joint_count", &Framework::joint_count)
      .def_prop_ro("bar_count", [](const Framework& f) { return f.bars().size(); })
      .def_prop_ro("chirality_count", &Framework::chirality_count)
      .def_prop_ro(
          "class_name", [](const Framework& f) { return graph_class(f.bond_components()); },
          "Class of the largest component of the bond graph.")
      .def_prop_ro(
          "cycle_rank",
          [](const Framework& f) { return cycle_rank(f.bond_graph(), f.bond_components()); },
          "Bonds - joints + components of the bond graph.")
      .def_prop_ro("component_count",
                   [](const Framework& f) { return f.bond_components().count(); })
      .def_prop_ro("masses", [](const Framework& f) { return out(f.masses()); })
      .def_prop_ro("fixed", [](const Framework& f) { return out(f.fixed()); })
      .def_prop_ro("labels", [](const Framework& f) { return f.parts().labels; })
      .def_prop_ro(
          "bars", [](const Framework& f) { return joints_of(f.bars()); }, "(nbar, 2)")
      .def_prop_ro(
          "bar_lengths", [](const Framework& f) { return lengths_of(f.bars()); }, "nm")
      .def_prop_ro(
          "bar_kinds",
          [](const Framework& f) {
            std::vector<std::uint8_t> kinds;
            for (const Bar& bar : f.bars()) kinds.push_back(std::uint8_t(bar.kind));
            return out(kinds);
          },
          "0 bond, 1 angle, 2 planar, 3 metal, 4 user")
      .def_prop_ro("tethers", [](const Framework& f) { return joints_of(f.tethers()); })
      .def_prop_ro("tether_lengths", [](const Framework& f) { return lengths_of(f.tethers()); })
      .def_prop_ro(
          "tether_kinds", [](const Framework& f) { return kinds_of(f.tethers()); },
          "0 user, 1 hydrogen bond, 2 salt bridge, 3 hydrophobic, 4 stacking, 5 backbone")
      .def_prop_ro("contacts", [](const Framework& f) { return joints_of(f.contacts()); })
      .def_prop_ro("contact_lengths", [](const Framework& f) { return lengths_of(f.contacts()); })
      .def_prop_ro(
          "contact_kinds", [](const Framework& f) { return kinds_of(f.contacts()); },
          "0 user, 1 hydrogen bond, 2 salt bridge, 3 backbone, 4 side chain")
      .def_prop_ro("hydrogen_bonds", &held_bond_joints,
                   "Donor, hydrogen (-1: none in the molecule) and acceptor of hydrogen bonds and "
                   "salt bridges that are held, strongest first. (n, 3)")
      .def_prop_ro(
          "hydrogen_bond_energies",
          [](const Framework& f) {
            std::vector<double> energies;
            for (const HeldBond& bond : f.held_bonds()) energies.push_back(bond.energy);
            return out(energies);
          },
          "kJ/mol, at the start")
      .def_prop_ro(
          "salt_bridges",
          [](const Framework& f) {
            std::vector<std::uint8_t> salt;
            for (const HeldBond& bond : f.held_bonds()) salt.push_back(bond.salt_bridge);
            return out(salt);
          },
          "1 for each of the hydrogen bonds that is a salt bridge")
      .def("constraint_counts", &constraint_counts,
           "How many bars, tethers, contacts and volumes there are of each kind.")
      .def(
          "tightened",
          [](const Framework& f, std::optional<double> tolerance,
             std::optional<double> absolute_tolerance) {
            return std::make_shared<Framework>(
                tightened(f, tolerance_of(tolerance, absolute_tolerance)));
          },
          "tolerance"_a = nb::none(), "absolute_tolerance"_a = nb::none(),
          "With tethers and contacts tighter by the tolerance, so that what resolves it keeps the "
          "bounds of this one.")
      .def_prop_ro("volumes", &volume_joints, "(nvolume, 4)")
      .def_prop_ro(
          "volume_lower",
          [](const Framework& f) {
            return volume_values<double>(f, [](const Volume& v) { return v.lower; });
          },
          "nm^3")
      .def_prop_ro(
          "volume_upper",
          [](const Framework& f) {
            return volume_values<double>(f, [](const Volume& v) { return v.upper; });
          },
          "nm^3")
      .def_prop_ro(
          "volume_scale",
          [](const Framework& f) {
            return volume_values<double>(f, [](const Volume& v) { return v.scale; });
          },
          "nm^3")
      .def_prop_ro(
          "volume_kinds",
          [](const Framework& f) {
            return volume_values<std::uint8_t>(f, [](const Volume& v) { return v.kind; });
          },
          "0 chirality, 1 planarity")
      .def_prop_ro(
          "contact_radii", [](const Framework& f) { return out(f.contact_rule().radii); },
          "van der Waals radii, nm; empty without contacts")
      .def_prop_ro(
          "contact_polarity",
          [](const Framework& f) {
            std::vector<std::uint8_t> polarity;
            for (const Polarity p : f.contact_rule().polarity) polarity.push_back(std::uint8_t(p));
            return out(polarity);
          },
          "0 none, 1 polar heavy atom, 2 polar hydrogen")
      .def_prop_ro(
          "contact_exclusions",
          [](const Framework& f) {
            const ContactRule& rule = f.contact_rule();
            std::vector<std::int32_t> pairs;
            for (std::size_t p = 0; p + 1 < rule.exclusion_begin.size(); ++p)
              for (int k = rule.exclusion_begin[p]; k < rule.exclusion_begin[p + 1]; ++k)
                pairs.insert(pairs.end(), {int(p), rule.exclusions[std::size_t(k)]});
            return out(pairs, {pairs.size() / 2, 2});
          },
          "Pairs that no contact applies to. (n, 2)")
      .def_prop_ro(
          "close_pairs", [](const Framework& f) { return joints_of(f.contact_rule().close_pairs); },
          "Pairs that started closer than the rule allows. (n, 2)")
      .def_prop_ro(
          "close_pair_lengths",
          [](const Framework& f) { return lengths_of(f.contact_rule().close_pairs); },
          "Their bounds: the starting distances. nm")
      .def_prop_ro("contact_scale", [](const Framework& f) { return f.contact_rule().scale; })
      .def_prop_ro(
          "contact_heavy_allowance",
          [](const Framework& f) { return f.contact_rule().heavy_allowance; }, "nm")
      .def_prop_ro(
          "contact_hydrogen_allowance",
          [](const Framework& f) { return f.contact_rule().hydrogen_allowance; }, "nm")
      .def("count_contacts", &count_contacts, "positions"_a, "skin"_a = 0.12,
           "Pairs within `skin` (nm) of their lower bounds at the positions (njoint, 3).")
      .def(
          "name",
          [](const Framework& f, int joint) {
            if (joint < 0 || joint >= f.joint_count()) throw nb::index_error("no such joint");
            return f.name(joint);
          },
          "joint"_a);

  bind_constraints(m);
}

void bind_method(nb::module_& m) {
  nb::class_<Resolver>(m, "Resolver", "A solver bound to one framework.")
      .def(nb::new_([](std::shared_ptr<Framework> framework, const std::string& solver,
                       const std::string& order, const std::string& weighting,
                       std::optional<double> tolerance, std::optional<double> absolute_tolerance,
                       long max_iterations, std::uint64_t seed, const std::string& precision,
                       bool mass_weights) {
             return make_resolver(
                        std::move(framework),
                        settings_of(solver, order, weighting, tolerance, absolute_tolerance,
                                    max_iterations, seed, precision, mass_weights))
                 .release();
           }),
           "framework"_a, "solver"_a = "auto", "order"_a = "bfs_cycle", "weighting"_a = ".5/.5",
           "tolerance"_a = nb::none(), "absolute_tolerance"_a = nb::none(),
           "max_iterations"_a = ResolverSettings{}.max_iterations, "seed"_a = 0,
           "precision"_a = "double", "mass_weights"_a = false,
           "tolerance: largest relative violation, 0.001 unless given; absolute_tolerance: in its "
           "place, largest |d - L| in nm.")
      .def_prop_ro("solver", &Resolver::solver, "The solver that works: what auto chose.")
      .def(
          "resolve",
          [](Resolver& self, InPoints positions, const std::vector<int>& roots, std::uint64_t step,
             const std::optional<InPoints>& box_vectors) {
            std::vector<Vec3> x = points_of(positions);
            const std::optional<Box> box = box_of(box_vectors);
            ResolveReport report;
            {
              nb::gil_scoped_release release;
              report = self.resolve(x, {roots, step, box ? &*box : nullptr});
            }
            return nb::make_tuple(out_points(x), report_dict(report));
          },
          "positions"_a, "roots"_a = std::vector<int>(), "step"_a = 0, "box_vectors"_a = nb::none(),
          "Returns the resolved positions (njoint, 3) and a report; the input stays as it is.");

  m.def(
      "order",
      [](const Framework& f, const std::string& kind, const std::vector<int>& roots,
         std::uint64_t seed) {
        Random random(seed, RandomStream::order, 0);
        const Order order = order_of(f.graph(), order_kind(kind), roots, random);
        std::vector<std::int32_t> joints;
        std::vector<std::uint8_t> problem;
        for (const Visit& visit : order) {
          joints.insert(joints.end(), {visit.near, visit.far});
          problem.push_back(visit.problem);
        }
        return nb::make_tuple(out(joints, {order.size(), 2}), out(problem));
      },
      "framework"_a, "kind"_a, "roots"_a = std::vector<int>(), "seed"_a = 0,
      "Bars in the order of the first iteration as (near, far) joints, and which close cycles.");
  m.def("check_order", [](const std::string& name) { order_kind(name); });
  m.def("check_weighting", [](const std::string& text) { return name_of(weighting_of(text)); });
  m.def("check_precision", [](const std::string& name) { precision_of(name); });
  m.def("check_perturbation", [](const std::string& name) { perturbation_kind(name); });
  m.def("solver_names", &solver_names);

  m.def(
      "perturb",
      [](InPoints positions, const std::string& kind, double size, std::uint64_t seed,
         std::uint64_t step) {
        std::vector<Vec3> x = points_of(positions);
        const std::vector<std::uint8_t> fixed(x.size(), 0);
        Random random(seed, RandomStream::perturbation, step);
        perturb(x, fixed, perturbation_kind(kind), size, random);
        return out_points(x);
      },
      "positions"_a, "kind"_a = "gaussian", "size"_a, "seed"_a = 0, "step"_a = 0,
      "Positions moved at random; size in nm.");
}

void bind_measures(nb::module_& m) {
  nb::class_<GeometryCheck>(m, "GeometryCheck", "Measures frames against the input.")
      .def(nb::new_([](std::shared_ptr<Framework> framework, InPoints start,
                       In<std::int32_t, nb::shape<-1, 4>> omegas, std::optional<double> tolerance,
                       std::optional<double> absolute_tolerance) {
             std::vector<std::array<int, 4>> torsions;
             for (std::size_t k = 0; k < omegas.shape(0); ++k)
               torsions.push_back({omegas(k, 0), omegas(k, 1), omegas(k, 2), omegas(k, 3)});
             return new GeometryCheck(std::move(framework), points_of(start), std::move(torsions),
                                      tolerance_of(tolerance, absolute_tolerance));
           }),
           "framework"_a, "start"_a, "omegas"_a, "tolerance"_a = nb::none(),
           "absolute_tolerance"_a = nb::none(), "tolerance: relative; absolute_tolerance: nm.")
      .def(
          "add",
          [](GeometryCheck& self, InPoints frame, const std::optional<InPoints>& box_vectors) {
            const std::vector<Vec3> x = points_of(frame);
            const std::optional<Box> box = box_of(box_vectors);
            nb::gil_scoped_release release;
            self.add(x, box ? &*box : nullptr);
          },
          "frame"_a, "box_vectors"_a = nb::none())
      .def("report", [](const GeometryCheck& self) { return dict_of(self.report()); });

  m.def(
      "superposed_rmsd",
      [](InPoints a, InPoints b) { return superposed_rmsd(points_of(a), points_of(b)); }, "a"_a,
      "b"_a, "Least RMSD over rotations and translations, nm.");
  m.def(
      "worst_violation",
      [](const Framework& f, InPoints positions, const std::optional<InPoints>& box_vectors,
         bool absolute) {
        check_size(positions, std::size_t(f.joint_count()), "positions");
        const std::optional<Box> box = box_of(box_vectors);
        const Tolerance measure = absolute ? Tolerance::nanometers(1) : Tolerance(1);
        const Violation worst =
            worst_violation(f, points_of(positions), box ? &*box : nullptr, measure);
        return std::make_pair(absolute ? worst.nanometers : worst.relative, worst.what);
      },
      "framework"_a, "positions"_a, "box_vectors"_a = nb::none(), "absolute"_a = false,
      "Largest violation of any constraint, and its description; relative, or in nm if absolute.");
  m.def(
      "inverted_centres",
      [](const Framework& f, InPoints positions) {
        check_size(positions, std::size_t(f.joint_count()), "positions");
        return inverted_centres(f, points_of(positions));
      },
      "framework"_a, "positions"_a, "Chirality centres of the wrong sign.");
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The C++ core of ragdoll.";
  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const ragdoll::Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  bind_framework(m);
  bind_method(m);
  bind_measures(m);
  bind_method_tools(m);
  bind_motions(m);
  bind_approach(m);
  bind_conformers(m);
  bind_ensembles(m);
  bind_quality(m);
  bind_rigidity(m);
  bind_rings(m);
}
