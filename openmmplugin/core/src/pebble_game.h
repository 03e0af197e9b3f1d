// PebbleGame: counts the independent bars of a body-bar framework, one bond after the other.

#pragma once
#include <array>
#include <utility>
#include <vector>

#include "disjoint_sets.h"  // DisjointSets

namespace ragdoll {

/// The (6, 6) pebble game. A body is born with six pebbles, its free motions; an independent bar
/// costs one. Each pebble that a bar took stays with it and points from the body that paid to the
/// body at the other end; turning that arrow round moves a pebble. Bars are independent while no
/// set of bodies pays for more than 6 x bodies - 6 of its own.
///
/// Bodies are merged, each merged set being one body with six pebbles, where a failed search shows
/// that they are rigid together: the search is paid for by the merge, which makes the whole near
/// linear. Calling `add` alone merges what is over-constrained; `join_if_rigid` and `settle` merge
/// what is rigid.
class PebbleGame {
 public:
  explicit PebbleGame(int bodies);

  /// Puts up to `bars` bars between two bodies. Where one is redundant, all bodies that it finds
  /// over-constrained are merged.
  /// @return how many of them are independent
  int add(int a, int b, int bars);

  /// Whether two bodies cannot move against each other; merges the smallest rigid set of both.
  bool join_if_rigid(int a, int b);

  /// Merges into a body everything that is rigid with it. `add` and `join_if_rigid` leave this to
  /// the caller: a set that hangs on the merged one by all its bars is not found by theirs.
  void settle(int body);

  /// Bodies that a bar added now would over-constrain, were it between a and b: the smallest rigid
  /// set that holds both, as representatives; empty where the bar would be independent.
  std::vector<int> rigid_set(int a, int b);

  /// The body that stands for all those merged with it.
  int representative(int body) { return sets_.find(body); }

  /// Pairs of bodies in the order in which they were merged.
  const std::vector<std::pair<int, int>>& merges() const { return merges_; }

  /// Bodies that all searches looked at: the cost, in a unit that no machine changes.
  long visits() const { return visits_; }

 private:
  static constexpr int pebbles_each = 6;
  static constexpr int free_pebble = -1;
  /// One end of a bond, in a ring of all ends that meet one merged body.
  struct End {
    int other;  ///< body at the bond's other end
    int next;   ///< in the ring
  };

  void gather(int body);
  bool search(int start, int held);
  void carry(int start, int end);
  int merge_visited(int held);
  void link(int body, int other);
  void list_ends(int body, std::vector<int>& list) const;
  void put_into(int& ring, int end);
  int free_count(int body) const;
  int free_slot(int body) const;

  std::vector<std::array<int, pebbles_each>> pebbles_;  ///< free, or the body that the bar reaches
  DisjointSets sets_;
  std::vector<int> mark_, from_;  ///< last search that saw a body, and whence it came
  std::vector<int> queue_;        ///< bodies of the last search, in its order
  std::vector<End> ends_;
  std::vector<int> ring_;  ///< an end of each body, or -1
  std::vector<std::pair<int, int>> merges_;
  int search_ = 0;
  long visits_ = 0;
};

}  // namespace ragdoll
