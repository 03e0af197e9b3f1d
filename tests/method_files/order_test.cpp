// Tests for openmmplugin/method_files: orders that are read and written.

#include <gtest/gtest.h>

#include "ragdoll/method_files/order_file.h"
#include "ragdoll/random.h"
#include "samples.h"

namespace ragdoll {
namespace {

void expect_same(const Order& a, const Order& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].bar, b[k].bar);
    EXPECT_EQ(a[k].near, b[k].near);
    EXPECT_EQ(a[k].far, b[k].far);
    EXPECT_EQ(a[k].problem, b[k].problem);
  }
}

Order order_of_square(OrderKind kind) {
  const std::vector<std::pair<int, int>> ends = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  Random random(1, RandomStream::order, 0);
  const int roots[] = {2};
  return order_of(Graph(4, ends), kind, roots, random);
}

TEST(OrderFile, NearerEndsComeFirst) {
  const Folder folder;
  const OrderFile file = read_order(folder.write("o.xml", R"(
<order version="1" structure="s.xml" root="a" order="bfs_cycle"><bar joints="a b"/>
<bar joints="c b" problem="true"/><bar joints="a d" problem="false"/></order>)"),
                                    square());
  EXPECT_EQ(file.structure, "s.xml");
  EXPECT_EQ(file.root, "a");
  EXPECT_EQ(file.name, "bfs_cycle");
  expect_same(file.order, {{0, 0, 1, false}, {1, 2, 1, true}, {3, 0, 3, false}});
}

TEST(OrderFile, RoundTripsAreExactForEveryOrder) {
  const Folder folder;
  for (const char* name : {"random", "bfs_tree", "dfs_tree", "bfs_cycle", "dfs_cycle",
                           "bfs_reverse", "dfs_reverse", "bfs_adapt", "bfs_random"}) {
    const OrderFile file{order_of_square(order_kind(name)), name, "c", "s & t.xml"};
    const std::string path = folder / (std::string(name) + ".xml");
    write_order(path, square(), file);
    Warnings warnings;
    const OrderFile back = read_order(path, square(), &warnings);
    expect_same(back.order, file.order);
    EXPECT_EQ(back.name, name);
    EXPECT_EQ(back.root, "c");
    EXPECT_EQ(back.structure, "s & t.xml");
    EXPECT_TRUE(warnings.empty());
  }
}

TEST(OrderFile, PairsOfJointsBecomeVisits) {
  expect_same(order_from_pairs(square(), {{1, 0}, {2, 3}}, {false, true}),
              {{0, 1, 0, false}, {2, 2, 3, true}});
  EXPECT_EQ(error_of([] {
              order_from_pairs(square(), {{0, 2}}, {false});
            }),
            "the structure has no bar that joins joint 0 and joint 2");
  EXPECT_EQ(error_of([] {
              order_from_pairs(square(), {{0, -1}}, {false});
            }),
            "the structure has no bar that joins joint 0 and joint -1");
  EXPECT_EQ(error_of([] {
              order_from_pairs(square(), {{0, 1}}, {});
            }),
            "the order has 1 pairs of joints, but 0 marks of problem constraints");
}

TEST(OrderFile, OrdersThatCouldNotBeReadBackAreNotWritten) {
  const Folder folder;
  const auto refusal = [&](const OrderFile& file) {
    return error_of([&] { write_order(folder / "o.xml", square(), file); });
  };
  EXPECT_NE(refusal({{{0, 0, 2, false}}}), "");
  EXPECT_NE(refusal({{{9, 0, 1, false}}}), "");
  EXPECT_NE(refusal({{{0, 0, 1, false}}, "", "e"}), "");
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace ragdoll
