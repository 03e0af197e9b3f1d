"""Trajectories: one HDF5 file that MDTraj loads as its own and that is H5MD 1.1 as well.

The work is done in C++ (module ``_trajectory``), which is loaded with the first trajectory and not
before: it brings its own HDF5 library.  T is the number of frames, N that of the atoms; lengths are
in nm, times in ps.
"""

# SPDX-License-Identifier: MIT
from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import InputError

if TYPE_CHECKING:
    from typing import Self

    from openmm.app import Topology

_PARAMETERS = "parameters"  # the text in the file's group /ragdoll that holds them, as JSON
_FRAMEWORK = "framework/"  # the arrays there that describe the framework
_BLOCK_BYTES = 16 << 20  # positions that iteration reads at once


class TrajectoryError(RuntimeError):
    """A trajectory could not be written or read; the message is one sentence."""


class TrajectoryUsageError(TrajectoryError, InputError):
    """The caller asked for something impossible, such as writing over an existing file."""


def _library():
    """The C++ half of this module."""
    from . import _trajectory

    return _trajectory


def check_output(path: str | os.PathLike, force: bool = False) -> None:
    """Refuse now what could not be written later, before a long simulation starts.

    Raises TrajectoryUsageError if ``path`` or segments of it exist already (unless ``force``), or
    if its folder is missing or cannot be written.
    """
    name = os.fspath(path)
    if not name.isprintable() or len(os.path.basename(name).encode(errors="replace")) > 240:
        raise TrajectoryUsageError(
            f"{ascii(name)} is no name for a trajectory; give a shorter one of printable characters"
        )
    _library().check_output(name, force)


# ------------------------------------------------------------------------------------- topologies


def mdtraj_topology_json(topology: Topology) -> str:
    """MDTraj's JSON form of an OpenMM topology: chains, residues, atoms and bonds.

    Equal to what ``mdtraj.Topology.from_openmm(topology)`` would store.  Bond orders and formal
    charges are kept where the topology has them, ids and insertion codes in keys of our own.
    """
    atoms = list(topology.atoms())
    charged = any(getattr(atom, "formalCharge", None) is not None for atom in atoms)
    bonds = list(topology.bonds())
    document: dict[str, Any] = {
        "chains": [_chain_json(chain, charged) for chain in topology.chains()],
        "bonds": [[bond[0].index, bond[1].index] for bond in bonds],
    }
    if any(bond.type is not None or bond.order is not None for bond in bonds):
        document["bond_metadata"] = [
            {"order": bond.order, "type": None if bond.type is None else str(bond.type)}
            for bond in bonds
        ]
    return json.dumps(document)


def _chain_json(chain, charged: bool) -> dict[str, Any]:
    residues = [_residue_json(residue, charged) for residue in chain.residues()]
    return {"index": chain.index, "chain_id": str(chain.id), "residues": residues}


def _residue_json(residue, charged: bool) -> dict[str, Any]:
    try:
        number = int(residue.id)
    except ValueError:  # an id such as "12A": MDTraj wants a number and takes the index
        number = residue.index
    atoms = []
    for atom in residue.atoms():
        symbol = "VS" if atom.element is None else atom.element.symbol
        atoms.append({"index": atom.index, "name": atom.name, "element": symbol})
        if charged:
            atoms[-1]["formal_charge"] = atom.formalCharge
    entry = {
        "index": residue.index,
        "name": residue.name,
        "resSeq": number,
        "segmentID": "",
        "atoms": atoms,
    }
    if residue.id != str(number):
        entry["id"] = str(residue.id)
    if residue.insertionCode.strip():
        entry["insertionCode"] = residue.insertionCode
    return entry


def joints_topology_json(ids: Sequence[str], bars: Iterable[tuple[int, int]]) -> str:
    """MDTraj's JSON form of a structure that is no molecule.

    ``ids`` are the names of the joints, ``bars`` pairs of their indices (from 0).  The joints
    become virtual sites of a single residue.
    """
    atoms = [{"index": i, "name": str(name), "element": "VS"} for i, name in enumerate(ids)]
    residue = {"index": 0, "name": "JNT", "resSeq": 1, "segmentID": "", "atoms": atoms}
    bonds = [[int(first), int(second)] for first, second in bars]
    return json.dumps({"chains": [{"index": 0, "residues": [residue]}], "bonds": bonds})


def openmm_topology(topology_json: str) -> Topology:
    """The OpenMM topology of MDTraj's JSON form, with bond orders and charges if it has them."""
    from openmm import app

    def by_index(items):
        return sorted(items, key=lambda item: item["index"])

    kinds = {"single": app.Single, "double": app.Double, "triple": app.Triple}
    kinds.update(aromatic=app.Aromatic, amide=app.Amide)
    document = json.loads(topology_json)
    topology, atoms = app.Topology(), []
    for chain_entry in by_index(document["chains"]):
        chain = topology.addChain(chain_entry.get("chain_id"))
        for entry in by_index(chain_entry["residues"]):
            identity = entry.get("id", str(entry.get("resSeq", entry["index"])))
            code = entry.get("insertionCode", "")
            residue = topology.addResidue(entry["name"], chain, identity, code)
            for atom in by_index(entry["atoms"]):
                element = _element_of(atom["element"])
                charge = atom.get("formal_charge")
                atoms.append(topology.addAtom(atom["name"], element, residue, formalCharge=charge))
    nothing = {"order": None, "type": None}
    metadata = document.get("bond_metadata") or [nothing] * len(document["bonds"])
    for (first, second), extra in zip(document["bonds"], metadata, strict=True):
        kind = kinds.get(str(extra["type"]).lower())
        order = None if extra["order"] is None else int(extra["order"])
        topology.addBond(atoms[first], atoms[second], kind, order)
    return topology


def _element_of(symbol: str):
    """OpenMM's element, or None for a virtual site."""
    from openmm.app.element import Element

    try:
        return Element.getBySymbol(symbol)
    except KeyError:
        return None


def _bonds_of(topology: Topology) -> np.ndarray:
    """Bonds as pairs of atom indices, (B, 2) int32."""
    pairs = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    return np.array(pairs, dtype=np.int32).reshape(-1, 2)


def _atomic_numbers_of(topology: Topology) -> np.ndarray:
    """Atomic numbers, (N,) int32; 0 for a virtual site."""
    elements = [atom.element for atom in topology.atoms()]
    return np.array([0 if e is None else e.atomic_number for e in elements], dtype=np.int32)


# ---------------------------------------------------------------------------------------- writing


class TrajectoryWriter:
    """Writes frames to a new trajectory; a context manager.

    While it is open, finished segments ``NAME.000.h5``, ``NAME.001.h5``, ... lie beside the file,
    each a complete trajectory, so that a killed run loses its last seconds only.  ``close()``
    merges them.
    """

    def __init__(
        self,
        path: str | os.PathLike,
        topology: Topology | str | None = None,
        *,
        atom_count: int | None = None,
        bonds: Iterable[tuple[int, int]] | None = None,
        observables: Mapping[str, type] | Iterable[str] = (),
        parameters: Mapping[str, Any] | None = None,
        attributes: Mapping[str, str | int | float] | None = None,
        texts: Mapping[str, str] | None = None,
        arrays: Mapping[str, Any] | None = None,
        framework: Mapping[str, Any] | None = None,
        periodic: bool = False,
        velocities: bool = False,
        force: bool = False,
        precision: float | None = None,
        author: str = "",
        program: str = "ragdoll",
        version: str | None = None,
        segment_seconds: float = 2.0,
    ):
        """Start a trajectory.

        topology: OpenMM topology, or MDTraj's JSON form, or None; then ``atom_count`` is needed
            and ``bonds`` (B, 2) may be given.
        observables: numbers that every frame carries: names, or names with their type (int or
            float, which is the default).
        parameters: anything JSON can hold; ``attributes``: small facts (seed, input_hash, ...);
            ``texts`` and ``arrays``: larger ones; ``framework``: arrays such as bars (B, 2).
        periodic, velocities: every frame has a box, has velocities.
        force: replace an existing trajectory.
        precision: largest error in nm that rounding may make, for smaller files; None: none.
        author, program, version: who and what writes; without a version, ours is meant.
        segment_seconds: how long the first segments last.

        Raises TrajectoryUsageError if the file cannot be written or the arguments do not fit.
        """
        library = _library()
        self.path = os.fspath(path)
        if not isinstance(observables, Mapping):
            observables = dict.fromkeys(observables, float)
        self._observables = list(observables)
        header = _header_of(
            topology,
            atom_count,
            bonds,
            observables,
            parameters or {},
            attributes or {},
            texts or {},
            arrays or {},
            framework or {},
        )
        header.periodic, header.velocities = bool(periodic), bool(velocities)
        if version is None:
            from .version import __version__ as version
        header.author, header.program, header.program_version = author, program, version
        self._writer = library.TrajectoryWriter(
            self.path, header, bool(force), float(precision or 0), float(segment_seconds)
        )

    def append(
        self,
        positions,
        time: float,
        step: int,
        observables: Mapping[str, float] | None = None,
        box=None,
        velocities=None,
    ) -> None:
        """Add a frame.

        positions: (N, 3) in nm; time in ps; observables: a number for each name; box: three
        vectors (3, 3) in nm; velocities: (N, 3) in nm/ps.  OpenMM quantities are taken as well.

        Raises TrajectoryUsageError if the frame does not fit the trajectory, TrajectoryError if
        the disk takes no more; what is written by then is kept.
        """
        given = observables or {}
        if set(given) != set(self._observables):
            raise TrajectoryUsageError(
                f"a frame for {self.path} needs the observables {self._observables}, "
                f"not {sorted(given)}"
            )
        self._writer.append(
            _numbers(positions, np.float32),
            float(time),
            int(step),
            [float(given[name]) for name in self._observables],
            None if box is None else _numbers(box, np.float64),
            None if velocities is None else _numbers(velocities, np.float32),
        )

    def close(self) -> None:
        """Complete the file; without a frame nothing is written.

        Raises TrajectoryError if there is no room for it; its message names the segments, which
        are kept.
        """
        self._writer.close()

    def abandon(self) -> None:
        """Remove all that this writer has made."""
        self._writer.abandon()

    @property
    def closed(self) -> bool:
        """Whether the trajectory takes no more frames."""
        return self._writer.closed

    def __len__(self) -> int:
        return self._writer.frame_count

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind, error, traceback) -> None:
        if error is None:
            self.close()
            return
        try:  # keep what is done; the error that ended the run is the one to report
            self.close()
        except TrajectoryError as second:
            error.add_note(str(second))


class CollectionWriter:
    """Writes one file of many trajectories, such as the conformers of many molecules.

    Each is a group ``/molecules/NAME`` that is laid out as a trajectory file is; ``/ragdoll`` tells
    of all. A context manager: the file appears when all went well, and not before.
    """

    def __init__(
        self,
        path: str | os.PathLike,
        *,
        parameters: Mapping[str, Any] | None = None,
        attributes: Mapping[str, str | int | float] | None = None,
        force: bool = False,
        expected_bytes: int = 0,
    ):
        """Start a file.

        parameters: anything JSON can hold; attributes: small facts (seed, version, ...).
        force: replace an existing file.
        expected_bytes: set aside on the disk, so that a full one is noticed now.

        Raises TrajectoryUsageError if the file cannot be written, TrajectoryError if there is no
        room.
        """
        library = _library()
        self.path = os.fspath(path)
        about = _header_of(None, 1, None, {}, parameters or {}, attributes or {}, {}, {}, {})
        self._writer = library.CollectionWriter(self.path, about, bool(force), int(expected_bytes))

    def add(
        self,
        name: str,
        positions,
        topology: Topology | str,
        *,
        observables: Mapping[str, Sequence[float]] | None = None,
        parameters: Mapping[str, Any] | None = None,
        attributes: Mapping[str, str | int | float] | None = None,
        texts: Mapping[str, str] | None = None,
    ) -> None:
        """Add a trajectory; frame k has the step k and the time k ps.

        name: of its group; no slash, unique.
        positions: (T, N, 3) in nm, or an OpenMM quantity.
        topology: OpenMM topology, or MDTraj's JSON form.
        observables: a number for each frame, by name (T,); the rest is as in TrajectoryWriter.

        Raises TrajectoryUsageError if these do not fit, TrajectoryError if the disk takes no more.
        """
        values = {key: [float(v) for v in all_] for key, all_ in (observables or {}).items()}
        header = _header_of(
            topology,
            None,
            None,
            dict.fromkeys(values, float),
            parameters or {},
            attributes or {},
            texts or {},
            {},
            {},
        )
        from .version import __version__

        header.program, header.program_version = "ragdoll", __version__
        self._writer.add(name, header, _numbers(positions, np.float32), list(values.values()))

    def close(self) -> None:
        """Complete the file.  Raises TrajectoryError if it cannot be written."""
        self._writer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind, error, traceback) -> None:
        if error is None:
            self.close()
        self._writer = None  # removes what is not complete


def _header_of(
    topology: Topology | str | None,
    atom_count: int | None,
    bonds: Iterable[tuple[int, int]] | None,
    observables: Mapping[str, type],
    parameters: Mapping[str, Any],
    attributes: Mapping[str, str | int | float],
    texts: Mapping[str, str],
    arrays: Mapping[str, Any],
    framework: Mapping[str, Any],
):
    """What a trajectory says once, for the C++ half."""
    library = _library()
    header = library.TrajectoryHeader()
    if topology is not None:
        if isinstance(topology, str):
            header.topology_json, topology = topology, openmm_topology(topology)
        else:
            header.topology_json = mdtraj_topology_json(topology)
        atom_count = topology.getNumAtoms()
        header.set_bonds(_bonds_of(topology))
        header.set_atomic_numbers(_atomic_numbers_of(topology))
    if bonds is not None:
        header.set_bonds(np.array(list(bonds), dtype=np.int32).reshape(-1, 2))
    header.atom_count = 0 if atom_count is None else int(atom_count)
    header.observables = [
        library.Observable(name, issubclass(kind, (int, np.integer)))
        for name, kind in observables.items()
    ]
    header.attributes = {name: _plain(value) for name, value in attributes.items()}
    header.texts = {_PARAMETERS: json.dumps(parameters, default=_jsonable), **texts}
    named = {_FRAMEWORK + name: values for name, values in framework.items()}
    for name, values in {**arrays, **named}.items():
        header.add_array(name, _storable(name, values))
    return header


def _plain(value):
    """A number or text as Python's own type, which the C++ half takes."""
    return value.item() if isinstance(value, np.generic) else value


def _jsonable(value):
    """What JSON does not know: numpy arrays and numbers, and anything else as text."""
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)


def _numbers(values, kind) -> np.ndarray:
    """A contiguous array of numbers or of an OpenMM quantity in its standard units."""
    if hasattr(values, "value_in_unit_system"):
        from openmm import unit

        values = values.value_in_unit_system(unit.md_unit_system)
    return np.ascontiguousarray(values, dtype=kind)


def _storable(name: str, values) -> np.ndarray:
    """An array of one of the three types that files hold: float64, int64, int32."""
    array = np.asarray(values)
    if array.dtype.kind == "f":
        kind = np.float64
    elif array.dtype.kind in "iub":
        kind = np.int32 if array.dtype.kind == "b" or array.dtype == np.int32 else np.int64
    else:
        raise TrajectoryUsageError(f"the array '{name}' holds {array.dtype}, not numbers")
    return np.array(array, dtype=kind, order="C")


# ---------------------------------------------------------------------------------------- reading


@dataclass(frozen=True)
class Frame:
    """One frame of a trajectory."""

    positions: np.ndarray  #: (N, 3) float32, nm
    time: float  #: ps
    step: int
    observables: dict[str, float | int] = field(default_factory=dict)
    box: np.ndarray | None = None  #: (3, 3) rows are the box vectors, nm
    velocities: np.ndarray | None = None  #: (N, 3) float32, nm/ps


class Trajectory:
    """A trajectory file, read frame by frame when asked; a context manager.

    ``len()`` is the number of frames T; indexing gives a Frame, iteration all of them in turn.
    Raises TrajectoryUsageError if there is no such file, TrajectoryError if it cannot be read.
    """

    def __init__(self, path: str | os.PathLike, molecule: str = ""):
        """Open a file, or the molecule of this name in a file of many; see molecule_names."""
        self.path = os.fspath(path)
        self._reader = _library().TrajectoryReader(self.path, molecule)
        self._header = self._reader.header()
        self._small: dict[str, Any] = {}  # read once: arrays with one entry a frame

    def _once(self, name: str, read):
        if name not in self._small:
            self._small[name] = read()
        return self._small[name]

    @property
    def atom_count(self) -> int:
        """Number of atoms N."""
        return self._reader.atom_count

    @property
    def frame_count(self) -> int:
        """Number of frames T."""
        return self._reader.frame_count

    @property
    def positions(self) -> np.ndarray:
        """All positions, (T, N, 3) float32 in nm; read anew each time."""
        return self._reader.positions(0, len(self))

    @property
    def velocities(self) -> np.ndarray | None:
        """All velocities, (T, N, 3) float32 in nm/ps, or None."""
        return self._reader.velocities(0, len(self)) if self._reader.has_velocities else None

    @property
    def time(self) -> np.ndarray:
        """Times, (T,) in ps."""
        return self._once("time", self._reader.times)

    @property
    def step(self) -> np.ndarray:
        """Integration steps, (T,) int64."""
        return self._once("step", self._reader.steps)

    @property
    def boxes(self) -> np.ndarray | None:
        """Box vectors, (T, 3, 3) in nm, or None if the trajectory is not periodic."""
        return self._once("boxes", self._reader.boxes) if self._reader.periodic else None

    @property
    def observables(self) -> dict[str, np.ndarray]:
        """Each observable by name, (T,) float64 or int64."""
        names = [observable.name for observable in self._header.observables]
        read = self._reader.observable
        return self._once("observables", lambda: {name: read(name) for name in names})

    @property
    def parameters(self) -> dict[str, Any]:
        """What the run was asked for."""
        return json.loads(self._header.texts.get(_PARAMETERS, "{}"))

    @property
    def attributes(self) -> dict[str, str | int | float]:
        """Small facts: seed, versions, hashes."""
        return self._header.attributes

    @property
    def texts(self) -> dict[str, str]:
        """Longer texts of the file's group /ragdoll, `parameters` among them."""
        return self._header.texts

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """All arrays of the file's group /ragdoll."""
        return self._header.arrays()

    @property
    def framework(self) -> dict[str, np.ndarray]:
        """The arrays that describe the framework, such as bars (B, 2)."""
        return {
            name.removeprefix(_FRAMEWORK): values
            for name, values in self.arrays.items()
            if name.startswith(_FRAMEWORK)
        }

    @property
    def topology_json(self) -> str:
        """MDTraj's JSON form of the topology; empty if there is none."""
        return self._header.topology_json

    @property
    def topology(self) -> Topology | None:
        """The OpenMM topology, with the box of the first frame, or None."""
        if not self.topology_json:
            return None
        topology = openmm_topology(self.topology_json)
        if self.boxes is not None and len(self):
            topology.setPeriodicBoxVectors(self.boxes[0])
        return topology

    @property
    def bonds(self) -> np.ndarray:
        """Bonds, (B, 2) int32."""
        bonds = self._header.bonds()
        if len(bonds) == 0 and self.topology_json:  # a file of MDTraj has them there only
            return _bonds_of(self.topology)
        return bonds

    def frame(self, number: int) -> Frame:
        """One frame; a negative number counts from the end.  Raises IndexError."""
        count = len(self)
        if not -count <= number < count:
            raise IndexError(f"{self.path} has {count} frames, frame {number} is not among them")
        number %= count
        positions = self._reader.positions(number, 1)[0]
        return self._frame(number, positions, self._velocities_of(number))

    def _velocities_of(self, number: int) -> np.ndarray | None:
        return self._reader.velocities(number, 1)[0] if self._reader.has_velocities else None

    def _frame(self, number: int, positions, velocities) -> Frame:
        return Frame(
            positions=positions,
            time=float(self.time[number]),
            step=int(self.step[number]),
            observables={name: all_[number].item() for name, all_ in self.observables.items()},
            box=None if self.boxes is None else self.boxes[number],
            velocities=velocities,
        )

    def __len__(self) -> int:
        return self.frame_count

    def __getitem__(self, number: int) -> Frame:
        return self.frame(number)

    def __iter__(self) -> Iterator[Frame]:
        block = max(1, _BLOCK_BYTES // (12 * self.atom_count))
        for first in range(0, len(self), block):
            positions = self._reader.positions(first, min(block, len(self) - first))
            for i, of_frame in enumerate(positions):
                yield self._frame(first + i, of_frame, self._velocities_of(first + i))

    def close(self) -> None:
        """Close the file; it cannot be read afterwards."""
        self._reader = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind, error, traceback) -> None:
        self.close()


def open_trajectory(path: str | os.PathLike, molecule: str = "") -> Trajectory:
    """Open a trajectory to read; of a file of many molecules, the one of this name.

    See Trajectory, and molecule_names.
    """
    return Trajectory(path, molecule)


def molecule_names(path: str | os.PathLike) -> list[str]:
    """Names of the molecules in a file of many, sorted; an empty list for a single trajectory.

    Raises TrajectoryUsageError if there is no such file, TrajectoryError if it cannot be read.
    """
    return _library().names_in_collection(os.fspath(path))
