// Tests for openmmplugin/method_files: the index of a set.

#include <gtest/gtest.h>

#include <limits>

#include "ragdoll/method_files/results_file.h"
#include "samples.h"

namespace ragdoll {
namespace {

TEST(ResultsFile, RoundTripsAreExact) {
  ResultSet set;
  set.seed = std::numeric_limits<std::uint64_t>::max();
  set.structures.push_back({"tree", "tree/001/structure.xml"});
  set.structures.push_back({"1-cycle",
                            "1-cycle/001/structure.xml",
                            "1-cycle/001/order.xml",
                            {"1-cycle/001/forces/01.xml", "1-cycle/001/forces/02.xml"},
                            {{"1-cycle/001/techniques/bfs_cycle_.5-.5", "bfs_cycle", ".5/.5"},
                             {"1-cycle/001/techniques/a & b"}}});
  const Folder folder;
  write_results(folder / "results.xml", set);
  Warnings warnings;
  const ResultSet back = read_results(folder / "results.xml", &warnings);

  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(back.seed, set.seed);
  ASSERT_EQ(back.structures.size(), 2U);
  EXPECT_EQ(back.structures[0].class_name, "tree");
  EXPECT_EQ(back.structures[0].structure, "tree/001/structure.xml");
  EXPECT_TRUE(back.structures[0].order.empty());
  const ResultStructure& a = set.structures[1];
  const ResultStructure& b = back.structures[1];
  EXPECT_EQ(b.order, a.order);
  EXPECT_EQ(b.forces, a.forces);
  ASSERT_EQ(b.techniques.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(b.techniques[k].folder, a.techniques[k].folder);
    EXPECT_EQ(b.techniques[k].order, a.techniques[k].order);
    EXPECT_EQ(b.techniques[k].weighting, a.techniques[k].weighting);
  }
}

TEST(ResultsFile, ResultsThatCouldNotBeReadBackAreNotWritten) {
  const Folder folder;
  const auto refusal = [&](const ResultSet& set) {
    return error_of([&] { write_results(folder / "results.xml", set); });
  };
  EXPECT_EQ(refusal({1, {{"tree", "../s.xml"}}}),
            "the results name the path \"../s.xml\", which leads out of the set");
  EXPECT_EQ(refusal({1, {{"tree", "s.xml"}, {"tree", "s.xml"}}}),
            "the results name the structure s.xml twice");
  EXPECT_EQ(refusal({1, {{"", "s.xml"}}}), "the results name no class for the structure s.xml");
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace ragdoll
