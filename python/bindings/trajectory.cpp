// The Python module _trajectory: numpy arrays in and out, no decisions.
//
// SPDX-License-Identifier: MIT

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ragdoll/trajectory/collection.h"
#include "ragdoll/trajectory/reader.h"
#include "ragdoll/trajectory/writer.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace ragdoll;

namespace {

template <typename T>
using Input = nb::ndarray<const T, nb::c_contig, nb::device::cpu>;

template <typename T>
std::vector<T> values_of(const Input<T>& input) {
  return {input.data(), input.data() + input.size()};
}

// A numpy array that takes over the memory of the vector.
template <typename T>
nb::object numpy_of(std::vector<T> values, const std::vector<std::size_t>& shape) {
  auto owner = std::make_unique<std::vector<T>>(std::move(values));
  T* data = owner->data();
  const nb::capsule keeper(owner.release(),
                           [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(data, shape.size(), shape.data(), keeper));
}

template <typename T>
void add_array(TrajectoryHeader& header, const std::string& name, const Input<T>& input) {
  Array array;
  for (std::size_t i = 0; i < input.ndim(); ++i) array.shape.push_back(input.shape(i));
  array.values = values_of(input);
  header.arrays[name] = std::move(array);
}

nb::object numpy_of(Values values, const std::vector<std::size_t>& shape) {
  return std::visit([&](auto& list) { return numpy_of(std::move(list), shape); }, values);
}

void append(TrajectoryWriter& writer, const Input<float>& positions, double time, std::int64_t step,
            const std::vector<double>& observables, const std::optional<Input<double>>& box,
            const std::optional<Input<float>>& velocities) {
  Frame frame;
  frame.positions = {positions.data(), positions.size()};
  frame.time = time;
  frame.step = step;
  frame.observables = observables;
  if (box) {
    if (box->size() != 9) throw TrajectoryUsageError("a box needs three vectors");
    std::copy_n(box->data(), 9, frame.box.emplace().begin());
  }
  if (velocities) frame.velocities = {velocities->data(), velocities->size()};
  const nb::gil_scoped_release others_may_run;
  writer.append(frame);
}

// Adds conformers, (frames, atoms, 3) positions, to a collection; frame k is step k.
void add_to_collection(CollectionWriter& writer, const std::string& name,
                       const TrajectoryHeader& header, const Input<float>& positions,
                       const std::vector<std::vector<double>>& observables) {
  if (positions.ndim() != 3)
    throw TrajectoryUsageError("the positions of " + name + " must be frames of atoms");
  const std::size_t count = positions.shape(0), row = positions.shape(1) * positions.shape(2);
  std::vector<std::vector<double>> values(count);
  for (const std::vector<double>& of_all : observables) {
    if (of_all.size() != count)
      throw TrajectoryUsageError("an observable of " + name + " needs a number for each frame");
    for (std::size_t k = 0; k < count; ++k) values[k].push_back(of_all[k]);
  }
  std::vector<Frame> frames(count);
  for (std::size_t k = 0; k < count; ++k) {
    frames[k].positions = {positions.data() + k * row, row};
    frames[k].time = static_cast<double>(k);
    frames[k].step = static_cast<std::int64_t>(k);
    frames[k].observables = values[k];
  }
  const nb::gil_scoped_release others_may_run;
  writer.add(name, header, frames);
}

using ReadFrames = void (TrajectoryReader::*)(std::size_t, std::span<float>) const;

nb::object read_frames(const TrajectoryReader& reader, ReadFrames read, std::size_t first,
                       std::size_t count) {
  std::vector<float> values;
  {
    const nb::gil_scoped_release others_may_run;
    if (first > reader.frame_count() || count > reader.frame_count() - first)
      throw TrajectoryUsageError("there are only " + std::to_string(reader.frame_count()) +
                                 " frames");
    values.resize(3 * reader.atom_count() * count);
    (reader.*read)(first, values);
  }
  return numpy_of(std::move(values), {count, reader.atom_count(), 3});
}

// Raises the Python exception of this name, which the Python half of the module defines.
void raise(const char* name, const std::exception& error) {
  const nb::object type = nb::module_::import_("ragdoll.trajectory").attr(name);
  PyErr_SetString(type.ptr(), error.what());
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const TrajectoryUsageError& error) {
    raise("TrajectoryUsageError", error);
  } catch (const TrajectoryError& error) {
    raise("TrajectoryError", error);
  }
}

}  // namespace

NB_MODULE(_trajectory, m) {
  nb::register_exception_translator(translate);

  nb::class_<Observable>(m, "Observable")
      .def(
          "__init__",
          [](Observable* self, std::string name, bool integer, std::string unit) {
            new (self) Observable{std::move(name), integer, std::move(unit)};
          },
          "name"_a, "integer"_a = false, "unit"_a = "")
      .def_ro("name", &Observable::name)
      .def_ro("integer", &Observable::integer)
      .def_ro("unit", &Observable::unit);

  nb::class_<TrajectoryHeader>(m, "TrajectoryHeader")
      .def(nb::init<>())
      .def_rw("atom_count", &TrajectoryHeader::atom_count)
      .def_rw("topology_json", &TrajectoryHeader::topology_json)
      .def_rw("periodic", &TrajectoryHeader::periodic)
      .def_rw("velocities", &TrajectoryHeader::velocities)
      .def_rw("observables", &TrajectoryHeader::observables)
      .def_rw("program", &TrajectoryHeader::program)
      .def_rw("program_version", &TrajectoryHeader::program_version)
      .def_rw("author", &TrajectoryHeader::author)
      .def_rw("attributes", &TrajectoryHeader::attributes)
      .def_rw("texts", &TrajectoryHeader::texts)
      .def("set_bonds", [](TrajectoryHeader& self,
                           const Input<std::int32_t>& pairs) { self.bonds = values_of(pairs); })
      .def("bonds",
           [](const TrajectoryHeader& self) {
             return numpy_of(self.bonds, {self.bonds.size() / 2, 2});
           })
      .def("set_atomic_numbers",
           [](TrajectoryHeader& self, const Input<std::int32_t>& numbers) {
             self.atomic_numbers = values_of(numbers);
           })
      .def("atomic_numbers",
           [](const TrajectoryHeader& self) {
             return numpy_of(self.atomic_numbers, {self.atomic_numbers.size()});
           })
      .def("add_array", &add_array<double>, "name"_a, "values"_a.noconvert())
      .def("add_array", &add_array<std::int64_t>, "name"_a, "values"_a.noconvert())
      .def("add_array", &add_array<std::int32_t>, "name"_a, "values"_a.noconvert())
      .def("arrays", [](const TrajectoryHeader& self) {
        nb::dict arrays;
        for (const auto& [name, array] : self.arrays)
          arrays[name.c_str()] = numpy_of(array.values, array.shape);
        return arrays;
      });

  nb::class_<TrajectoryWriter>(m, "TrajectoryWriter")
      .def(
          "__init__",
          [](TrajectoryWriter* self, std::string path, TrajectoryHeader header, bool force,
             double precision, double segment_seconds) {
            TrajectoryOptions options;
            options.force = force;
            options.precision_nm = precision;
            options.segment_seconds = segment_seconds;
            new (self) TrajectoryWriter(std::move(path), std::move(header), options);
          },
          "path"_a, "header"_a, "force"_a = false, "precision"_a = 0.0, "segment_seconds"_a = 2.0)
      .def("append", &append, "positions"_a, "time"_a, "step"_a, "observables"_a,
           "box"_a = nb::none(), "velocities"_a = nb::none())
      .def("close", &TrajectoryWriter::close, nb::call_guard<nb::gil_scoped_release>())
      .def("abandon", &TrajectoryWriter::abandon, nb::call_guard<nb::gil_scoped_release>())
      .def_prop_ro("frame_count", &TrajectoryWriter::frame_count,
                   nb::call_guard<nb::gil_scoped_release>())
      .def_prop_ro("closed", &TrajectoryWriter::closed, nb::call_guard<nb::gil_scoped_release>());

  nb::class_<TrajectoryReader>(m, "TrajectoryReader")
      .def(nb::init<std::string, const std::string&>(), "path"_a, "molecule"_a = "")
      .def_prop_ro("atom_count", &TrajectoryReader::atom_count)
      .def_prop_ro("frame_count", &TrajectoryReader::frame_count)
      .def_prop_ro("periodic", &TrajectoryReader::periodic)
      .def_prop_ro("has_velocities", &TrajectoryReader::has_velocities)
      .def("header", &TrajectoryReader::header)
      .def("positions",
           [](const TrajectoryReader& self, std::size_t first, std::size_t count) {
             return read_frames(self, &TrajectoryReader::read_positions, first, count);
           })
      .def("velocities",
           [](const TrajectoryReader& self, std::size_t first, std::size_t count) {
             return read_frames(self, &TrajectoryReader::read_velocities, first, count);
           })
      .def(
          "times",
          [](const TrajectoryReader& self) { return numpy_of(self.times(), {self.frame_count()}); })
      .def(
          "steps",
          [](const TrajectoryReader& self) { return numpy_of(self.steps(), {self.frame_count()}); })
      .def("boxes",
           [](const TrajectoryReader& self) {
             std::vector<double> flat;
             for (const BoxVectors& box : self.boxes())
               flat.insert(flat.end(), box.begin(), box.end());
             const std::size_t count = flat.size() / 9;
             return numpy_of(std::move(flat), {count, 3, 3});
           })
      .def("observable", [](const TrajectoryReader& self, const std::string& name) {
        return numpy_of(self.observable(name), {self.frame_count()});
      });

  nb::class_<CollectionWriter>(m, "CollectionWriter")
      .def(nb::init<std::string, const TrajectoryHeader&, bool, std::uintmax_t>(), "path"_a,
           "about"_a, "force"_a = false, "expected_bytes"_a = 0)
      .def("add", &add_to_collection, "name"_a, "header"_a, "positions"_a, "observables"_a)
      .def("close", &CollectionWriter::close, nb::call_guard<nb::gil_scoped_release>());

  m.def("names_in_collection", &names_in_collection, "path"_a);
  m.def("check_output", &check_output, "path"_a, "force"_a = false);
}
