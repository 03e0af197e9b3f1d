// Tests for core/src/graph.cpp.

#include "ragdoll/graph.h"

#include <gtest/gtest.h>

#include <algorithm>  // max, max_element

#include "examples.h"

namespace ragdoll {
namespace {

using namespace examples;

std::vector<int> bars_met_by(const Graph& graph, int joint) {
  std::vector<int> bars;
  for (const Graph::Link& link : graph.links(joint)) bars.push_back(link.bar);
  return bars;
}

int rank_of(const Graph& graph) {
  return cycle_rank(graph, components_of(graph));
}

std::string class_of(const Graph& graph) {
  return graph_class(components_of(graph));
}

int middle_of(const Graph& graph, int start) {
  return MiddleJoint(graph).of(start);
}

/// Distances from a joint by relaxing every bar until nothing changes.
std::vector<int> distances_from(const Graph& graph, int start) {
  std::vector<int> distance(std::size_t(graph.joint_count()), graph.joint_count());
  distance[std::size_t(start)] = 0;
  for (int round = 0; round < graph.joint_count(); ++round)
    for (int bar = 0; bar < graph.bar_count(); ++bar) {
      int& p = distance[std::size_t(graph.ends(bar).first)];
      int& q = distance[std::size_t(graph.ends(bar).second)];
      p = std::min(p, q + 1);
      q = std::min(q, p + 1);
    }
  return distance;
}

TEST(Graph, JointMeetsItsBarsInTheOrderInWhichTheyWereAdded) {
  const Graph graph = graph_of("bd ab cb da", 4);
  EXPECT_EQ(bars_met_by(graph, 0), (std::vector<int>{1, 3}));
  EXPECT_EQ(bars_met_by(graph, 1), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(bars_met_by(graph, 2), (std::vector<int>{2}));
  EXPECT_EQ(graph.links(2)[0].other, 1);
  EXPECT_EQ(graph.ends(2), std::pair(2, 1));
  EXPECT_EQ(graph.joint_count(), 4);
  EXPECT_EQ(graph.bar_count(), 4);
}

TEST(Graph, EmptyGraphHasNoJoints) {
  EXPECT_EQ(Graph().joint_count(), 0);
  EXPECT_EQ(Graph().bar_count(), 0);
  EXPECT_EQ(components_of(Graph()).count(), 0);
}

TEST(Graph, ComponentsComeInTheOrderOfTheirLowestJoints) {
  // b is alone, c-e-g a triangle
  const Components components = components_of(graph_of("gc fa ce eg df", 7));
  EXPECT_EQ(components.count(), 3);
  EXPECT_EQ(components.lowest_joint, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(components.of_joint, (std::vector<int>{0, 1, 2, 0, 2, 0, 2}));
  EXPECT_EQ(components.joint_count, (std::vector<int>{3, 1, 3}));
  EXPECT_EQ(components.bar_count, (std::vector<int>{2, 0, 3}));
}

TEST(Graph, CycleRankIsBarsMinusJointsPlusComponents) {
  EXPECT_EQ(rank_of(graph_of("ab bc", 3)), 0);
  EXPECT_EQ(rank_of(graph_of("ab bc", 5)), 0);
  EXPECT_EQ(rank_of(graph_of("ab bc ca", 3)), 1);
  EXPECT_EQ(rank_of(graph_of("ab bc ca de ef fd", 6)), 2);
  EXPECT_EQ(rank_of(graph_of("ab ac ad bc bd cd", 4)), 3);
}

TEST(Graph, ClassesAreNamedByTheirCycleRank) {
  EXPECT_EQ(class_name(0), "tree");
  EXPECT_EQ(class_name(1), "1-cycle");
  EXPECT_EQ(class_name(2), "2-cycle");
  EXPECT_EQ(class_name(3), "n-cycle");
  EXPECT_EQ(class_name(400), "n-cycle");
}

TEST(Graph, TwoCyclesOfEachTypeAreTwoCycles) {
  EXPECT_EQ(class_of(graph_of("ab bc ca cd de ef fd", 6)), "2-cycle");  // joined by a path
  EXPECT_EQ(class_of(graph_of("ab bc ca cd de ec", 5)), "2-cycle");     // sharing a joint
  EXPECT_EQ(class_of(graph_of("ab bc cd da ac", 4)), "2-cycle");        // theta
}

TEST(Graph, ClassIsThatOfTheLargestComponentAndOfTheFirstOnTies) {
  EXPECT_EQ(class_of(graph_of("ab bc ca de ef fg", 7)), "tree");
  EXPECT_EQ(class_of(graph_of("ab bc ca de ef", 6)), "1-cycle");
  EXPECT_EQ(class_of(graph_of("ab bc de ef fd", 6)), "tree");
}

TEST(MiddleJoint, IsTheMiddleOfAPathFromWhereverItIsSearched) {
  const Graph path = graph_of("ab bc cd de", 5);
  for (int start = 0; start < 5; ++start) EXPECT_EQ(middle_of(path, start), 2);
}

TEST(MiddleJoint, IsTheLowerIndexWhereAPathHasTwoMiddles) {
  EXPECT_EQ(middle_of(graph_of("ad db bc", 4), 0), 1);  // a-d-b-c: d or b
  EXPECT_EQ(middle_of(graph_of("ab bd dc", 4), 0), 1);  // a-b-d-c: b or d
  EXPECT_EQ(middle_of(graph_of("cd da ab", 4), 2), 0);  // c-d-a-b: d or a
  EXPECT_EQ(middle_of(graph_of("ba", 2), 1), 0);
}

TEST(MiddleJoint, OfALoneJointIsTheJoint) {
  EXPECT_EQ(middle_of(graph_of("ab", 3), 2), 2);
}

TEST(MiddleJoint, OfACycleFollowsTheFirstPathThatTheSearchFinds) {
  // from a the farthest is c; from c, joint a is first reached over b
  EXPECT_EQ(middle_of(graph_of("ab bc cd da", 4), 0), 1);
  // and over d where c meets cd first
  EXPECT_EQ(middle_of(graph_of("cd ab bc da", 4), 0), 3);
}

TEST(MiddleJoint, TakesTheLowestOfSeveralFarthestJoints) {
  // two squares that share e: from e the corners b and f are both two bars away; from the lower, b,
  // the farthest is f, and the path b-a-e-d-f has e in its middle
  EXPECT_EQ(middle_of(graph_of("ea ab bc ce ed df fg ge", 7), 4), 4);
  // pentagon: from a both c and d are two bars away; c is lower; from c both a and e are, a is
  // lower
  EXPECT_EQ(middle_of(graph_of("ab bc cd de ea", 5), 0), 1);
}

TEST(MiddleJoint, OfATreeIsItsLowestCentre) {
  Random random(1, RandomStream::generate, 0);
  for (int round = 0; round < 100; ++round) {
    const Structure tree = random_structure(2 + round % 20, 0, random);
    const Framework framework(tree.parts);
    const Graph& graph = framework.graph();
    MiddleJoint middle(graph);
    // the joint from which the farthest is nearest
    int centre = -1, least = graph.joint_count();
    for (int joint = 0; joint < graph.joint_count(); ++joint) {
      const std::vector<int> distance = distances_from(graph, joint);
      const int farthest = *std::max_element(distance.begin(), distance.end());
      if (farthest < least) {
        least = farthest;
        centre = joint;
      }
    }
    // searched twice by one object: it leaves nothing behind
    for (const int start : {0, graph.joint_count() - 1}) EXPECT_EQ(middle.of(start), centre);
  }
}

}  // namespace
}  // namespace ragdoll
