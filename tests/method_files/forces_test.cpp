// Tests for openmmplugin/method_files: forces that are read and written.

#include <gtest/gtest.h>

#include "ragdoll/method_files/force_file.h"
#include "samples.h"

namespace ragdoll {
namespace {

void expect_same(const ForceSet& a, const ForceSet& b) {
  EXPECT_EQ(a.structure, b.structure);
  EXPECT_EQ(a.max_iterations, b.max_iterations);
  EXPECT_EQ(a.tolerance, b.tolerance);
  EXPECT_EQ(a.timestep, b.timestep);
  ASSERT_EQ(a.forces.size(), b.forces.size());
  for (std::size_t k = 0; k < a.forces.size(); ++k) {
    EXPECT_EQ(a.forces[k].joint, b.forces[k].joint);
    EXPECT_EQ(a.forces[k].force, b.forces[k].force);
  }
}

TEST(ForceFile, ExampleOfTheSpecificationIsRead) {
  const Folder folder;
  const ForceSet set = read_forces(folder.write("f.xml", R"(
<forces version="1" structure="s.xml" max-iterations="500" tolerance="0.01" timestep="2">
  <force joint="b" x="0.1" y="-0.3" z="0"/>            <!-- one step each, in this order -->
  <force z="1e-3" joint="a" y="0" x="0"></force>
</forces>)"),
                                   square());
  expect_same(set, {{{1, Vec3(0.1, -0.3, 0)}, {0, Vec3(0, 0, 1e-3)}}, "s.xml", 500, 0.01, 2});
}

TEST(ForceFile, WhatIsNotStatedIsAsTheSpecificationSays) {
  const Folder folder;
  const ForceSet set = read_forces(folder.write("f.xml", "<forces version=\"1\"/>"), square());
  expect_same(set, {{}, "", 10000, 0.001, 1});
}

TEST(ForceFile, RoundTripsAreExact) {
  const Folder folder;
  const ForceSet set = {
      {{3, Vec3(0.1, -1.0 / 3, 1e-300)}, {0, Vec3(0, 0, -0.0)}, {3, Vec3(1, 2, 3)}},
      "sets & more/s \"1\".xml",
      123456789012,
      1.0 / 3e9,
      0.1};
  write_forces(folder / "f.xml", square(), set);
  Warnings warnings;
  expect_same(read_forces(folder / "f.xml", square(), &warnings), set);
  EXPECT_TRUE(warnings.empty());
}

TEST(ForceFile, WithoutAStructureJointsKeepTheirIds) {
  const Folder folder;
  const NamedForces named = read_forces(folder.write("f.xml", R"(<forces version="1">
<force joint="q" x="0" y="0" z="0"/><force joint="p" x="0" y="0" z="0"/>
<force joint="q" x="0" y="0" z="0"/></forces>)"));
  EXPECT_EQ(named.ids, (std::vector<std::string>{"q", "p"}));
  EXPECT_EQ(named.set.forces[0].joint, 0);
  EXPECT_EQ(named.set.forces[1].joint, 1);
  EXPECT_EQ(named.set.forces[2].joint, 0);
}

TEST(ForceFile, ForcesThatCouldNotBeReadBackAreNotWritten) {
  const Folder folder;
  const auto refusal = [&](const ForceSet& set) {
    return error_of([&] { write_forces(folder / "f.xml", square(), set); });
  };
  EXPECT_EQ(refusal({{{4, Vec3::Zero()}}}), "force 0 acts on joint 4, but there are 4");
  EXPECT_EQ(refusal({{{0, Vec3(0, 0, 1.0 / 0.0)}}}), "force 0 is not finite");
  EXPECT_EQ(refusal({{}, "", 0}), "the maximum of iterations is not positive");
  EXPECT_NE(refusal({{}, "", 1, 0}), "");
  EXPECT_NE(refusal({{}, "", 1, 1, 1.0 / 0.0}), "");
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace ragdoll
