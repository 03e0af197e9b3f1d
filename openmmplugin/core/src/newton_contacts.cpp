#include "newton_contacts.h"

#include <algorithm>  // max
#include <cmath>      // abs, sqrt

namespace ragdoll {
namespace {

/// Pairs are kept up to their bound plus this, nm.
constexpr double skin = 0.12;

}  // namespace

NewtonContacts::NewtonContacts(const ContactRule& rule, std::span<const NewtonPlan::Pair> far,
                               std::span<const int> joint)
    : list_(rule, skin) {
  for (const NewtonPlan::Pair& pair : far)
    far_.push_back(
        {joint[std::size_t(pair.p)], joint[std::size_t(pair.q)], pair.side, pair.length});
}

void NewtonContacts::enter(Active pair, const Vec3& d, double square) {
  const double distance = std::sqrt(square);
  pair.row = distance - pair.bound;
  pair.u = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
  active_.push_back(pair);
  energy_ += pair.row * pair.row / 2;
  residual_ = std::max(residual_, std::abs(pair.row) / pair.bound);
  residual_nm_ = std::max(residual_nm_, std::abs(pair.row));
}

}  // namespace ragdoll
