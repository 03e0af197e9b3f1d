// SPDX-License-Identifier: MIT

#include "ragdoll/trajectory/reader.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <numeric>
#include <system_error>
#include <type_traits>
#include <utility>

#include "hdf5.h"
#include "layout.h"

namespace ragdoll {
namespace {

using hdf5::Handle;

Handle open_object(hid_t file, const std::string& path) {
  return {H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose, "find " + path};
}

// Numbers of any width, as the narrowest of our types that holds them.
Values read_values(hid_t file, const std::string& path) {
  const Handle dataset = open_object(file, path);
  const Handle type(H5Dget_type(dataset), H5Tclose, "read " + path);
  if (H5Tget_class(type) != H5T_INTEGER) return hdf5::read_array<double>(file, path);
  if (H5Tget_size(type) <= 4 && H5Tget_sign(type) == H5T_SGN_2)
    return hdf5::read_array<std::int32_t>(file, path);
  return hdf5::read_array<std::int64_t>(file, path);
}

std::map<std::string, Attribute> attributes_of(hid_t object) {
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5A_info_t*, void* to) -> herr_t {
    static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    return 0;
  };
  hdf5::checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names),
                "list attributes");

  std::map<std::string, Attribute> attributes;
  for (const std::string& name : names) {
    if (name == kFormatVersionName || name == kSegmentName) continue;
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "read " + name);
    const Handle type(H5Aget_type(attribute), H5Tclose, "read " + name);
    const Handle space(H5Aget_space(attribute), H5Sclose, "read " + name);
    if (H5Sget_simple_extent_npoints(space) != 1) continue;  // not one of ours
    std::int64_t whole = 0;
    double number = 0;
    switch (H5Tget_class(type)) {
      case H5T_STRING:
        attributes[name] = hdf5::text_attribute(object, name);
        break;
      case H5T_INTEGER:
        hdf5::checked(H5Aread(attribute, hdf5::memory_type<std::int64_t>(), &whole),
                      "read " + name);
        attributes[name] = whole;
        break;
      case H5T_FLOAT:
        hdf5::checked(H5Aread(attribute, hdf5::memory_type<double>(), &number), "read " + name);
        attributes[name] = number;
        break;
      default:
        break;
    }
  }
  return attributes;
}

// Texts and arrays of a group and its groups, under names relative to /ragdoll.
void read_own(hid_t file, const std::string& name, TrajectoryHeader& header) {
  for (const std::string& child : hdf5::names_in(file, "ragdoll/" + name)) {
    const std::string here = name + child, path = "ragdoll/" + here;
    const Handle object = open_object(file, path);
    if (H5Iget_type(object) == H5I_GROUP) {
      read_own(file, here + "/", header);
      continue;
    }
    if (H5Iget_type(object) != H5I_DATASET) continue;
    const Handle type(H5Dget_type(object), H5Tclose, "read " + path);
    if (H5Tget_class(type) == H5T_STRING) {
      header.texts[here] = hdf5::read_text(file, path);
    } else {
      const hdf5::Shape shape = hdf5::shape_of(object);
      header.arrays[here] = {{shape.begin(), shape.end()}, read_values(file, path)};
    }
  }
}

}  // namespace

struct TrajectoryReader::State {
  std::string path;
  Handle whole;  // the file
  Handle file;   // the group in it that is laid out as a file
  std::size_t atoms = 0, frames = 0;
  bool periodic = false, velocities = false;

  // Does some reading; whatever fails there becomes one sentence.
  template <typename Reading>
  auto read(const Reading& reading) const {
    const hdf5::Session session;
    try {
      return reading();
    } catch (const TrajectoryError&) {
      throw;
    } catch (const std::exception& error) {
      throw TrajectoryError(path + " is damaged: " + error.what());
    }
  }

  void read_frames(const char* name, std::size_t first, std::span<float> out) const;
  TrajectoryHeader header() const;
};

void TrajectoryReader::State::read_frames(const char* name, std::size_t first,
                                          std::span<float> out) const {
  const std::size_t count = out.size() / (3 * atoms);
  if (out.size() != 3 * atoms * count)
    throw TrajectoryUsageError("the room for frames of " + path + " does not hold whole frames");
  if (first > frames || count > frames - first)
    throw TrajectoryUsageError(path + " has " + std::to_string(frames) + " frames, frame " +
                               std::to_string(first + count - 1) + " is not among them");
  if (count == 0) return;
  const Handle dataset = open_object(file, name);
  const Handle space(H5Dget_space(dataset), H5Sclose, "measure the frames");
  const hsize_t start[] = {first, 0, 0}, extent[] = {count, atoms, 3};
  const Handle memory(H5Screate_simple(3, extent, nullptr), H5Sclose, "make a data space");
  hdf5::checked(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, extent, nullptr),
                "select frames");
  hdf5::checked(
      H5Dread(dataset, hdf5::memory_type<float>(), memory, space, H5P_DEFAULT, out.data()),
      "read frame " + std::to_string(first));
}

TrajectoryHeader TrajectoryReader::State::header() const {
  TrajectoryHeader header;
  header.atom_count = static_cast<std::int64_t>(atoms);
  header.periodic = periodic;
  header.velocities = velocities;
  const Handle root = open_object(file, ".");
  header.program = hdf5::text_attribute(root, "program");
  header.program_version = hdf5::text_attribute(root, "programVersion");
  if (hdf5::exists(file, "h5md/author"))
    header.author = hdf5::text_attribute(open_object(file, "h5md/author"), "name");

  // the molecule
  if (hdf5::exists(file, "topology")) header.topology_json = hdf5::read_text(file, "topology");
  if (hdf5::exists(file, "connectivity/bonds"))
    header.bonds = hdf5::read_array<std::int32_t>(file, "connectivity/bonds");
  if (hdf5::exists(file, "particles/trajectory/species"))
    header.atomic_numbers = hdf5::read_array<std::int32_t>(file, "particles/trajectory/species");

  // the observables
  for (const std::string& name : hdf5::names_in(file, "observables")) {
    const Handle value = open_object(file, "observables/" + name + "/value");
    const Handle type(H5Dget_type(value), H5Tclose, "read " + name);
    header.observables.push_back(
        {name, H5Tget_class(type) == H5T_INTEGER, hdf5::text_attribute(value, "unit")});
  }

  // our own group
  if (hdf5::exists(file, "ragdoll")) {
    header.attributes = attributes_of(open_object(file, "ragdoll"));
    read_own(file, "", header);
  }
  return header;
}

TrajectoryReader::TrajectoryReader(std::string path, const std::string& molecule)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.path = std::move(path);
  std::error_code error;
  const auto status = std::filesystem::status(state.path, error);
  if (!std::filesystem::exists(status))
    throw TrajectoryUsageError("there is no file " + state.path);
  if (std::filesystem::is_directory(status))
    throw TrajectoryUsageError(state.path + " is a folder, not a trajectory");

  const hdf5::Session session;
  try {
    state.whole = hdf5::open_to_read(state.path);
  } catch (const hdf5::Failure&) {
    throw TrajectoryError(state.path +
                          " cannot be read: it is not an HDF5 file, is cut short or protected");
  }
  const std::string group = molecule.empty() ? "." : "molecules/" + molecule;
  if (!molecule.empty() &&
      (molecule.find('/') != std::string::npos || !hdf5::exists(state.whole, group)))
    throw TrajectoryUsageError(state.path + " has no molecule " + molecule);
  const bool is_collection = molecule.empty() && hdf5::exists(state.whole, "molecules");
  if (is_collection)
    throw TrajectoryUsageError(state.path + " holds many molecules; name one of them");
  state.file = open_object(state.whole, group);
  try {
    const hdf5::Shape shape = hdf5::shape_of(open_object(state.file, "coordinates"));
    if (shape.size() != 3 || shape[1] < 1 || shape[2] != 3) throw hdf5::Failure("wrong shape");
    state.frames = shape[0];
    state.atoms = shape[1];
  } catch (const hdf5::Failure&) {
    throw TrajectoryError(state.path +
                          " holds no trajectory: /coordinates is missing or is not "
                          "frames of atoms");
  }
  state.periodic = hdf5::exists(state.file, "particles/trajectory/box/edges/value");
  state.velocities = hdf5::exists(state.file, "velocities");
}

TrajectoryReader::~TrajectoryReader() {
  const hdf5::Session session;
  state_.reset();
}

std::size_t TrajectoryReader::atom_count() const {
  return state_->atoms;
}
std::size_t TrajectoryReader::frame_count() const {
  return state_->frames;
}
bool TrajectoryReader::periodic() const {
  return state_->periodic;
}
bool TrajectoryReader::has_velocities() const {
  return state_->velocities;
}

TrajectoryHeader TrajectoryReader::header() const {
  return state_->read([&] { return state_->header(); });
}

void TrajectoryReader::read_positions(std::size_t first, std::span<float> out) const {
  state_->read([&] { state_->read_frames("coordinates", first, out); });
}

void TrajectoryReader::read_velocities(std::size_t first, std::span<float> out) const {
  if (!state_->velocities) throw TrajectoryUsageError(state_->path + " has no velocities");
  state_->read([&] { state_->read_frames("velocities", first, out); });
}

std::vector<float> TrajectoryReader::positions(std::size_t frame) const {
  std::vector<float> values(3 * state_->atoms);
  read_positions(frame, values);
  return values;
}

std::vector<double> TrajectoryReader::times() const {
  return state_->read([&] {
    if (hdf5::exists(state_->file, "time")) return hdf5::read_array<double>(state_->file, "time");
    return std::vector<double>(state_->frames);
  });
}

std::vector<std::int64_t> TrajectoryReader::steps() const {
  return state_->read([&] {
    const char* path = "particles/trajectory/position/step";
    if (hdf5::exists(state_->file, path)) return hdf5::read_array<std::int64_t>(state_->file, path);
    std::vector<std::int64_t> numbers(state_->frames);
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
  });
}

std::vector<BoxVectors> TrajectoryReader::boxes() const {
  if (!state_->periodic) return {};
  return state_->read([&] {
    const auto flat =
        hdf5::read_array<double>(state_->file, "particles/trajectory/box/edges/value");
    std::vector<BoxVectors> boxes(flat.size() / 9);
    for (std::size_t i = 0; i < boxes.size(); ++i)
      std::copy_n(flat.begin() + static_cast<std::ptrdiff_t>(9 * i), 9, boxes[i].begin());
    return boxes;
  });
}

Values TrajectoryReader::observable(const std::string& name) const {
  return state_->read([&]() -> Values {
    const std::string path = "observables/" + name + "/value";
    if (name.empty() || !hdf5::exists(state_->file, path))
      throw TrajectoryUsageError(state_->path + " has no observable '" + name + "'");
    return read_values(state_->file, path);
  });
}

}  // namespace ragdoll
