// StepReport: what one step of RagdollIntegrator tells about itself.

#pragma once
#include <openmm/serialization/SerializationNode.h>

#include <iosfwd>
#include <string>

namespace ragdoll {

/// Before the first step: no iterations, not converged, accepted, "no step taken".
struct StepReport {
  long long iterations = 0;                  ///< passes over the order
  long long barVisits = 0;                   ///< bars visited in these passes
  bool converged = false;                    ///< every constraint is within tolerance
  double residual = 0;                       ///< largest relative violation
  double residualLength = 0;                 ///< largest violation as a length, nm
  bool accepted = true;                      ///< false: the step was taken back
  int invertedCentres = 0;                   ///< chirality centres on the wrong side
  std::string stopReason = "no step taken";  ///< why the resolver stopped
  std::string worstConstraint = {};          ///< the most violated constraint, if not converged
  std::string solver = {};                   ///< that worked: what "auto" chose

  /// The report as properties of a node of a State's XML, and back.
  void writeTo(OpenMM::SerializationNode& node) const;
  static StepReport readFrom(const OpenMM::SerializationNode& node);

  /// The report in a binary checkpoint, and back.
  void writeTo(std::ostream& stream) const;
  static StepReport readFrom(std::istream& stream);
};

}  // namespace ragdoll
