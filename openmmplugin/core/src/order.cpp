#include "ragdoll/order.h"

#include <algorithm>  // reverse_copy
#include <array>
#include <numeric>  // iota

#include "breadth_first.h"  // BreadthFirst
#include "names.h"          // value_of, name_in
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

constexpr std::array<std::pair<OrderKind, const char*>, 11> kinds = {{
    {OrderKind::random, "random"},
    {OrderKind::bfs_tree, "bfs_tree"},
    {OrderKind::dfs_tree, "dfs_tree"},
    {OrderKind::bfs_cycle, "bfs_cycle"},
    {OrderKind::dfs_cycle, "dfs_cycle"},
    {OrderKind::bfs_reverse, "bfs_reverse"},
    {OrderKind::dfs_reverse, "dfs_reverse"},
    {OrderKind::bfs_adapt, "bfs_adapt"},
    {OrderKind::bfs_random, "bfs_random"},
    {OrderKind::bfs_active, "bfs_active"},
    {OrderKind::bfs_worst, "bfs_worst"},
}};

/// A whole breadth-first traversal; components are entered one after the other.
class Breadth {
 public:
  explicit Breadth(const Graph& graph) : steps_(graph) {
    order_.reserve(std::size_t(graph.bar_count()));
  }

  bool reached(int joint) const { return steps_.reached(joint); }

  void enter(int root) {
    steps_.enter(root);
    append_all();
  }

  /// From both ends of a problem constraint, which comes first.
  void enter_at(const Visit& problem) {
    steps_.leave_out(problem.bar);
    order_.push_back(problem);
    steps_.enter(problem.near);
    steps_.enter(problem.far);
    append_all();
  }

  Order take() { return std::move(order_); }

 private:
  void append_all() {
    for (Visit visit; steps_.next(visit);) order_.push_back(visit);
  }

  BreadthFirst steps_;
  Order order_;
};

/// The same depth-first. A problem constraint is appended when it is met.
class Depth {
 public:
  explicit Depth(const Graph& graph)
      : graph_(graph),
        depth_(std::size_t(graph.joint_count()), -1),
        used_(std::size_t(graph.bar_count()), 0) {
    order_.reserve(std::size_t(graph.bar_count()));
  }

  bool reached(int joint) const { return depth_[std::size_t(joint)] >= 0; }

  void enter(int root) {
    depth_[std::size_t(root)] = 0;
    std::vector<std::pair<int, std::size_t>> stack = {{root, 0}};  // joint, next link
    while (!stack.empty()) {
      auto& [joint, next] = stack.back();
      const auto links = graph_.links(joint);
      if (next == links.size()) {
        stack.pop_back();
        continue;
      }
      const Graph::Link link = links[next++];
      if (used_[std::size_t(link.bar)]) continue;
      used_[std::size_t(link.bar)] = 1;
      if (reached(link.other)) {
        order_.push_back(BreadthFirst::problem_visit(graph_, link, joint, depth_));
      } else {
        depth_[std::size_t(link.other)] = depth_[std::size_t(joint)] + 1;
        order_.push_back({link.bar, joint, link.other, false});
        stack.emplace_back(link.other, 0);
      }
    }
  }

  Order take() { return std::move(order_); }

 private:
  const Graph& graph_;
  std::vector<int> depth_;           ///< -1: not reached (njoint)
  std::vector<unsigned char> used_;  ///< in the order already (nbar)
  Order order_;
};

/// Components that were not entered yet: from their own roots, or from their lowest joints.
template <class Traversal>
void enter_others(const Graph& graph, Traversal& traversal, std::span<const int> roots) {
  if (roots.size() <= 1) {
    for (int joint = 0; joint < graph.joint_count(); ++joint)
      if (!traversal.reached(joint)) traversal.enter(joint);
    return;
  }
  // roots of other components, found by component
  const Components components = components_of(graph);
  std::vector<int> root_of(std::size_t(components.count()), -1);
  for (const int root : roots) {
    int& own = root_of[std::size_t(components.of_joint[std::size_t(root)])];
    if (own < 0) own = root;
  }
  for (int c = 0; c < components.count(); ++c) {
    const int lowest = components.lowest_joint[std::size_t(c)];
    const int start = root_of[std::size_t(c)] >= 0 ? root_of[std::size_t(c)] : lowest;
    if (!traversal.reached(start)) traversal.enter(start);
  }
}

template <class Traversal>
Order traversed(const Graph& graph, std::span<const int> roots) {
  Traversal traversal(graph);
  if (!roots.empty()) traversal.enter(roots.front());
  enter_others(graph, traversal, roots);
  return traversal.take();
}

}  // namespace

OrderKind order_kind(const std::string& name) {
  return value_of(kinds, name, "order");
}

std::string name_of(OrderKind kind) {
  return name_in(kinds, kind);
}

std::vector<std::string> order_names() {
  std::vector<std::string> names;
  for (const auto& [kind, name] : kinds) names.emplace_back(name);
  return names;
}

void check_roots(const Graph& graph, std::span<const int> roots) {
  for (const int root : roots)
    if (root < 0 || root >= graph.joint_count())
      throw Error("root " + std::to_string(root) + " is no joint; there are " +
                  std::to_string(graph.joint_count()));
}

Order shuffled_order(const Graph& graph, Random& random) {
  // Fisher and Yates, on numbers: they stay in the nearest cache
  std::vector<int> bars(std::size_t(graph.bar_count()));
  std::iota(bars.begin(), bars.end(), 0);
  for (std::size_t k = bars.size(); k > 1; --k) std::swap(bars[k - 1], bars[random.below(k)]);
  Order order;
  order.reserve(bars.size());
  for (const int bar : bars) {
    const auto [first, second] = graph.ends(bar);
    order.push_back({bar, first, second, false});
  }
  return order;
}

Order order_of(const Graph& graph, OrderKind kind, std::span<const int> roots, Random& random) {
  check_roots(graph, roots);
  if (kind == OrderKind::random) return shuffled_order(graph, random);

  const bool depth =
      kind == OrderKind::dfs_tree || kind == OrderKind::dfs_cycle || kind == OrderKind::dfs_reverse;
  Order order = depth ? traversed<Depth>(graph, roots) : traversed<Breadth>(graph, roots);

  if (kind == OrderKind::bfs_tree || kind == OrderKind::dfs_tree)
    std::erase_if(order, [](const Visit& visit) { return visit.problem; });
  if (kind == OrderKind::bfs_reverse || kind == OrderKind::dfs_reverse) {
    const std::size_t forward = order.size();
    order.resize(2 * forward);
    std::reverse_copy(order.begin(), order.begin() + std::ptrdiff_t(forward),
                      order.begin() + std::ptrdiff_t(forward));
  }
  return order;
}

Order adapted_order(const Graph& graph, int problem_bar, std::span<const int> roots) {
  check_roots(graph, roots);
  const auto [first, second] = graph.ends(problem_bar);
  Breadth traversal(graph);
  traversal.enter_at({problem_bar, first, second, true});
  enter_others(graph, traversal, roots);
  return traversal.take();
}

}  // namespace ragdoll
