// ContactList: pairs of joints that are near each other, kept while no joint has moved too far.

#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <utility>  // pair
#include <vector>

#include "ragdoll/box.h"            // Box
#include "ragdoll/cell_list.h"      // CellPair
#include "ragdoll/contact_rule.h"   // ContactRule
#include "ragdoll/contact_table.h"  // ContactTable
#include "ragdoll/vec3.h"           // Vec3

namespace ragdoll {

/// A pair that the rule watches, p < q.
struct NearPair {
  int p = 0, q = 0;
  double bound = 0;  ///< nm
};

/// Holds every pair closer than its bound plus `reach`, sorted by (p, q), so that what is done with
/// the pairs does not depend on when the list was made.
///
/// There are two lists: the outer one has a wider skin and is searched for by cells; the pairs
/// are chosen from it, more often. Each knows by how much its pairs were farther apart than their
/// bounds, so that a pair is looked at only if its own two joints have moved so far.
class ContactList {
 public:
  /// @param rule  it must outlive the list
  /// @param skin  nm; pairs are kept up to bound + skin. With a larger skin they are chosen more
  ///              rarely, and there are more of them
  ContactList(const ContactRule& rule, double skin);

  /// Chooses or searches anew if some pair closer than bound + reach could be missing.
  /// @param positions  finite
  /// @return true if the pairs changed
  bool update(std::span<const Vec3> positions, const Box* box, double reach);

  const std::vector<NearPair>& pairs() const { return pairs_; }

  /// Updates, and hands out the pairs closer than bound + reach; no others.
  void find_near(std::span<const Vec3> positions, const Box* box, double reach,
                 std::vector<NearPair>& near);

  std::int64_t searches() const { return searches_; }  ///< how often the cells were searched

 private:
  /// A pair and its slack: how much farther apart than its bound it was at least when it was
  /// listed.
  struct Spaced {
    int p, q;
    float slack;  ///< nm
  };
  /// Pairs up to bound + skin from where the joints were.
  struct Level {
    double skin = 0;
    std::vector<Vec3> reference;              ///< (njoint)
    std::vector<std::pair<int, int>> joints;  ///< of the pairs, sorted
    std::vector<float> slacks;                ///< of the pairs
  };
  bool same_space(std::size_t joints, const Box* box) const;
  void search(std::span<const Vec3> positions, const Box* box, double reach);
  void choose(std::span<const Vec3> positions, const Box* box, double skin);
  std::span<const int> select(const Level& level, double limit);
  void sort_outer(std::size_t joints, std::size_t pairs);

  ContactTable table_;
  double skin_;
  Level outer_, middle_;
  std::vector<NearPair> pairs_;  ///< those of the middle level
  std::optional<Box> box_;       ///< the box of the last search
  bool lasting_ = false;         ///< the levels hold as long as joints stay near
  std::int64_t searches_ = 0;

  // scratch
  std::vector<CellPair> candidates_;
  std::vector<Spaced> unsorted_, half_sorted_;
  std::vector<int> cursor_;
  std::vector<float> moved_;  ///< of each joint since the level at hand was made, nm
  float most_moved_ = 0;      ///< by two joints together, nm
  std::vector<int> selected_;
};

}  // namespace ragdoll
