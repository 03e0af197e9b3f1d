// NewtonContacts: pairs that the pattern does not know of and that are violated, of one conformer:
// those of the contact rule, and tethers and contacts far across. Private to the solver `newton`.

#pragma once
#include <span>
#include <vector>

#include "newton_plan.h"           // NewtonPlan
#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/framework.h"     // Framework

namespace ragdoll {

/// Pairs of the rule are looked up once, up to somewhat more than their bounds; these alone are
/// measured as long as the joints stay near where they were then. The result is that of measuring
/// all pairs.
class NewtonContacts {
 public:
  struct Active {
    int p = 0, q = 0;
    Vec3 u = Vec3::Zero();  ///< from p to q
    double row = 0;         ///< distance less bound
    double bound = 0;       ///< nm
    bool of_rule = true;    ///< the nearest image counts
  };

  /// So far may each joint move after the pairs were looked up. nm
  static constexpr double room = 0.02;

  /// @param far  of the plan that `joint` is of
  NewtonContacts(const ContactRule& rule, std::span<const NewtonPlan::Pair> far,
                 std::span<const int> joint);

  /// Looks pairs up where the joints are; finite positions.
  void look_up(std::span<const Vec3> positions, const Box* box) {
    list_.find_near(positions, box, 2 * room, near_);
  }

  /// Finds the pairs that are on the wrong side of their bound.
  /// @param at  position of a joint, which has moved no further than it has room to
  template <class At>
  void measure(const At& at, const Box* box) {
    active_.clear();
    energy_ = residual_ = residual_nm_ = 0;
    for (const NearPair& pair : near_) {
      Vec3 d = at(pair.q) - at(pair.p);
      if (box) d = box->minimum_image(d);
      const double square = d.squaredNorm();
      if (square < pair.bound * pair.bound)
        enter({.p = pair.p, .q = pair.q, .bound = pair.bound}, d, square);
    }
    for (const Far& pair : far_) {
      const Vec3 d = at(pair.q) - at(pair.p);
      const double square = d.squaredNorm();
      if (pair.side * (square - pair.bound * pair.bound) > 0)
        enter({.p = pair.p, .q = pair.q, .bound = pair.bound, .of_rule = false}, d, square);
    }
  }

  const std::vector<Active>& active() const { return active_; }
  double energy() const { return energy_; }
  double residual() const { return residual_; }
  double residual_nm() const { return residual_nm_; }

 private:
  /// By joints.
  struct Far {
    int p = 0, q = 0, side = 0;
    double bound = 0;
  };

  void enter(Active pair, const Vec3& d, double square);

  ContactList list_;
  std::vector<NearPair> near_;
  std::vector<Far> far_;
  std::vector<Active> active_;
  double energy_ = 0, residual_ = 0, residual_nm_ = 0;
};

}  // namespace ragdoll
