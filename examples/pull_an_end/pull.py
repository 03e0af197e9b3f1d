"""Pull the last residue of villin away from the first; the chain follows and unfolds."""

from importlib.resources import files
from pathlib import Path

import matplotlib
import numpy as np
from openmm import Platform, app, unit

import ragdoll

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

STEPS = 600
FORCE = 2000.0  # kJ/mol/nm; with 12 dalton and a step of 0.01 ps this moves an atom by 0.017 nm

molecule = ragdoll.Molecule.from_file(files("openmm.app") / "data" / "test.pdb")
framework = ragdoll.build_framework(molecule)
alphas = [atom.index for atom in molecule.topology.atoms() if atom.name == "CA"]
first, last = alphas[0], alphas[-1]

integrator = ragdoll.RagdollIntegrator(
    stepSize=0.01, framework=framework, tolerance=0.01, rejectUnresolved=True
)
simulation = app.Simulation(
    molecule.topology,
    ragdoll.make_system(molecule, framework),
    integrator,
    Platform.getPlatformByName("Reference"),
)
simulation.context.setPositions(molecule.positions)

distances, iterations = [], []
for _ in range(STEPS):
    state = simulation.context.getState(positions=True)
    x = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    apart = x[last] - x[first]
    distances.append(np.linalg.norm(apart))
    # forces hold for one step; the two joints are the roots of the order
    integrator.setJointForce(last, FORCE * apart / distances[-1])
    integrator.setJointForce(first, -FORCE * apart / distances[-1])
    # without this the joints keep the speed of the step before
    simulation.context.setVelocities(np.zeros_like(x))
    simulation.step(1)
    iterations.append(integrator.getIterations())

figure, axes = plt.subplots(2, 1, sharex=True, figsize=(6, 5), dpi=120, layout="constrained")
axes[0].plot(distances)
axes[0].set_ylabel("end to end / nm")
axes[1].plot(iterations, linewidth=0.7)
axes[1].set_ylabel("iterations")
axes[1].set_xlabel("step")
figure.savefig(Path(__file__).with_name("pull.png"))
print(f"end to end: {distances[0]:.2f} nm at the start, {distances[-1]:.2f} nm after {STEPS} steps")
