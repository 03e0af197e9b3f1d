#include "ragdoll/order.h"

#include <algorithm>  // reverse_copy
#include <array>
#include <numeric>  // iota

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

/// One traversal over a graph; components are entered one after the other.
class Traversal {
 public:
  explicit Traversal(const Graph& graph)
      : graph_(graph),
        depth_(std::size_t(graph.joint_count()), -1),
        taken_(std::size_t(graph.joint_count()), 0),
        used_(std::size_t(graph.bar_count()), 0) {
    order_.reserve(std::size_t(graph.bar_count()));
  }

  bool reached(int joint) const { return depth_[std::size_t(joint)] >= 0; }

  /// Breadth-first. A problem constraint is appended when the second of its ends is taken off the
  /// queue, at its place among that joint's bars.
  void breadth_first(int root) {
    enqueue(root, 0);
    run_queue();
  }

  /// Breadth-first from both ends of a problem constraint, which comes first.
  void breadth_first_from(const Visit& problem, int first, int second) {
    use(problem.bar);
    order_.push_back(problem);
    enqueue(first, 0);
    enqueue(second, 0);
    run_queue();
  }

  /// Depth-first. A problem constraint is appended when it is met.
  void depth_first(int root) {
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
      if (reached(link.other)) {
        append_problem(link, joint);
      } else {
        append_tree(link, joint);
        stack.emplace_back(link.other, 0);
      }
    }
  }

  Order take() { return std::move(order_); }

 private:
  void enqueue(int joint, int depth) {
    depth_[std::size_t(joint)] = depth;
    queue_.push_back(joint);
  }

  void run_queue() {
    for (; head_ < queue_.size(); ++head_) {
      const int joint = queue_[head_];
      taken_[std::size_t(joint)] = 1;
      for (const Graph::Link& link : graph_.links(joint)) {
        if (used_[std::size_t(link.bar)]) continue;
        if (!reached(link.other)) {
          append_tree(link, joint);
          queue_.push_back(link.other);
        } else if (taken_[std::size_t(link.other)]) {
          append_problem(link, joint);
        }
      }
    }
  }

  void use(int bar) { used_[std::size_t(bar)] = 1; }

  void append_tree(const Graph::Link& link, int joint) {
    use(link.bar);
    depth_[std::size_t(link.other)] = depth_[std::size_t(joint)] + 1;
    order_.push_back({link.bar, joint, link.other, false});
  }

  /// The nearer end has the smaller depth; at one depth it is left to the caller's bar order.
  void append_problem(const Graph::Link& link, int joint) {
    use(link.bar);
    const bool other_nearer = depth_[std::size_t(link.other)] < depth_[std::size_t(joint)];
    const bool tie = depth_[std::size_t(link.other)] == depth_[std::size_t(joint)];
    const auto [first, second] = graph_.ends(link.bar);
    if (tie)
      order_.push_back({link.bar, first, second, true});
    else if (other_nearer)
      order_.push_back({link.bar, link.other, joint, true});
    else
      order_.push_back({link.bar, joint, link.other, true});
  }

  const Graph& graph_;
  std::vector<int> depth_;            ///< -1: not reached (njoint)
  std::vector<unsigned char> taken_;  ///< taken off the queue (njoint)
  std::vector<unsigned char> used_;   ///< in the order already (nbar)
  std::vector<int> queue_;
  std::size_t head_ = 0;
  Order order_;
};

void check_roots(const Graph& graph, std::span<const int> roots) {
  for (const int root : roots)
    if (root < 0 || root >= graph.joint_count())
      throw Error("root " + std::to_string(root) + " is no joint; there are " +
                  std::to_string(graph.joint_count()));
}

/// Components that were not entered yet: from their own roots, or from their lowest joints.
template <class Enter>
void enter_others(const Graph& graph, const Traversal& traversal, std::span<const int> roots,
                  Enter enter) {
  if (roots.size() <= 1) {
    for (int joint = 0; joint < graph.joint_count(); ++joint)
      if (!traversal.reached(joint)) enter(joint);
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
    if (!traversal.reached(start)) enter(start);
  }
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
  Traversal traversal(graph);
  const auto enter = [&](int root) {
    depth ? traversal.depth_first(root) : traversal.breadth_first(root);
  };
  if (!roots.empty()) enter(roots.front());
  enter_others(graph, traversal, roots, enter);
  Order order = traversal.take();

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
  Traversal traversal(graph);
  const auto [first, second] = graph.ends(problem_bar);
  traversal.breadth_first_from({problem_bar, first, second, true}, first, second);
  enter_others(graph, traversal, roots, [&](int root) { traversal.breadth_first(root); });
  return traversal.take();
}

}  // namespace ragdoll
