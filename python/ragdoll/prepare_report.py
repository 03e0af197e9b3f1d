"""What ``prepare`` is asked for, what it found and what it did."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from .errors import InputError
from .missing_residues import MissingResidues
from .molecule import Molecule

_HETEROGENS = ("keep", "ligands", "drop")


@dataclass(frozen=True)
class PrepareOptions:
    """How to prepare a structure.

    Attributes:
        heterogens: "keep" all but water, "ligands" without single ions, or "drop" all of them.
        keep_water: keep waters.
        replace_nonstandard: replace residues such as MSE by the standard one.
        longest_loop: missing residues in a row that are built at most; 0: none.
        build_ends: build missing residues at the ends of chains too.
        add_hydrogens: add the hydrogens that residues lack.
        ph: decides which hydrogens those are.
        model, altloc, chains: what of the file is read, as in Molecule.from_file.
        ligands, ligand_smiles, covalent_bonds: as in Molecule.from_file, with pairs for a mapping.
    """

    heterogens: str = "keep"
    keep_water: bool = False
    replace_nonstandard: bool = True
    longest_loop: int = 12
    build_ends: bool = False
    add_hydrogens: bool = True
    ph: float = 7.0
    model: int = 1
    altloc: str | None = None
    chains: tuple[str, ...] | None = None
    ligands: tuple[str, ...] = ()
    ligand_smiles: tuple[tuple[str, str], ...] = ()
    covalent_bonds: tuple[str, ...] = ()

    def check(self) -> None:
        """Raise InputError at the first option that makes no sense."""
        if self.heterogens not in _HETEROGENS:
            raise InputError(
                f"--heterogens must be one of {', '.join(_HETEROGENS)}, not '{self.heterogens}'."
            )
        if not (math.isfinite(self.ph) and 0 <= self.ph <= 14):
            raise InputError(f"--ph must be from 0 to 14, not {self.ph}.")
        if self.longest_loop < 0:
            raise InputError(f"--longest-loop must be 0 or more, not {self.longest_loop}.")


@dataclass
class PrepareReport:
    """What was found, what was done, and what is left.

    Attributes:
        source: path of the file.
        source_hash: SHA-256 of its bytes.
        models: how many the file has.
        alternates: residues with alternate locations.
        missing_atoms: names of missing heavy atoms by residue.
        missing_residues: residues of the sequence without coordinates.
        nonstandard: the standard residue for each that is not, by residue; "" where none is known.
        heterogens: how many of each ligand and ion.
        waters: how many.
        hydrogens: how many there are.
        unknown_atoms: atoms of unknown element.
        done: sentences on what was done; of a dry run, on what would be.
        left: sentences on what could not be mended.
        notes: sentences of the reader.
        dry_run: whether nothing was done.
        molecule: the prepared molecule; None of a dry run.
        added: labels of the residues that were built.
        quality: of the prepared molecule; see QualityReport.input.
        parameters: the options.
    """

    source: str
    source_hash: str = ""
    models: int = 1
    alternates: list[str] = field(default_factory=list)
    missing_atoms: dict[str, list[str]] = field(default_factory=dict)
    missing_residues: list[MissingResidues] = field(default_factory=list)
    nonstandard: dict[str, str] = field(default_factory=dict)
    heterogens: dict[str, int] = field(default_factory=dict)
    waters: int = 0
    hydrogens: int = 0
    unknown_atoms: int = 0
    done: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    dry_run: bool = False
    molecule: Molecule | None = None
    added: list[str] = field(default_factory=list)
    quality: dict[str, Any] = field(default_factory=dict)
    parameters: PrepareOptions = field(default_factory=PrepareOptions)

    def found(self) -> list[str]:
        """Sentences on what stands in the way."""
        sentences = []
        if self.models > 1:
            sentences.append(
                f"The file has {self.models} models; model {self.parameters.model} is taken."
            )
        if self.alternates:
            sentences.append(
                f"Alternate locations: {len(self.alternates)} residue(s), {_some(self.alternates)}."
            )
        if self.missing_residues:
            parts = [f"{_place(gap)} ({len(gap.names)})" for gap in self.missing_residues]
            sentences.append(
                f"Missing residues: {sum(len(g.names) for g in self.missing_residues)}, "
                f"{_some(parts)}."
            )
        if self.missing_atoms:
            count = sum(len(names) for names in self.missing_atoms.values())
            sentences.append(f"Missing heavy atoms: {count}, in {_some(list(self.missing_atoms))}.")
        if self.nonstandard:
            parts = [
                f"{name} ({std or 'no standard one'})" for name, std in self.nonstandard.items()
            ]
            sentences.append(f"Non-standard residues: {_some(parts)}.")
        if self.heterogens:
            parts = [f"{count} {name}" for name, count in self.heterogens.items()]
            sentences.append(f"Ligands and ions: {', '.join(parts)}.")
        if self.waters:
            sentences.append(f"Waters: {self.waters}.")
        if self.unknown_atoms:
            sentences.append(f"Atoms of unknown element: {self.unknown_atoms}.")
        if not self.hydrogens:
            sentences.append("There are no hydrogens.")
        return sentences or ["Nothing stands in the way."]

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain values."""
        gaps = [
            {
                "chain": gap.chain,
                "names": list(gap.names),
                "before": None if gap.before is None else gap.before[1],
                "after": None if gap.after is None else gap.after[1],
            }
            for gap in self.missing_residues
        ]
        return {
            "source": self.source,
            "source_hash": self.source_hash,
            "found": {
                "models": self.models,
                "alternate_locations": self.alternates,
                "missing_residues": gaps,
                "missing_atoms": self.missing_atoms,
                "nonstandard": self.nonstandard,
                "heterogens": self.heterogens,
                "waters": self.waters,
                "hydrogens": self.hydrogens,
                "unknown_atoms": self.unknown_atoms,
            },
            "done": self.done,
            "left": self.left,
            "built_residues": self.added,
            "atoms": None if self.molecule is None else len(self.molecule),
            "quality": self.quality,
            "dry_run": self.dry_run,
            "parameters": asdict(self.parameters),
            "notes": self.notes,
        }


def _place(gap: MissingResidues) -> str:
    if gap.before is None:
        return f"before {gap.after[1]} {gap.chain}" if gap.after else f"chain {gap.chain}"
    if gap.after is None:
        return f"after {gap.before[1]} {gap.chain}"
    return f"{gap.before[1]} to {gap.after[1]} {gap.chain}"


def _some(names: list[str], most: int = 6) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
