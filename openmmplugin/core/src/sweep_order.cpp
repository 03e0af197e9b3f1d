#include "sweep_order.h"

#include "ragdoll/classify.h"  // classify

namespace ragdoll {

SweepOrder::SweepOrder(const Framework& framework, const ResolverSettings& settings)
    : framework_(framework), kind_(settings.order), custom_order_(settings.custom_order) {}

bool SweepOrder::changes() const {
  return custom_order_.empty() && (kind_ == OrderKind::random || kind_ == OrderKind::bfs_adapt ||
                                   kind_ == OrderKind::bfs_random || kind_ == OrderKind::bfs_worst);
}

/// Depth-first orders cannot be: they go to the end of a structure before they come back to the
/// root's second bar.
bool SweepOrder::by_visit() const {
  return custom_order_.empty() &&
         (kind_ == OrderKind::bfs_cycle || kind_ == OrderKind::bfs_tree ||
          kind_ == OrderKind::bfs_active || kind_ == OrderKind::bfs_reverse);
}

bool SweepOrder::start(std::span<const int> roots) {
  if (roots.empty()) roots = middle_joints();
  if (ready_ && std::equal(roots.begin(), roots.end(), roots_.begin(), roots_.end())) return false;
  check_roots(framework_.graph(), roots);
  const Components& components = framework_.components();
  const auto root_of = [&](int joint) -> int& {
    return root_of_[std::size_t(components.of_joint[std::size_t(joint)])];
  };
  if (!steps_) {
    steps_.emplace(framework_.graph());
    root_of_.assign(std::size_t(components.count()), -1);
  }
  for (const int root : roots_) root_of(root) = -1;
  roots_.assign(roots.begin(), roots.end());
  for (const int root : roots_)
    if (root_of(root) < 0) root_of(root) = root;
  steps_->start_over();
  steps_->enter(roots_.front());
  next_component_ = 0;
  ready_ = true;
  return true;
}

bool SweepOrder::next(Visit& visit) {
  while (!steps_->next(visit))
    if (!enter_next_component()) return false;
  return true;
}

/// Components in their order, each from its own root, or from its lowest joint where it has none.
bool SweepOrder::enter_next_component() {
  const Components& components = framework_.components();
  for (; next_component_ < components.count(); ++next_component_) {
    const std::size_t c = std::size_t(next_component_);
    const int joint = root_of_[c] >= 0 ? root_of_[c] : components.lowest_joint[c];
    if (steps_->reached(joint)) continue;
    steps_->enter(joint);
    return true;
  }
  return false;
}

bool SweepOrder::prepare(std::span<const int> roots, Random& random, Order& order) {
  if (!custom_order_.empty()) {
    if (ready_) return false;
    order = custom_order_;
    ready_ = true;
    return true;
  }
  if (roots.empty()) roots = middle_joints();
  if (ready_ && !changes() && std::equal(roots.begin(), roots.end(), roots_.begin(), roots_.end()))
    return false;
  roots_.assign(roots.begin(), roots.end());
  order = order_of(framework_.graph(), kind_, roots_, random);
  ready_ = true;
  return true;
}

bool SweepOrder::change(int problem_bar, int worst_bar, Random& random, Order& order) {
  const Graph& graph = framework_.graph();
  if (kind_ == OrderKind::random) {
    order = shuffled_order(graph, random);
    return true;
  }
  if (kind_ == OrderKind::bfs_random) {
    std::vector<int> roots = {int(random.below(std::uint64_t(graph.joint_count())))};
    roots.insert(roots.end(), roots_.begin(), roots_.end());
    order = order_of(graph, OrderKind::bfs_cycle, roots, random);
    return true;
  }
  const int first = kind_ == OrderKind::bfs_worst ? worst_bar : problem_bar;
  if (first < 0) return false;
  order = adapted_order(graph, first, roots_);
  return true;
}

bool SweepOrder::even(const Visit& visit) {
  return visit.problem || in_dense_block(visit.bar);
}

/// bfs_worst shares errors evenly where cycles are dense, 3 bars for 2 joints or more: there any
/// other weighting sends them round and round.
bool SweepOrder::in_dense_block(int bar) {
  if (kind_ != OrderKind::bfs_worst || !custom_order_.empty()) return false;
  if (dense_.empty()) {
    dense_.assign(framework_.bars().size(), 0);
    for (const Block& block : classify(framework_.graph()).blocks)
      if (2 * block.bars.size() >= 3 * block.joints.size())
        for (const int k : block.bars) dense_[std::size_t(k)] = 1;
  }
  return dense_[std::size_t(bar)] != 0;
}

const std::vector<int>& SweepOrder::middle_joints() {
  if (middle_joints_.empty()) {
    MiddleJoint middle(framework_.graph());
    for (const int lowest : framework_.components().lowest_joint)
      middle_joints_.push_back(middle.of(lowest));
  }
  return middle_joints_;
}

}  // namespace ragdoll
