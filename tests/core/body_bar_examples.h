// Networks of bodies and bars for tests, and their rigidity by linear algebra.

#pragma once
#include <Eigen/Dense>
#include <vector>

#include "ragdoll/hinge_groups.h"  // HingeGroup
#include "ragdoll/random.h"        // Random
#include "ragdoll/rigidity.h"      // BodyBarNetwork

namespace ragdoll::examples {

/// Bodies 0, 1, ... each joined to the next by a bond of so many bars.
BodyBarNetwork chain_of(int bodies, int bars);

/// The same, and the last joined to the first.
BodyBarNetwork ring_of(int bodies, int bars);

/// Bonds of 1 to 6 bars between random bodies; some pairs have several.
BodyBarNetwork random_network(int bodies, int bonds, Random& random);

/// What the rigidity matrix of bars along random lines says, by its singular values; fit for a few
/// bodies. Leaves are not looked for.
class RigidityMatrix {
 public:
  RigidityMatrix(const BodyBarNetwork& network, Random& random);

  int degrees_of_freedom() const;
  int redundant_bars() const;

  /// Numbered as Rigidity numbers them.
  std::vector<int> cluster_of_body() const;
  std::vector<int> region_of_body() const;

  /// The hinges that turn together, each group sorted, and the groups; with their freedoms.
  std::vector<HingeGroup> hinge_groups(const std::vector<int>& hinges) const;

 private:
  BodyBarNetwork network_;
  Eigen::MatrixXd motions_;   ///< one in each column (6 nbody, nmotion)
  Eigen::MatrixXd stresses_;  ///< one in each column (nbar, nstress)
  std::vector<int> bond_of_bar_;
  std::vector<Eigen::Matrix<double, 6, 1>> locks_;  ///< a further line of each bond
};

}  // namespace ragdoll::examples
