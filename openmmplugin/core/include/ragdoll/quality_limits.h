// QualityLimits: below which quality a frame is not kept.

#pragma once
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "ragdoll/quality.h"  // QualityCheck, FrameQuality

namespace ragdoll {

/// The most of each; infinity: not limited. What is called growth is over the input's own figure.
struct QualityLimits {
  static constexpr double none = std::numeric_limits<double>::infinity();
  double bond_rms = none;          ///< from the input, nm
  double angle_rms = none;         ///< from the input, degree
  double clash_growth = none;      ///< clashes per 1000 heavy atoms
  double outlier_growth = none;    ///< share of residues that are Ramachandran outliers
  double omega_growth = none;      ///< share of peptide bonds off by more than 30 degrees
  double inverted_centres = none;  ///< how many
  double core_loss = none;         ///< share of residues that left the core of the Ramachandran map
  double excess = none;            ///< over any bound, nm
};

/// Why a frame is below the limits.
struct QualityFault {
  std::string measure;  ///< "clashes", ...; empty: it is not below
  std::string words;    ///< the measure's value and the limit

  explicit operator bool() const { return !measure.empty(); }
};

/// Judges frames by limits.
class QualityJudge {
 public:
  QualityJudge(std::shared_ptr<const QualityCheck> check, const QualityLimits& limits);

  /// Positions are first rounded to single precision, as files have them.
  QualityFault fault(std::span<const Vec3> frame, const Box* box = nullptr) const;
  QualityFault fault(const FrameQuality& quality) const;

 private:
  std::shared_ptr<const QualityCheck> check_;
  QualityLimits limits_;
  FrameQuality input_;
};

}  // namespace ragdoll
