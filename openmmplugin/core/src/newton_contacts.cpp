#include "newton_contacts.h"

#include <algorithm>  // max
#include <cmath>      // sqrt

namespace ragdoll {
namespace {

/// Pairs are kept up to their bound plus this, nm.
constexpr double skin = 0.16;

}  // namespace

NewtonContacts::NewtonContacts(const ContactRule& rule) : list_(rule, skin) {}

void NewtonContacts::measure(std::span<const Vec3> positions, const Box* box) {
  active_.clear();
  energy_ = residual_ = residual_nm_ = 0;
  list_.find_near(positions, box, 0, near_);
  for (const NearPair& pair : near_) {
    Vec3 d = positions[std::size_t(pair.q)] - positions[std::size_t(pair.p)];
    if (box) d = box->minimum_image(d);
    const double square = d.squaredNorm();
    const double distance = std::sqrt(square), row = distance - pair.bound;
    active_.push_back(
        {pair.p, pair.q, distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0), row, pair.bound});
    energy_ += row * row / 2;
    residual_ = std::max(residual_, -row / pair.bound);
    residual_nm_ = std::max(residual_nm_, -row);
  }
}

}  // namespace ragdoll
