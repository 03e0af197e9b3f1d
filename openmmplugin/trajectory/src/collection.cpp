// SPDX-License-Identifier: MIT

#include "ragdoll/trajectory/collection.h"

#include <filesystem>
#include <mutex>
#include <utility>

#include "files.h"
#include "hdf5.h"
#include "layout.h"
#include "ragdoll/trajectory/writer.h"  // check_output

namespace ragdoll {
namespace {

const std::string kMolecules = "molecules";

[[noreturn]] void refuse(const std::string& sentence) {
  throw TrajectoryUsageError(sentence);
}

// Frames as the layout wants them: what is small in a table, positions in a row.
std::pair<FrameTable, std::vector<float>> tabled(const std::string& name,
                                                 const TrajectoryHeader& header,
                                                 std::span<const Frame> frames) {
  FrameTable table;
  std::vector<float> positions;
  table.observables.resize(header.observables.size());
  for (const Frame& frame : frames) {
    if (std::cmp_not_equal(frame.positions.size(), 3 * header.atom_count) ||
        frame.observables.size() != header.observables.size() || frame.box ||
        !frame.velocities.empty())
      refuse("a frame of " + name + " does not fit its header");
    positions.insert(positions.end(), frame.positions.begin(), frame.positions.end());
    table.times.push_back(static_cast<float>(frame.time));
    table.steps.push_back(frame.step);
    for (std::size_t i = 0; i < frame.observables.size(); ++i)
      table.observables[i].push_back(frame.observables[i]);
  }
  return {std::move(table), std::move(positions)};
}

}  // namespace

struct CollectionWriter::State {
  std::mutex turn;
  std::string path;
  hdf5::Handle file;
  bool closed = false;

  template <typename Writing>
  void write(const Writing& writing) {
    const hdf5::Session session;
    try {
      writing();
    } catch (const hdf5::Failure& failure) {
      throw TrajectoryError(path + " cannot be written: " + failure.what());
    }
  }
};

CollectionWriter::CollectionWriter(std::string path, const TrajectoryHeader& about, bool force,
                                   std::uintmax_t expected_bytes)
    : state_(std::make_unique<State>()) {
  state_->path = std::move(path);
  check_output(state_->path, force);
  check_room(state_->path, expected_bytes);
  state_->write([&] {
    state_->file = hdf5::create_compact_on_disk(part_of(state_->path));
    if (expected_bytes > 0) reserve_room(state_->path, expected_bytes);
    write_own(state_->file, about, std::nullopt);
    hdf5::make_group(state_->file, kMolecules);
  });
}

CollectionWriter::~CollectionWriter() {
  const std::lock_guard lock(state_->turn);
  if (state_->closed) return;
  const hdf5::Session session;
  state_->file = {};
  remove_file(part_of(state_->path));
}

void CollectionWriter::add(const std::string& name, const TrajectoryHeader& header,
                           std::span<const Frame> frames) {
  const std::lock_guard lock(state_->turn);
  if (state_->closed) refuse(state_->path + " is closed already and takes no more molecules");
  if (name.empty() || name.find('/') != std::string::npos || name == ".")
    refuse("'" + name + "' cannot name a molecule of " + state_->path);
  if (header.atom_count < 1) refuse("the molecule " + name + " needs at least one atom");
  if (header.periodic || header.velocities)
    refuse("the molecule " + name + " may have neither boxes nor velocities");
  const auto [table, positions] = tabled(name, header, frames);
  const std::string group_path = kMolecules + "/" + name;
  state_->write([&] {
    if (hdf5::exists(state_->file, group_path))
      refuse(state_->path + " has a molecule " + name + " already");
    const hdf5::Handle group = hdf5::make_group(state_->file, group_path);
    write_layout(group, header, table, std::nullopt);
    write_frames(group, "coordinates", positions);
  });
}

void CollectionWriter::close() {
  const std::lock_guard lock(state_->turn);
  if (state_->closed) return;
  state_->write([&] { state_->file.close("finish the file"); });
  publish(state_->path);
  state_->closed = true;
}

std::vector<std::string> names_in_collection(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) refuse("there is no file " + path);
  const hdf5::Session session;
  try {
    return hdf5::names_in(hdf5::open_to_read(path), kMolecules);
  } catch (const hdf5::Failure&) {
    throw TrajectoryError(path +
                          " cannot be read: it is not an HDF5 file, is cut short or protected");
  }
}

}  // namespace ragdoll
