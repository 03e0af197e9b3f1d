// SPDX-License-Identifier: MIT

#include "ragdoll/trajectory/writer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <mutex>
#include <numeric>
#include <set>
#include <utility>

#include "files.h"
#include "hdf5.h"
#include "layout.h"
#include "segments.h"

namespace ragdoll {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

[[noreturn]] void refuse(const std::string& sentence) {
  throw TrajectoryUsageError(sentence);
}

void check_header(const TrajectoryHeader& header) {
  const std::int64_t atoms = header.atom_count;
  if (atoms < 1) refuse("a trajectory needs at least one atom");
  if (header.bonds.size() % 2 != 0) refuse("the bonds of a trajectory must be pairs of atoms");
  for (const std::int32_t atom : header.bonds)
    if (atom < 0 || atom >= atoms)
      refuse("a bond of the trajectory joins atom " + std::to_string(atom) + ", but there are " +
             std::to_string(atoms) + " atoms");
  if (!header.atomic_numbers.empty() && std::cmp_not_equal(header.atomic_numbers.size(), atoms))
    refuse("a trajectory needs an atomic number for each atom, or none");

  std::set<std::string> names;
  for (const Observable& observable : header.observables)
    if (observable.name.empty() || observable.name.find('/') != std::string::npos ||
        !names.insert(observable.name).second)
      refuse("'" + observable.name +
             "' cannot name an observable: it is empty, has a slash or "
             "is there twice");
  for (const char* name : {kFormatVersionName, kSegmentName})
    if (header.attributes.contains(name))
      refuse(std::string("the attribute '") + name + "' belongs to the trajectory itself");
  for (const auto& [name, array] : header.arrays) {
    const std::size_t size = std::accumulate(array.shape.begin(), array.shape.end(), std::size_t{1},
                                             std::multiplies<>());
    if (std::visit([](const auto& values) { return values.size(); }, array.values) != size)
      refuse("the array '" + name + "' does not have as many values as its shape says");
  }
}

// The largest power of two whose rounding errs by no more than `precision`; such numbers end in
// zero bits, which compress well.
double grid_of(double precision) {
  if (precision == 0) return 0;
  if (!(precision > 0) || !std::isfinite(precision))
    refuse("the precision of a trajectory must be a positive length in nm");
  return std::exp2(std::floor(std::log2(2 * precision)));
}

}  // namespace

struct TrajectoryWriter::State {
  std::mutex turn;  // one thread at a time
  std::string path;
  TrajectoryHeader header;
  TrajectoryOptions options;
  double grid = 0;  // positions are multiples of it, nm; 0: any

  FrameTable frames;              // of the whole run
  std::vector<float> positions;   // of the frames since the last segment
  std::vector<float> velocities;  // likewise
  std::size_t gathered = 0;       // frames in segments

  struct Segment {
    std::string path;
    std::size_t first;  // number of its first frame
  };
  std::vector<Segment> segments;

  Clock::time_point start = Clock::now();
  Clock::time_point segment_start = start;
  bool closed = false;

  void try_header() const;
  void check(const Frame& frame) const;
  void add(const Frame& frame);
  bool segment_is_due() const;
  void write_segment();
  void write_whole();
  void merge();
  void copy_segments(hid_t file) const;
  std::uintmax_t merged_bytes() const;
  void remove_segments();
  [[noreturn]] void fail(const std::exception& error) const;
  std::vector<std::byte> image(std::optional<std::int64_t> segment) const;
};

// Writes a file without frames in memory: a header that HDF5 refuses (two things of one name, ...)
// must not come to light after hours of simulation.
void TrajectoryWriter::State::try_header() const {
  const hdf5::Session session;
  try {
    write_layout(hdf5::create_in_memory(1 << 16), header, frames, std::nullopt);
  } catch (const hdf5::Failure& failure) {
    refuse("the header of " + path + " cannot be stored: " + failure.what());
  }
}

void TrajectoryWriter::State::check(const Frame& frame) const {
  const auto wanted = 3 * static_cast<std::size_t>(header.atom_count);
  if (closed) refuse(path + " is closed already and takes no more frames");
  if (frame.positions.size() != wanted)
    refuse("a frame for " + path + " has " + std::to_string(frame.positions.size()) +
           " coordinates instead of " + std::to_string(wanted));
  if (frame.velocities.size() != (header.velocities ? wanted : 0))
    refuse("a frame for " + path + " has " + std::to_string(frame.velocities.size()) +
           " velocity components instead of " + std::to_string(header.velocities ? wanted : 0));
  if (frame.box.has_value() != header.periodic)
    refuse("a frame for " + path +
           (header.periodic ? " lacks its box" : " has a box, though it is not periodic"));
  if (frame.observables.size() != header.observables.size())
    refuse("a frame for " + path + " has " + std::to_string(frame.observables.size()) +
           " observables instead of " + std::to_string(header.observables.size()));
  for (std::size_t i = 0; i < frame.observables.size(); ++i)
    if (header.observables[i].integer && !(std::abs(frame.observables[i]) < 0x1p63))
      refuse("the observable '" + header.observables[i].name + "' must be an integer");
}

void TrajectoryWriter::State::add(const Frame& frame) {
  for (const float x : frame.positions)
    positions.push_back(grid > 0 ? static_cast<float>(std::nearbyint(x / grid) * grid) : x);
  velocities.insert(velocities.end(), frame.velocities.begin(), frame.velocities.end());
  frames.times.push_back(static_cast<float>(frame.time));
  frames.steps.push_back(frame.step);
  for (std::size_t i = 0; i < frame.observables.size(); ++i)
    frames.observables[i].push_back(frame.observables[i]);
  if (frame.box) frames.boxes.push_back(*frame.box);
}

bool TrajectoryWriter::State::segment_is_due() const {
  const std::size_t bytes = (positions.size() + velocities.size()) * sizeof(float);
  return bytes >= options.segment_bytes ||
         seconds_since(segment_start) >=
             std::max(options.segment_seconds, options.segment_share * seconds_since(start));
}

// A complete file of the frames since the last segment.
std::vector<std::byte> TrajectoryWriter::State::image(std::optional<std::int64_t> segment) const {
  const hdf5::Session session;
  const std::size_t bytes = (positions.size() + velocities.size()) * sizeof(float);
  const hdf5::Handle file = hdf5::create_in_memory(std::max<std::size_t>(1 << 16, bytes / 4));
  write_layout(file, header, frames.since(gathered), segment);
  write_frames(file, "coordinates", positions);
  if (header.velocities) write_frames(file, "velocities", velocities);
  return hdf5::image_of(file);
}

void TrajectoryWriter::State::write_segment() {
  const std::string name = segment_path(path, segments.size());
  write_file(name, image(static_cast<std::int64_t>(segments.size())));
  segments.push_back({name, gathered});
  gathered = frames.size();
  positions.clear();
  velocities.clear();
  segment_start = Clock::now();
}

void TrajectoryWriter::State::write_whole() {
  write_file(path, image(std::nullopt));
}

void TrajectoryWriter::State::copy_segments(hid_t file) const {
  write_layout(file, header, frames, std::nullopt);
  for (const Segment& segment : segments) {
    const hdf5::Handle source = hdf5::open_to_read(segment.path);
    copy_frames(source, file, "coordinates", segment.first);
    if (header.velocities) copy_frames(source, file, "velocities", segment.first);
  }
}

// About how large the trajectory will be: the frames, an index of them, and what the first segment
// holds besides.
std::uintmax_t TrajectoryWriter::State::merged_bytes() const {
  const hdf5::Session session;
  std::uintmax_t sum = std::filesystem::file_size(segments.front().path);
  for (const Segment& segment : segments) {
    const hdf5::Handle file = hdf5::open_to_read(segment.path);
    sum += stored_bytes(file, "coordinates");
    if (header.velocities) sum += stored_bytes(file, "velocities");
  }
  const std::size_t row = 256 + sizeof(double) * header.observables.size();
  return sum + row * frames.size();
}

void TrajectoryWriter::State::merge() {
  const std::uintmax_t size = merged_bytes();
  if (size <= options.memory_bytes) {
    std::vector<std::byte> content;
    {
      const hdf5::Session session;
      const hdf5::Handle file = hdf5::create_in_memory(std::max<std::size_t>(1 << 16, size / 4));
      copy_segments(file);
      content = hdf5::image_of(file);
    }
    write_file(path, content);
    return;
  }

  // too large for memory: the only file that HDF5 itself writes, into blocks set aside for it
  check_room(path, size);
  try {
    const hdf5::Session session;
    hdf5::Handle file = hdf5::create_on_disk(part_of(path));
    reserve_room(path, size);
    copy_segments(file);
    file.close("finish the file");
  } catch (...) {
    remove_file(part_of(path));
    throw;
  }
  publish(path);
}

void TrajectoryWriter::State::remove_segments() {
  for (const Segment& segment : segments) remove_file(segment.path);
  segments.clear();
}

// One sentence: which file, why, and where its frames are now.
void TrajectoryWriter::State::fail(const std::exception& error) const {
  std::string sentence = error.what();
  if (!dynamic_cast<const TrajectoryError*>(&error))
    sentence = path + " cannot be written: " + sentence;
  if (!segments.empty()) {
    sentence += "; " + std::to_string(gathered) + " of its " + std::to_string(frames.size()) +
                " frames are kept in " + segments.front().path;
    if (segments.size() > 1) sentence += " to " + segments.back().path;
  }
  throw TrajectoryError(sentence);
}

TrajectoryWriter::TrajectoryWriter(std::string path, TrajectoryHeader header,
                                   TrajectoryOptions options)
    : state_(std::make_unique<State>()) {
  check_header(header);
  State& state = *state_;
  state.path = std::move(path);
  state.header = std::move(header);
  state.options = options;
  state.grid = grid_of(options.precision_nm);
  state.frames.observables.resize(state.header.observables.size());
  state.try_header();
  check_output(state.path, options.force);

  // force allows these to go; the trajectory itself stays until the new one replaces it
  const Leftovers old = leftovers_of(state.path);
  for (const std::string& name : old.segments) remove_file(name);
  for (const std::string& name : old.parts) remove_file(name);
}

TrajectoryWriter::~TrajectoryWriter() = default;

void TrajectoryWriter::append(const Frame& frame) {
  const std::lock_guard lock(state_->turn);
  state_->check(frame);
  state_->add(frame);
  if (!state_->segment_is_due()) return;
  try {
    state_->write_segment();
  } catch (const std::exception& error) {
    state_->fail(error);
  }
}

void TrajectoryWriter::close() {
  State& state = *state_;
  const std::lock_guard lock(state.turn);
  if (state.closed) return;
  try {
    if (state.segments.empty()) {
      if (state.frames.size() > 0) state.write_whole();
    } else {
      if (state.gathered < state.frames.size()) state.write_segment();
      state.merge();
    }
  } catch (const std::exception& error) {
    state.fail(error);
  }
  state.remove_segments();
  state.closed = true;
}

void TrajectoryWriter::abandon() {
  const std::lock_guard lock(state_->turn);
  if (state_->closed) return;
  state_->remove_segments();
  state_->closed = true;
}

std::size_t TrajectoryWriter::frame_count() const {
  const std::lock_guard lock(state_->turn);
  return state_->frames.size();
}

bool TrajectoryWriter::closed() const {
  const std::lock_guard lock(state_->turn);
  return state_->closed;
}

}  // namespace ragdoll
