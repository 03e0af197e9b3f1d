// Ordered constraints: all that the passes of `ordered` visit, in the order in which they do, ready
// to be tested and corrected in floats or doubles. Private to the resolvers.

#pragma once
#include <vector>

#include "ragdoll/resolver.h"  // ResolverSettings
#include "sweep_arithmetic.h"  // BarVisit, PairVisit, VolumeVisit, Slack
#include "sweep_order.h"       // SweepOrder

namespace ragdoll {

template <class T>
struct OrderedConstraints {
  OrderedConstraints(const Framework& framework, const ResolverSettings& settings)
      : slack(settings.tolerance), framework_(framework), weighting_(settings.weighting) {
    set_others();
  }

  /// What is no bar, by the joints' own numbers.
  void set_others() {
    tethers = pair_visits(framework_, slack, Side::upper, framework_.tethers());
    contacts = pair_visits(framework_, slack, Side::lower, framework_.contacts());
    volumes = volume_visits(framework_, slack);
  }

  void set_order(const Order& order, SweepOrder& sweep_order) {
    clear_order();
    bars.reserve(order.size());
    corrections.reserve(order.size());
    for (const Visit& visit : order) append(visit, sweep_order.even(visit));
  }
  void clear_order() {
    bars.clear();
    corrections.clear();
  }
  /// Numbers the joints of all constraints anew.
  template <class Numbering>
  void renumber(Numbering number) {
    for (BarVisit<T>& bar : bars) bar.near = number(bar.near), bar.far = number(bar.far);
    for (auto* const pairs : {&tethers, &contacts})
      for (PairVisit<T>& pair : *pairs) pair.p = number(pair.p), pair.q = number(pair.q);
    for (VolumeVisit<T>& volume : volumes)
      for (int& joint : volume.joint) joint = number(joint);
  }
  void append(const Visit& visit, bool even) {
    const auto [bar, correction] = bar_visit(framework_, slack, visit.bar, visit.near, visit.far,
                                             even, even ? Weighting{} : weighting_);
    bars.push_back(bar);
    corrections.push_back(correction);
  }

  Slack<T> slack;
  std::vector<BarVisit<T>> bars;
  std::vector<BarCorrection<T>> corrections;  ///< of the bars
  std::vector<PairVisit<T>> tethers, contacts;
  std::vector<VolumeVisit<T>> volumes;

 private:
  const Framework& framework_;
  Weighting weighting_;
};

}  // namespace ragdoll
