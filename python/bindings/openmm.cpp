// _openmm: RagdollIntegrator and FrameworkForce behind the `this` pointers of OpenMM's own Python
// objects. What XML should not carry (frameworks, joint forces) goes through here, and all setters.

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <vector>

#include "arrays.h"                     // InPoints, out_points
#include "ragdoll/FrameworkForce.h"     // FrameworkForce
#include "ragdoll/RagdollIntegrator.h"  // RagdollIntegrator

namespace nb = nanobind;
using namespace nb::literals;
using ragdoll::FrameworkForce;
using ragdoll::RagdollIntegrator;
using ragdoll::bindings::InPoints;
using ragdoll::bindings::out_points;

namespace {

// The object behind int(this) of an OpenMM object that Python holds.
template <class Object, class Base>
Object& object_at(std::uintptr_t address) {
  auto* object = dynamic_cast<Object*>(reinterpret_cast<Base*>(address));
  if (object == nullptr) throw nb::type_error("This OpenMM object was not made by ragdoll.");
  return *object;
}

void set_joint_forces(RagdollIntegrator& integrator, const InPoints& rows) {
  std::vector<OpenMM::Vec3> forces(rows.shape(0));
  for (std::size_t joint = 0; joint < forces.size(); ++joint)
    forces[joint] = {rows(joint, 0), rows(joint, 1), rows(joint, 2)};
  integrator.setJointForces(forces);
}

// As many rows as the framework has joints, or as forces were set.
nb::object joint_forces(const RagdollIntegrator& integrator) {
  std::vector<ragdoll::Vec3> rows;
  for (const OpenMM::Vec3& force : integrator.getJointForces())
    rows.emplace_back(force[0], force[1], force[2]);
  const auto& framework = integrator.getFramework();
  if (framework && rows.size() < std::size_t(framework->joint_count()))
    rows.resize(std::size_t(framework->joint_count()), ragdoll::Vec3::Zero());
  return out_points(rows);
}

void translate(const std::exception_ptr& error, void* openmm_exception) {
  try {
    std::rethrow_exception(error);
  } catch (const OpenMM::OpenMMException& exception) {
    PyErr_SetString(static_cast<PyObject*>(openmm_exception), exception.what());
  }
}

void bind_integrator(nb::module_& m) {
  using R = RagdollIntegrator;
  nb::class_<R>(m, "RagdollIntegrator",
                "A view of the C++ object; ragdoll.RagdollIntegrator owns it.")
      .def("setFramework", &R::setFramework, "framework"_a.none())
      .def("getFramework", [](const R& r) { return r.getFramework(); })
      .def("setOrder", &R::setOrder)
      .def("getOrder", &R::getOrder)
      .def("setWeighting", &R::setWeighting)
      .def("getWeighting", &R::getWeighting)
      .def("setSolver", &R::setSolver)
      .def("getSolver", &R::getSolver)
      .def("setMaxIterations", &R::setMaxIterations)
      .def("getMaxIterations", &R::getMaxIterations)
      .def("setAbsoluteTolerance", &R::setAbsoluteTolerance)
      .def("getAbsoluteTolerance", &R::getAbsoluteTolerance)
      .def("setPrecision", &R::setPrecision)
      .def("getPrecision", &R::getPrecision)
      .def("setUseMassWeights", &R::setUseMassWeights)
      .def("getUseMassWeights", &R::getUseMassWeights)
      .def("setVerletScope", &R::setVerletScope)
      .def("getVerletScope", &R::getVerletScope)
      .def("setUseSystemForces", &R::setUseSystemForces)
      .def("getUseSystemForces", &R::getUseSystemForces)
      .def("setPerturbation", &R::setPerturbation)
      .def("getPerturbation", &R::getPerturbation)
      .def("setPerturbationSize", &R::setPerturbationSize)
      .def("getPerturbationSize", &R::getPerturbationSize)
      .def("setRandomNumberSeed", &R::setRandomNumberSeed)
      .def("getRandomNumberSeed", &R::getRandomNumberSeed)
      .def("setRejectUnresolved", &R::setRejectUnresolved)
      .def("getRejectUnresolved", &R::getRejectUnresolved)
      .def("setJointForce",
           [](R& r, int joint, double x, double y, double z) {
             r.setJointForce(joint, {x, y, z});
           })
      .def("setJointForces", &set_joint_forces)
      .def("getJointForces", &joint_forces)
      .def("clearJointForces", &R::clearJointForces)
      .def("getIterations", &R::getIterations)
      .def("getBarVisits", &R::getBarVisits)
      .def("getConverged", &R::getConverged)
      .def("getResidual", &R::getResidual)
      .def("getResidualLength", &R::getResidualLength)
      .def("getChosenSolver", &R::getChosenSolver)
      .def("getAccepted", &R::getAccepted)
      .def("getInvertedCentres", &R::getInvertedCentres)
      .def("getStopReason", &R::getStopReason)
      .def("getWorstConstraint", &R::getWorstConstraint)
      .def("getAttemptedSteps", &R::getAttemptedSteps)
      .def("getRejectedSteps", &R::getRejectedSteps);
}

void bind_force(nb::module_& m) {
  using F = FrameworkForce;
  nb::class_<F>(m, "FrameworkForce", "A view of the C++ object; ragdoll.FrameworkForce owns it.")
      .def("setFramework", &F::setFramework, "framework"_a.none())
      .def("getFramework", [](const F& f) { return f.getFramework(); })
      .def("setUsesPeriodicBoundaryConditions", &F::setUsesPeriodicBoundaryConditions);
}

}  // namespace

NB_MODULE(_openmm, m) {
  // libOpenMM.so is found by name among what `import openmm` loaded; Framework is bound by _core
  static nb::object openmm_exception = nb::module_::import_("openmm").attr("OpenMMException");
  nb::module_::import_("ragdoll._core");
  nb::register_exception_translator(&translate, openmm_exception.ptr());

  bind_integrator(m);
  bind_force(m);
  m.def(
      "integrator_at",
      [](std::uintptr_t address) -> RagdollIntegrator& {
        return object_at<RagdollIntegrator, OpenMM::Integrator>(address);
      },
      nb::rv_policy::reference, "address"_a, "The integrator behind int(integrator.this).");
  m.def(
      "force_at",
      [](std::uintptr_t address) -> FrameworkForce& {
        return object_at<FrameworkForce, OpenMM::Force>(address);
      },
      nb::rv_policy::reference, "address"_a, "The force behind int(force.this).");
}
