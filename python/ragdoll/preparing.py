"""Preparing structures: what stands in the way is found, and mended where that can be."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue

from .complexes import AtomTable, join_ligands
from .errors import InputError
from .ligands import Ligands
from .missing_residues import MissingResidues, find_missing_residues
from .molecule import Molecule
from .neighbors import close_pairs
from .prepare_report import PrepareOptions, PrepareReport
from .quality_report import quality
from .residue_match import TemplateMatch, match_residue, residue_label
from .residues import WATERS
from .selection import is_solvent
from .structure_repair import Repaired, repair, standard_name
from .structure_text import read_structure_text
from .structure_writer import structure_text
from .version import __version__
from .whole_file import whole_file

_TRIES = 2  # to build loops without clashes
_CLOSED = 0.17  # nm between C and N of a peptide bond at most


def prepare(
    source: str | Path,
    output: str | Path | None = None,
    options: PrepareOptions | None = None,
    *,
    dry_run: bool = False,
    force: bool = False,
) -> PrepareReport:
    """Find what stands in the way of a structure, and mend it.

    One model and one alternate location of each residue are taken; waters go; non-standard residues
    become standard ones; missing loops and heavy atoms are built by PDBFixer, hydrogens placed.
    Atoms that are there stay where they are.

    Args:
        source: PDB or mmCIF file, also gzipped.
        output: where to write the result, .pdb or .cif; by default nowhere.
        options: how.
        dry_run: only report.
        force: replace an existing output.

    Returns:
        What was found, done and left, and the prepared molecule.

    Raises:
        InputError: the file, an option or the output cannot be used.
    """
    options = options or PrepareOptions()
    options.check()
    if output is not None:
        check_structure_output(output, source, force)
    work = _Preparation(source, options)
    if not dry_run:
        work.mend()
        if output is not None:
            _write(work.report, Path(output))
    work.report.dry_run = dry_run
    return work.report


def check_structure_output(output: str | Path, source: str | Path, force: bool) -> None:
    """Raise InputError if a structure cannot be written there."""
    path = Path(output)
    if path.suffix.lower() not in (".pdb", ".cif", ".mmcif"):
        raise InputError(f"{path} is no structure; give a name that ends in .pdb or .cif.")
    if path.exists() and os.path.exists(source) and os.path.samefile(source, path):
        raise InputError(f"{path} is the input; give another name for the output.")
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the name of a file in it.")
    if os.path.lexists(path) and not force:
        raise InputError(f"{path} exists already; give --force to replace it.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"The folder {path.absolute().parent} does not exist; make it first.")


def _write(report: PrepareReport, path: Path) -> None:
    remarks = [f"Prepared by ragdoll {__version__} from {report.source}.", *report.done]
    text = structure_text(report.molecule, path, remarks)
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


class _Preparation:
    """One structure on its way."""

    def __init__(self, source: str | Path, options: PrepareOptions):
        self.options = options
        self.ligands = Ligands.read(
            options.ligands, dict(options.ligand_smiles), options.covalent_bonds
        )
        reading = {"model": options.model, "altloc": options.altloc, "chains": options.chains}
        self.molecule = Molecule.from_file(source, **reading, keep_solvent=True)
        self.residues: list[Residue] = list(self.molecule.topology.residues())
        self.matches: list[TemplateMatch | None] = [match_residue(r) for r in self.residues]
        self.residue_of = [atom.residue.index for atom in self.molecule.topology.atoms()]
        self._bonded: dict[int, set[int]] = {}  # residues by the atom that is bonded to them
        for i, j in self.molecule.bonds.tolist():
            if self.residue_of[i] != self.residue_of[j]:
                self._bonded.setdefault(i, set()).add(self.residue_of[j])
                self._bonded.setdefault(j, set()).add(self.residue_of[i])
        structure = read_structure_text(source).structure
        missing, notes = find_missing_residues(structure, options.model)
        if options.chains is not None:
            missing = [gap for gap in missing if gap.chain in options.chains]
        self.report = PrepareReport(
            source=str(source),
            source_hash=self.molecule.source_hash,
            models=len(structure),
            missing_residues=missing,
            parameters=options,
            notes=notes,
        )
        self._look(structure[options.model - 1])
        self.replacements = self._replacements()
        self.loops = self._loops()
        self.keep = self._kept_atoms()

    def _look(self, model) -> None:
        """Fill in what is found in the file."""
        report, options = self.report, self.options
        alternates: dict[str, None] = {}
        for chain in model:
            if options.chains is not None and chain.name not in options.chains:
                continue
            for residue in chain:
                name = f"{residue.name}{residue.seqid} {chain.name}".rstrip()
                if any(atom.has_altloc() for atom in residue):
                    alternates[name] = None
                report.unknown_atoms += sum(a.element.atomic_number == 0 for a in residue)
        report.alternates = list(alternates)
        report.missing_atoms = {m.residue: list(m.names) for m in self.molecule.missing_atoms}
        report.hydrogens = int((self.molecule.elements == 1).sum())
        counts: Counter[str] = Counter()
        for residue in self.residues:
            if residue.name in WATERS:
                report.waters += 1
            elif self._is_heterogen(residue):
                counts[residue.name] += 1
            elif self.matches[residue.index] is None or residue.name in ("MSE", "SEC", "CSE"):
                name = standard_name(residue, self.matches[residue.index])
                report.nonstandard[residue_label(residue)] = name or ""
        report.heterogens = dict(counts)

    def _is_heterogen(self, residue: Residue) -> bool:
        """Whether a residue is no part of a chain: a ligand, an ion, a free amino acid."""
        if is_solvent(residue):
            return True
        match = self.matches[residue.index]
        if match is None:  # part of a chain where it has a backbone and a standard neighbour
            atoms = {atom.name: atom.index for atom in residue.atoms()}
            beside = (self.matches[n] for n in self._neighbours(set(atoms.values())))
            in_chain = any(m is not None and _is_polymer(m) for m in beside)
            return not (in_chain and ({"N", "CA", "C"} <= atoms.keys() or "P" in atoms))
        if not _is_polymer(match):
            return False  # ACE, NME
        return len(list(residue.chain.residues())) > 1 and self._is_free(residue)

    def _is_free(self, residue: Residue) -> bool:
        """Whether a standard residue has no bond to any other and is beside ligands."""
        own = {atom.index for atom in residue.atoms()}
        if self._neighbours(own):
            return False
        others = [r for r in residue.chain.residues() if r is not residue]
        return all(self.matches[r.index] is None or r.name == residue.name for r in others)

    def _neighbours(self, own: set[int]) -> set[int]:
        """Indices of the residues bonded to these atoms."""
        return set().union(*(self._bonded.get(atom, set()) for atom in own))

    def _replacements(self) -> dict[int, str]:
        if not self.options.replace_nonstandard:
            return {}
        names = self.report.nonstandard
        return {
            residue.index: names[residue_label(residue)]
            for residue in self.residues
            if names.get(residue_label(residue))
        }

    def _loops(self) -> list[MissingResidues]:
        """What of the missing residues is to be built; the rest is told."""
        from pdbfixer.pdbfixer import dnaResidues, proteinResidues, rnaResidues, substitutions

        known = {*proteinResidues, *dnaResidues, *rnaResidues}
        loops = []
        for gap in self.report.missing_residues:
            count, where = len(gap.names), _where(gap)
            strange = [n for n in gap.names if substitutions.get(n, n) not in known]
            if gap.is_end and not self.options.build_ends:
                self.report.notes.append(
                    f"{count} residue(s) {where} are an end of the chain and stay away "
                    "(--build-ends builds them)."
                )
            elif strange:
                self.report.left.append(
                    f"{count} residue(s) {where} cannot be built: {strange[0]} is not known."
                )
            elif count > self.options.longest_loop:
                self.report.left.append(
                    f"{count} residues {where} are more than --longest-loop "
                    f"{self.options.longest_loop} and stay away."
                )
            else:
                loops.append(gap)
        return loops

    def _kept_atoms(self) -> NDArray[np.bool_]:
        keep = np.ones(len(self.molecule), dtype=bool)
        for residue in self.residues:
            if residue.name in WATERS:
                stays = self.options.keep_water
            elif self._is_heterogen(residue):
                single = len(list(residue.atoms())) == 1
                stays = self.options.heterogens == "keep" or (
                    self.options.heterogens == "ligands" and not single
                )
            else:
                stays = True
            if not stays:
                keep[[atom.index for atom in residue.atoms()]] = False
        if not keep.any():
            raise InputError(
                f"{self.report.source} holds nothing but what is dropped; keep waters by "
                "--keep-water or ligands by --heterogens keep."
            )
        return keep

    # ------------------------------------------------------------------------------------ mending

    def mend(self) -> None:
        """Make the prepared molecule."""
        report = self.report
        best: tuple[float, Repaired] | None = None
        for seed in range(1, _TRIES + 1):
            repaired = repair(self.molecule, self.keep, self.replacements, self.loops, seed)
            fault = _faults(repaired) if repaired.built else 0.0
            if best is None or fault < best[0]:
                best = (fault, repaired)
            if fault == 0:
                break
        repaired = best[1]
        report.molecule = self._molecule(repaired)
        self._tell(repaired)
        report.quality = quality(report.molecule).input

    def _molecule(self, repaired: Repaired) -> Molecule:
        """The repaired atoms with bonds, charges and hydrogens."""
        old = self.molecule
        is_old = repaired.origin >= 0
        new_of = {int(o): new for new, o in enumerate(repaired.origin) if o >= 0}
        recorded = [
            (new_of[i], new_of[j])
            for i, j in old.bonds.tolist()
            if i in new_of and j in new_of and not self._is_standard_bond(i, j)
        ]
        factors = None
        if old.b_factors is not None:
            factors = np.where(is_old, old.b_factors[repaired.origin], 0.0)
            for residue in repaired.topology.residues():
                own = np.array([atom.index for atom in residue.atoms()])
                known = own[is_old[own]]
                factors[own[~is_old[own]]] = factors[known].mean() if len(known) else 0.0
        keep_box = self.options.keep_water and old.box_vectors is not None
        charges = np.zeros(len(is_old), dtype=np.int32)
        if not self.options.add_hydrogens:
            charges[is_old] = old.charges[repaired.origin[is_old]]
        table = AtomTable(
            topology=repaired.topology,
            positions=repaired.positions,
            charges=charges,
            recorded=np.array(recorded, dtype=np.int64).reshape(-1, 2),
            hetero=np.zeros(len(is_old), dtype=bool),
            b_factors=factors,
        )
        if self.ligands:
            hydrogens = self.options.add_hydrogens
            table = join_ligands(table, self.ligands, self.report.source, hydrogens)
        return Molecule._from_atoms(
            table,
            source=self.report.source,
            source_hash=self.report.source_hash,
            hydrogens_at_ph=self.options.ph if self.options.add_hydrogens else None,
            box_vectors=old.box_vectors if keep_box else None,
        )

    def _is_standard_bond(self, i: int, j: int) -> bool:
        """Whether a bond is within standard residues, whose templates tell it."""
        return all(self.matches[self.residue_of[atom]] is not None for atom in (i, j))

    def _tell(self, repaired: Repaired) -> None:
        report, molecule = self.report, self.report.molecule
        residues = list(repaired.topology.residues())
        report.added = [residue_label(residues[k]) for k in repaired.built]
        done = report.done
        if self.replacements:
            changed = [
                f"{residue_label(self.residues[k])} by {name}"
                for k, name in self.replacements.items()
            ]
            done.append(f"Replaced: {', '.join(changed[:6])}{_more(changed, 6)}.")
        if repaired.built:
            done.append(f"Built residues: {', '.join(report.added[:6])}{_more(report.added, 6)}.")
        if repaired.completed:
            labels = [residue_label(residues[k]) for k in repaired.completed]
            done.append(f"Completed: {', '.join(labels[:6])}{_more(labels, 6)}.")
        dropped = Counter(
            "water" if r.name in WATERS else r.name
            for r in self.residues
            if not self.keep[next(r.atoms()).index]
        )
        if dropped:
            parts = ", ".join(f"{count} {name}" for name, count in dropped.items())
            done.append(f"Left out: {parts}.")
        hydrogens = int((molecule.elements == 1).sum())
        if self.options.add_hydrogens:
            done.append(
                f"Hydrogens for pH {self.options.ph:g}: {hydrogens}; the file had "
                f"{report.hydrogens}."
            )
        if not done:
            done.append("Nothing had to be done.")
        for gap in molecule.missing_atoms:
            report.left.append(f"{gap.residue} lacks {', '.join(gap.names)}.")
        for residue, name in report.nonstandard.items():
            if not name:
                report.left.append(f"{residue} has no standard residue and stays as it is.")
        report.left += _open_joints(repaired)
        report.notes += [note for note in molecule.notes if "hydrogens were added for" not in note]


def _is_polymer(match: TemplateMatch) -> bool:
    return match.template.is_amino_acid or match.template.is_nucleotide


def _where(gap: MissingResidues) -> str:
    if gap.before is None:
        return f"before {gap.after[1]} of chain {gap.chain}".rstrip()
    if gap.after is None:
        return f"after {gap.before[1]} of chain {gap.chain}".rstrip()
    return f"between {gap.before[1]} and {gap.after[1]} of chain {gap.chain}".rstrip()


def _more(names: list[str], most: int) -> str:
    return f" and {len(names) - most} more" if len(names) > most else ""


def _joints(repaired: Repaired) -> list[tuple[str, str, float]]:
    """Neighbours in a chain of which one was built, and the length of their bond, nm."""
    residues = list(repaired.topology.residues())
    built = set(repaired.built)
    found = []
    for one, other in zip(residues, residues[1:], strict=False):
        if one.chain is not other.chain or not {one.index, other.index} & built:
            continue
        ends = [a.index for a in one.atoms() if a.name in ("C", "O3'")]
        starts = [a.index for a in other.atoms() if a.name in ("N", "P")]
        if ends and starts:
            x = repaired.positions
            length = float(np.linalg.norm(x[starts[0]] - x[ends[0]]))
            found.append((residue_label(one), residue_label(other), length))
    return found


def _open_joints(repaired: Repaired) -> list[str]:
    return [
        f"The chain stays open between {one} and {other}, {10 * length:.1f} Å apart."
        for one, other, length in _joints(repaired)
        if length > _CLOSED
    ]


def _faults(repaired: Repaired) -> float:
    """How bad what was built is: open joints, and new heavy atoms nearer than 0.2 nm to others."""
    worst = sum(length > _CLOSED for _, _, length in _joints(repaired))
    residue_of = np.array([a.residue.index for a in repaired.topology.atoms()])
    heavy = np.array([a.element.atomic_number > 1 for a in repaired.topology.atoms()])
    pairs = close_pairs(repaired.positions, 0.2)
    if len(pairs):
        i, j = pairs.T
        new = (repaired.origin[i] < 0) | (repaired.origin[j] < 0)
        apart = np.abs(residue_of[i] - residue_of[j]) > 1
        worst += int((new & apart & heavy[i] & heavy[j]).sum())
    return float(worst)
