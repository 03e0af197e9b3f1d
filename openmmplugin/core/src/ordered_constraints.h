// Ordered constraints: all that the passes of `ordered` visit, in the order in which they do, ready
// to be tested and corrected in floats or doubles. Private to the resolvers.

#pragma once
#include <tuple>  // tie
#include <vector>

#include "ragdoll/resolver.h"  // ResolverSettings
#include "sweep_arithmetic.h"  // BarVisit, PairVisit, VolumeVisit, Slack
#include "sweep_order.h"       // SweepOrder

namespace ragdoll {

template <class T>
struct OrderedConstraints {
  OrderedConstraints(const Framework& framework, const ResolverSettings& settings)
      : slack(settings.tolerance),
        tethers(pair_visits(framework, slack, Side::upper, framework.tethers())),
        contacts(pair_visits(framework, slack, Side::lower, framework.contacts())),
        volumes(volume_visits(framework, slack)),
        framework_(framework),
        weighting_(settings.weighting) {}

  void set_order(const Order& order, SweepOrder& sweep_order) {
    bars.resize(order.size());
    corrections.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Visit& visit = order[k];
      const bool even = sweep_order.even(visit);
      std::tie(bars[k], corrections[k]) =
          bar_visit(framework_, slack, visit.bar, visit.near, visit.far, even,
                    even ? Weighting{} : weighting_);
    }
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
