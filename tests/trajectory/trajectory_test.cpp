// Tests for openmmplugin/trajectory: what is written is read.
//
// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <cmath>

#include "samples.h"

namespace ragdoll {
namespace {

std::vector<double> doubles(const Values& values) {
  return std::get<std::vector<double>>(values);
}

TEST(Trajectory, FramesComeBackAsTheyWere) {
  const Folder folder;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain());
  append_frames(writer, 0, 5);
  writer.close();

  const TrajectoryReader reader(folder / "a.h5");
  ASSERT_EQ(reader.frame_count(), 5U);
  EXPECT_EQ(reader.atom_count(), kAtoms);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(reader.positions(i), positions_of(i));
  EXPECT_EQ(reader.times(), (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(reader.steps(), (std::vector<std::int64_t>{0, 100, 200, 300, 400}));
  EXPECT_EQ(reader.observable("iterations"), Values(std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(doubles(reader.observable("residual")), (std::vector<double>{0, .5, 1, 1.5, 2}));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.h5"});
}

TEST(Trajectory, HeaderComesBackAsItWas) {
  TrajectoryHeader header = header_of_chain();
  header.program_version = "1.2";
  header.author = "Jörg";
  header.attributes = {{"seed", std::int64_t{7}}, {"input_hash", "ab12"}, {"scale", 0.5}};
  header.texts = {
      {"parameters", R"({"a": 1})"}, {"log/solver", ""}, {"long", std::string(99999, 'x')}};
  header.arrays["framework/bars"] = {{2, 2}, std::vector<std::int32_t>{0, 1, 1, 2}};
  header.arrays["framework/bar_lengths"] = {{2}, std::vector<double>{0.15, 0.1523456789}};
  header.arrays["framework/none"] = {{0, 3}, std::vector<double>{}};
  header.arrays["total"] = {{}, std::vector<std::int64_t>{std::int64_t{1} << 40}};

  const Folder folder;
  TrajectoryWriter writer(folder / "a.h5", header);
  append_frames(writer, 0, 1);
  writer.close();
  EXPECT_EQ(TrajectoryReader(folder / "a.h5").header(), header);
}

TEST(Trajectory, BoxesAndVelocitiesComeBackAsTheyWere) {
  TrajectoryHeader header;
  header.atom_count = 1;
  header.periodic = header.velocities = true;
  const float position[] = {1, 2, 3}, velocity[] = {4, 5, 6};
  Frame frame;
  frame.positions = position;
  frame.velocities = velocity;
  frame.box = BoxVectors{2, 0, 0, 0.5, 3, 0, 0.25, 0.5, 4};

  const Folder folder;
  TrajectoryOptions options = one_frame_a_segment();
  TrajectoryWriter writer(folder / "a.h5", header, options);
  writer.append(frame);
  writer.append(frame);
  writer.close();

  const TrajectoryReader reader(folder / "a.h5");
  ASSERT_TRUE(reader.periodic());
  EXPECT_EQ(reader.boxes(), (std::vector<BoxVectors>{*frame.box, *frame.box}));
  std::vector<float> velocities(6);
  reader.read_velocities(0, velocities);
  EXPECT_EQ(velocities, (std::vector<float>{4, 5, 6, 4, 5, 6}));
}

TEST(Trajectory, RoundingErrsByNoMoreThanThePrecision) {
  const Folder folder;
  TrajectoryOptions options;
  options.precision_nm = 1e-4;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
  append_frames(writer, 0, 3);
  writer.close();

  const std::vector<float> exact = positions_of(2);
  const std::vector<float> read = TrajectoryReader(folder / "a.h5").positions(2);
  bool rounded = false;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(read[i], exact[i], 1e-4);
    EXPECT_EQ(std::ldexp(read[i], 13), std::round(std::ldexp(read[i], 13)));
    rounded = rounded || read[i] != exact[i];
  }
  EXPECT_TRUE(rounded);
}

TEST(Trajectory, FramesThatDoNotFitAreRefusedAndNotKept) {
  const Folder folder;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain());
  const std::vector<float> positions = positions_of(0);
  const double observables[] = {1, 2}, uneven[] = {std::nan(""), 2};
  const auto refused = [&](auto change) {
    Frame frame;
    frame.positions = positions;
    frame.observables = observables;
    change(frame);
    EXPECT_THROW(writer.append(frame), TrajectoryUsageError);
  };
  refused([&](Frame& frame) { frame.positions = frame.positions.first(3); });
  refused([&](Frame& frame) { frame.observables = frame.observables.first(1); });
  refused([&](Frame& frame) { frame.observables = uneven; });
  refused([&](Frame& frame) { frame.velocities = positions; });
  refused([&](Frame& frame) { frame.box = BoxVectors{}; });
  EXPECT_EQ(writer.frame_count(), 0U);
}

TEST(Trajectory, HeadersThatContradictThemselvesAreRefused) {
  const Folder folder;
  const auto refused = [&](auto change) {
    TrajectoryHeader header = header_of_chain();
    change(header);
    EXPECT_THROW(TrajectoryWriter(folder / "a.h5", header), TrajectoryUsageError);
  };
  refused([](TrajectoryHeader& h) { h.atom_count = 0; });
  refused([](TrajectoryHeader& h) { h.bonds = {0, 4}; });
  refused([](TrajectoryHeader& h) { h.bonds = {0}; });
  refused([](TrajectoryHeader& h) { h.atomic_numbers = {6}; });
  refused([](TrajectoryHeader& h) { h.observables = {{"a/b", false, ""}}; });
  refused([](TrajectoryHeader& h) { h.observables = {{"a", false, ""}, {"a", true, ""}}; });
  refused([](TrajectoryHeader& h) { h.attributes["segment"] = 1.0; });
  refused([](TrajectoryHeader& h) { h.arrays["a"] = {{2}, std::vector<double>{1}}; });
  refused([](TrajectoryHeader& h) {
    h.arrays["a/b"] = {{1}, std::vector<double>{1}};
    h.texts["a"] = "an array's group has this name";
  });
  EXPECT_TRUE(folder.names().empty());
}

TEST(Trajectory, AFrameOrObservableThatIsNotThereIsRefused) {
  const Folder folder;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain());
  append_frames(writer, 0, 2);
  writer.close();
  const TrajectoryReader reader(folder / "a.h5");
  EXPECT_THROW(reader.positions(2), TrajectoryUsageError);
  EXPECT_THROW(reader.observable("energy"), TrajectoryUsageError);
  std::vector<float> room(3 * kAtoms);
  EXPECT_THROW(reader.read_velocities(0, room), TrajectoryUsageError);
}

TEST(Trajectory, UnreadableFilesGiveOneSentence) {
  const Folder folder;
  TrajectoryWriter writer(folder / "good.h5", header_of_chain());
  append_frames(writer, 0, 50);
  writer.close();

  // garbage, nothing at all, and a file cut short
  put_file(folder / "garbage.h5", "this is not HDF5");
  put_file(folder / "empty.h5", "");
  std::filesystem::copy_file(folder / "good.h5", folder / "cut.h5");
  std::filesystem::resize_file(folder / "cut.h5",
                               std::filesystem::file_size(folder / "cut.h5") / 2);
  for (const char* name : {"garbage.h5", "empty.h5", "cut.h5"}) {
    const std::string path = folder / name;
    EXPECT_EQ(sentence_of<TrajectoryError>([&] { TrajectoryReader reader(path); }),
              path + " cannot be read: it is not an HDF5 file, is cut short or protected");
  }
  const std::string none = folder / "none.h5";
  EXPECT_EQ(sentence_of<TrajectoryUsageError>([&] { TrajectoryReader reader(none); }),
            "there is no file " + none);
}

TEST(Trajectory, ADamagedFrameIsReportedAndTheOthersAreRead) {
  const Folder folder;
  const std::string path = folder / "a.h5";
  TrajectoryHeader header;
  header.atom_count = 20000;
  TrajectoryWriter writer(path, header);
  std::vector<float> positions(60000);
  for (std::size_t frame = 0; frame < 4; ++frame) {
    for (std::size_t i = 0; i < positions.size(); ++i)
      positions[i] = std::sin(static_cast<float>(i + 7 * frame));
    Frame one;
    one.positions = positions;
    writer.append(one);
  }
  writer.close();

  // the frames fill most of the file, so its middle lies in one of them
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(path) / 2));
  file << std::string(64, 'x');
  file.close();

  const TrajectoryReader reader(path);
  std::size_t damaged = 0;
  for (std::size_t frame = 0; frame < 4; ++frame) {
    try {
      reader.positions(frame);
    } catch (const TrajectoryError& error) {
      ++damaged;
      EXPECT_TRUE(std::string(error.what()).starts_with(path + " is damaged: ")) << error.what();
    }
  }
  EXPECT_EQ(damaged, 1U);
}

}  // namespace
}  // namespace ragdoll
