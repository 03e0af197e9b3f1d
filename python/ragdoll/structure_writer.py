"""Molecules to PDB and mmCIF files."""

import textwrap
from pathlib import Path

import gemmi

from .errors import InputError
from .molecule import Molecule
from .residues import WATERS, residue_template

_ANGSTROM = 10.0  # per nm
_MOST_ATOMS_OF_PDB = 99_999


def structure_text(molecule: Molecule, path: str | Path, remarks: list[str]) -> str:
    """The text of a file in the format that the name asks for: .pdb, .cif or .mmcif.

    Bonds that residue names do not tell go along: CONECT records, or struct_conn for disulfides.

    Args:
        molecule: what to write.
        path: tells the format.
        remarks: sentences for the head of the file.

    Raises:
        InputError: the molecule does not fit into the format.
    """
    as_pdb = Path(path).suffix.lower() == ".pdb"
    structure = _structure(molecule)
    if as_pdb:
        if len(molecule) > _MOST_ATOMS_OF_PDB or any(len(c.name) > 1 for c in structure[0]):
            raise InputError(
                f"{len(molecule)} atoms and these chains do not fit into a PDB file; give a name "
                "that ends in .cif."
            )
        structure.assign_serial_numbers()
        _add_conects(structure, molecule)
        options = gemmi.PdbWriteOptions()
        options.conect_records = True
        options.preserve_serial = True
        options.cryst1_record = False
        head = "".join(f"REMARK   3 {line}\n" for line in _wrapped(remarks))
        return head + structure.make_pdb_string(options)
    document = structure.make_mmcif_document()
    return "".join(f"# {line}\n" for line in _wrapped(remarks)) + document.as_string()


def _structure(molecule: Molecule) -> gemmi.Structure:
    """The atoms, in the order of the molecule; each chain of the topology is a chain of its own."""
    structure = gemmi.Structure()
    structure.name = "prepared"
    model = gemmi.Model(1)
    factors = molecule.b_factors
    links = []
    address = {}
    for chain in molecule.topology.chains():
        new_chain = gemmi.Chain(chain.id.strip())
        for residue in chain.residues():
            target = gemmi.Residue()
            target.name = residue.name
            target.seqid = gemmi.SeqId(int(residue.id), residue.insertionCode.strip() or " ")
            template = residue_template(residue.name)
            polymer = template is not None and (template.is_amino_acid or template.is_nucleotide)
            target.het_flag = "A" if polymer else "H"
            if residue.name in WATERS:
                target.entity_type = gemmi.EntityType.Water
            else:
                kinds = gemmi.EntityType
                target.entity_type = kinds.Polymer if polymer else kinds.NonPolymer
            for atom in residue.atoms():
                new = gemmi.Atom()
                new.name = atom.name
                new.element = gemmi.Element(atom.element.symbol)
                new.charge = int(molecule.charges[atom.index])
                new.pos = gemmi.Position(*(molecule.positions[atom.index] * _ANGSTROM))
                new.b_iso = 0.0 if factors is None else float(factors[atom.index])
                target.add_atom(new)
                address[atom.index] = (new_chain.name, target.clone(), atom.name)
            new_chain.add_residue(target)
        model.add_chain(new_chain)
    structure.add_model(model)
    elements = molecule.elements
    for i, j in molecule.bonds.tolist():
        if elements[i] == elements[j] == 16:
            links.append((i, j))
    for number, (i, j) in enumerate(links, start=1):
        link = gemmi.Connection()
        link.name = f"disulf{number}"
        link.type = gemmi.ConnectionType.Disulf
        link.asu = gemmi.Asu.Same
        for end, atom in ((link.partner1, i), (link.partner2, j)):
            end.chain_name, residue, end.atom_name = address[atom]
            end.res_id.name, end.res_id.seqid = residue.name, residue.seqid
        structure.connections.append(link)
    structure.setup_entities()
    return structure


def _add_conects(structure: gemmi.Structure, molecule: Molecule) -> None:
    """CONECT records of the bonds that no template tells."""
    atoms = list(molecule.topology.atoms())
    serials = [atom.serial for chain in structure[0] for residue in chain for atom in residue]
    standard = [
        residue_template(atom.residue.name) is not None or atom.residue.name in WATERS
        for atom in atoms
    ]
    for i, j in molecule.bonds.tolist():
        sulfurs = molecule.elements[i] == molecule.elements[j] == 16
        if not (standard[i] and standard[j]) or sulfurs:
            structure.add_conect(serials[i], serials[j], 1)


def _wrapped(remarks: list[str], width: int = 66) -> list[str]:
    return [line for remark in remarks for line in textwrap.wrap(remark, width)]
