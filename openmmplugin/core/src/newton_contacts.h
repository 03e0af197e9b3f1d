// NewtonContacts: pairs of the contact rule that are violated, of one conformer. Private to the
// solver `newton`.

#pragma once
#include <algorithm>  // max
#include <cmath>      // sqrt
#include <span>
#include <vector>

#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/framework.h"     // Framework

namespace ragdoll {

/// Pairs are looked up once, up to somewhat more than their bounds; these alone are measured as
/// long as the joints stay near where they were then. The result is that of measuring all pairs.
class NewtonContacts {
 public:
  struct Active {
    int p = 0, q = 0;
    Vec3 u = Vec3::Zero();  ///< from p to q
    double row = 0;         ///< distance less bound, negative
    double bound = 0;       ///< nm
  };

  /// So far may each joint move after the pairs were looked up. nm
  static constexpr double room = 0.02;

  explicit NewtonContacts(const ContactRule& rule);

  /// Looks pairs up where the joints are; finite positions.
  void look_up(std::span<const Vec3> positions, const Box* box) {
    list_.find_near(positions, box, 2 * room, near_);
  }

  /// Finds the pairs that are closer than their bound, sorted by (p, q).
  /// @param at  position of a joint, which has moved no further than it has room to
  template <class At>
  void measure(const At& at, const Box* box) {
    active_.clear();
    energy_ = residual_ = residual_nm_ = 0;
    for (const NearPair& pair : near_) {
      Vec3 d = at(pair.q) - at(pair.p);
      if (box) d = box->minimum_image(d);
      const double square = d.squaredNorm();
      if (square < pair.bound * pair.bound) enter(pair, d, std::sqrt(square));
    }
  }

  const std::vector<Active>& active() const { return active_; }
  double energy() const { return energy_; }
  double residual() const { return residual_; }
  double residual_nm() const { return residual_nm_; }

 private:
  void enter(const NearPair& pair, const Vec3& d, double distance);

  ContactList list_;
  std::vector<NearPair> near_;
  std::vector<Active> active_;
  double energy_ = 0, residual_ = 0, residual_nm_ = 0;
};

}  // namespace ragdoll
