// Ordered passes: the thesis' loop of one break, in floats or doubles. Every bar in its order, each
// corrected along itself by its weighting, again and again until all are within tolerance. Tethers,
// contacts and volumes follow the bars in each pass. Private to the resolvers.

#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "conclusion.h"           // conclude, residual_of
#include "joint_places.h"         // JointPlaces
#include "known_residual.h"       // KnownResidual
#include "near_contacts.h"        // NearContacts
#include "ordered_constraints.h"  // OrderedConstraints
#include "ragdoll/resolver.h"     // ResolverSettings, Breakage, StopReason
#include "sweep_arithmetic.h"     // PassTally
#include "sweep_order.h"          // SweepOrder
#include "work_list.h"            // WorkList

namespace ragdoll {

struct OrderedOutcome {
  StopReason reason = StopReason::nothing_broken;
  std::int64_t iterations = 0, bar_visits = 0;
};

/// Every constraint is within tolerance, in doubles.
template <class T>
bool within_tolerance(const Framework& framework, StridedPoints<T> points, const Box* box,
                      const Tolerance& tolerance, std::span<const NearPair> near) {
  std::vector<Vec3> positions;
  points.copy_to(positions);
  return residual_of(framework, positions, box, tolerance, near).within;
}

template <class T>
class OrderedPasses {
 public:
  OrderedPasses(const Framework& framework, const ResolverSettings& settings);

  /// @param x  positions, three numbers each (3 njoint)
  OrderedOutcome run(T* x, const Breakage& breakage);

  /// Where the last run left the joints, if it is known without looking at all of them.
  std::optional<Residual> known_residual() const {
    if (!resolved_) return std::nullopt;
    if (placed_residual_) return placed_residual_;
    return few_ ? std::optional(known_residual_->largest()) : std::nullopt;
  }

  /// The joints that the last run moved and the roots, if only roots had moved before; else null.
  const std::vector<int>* moved_joints() const { return few_ && resolved_ ? &moved_ : nullptr; }

  /// Of the contact rule, where the last run left the joints.
  std::span<const NearPair> near_pairs() { return near_contacts_.pairs(points()); }

 private:
  bool uses_work_list() const;
  bool only_few_moved(const Breakage& breakage) const;
  bool bars_only() const;
  void prepare_order(const Breakage& breakage, Random& random);
  void set_order(const Order& order);
  void place_joints(const Order& order);
  OrderedOutcome loop_in_places(Random& random);
  bool all_finite(const Breakage& breakage) const;
  void move(int joint);
  std::size_t next_moved(std::size_t place);
  void remember();
  void mark_moved(const Breakage& breakage);
  OrderedOutcome loop(Random& random);
  void sweep_constraints();
  void sweep_bars();
  void sweep_work_list();
  bool within_tolerance() {
    if (places_) return residual_in_places().within;
    return ragdoll::within_tolerance(framework_, points(), box_, settings_.tolerance, near_pairs());
  }
  Residual residual_in_places() const;
  int worst_bar() const;
  StridedPoints<T> points() const { return {x_, joint_count_}; }

  const Framework& framework_;
  ResolverSettings settings_;
  std::size_t joint_count_;
  SweepOrder sweep_order_;
  OrderedConstraints<T> constraints_;
  std::vector<T> looked_up_at_;
  NearContacts<T> near_contacts_;
  WorkList<T> work_list_;
  bool resolved_ = false;  ///< the last run ended so, and the work list remembers where

  // where joints' own numbers scatter them: positions are copied to places, and constraints name
  // these
  std::optional<JointPlaces> places_;
  std::vector<T> placed_;         ///< (3 njoint)
  std::vector<Bar> placed_bars_;  ///< in their order (nbar)
  std::optional<Residual> placed_residual_;

  // where only roots had moved
  bool few_ = false;
  std::optional<KnownResidual> known_residual_;
  std::vector<int> moved_;              ///< joints
  std::vector<std::uint8_t> is_moved_;  ///< is in moved_ (njoint)

  // the break at hand
  T* x_ = nullptr;
  const Box* box_ = nullptr;
  PassTally tally_;
  std::int64_t bar_visits_ = 0;  ///< in this pass
};

/// Fills in the report of passes in T, and of the positions that they are handed back as.
/// @param near   the pairs of the contact rule that could be violated
/// @param known  the residual, if it is
/// @return false if floats found them to be within tolerance, and doubles do not
template <class T>
bool conclude_passes(ResolveReport& report, const OrderedOutcome& outcome,
                     const Framework& framework, std::span<const Vec3> positions, const Box* box,
                     const Tolerance& tolerance, std::span<const NearPair> near,
                     const std::optional<Residual>& known = {}) {
  Residual residual = known.value_or(Residual());
  if (is_resolved(outcome.reason) && !known) {
    residual = residual_of(framework, positions, box, tolerance, near);
    if (Slack<T>::single && !residual.within) return false;
  }
  report.iterations = outcome.iterations;
  report.bar_visits = outcome.bar_visits;
  conclude(report, outcome.reason, framework, positions, box, tolerance, residual);
  return true;
}

extern template class OrderedPasses<float>;
extern template class OrderedPasses<double>;

}  // namespace ragdoll
