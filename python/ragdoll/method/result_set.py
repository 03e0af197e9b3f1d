"""A set on disk: the structures, orders, force files and technique folders of ``results.xml``."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .. import _method_files
from ..errors import InputError
from .sources import refusals
from .technique import Technique

RESULTS = "results.xml"


@dataclass(frozen=True)
class SetEntry:
    """One structure of a set; paths are relative to the set's folder.

    Attributes:
        class_name: as results.xml has it.
        structure: the structure file.
        order: an order file, or None.
        forces: force files.
        techniques: folders of the techniques that ran on it, by technique.
    """

    class_name: str
    structure: Path
    order: Path | None = None
    forces: Sequence[Path] = ()
    techniques: dict[Technique, Path] = field(default_factory=dict, hash=False, compare=False)

    @property
    def folder(self) -> Path:
        """The structure's folder, relative to the set's."""
        return self.structure.parent

    @property
    def name(self) -> str:
        """The structure's name in tables: its folder without the class, ``001``."""
        parts = self.folder.parts or (self.structure.stem,)
        if len(parts) > 1 and parts[0] == self.class_name:
            parts = parts[1:]
        return "/".join(parts)

    def technique_folder(self, technique: Technique) -> Path:
        """Where a technique's iterations go."""
        return self.folder / "techniques" / technique.folder


@dataclass(frozen=True)
class ResultSet:
    """A set: its folder, its entries and the seed it was drawn with."""

    folder: Path
    entries: list[SetEntry]
    seed: int


def read_set(folder: str | Path) -> ResultSet:
    """Read a set's ``results.xml``.

    Raises:
        InputError: there is none, or it cannot be used, or it names no structure.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"There is no folder {folder}; ragdoll generate set makes one.")
    if not (folder / RESULTS).is_file():
        raise InputError(f"{folder} holds no {RESULTS}; ragdoll generate set writes one.")
    with refusals():
        found, _ = _method_files.read_results(str(folder / RESULTS))
    entries = [
        SetEntry(
            structure["class"],
            Path(structure["structure"]),
            Path(structure["order"]) if structure["order"] else None,
            [Path(path) for path in structure["forces"]],
            {_technique_of(t): Path(t["folder"]) for t in structure["techniques"]},
        )
        for structure in found["structures"]
    ]
    if not entries:
        raise InputError(f"{folder / RESULTS} names no structure.")
    return ResultSet(folder, entries, found["seed"])


def _technique_of(entry: dict[str, str]) -> Technique:
    """results.xml does not name the solver; the folder does."""
    ordered = Technique(entry["order"], entry["weighting"])
    solver = Path(entry["folder"]).name.removeprefix(ordered.folder).removeprefix("_")
    return Technique(ordered.order, ordered.weighting, solver) if solver else ordered


def write_results(folder: Path, entries: Sequence[SetEntry], seed: int) -> None:
    """Write a set's ``results.xml``, whole or not at all.

    Raises:
        OSError: the disk takes no more.
    """
    with refusals():
        _write(folder, entries, seed)


def _write(folder: Path, entries: Sequence[SetEntry], seed: int) -> None:
    _method_files.write_results(
        str(folder / RESULTS),
        {
            "seed": seed,
            "structures": [
                {
                    "class": entry.class_name,
                    "structure": entry.structure.as_posix(),
                    "order": entry.order.as_posix() if entry.order else "",
                    "forces": [path.as_posix() for path in entry.forces],
                    "techniques": [
                        {
                            "folder": path.as_posix(),
                            "order": technique.order,
                            "weighting": technique.weighting,
                        }
                        for technique, path in entry.techniques.items()
                    ],
                }
                for entry in entries
            ],
        },
        force=True,
    )
