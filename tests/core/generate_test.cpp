// Tests for core/src/generate.cpp and the sketches of the classes.

#include <gtest/gtest.h>

#include <algorithm>  // minmax, count
#include <cmath>      // abs, sqrt
#include <map>
#include <set>

#include "examples.h"  // refusal_of
#include "naive_classify.h"
#include "ragdoll/classify.h"
#include "ragdoll/force_run.h"  // framework_of
#include "ragdoll/generate.h"

namespace ragdoll {
namespace {

using naive::Bars;

Bars bars_of(const Structure& structure) {
  Bars bars;
  for (const Bar& bar : structure.parts.bars) bars.emplace_back(bar.p, bar.q);
  return bars;
}

int joints_of(const Structure& structure) {
  return int(structure.positions.size());
}

Graph graph_of(const Structure& structure) {
  return Graph(joints_of(structure), bars_of(structure));
}

Structure make(const std::string& class_name, int joints, std::uint64_t seed,
               const std::string& construction = "", const std::string& type = "") {
  StructureRequest request;
  request.class_name = class_name;
  request.joints = joints;
  request.seed = seed;
  request.construction = construction;
  request.type = type;
  return generate_structure(request);
}

std::string refusal(const StructureRequest& request) {
  return examples::refusal_of([&] { generate_structure(request); });
}

std::vector<int> degrees_of(const Structure& structure) {
  std::vector<int> degrees(structure.positions.size(), 0);
  for (const auto& [p, q] : bars_of(structure))
    ++degrees[std::size_t(p)], ++degrees[std::size_t(q)];
  return degrees;
}

double mean_length(const Structure& structure) {
  double sum = 0;
  for (const Bar& bar : structure.parts.bars) sum += bar.length;
  return sum / double(structure.parts.bars.size());
}

/// The smallest structure of each class.
const std::map<std::string, int> least_joints = {
    {"tree", 2},  {"1-cycle", 3}, {"2-cycle", 4},    {"n-cycle", 4}, {"grid", 2},
    {"cloth", 3}, {"thread", 3},  {"ring-chain", 3}, {"regular", 2}, {"protein", 4}};

// === All classes

TEST(Generate, EveryClassMeetsTheNumberOfJointsExactlyAndIsConnected) {
  ASSERT_EQ(structure_classes().size(), least_joints.size());
  for (const std::string& name : structure_classes()) {
    for (int joints = least_joints.at(name); joints < 60; ++joints) {
      const Structure structure = make(name, joints, 7);
      EXPECT_EQ(joints_of(structure), joints) << name;
      EXPECT_EQ(int(structure.ids.size()), joints) << name;
      EXPECT_EQ(naive::component_count(joints, bars_of(structure)), 1) << name << " " << joints;
      EXPECT_EQ(structure.class_name, name);
    }
  }
}

TEST(Generate, BarsHaveTheirPresentLengthsAndJoinDifferentPairs) {
  for (const std::string& name : structure_classes()) {
    const Structure structure = make(name, 40, 3);
    // a framework refuses double bars, bars from a joint to itself and lengths of zero
    const auto framework = framework_of(structure);
    EXPECT_EQ(worst_violation(*framework, structure.positions, nullptr).relative, 0) << name;
    EXPECT_EQ(framework->name(0), "j0");
    EXPECT_EQ(std::set<std::string>(structure.ids.begin(), structure.ids.end()).size(), 40u);
  }
}

TEST(Generate, MeanBarLengthIsOfOrderOne) {
  for (const std::string& name : structure_classes()) {
    const double mean = mean_length(make(name, 500, 5));
    EXPECT_GT(mean, 0.9) << name;
    EXPECT_LT(mean, 1.5) << name;
  }
}

TEST(Generate, SeedAndIndexDecideTheStructure) {
  for (const std::string& name : structure_classes()) {
    StructureRequest request;
    request.class_name = name;
    request.joints = 30;
    request.seed = 11;
    const Structure first = generate_structure(request), again = generate_structure(request);
    EXPECT_EQ(first.positions, again.positions) << name;
    EXPECT_EQ(bars_of(first), bars_of(again)) << name;
    EXPECT_EQ(first.type, again.type) << name;
    request.index = 1;
    EXPECT_NE(generate_structure(request).positions, first.positions) << name;
    request.index = 0;
    request.seed = 12;
    EXPECT_NE(generate_structure(request).positions, first.positions) << name;
  }
}

TEST(Generate, LargeStructuresNeedNoDeepStack) {
  for (const std::string& name : structure_classes()) {
    const Structure structure = make(name, 100'000, 1);
    EXPECT_EQ(joints_of(structure), 100'000) << name;
    EXPECT_EQ(components_of(graph_of(structure)).count(), 1) << name;
  }
  StructureRequest chain;
  chain.joints = 100'000;
  chain.children = 1;
  EXPECT_EQ(classify(graph_of(generate_structure(chain))).diameter, 99'999);
}

// === The thesis' classes

TEST(Generate, ThesisClassesAgreeWithAnIndependentCount) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const int joints = 4 + int(seed % 17);
    for (const std::string name : {"tree", "1-cycle", "2-cycle", "n-cycle"}) {
      const Structure structure = make(name, joints, seed);
      EXPECT_EQ(naive::class_of(joints, bars_of(structure)), name) << seed;
      EXPECT_EQ(naive::type_of(joints, bars_of(structure)), structure.type) << seed;
    }
  }
}

TEST(Generate, EveryTypeOfTwoCycleOccursOften) {
  std::map<std::string, int> count;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) ++count[make("2-cycle", 20, seed).type];
  EXPECT_EQ(count.size(), 3u);
  for (const auto& [type, times] : count) EXPECT_GT(times, 200) << type;
}

TEST(Generate, ConstructionsOfTwoCyclesGiveTheirTypes) {
  std::set<std::string> of_trees;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const int joints = 6 + int(seed % 20);
    EXPECT_EQ(make("2-cycle", joints, seed, "b").type, "shared-joint");
    EXPECT_EQ(make("2-cycle", joints, seed, "c").type, "path");
    EXPECT_EQ(make("2-cycle", joints, seed, "d").type, "theta");
    of_trees.insert(make("2-cycle", joints, seed, "a").type);
  }
  EXPECT_EQ(of_trees, (std::set<std::string>{"path", "shared-joint", "theta"}));
}

TEST(Generate, TypeThatIsAskedForIsTheTypeThatComesOut) {
  for (const auto& [type, least] :
       std::map<std::string, int>{{"path", 6}, {"shared-joint", 5}, {"theta", 4}})
    for (int joints = least; joints < 40; ++joints) {
      const Structure structure = make("2-cycle", joints, std::uint64_t(joints), "", type);
      EXPECT_EQ(structure.type, type);
      EXPECT_EQ(naive::type_of(joints, bars_of(structure)), type);
    }
}

TEST(Generate, BothConstructionsOfOneCyclesGiveCyclesOfAnyLength) {
  for (const std::string construction : {"a", "b"}) {
    std::set<std::size_t> lengths;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
      const Structure structure = make("1-cycle", 8, seed, construction);
      lengths.insert(classify(graph_of(structure)).blocks.at(0).joints.size());
    }
    EXPECT_EQ(*lengths.begin(), 3u) << construction;
    EXPECT_GE(lengths.size(), 4u) << construction;
  }
}

TEST(Generate, BarThatClosesATreeFallsOnEveryPairAlike) {
  // a star of one root and three children has three open pairs
  std::map<std::pair<int, int>, int> count;
  StructureRequest request;
  request.class_name = "1-cycle";
  request.construction = "a";
  request.joints = 4;
  request.depth = 1;
  request.children = 3;
  for (request.seed = 0; request.seed < 3000; ++request.seed) {
    const auto [p, q] = bars_of(generate_structure(request)).back();
    ++count[std::minmax(p, q)];
  }
  EXPECT_EQ(count.size(), 3u);
  for (const auto& [pair, times] : count) EXPECT_NEAR(times, 1000, 120);
}

TEST(Generate, NCyclesHaveTheNumberOfBarsAskedFor) {
  StructureRequest request;
  request.class_name = "n-cycle";
  request.joints = 12;
  // from few to all pairs
  for (request.cycles = 3; request.cycles <= 55; ++request.cycles)
    EXPECT_EQ(naive::cycle_rank(12, bars_of(generate_structure(request))), request.cycles);
  request.cycles = 0;
  std::set<int> ranks;
  for (request.seed = 0; request.seed < 100; ++request.seed)
    ranks.insert(naive::cycle_rank(12, bars_of(generate_structure(request))));
  EXPECT_EQ(ranks, (std::set<int>{3, 4, 5, 6}));
}

TEST(Generate, TreesKeepToDepthAndChildren) {
  StructureRequest request;
  request.depth = 3;
  request.children = 3;
  for (int joints = 2; joints <= 40; ++joints) {
    request.joints = joints;
    request.seed = std::uint64_t(joints);
    const Structure tree = generate_structure(request);
    EXPECT_EQ(joints_of(tree), joints);
    // bar k joins joint k + 1 to its parent
    std::vector<int> depth(std::size_t(joints), 0), children(std::size_t(joints), 0);
    for (const auto& [parent, child] : bars_of(tree)) {
      depth[std::size_t(child)] = depth[std::size_t(parent)] + 1;
      EXPECT_LE(depth[std::size_t(child)], 3);
      EXPECT_LE(++children[std::size_t(parent)], 3);
    }
  }
  request.joints = 41;
  EXPECT_EQ(refusal(request), "a tree of depth 3 with up to 3 children has no room for 41 joints");
}

// === Other classes

TEST(Generate, GridsHaveTheBarsOfTheirLattice) {
  StructureRequest request;
  request.class_name = "grid";
  request.joints = 36;
  request.dimensions = 2;
  EXPECT_EQ(generate_structure(request).parts.bars.size(), 60u);
  request.joints = 27;
  request.dimensions = 3;
  EXPECT_EQ(generate_structure(request).parts.bars.size(), 54u);
}

TEST(Generate, BarsOfLatticesAreShort) {
  for (const std::string name : {"grid", "cloth", "ring-chain"})
    for (const Bar& bar : make(name, 211, 1).parts.bars) EXPECT_NEAR(bar.length, 1, 0.2) << name;
}

TEST(Generate, ThreadsHoldEachJointToTheNextButOne) {
  const Structure thread = make("thread", 30, 1);
  EXPECT_EQ(thread.parts.bars.size(), 2u * 30 - 3);
  for (const auto& [p, q] : bars_of(thread)) EXPECT_LE(q - p, 2);
}

TEST(Generate, RingChainsHaveAsManyBlocksAsRings) {
  StructureRequest request;
  request.class_name = "ring-chain";
  request.joints = 40;
  for (int rings = 1; rings <= 13; ++rings) {
    request.cycles = rings;
    const Classification found = classify(graph_of(generate_structure(request)));
    EXPECT_EQ(int(found.blocks.size()), rings);
    EXPECT_EQ(int(found.bridges.size()), rings - 1);
  }
  request.cycles = 0;
  for (const Block& block : classify(graph_of(generate_structure(request))).blocks) {
    EXPECT_GE(block.joints.size(), 3u);
    EXPECT_LE(block.joints.size(), 8u);
  }
}

TEST(Generate, RegularGraphsHaveOneDegree) {
  StructureRequest request;
  request.class_name = "regular";
  for (request.joints = 6; request.joints <= 20; request.joints += 2)
    for (request.degree = 2; request.degree < 6; ++request.degree)
      for (const int degree : degrees_of(generate_structure(request)))
        EXPECT_EQ(degree, request.degree);
}

TEST(Generate, RegularGraphsOfOneSizeDiffer) {
  std::set<std::set<std::pair<int, int>>> graphs;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Bars bars = bars_of(make("regular", 12, seed));
    graphs.insert(std::set<std::pair<int, int>>(bars.begin(), bars.end()));
  }
  EXPECT_EQ(graphs.size(), 50u);
}

TEST(Generate, ProteinsAreSparseAndHaveRingsOfFiveAndSix) {
  const Structure protein = make("protein", 5000, 2);
  const Classification found = classify(graph_of(protein));
  for (const int degree : degrees_of(protein)) EXPECT_LE(degree, 4);
  // 1.5 cycles for 100 atoms or so
  EXPECT_GT(found.cycle_rank, 50);
  EXPECT_LT(found.cycle_rank, 250);
  std::set<std::size_t> sizes;
  for (const Block& block : found.blocks) sizes.insert(block.joints.size());
  for (const std::size_t size : {5u, 6u, 9u}) EXPECT_TRUE(sizes.contains(size)) << size;
}

TEST(Generate, MoleculesBecomeStructuresWithTheirBondsAndNames) {
  const auto atom = [](const char* label) { return Atom{6, 0, 12.011, label}; };
  const std::vector<Bond> bonds = {{0, 1}, {1, 2}, {2, 0}, {2, 3}};
  const std::vector<Vec3> x = {{0, 0, 0}, {0.15, 0, 0}, {0, 0.15, 0}, {0, 0.3, 0}};
  const Structure named =
      structure_of(Molecule({atom("C1 LIG"), atom("C2 LIG"), atom("C3"), atom("C4")}, bonds, x));
  EXPECT_EQ(named.ids, (std::vector<std::string>{"C1_LIG", "C2_LIG", "C3", "C4"}));
  EXPECT_EQ(named.class_name, "1-cycle");
  EXPECT_EQ(named.length_unit, "nm");
  EXPECT_DOUBLE_EQ(named.parts.bars.at(3).length, 0.15);
  EXPECT_EQ(named.parts.masses.at(0), 12.011);
  // names that are missing or not unique give way to numbers
  const Structure numbered =
      structure_of(Molecule({atom("C"), atom("C"), atom(""), atom("C4")}, bonds, x));
  EXPECT_EQ(numbered.ids, (std::vector<std::string>{"j0", "j1", "j2", "j3"}));
}

// === Refusals

TEST(Generate, WhatDoesNotExistIsRefusedInOneSentence) {
  EXPECT_EQ(refusal({.class_name = "1-cycle", .joints = 2}),
            "a structure of class 1-cycle has at least 3 joints, not 2");
  EXPECT_EQ(refusal({.class_name = "2-cycle", .joints = 3}),
            "a structure of class 2-cycle has at least 4 joints, not 3");
  EXPECT_EQ(refusal({.class_name = "2-cycle", .type = "shared-joint", .joints = 4}),
            "two cycles that share a joint have at least 5 joints, not 4");
  EXPECT_EQ(refusal({.class_name = "2-cycle", .type = "path", .joints = 5}),
            "two cycles joined by a path have at least 6 joints, not 5");
  EXPECT_EQ(refusal({.class_name = "2-cycle", .type = "eight"}),
            "type 'eight' of a 2-cycle is not known; choose one of: path, shared-joint, theta");
  EXPECT_EQ(refusal({.class_name = "1-cycle", .construction = "c"}),
            "construction 'c' of a 1-cycle is not known; choose one of a to b");
  EXPECT_EQ(refusal({.class_name = "n-cycle", .cycles = 4, .joints = 4}),
            "a tree of 4 joints has room for 3 more bars, not 4");
  EXPECT_EQ(refusal({.class_name = "n-cycle", .cycles = 2}),
            "an n-cycle has at least 3 bars beside its tree's, not 2");
  EXPECT_EQ(refusal({.class_name = "tree", .cycles = 1}),
            "a structure of class tree has no choice of cycles");
  EXPECT_EQ(refusal({.class_name = "tree", .joints = 1}),
            "a structure of class tree has at least 2 joints, not 1");
  EXPECT_EQ(refusal({.class_name = "regular", .joints = 5, .degree = 3}),
            "a regular graph of 5 joints and degree 3 does not exist: one of the two must be even");
  EXPECT_EQ(refusal({.class_name = "ring-chain", .cycles = 4, .joints = 11}),
            "11 joints make from 1 to 3 rings, not 4");
  EXPECT_EQ(refusal({.class_name = "grid", .dimensions = 4}),
            "a grid has 2 or 3 dimensions, not 4");
  EXPECT_EQ(refusal({.class_name = "cube"}),
            "class 'cube' is not known; choose one of: tree, 1-cycle, 2-cycle, n-cycle, grid, "
            "cloth, thread, ring-chain, regular, protein");
}

// === Forces

TEST(GenerateForces, SizesAreUniformBetweenTheBounds) {
  Structure structure = make("1-cycle", 15, 4);
  for (std::size_t j = 0; j < 15; ++j) structure.parts.masses[j] = 1 + double(j);
  const double mean = mean_length(structure);
  const ForceSet set =
      generate_forces(structure, {.count = 20000, .lo = 0.5, .hi = 1.5, .seed = 9});
  ASSERT_EQ(set.forces.size(), 20000u);
  EXPECT_EQ(set.timestep, 1);
  std::vector<int> bins(10, 0);
  for (const Force& force : set.forces) {
    const double size =
        force.force.norm() / structure.parts.masses[std::size_t(force.joint)] / mean;
    ASSERT_GE(size, 0.5 - 1e-12);
    ASSERT_LT(size, 1.5 + 1e-12);
    ++bins[std::min<std::size_t>(9, std::size_t((size - 0.5) * 10))];
  }
  for (const int count : bins) EXPECT_NEAR(count, 2000, 200);
}

TEST(GenerateForces, DirectionsAreUniformOnTheSphere) {
  const ForceSet set = generate_forces(make("tree", 10, 4), {.count = 20000, .seed = 3});
  Vec3 sum = Vec3::Zero();
  // each coordinate of a point on a sphere is uniform (Archimedes)
  std::vector<std::vector<int>> bins(3, std::vector<int>(10, 0));
  for (const Force& force : set.forces) {
    const Vec3 unit = force.force.normalized();
    sum += unit;
    for (int k = 0; k < 3; ++k)
      ++bins[std::size_t(k)][std::min<std::size_t>(9, std::size_t((unit[k] + 1) * 5))];
  }
  EXPECT_LT(sum.norm() / 20000, 0.02);
  for (const auto& axis : bins)
    for (const int count : axis) EXPECT_NEAR(count, 2000, 200);
}

TEST(GenerateForces, JointsAreUniformAmongThoseThatCanMove) {
  Structure structure = make("tree", 10, 4);
  structure.parts.fixed[3] = 1;
  structure.parts.masses[5] = 0;
  std::vector<int> count(10, 0);
  for (const Force& force : generate_forces(structure, {.count = 8000}).forces)
    ++count[std::size_t(force.joint)];
  for (std::size_t j = 0; j < 10; ++j)
    EXPECT_NEAR(count[j], j == 3 || j == 5 ? 0 : 1000, j == 3 || j == 5 ? 0 : 130) << j;
}

TEST(GenerateForces, SeedAndIndexDecideTheForces) {
  const Structure structure = make("tree", 10, 4);
  const auto forces = [&](std::uint64_t seed, std::uint64_t index) {
    std::vector<Vec3> vectors;
    for (const Force& force : generate_forces(structure, {.seed = seed, .index = index}).forces)
      vectors.push_back(force.force);
    return vectors;
  };
  EXPECT_EQ(forces(1, 0), forces(1, 0));
  EXPECT_NE(forces(1, 0), forces(2, 0));
  EXPECT_NE(forces(1, 0), forces(1, 1));
}

TEST(GenerateForces, ImpossibleRequestsAreRefused) {
  Structure structure = make("tree", 2, 4);
  const auto refused = [&](const ForceRequest& request) {
    return examples::refusal_of([&] { generate_forces(structure, request); });
  };
  EXPECT_EQ(refused({.lo = 2, .hi = 1}),
            "the size of the forces lies between two numbers, 0 <= lo <= hi");
  EXPECT_EQ(refused({.count = -1}), "the number of forces must be 0 or more");
  structure.parts.fixed = {1, 1};
  EXPECT_EQ(refused({}), "no joint of the structure can move");
  structure.parts.bars.clear();
  EXPECT_EQ(refused({}), "a structure without bars has no mean bar length");
}

}  // namespace
}  // namespace ragdoll
