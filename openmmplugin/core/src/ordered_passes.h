// Ordered passes: the thesis' loop of one break, in floats or doubles. Every bar in its order, each
// corrected along itself by its weighting, again and again until all are within tolerance. Tethers,
// contacts and volumes follow the bars in each pass. Private to the resolvers.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "moved_bars.h"        // MovedBars
#include "near_contacts.h"     // NearContacts
#include "ragdoll/resolver.h"  // ResolverSettings, Breakage, StopReason
#include "sweep_arithmetic.h"  // BarVisit, PassTally, Slack
#include "sweep_order.h"       // SweepOrder

namespace ragdoll {

template <class T>
class OrderedPasses {
 public:
  OrderedPasses(const Framework& framework, const ResolverSettings& settings);

  struct Outcome {
    StopReason reason = StopReason::nothing_broken;
    std::int64_t iterations = 0, bar_visits = 0;
  };

  /// @param x  positions, three numbers each (3 njoint)
  Outcome run(T* x, const Breakage& breakage);

  /// Of the contact rule, where the last run left the joints.
  std::span<const NearPair> near_pairs() { return contacts_.pairs(points()); }

 private:
  void set_order(const Order& order);
  bool only_moved_bars() const;
  bool bars_only() const;
  Outcome loop(Random& random);
  void sweep_constraints();
  void sweep_bars();
  void sweep_moved_bars();
  bool all_finite() const;
  bool within_tolerance();
  int worst_bar() const;
  StridedPoints<T> points() const { return {x_, joint_count_}; }

  const Framework& framework_;
  ResolverSettings settings_;
  std::size_t joint_count_;
  Slack<T> slack_;
  SweepOrder sweep_order_;
  std::vector<BarVisit<T>> visits_;
  std::vector<BarCorrection<T>> corrections_;  ///< of the visits
  std::vector<PairVisit<T>> tethers_, pairs_;
  std::vector<VolumeVisit<T>> volumes_;
  std::vector<T> looked_up_at_;
  NearContacts<T> contacts_;
  MovedBars<T> moved_bars_;

  // the break at hand
  T* x_ = nullptr;
  const Box* box_ = nullptr;
  PassTally tally_;
  std::int64_t bar_visits_ = 0;  ///< in this pass
};

extern template class OrderedPasses<float>;
extern template class OrderedPasses<double>;

}  // namespace ragdoll
