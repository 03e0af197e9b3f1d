// Geometry: how far frames are from the input, measured on the frames themselves, not on what a
// resolver reported.

#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ragdoll/box.h"        // Box
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/tolerance.h"  // Tolerance

namespace ragdoll {

/// Over all frames measured; deviations are from the input.
struct GeometryReport {
  double bond_rms = 0;                    ///< nm, over the bars of kind bond
  double bond_max = 0;                    ///< nm
  double bond_max_relative = 0;           ///< of the bond's input length
  double bar_max = 0;                     ///< nm, over all bars
  double bar_max_relative = 0;            ///< of any bar's length
  double angle_rms_degree = 0;            ///< over the angles between bonds
  double omega_max_deviation_degree = 0;  ///< over the peptide torsions
  std::int64_t contact_violations =
      0;                     ///< pairs closer than their bound by more than the tolerance
  double contact_worst = 0;  ///< nm by which the worst pair is closer than its bound
  std::int64_t tolerance_violations =
      0;  ///< bars, volumes, tethers and contacts violated by more than the tolerance
  /// By which the worst is beyond its bound, by kind, the tolerance not counted; 0: none is. nm
  std::array<double, tether_kind_count> tether_worst = {};
  std::array<double, contact_kind_count> held_contact_worst = {};
  std::int64_t chirality_inverted = 0;  ///< centres of the wrong sign
  std::int64_t planar_inverted = 0;     ///< planar units that went over from cis to trans or back
  double rmsd_last = 0, rmsd_max = 0;   ///< nm, all joints, superposed on the input
  std::int64_t frames = 0;
};

class GeometryCheck {
 public:
  /// @param start     input positions, nm (njoint)
  /// @param omegas    torsions abcd whose change is reported
  /// @param tolerance of all constraints
  GeometryCheck(std::shared_ptr<const Framework> framework, std::vector<Vec3> start,
                std::vector<std::array<int, 4>> omegas, const Tolerance& tolerance);

  /// @throw Error if the frame has another size
  void add(std::span<const Vec3> frame, const Box* box = nullptr);

  GeometryReport report() const;

 private:
  void add_bounds(std::span<const Vec3> frame);
  void add_contacts(std::span<const Vec3> frame, const Box* box);

  std::shared_ptr<const Framework> framework_;
  std::vector<Vec3> start_;
  std::vector<std::array<int, 3>> angles_;  ///< centre in the middle
  std::vector<double> start_angles_;        ///< rad
  std::vector<std::array<int, 4>> omegas_;
  std::vector<double> start_omegas_;  ///< rad
  Tolerance tolerance_;
  GeometryReport report_;
  double bond_squares_ = 0, angle_squares_ = 0;
  std::int64_t bonds_ = 0;
};

}  // namespace ragdoll
