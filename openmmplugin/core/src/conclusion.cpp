#include "conclusion.h"

#include <algorithm>  // min, max
#include <cmath>      // abs, cbrt, sqrt

namespace ragdoll {
namespace {

/// Largest violations of pairs. Most pairs are told to be no larger by their squared distance.
class Largest {
 public:
  Largest(Residual& residual, const Tolerance& tolerance)
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

}  // namespace

Residual residual_of(const Framework& framework, std::span<const Vec3> positions, const Box* box,
                     const Tolerance& tolerance, std::span<const NearPair> near) {
  Residual residual;
  Largest largest(residual, tolerance);
  const auto at = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  const auto distance2 = [&](const auto& pair) { return (at(pair.q) - at(pair.p)).squaredNorm(); };
  for (const Bar& bar : framework.bars()) largest.bar(distance2(bar), bar.length);
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

void conclude(ResolveReport& report, StopReason reason, const Framework& framework,
              std::span<const Vec3> positions, const Box* box, const Tolerance& tolerance,
              const Residual& residual) {
  report.reason = reason;
  report.converged = is_resolved(reason);
  if (report.converged) {
    report.residual = residual.relative;
    report.residual_nm = residual.nanometers;
  } else {
    const Violation worst = worst_violation(framework, positions, box, tolerance);
    report.residual = worst.relative;
    report.residual_nm = worst.nanometers;
    report.worst = worst.what;
  }
}

}  // namespace ragdoll
