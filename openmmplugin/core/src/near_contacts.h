// Near contacts: the pairs of the contact rule that could be violated, and their sweep. Private to
// the resolvers.

#pragma once
#include <algorithm>  // upper_bound
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ragdoll/box.h"           // Box
#include "ragdoll/contact_list.h"  // ContactList, NearPair
#include "ragdoll/framework.h"     // Framework
#include "strided_points.h"        // StridedPoints
#include "sweep_arithmetic.h"      // PassTally, Slack

namespace ragdoll {

/// Only pairs that could be violated are looked at; when joints have moved so far that others could
/// be, the pairs are looked up anew and the sweep goes on behind the pair it had come to. Where
/// that happens again and again, the pass looks at all pairs of the joints that left their room. So
/// the result is that of looking at every pair in each pass, whatever was looked up when.
///
/// Positions may be floats; a contact is computed in doubles, and rounded where it is stored.
template <class T>
class NearContacts {
 public:
  /// @param list  may be shared, by conformers that are near each other: who is not takes one of
  /// his
  ///              own later
  /// @param looked_up_at  room for positions, kept by the caller in the layout of those it sweeps
  NearContacts(const Framework& framework, const Slack<T>& slack, std::shared_ptr<ContactList> list,
               StridedPoints<T> looked_up_at);

  bool empty() const { return framework_.contact_rule().empty(); }

  /// A new break.
  void begin(const Box* box);

  /// Whether all pairs that could be violated are known: no joint has moved further than this
  /// allows since they were looked up.
  bool reach_holds(StridedPoints<T> x) const;

  /// How far each of two joints may move before pairs between them could be missing. nm
  static constexpr double room = 0.01;

  /// For callers that know how far joints have moved: whether there is anything to have moved from.
  bool looked_up() const { return known_; }

  /// One pass.
  void sweep(StridedPoints<T> x, PassTally& tally) {
    if (!start_pass(x, reach_holds(x), tally)) return;
    for (std::size_t k = 0; k < near_.size() && tally.finite;) {
      const NearPair pair = near_[k];
      const bool renewed = visit(x, pair, tally);
      if (scattered_) {
        finish_scattered(x, pair, tally);
        return;
      }
      k = renewed ? place_behind(near_, pair) : k + 1;
    }
  }

  // what sweep() does, for callers that visit the pairs themselves

  /// Looks pairs up if need be. @param holds  reach_holds(x). @return false on no numbers
  bool start_pass(StridedPoints<T> x, bool holds, PassTally& tally);

  /// One pair. @return true if pairs were looked up anew: go on behind it
  bool visit(StridedPoints<T> x, const NearPair& pair, PassTally& tally);

  /// How often pairs were looked up.
  std::int64_t look_ups() const { return look_ups_; }

  /// What was looked up last, sorted.
  const std::vector<NearPair>& near() const { return near_; }

  /// Where the first pair behind this one is in sorted pairs.
  template <class Pairs>
  static std::size_t place_behind(const Pairs& pairs, const NearPair& pair) {
    const auto after = std::upper_bound(
        pairs.begin(), pairs.end(), pair,
        [](const auto& a, const auto& b) { return a.p != b.p ? a.p < b.p : a.q < b.q; });
    return std::size_t(after - pairs.begin());
  }

  /// visit() gave up looking pairs up anew, because joints fly about: only sweep() knows how to go
  /// on.
  bool scattered() const { return scattered_; }

  /// The pairs that could be violated where the joints are.
  std::span<const NearPair> pairs(StridedPoints<T> x);

 private:
  bool moved_within_room(StridedPoints<T> x, int joint) const;
  void look_up(StridedPoints<T> x);
  bool correct(StridedPoints<T> x, const NearPair& pair, PassTally& tally) const;
  void finish_scattered(StridedPoints<T> x, NearPair pair, PassTally& tally);
  void find_strays(StridedPoints<T> x);
  NearPair next_pair(const NearPair& pair) const;

  const Framework& framework_;
  Slack<T> slack_;
  std::shared_ptr<ContactList> list_;
  std::vector<NearPair> near_;
  StridedPoints<T> looked_up_at_;
  bool known_ = false;  ///< looked_up_at_ is filled
  bool scattered_ = false;
  std::int64_t look_ups_ = 0;
  int renewals_ = 0;  ///< in this pass
  const Box* box_ = nullptr;
  bool had_box_ = false;  ///< when pairs were looked up
  Box last_box_{};
  std::vector<Vec3> gathered_;  ///< scratch
  std::vector<int> strays_;     ///< joints that left their room, sorted
};

/// A list for NearContacts.
std::shared_ptr<ContactList> near_contact_list(const Framework& framework);

extern template class NearContacts<float>;
extern template class NearContacts<double>;

}  // namespace ragdoll
