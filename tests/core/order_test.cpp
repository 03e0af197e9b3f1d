// Tests for core/src/order.cpp.

#include "ragdoll/order.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort, find
#include <map>
#include <set>

#include "examples.h"

namespace ragdoll {
namespace {

using namespace examples;

constexpr OrderKind all_kinds[] = {
    OrderKind::random,      OrderKind::bfs_tree,  OrderKind::dfs_tree,
    OrderKind::bfs_cycle,   OrderKind::dfs_cycle, OrderKind::bfs_reverse,
    OrderKind::dfs_reverse, OrderKind::bfs_adapt, OrderKind::bfs_random};

Random dice(std::uint64_t seed = 1) {
  return Random(seed, RandomStream::order, 0);
}

Order order_from(const Graph& graph, OrderKind kind, std::vector<int> roots) {
  Random random = dice();
  return order_of(graph, kind, roots, random);
}

std::string text_from(const Graph& graph, OrderKind kind, std::vector<int> roots = {0}) {
  return text_of(graph, order_from(graph, kind, std::move(roots)));
}

std::string problems_from(const Graph& graph, OrderKind kind, std::vector<int> roots = {0}) {
  return problems_of(graph, order_from(graph, kind, std::move(roots)));
}

/// The visit of a bar, spelled as the graph spells it: "near-far".
std::string direction_of(const Graph& graph, const Order& order, const std::string& bar) {
  for (const Visit& visit : order)
    if (text_of(graph, {visit}) == spelled(graph, bar))
      return {char('a' + visit.near), '-', char('a' + visit.far)};
  return "not visited";
}

// === Worked examples of the thesis

TEST(Order, TreeOrdersOfFigure22) {
  const Graph graph = graph_of("ab ac bd ce de", 5);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_tree), "ab ac bd ce");
  EXPECT_EQ(text_from(graph, OrderKind::dfs_tree), spelled(graph, "ab bd de ec"));
  EXPECT_EQ(problems_from(graph, OrderKind::bfs_tree), "");
  EXPECT_EQ(problems_from(graph, OrderKind::dfs_tree), "");
}

TEST(Order, CycleOrdersOfFigure52) {
  const Graph graph = graph_of("ab ac af bd ce fg de eg", 7);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle), "ab ac af bd ce fg de eg");
  EXPECT_EQ(problems_from(graph, OrderKind::bfs_cycle), "de eg");
  EXPECT_EQ(text_from(graph, OrderKind::dfs_cycle), spelled(graph, "ab bd de ec ca eg gf fa"));
  EXPECT_EQ(problems_from(graph, OrderKind::dfs_cycle), spelled(graph, "ca fa"));
}

TEST(Order, CycleAndReverseOrdersOfFigure55) {
  const Graph graph = graph_of("ab ac bd cb", 4);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle), "ab ac bd cb");
  EXPECT_EQ(problems_from(graph, OrderKind::bfs_cycle), "cb");
  EXPECT_EQ(text_from(graph, OrderKind::bfs_reverse), "ab ac bd cb cb bd ac ab");
  EXPECT_EQ(text_from(graph, OrderKind::dfs_cycle), spelled(graph, "ab bd bc ca"));
  EXPECT_EQ(problems_from(graph, OrderKind::dfs_cycle), spelled(graph, "ca"));
  EXPECT_EQ(text_from(graph, OrderKind::dfs_reverse), spelled(graph, "ab bd bc ca ca bc bd ab"));
}

TEST(Order, AdaptOrderOfFigure58StartsItsSecondIterationAtTheProblemConstraint) {
  const Graph graph = graph_of("ab ac bd cb", 4);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_adapt), "ab ac bd cb");
  EXPECT_EQ(problems_from(graph, OrderKind::bfs_adapt), "cb");

  // the queue starts with c and b: c reaches a, b reaches d, and ab now closes the cycle
  const Order second = adapted_order(graph, 3, std::vector<int>{0});
  EXPECT_EQ(text_of(graph, second), "cb ac bd ab");
  EXPECT_EQ(problems_of(graph, second), "cb ab");
  EXPECT_EQ(direction_of(graph, second, "cb"), "c-b");
  EXPECT_EQ(direction_of(graph, second, "ac"), "c-a");
  EXPECT_EQ(direction_of(graph, second, "ab"), "b-a");
}

TEST(Order, RandomRootOrderOfFigure510BeginsAsBreadthFirst) {
  const Graph graph = graph_of("ab ac bd cb df cd fe", 6);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_random), "ab ac bd cb df cd fe");
  EXPECT_EQ(problems_from(graph, OrderKind::bfs_random), "cb cd");
}

// === Problem constraints

TEST(Order, ProblemConstraintComesWhenItsSecondEndLeavesTheQueue) {
  // bc is met from b, before ce and bd; it comes among the bars of c
  const Graph graph = graph_of("ab ac bc bd ce", 5);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle), "ab ac bd bc ce");
  // and at its place among them
  EXPECT_EQ(text_from(graph_of("ab ac ce bc bd", 5), OrderKind::bfs_cycle), "ab ac bd ce bc");
}

TEST(Order, DepthFirstProblemConstraintComesWhenItIsMet) {
  // at c, ca is met before cd
  EXPECT_EQ(text_from(graph_of("ab bc ca cd", 4), OrderKind::dfs_cycle), "ab bc ca cd");
}

TEST(Order, NearerEndOfATreeBarIsTheOneReachedFirst) {
  const Graph graph = graph_of("ba bc dc", 4);
  for (const OrderKind kind : {OrderKind::bfs_cycle, OrderKind::dfs_cycle}) {
    const Order order = order_from(graph, kind, {3});
    EXPECT_EQ(direction_of(graph, order, "dc"), "d-c");
    EXPECT_EQ(direction_of(graph, order, "bc"), "c-b");
    EXPECT_EQ(direction_of(graph, order, "ba"), "b-a");
  }
}

TEST(Order, NearerEndOfAProblemConstraintHasTheSmallerDepth) {
  // breadth first: c at depth 1, e at depth 2, spelled "ec"
  const Graph graph = graph_of("ab ac bd be ec", 5);
  const Order breadth = order_from(graph, OrderKind::bfs_cycle, {0});
  EXPECT_EQ(problems_of(graph, breadth), "ec");
  EXPECT_EQ(direction_of(graph, breadth, "ec"), "c-e");
  // depth first: a-b-c, the root is nearer, spelled "ca"
  const Graph triangle = graph_of("ab bc ca", 3);
  const Order depth = order_from(triangle, OrderKind::dfs_cycle, {0});
  EXPECT_EQ(problems_of(triangle, depth), "ca");
  EXPECT_EQ(direction_of(triangle, depth, "ca"), "a-c");
}

TEST(Order, NearerEndOfAProblemConstraintIsTheBarsFirstJointOnTies) {
  for (const char* problem : {"bc", "cb"}) {
    const Graph graph = graph_of(std::string("ab ac ").append(problem), 3);
    const Order order = order_from(graph, OrderKind::bfs_cycle, {0});
    EXPECT_TRUE(order.back().problem);
    EXPECT_EQ(order.back().near, problem[0] - 'a');
    EXPECT_EQ(order.back().far, problem[1] - 'a');
  }
}

// === Several components

TEST(Order, ComponentOfTheRootComesFirstThenTheOthersFromTheirLowestJoints) {
  // a-d, b-f-c, e-g-h
  const Graph graph = graph_of("hg fb cf da ge", 8);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle, {7}), "hg ge da fb cf");
  const Order order = order_from(graph, OrderKind::bfs_cycle, {7});
  EXPECT_EQ(direction_of(graph, order, "hg"), "h-g");
  EXPECT_EQ(direction_of(graph, order, "da"), "a-d");
  EXPECT_EQ(direction_of(graph, order, "fb"), "b-f");
  EXPECT_EQ(text_from(graph, OrderKind::dfs_tree, {5}), "fb cf da ge hg");
}

TEST(Order, WithoutARootEveryComponentStartsAtItsLowestJoint) {
  const Graph graph = graph_of("dc cb fe ea", 6);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle, {}), "ea fe cb dc");
}

TEST(Order, SeveralRootsStartTheirOwnComponents) {
  // a-b, c-d-e, f-g-h, i-j; roots g, e and again f
  const Graph graph = graph_of("ab cd de fg gh ij", 10);
  const Order order = order_from(graph, OrderKind::bfs_cycle, {6, 4, 5});
  EXPECT_EQ(text_of(graph, order), "fg gh ab de cd ij");
  EXPECT_EQ(direction_of(graph, order, "fg"), "g-f");
  EXPECT_EQ(direction_of(graph, order, "ab"), "a-b");
  EXPECT_EQ(direction_of(graph, order, "de"), "e-d");
  EXPECT_EQ(direction_of(graph, order, "cd"), "d-c");
}

TEST(Order, FirstOfTwoRootsInOneComponentIsItsRoot) {
  const Graph graph = graph_of("ab bc cd", 4);
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle, {3, 0}), "cd bc ab");
  EXPECT_EQ(text_from(graph, OrderKind::bfs_cycle, {3, 3}), "cd bc ab");
}

TEST(Order, AdaptedOrderVisitsTheOtherComponentsFromTheirRoots) {
  const Graph graph = graph_of("de ef fd ab bc", 6);
  const Order order = adapted_order(graph, 1, std::vector<int>{5, 2});
  EXPECT_EQ(text_of(graph, order), "ef de fd bc ab");
  EXPECT_EQ(direction_of(graph, order, "ab"), "b-a");
}

TEST(Order, RootThatIsNoJointIsRefused) {
  const Graph graph = graph_of("ab bc", 3);
  for (const int root : {-1, 3}) {
    const auto refusal = refusal_of([&] { order_from(graph, OrderKind::bfs_cycle, {0, root}); });
    EXPECT_EQ(refusal,
              std::string("root ").append(std::to_string(root)) + " is no joint; there are 3");
    EXPECT_NE(refusal_of([&] { adapted_order(graph, 0, std::vector<int>{root}); }), "");
  }
}

// === Properties

TEST(Order, CycleOrdersVisitEveryBarOnceAndReverseOrdersTwice) {
  Random random = dice(2);
  for (int cycles = 0; cycles < 8; ++cycles) {
    const Structure structure = random_structure(12, cycles, random);
    const Framework framework(structure.parts);
    const Graph& graph = framework.graph();
    const int root = int(random.below(12));
    for (const OrderKind kind : all_kinds) {
      std::map<int, int> visits;
      const Order order = order_of(graph, kind, std::vector<int>{root}, random);
      for (const Visit& visit : order) {
        ++visits[visit.bar];
        EXPECT_EQ(std::minmax(visit.near, visit.far),
                  std::minmax(graph.ends(visit.bar).first, graph.ends(visit.bar).second));
      }
      const bool tree = kind == OrderKind::bfs_tree || kind == OrderKind::dfs_tree;
      const bool twice = kind == OrderKind::bfs_reverse || kind == OrderKind::dfs_reverse;
      EXPECT_EQ(int(visits.size()), tree ? 11 : 11 + cycles) << name_of(kind);
      for (const auto& [bar, count] : visits) EXPECT_EQ(count, twice ? 2 : 1) << name_of(kind);
      if (twice)
        for (std::size_t k = 0; k < order.size(); ++k) {
          EXPECT_EQ(order[k].bar, order[order.size() - 1 - k].bar);
          EXPECT_EQ(order[k].near, order[order.size() - 1 - k].near);
        }
    }
  }
}

TEST(Order, TreeBarsReachNewJointsAndProblemConstraintsJoinReachedOnes) {
  Random random = dice(3);
  for (int round = 0; round < 50; ++round) {
    const Structure structure = random_structure(10, round % 6, random);
    const Framework framework(structure.parts);
    const int root = int(random.below(10));
    for (const OrderKind kind : {OrderKind::bfs_cycle, OrderKind::dfs_cycle}) {
      std::set<int> reached = {root};
      int problems = 0;
      for (const Visit& visit : order_of(framework.graph(), kind, std::vector<int>{root}, random)) {
        EXPECT_TRUE(reached.contains(visit.near));
        EXPECT_EQ(reached.contains(visit.far), visit.problem);
        reached.insert(visit.far);
        problems += visit.problem;
      }
      EXPECT_EQ(problems, cycle_rank(framework.graph(), framework.components()));
    }
  }
}

TEST(Order, AdaptedOrderVisitsEveryBarOnceAndTheProblemConstraintFirst) {
  Random random = dice(4);
  for (int round = 0; round < 30; ++round) {
    const Structure structure = random_structure(10, 3, random);
    const Framework framework(structure.parts);
    for (const Visit& problem :
         order_of(framework.graph(), OrderKind::bfs_cycle, std::vector<int>{0}, random)) {
      if (!problem.problem) continue;
      const Order order = adapted_order(framework.graph(), problem.bar, std::vector<int>{0});
      EXPECT_EQ(order.front().bar, problem.bar);
      EXPECT_TRUE(order.front().problem);
      std::set<int> bars;
      for (const Visit& visit : order) bars.insert(visit.bar);
      EXPECT_EQ(bars.size(), 12U);
      EXPECT_EQ(order.size(), 12U);
    }
  }
}

TEST(Order, DeterministicOrdersDrawNoRandomNumbers) {
  const Graph graph = graph_of("ab ac bd cb", 4);
  for (const OrderKind kind : all_kinds) {
    Random random = dice(5), untouched = dice(5);
    order_of(graph, kind, std::vector<int>{0}, random);
    EXPECT_EQ(random.next() == untouched.next(), kind != OrderKind::random) << name_of(kind);
  }
}

TEST(Order, ShuffledOrderStartsEachBarAtItsFirstJoint) {
  const Graph graph = graph_of("ba ac db cb", 4);
  Random random = dice(6);
  for (const Visit& visit : shuffled_order(graph, random)) {
    EXPECT_EQ(std::pair(visit.near, visit.far), graph.ends(visit.bar));
    EXPECT_FALSE(visit.problem);
  }
}

TEST(Order, ShuffledOrdersAreAllEquallyLikely) {
  const Graph graph = graph_of("ab bc cd", 4);
  Random random = dice(7);
  std::map<std::string, int> counts;
  for (int draw = 0; draw < 6000; ++draw) ++counts[text_of(graph, shuffled_order(graph, random))];
  ASSERT_EQ(counts.size(), 6U);
  // five deviations of a binomial count about 1000
  for (const auto& [text, count] : counts) EXPECT_NEAR(count, 1000, 145) << text;
}

TEST(Order, LongChainsDoNotExhaustTheStack) {
  std::vector<std::pair<int, int>> bars;
  for (int j = 0; j < 300000; ++j) bars.emplace_back(j, j + 1);
  const Graph chain(300001, bars);
  EXPECT_EQ(order_from(chain, OrderKind::dfs_cycle, {0}).size(), bars.size());
  EXPECT_EQ(components_of(chain).count(), 1);
  EXPECT_EQ(MiddleJoint(chain).of(0), 150000);
}

// === Names

TEST(Order, NamesAreReadBack) {
  for (const OrderKind kind : all_kinds) EXPECT_EQ(order_kind(name_of(kind)), kind);
  EXPECT_EQ(name_of(OrderKind::bfs_reverse), "bfs_reverse");
}

TEST(Order, UnknownNameIsRefusedWithTheListOfKnownOnes) {
  const std::string refusal = refusal_of([] { order_kind("BFS"); });
  EXPECT_TRUE(refusal.starts_with("order 'BFS' is not known; choose one of: random, bfs_tree, "))
      << refusal;
  for (const OrderKind kind : all_kinds)
    EXPECT_NE(refusal.find(name_of(kind)), std::string::npos) << refusal;
}

}  // namespace
}  // namespace ragdoll
