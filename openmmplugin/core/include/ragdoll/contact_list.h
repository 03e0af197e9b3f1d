// ContactList: pairs of joints that are near each other, found by a cell list with a skin and kept
// while no joint has moved too far.

#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "ragdoll/box.h"           // Box
#include "ragdoll/contact_rule.h"  // ContactRule
#include "ragdoll/vec3.h"          // Vec3

namespace ragdoll {

/// A pair that the rule watches, p < q.
struct NearPair {
  int p = 0, q = 0;
  double bound = 0;  ///< nm
};

/// Holds every pair closer than its bound plus `reach`, sorted by (p, q), so that what is done with
/// the pairs does not depend on when the list was made.
class ContactList {
 public:
  /// @param skin  nm; pairs are kept up to bound + skin. A larger skin is searched for more rarely
  ContactList(const ContactRule& rule, double skin);

  /// Searches anew if some pair closer than bound + reach could be missing.
  /// @return true if the pairs changed
  bool update(std::span<const Vec3> positions, const Box* box, double reach);

  const std::vector<NearPair>& pairs() const { return pairs_; }

  std::int64_t searches() const { return searches_; }  ///< how often the cells were searched

 private:
  bool still_valid(std::span<const Vec3> positions, const Box* box, double reach) const;
  void search(std::span<const Vec3> positions, const Box* box);

  const ContactRule& rule_;
  double skin_;
  std::vector<NearPair> pairs_;
  std::vector<Vec3> reference_;  ///< where the joints were at the last search (njoint)
  std::optional<Box> box_;       ///< the box of the last search
  std::int64_t searches_ = 0;
};

}  // namespace ragdoll
