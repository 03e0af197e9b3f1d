// SPDX-License-Identifier: MIT

#include "layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <type_traits>

namespace ragdoll {
namespace {

using hdf5::Shape;

// time and step of any H5MD element are those of the whole trajectory
void link_steps(hid_t file, const std::string& element) {
  hdf5::make_link(file, "particles/trajectory/position/step", element + "/step");
  hdf5::make_link(file, "time", element + "/time");
}

// Units by both names: `units` for MDTraj, `unit` for H5MD.
void set_units(hid_t file, const char* path, const char* mdtraj, const char* h5md) {
  const hdf5::Handle dataset(H5Dopen2(file, path, H5P_DEFAULT), H5Dclose, "open a dataset");
  hdf5::set_text(dataset, "units", mdtraj);
  hdf5::set_text(dataset, "unit", h5md);
}

void write_root(hid_t file, const TrajectoryHeader& header, const FrameTable& frames) {
  const hdf5::Handle root(H5Gopen2(file, ".", H5P_DEFAULT), H5Gclose, "open the root group");
  hdf5::set_text(root, "conventions", "Pande");
  hdf5::set_text(root, "conventionVersion", "1.1");
  hdf5::set_text(root, "program", header.program);
  hdf5::set_text(root, "programVersion", header.program_version);
  hdf5::set_text(root, "application", header.program);

  const auto atoms = static_cast<hsize_t>(header.atom_count);
  hdf5::make_frames(file, "coordinates", frames.size(), atoms);
  set_units(file, "coordinates", "nanometers", "nm");
  hdf5::write_array(file, "time", Shape{frames.size()}, frames.times.data());
  set_units(file, "time", "picoseconds", "ps");
  if (header.velocities) {
    hdf5::make_frames(file, "velocities", frames.size(), atoms);
    set_units(file, "velocities", "nanometers/picosecond", "nm ps-1");
  }
  if (!header.topology_json.empty()) hdf5::write_fixed_text(file, "topology", header.topology_json);
}

void write_h5md(hid_t file, const TrajectoryHeader& header) {
  hdf5::set_version(hdf5::make_group(file, "h5md"), 1, 1);
  const hdf5::Handle author = hdf5::make_group(file, "h5md/author");
  hdf5::set_text(author, "name", header.author);
  const hdf5::Handle creator = hdf5::make_group(file, "h5md/creator");
  hdf5::set_text(creator, "name", header.program);
  hdf5::set_text(creator, "version", header.program_version);
  hdf5::set_version(hdf5::make_group(file, "h5md/modules/units"), 1, 0);
}

double dot(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double degrees_between(const double* a, const double* b) {
  return std::acos(dot(a, b) / std::sqrt(dot(a, a) * dot(b, b))) * 180 / std::numbers::pi;
}

void write_box(hid_t file, const TrajectoryHeader& header, const FrameTable& frames) {
  const std::string boundary = header.periodic ? "periodic" : "none";
  const hdf5::Handle box = hdf5::make_group(file, "particles/trajectory/box");
  hdf5::set_number(box, "dimension", std::int32_t{3});
  hdf5::set_texts(box, "boundary", {boundary, boundary, boundary});
  if (!header.periodic) return;

  // MDTraj wants lengths and angles, H5MD the vectors
  std::vector<float> lengths, angles, edges;
  for (const BoxVectors& vectors : frames.boxes) {
    const double *a = vectors.data(), *b = a + 3, *c = a + 6;
    for (const double* edge : {a, b, c})
      lengths.push_back(static_cast<float>(std::sqrt(dot(edge, edge))));
    for (const double angle : {degrees_between(b, c), degrees_between(a, c), degrees_between(a, b)})
      angles.push_back(static_cast<float>(angle));
    for (const double component : vectors) edges.push_back(static_cast<float>(component));
  }
  hdf5::write_array(file, "cell_lengths", {frames.size(), 3}, lengths.data());
  set_units(file, "cell_lengths", "nanometers", "nm");
  hdf5::write_array(file, "cell_angles", {frames.size(), 3}, angles.data());
  set_units(file, "cell_angles", "degrees", "deg");
  const char* value = "particles/trajectory/box/edges/value";
  hdf5::write_array(file, value, {frames.size(), 3, 3}, edges.data());
  set_units(file, value, "nanometers", "nm");
  link_steps(file, "particles/trajectory/box/edges");
}

void write_particles(hid_t file, const TrajectoryHeader& header, const FrameTable& frames) {
  hdf5::make_link(file, "coordinates", "particles/trajectory/position/value");
  hdf5::make_link(file, "time", "particles/trajectory/position/time");
  hdf5::write_array(file, "particles/trajectory/position/step", {frames.size()},
                    frames.steps.data());
  if (header.velocities) {
    hdf5::make_link(file, "velocities", "particles/trajectory/velocity/value");
    link_steps(file, "particles/trajectory/velocity");
  }
  write_box(file, header, frames);
}

void write_observables(hid_t file, const TrajectoryHeader& header, const FrameTable& frames) {
  for (std::size_t i = 0; i < header.observables.size(); ++i) {
    const Observable& observable = header.observables[i];
    const std::vector<double>& values = frames.observables[i];
    const std::string element = "observables/" + observable.name;
    const std::string value = element + "/value";
    if (observable.integer) {
      const std::vector<std::int64_t> whole(values.begin(), values.end());
      hdf5::write_array(file, value, {frames.size()}, whole.data());
    } else {
      hdf5::write_array(file, value, {frames.size()}, values.data());
    }
    if (!observable.unit.empty()) {
      const hdf5::Handle dataset(H5Dopen2(file, value.c_str(), H5P_DEFAULT), H5Dclose, "open it");
      hdf5::set_text(dataset, "unit", observable.unit);
    }
    link_steps(file, element);
  }
}

void write_molecule(hid_t file, const TrajectoryHeader& header) {
  const std::vector<std::int32_t>& bonds = header.bonds;
  hdf5::write_array(file, "connectivity/bonds", {bonds.size() / 2, 2}, bonds.data());
  const hdf5::Handle dataset(H5Dopen2(file, "connectivity/bonds", H5P_DEFAULT), H5Dclose,
                             "open the bonds");
  hdf5::set_reference(dataset, "particles_group", file, "particles/trajectory");

  // VMD counts from 1, and takes an atomic number for each species; ours are the numbers
  const std::string vmd = "parameters/vmd_structure/";
  std::vector<std::int32_t> from, to;
  for (std::size_t i = 0; i < bonds.size(); i += 2) {
    from.push_back(bonds[i] + 1);
    to.push_back(bonds[i + 1] + 1);
  }
  hdf5::write_array(file, vmd + "bond_from", {from.size()}, from.data());
  hdf5::write_array(file, vmd + "bond_to", {to.size()}, to.data());
  if (header.atomic_numbers.empty()) return;
  const std::set<std::int32_t> distinct(header.atomic_numbers.begin(), header.atomic_numbers.end());
  const std::vector<std::int32_t> species(distinct.begin(), distinct.end());
  hdf5::write_array(file, "particles/trajectory/species", {header.atomic_numbers.size()},
                    header.atomic_numbers.data());
  hdf5::write_array(file, vmd + "indexOfSpecies", {species.size()}, species.data());
  hdf5::make_link(file, vmd + "indexOfSpecies", vmd + "atomicnumber");
}

}  // namespace

void write_own(hid_t file, const TrajectoryHeader& header, std::optional<std::int64_t> segment) {
  const hdf5::Handle group = hdf5::make_group(file, "ragdoll");
  hdf5::set_number(group, kFormatVersionName, kFormatVersion);
  if (segment) hdf5::set_number(group, kSegmentName, *segment);
  for (const auto& [name, attribute] : header.attributes) {
    if (const auto* text = std::get_if<std::string>(&attribute))
      hdf5::set_text(group, name, *text);
    else if (const auto* whole = std::get_if<std::int64_t>(&attribute))
      hdf5::set_number(group, name, *whole);
    else
      hdf5::set_number(group, name, std::get<double>(attribute));
  }
  for (const auto& [name, text] : header.texts) hdf5::write_text(file, "ragdoll/" + name, text);
  for (const auto& [name, array] : header.arrays) {
    const Shape shape(array.shape.begin(), array.shape.end());
    std::visit([&](const auto& v) { hdf5::write_array(file, "ragdoll/" + name, shape, v.data()); },
               array.values);
  }
}

FrameTable FrameTable::since(std::size_t first) const {
  const auto tail = [first](const auto& all) {
    const std::size_t begin = std::min(first, all.size());
    return std::remove_cvref_t<decltype(all)>(all.begin() + static_cast<std::ptrdiff_t>(begin),
                                              all.end());
  };
  FrameTable part{tail(times), tail(steps), {}, tail(boxes)};
  for (const std::vector<double>& values : observables) part.observables.push_back(tail(values));
  return part;
}

void write_layout(hid_t file, const TrajectoryHeader& header, const FrameTable& frames,
                  std::optional<std::int64_t> segment) {
  write_root(file, header, frames);
  write_h5md(file, header);
  write_particles(file, header, frames);
  write_observables(file, header, frames);
  write_molecule(file, header);
  write_own(file, header, segment);
}

void write_frames(hid_t file, const char* name, const std::vector<float>& values) {
  const hdf5::Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, "open the frames");
  hdf5::checked(
      H5Dwrite(dataset, hdf5::memory_type<float>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
      "write the frames");
}

void copy_frames(hid_t segment, hid_t file, const char* name, std::size_t first) {
  const hdf5::Handle source(H5Dopen2(segment, name, H5P_DEFAULT), H5Dclose, "open the frames");
  const hdf5::Handle target(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, "open the frames");
  std::vector<std::byte> chunk;

  // a chunk is one frame: it moves as it is, without unpacking
  for (hsize_t frame = 0; frame < hdf5::shape_of(source)[0]; ++frame) {
    const hsize_t from[] = {frame, 0, 0}, to[] = {first + frame, 0, 0};
    hsize_t size = 0;
    std::uint32_t filters = 0;
    hdf5::checked(H5Dget_chunk_storage_size(source, from, &size), "measure a frame");
    chunk.resize(size);
    hdf5::checked(H5Dread_chunk(source, H5P_DEFAULT, from, &filters, chunk.data()), "copy a frame");
    hdf5::checked(H5Dwrite_chunk(target, H5P_DEFAULT, filters, to, size, chunk.data()),
                  "copy a frame");
  }
}

std::size_t stored_bytes(hid_t file, const char* name) {
  const hdf5::Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, "open the frames");
  return H5Dget_storage_size(dataset);
}

bool is_segment(const std::string& path) {
  const hdf5::Session session;
  try {
    const hdf5::Handle file = hdf5::open_to_read(path);
    return H5Aexists_by_name(file, "ragdoll", kSegmentName, H5P_DEFAULT) > 0;
  } catch (const hdf5::Failure&) {
    return false;
  }
}

}  // namespace ragdoll
