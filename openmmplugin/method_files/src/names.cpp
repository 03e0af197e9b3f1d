#include "names.h"

#include <algorithm>  // lower_bound, min, max, sort, find
#include <cmath>      // isfinite
#include <utility>    // pair

#include "ragdoll/error.h"      // Error
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/graph.h"      // Graph
#include "text.h"               // is_space, excerpt, find_bad_byte

namespace ragdoll {

NameIndex::NameIndex(const std::vector<std::string>& names) {
  numbers_.reserve(names.size());
  for (const std::string& name : names) add(name);
}

bool NameIndex::add(std::string_view name) {
  return numbers_.emplace(name, count()).second;
}

int NameIndex::find(std::string_view name) const {
  const auto place = numbers_.find(name);
  return place == numbers_.end() ? -1 : place->second;
}

std::uint64_t pair_key(int p, int q) {
  return std::uint64_t(std::min(p, q)) << 32 | std::uint64_t(std::max(p, q));
}

BarIndex::BarIndex(const std::vector<Bar>& bars) {
  entries_.reserve(bars.size());
  for (std::size_t k = 0; k < bars.size(); ++k)
    entries_.push_back({pair_key(bars[k].p, bars[k].q), int(k)});
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.pair < b.pair; });
}

int BarIndex::find(int p, int q) const {
  const std::uint64_t pair = pair_key(p, q);
  const auto place =
      std::lower_bound(entries_.begin(), entries_.end(), pair,
                       [](const Entry& entry, std::uint64_t key) { return entry.pair < key; });
  return place == entries_.end() || place->pair != pair ? -1 : place->bar;
}

void check_class(const std::string& class_name, int joint_count, const std::vector<Bar>& bars) {
  if (class_name.empty()) return;
  constexpr const char* kFamilies[] = {"grid", "ring-chain", "regular", "cloth", "thread", "protein"};
  constexpr const char* kClasses[] = {"tree", "1-cycle", "2-cycle", "n-cycle"};
  const auto is_in = [&](const auto& names) {
    return std::find(std::begin(names), std::end(names), class_name) != std::end(names);
  };
  if (is_in(kFamilies)) return;
  if (!is_in(kClasses))
    throw Error("the class \"" + excerpt(class_name) +
                "\" is none of tree, 1-cycle, 2-cycle, n-cycle, grid, ring-chain, regular, cloth, "
                "thread and protein");

  std::vector<std::pair<int, int>> ends;
  ends.reserve(bars.size());
  for (const Bar& bar : bars) ends.emplace_back(bar.p, bar.q);
  const Graph graph(joint_count, ends);
  const Components components = components_of(graph);
  const std::string largest = graph_class(components);
  if (class_name != largest && class_name != ragdoll::class_name(cycle_rank(graph, components)))
    throw Error("the class is said to be " + class_name + ", but the bars make it " + largest);
}

void check_structure(const Structure& structure) {
  const std::size_t n = structure.ids.size();
  if (n == 0) throw Error("the structure has no joints");
  if (structure.positions.size() != n || structure.parts.masses.size() != n)
    throw Error("the structure does not have one id, position and mass for each joint");
  if (!structure.parts.volumes.empty() || !structure.parts.contact_rule.empty())
    throw Error("volumes and contact radii have no place in a structure file");

  NameIndex names;
  for (std::size_t j = 0; j < n; ++j) {
    const std::string& id = structure.ids[j];
    if (id.empty()) throw Error("joint " + std::to_string(j) + " has an empty id");
    if (std::any_of(id.begin(), id.end(), is_space))
      throw Error("the id \"" + excerpt(id) + "\" has a space in it");
    if (find_bad_byte(id) != std::string::npos)
      throw Error("the id of joint " + std::to_string(j) + " is not text in UTF-8");
    if (!names.add(id)) throw Error("two joints have the id " + excerpt(id));
    if (!structure.positions[j].allFinite())
      throw Error("the position of joint " + excerpt(id) + " is not finite");
  }

  // the rest is what any framework is held to
  FrameworkParts parts = structure.parts;
  parts.labels = structure.ids;
  const Framework framework(std::move(parts));
  check_class(structure.class_name, int(n), structure.parts.bars);
}

}  // namespace ragdoll
