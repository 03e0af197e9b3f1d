// NewtonRows: the constraints of a framework as the rows of a least-squares problem. Private to the
// solver `newton`.

#pragma once
#include <cmath>  // isfinite
#include <memory>
#include <span>
#include <vector>

#include "newton_factor.h"         // BlockFactor
#include "ragdoll/contact_list.h"  // ContactList, NearPair
#include "ragdoll/framework.h"     // Framework

namespace ragdoll {

/// How far positions are from holding every constraint.
struct Misfit {
  double energy = 0;    ///< half the sum of the squared rows, nm^2
  double residual = 0;  ///< largest relative violation of any constraint
  bool finite() const { return std::isfinite(energy) && std::isfinite(residual); }
};

/// Rows are |q - p| - L of every bar; of tethers, contacts and volumes those that are violated, by
/// however little: |q - p| less the bound, and the volume less its nearer bound over scale^(2/3),
/// which makes it a length. What depends on positions depends on these alone.
class NewtonRows {
 public:
  explicit NewtonRows(std::shared_ptr<const Framework> framework);

  Misfit measure(std::span<const Vec3> x, const Box* box);

  /// J^T J and the resistance of stretched pairs to turning into the matrix, and -J^T r. Fixed
  /// joints take no part.
  void assemble(std::span<const Vec3> x, const Box* box, std::vector<Vec3>& right);

  BlockFactor& matrix() { return *matrix_; }

  /// One Gauss-Seidel sweep: bars, tethers, contacts in the order of the framework, pairs of the
  /// contact rule, volumes; each that is violated beyond the tolerance is corrected, shared evenly.
  void sweep(std::span<Vec3> x, const Box* box, double tolerance);

  /// Joints that move and belong to constraints violated beyond the tolerance, once each, sorted.
  std::vector<int> violated_joints(std::span<const Vec3> x, const Box* box, double tolerance);

 private:
  bool fixed(int joint) const { return framework_->fixed()[std::size_t(joint)] != 0; }
  void prepare_matrix();
  void find_active_pairs(std::span<const Vec3> x, const Box* box);
  void sweep_volume(const Volume& volume, std::span<Vec3> x, double tolerance) const;

  std::shared_ptr<const Framework> framework_;
  std::unique_ptr<BlockFactor> matrix_;  ///< made when first needed
  std::vector<int> places_;              ///< bars', tethers', contacts', 6 of each volume; -1: none
  ContactList contact_list_;
  std::vector<NearPair> active_;  ///< pairs of the contact rule that are violated
  std::vector<std::pair<int, int>> active_pairs_, former_pairs_;
};

}  // namespace ragdoll
