#include "newton_bars_plan.h"

#include <algorithm>  // max, sort

#include "breadth_first.h"  // BreadthFirst
#include "constraints.h"    // has_bars_only

namespace ragdoll {
namespace {

constexpr double most_bars = 1.25;   ///< for each joint
constexpr double most_entries = 4;   ///< for each bar
constexpr double most_targets = 16;  ///< for each bar
constexpr std::size_t small = 1000;  ///< more than these numbers, in frameworks of few bars

}  // namespace

std::shared_ptr<const NewtonBarsPlan> NewtonBarsPlan::make(const Framework& framework,
                                                           const ResolverSettings& settings) {
  if (!has_bars_only(framework) || framework.bars().empty()) return nullptr;
  auto plan = std::make_shared<NewtonBarsPlan>();
  if (!plan->order_bars(framework, settings) || !plan->fill_in()) return nullptr;
  return plan;
}

bool NewtonBarsPlan::order_bars(const Framework& framework, const ResolverSettings& settings) {
  const Graph& graph = framework.graph();
  joint_count = std::size_t(framework.joint_count());
  if (double(framework.bars().size()) > most_bars * double(joint_count)) return false;
  const auto weight = [&](int joint) {
    if (framework.fixed()[std::size_t(joint)]) return 0.0;
    const double mass = framework.masses()[std::size_t(joint)];
    return settings.mass_weights ? 1 / std::max(mass, 1e-6) : 1.0;
  };
  bars.resize(framework.bars().size());
  std::size_t place = bars.size();
  BreadthFirst steps(graph);
  MiddleJoint middle(graph);
  for (const int lowest : framework.components().lowest_joint) {
    steps.enter(middle.of(lowest));
    for (Visit visit; steps.next(visit);) {
      const Bar& bar = framework.bars()[std::size_t(visit.bar)];
      bars[--place] = {bar.p, bar.q, bar.length, weight(bar.p), weight(bar.q)};
    }
  }
  return true;
}

/// Which entries there are, by the elimination tree: a column's rows are its own and those of the
/// columns whose first row it is.
bool NewtonBarsPlan::fill_in() {
  const std::size_t n = bars.size();
  // bars of each joint, ascending
  std::vector<int> bars_begin(joint_count + 1, 0), bars_of(2 * n);
  for (const BarRow& bar : bars) {
    ++bars_begin[std::size_t(bar.p) + 1];
    ++bars_begin[std::size_t(bar.q) + 1];
  }
  for (std::size_t j = 0; j < joint_count; ++j) bars_begin[j + 1] += bars_begin[j];
  std::vector<int> next(bars_begin.begin(), bars_begin.end() - 1);
  for (std::size_t k = 0; k < n; ++k)
    for (const int joint : {bars[k].p, bars[k].q})
      bars_of[std::size_t(next[std::size_t(joint)]++)] = int(k);

  const auto most = std::size_t(most_entries * double(n)) + small;
  entries.reserve(3 * n);
  begin.reserve(n + 1);
  targets.reserve(5 * n);
  std::vector<int> seen_in(n, -1), first_child(n, -1), next_sibling(n, -1);
  std::vector<int> rows;
  std::vector<double> couplings(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    const int column = int(k);
    rows.clear();
    begin.push_back(int(entries.size()));
    const BarRow& bar = bars[k];
    for (const bool far : {false, true}) {
      const int joint = far ? bar.q : bar.p;
      const double weight = far ? bar.far_weight : bar.near_weight;
      for (int i = bars_begin[std::size_t(joint)]; i < bars_begin[std::size_t(joint) + 1]; ++i) {
        const int row = bars_of[std::size_t(i)];
        if (row <= column) continue;
        rows.push_back(row);
        seen_in[std::size_t(row)] = column;
        const bool same_end = (bars[std::size_t(row)].q == joint) == far;
        couplings[std::size_t(row)] = same_end ? weight : -weight;
      }
    }
    for (int child = first_child[k]; child >= 0; child = next_sibling[std::size_t(child)])
      for (int e = begin[std::size_t(child)]; e < begin[std::size_t(child) + 1]; ++e) {
        const int row = entries[std::size_t(e)].row;
        if (row == column || seen_in[std::size_t(row)] == column) continue;
        seen_in[std::size_t(row)] = column;
        couplings[std::size_t(row)] = 0;
        rows.push_back(row);
      }
    std::sort(rows.begin(), rows.end());
    for (const int row : rows) entries.push_back({row, column, couplings[std::size_t(row)]});
    if (entries.size() > most) return false;
    if (rows.empty()) continue;
    next_sibling[k] = first_child[std::size_t(rows.front())];
    first_child[std::size_t(rows.front())] = column;
  }
  begin.push_back(int(entries.size()));

  const auto value_of = [&](int row, int column) {
    int e = begin[std::size_t(column)];
    while (entries[std::size_t(e)].row != row) ++e;
    return int(n) + e;
  };
  for (std::size_t k = 0; k < n; ++k) {
    for (int e = begin[k]; e < begin[k + 1]; ++e)
      for (int g = begin[k]; g <= e; ++g) {
        const int row = entries[std::size_t(e)].row, column = entries[std::size_t(g)].row;
        targets.push_back(row == column ? row : value_of(row, column));
      }
    if (targets.size() > std::size_t(most_targets * double(n)) + small) return false;
  }
  return true;
}

}  // namespace ragdoll
