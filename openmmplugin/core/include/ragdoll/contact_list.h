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
/// Pairs are searched for by cells up to a wide skin, and listed by how much farther apart they
/// were than their bounds: so one look at the joints that moved most tells how much of the list
/// could matter now, and of that a pair is looked at only if its own two joints moved so far.
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
  template <class Index>
  struct Ends {
    Index p, q;
  };
  /// A pair and its slack: how much farther apart than its bound it was at least.
  struct Spaced {
    int p, q;
    float slack;  ///< nm
  };
  bool same_space(std::size_t joints, const Box* box) const;
  double room_left(double skin, const std::vector<Vec3>& reference, std::span<const Vec3> positions,
                   const Box* box);
  void search(std::span<const Vec3> positions, const Box* box, double reach);
  template <class Index>
  void list(std::span<const Spaced> pairs, std::vector<Ends<Index>>& listed);
  std::size_t bucket_of(float slack) const;
  void find_listed(std::span<const Vec3> positions, const Box* box, double reach,
                   std::vector<NearPair>& near);
  template <class Index>
  std::size_t select(const std::vector<Ends<Index>>& listed, float farthest);
  void sort(std::vector<NearPair>& near);

  ContactTable table_;
  double skin_;
  std::vector<NearPair> pairs_;
  std::vector<Vec3> pairs_at_;  ///< where the joints were when they were chosen (njoint)
  double pairs_skin_ = -1;      ///< nm; below 0: none are chosen

  // the list: pairs up to bound + listed_skin_ from where the joints were, in buckets by slack
  double listed_skin_ = 0;                  ///< nm
  std::vector<Vec3> listed_at_;             ///< (njoint)
  std::vector<Ends<std::uint16_t>> short_;  ///< in as little memory as may be: it is read often
  std::vector<Ends<std::int32_t>> long_;    ///< where there are more joints
  std::vector<std::size_t> bucket_end_;     ///< (nbucket)
  std::optional<Box> box_;                  ///< of the last search
  bool lasting_ = false;                    ///< the list holds as long as joints stay near
  std::int64_t searches_ = 0;

  // scratch
  std::vector<float> moved_;  ///< of each joint since a reference, nm (njoint)
  float most_moved_ = 0;      ///< by two joints together, nm
  std::vector<CellPair> candidates_;
  std::vector<Ends<std::int32_t>> selected_;
  std::vector<int> cursor_;
  std::vector<NearPair> unsorted_;
};

}  // namespace ragdoll
