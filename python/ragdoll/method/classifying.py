"""What a structure or a molecule is made of: class, bridges, cycle blocks."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from ..molecule import Molecule
from .sources import Structure, structure_of


@dataclass(frozen=True, eq=False)
class Classification:
    """Of a structure, or of a molecule's bond graph.

    Attributes:
        class_name, type, diameter: of the largest component. The diameter is counted in bars; it
            is exact on trees, else a lower bound.
        cycle_rank: bars - joints + components.
        joints, bars: how many.
        components: class, type, joints, bars, cycle_rank and diameter of each.
        bridges: (n, 2) int32 joints of the bars that lie on no cycle.
        articulation_joints: (n,) int32 joints that parts hang together at.
        blocks: joints (n,), bars (m, 2), cycle_rank and component of each cycle block.
        ids: names of the joints.
    """

    class_name: str
    type: str
    cycle_rank: int
    diameter: int
    joints: int
    bars: int
    components: list[dict[str, Any]]
    bridges: np.ndarray
    articulation_joints: np.ndarray
    blocks: list[dict[str, Any]]
    ids: list[str] = field(repr=False)

    def records(self) -> list[dict[str, Any]]:
        """A record for each cycle block: joints, bars, cycle_rank, component."""
        return [
            {
                "joints": len(block["joints"]),
                "bars": len(block["bars"]),
                "cycle_rank": block["cycle_rank"],
                "component": block["component"],
            }
            for block in self.blocks
        ]

    def as_dict(self) -> dict[str, Any]:
        """The object that ``ragdoll classify --json`` prints: joints by their ids."""
        return {
            "class": self.class_name,
            "type": self.type,
            "cycle_rank": self.cycle_rank,
            "joints": self.joints,
            "bars": self.bars,
            "diameter": self.diameter,
            "components": self.components,
            "bridges": self._pairs(self.bridges),
            "articulation_joints": [self.ids[j] for j in self.articulation_joints.tolist()],
            "blocks": [
                {
                    "joints": [self.ids[j] for j in block["joints"].tolist()],
                    "bars": self._pairs(block["bars"]),
                    "cycle_rank": block["cycle_rank"],
                    "component": block["component"],
                }
                for block in self.blocks
            ],
        }

    def _pairs(self, joints: np.ndarray) -> list[list[str]]:
        return [[self.ids[p], self.ids[q]] for p, q in joints.tolist()]


def classify(
    source: Structure | Molecule | str | Path,
    *,
    model: int = 1,
    warnings: list[str] | None = None,
) -> Classification:
    """Find the class of each component, the cycle rank, bridges and cycle blocks.

    Args:
        source: a structure, a molecule, or the file of one.
        model: model of a PDB or mmCIF file, molecule of an SDF file, from 1.
        warnings: what the reader ignored is appended here.

    Raises:
        InputError: the file cannot be used.
    """
    structure = structure_of(source, warnings, model=model)
    found = _core.classify(structure)
    ids = list(structure.ids)
    return Classification(
        class_name=found["class"],
        type=found["type"],
        cycle_rank=found["cycle_rank"],
        diameter=found["diameter"],
        joints=structure.joint_count,
        bars=structure.bar_count,
        components=[
            {("first_joint" if key == "lowest_joint" else key): value for key, value in c.items()}
            | {"first_joint": ids[c["lowest_joint"]]}
            for c in found["components"]
        ],
        bridges=found["bridges"],
        articulation_joints=found["articulation_joints"],
        blocks=list(found["blocks"]),
        ids=ids,
    )
