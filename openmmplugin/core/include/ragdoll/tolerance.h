// Tolerance: how far a constraint may be violated. Relative to its length, or one length for all.

#pragma once
#include <cmath>  // cbrt

namespace ragdoll {

class Tolerance {
 public:
  /// |d - L| <= relative * L; implicit, because most tolerances are plain numbers.
  constexpr Tolerance(double relative = 1e-3) : value_(relative) {}

  /// |d - L| <= length, in nm, whatever L is.
  static constexpr Tolerance nanometers(double length) {
    Tolerance tolerance(length);
    tolerance.absolute_ = true;
    return tolerance;
  }

  constexpr double value() const { return value_; }  ///< relative, or nm
  constexpr bool absolute() const { return absolute_; }

  /// What |d - L| may be for a bar, tether or contact of this length. nm
  constexpr double slack(double length) const { return absolute_ ? value_ : value_ * length; }

  /// What a volume may be outside its bounds. An absolute tolerance holds for its length, the
  /// excess over scale^(2/3). nm^3
  double volume_slack(double scale) const {
    if (!absolute_) return value_ * scale;
    const double edge = std::cbrt(scale);
    return value_ * edge * edge;
  }

  friend bool operator==(const Tolerance&, const Tolerance&) = default;

 private:
  double value_;
  bool absolute_ = false;
};

}  // namespace ragdoll
