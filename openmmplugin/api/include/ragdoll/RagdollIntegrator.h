// RagdollIntegrator: break, resolve, iterate, as an OpenMM integrator.

#pragma once
#include <openmm/Context.h>
#include <openmm/Integrator.h>
#include <openmm/Kernel.h>
#include <openmm/Vec3.h>

#include <memory>
#include <string>
#include <vector>

#include "ragdoll/StepReport.h"  // StepReport
#include "ragdoll/break.h"       // VerletScope, PerturbationKind
#include "ragdoll/framework.h"   // Framework
#include "ragdoll/resolver.h"    // ResolverSettings

namespace ragdoll {

/// Moves the joints of a framework geometrically. A step breaks the framework's constraints, by
/// forces or by a random perturbation, and resolves them again:
///
/// - **predict**: Verlet, x_new = x + v dt + F/m dt^2, under the forces of setJointForce() and, if
///   setUseSystemForces() says so, those of the System; then the perturbation;
/// - **resolve**: bars, tethers, contacts and volumes, until all are within the tolerance;
/// - **finish**: v = (x_new - x) / dt, virtual sites, time, step count.
///
/// The state is the positions and velocities of the Context, so that checkpoints, saved states,
/// setPositions() and setVelocities() act as they do with any integrator. A velocity is inferred
/// from the last displacement: it is the mean over that step, and it contains the corrections of
/// the constraints and the perturbation. It is used, reported and set as it is: the kinetic energy
/// is the sum of m v^2 / 2, and setVelocitiesToTemperature() shifts nothing. (With
/// setVerletScope("all") and the System's forces this is leapfrog Verlet, whose velocities are half
/// a step behind.)
///
/// Particles of mass 0 and joints that the framework fixes never move; virtual sites follow their
/// particles. Masses are the System's. Constraints of the System are resolved as bars; where the
/// framework has a bar on the same pair the System's distance holds. The tolerance of all
/// constraints is Integrator::setConstraintTolerance(), relative, 0.001 unless set, or
/// setAbsoluteTolerance(), one length for all.
///
/// Every parameter may be changed at any time, also while a Context exists; the next step uses it.
/// Setters throw OpenMMException on wrong values.
class RagdollIntegrator : public OpenMM::Integrator {
 public:
  /// @param size  the step size, ps; it has to be positive when a step is taken
  explicit RagdollIntegrator(double size);

  /// The framework: one joint for each particle of the System, in the same order. It may be set
  /// after the Context was created, but before the first step. Null takes it away.
  void setFramework(std::shared_ptr<const Framework> newFramework);
  const std::shared_ptr<const Framework>& getFramework() const { return framework; }

  /// Which bar is resolved when: "random", "bfs_tree", "dfs_tree", "bfs_cycle" (default),
  /// "dfs_cycle", "bfs_reverse", "dfs_reverse", "bfs_adapt", "bfs_random", "bfs_active" or
  /// "bfs_worst".
  void setOrder(const std::string& order);
  std::string getOrder() const;

  /// How a bar's error is shared, the far end's share first: ".5/.5" (default), ".75/.25", "1/0" or
  /// any "a/b" with a + b = 1.
  void setWeighting(const std::string& weighting);
  std::string getWeighting() const;

  /// The solver: a name of core's solver_names(), or "auto" (default), which chooses.
  void setSolver(const std::string& solver);
  const std::string& getSolver() const { return settings.solver; }

  /// Iterations after which a step is given up as not converged: at least 1, 10000 unless set.
  void setMaxIterations(int iterations);
  int getMaxIterations() const { return int(settings.max_iterations); }

  /// What |d - L| of any constraint may be, nm, in the place of the relative
  /// Integrator::setConstraintTolerance(). 0 unless set: the relative tolerance holds.
  void setAbsoluteTolerance(double nanometers);
  double getAbsoluteTolerance() const { return absoluteTolerance; }

  /// Of the numbers that solvers "ordered" and "newton" work with: "double" (default) or "single".
  /// Positions are doubles before and after.
  void setPrecision(const std::string& precision);
  std::string getPrecision() const;

  /// Whether solver "newton" moves heavy joints less than light ones; false unless set.
  void setUseMassWeights(bool use);
  bool getUseMassWeights() const { return settings.mass_weights; }

  /// Which joints Verlet moves: "affected" (default), those that a force acts on; or "all".
  void setVerletScope(const std::string& scope);
  std::string getVerletScope() const;

  /// Whether the System's forces act on the joints; false unless set. Only force groups of
  /// Integrator::setIntegrationForceGroups() count.
  void setUseSystemForces(bool use);
  bool getUseSystemForces() const { return useSystemForces; }

  /// Random displacements before the constraints are resolved: "none" (default), "gaussian" (each
  /// coordinate normal) or "ball" (each joint uniform in a ball).
  void setPerturbation(const std::string& kind);
  std::string getPerturbation() const;

  /// Deviation of the normal distribution or radius of the ball: 0 or more, 0.01 nm unless set.
  void setPerturbationSize(double nanometers);
  double getPerturbationSize() const { return perturbationSize; }

  /// The seed of perturbations and random orders, 0 unless set. Unlike in OpenMM's own integrators
  /// 0 is a seed as any other: the same seed, parameters and step number give the same numbers.
  void setRandomNumberSeed(int newSeed);
  int getRandomNumberSeed() const { return seed; }

  /// Whether a step that does not converge, or ends with a chirality centre inverted, is taken
  /// back: positions and velocities are then those from before the step, while time and step count
  /// advance, so that the next step draws anew. False unless set.
  void setRejectUnresolved(bool reject);
  bool getRejectUnresolved() const { return rejectUnresolved; }

  /// A force on one joint (kJ/mol/nm), for the next step only; others that are set stay. Where
  /// these are the only forces and nothing is perturbed, the joints they act on are the roots of
  /// the order.
  void setJointForce(int joint, const OpenMM::Vec3& force);
  /// The forces on all joints (njoint), for the next step only.
  void setJointForces(const std::vector<OpenMM::Vec3>& forces);
  void clearJointForces();
  /// Forces for the next step; joints beyond the end have none.
  const std::vector<OpenMM::Vec3>& getJointForces() const { return jointForces; }

  /// About the last step.
  long long getIterations() const { return report.iterations; }
  long long getBarVisits() const { return report.barVisits; }
  bool getConverged() const { return report.converged; }
  double getResidual() const { return report.residual; }
  /// Largest violation as a length, nm.
  double getResidualLength() const { return report.residualLength; }
  /// The solver that worked: what "auto" chose.
  const std::string& getChosenSolver() const { return report.solver; }
  /// False if the step was taken back; see setRejectUnresolved().
  bool getAccepted() const { return report.accepted; }
  int getInvertedCentres() const { return report.invertedCentres; }
  const std::string& getStopReason() const { return report.stopReason; }
  const std::string& getWorstConstraint() const { return report.worstConstraint; }

  /// Since the Context was created.
  long long getAttemptedSteps() const { return attemptedSteps; }
  long long getRejectedSteps() const { return rejectedSteps; }

  /// Takes steps. step(n) is exactly n times step(1).
  /// @throw OpenMMException without a Context, positions, or a framework of the System's size
  void step(int steps) override;

  /// For platforms: the parameters as core takes them; the tolerance is up to date.
  ResolverSettings getResolverSettings() const;
  VerletScope getVerletScopeKind() const { return verletScope; }
  PerturbationKind getPerturbationKind() const { return perturbation; }
  /// For platforms: joints that the next step starts from, ascending; empty where all joints move.
  std::vector<int> getRoots() const;
  /// For platforms: changes with every parameter that getFramework() or getResolverSettings()
  /// gives, save the tolerance.
  int getRevision() const { return revision; }

 protected:
  void initialize(OpenMM::ContextImpl& context) override;
  void cleanup() override;
  std::vector<std::string> getKernelNames() override;
  void stateChanged(OpenMM::State::DataType changed) override;
  double computeKineticEnergy() override;
  bool kineticEnergyRequiresForce() const override { return false; }
  void createCheckpoint(std::ostream& stream) const override;
  void loadCheckpoint(std::istream& stream) override;
  void serializeParameters(OpenMM::SerializationNode& node) const override;
  void deserializeParameters(const OpenMM::SerializationNode& node) override;

 private:
  void requireReady() const;

  std::shared_ptr<const Framework> framework;
  ResolverSettings settings;
  VerletScope verletScope = VerletScope::affected;
  PerturbationKind perturbation = PerturbationKind::none;
  double perturbationSize = 0.01;
  double absoluteTolerance = 0;
  int seed = 0;
  bool useSystemForces = false, rejectUnresolved = false;
  int revision = 0;

  std::vector<OpenMM::Vec3> jointForces;
  StepReport report;
  long long attemptedSteps = 0, rejectedSteps = 0;
  bool positionsAreSet = false;
  OpenMM::Kernel kernel;
};

}  // namespace ragdoll
