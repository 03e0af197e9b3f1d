// Near contacts: the pairs of the contact rule that could be violated, and their sweep. Private to
// the resolvers.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/box.h"           // Box
#include "ragdoll/contact_list.h"  // ContactList, NearPair
#include "ragdoll/framework.h"     // Framework
#include "strided_points.h"        // StridedPoints
#include "sweep_arithmetic.h"      // PassTally, Slack

namespace ragdoll {

/// Only pairs that could be violated are looked at; when joints have moved so far that others could
/// be, the pairs are looked up anew and the sweep goes on behind the pair it had come to. So the
/// result is that of looking at every pair in each pass, whatever was looked up when.
///
/// Positions may be floats; a contact is computed in doubles, and rounded where it is stored.
template <class T>
class NearContacts {
 public:
  /// @param looked_up_at  room for positions, kept by the caller in the layout of those it sweeps
  NearContacts(const Framework& framework, const Slack<T>& slack, StridedPoints<T> looked_up_at);

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
  /// @param holds  reach_holds(x)
  void sweep(StridedPoints<T> x, bool holds, PassTally& tally);

  /// The pass gave up looking pairs up anew: joints fly about, and what the result is depends on
  /// when that was.
  bool scattered() const { return scattered_; }

  /// The pairs that could be violated where the joints are.
  std::span<const NearPair> pairs(StridedPoints<T> x);

 private:
  bool moved_within_room(StridedPoints<T> x, int joint) const;
  void look_up(StridedPoints<T> x);
  bool correct(StridedPoints<T> x, const NearPair& pair, PassTally& tally) const;

  const Framework& framework_;
  Slack<T> slack_;
  ContactList list_;
  std::vector<NearPair> near_;
  StridedPoints<T> looked_up_at_;
  bool known_ = false;  ///< looked_up_at_ is filled
  bool scattered_ = false;
  const Box* box_ = nullptr;
  bool had_box_ = false;  ///< when pairs were looked up
  Box last_box_{};
  std::vector<Vec3> gathered_;  ///< scratch
};

extern template class NearContacts<float>;
extern template class NearContacts<double>;

}  // namespace ragdoll
