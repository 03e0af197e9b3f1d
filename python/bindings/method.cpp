// The Python face of the method's tools: structures, forces, generators, classification, force
// runs, statistics.

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>  // minmax, sort, lower_bound
#include <memory>
#include <optional>
#include <tuple>

#include "arrays.h"
#include "method.h"
#include "ragdoll/classify.h"
#include "ragdoll/error.h"
#include "ragdoll/force_run.h"
#include "ragdoll/generate.h"
#include "ragdoll/statistics.h"
#include "ragdoll/structure.h"
#include "settings.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace ragdoll;
using namespace ragdoll::bindings;

namespace {

// === Structures

template <class Pair>
void read_pairs(std::vector<Pair>& pairs, const std::optional<InPairs>& joints,
                const std::optional<InVector<double>>& lengths, const char* name) {
  if (!joints) return;
  if (!lengths) throw Error(std::string(name) + " come with their lengths");
  check_size(*lengths, joints->shape(0), name);
  for (std::size_t k = 0; k < joints->shape(0); ++k)
    pairs.push_back({(*joints)(k, 0), (*joints)(k, 1), (*lengths)(k)});
}

std::vector<double> present_lengths(const std::vector<Vec3>& positions, const InPairs& bars) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < bars.shape(0); ++k) {
    const int p = bars(k, 0), q = bars(k, 1);
    if (std::min(p, q) < 0 || std::size_t(std::max(p, q)) >= positions.size())
      throw Error("bar " + std::to_string(k) + " names a joint that does not exist");
    lengths.push_back((positions[std::size_t(q)] - positions[std::size_t(p)]).norm());
  }
  return lengths;
}

Structure make_structure(std::vector<std::string> ids, InPoints positions, InPairs bars,
                         const std::optional<InVector<double>>& bar_lengths,
                         const std::optional<InVector<double>>& masses,
                         const std::optional<InVector<std::uint8_t>>& fixed,
                         const std::optional<InPairs>& tethers,
                         const std::optional<InVector<double>>& tether_lengths,
                         const std::optional<InPairs>& contacts,
                         const std::optional<InVector<double>>& contact_lengths,
                         const std::string& length_unit, const std::string& class_name,
                         const std::string& type) {
  Structure s;
  s.ids = std::move(ids);
  s.positions = points_of(positions);
  const std::size_t n = s.positions.size();
  if (s.ids.size() != n) throw Error("ids do not have one entry for each joint");
  s.parts.masses.assign(n, 1);
  s.parts.fixed.assign(n, 0);
  if (masses) {
    check_size(*masses, n, "masses");
    s.parts.masses.assign(masses->data(), masses->data() + n);
  }
  if (fixed) {
    check_size(*fixed, n, "fixed");
    s.parts.fixed.assign(fixed->data(), fixed->data() + n);
  }
  std::vector<double> lengths;
  if (bar_lengths) {
    check_size(*bar_lengths, bars.shape(0), "bar_lengths");
    lengths.assign(bar_lengths->data(), bar_lengths->data() + bars.shape(0));
  } else {
    lengths = present_lengths(s.positions, bars);
  }
  for (std::size_t k = 0; k < bars.shape(0); ++k)
    s.parts.bars.push_back({bars(k, 0), bars(k, 1), lengths[k]});
  read_pairs(s.parts.tethers, tethers, tether_lengths, "tethers");
  read_pairs(s.parts.contacts, contacts, contact_lengths, "contacts");
  s.length_unit = length_unit;
  s.class_name = class_name;
  s.type = type;
  framework_of(s);  // refuses what no framework can be made of
  return s;
}

void bind_structure(nb::module_& m) {
  nb::class_<Structure>(m, "Structure",
                        "Joints with names and positions, and the bars, tethers and contacts "
                        "between them.")
      .def(
          "__init__",
          [](Structure* self, std::vector<std::string> ids, InPoints positions, InPairs bars,
             std::optional<InVector<double>> bar_lengths, std::optional<InVector<double>> masses,
             std::optional<InVector<std::uint8_t>> fixed, std::optional<InPairs> tethers,
             std::optional<InVector<double>> tether_lengths, std::optional<InPairs> contacts,
             std::optional<InVector<double>> contact_lengths, const std::string& length_unit,
             const std::string& class_name, const std::string& type) {
            new (self) Structure(make_structure(std::move(ids), positions, bars, bar_lengths,
                                                masses, fixed, tethers, tether_lengths, contacts,
                                                contact_lengths, length_unit, class_name, type));
          },
          "ids"_a, "positions"_a, "bars"_a, "bar_lengths"_a = nb::none(), "masses"_a = nb::none(),
          "fixed"_a = nb::none(), "tethers"_a = nb::none(), "tether_lengths"_a = nb::none(),
          "contacts"_a = nb::none(), "contact_lengths"_a = nb::none(), "length_unit"_a = "none",
          "class_name"_a = "", "type"_a = "",
          "Bars without lengths have their present ones; joints without masses 1.")
      .def_ro("ids", &Structure::ids)
      .def_prop_ro(
          "positions", [](const Structure& s) { return out_points(s.positions); }, "(njoint, 3)")
      .def_prop_ro("masses", [](const Structure& s) { return out(s.parts.masses); })
      .def_prop_ro(
          "fixed",
          [](const Structure& s) {
            std::vector<std::uint8_t> fixed = s.parts.fixed;
            fixed.resize(s.positions.size(), 0);
            return out(fixed);
          },
          "1 = pinned (njoint)")
      .def_prop_ro(
          "bars", [](const Structure& s) { return joints_of(s.parts.bars); }, "(nbar, 2)")
      .def_prop_ro("bar_lengths", [](const Structure& s) { return lengths_of(s.parts.bars); })
      .def_prop_ro("tethers", [](const Structure& s) { return joints_of(s.parts.tethers); })
      .def_prop_ro("tether_lengths", [](const Structure& s) { return lengths_of(s.parts.tethers); })
      .def_prop_ro("contacts", [](const Structure& s) { return joints_of(s.parts.contacts); })
      .def_prop_ro("contact_lengths",
                   [](const Structure& s) { return lengths_of(s.parts.contacts); })
      .def_ro("length_unit", &Structure::length_unit)
      .def_rw("class_name", &Structure::class_name)
      .def_rw("type", &Structure::type)
      .def_prop_ro("joint_count", [](const Structure& s) { return s.positions.size(); })
      .def_prop_ro("bar_count", [](const Structure& s) { return s.parts.bars.size(); })
      .def(
          "framework",
          [](const Structure& s) { return std::const_pointer_cast<Framework>(framework_of(s)); },
          "Its framework; the ids are the labels.")
      .def(
          "moved",
          [](const Structure& s, InPoints positions) {
            check_size(positions, s.positions.size(), "positions");
            Structure copy = s;
            copy.positions = points_of(positions);
            return copy;
          },
          "positions"_a, "The same structure elsewhere: lengths of bars stay.");

  nb::class_<ForceSet>(m, "ForceSet", "Forces, one step each, and how they are resolved.")
      .def(
          "__init__",
          [](ForceSet* self, InVector<std::int32_t> joints, InPoints forces, long max_iterations,
             double tolerance, double timestep, const std::string& structure) {
            check_size(joints, forces.shape(0), "joints");
            const std::vector<Vec3> vectors = points_of(forces);
            ForceSet set;
            for (std::size_t k = 0; k < vectors.size(); ++k)
              set.forces.push_back({joints(k), vectors[k]});
            set.max_iterations = max_iterations;
            set.tolerance = tolerance;
            set.timestep = timestep;
            set.structure = structure;
            new (self) ForceSet(std::move(set));
          },
          "joints"_a, "forces"_a, "max_iterations"_a = ForceSet{}.max_iterations,
          "tolerance"_a = ForceSet{}.tolerance, "timestep"_a = ForceSet{}.timestep,
          "structure"_a = "")
      .def_prop_ro(
          "joints",
          [](const ForceSet& set) {
            std::vector<std::int32_t> joints;
            for (const Force& force : set.forces) joints.push_back(force.joint);
            return out(joints);
          },
          "(nforce)")
      .def_prop_ro(
          "forces",
          [](const ForceSet& set) {
            std::vector<Vec3> vectors;
            for (const Force& force : set.forces) vectors.push_back(force.force);
            return out_points(vectors);
          },
          "(nforce, 3)")
      .def("__len__", [](const ForceSet& set) { return set.forces.size(); })
      .def_rw("max_iterations", &ForceSet::max_iterations)
      .def_rw("tolerance", &ForceSet::tolerance, "relative")
      .def_rw("timestep", &ForceSet::timestep)
      .def_rw("structure", &ForceSet::structure, "File they are meant for; empty: any.");
}

// === Generators and classification

void bind_generators(nb::module_& m) {
  m.def("structure_classes", &structure_classes);
  m.def(
      "generate_structure",
      [](const std::string& class_name, const std::string& type, int cycles, int joints,
         std::uint64_t seed, std::uint64_t index, const std::string& construction, int depth,
         int children, int dimensions, int degree) {
        const StructureRequest request{class_name, type,       construction, cycles, joints, depth,
                                       children,   dimensions, degree,       seed,   index};
        nb::gil_scoped_release release;
        return generate_structure(request);
      },
      "class_name"_a, "type"_a = "", "cycles"_a = 0, "joints"_a = StructureRequest{}.joints,
      "seed"_a = 0, "index"_a = 0, "construction"_a = "", "depth"_a = 0, "children"_a = 0,
      "dimensions"_a = 0, "degree"_a = 0,
      "A random structure; what is 0 or empty is left to the seed. `index`: which one of a set.");
  m.def(
      "structure_of", [](const Molecule& molecule) { return structure_of(molecule); }, "molecule"_a,
      "A joint for each atom, a bar for each bond; lengths in nm.");
  m.def(
      "generate_forces",
      [](const Structure& structure, int count, double lo, double hi, std::uint64_t seed,
         std::uint64_t index) {
        nb::gil_scoped_release release;
        return generate_forces(structure, {count, lo, hi, seed, index});
      },
      "structure"_a, "count"_a = ForceRequest{}.count, "lo"_a = ForceRequest{}.lo,
      "hi"_a = ForceRequest{}.hi, "seed"_a = 0, "index"_a = 0,
      "Random forces; lo and hi are mean bar lengths. `index`: which set of them.");
}

/// First and second joints of bars. (n, 2)
nb::object ends_of(const Graph& graph, const std::vector<int>& bars) {
  std::vector<std::int32_t> ends;
  ends.reserve(2 * bars.size());
  for (const int bar : bars) {
    ends.push_back(graph.ends(bar).first);
    ends.push_back(graph.ends(bar).second);
  }
  return out(ends, {bars.size(), 2});
}

nb::dict classify_graph(const Graph& graph) {
  Classification found;
  {
    nb::gil_scoped_release release;
    found = classify(graph);
  }
  nb::list components, blocks;
  for (const ComponentClass& component : found.components) {
    nb::dict d;
    d["class"] = component.class_name;
    d["type"] = component.type;
    d["joints"] = component.joints;
    d["bars"] = component.bars;
    d["cycle_rank"] = component.cycle_rank;
    d["diameter"] = component.diameter;
    d["lowest_joint"] = component.lowest_joint;
    components.append(d);
  }
  for (const Block& block : found.blocks) {
    nb::dict d;
    d["joints"] = out(block.joints);
    d["bars"] = ends_of(graph, block.bars);
    d["cycle_rank"] = block.cycle_rank();
    d["component"] = block.component;
    blocks.append(d);
  }
  nb::dict d;
  d["class"] = found.class_name;
  d["type"] = found.type;
  d["cycle_rank"] = found.cycle_rank;
  d["diameter"] = found.diameter;
  d["components"] = components;
  d["bridges"] = ends_of(graph, found.bridges);
  d["articulation_joints"] = out(found.articulation_joints);
  d["blocks"] = blocks;
  return d;
}

void bind_classify(nb::module_& m) {
  m.def(
      "classify", [](const Framework& f) { return classify_graph(f.bond_graph()); }, "framework"_a,
      "Class, type, cycle rank, components, bridges and cycle blocks of the bond graph.");
  m.def(
      "classify",
      [](const Structure& s) {
        std::vector<std::pair<int, int>> bars;
        for (const Bar& bar : s.parts.bars) bars.emplace_back(bar.p, bar.q);
        return classify_graph(Graph(int(s.positions.size()), bars));
      },
      "structure"_a, "Class, type, cycle rank, components, bridges and cycle blocks.");
}

// === Force runs

/// Near and far joints, and which bars close cycles, as `order` returns them.
Order order_from(const Structure& structure, const InPairs& joints,
                 const std::optional<InVector<std::uint8_t>>& problem) {
  if (problem) check_size(*problem, joints.shape(0), "problem");
  std::vector<std::tuple<int, int, int>> bars;  // lower joint, higher joint, bar
  for (std::size_t k = 0; k < structure.parts.bars.size(); ++k) {
    const Bar& bar = structure.parts.bars[k];
    bars.emplace_back(std::min(bar.p, bar.q), std::max(bar.p, bar.q), int(k));
  }
  std::sort(bars.begin(), bars.end());
  Order order;
  for (std::size_t k = 0; k < joints.shape(0); ++k) {
    const auto [low, high] = std::minmax({joints(k, 0), joints(k, 1)});
    const auto found = std::lower_bound(bars.begin(), bars.end(), std::tuple(low, high, 0));
    if (found == bars.end() || std::get<0>(*found) != low || std::get<1>(*found) != high)
      throw Error("entry " + std::to_string(k) + " of the custom order is no bar of the structure");
    order.push_back(
        {std::get<2>(*found), joints(k, 0), joints(k, 1), problem && (*problem)(k) != 0});
  }
  if (order.empty()) throw Error("the custom order is empty");
  return order;
}

nb::object flat_frames(const std::vector<std::vector<Vec3>>& frames, std::size_t joints) {
  std::vector<double> flat;
  flat.reserve(3 * joints * frames.size());
  for (const std::vector<Vec3>& frame : frames)
    for (const Vec3& x : frame) flat.insert(flat.end(), {x[0], x[1], x[2]});
  return out(flat, {frames.size(), joints, 3});
}

nb::dict dict_of(const ForceRun& run, bool frames) {
  std::vector<std::int64_t> iterations, bar_visits, carried;
  std::vector<double> residual, residual_nm;
  nb::list reasons, worst;
  bool* flags = new bool[run.reports.size() + 1];
  for (std::size_t k = 0; k < run.reports.size(); ++k) {
    const ResolveReport& report = run.reports[k];
    iterations.push_back(report.iterations);
    bar_visits.push_back(report.bar_visits);
    carried.push_back(report.carried);
    flags[k] = report.converged;
    residual.push_back(report.residual);
    residual_nm.push_back(report.residual_nm);
    reasons.append(name_of(report.reason));
    worst.append(report.worst);
  }
  const nb::capsule owner(flags, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  nb::dict d;
  d["iterations"] = out(iterations);
  d["bar_visits"] = out(bar_visits);
  d["carried"] = out(carried);
  d["converged"] = nb::ndarray<nb::numpy, bool>(flags, {run.reports.size()}, owner);
  d["residual"] = out(residual);
  d["residual_nm"] = out(residual_nm);
  d["solver"] = run.solver;
  d["reasons"] = reasons;
  d["worst"] = worst;
  d["positions"] = out_points(run.positions);
  if (frames) d["frames"] = flat_frames(run.frames, run.positions.size());
  return d;
}

nb::dict resolve_forces(const Structure& structure, ForceSet forces, const std::string& order,
                        const std::string& weighting, const std::string& solver,
                        const std::string& verlet, std::uint64_t seed,
                        const std::optional<InPairs>& custom_order,
                        const std::optional<InVector<std::uint8_t>>& custom_problem, bool frames,
                        std::optional<long> max_iterations, std::optional<double> tolerance,
                        std::optional<double> absolute_tolerance, const std::string& precision,
                        const nb::object& progress) {
  ForceRunSettings settings;
  settings.resolver.precision = precision_of(precision);
  if (tolerance || absolute_tolerance)
    settings.tolerance = tolerance_of(tolerance, absolute_tolerance);
  settings.resolver.solver = solver;
  settings.resolver.weighting = weighting_of(weighting);
  settings.resolver.seed = seed;
  if (custom_order)
    settings.resolver.custom_order = order_from(structure, *custom_order, custom_problem);
  else
    settings.resolver.order = order_kind(order);
  settings.verlet = verlet_scope(verlet);
  settings.frames = frames;
  settings.progress = [&progress](std::size_t done) {
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!progress.is_none()) progress(done);
    return true;
  };
  if (max_iterations) forces.max_iterations = *max_iterations;
  ForceRun run;
  {
    const nb::gil_scoped_release release;
    run = run_forces(structure, forces, settings);
  }
  return dict_of(run, frames);
}

void bind_runs(nb::module_& m) {
  m.def(
      "resolve_forces", &resolve_forces, "structure"_a, "forces"_a, "order"_a = "bfs_cycle",
      "weighting"_a = ".5/.5", "solver"_a = "ordered", "verlet"_a = "affected", "seed"_a = 0,
      "custom_order"_a = nb::none(), "custom_problem"_a = nb::none(), "frames"_a = false,
      "max_iterations"_a = nb::none(), "tolerance"_a = nb::none(),
      "absolute_tolerance"_a = nb::none(), "precision"_a = "double", "progress"_a = nb::none(),
      "Breaks and resolves force after force by one technique; arrays with an entry a force.\n"
      "custom_order (n, 2): bars as (near, far), in place of `order`; custom_problem (n): 1 where "
      "one closes a cycle.\n"
      "tolerance: relative, absolute_tolerance: in nm (1 unit of a structure without one is 1 "
      "nm);\n"
      "either in the place of the forces'.\n"
      "progress: called with the number of forces done.");
  m.def("order_names", &order_names, "The thesis' orders, then ours.");
  m.def(
      "statistics",
      [](InVector<std::int64_t> values) {
        const Statistics s = statistics_of({values.data(), values.shape(0)});
        nb::dict d;
        d["count"] = s.count;
        d["mean"] = s.mean;
        d["mode"] = s.mode;
        d["stdev"] = s.deviation;
        d["p50"] = s.p50;
        d["p99"] = s.p99;
        d["min"] = s.least;
        d["max"] = s.most;
        return d;
      },
      "values"_a,
      "Mean, mode (the smallest on ties), deviation of the population, nearest-rank percentiles.");
  m.def(
      "histogram",
      [](InVector<std::int64_t> values) {
        std::vector<std::int64_t> bins, counts;
        for (const auto& [value, count] : histogram_of({values.data(), values.shape(0)})) {
          bins.push_back(value);
          counts.push_back(count);
        }
        return nb::make_tuple(out(bins), out(counts));
      },
      "values"_a, "Each value that occurs, ascending, and how often.");
}

}  // namespace

namespace ragdoll::bindings {

void bind_method_tools(nb::module_& m) {
  bind_structure(m);
  bind_generators(m);
  bind_classify(m);
  bind_runs(m);
}

}  // namespace ragdoll::bindings
