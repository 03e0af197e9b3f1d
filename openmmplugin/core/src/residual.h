// Residual: how far constraints are violated, where joints are told by any means. Private to the
// resolvers.

#pragma once
#include <algorithm>  // min, max
#include <cmath>      // abs, cbrt, sqrt
#include <span>

#include "ragdoll/box.h"           // Box
#include "ragdoll/contact_list.h"  // NearPair
#include "ragdoll/framework.h"     // Framework
#include "ragdoll/tolerance.h"     // Tolerance
#include "ragdoll/vec3.h"          // signed_volume

namespace ragdoll {

/// How far the constraints are violated.
struct Residual {
  double relative = 0, nanometers = 0;
  bool within = true;  ///< every constraint is within its tolerance
};

/// Largest violations of pairs. Most pairs are told to be no larger by their squared distance.
class LargestViolation {
 public:
  LargestViolation(Residual& residual, const Tolerance& tolerance)
      : residual_(residual), tolerance_(tolerance) {}

  void bar(double distance2, double length) {
    const double room = room_of(length);
    const double lower = length - room, upper = length + room;
    if (distance2 >= lower * lower && distance2 <= upper * upper) return;
    take(std::abs(std::sqrt(distance2) - length), length);
  }
  void tether(double distance2, double length) {
    const double upper = length + room_of(length);
    if (distance2 <= upper * upper) return;
    take(std::sqrt(distance2) - length, length);
  }
  void contact(double distance2, double length) {
    const double lower = length - room_of(length);
    if (distance2 >= lower * lower) return;
    take(length - std::sqrt(distance2), length);
  }

 private:
  /// What is violated by less is no larger, however it is rounded. Below 0: nothing is.
  double room_of(double length) const {
    const double most = std::min(residual_.relative * length, residual_.nanometers);
    return most * (1 - 1e-12) - 1e-15 * length;
  }
  void take(double excess, double length) {
    residual_.relative = std::max(residual_.relative, excess / length);
    residual_.nanometers = std::max(residual_.nanometers, excess);
    if (!(excess <= tolerance_.slack(length))) residual_.within = false;
  }

  Residual& residual_;
  const Tolerance& tolerance_;
};

/// @param bars    of the framework, whatever their joints are numbered by
/// @param bar_at  where the joints of `bars` are
/// @param at      where the framework's joints are
/// @param near    the pairs of the contact rule that could be violated
template <class BarAt, class At>
Residual residual_of(const Framework& framework, std::span<const Bar> bars, BarAt bar_at, At at,
                     const Box* box, const Tolerance& tolerance, std::span<const NearPair> near) {
  Residual residual;
  LargestViolation largest(residual, tolerance);
  for (const Bar& bar : bars)
    largest.bar((bar_at(bar.q) - bar_at(bar.p)).squaredNorm(), bar.length);
  const auto distance2 = [&](const auto& pair) { return (at(pair.q) - at(pair.p)).squaredNorm(); };
  for (const Tether& tether : framework.tethers()) largest.tether(distance2(tether), tether.length);
  for (const Contact& contact : framework.contacts())
    largest.contact(distance2(contact), contact.length);
  for (const NearPair& pair : near) {
    Vec3 d = at(pair.q) - at(pair.p);
    if (box) d = box->minimum_image(d);
    largest.contact(d.squaredNorm(), pair.bound);
  }
  for (const Volume& v : framework.volumes()) {
    const double volume = signed_volume(at(v.a), at(v.b), at(v.c), at(v.d));
    const double excess = std::max(v.lower - volume, volume - v.upper);
    if (!(excess > 0)) continue;
    residual.relative = std::max(residual.relative, excess / v.scale);
    residual.nanometers = std::max(residual.nanometers, excess / v.scale * std::cbrt(v.scale));
    if (!(excess <= tolerance.volume_slack(v.scale))) residual.within = false;
  }
  return residual;
}

}  // namespace ragdoll
