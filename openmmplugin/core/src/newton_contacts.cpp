#include "newton_contacts.h"

namespace ragdoll {
namespace {

/// Pairs are kept up to their bound plus this, nm.
constexpr double skin = 0.12;

}  // namespace

NewtonContacts::NewtonContacts(const ContactRule& rule) : list_(rule, skin) {}

void NewtonContacts::enter(const NearPair& pair, const Vec3& d, double distance) {
  const double row = distance - pair.bound;
  const Vec3 u = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
  active_.push_back({pair.p, pair.q, u, row, pair.bound});
  energy_ += row * row / 2;
  residual_ = std::max(residual_, -row / pair.bound);
  residual_nm_ = std::max(residual_nm_, -row);
}

}  // namespace ragdoll
