#include "ragdoll/quality_limits.h"

#include <algorithm>  // max, max_element
#include <cstdio>     // snprintf
#include <utility>    // move

namespace ragdoll {
namespace {

/// "words 1.23 unit, at most 1".
QualityFault fault_of(const char* measure, const char* words, double value, const char* unit,
                      double most) {
  char text[160];
  std::snprintf(text, sizeof text, "%s %.3g%s, at most %.3g", words, value, unit, most);
  return {measure, text};
}

double share(std::int64_t count, std::size_t of) {
  return of > 0 ? double(count) / double(of) : 0;
}

}  // namespace

QualityJudge::QualityJudge(std::shared_ptr<const QualityCheck> check, const QualityLimits& limits)
    : check_(std::move(check)), limits_(limits), input_(check_->measure(check_->start())) {}

QualityFault QualityJudge::fault(std::span<const Vec3> frame, const Box* box) const {
  std::vector<Vec3> rounded(frame.begin(), frame.end());
  for (Vec3& point : rounded) point = point.cast<float>().cast<double>();
  return fault(check_->measure(rounded, box));
}

QualityFault QualityJudge::fault(const FrameQuality& q) const {
  const QualityTerms& terms = check_->terms();
  if (double(q.centres_inverted) > limits_.inverted_centres)
    return fault_of("inverted_centres", "inverted centres", double(q.centres_inverted), "",
                    limits_.inverted_centres);
  const double omegas = 100 * share(q.omegas_off - input_.omegas_off, terms.omegas.size());
  if (omegas > 100 * limits_.omega_growth)
    return fault_of("omega", "peptide bonds turned by more than 30 degrees", omegas, " % more",
                    100 * limits_.omega_growth);
  const double bonds = 10 * q.bond_rms;
  if (q.bond_rms > limits_.bond_rms)
    return fault_of("bond_rms", "bonds off by an RMS of", bonds, " angstrom",
                    10 * limits_.bond_rms);
  if (q.angle_rms > limits_.angle_rms)
    return fault_of("angle_rms", "angles off by an RMS of", q.angle_rms, " degrees",
                    limits_.angle_rms);
  const double clashes =
      1000 * share(q.clashes - input_.clashes, std::size_t(check_->heavy_count()));
  if (clashes > limits_.clash_growth)
    return fault_of("clashes", "clashes", clashes, " more per 1000 atoms", limits_.clash_growth);
  const double outliers = 100 * share(q.outliers - input_.outliers, terms.backbones.size());
  if (outliers > 100 * limits_.outlier_growth)
    return fault_of("ramachandran_outliers", "Ramachandran outliers", outliers, " % more",
                    100 * limits_.outlier_growth);
  const double core = 100 * share(input_.core - q.core, terms.backbones.size());
  if (core > 100 * limits_.core_loss)
    return fault_of("ramachandran_core", "Ramachandran core", core, " % less",
                    100 * limits_.core_loss);
  for (const double excess : q.excess)
    if (excess > limits_.excess)
      return fault_of("bounds", "bounds exceeded by", 10 * excess, " angstrom",
                      10 * limits_.excess);
  return {};
}

}  // namespace ragdoll
