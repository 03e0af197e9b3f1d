// Small trajectories for the tests, in a folder that removes itself.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "ragdoll/trajectory/reader.h"
#include "ragdoll/trajectory/writer.h"

namespace ragdoll {

/// A new folder, gone with its scope.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "ragdoll.XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  /// Names of all that is in it, sorted.
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      found.push_back(entry.path().filename().string());
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  std::filesystem::path path_;
};

constexpr std::size_t kAtoms = 4;

/// A chain of four carbons with an observable of each type.
inline TrajectoryHeader header_of_chain() {
  TrajectoryHeader header;
  header.atom_count = kAtoms;
  header.topology_json = R"({"chains": [], "bonds": []})";
  header.bonds = {0, 1, 1, 2, 2, 3};
  header.atomic_numbers = {6, 6, 6, 6};
  header.observables = {{"iterations", true, ""}, {"residual", false, "nm"}};
  return header;
}

/// Position of a coordinate in a frame: different everywhere, and not a short binary number.
inline float coordinate(std::size_t frame, std::size_t i) {
  return 0.1F * static_cast<float>(i) + 0.01234567F * static_cast<float>(frame);
}

inline std::vector<float> positions_of(std::size_t frame) {
  std::vector<float> positions(3 * kAtoms);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = coordinate(frame, i);
  return positions;
}

/// Appends frames first, ..., last - 1 for header_of_chain().
inline void append_frames(TrajectoryWriter& writer, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    const std::vector<float> positions = positions_of(i);
    const double observables[] = {static_cast<double>(i), 0.5 * static_cast<double>(i)};
    Frame frame;
    frame.positions = positions;
    frame.time = 0.25 * static_cast<double>(i);
    frame.step = static_cast<std::int64_t>(100 * i);
    frame.observables = observables;
    writer.append(frame);
  }
}

/// A segment for each frame.
inline TrajectoryOptions one_frame_a_segment() {
  TrajectoryOptions options;
  options.segment_bytes = 1;
  return options;
}

inline void put_file(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
}

/// The sentence with which `action` refuses.
template <typename Error, typename Action>
std::string sentence_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace ragdoll
