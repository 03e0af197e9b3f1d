// Tests for openmmplugin/method_files: a file is written whole or not at all.

#include <gtest/gtest.h>
#include <sys/resource.h>  // setrlimit

#include <csignal>
#include <limits>

#include "ragdoll/method_files/structure_file.h"
#include "samples.h"

namespace ragdoll {
namespace {

TEST(Writing, AFileThatIsThereIsReplacedOnlyByForce) {
  const Folder folder;
  const std::string path = folder.write("s.xml", "mine");
  EXPECT_EQ(error_of([&] { write_structure(path, square()); }),
            path + " exists already; give --force to replace it");
  EXPECT_EQ(text_of_file(path), "mine");
  write_structure(path, square(), {true});
  EXPECT_EQ(fingerprint(read_structure(path)), fingerprint(square()));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"s.xml"});
}

TEST(Writing, PlacesWhereNoFileCanBeAreRefused) {
  const Folder folder;
  const auto refusal = [](const std::string& path) {
    return error_of([&] { write_structure(path, square(), {true}); });
  };
  const std::string nowhere = folder / "no/s.xml", directory = folder / "";
  EXPECT_EQ(refusal(nowhere), nowhere + " cannot be written: No such file or directory");
  EXPECT_EQ(refusal(directory), directory + " is a folder; give the name of a file in it");
  EXPECT_EQ(refusal("/dev/null"), "/dev/null is not a regular file; give another name");
  EXPECT_EQ(refusal(""), "the file to write has no name");
}

TEST(Writing, AFullDiskLeavesNothingBehind) {
  const Folder folder;
  const std::string path = folder.write("s.xml", "mine");
  Structure big = square();
  for (int j = 0; j < 1000; ++j) {
    big.ids.push_back(std::to_string(j));
    big.positions.emplace_back(j, 0, 0);
    big.parts.masses.push_back(1);
    big.parts.fixed.push_back(0);
  }

  // the size of files is limited for a moment, with EFBIG in place of the signal
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 4096;
  setrlimit(RLIMIT_FSIZE, &small);
  std::string message;
  try {
    write_structure(path, big, {true});
  } catch (const FileError& error) {
    message = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);

  EXPECT_EQ(message, path + " cannot be written: File too large");
  EXPECT_EQ(text_of_file(path), "mine");
  EXPECT_EQ(folder.names(), std::vector<std::string>{"s.xml"});
}

TEST(Writing, StructuresThatCouldNotBeReadBackAreNotWritten) {
  const Folder folder;
  const auto refusal = [&](auto change) {
    Structure structure = square();
    change(structure);
    return error_of([&] { write_structure(folder / "s.xml", structure); });
  };
  EXPECT_EQ(refusal([](Structure& s) { s = {}; }), "the structure has no joints");
  EXPECT_EQ(refusal([](Structure& s) { s.ids[1] = "a"; }), "two joints have the id a");
  EXPECT_EQ(refusal([](Structure& s) { s.ids[1] = "b b"; }), "the id \"b b\" has a space in it");
  EXPECT_EQ(refusal([](Structure& s) { s.ids[1] = ""; }), "joint 1 has an empty id");
  EXPECT_EQ(refusal([](Structure& s) { s.ids[1] = "\x01"; }),
            "the id of joint 1 is not text in UTF-8");
  EXPECT_EQ(refusal([](Structure& s) { s.positions[2][1] = 0.0 / 0.0; }),
            "the position of joint c is not finite");
  EXPECT_EQ(refusal([](Structure& s) { s.positions.pop_back(); }),
            "the structure does not have one id, position and mass for each joint");
  EXPECT_EQ(refusal([](Structure& s) { s.parts.bars[0].q = 0; }), "a bar goes from a to itself");
  EXPECT_EQ(refusal([](Structure& s) { s.class_name = "tree"; }),
            "the class is said to be tree, but the bars make it 1-cycle");
  EXPECT_EQ(refusal([](Structure& s) { s.length_unit = "\xff"; }).substr(0, 8),
            (folder / "s.xml").substr(0, 8));
  EXPECT_NE(refusal([](Structure& s) { s.length_unit = ""; }), "");
  EXPECT_EQ(error_of([&] {
              write_structure(folder / "s.xml", square(), {false, 18});
            }),
            "numbers are written with 1 to 17 digits");
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace ragdoll
