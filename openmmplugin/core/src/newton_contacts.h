// NewtonContacts: pairs of the contact rule that are violated, of one conformer. Private to the
// solver `newton`.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/framework.h"     // Framework

namespace ragdoll {

class NewtonContacts {
 public:
  struct Active {
    int p = 0, q = 0;
    Vec3 u = Vec3::Zero();  ///< from p to q
    double row = 0;         ///< distance less bound, negative
    double bound = 0;       ///< nm
  };

  explicit NewtonContacts(const ContactRule& rule);

  /// Finds the pairs that are closer than their bound, sorted by (p, q).
  void measure(std::span<const Vec3> positions, const Box* box);

  const std::vector<Active>& active() const { return active_; }
  double energy() const { return energy_; }
  double residual() const { return residual_; }
  double residual_nm() const { return residual_nm_; }

 private:
  ContactList list_;
  std::vector<NearPair> near_;
  std::vector<Active> active_;
  double energy_ = 0, residual_ = 0, residual_nm_ = 0;
};

}  // namespace ragdoll
