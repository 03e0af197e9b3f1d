// Sketches of the thesis' classes: trees, and trees with bars that close cycles.

#include <algorithm>  // min, max
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>

#include "ragdoll/error.h"  // Error
#include "sketch.h"

namespace ragdoll {
namespace {

/// How many joints a tree can still get below a joint of each depth, up to the joints wanted.
std::vector<long> room_below(const Sketch& sketch, int children) {
  const long wanted = sketch.request.joints;
  const int deepest = sketch.request.depth > 0 ? sketch.request.depth : sketch.request.joints;
  std::vector<long> room = {0};  // from the deepest level up
  while (int(room.size()) <= deepest && room.back() < wanted)
    room.push_back(std::min(wanted, children * (1 + room.back())));
  // levels above those are as roomy as can be
  std::vector<long> by_depth(std::size_t(deepest) + 1, wanted);
  for (std::size_t k = 0; k < room.size() && k <= std::size_t(deepest); ++k)
    by_depth[std::size_t(deepest) - k] = room[k];
  return by_depth;
}

/// Between 2 and 4 children where it is left open: 1 would make a chain.
int children_of(Sketch& sketch) {
  return sketch.request.children > 0 ? sketch.request.children : sketch.between(2, 4);
}

/// Trees hung on what is there: each joint still missing gets a bar to one of those before it.
void hang_trees(Sketch& sketch) {
  while (sketch.missing() > 0) {
    const int parent = sketch.below(sketch.joints());
    sketch.add_bar(parent, sketch.add_random_joint());
  }
}

/// `count` new joints in a row after `from`; the last of them.
int add_chain(Sketch& sketch, int from, int count) {
  for (int k = 0; k < count; ++k) {
    const int joint = sketch.add_random_joint();
    sketch.add_bar(from, joint);
    from = joint;
  }
  return from;
}

/// A cycle of `length` joints, of which `from` is the first.
void add_cycle(Sketch& sketch, int from, int length) {
  const int last = add_chain(sketch, from, length - 1);
  sketch.add_bar(last, from);
}

/// Bars between pairs that have none, each pair equally likely.
/// @param sketch  a tree, whose bar k - 1 joins joint k to its parent
void add_bars(Sketch& sketch, long count) {
  const long n = sketch.joints();
  const long pairs = n * (n - 1) / 2 - (n - 1);
  std::vector<int> parent(std::size_t(n), -1);
  for (const auto& [p, q] : sketch.bars) parent[std::size_t(q)] = p;
  const auto in_tree = [&](int p, int q) {
    return parent[std::size_t(p)] == q || parent[std::size_t(q)] == p;
  };

  // most of all pairs: list them, and take from the list
  if (count > pairs / 2) {
    std::vector<std::pair<int, int>> open;
    for (int q = 0; q < n; ++q)
      for (int p = 0; p < q; ++p)
        if (!in_tree(p, q)) open.emplace_back(p, q);
    for (long k = 0; k < count; ++k) {
      const std::size_t pick = std::size_t(k) + std::size_t(sketch.below(pairs - k));
      std::swap(open[std::size_t(k)], open[pick]);
      sketch.bars.push_back(open[std::size_t(k)]);
    }
    return;
  }
  // few of them: draw until a pair is free
  std::unordered_set<std::uint64_t> added;
  added.reserve(std::size_t(count));
  while (long(added.size()) < count) {
    const int p = sketch.below(n), q = sketch.below(n);
    if (p == q || in_tree(p, q)) continue;
    const std::uint64_t key = std::uint64_t(std::min(p, q)) << 32 | std::uint64_t(std::max(p, q));
    if (added.insert(key).second) sketch.add_bar(p, q);
  }
}

// === The constructions of a 2-cycle

void shared_joint(Sketch& sketch) {
  const std::vector<int> more = sketch.deal(sketch.missing() - 5, 3);  // the third: trees
  const int joint = sketch.add_random_joint();
  add_cycle(sketch, joint, 3 + more[0]);
  add_cycle(sketch, joint, 3 + more[1]);
  hang_trees(sketch);
}

void joined_by_path(Sketch& sketch) {
  const std::vector<int> more = sketch.deal(sketch.missing() - 6, 4);
  add_cycle(sketch, sketch.add_random_joint(), 3 + more[0]);
  const int from = sketch.below(sketch.joints());
  const int to = add_chain(sketch, from, more[1] + 1);
  add_cycle(sketch, to, 3 + more[2]);
  hang_trees(sketch);
}

void path_across(Sketch& sketch) {
  // a chord needs a cycle of 4, a path with joints of its own one of 3
  std::vector<int> more = sketch.deal(sketch.missing() - 3, 3);
  if (more[0] == 0 && more[1] == 0) {
    --more[2];
    ++more[std::size_t(sketch.below(2))];
  }
  const int length = 3 + more[0], inner = more[1];
  add_cycle(sketch, sketch.add_random_joint(), length);
  const int p = sketch.below(length);
  // joints p + 1 and p - 1 have a bar to p already
  const int apart = inner > 0 ? sketch.between(1, length - 1) : sketch.between(2, length - 2);
  const int q = (p + apart) % length;
  sketch.add_bar(add_chain(sketch, p, inner), q);
  hang_trees(sketch);
}

void tree_and_bars(Sketch& sketch, long count) {
  sketch_tree(sketch);
  add_bars(sketch, count);
}

/// The construction that is asked for, or by chance one of the possible ones.
char construction_of(Sketch& sketch, std::string_view possible, std::string_view all) {
  const std::string& wanted = sketch.request.construction;
  if (wanted.empty()) return possible[std::size_t(sketch.below(long(possible.size())))];
  if (wanted.size() == 1 && all.find(wanted[0]) != std::string_view::npos) return wanted[0];
  throw Error("construction '" + wanted + "' of a " + sketch.request.class_name +
              " is not known; choose one of a to " + std::string(all.substr(all.size() - 1)));
}

/// 0 where the type is left open.
char construction_of_type(const StructureRequest& request) {
  const std::string& type = request.type;
  char construction = 0;
  if (type == "shared-joint") construction = 'b';
  if (type == "path") construction = 'c';
  if (type == "theta") construction = 'd';
  if (!type.empty() && construction == 0)
    throw Error("type '" + type +
                "' of a 2-cycle is not known; choose one of: path, shared-joint, theta");
  if (construction != 0 && !request.construction.empty() &&
      request.construction != std::string_view(&construction, 1))
    throw Error("a 2-cycle of type " + type + " is asked for by its type or by its construction, " +
                "not by both");
  return construction;
}

}  // namespace

void sketch_tree(Sketch& sketch) {
  const StructureRequest& request = sketch.request;
  if (request.depth < 0 || request.children < 0)
    throw Error("depth and children of a tree must be 0 or more");
  const int children = children_of(sketch);
  const std::vector<long> room_of = room_below(sketch, children);
  if (room_of[0] + 1 < request.joints)
    throw Error("a tree of depth " + std::to_string(request.depth) + " with up to " +
                std::to_string(children) + " children has no room for " +
                std::to_string(request.joints) + " joints");

  // level by level, each joint with as many children as chance has it; `room` is what the joints
  // that wait can still take up, and a joint gets enough children that the rest find room
  std::vector<int> depth = {0};
  depth.reserve(std::size_t(request.joints));
  sketch.add_random_joint();
  long room = room_of[0];
  for (int parent = 0; sketch.missing() > 0; ++parent) {
    const std::size_t level = std::size_t(depth[std::size_t(parent)]);
    room -= room_of[level];
    if (room_of[level] == 0) continue;
    const long each = 1 + room_of[level + 1];
    const long lacking = sketch.missing() - room;
    const long least = lacking > 0 ? (lacking + each - 1) / each : 0;
    const long most = std::min<long>(children, sketch.missing());
    for (int k = sketch.between(std::min(least, most), most); k > 0; --k) {
      sketch.add_bar(parent, sketch.add_random_joint());
      depth.push_back(int(level) + 1);
      room += room_of[level + 1];
    }
  }
}

void sketch_one_cycle(Sketch& sketch) {
  if (construction_of(sketch, "ab", "ab") == 'a') return tree_and_bars(sketch, 1);
  add_cycle(sketch, sketch.add_random_joint(), sketch.between(3, sketch.request.joints));
  hang_trees(sketch);
}

void sketch_two_cycle(Sketch& sketch) {
  const int joints = sketch.request.joints;
  const std::string_view possible = joints >= 6 ? "abcd" : joints == 5 ? "abd" : "ad";
  char construction = construction_of_type(sketch.request);
  if (construction == 0) construction = construction_of(sketch, possible, "abcd");
  if (construction == 'b' && joints < 5)
    throw Error("two cycles that share a joint have at least 5 joints, not " +
                std::to_string(joints));
  if (construction == 'c' && joints < 6)
    throw Error("two cycles joined by a path have at least 6 joints, not " +
                std::to_string(joints));
  if (construction == 'a') tree_and_bars(sketch, 2);
  if (construction == 'b') shared_joint(sketch);
  if (construction == 'c') joined_by_path(sketch);
  if (construction == 'd') path_across(sketch);
}

void sketch_n_cycle(Sketch& sketch) {
  const long n = sketch.request.joints;
  const long open = n * (n - 1) / 2 - (n - 1);
  long cycles = sketch.request.cycles;
  if (cycles != 0 && cycles < 3)
    throw Error("an n-cycle has at least 3 bars beside its tree's, not " + std::to_string(cycles));
  if (cycles > open || cycles > 100'000'000)
    throw Error("a tree of " + std::to_string(n) + " joints has room for " +
                std::to_string(std::min(open, 100'000'000L)) + " more bars, not " +
                std::to_string(cycles));
  if (cycles == 0) cycles = sketch.between(3, std::min(open, 3 + n / 4));
  tree_and_bars(sketch, cycles);
}

}  // namespace ragdoll
