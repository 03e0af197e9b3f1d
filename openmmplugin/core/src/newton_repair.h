// NewtonRepair: frees groups of joints that are caught in a trap, such as their mirror image, where
// the steps of `newton` lead nowhere. Private to the solver `newton`.

#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ragdoll/resolver.h"  // ResolverSettings

namespace ragdoll {

/// Violated constraints that touch each other are a cluster. The joints within a few bars of its
/// worst ones are taken out as a framework of their own, everything around held fixed; that is
/// shaken (by fixed random numbers) and resolved, a few times. So the cost is of the traps, not of
/// the structure they are in.
class NewtonRepair {
 public:
  NewtonRepair(std::shared_ptr<const Framework> framework, const ResolverSettings& settings);

  struct Result {
    int repaired = 0;             ///< clusters that are resolved, or notably better
    std::int64_t iterations = 0;  ///< the most that any of them took, its longest try
    std::int64_t bar_visits = 0;  ///< of all of them, in all tries
  };

  /// @param round  counts the calls for one break; each has its own random numbers
  Result repair(std::span<Vec3> positions, const Box* box, int round, std::int64_t max_iterations);

 private:
  struct Broken {
    std::vector<int> joints;
    double violation = 0;  ///< over the slack
    double length = 0;     ///< nm
  };
  struct Tally {
    bool better = false;
    std::int64_t iterations = 0;  ///< of the longest try; of the one that resolved it, if any
    std::int64_t bar_visits = 0;
  };

  std::vector<Broken> find_broken(std::span<const Vec3> positions, const Box* box);
  std::vector<std::vector<Broken>> cluster(std::vector<Broken> broken) const;
  Tally repair_cluster(const std::vector<Broken>& cluster, std::span<Vec3> positions,
                       const Box* box, int round, std::int64_t max_iterations);
  std::vector<int> ball(const std::vector<int>& centre, int bars);
  std::shared_ptr<const Framework> cut_out(const std::vector<int>& free,
                                           std::span<const Vec3> positions, const Box* box,
                                           std::vector<int>& joints);
  void index_constraints();
  void find_near_pairs(std::span<const Vec3> positions, const Box* box, double reach);

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  struct NearContact {
    int p, q;
    double bound;
  };
  std::vector<NearContact> near_;
  std::vector<std::vector<int>> near_of_;  ///< of each joint, where there is a rule
  std::vector<std::int64_t> use_begin_;    ///< constraints of each joint (njoint + 1)
  std::vector<std::int64_t> uses_;         ///< numbered through all kinds
  std::vector<int> local_;                 ///< -1 between calls (njoint)
};

}  // namespace ragdoll
