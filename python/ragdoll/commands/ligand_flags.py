"""The flags of ligands, for every command that reads a structure."""

import functools
import inspect
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from ..ligand_file import read_ligand
from ..ligands import Ligands, parse_ligand_smiles


@dataclass(frozen=True)
class LigandFlags:
    """What the flags say.

    Attributes:
        files: ``FILE`` or ``FILE:RECORD``, each.
        smiles: a SMILES by residue name.
        covalent_bonds: texts that name two atoms each.
    """

    files: tuple[str, ...] = ()
    smiles: tuple[tuple[str, str], ...] = ()
    covalent_bonds: tuple[str, ...] = ()

    def arguments(self) -> dict[str, Any]:
        """The arguments of Molecule.from_file."""
        return {
            "ligands": list(self.files),
            "ligand_smiles": dict(self.smiles),
            "covalent_bonds": list(self.covalent_bonds),
        }

    def check(self) -> dict[str, Any]:
        """Read them before a large file is read.

        Returns:
            What a trajectory keeps of them: the arguments, and hashes of the files' records.

        Raises:
            InputError: one of them cannot be used.
        """
        Ligands.read(**self.arguments())
        if not (self.files or self.smiles or self.covalent_bonds):
            return {}
        hashes = [read_ligand(file).source_hash for file in self.files]
        return {**self.arguments(), "ligand_hashes": hashes}


def _flags(
    ligand: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE[:RECORD]",
            help="SDF, MOL or MOL2 file of a ligand posed in the structure; a residue that is in "
            "its place goes. May be repeated.",
        ),
    ] = None,
    ligand_smiles: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=SMILES",
            help="Bonds, charges and hydrogens of the file's residues of this name. May be "
            "repeated.",
        ),
    ] = None,
    covalent_bond: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ATOM=ATOM",
            help="A:CYS145:SG=LIG:C12, or 'SEL1; SEL2': a bond of a ligand; recorded bonds, and "
            "those by distance, are found without. May be repeated.",
        ),
    ] = None,
) -> LigandFlags:
    return LigandFlags(
        tuple(ligand or ()),
        tuple(parse_ligand_smiles(ligand_smiles or ()).items()),
        tuple(covalent_bond or ()),
    )


NO_LIGANDS = LigandFlags()


def takes_ligands(command):
    """Give a command that has a parameter ``ligands`` the flags that make it, in its place."""
    own = inspect.signature(command).parameters
    flags = inspect.signature(_flags).parameters

    @functools.wraps(command)
    def run(**values: Any):
        ligands = _flags(**{name: values.pop(name) for name in flags})
        return command(**values, ligands=ligands)

    parameters = []
    for name, parameter in own.items():
        parameters += flags.values() if name == "ligands" else [parameter]
    # typer asks for keywords alone, in this sequence
    run.__signature__ = inspect.Signature(
        [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    )
    run.__annotations__ = {p.name: p.annotation for p in parameters}
    return run
