// Tests for openmmplugin/trajectory: many trajectories in one file.
//
// SPDX-License-Identifier: MIT

#include "ragdoll/trajectory/collection.h"

#include <gtest/gtest.h>

#include <span>

#include "samples.h"

namespace ragdoll {
namespace {

/// Adds the chain of samples.h with frames of these numbers.
void add_chain(CollectionWriter& writer, const std::string& name, std::size_t begin,
               std::size_t end) {
  std::vector<std::vector<float>> positions;
  for (std::size_t i = begin; i < end; ++i) positions.push_back(positions_of(i));
  const double observables[] = {1, 0.5};
  std::vector<Frame> frames(positions.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].positions = positions[k];
    frames[k].step = static_cast<std::int64_t>(k);
    frames[k].observables = observables;
  }
  TrajectoryHeader header = header_of_chain();
  header.attributes["title"] = "molecule " + name;
  writer.add(name, header, frames);
}

TrajectoryHeader about() {
  TrajectoryHeader header;
  header.attributes["seed"] = std::int64_t{7};
  header.texts["parameters"] = "{}";
  return header;
}

TEST(Collection, EachMoleculeComesBackAsATrajectory) {
  const Folder folder;
  {
    CollectionWriter writer(folder / "a.h5", about(), false, 0);
    add_chain(writer, "two", 3, 5);
    add_chain(writer, "one", 0, 3);
    EXPECT_EQ(folder.names(), std::vector<std::string>{"a.h5.part"});
    writer.close();
  }
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.h5"});
  EXPECT_EQ(names_in_collection(folder / "a.h5"), (std::vector<std::string>{"one", "two"}));

  const TrajectoryReader one(folder / "a.h5", "one"), two(folder / "a.h5", "two");
  ASSERT_EQ(one.frame_count(), 3U);
  ASSERT_EQ(two.frame_count(), 2U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(one.positions(i), positions_of(i));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(two.positions(i), positions_of(3 + i));
  EXPECT_EQ(one.observable("iterations"), Values(std::vector<std::int64_t>{1, 1, 1}));
  EXPECT_EQ(two.header().attributes.at("title"), Attribute("molecule two"));
  EXPECT_EQ(two.header().bonds, header_of_chain().bonds);
}

TEST(Collection, ManyMoleculesTakeLittleRoomEach) {
  const Folder folder;
  CollectionWriter writer(folder / "a.h5", about(), false, 0);
  for (int k = 0; k < 200; ++k) add_chain(writer, std::to_string(k), 0, 2);
  writer.close();
  EXPECT_EQ(names_in_collection(folder / "a.h5").size(), 200U);
  EXPECT_LT(std::filesystem::file_size(folder / "a.h5"), 200U * 16000U);
}

TEST(Collection, WithoutACloseNothingIsLeft) {
  const Folder folder;
  {
    CollectionWriter writer(folder / "a.h5", about(), false, 0);
    add_chain(writer, "one", 0, 3);
  }
  EXPECT_TRUE(folder.names().empty());
}

TEST(Collection, NamesAreUniqueAndHaveNoSlash) {
  const Folder folder;
  CollectionWriter writer(folder / "a.h5", about(), false, 0);
  add_chain(writer, "one", 0, 1);
  for (const std::string name : {"one", "", "a/b", "."})
    EXPECT_THROW(add_chain(writer, name, 0, 1), TrajectoryUsageError) << name;
  writer.close();
  EXPECT_THROW(add_chain(writer, "two", 0, 1), TrajectoryUsageError);
}

TEST(Collection, FramesThatDoNotFitTheirHeaderAreRefused) {
  const Folder folder;
  CollectionWriter writer(folder / "a.h5", about(), false, 0);
  const std::vector<float> short_row(3 * kAtoms - 1);
  const double observables[] = {1, 0.5};
  Frame frame;
  frame.positions = short_row;
  frame.observables = observables;
  EXPECT_THROW(writer.add("one", header_of_chain(), std::span(&frame, 1)), TrajectoryUsageError);
}

TEST(Collection, AnExistingFileStaysUnlessForced) {
  const Folder folder;
  const auto write = [&](bool force) {
    CollectionWriter writer(folder / "a.h5", about(), force, 0);
    add_chain(writer, "one", 0, 1);
    writer.close();
  };
  write(false);
  EXPECT_THROW(write(false), TrajectoryUsageError);
  write(true);
}

TEST(Collection, ADiskThatIsTooFullIsNoticedBeforeAnythingIsWritten) {
  const Folder folder;
  EXPECT_THROW(CollectionWriter(folder / "a.h5", about(), false, std::uintmax_t{1} << 60),
               TrajectoryError);
  EXPECT_TRUE(folder.names().empty());
}

TEST(Collection, ReadersSayWhichMoleculeIsMissing) {
  const Folder folder;
  CollectionWriter writer(folder / "a.h5", about(), false, 0);
  add_chain(writer, "one", 0, 1);
  writer.close();
  EXPECT_THROW(TrajectoryReader(folder / "a.h5"), TrajectoryUsageError);
  EXPECT_THROW(TrajectoryReader(folder / "a.h5", "two"), TrajectoryUsageError);
  EXPECT_THROW(TrajectoryReader(folder / "a.h5", "../molecules/one"), TrajectoryUsageError);
  EXPECT_THROW(names_in_collection(folder / "none.h5"), TrajectoryUsageError);

  TrajectoryWriter single(folder / "b.h5", header_of_chain());
  append_frames(single, 0, 2);
  single.close();
  EXPECT_TRUE(names_in_collection(folder / "b.h5").empty());
}

}  // namespace
}  // namespace ragdoll
