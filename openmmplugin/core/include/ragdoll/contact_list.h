// ContactList: pairs of joints that are near each other, kept while no joint has moved too far.

#pragma once
#include <cstdint>
#include <optional>
#include <span>
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

/// Finds every pair closer than its bound plus `reach`, sorted by (p, q), so that what is done with
/// the pairs does not depend on when they were listed.
///
/// There are two levels: pairs up to a wide skin, searched for by cells; and of these, chosen more
/// often, those up to a narrower one. Each lists its pairs by how much farther apart they were than
/// their bounds: so one look at the joints that moved most tells how much of the list could matter
/// now, and of that a pair is looked at only if its own two joints moved so far.
class ContactList {
 public:
  /// @param rule  it must outlive the list
  /// @param skin  nm; update() keeps pairs up to bound + skin. With a larger skin they are chosen
  ///              more rarely, and there are more of them
  ContactList(const ContactRule& rule, double skin);

  /// Chooses or searches anew if some pair closer than bound + reach could be missing from pairs().
  /// @param positions  finite
  /// @return true if the pairs changed
  bool update(std::span<const Vec3> positions, const Box* box, double reach);

  /// What update() chose last.
  const std::vector<NearPair>& pairs() const { return pairs_; }

  /// The pairs closer than bound + reach; no others.
  /// @param positions  finite
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
  /// Pairs up to their bounds plus `skin` from where the joints were.
  struct Level {
    double skin = -1;                     ///< nm; below 0: nothing is listed
    std::vector<Vec3> reference;          ///< (njoint)
    std::vector<Spaced> pairs;            ///< in buckets by slack
    std::vector<std::size_t> bucket_end;  ///< (nbucket)

    void list(std::span<const Spaced> unsorted);
    std::size_t bucket_of(float slack) const;
  };
  bool same_space(std::size_t joints, const Box* box) const;
  double room_left(const Level& level, std::span<const Vec3> positions, const Box* box);
  bool renew(std::span<const Vec3> positions, const Box* box, double reach);
  void search(std::span<const Vec3> positions, const Box* box, double reach);
  void choose(std::span<const Vec3> positions, const Box* box, double skin);
  std::span<const int> select(const Level& level, double limit);
  void sort(std::span<const NearPair> pairs, std::vector<NearPair>& sorted);

  ContactTable table_;
  double skin_;
  Level outer_, middle_;
  std::vector<NearPair> pairs_;
  bool pairs_known_ = false;  ///< they are those of the middle level
  std::optional<Box> box_;    ///< the box of the last search
  bool lasting_ = false;      ///< the levels hold as long as joints stay near
  std::int64_t searches_ = 0;

  // scratch
  std::vector<float> moved_;  ///< of each joint since the level at hand was made, nm
  float most_moved_ = 0;      ///< by two joints together, nm
  std::vector<CellPair> candidates_;
  std::vector<Spaced> spaced_;
  std::vector<int> selected_, cursor_;
  std::vector<NearPair> unsorted_;
};

}  // namespace ragdoll
