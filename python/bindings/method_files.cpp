// The Python face of the method's XML files: paths and core's objects in and out, no decisions.

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <optional>

#include "arrays.h"
#include "ragdoll/error.h"
#include "ragdoll/method_files/force_file.h"
#include "ragdoll/method_files/order_file.h"
#include "ragdoll/method_files/results_file.h"
#include "ragdoll/method_files/structure_file.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace ragdoll;
using namespace ragdoll::bindings;
using Path = std::filesystem::path;

namespace {

nb::object py_read_structure(const Path& path) {
  Warnings warnings;
  Structure structure;
  {
    const nb::gil_scoped_release others_may_run;
    structure = read_structure(path.string(), &warnings);
  }
  return nb::make_tuple(std::move(structure), warnings);
}

void py_write_structure(const Path& path, const Structure& structure, bool force,
                        std::optional<int> digits) {
  const nb::gil_scoped_release others_may_run;
  write_structure(path.string(), structure, {force, digits.value_or(0)});
}

nb::object py_read_forces(const Path& path, const Structure& structure) {
  Warnings warnings;
  ForceSet forces;
  {
    const nb::gil_scoped_release others_may_run;
    forces = read_forces(path.string(), structure, &warnings);
  }
  return nb::make_tuple(std::move(forces), warnings);
}

void py_write_forces(const Path& path, const Structure& structure, const ForceSet& forces,
                     bool force) {
  const nb::gil_scoped_release others_may_run;
  write_forces(path.string(), structure, forces, {force});
}

// === Orders

nb::object py_read_order(const Path& path, const Structure& structure,
                         std::optional<nb::list> warnings) {
  Warnings found;
  Order order;
  {
    const nb::gil_scoped_release others_may_run;
    order = read_order(path.string(), structure, &found).order;
  }
  if (warnings)
    for (const std::string& sentence : found) warnings->append(sentence);
  std::vector<std::int32_t> joints;
  joints.reserve(2 * order.size());
  for (const Visit& visit : order) {
    joints.push_back(visit.near);
    joints.push_back(visit.far);
  }
  bool* const problem = new bool[order.size() + 1];
  const nb::capsule owner(problem, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  for (std::size_t k = 0; k < order.size(); ++k) problem[k] = order[k].problem;
  return nb::make_tuple(out(joints, {order.size(), 2}),
                        nb::ndarray<nb::numpy, bool>(problem, {order.size()}, owner));
}

void py_write_order(const Path& path, const Structure& structure, InPairs joints,
                    InVector<bool> problem, const std::string& root, const std::string& order,
                    bool force, const std::string& structure_path) {
  check_size(problem, joints.shape(0), "problem");
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t k = 0; k < joints.shape(0); ++k) pairs.emplace_back(joints(k, 0), joints(k, 1));
  const std::vector<bool> marks(problem.data(), problem.data() + problem.shape(0));
  const nb::gil_scoped_release others_may_run;
  write_order(path.string(), structure,
              {order_from_pairs(structure, pairs, marks), order, root, structure_path}, {force});
}

// === Results

nb::dict dict_of(const ResultStructure& entry) {
  nb::list techniques;
  for (const ResultTechnique& technique : entry.techniques) {
    nb::dict d;
    d["folder"] = technique.folder;
    d["order"] = technique.order;
    d["weighting"] = technique.weighting;
    techniques.append(d);
  }
  nb::dict d;
  d["class"] = entry.class_name;
  d["structure"] = entry.structure;
  d["order"] = entry.order;
  d["forces"] = entry.forces;
  d["techniques"] = techniques;
  return d;
}

nb::object py_read_results(const Path& path) {
  Warnings warnings;
  ResultSet results;
  {
    const nb::gil_scoped_release others_may_run;
    results = read_results(path.string(), &warnings);
  }
  nb::list structures;
  for (const ResultStructure& entry : results.structures) structures.append(dict_of(entry));
  nb::dict d;
  d["seed"] = results.seed;
  d["structures"] = structures;
  return nb::make_tuple(d, warnings);
}

/// The text under a key; "" where there is none.
std::string text_at(const nb::dict& d, const char* key) {
  return d.contains(key) && !nb::handle(d[key]).is_none() ? nb::cast<std::string>(d[key]) : "";
}

ResultStructure entry_of(const nb::dict& d) {
  ResultStructure entry{text_at(d, "class"), text_at(d, "structure"), text_at(d, "order")};
  if (d.contains("forces")) entry.forces = nb::cast<std::vector<std::string>>(d["forces"]);
  if (d.contains("techniques"))
    for (const nb::handle item : d["techniques"]) {
      const auto technique = nb::cast<nb::dict>(item);
      entry.techniques.push_back({text_at(technique, "folder"), text_at(technique, "order"),
                                  text_at(technique, "weighting")});
    }
  return entry;
}

void py_write_results(const Path& path, const nb::dict& results, bool force) {
  ResultSet set;
  if (!nb::try_cast<std::uint64_t>(results["seed"], set.seed))
    throw Error("the seed of a set is a whole number from 0 to 2^64 - 1");
  for (const nb::handle item : results["structures"])
    set.structures.push_back(entry_of(nb::cast<nb::dict>(item)));
  const nb::gil_scoped_release others_may_run;
  write_results(path.string(), set, {force});
}

}  // namespace

NB_MODULE(_method_files, m) {
  m.doc() = "Readers and writers of the method's XML files.";
  nb::module_::import_("ragdoll._core");  // has Structure and ForceSet
  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const ragdoll::Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const FileError& error) {
      PyErr_SetString(PyExc_RuntimeError, error.what());
    }
  });

  m.def(
      "read_structure", &py_read_structure, "path"_a,
      "(Structure, warnings). ValueError: the file is refused; one sentence names file and line.");
  m.def("write_structure", &py_write_structure, "path"_a, "structure"_a, "force"_a = false,
        "digits"_a = nb::none(),
        "Writes the file whole or not at all. digits: significant ones; None: the fewest that read "
        "back exactly. RuntimeError: the disk failed.");
  m.def("read_forces", &py_read_forces, "path"_a, "structure"_a,
        "(ForceSet, warnings). The joints are those of the structure.");
  m.def("write_forces", &py_write_forces, "path"_a, "structure"_a, "forces"_a, "force"_a = false);
  m.def("read_order", &py_read_order, "path"_a, "structure"_a, "warnings"_a = nb::none(),
        "(joints (n, 2): near and far, problem (n): bool). Warnings are appended to the list.");
  m.def("write_order", &py_write_order, "path"_a, "structure"_a, "joints"_a, "problem"_a,
        "root"_a = "", "order"_a = "", "force"_a = false, "structure_path"_a = "",
        "joints (n, 2): near and far; root: id of a joint; order: its name.");
  m.def("read_results", &py_read_results, "path"_a,
        "({seed, structures: [{class, structure, order, forces, techniques: [{folder, order, "
        "weighting}]}]}, warnings). Paths are relative to the file's folder.");
  m.def("write_results", &py_write_results, "path"_a, "results"_a, "force"_a = false,
        "Takes what read_results gives.");
}
