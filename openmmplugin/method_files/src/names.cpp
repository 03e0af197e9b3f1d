#include "names.h"

#include <algorithm>   // lower_bound, min, max, sort, find
#include <cmath>       // isfinite
#include <functional>  // hash
#include <utility>     // exchange, pair

#include "ragdoll/error.h"      // Error
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/generate.h"   // structure_classes
#include "ragdoll/graph.h"      // Graph
#include "text.h"               // is_space, excerpt, find_bad_byte

namespace ragdoll {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k)
    text += (k == 0 ? "" : k + 1 < names.size() ? ", " : " and ") + names[k];
  return text;
}

std::uint32_t hash_of(std::string_view name) {
  const std::size_t hash = std::hash<std::string_view>()(name);
  return std::uint32_t(hash ^ hash >> 32);
}

}  // namespace

NameIndex::NameIndex(const std::vector<std::string>& names) {
  for (const std::string& name : names) add(name);
}

bool NameIndex::add(std::string_view name) {
  if (2 * names_.size() >= slots_.size()) grow();
  const std::uint32_t hash = hash_of(name);
  Slot& slot = slots_[slot_of(name, hash)];
  if (slot.number >= 0) return false;
  slot = {hash, count()};
  names_.push_back(name);
  return true;
}

int NameIndex::find(std::string_view name) const {
  return slots_[slot_of(name, hash_of(name))].number;
}

/// Where the name is, or the free slot where it would be.
std::size_t NameIndex::slot_of(std::string_view name, std::uint32_t hash) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t k = hash & mask;
  while (slots_[k].number >= 0 &&
         (slots_[k].hash != hash || names_[std::size_t(slots_[k].number)] != name))
    k = (k + 1) & mask;
  return k;
}

void NameIndex::grow() {
  const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(2 * slots_.size()));
  const std::size_t mask = slots_.size() - 1;
  for (const Slot& slot : old) {
    if (slot.number < 0) continue;
    std::size_t k = slot.hash & mask;
    while (slots_[k].number >= 0) k = (k + 1) & mask;
    slots_[k] = slot;
  }
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
  const std::vector<std::string> known = structure_classes();
  if (std::find(known.begin(), known.end(), class_name) == known.end())
    throw Error("the class \"" + excerpt(class_name) + "\" is none of " + listed(known));

  constexpr const char* kCycleClasses[] = {"tree", "1-cycle", "2-cycle", "n-cycle"};
  if (std::find(std::begin(kCycleClasses), std::end(kCycleClasses), class_name) ==
      std::end(kCycleClasses))
    return;
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
  if (structure.length_unit.empty()) throw Error("the structure has no length unit");
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
