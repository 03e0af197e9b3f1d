"""What is asked for a complex: posed ligands, SMILES of residues, covalent bonds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rdkit import Chem

from .errors import InputError
from .ligand_file import PosedLigand, read_ligand
from .ligand_template import read_smiles


@dataclass(frozen=True)
class Ligands:
    """Ligands that are read and checked.

    Attributes:
        posed: ligands with places of their own.
        templates: the molecule of each residue name, upper case.
        covalent_bonds: texts that name two atoms each.
    """

    posed: tuple[PosedLigand, ...] = ()
    templates: tuple[tuple[str, Chem.Mol], ...] = ()
    covalent_bonds: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        """Whether anything is asked for."""
        return bool(self.posed or self.templates or self.covalent_bonds)

    @classmethod
    def read(
        cls,
        ligands: Sequence[str | Path | Chem.Mol] | str | Path | Chem.Mol = (),
        ligand_smiles: Mapping[str, str] | None = None,
        covalent_bonds: Sequence[str] | str = (),
    ) -> "Ligands":
        """Read them.

        Args:
            ligands: files, ``FILE:RECORD``, or RDKit molecules with a conformer.
            ligand_smiles: a SMILES for each residue name.
            covalent_bonds: ``A:CYS145:SG=L:LIG1:C12``, or two selections ``SEL1; SEL2``.

        Raises:
            InputError: one of them cannot be used; the message says which and why.
        """
        if isinstance(ligands, str | Path | Chem.Mol):
            ligands = [ligands]
        if isinstance(covalent_bonds, str):
            covalent_bonds = [covalent_bonds]
        return cls(
            tuple(read_ligand(one) for one in ligands),
            tuple(
                (name.strip().upper(), read_smiles(name.strip(), smiles))
                for name, smiles in (ligand_smiles or {}).items()
            ),
            tuple(covalent_bonds),
        )


def parse_ligand_smiles(texts: Sequence[str]) -> dict[str, str]:
    """Residue names with their SMILES, from texts of the form ``NAME=SMILES``.

    Raises:
        InputError: a text is not of this form, or a name comes twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, separator, smiles = text.partition("=")
        name, smiles = name.strip(), smiles.strip()
        if not separator or not name or not smiles or not name.isalnum():
            raise InputError(
                f"--ligand-smiles '{text}' must be a residue name and a SMILES: BNZ=c1ccccc1."
            )
        if name.upper() in (known.upper() for known in found):
            raise InputError(f"--ligand-smiles names {name} twice; give one SMILES for it.")
        found[name] = smiles
    return found
