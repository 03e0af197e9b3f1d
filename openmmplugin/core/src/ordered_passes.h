// Ordered passes: the thesis' loop of one break, in floats or doubles. Every bar in its order, each
// corrected along itself by its weighting, again and again until all are within tolerance. Tethers,
// contacts and volumes follow the bars in each pass. Private to the resolvers.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "conclusion.h"           // conclude, residual_of
#include "moved_bars.h"           // MovedBars
#include "near_contacts.h"        // NearContacts
#include "ordered_constraints.h"  // OrderedConstraints
#include "ragdoll/resolver.h"     // ResolverSettings, Breakage, StopReason
#include "sweep_arithmetic.h"     // PassTally
#include "sweep_order.h"          // SweepOrder

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

  /// Of the contact rule, where the last run left the joints.
  std::span<const NearPair> near_pairs() { return near_contacts_.pairs(points()); }

 private:
  bool only_moved_bars() const;
  bool bars_only() const;
  OrderedOutcome loop(Random& random);
  void sweep_constraints();
  void sweep_bars();
  void sweep_moved_bars();
  bool all_finite() const;
  bool within_tolerance() {
    return ragdoll::within_tolerance(framework_, points(), box_, settings_.tolerance, near_pairs());
  }
  int worst_bar() const;
  StridedPoints<T> points() const { return {x_, joint_count_}; }

  const Framework& framework_;
  ResolverSettings settings_;
  std::size_t joint_count_;
  SweepOrder sweep_order_;
  OrderedConstraints<T> constraints_;
  std::vector<T> looked_up_at_;
  NearContacts<T> near_contacts_;
  MovedBars<T> moved_bars_;

  // the break at hand
  T* x_ = nullptr;
  const Box* box_ = nullptr;
  PassTally tally_;
  std::int64_t bar_visits_ = 0;  ///< in this pass
};

/// Fills in the report of passes in T, and of the positions that they are handed back as.
/// @param near  the pairs of the contact rule that could be violated
/// @return false if floats found them to be within tolerance, and doubles do not
template <class T>
bool conclude_passes(ResolveReport& report, const OrderedOutcome& outcome,
                     const Framework& framework, std::span<const Vec3> positions, const Box* box,
                     const Tolerance& tolerance, std::span<const NearPair> near) {
  Residual residual;
  if (is_resolved(outcome.reason)) {
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
