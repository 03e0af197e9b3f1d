"""Conformers in HDF5: one molecule as a trajectory, many as a file with a group for each."""

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rdkit import Chem

from ..framework import build_framework, framework_arrays
from ..molecule import Molecule
from ..trajectory import CollectionWriter, TrajectoryWriter, mdtraj_topology_json
from .conforming import MadeConformers
from .records import Record

_ANGSTROM = 10.0  # per nm
_KILOJOULES = 4.184  # per kcal
_GROUP_BYTES = 20_000  # that HDF5 takes for the objects of a molecule, about
_LENGTHS = struct.Struct("<QQ")


def h5_block(record: Record, made: MadeConformers, run: dict[str, Any]) -> bytes:
    """The conformers of a molecule as bytes: what ``write_h5`` needs of them.

    Args:
        record: of the input.
        made: its conformers, at least one.
        run: plain values that become attributes.
    """
    mol, start = made.mol, made.start
    positions = np.array(
        [conformer.GetPositions() for conformer in mol.GetConformers()], dtype=np.float64
    )
    facts = {
        "title": record.title,
        "record": record.number,
        "line": record.line,
        "shape": positions.shape,
        "energies": [float(energy) * _KILOJOULES for energy in made.energies],
        "energy_by": made.energy_name,
        "topology": mdtraj_topology_json(Molecule.from_rdkit(start).topology),
        "mol_block": Chem.MolToMolBlock(start),
        "start": (np.array(start.GetConformer().GetPositions()) / _ANGSTROM).tolist(),
        "smiles": Chem.MolToSmiles(Chem.RemoveHs(start)),
        "reason": made.reason,
        "notes": made.notes,
        "run": run,
    }
    header = json.dumps(facts).encode()
    places = np.ascontiguousarray(positions / _ANGSTROM, dtype="<f4").tobytes()
    return _LENGTHS.pack(len(header), len(places)) + header + places


def split_blocks(data: bytes) -> list[bytes]:
    """The blocks that were put in a row."""
    found, begin = [], 0
    while begin < len(data):
        end = begin + _LENGTHS.size + sum(_LENGTHS.unpack_from(data, begin))
        found.append(data[begin:end])
        begin = end
    return found


def _unpacked(block: bytes) -> tuple[dict[str, Any], np.ndarray]:
    length, _ = _LENGTHS.unpack_from(block)
    begin = _LENGTHS.size
    facts = json.loads(block[begin : begin + length])
    places = np.frombuffer(block, dtype="<f4", offset=begin + length)
    return facts, places.reshape(facts["shape"])


def write_h5(
    path: Path,
    blocks: Iterator[bytes],
    count: int,
    size: int,
    parameters: dict[str, Any],
) -> None:
    """Write the file of all blocks, also over one that is there.

    Args:
        path: the file; it appears when it is complete.
        blocks: of each molecule, in order.
        count: how many there are; one makes a trajectory, more a collection.
        size: bytes of all.
        parameters: of the run.

    Raises:
        TrajectoryError: it cannot be written.
    """
    if count == 1:
        facts, positions = _unpacked(next(blocks))
        writer = TrajectoryWriter(path, force=True, **_header(facts, parameters, whole=True))
        with writer:
            for number, (places, energy) in enumerate(
                zip(positions, facts["energies"], strict=True)
            ):
                writer.append(places, float(number), number, {"energy": energy})
        return
    names = ("version", "seed", "input", "input_hash")
    with CollectionWriter(
        path,
        parameters=parameters,
        attributes={name: parameters[name] for name in names},
        force=True,
        expected_bytes=size + _GROUP_BYTES * count,
    ) as writer:
        for number, block in enumerate(blocks):
            facts, positions = _unpacked(block)
            writer.add(
                f"{number + 1:07d}",
                positions,
                observables={"energy": facts["energies"]},
                **_header(facts, {}, whole=False),
            )


def _header(facts: dict[str, Any], parameters: dict[str, Any], whole: bool) -> dict[str, Any]:
    """What a trajectory says of a molecule; with its framework where it is alone in its file."""
    header: dict[str, Any] = {
        "topology": facts["topology"],
        "parameters": parameters,
        "attributes": {
            **facts["run"],
            "title": facts["title"],
            "record": facts["record"],
            "smiles": facts["smiles"],
            "energy_by": facts["energy_by"],
            "reason": facts["reason"],
            "notes": "; ".join(facts["notes"]),
        },
        "texts": {"mol_block": facts["mol_block"]},
    }
    if whole:
        header["observables"] = {"energy": float}
        mol = Chem.MolFromMolBlock(facts["mol_block"], removeHs=False, sanitize=False)
        Chem.SanitizeMol(mol)
        mol.GetConformer().SetPositions(np.array(facts["start"]) * _ANGSTROM)
        molecule = Molecule.from_rdkit(mol)
        header["arrays"] = {"input_positions": molecule.positions}
        header["framework"] = framework_arrays(build_framework(molecule))
    return header
