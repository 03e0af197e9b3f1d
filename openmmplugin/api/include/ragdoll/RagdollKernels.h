// RagdollKernels: what a platform has to implement so that RagdollIntegrator runs on it.

#pragma once
#include <openmm/KernelImpl.h>
#include <openmm/System.h>
#include <openmm/internal/ContextImpl.h>

#include <string>

#include "ragdoll/RagdollIntegrator.h"  // RagdollIntegrator
#include "ragdoll/StepReport.h"         // StepReport

namespace ragdoll {

/// One step of RagdollIntegrator: predict, resolve, finish.
class IntegrateRagdollStepKernel : public OpenMM::KernelImpl {
 public:
  static std::string Name() { return "IntegrateRagdollStep"; }

  using OpenMM::KernelImpl::KernelImpl;

  /// Called once per Context. The integrator may not have a framework yet.
  virtual void initialize(const OpenMM::System& system, const RagdollIntegrator& integrator) = 0;

  /// Takes one step: moves positions and velocities of the Context, its time and its step count.
  /// The integrator has a framework of the System's size, positions are set and, where the
  /// integrator uses them, the System's forces are up to date. A kernel keeps what it derives from
  /// the integrator's parameters for as long as getRevision() and getConstraintTolerance() stay.
  /// @throw OpenMMException, and no other
  virtual StepReport execute(OpenMM::ContextImpl& context, const RagdollIntegrator& integrator) = 0;

  /// Sum of m v^2 / 2 over the velocities as they are, kJ/mol.
  virtual double computeKineticEnergy(OpenMM::ContextImpl& context) = 0;
};

}  // namespace ragdoll
