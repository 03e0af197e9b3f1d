// Tests for openmmplugin/trajectory: nothing is lost when something goes wrong.
//
// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "samples.h"

namespace ragdoll {
namespace {

using Names = std::vector<std::string>;

TEST(Trajectory, SegmentsAreCompleteTrajectories) {
  const Folder folder;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain(), one_frame_a_segment());
  append_frames(writer, 0, 3);
  EXPECT_EQ(folder.names(), (Names{"a.000.h5", "a.001.h5", "a.002.h5"}));

  const TrajectoryReader second(folder / "a.001.h5");
  EXPECT_EQ(second.header(), header_of_chain());
  ASSERT_EQ(second.frame_count(), 1U);
  EXPECT_EQ(second.positions(0), positions_of(1));
  EXPECT_EQ(second.steps(), std::vector<std::int64_t>{100});
}

TEST(Trajectory, SegmentsAreMergedIntoOneFile) {
  for (const std::size_t memory : {std::size_t{1} << 20, std::size_t{0}}) {
    const Folder folder;
    TrajectoryOptions options;
    options.segment_bytes = 3 * sizeof(float) * 3 * kAtoms;  // three frames
    options.memory_bytes = memory;                           // 0: merged on the disk
    TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
    append_frames(writer, 0, 11);
    EXPECT_EQ(folder.names().size(), 3U);
    writer.close();
    EXPECT_EQ(folder.names(), Names{"a.h5"});

    const TrajectoryReader reader(folder / "a.h5");
    EXPECT_EQ(reader.header(), header_of_chain());
    ASSERT_EQ(reader.frame_count(), 11U);
    for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(reader.positions(i), positions_of(i));
    EXPECT_EQ(reader.steps().back(), 1000);
  }
}

TEST(Trajectory, ASegmentEndsWhenItHasLastedLongEnough) {
  const Folder folder;
  TrajectoryOptions options;
  options.segment_seconds = 0.02;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
  append_frames(writer, 0, 1);
  EXPECT_TRUE(folder.names().empty());
  usleep(30000);
  append_frames(writer, 1, 2);
  EXPECT_EQ(folder.names(), Names{"a.000.h5"});
}

TEST(Trajectory, TheDestructorKeepsFinishedSegments) {
  const Folder folder;
  {
    TrajectoryWriter writer(folder / "a.h5", header_of_chain(), one_frame_a_segment());
    append_frames(writer, 0, 2);
  }
  EXPECT_EQ(folder.names(), (Names{"a.000.h5", "a.001.h5"}));
}

TEST(Trajectory, AbandoningRemovesAllThatTheWriterMade) {
  const Folder folder;
  put_file(folder / "a.h5", "an older file");
  TrajectoryOptions options = one_frame_a_segment();
  options.force = true;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
  append_frames(writer, 0, 2);
  writer.abandon();
  EXPECT_EQ(folder.names(), Names{"a.h5"});
  EXPECT_THROW(append_frames(writer, 2, 3), TrajectoryUsageError);
}

TEST(Trajectory, WithoutFramesNothingIsWrittenAndNothingReplaced) {
  const Folder folder;
  put_file(folder / "a.h5", "an older file");
  TrajectoryOptions options;
  options.force = true;
  TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
  writer.close();
  EXPECT_TRUE(writer.closed());
  EXPECT_EQ(std::filesystem::file_size(folder / "a.h5"), 13U);
}

TEST(Trajectory, ForceReplacesTheFileAndItsOldSegments) {
  const Folder folder;
  put_file(folder / "a.h5", "an older file");
  put_file(folder / "a.000.h5.part", "half a segment");
  TrajectoryOptions options = one_frame_a_segment();
  options.force = true;
  {
    TrajectoryWriter killed(folder / "a.h5", header_of_chain(), options);
    append_frames(killed, 0, 4);
  }
  TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
  EXPECT_EQ(folder.names(), Names{"a.h5"});
  append_frames(writer, 0, 2);
  writer.close();
  EXPECT_EQ(folder.names(), Names{"a.h5"});
  EXPECT_EQ(TrajectoryReader(folder / "a.h5").frame_count(), 2U);
}

TEST(Trajectory, RefusalsSayWhatToDo) {
  const Folder folder;
  const auto refusal = [](const std::string& path, bool force = false) {
    return sentence_of<TrajectoryUsageError>([&] { check_output(path, force); });
  };
  const std::string path = folder / "a.h5";
  EXPECT_EQ(refusal(""), "a trajectory needs a file name");
  EXPECT_EQ(refusal(folder / "none/a.h5"), (folder / "none/a.h5") +
                                               " cannot be written: there is no folder " +
                                               (folder / "none") + "; make it first");
  EXPECT_EQ(refusal("/dev/null", true), "/dev/null is not a regular file; give another name");

  put_file(path, "an older file");
  EXPECT_EQ(refusal(path), path + " exists already; give --force to replace it");
  std::filesystem::rename(path, folder / "a.000.h5");
  EXPECT_EQ(refusal(path), (folder / "a.000.h5") + " is left from an interrupted run of " + path +
                               "; move it away, or give --force to remove it");
  EXPECT_EQ(refusal(path, true), (folder / "a.000.h5") + " is in the way of " + path +
                                     " and is not a segment of it; move it away");
  std::filesystem::rename(folder / "a.000.h5", path + ".part");
  EXPECT_EQ(refusal(path), path + ".part is left from an interrupted run of " + path +
                               "; move it away, or give --force to remove it");
  std::filesystem::remove(path + ".part");

  std::filesystem::create_directory(path);
  EXPECT_EQ(refusal(path, true), path + " is a folder; give the name of a file in it");
  if (geteuid() != 0) {
    std::filesystem::permissions(path, std::filesystem::perms::owner_read);
    EXPECT_EQ(refusal(path + "/b.h5"), path + "/b.h5 cannot be written: Permission denied");
  }
}

// Runs `body` in a child process; true if it returned true.
template <typename Body>
bool in_child(const Body& body) {
  const pid_t child = fork();
  if (child == 0) {
    bool good = false;
    try {
      good = body();
    } catch (const std::exception& error) {
      fprintf(stderr, "%s\n", error.what());
    }
    _exit(good ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void limit_file_size(rlim_t bytes) {
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_FSIZE, &limit);
}

TEST(Trajectory, AFileSizeLimitGivesASentenceAndNoStrayFile) {
  const Folder folder;
  const std::string path = folder / "a.h5";
  EXPECT_TRUE(in_child([&] {
    limit_file_size(4096);  // SIGXFSZ keeps its default, which would end the process
    TrajectoryWriter writer(path, header_of_chain());
    append_frames(writer, 0, 3);
    const std::string sentence = sentence_of<TrajectoryError>([&] { writer.close(); });
    return sentence == path + " cannot be written: File too large" && folder.names().empty();
  }));
}

TEST(Trajectory, SegmentsAreKeptAndNamedIfTheyCannotBeMerged) {
  for (const std::size_t memory : {std::size_t{1} << 20, std::size_t{0}}) {
    const Folder folder;
    const std::string path = folder / "a.h5";
    EXPECT_TRUE(in_child([&] {
      TrajectoryOptions options = one_frame_a_segment();
      options.memory_bytes = memory;
      TrajectoryWriter writer(path, header_of_chain(), options);
      append_frames(writer, 0, 3);
      limit_file_size(std::filesystem::file_size(folder / "a.000.h5") / 2);
      const std::string sentence = sentence_of<TrajectoryError>([&] { writer.close(); });
      return sentence == path +
                             " cannot be written: File too large; 3 of its 3 frames are kept in " +
                             (folder / "a.000.h5") + " to " + (folder / "a.002.h5");
    }));
    EXPECT_EQ(folder.names(), (Names{"a.000.h5", "a.001.h5", "a.002.h5"}));
  }
}

TEST(Trajectory, ALostSegmentIsReportedAndTheOthersAreKept) {
  for (const std::size_t memory : {std::size_t{1} << 20, std::size_t{0}}) {
    const Folder folder;
    TrajectoryOptions options = one_frame_a_segment();
    options.memory_bytes = memory;
    TrajectoryWriter writer(folder / "a.h5", header_of_chain(), options);
    append_frames(writer, 0, 3);
    put_file(folder / "a.001.h5", "overwritten by somebody");
    const std::string sentence = sentence_of<TrajectoryError>([&] { writer.close(); });
    EXPECT_TRUE(sentence.starts_with((folder / "a.h5") + " cannot be written: HDF5 cannot open " +
                                     (folder / "a.001.h5")))
        << sentence;
    EXPECT_EQ(folder.names(), (Names{"a.000.h5", "a.001.h5", "a.002.h5"}));
  }
}

TEST(Trajectory, AKilledRunLeavesItsSegments) {
  const Folder folder;
  EXPECT_FALSE(in_child([&] {
    TrajectoryWriter writer(folder / "a.h5", header_of_chain(), one_frame_a_segment());
    append_frames(writer, 0, 3);
    raise(SIGKILL);
    return true;
  }));
  EXPECT_EQ(folder.names(), (Names{"a.000.h5", "a.001.h5", "a.002.h5"}));
  EXPECT_EQ(TrajectoryReader(folder / "a.002.h5").positions(0), positions_of(2));
}

}  // namespace
}  // namespace ragdoll
