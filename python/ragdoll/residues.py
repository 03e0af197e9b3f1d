"""Templates of standard residues: which atoms are bonded, with which bond order.

Bonds and alternative atom names come from the tables that OpenMM ships; the bond orders are ours,
because OpenMM's tables have none.
"""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import openmm.app

# Bond orders as the core library numbers them.
UNKNOWN, SINGLE, DOUBLE, TRIPLE, AROMATIC, DATIVE = range(6)

WATERS = frozenset((
    "HOH", "DOD", "H2O", "D2O", "WAT", "SOL", "TIP", "TIP2", "TIP3", "TP3", "TP3M", "TP4", "TIP4",
    "T4P", "TIP5", "SPC", "OPC", "OPC3", "SPCE",
))  # fmt: skip

# Residues whose template is that of another, beyond the names in OpenMM's table. MSE and SEC have
# selenium where the template has sulfur.
_SAME_TEMPLATE = {
    "HSE": "HIS", "CYM": "CYS", "LYN": "LYS", "MSE": "MET", "SEC": "CYS", "CSE": "CYS",
    "T": "DT", "DU": "DT", "ARN": "ARG", "TYM": "TYR",
}  # fmt: skip
_SAME_ATOM = {"MSE": {"SE": "SD"}, "SEC": {"SE": "SG"}, "CSE": {"SE": "SG"}}
_NOT_MISSING = {"DU": {"C7"}}

_AMINO_ACIDS = frozenset((
    "ALA", "ARG", "ASN", "ASP", "CYS", "GLN", "GLU", "GLY", "HIS", "ILE", "LEU", "LYS", "MET",
    "PHE", "PRO", "SER", "THR", "TRP", "TYR", "VAL", "AIB", "ORN", "PCA", "UNK",
))  # fmt: skip
_NUCLEOTIDES = frozenset(("A", "C", "G", "U", "DA", "DC", "DG", "DT"))

_DOUBLE_BONDS = {
    "ASP": "CG-OD1", "GLU": "CD-OE1", "ASN": "CG-OD1", "GLN": "CD-OE1", "ARG": "CZ-NH2",
    "PCA": "CD-OE", "ACE": "C-O", "FOR": "C-O", "G": "C6-O6", "DG": "C6-O6",
    "C": "C2-O2", "DC": "C2-O2", "U": "C2-O2 C4-O4", "DT": "C2-O2 C4-O4",
}  # fmt: skip
_PURINE = "N9-C8-N7-C5-C4 C4-C5-C6-N1-C2-N3"
_PYRIMIDINE = "N1-C2-N3-C4-C5-C6"
_AROMATIC_RINGS = {
    "PHE": "CG-CD1-CE1-CZ-CE2-CD2", "TYR": "CG-CD1-CE1-CZ-CE2-CD2", "HIS": "CG-ND1-CE1-NE2-CD2",
    "TRP": "CG-CD1-NE1-CE2-CD2 CD2-CE2-CZ2-CH2-CZ3-CE3",
    "A": _PURINE, "DA": _PURINE, "G": _PURINE, "DG": _PURINE,
    "C": _PYRIMIDINE, "DC": _PYRIMIDINE, "U": _PYRIMIDINE, "DT": _PYRIMIDINE,
}  # fmt: skip


@dataclass(frozen=True)
class ResidueTemplate:
    """What is known of a residue by its name.

    Attributes:
        name: the template's name, such as "HIS" for a residue HID.
        aliases: alternative atom names, each with the template's name for the atom.
        elements: the symbol of each atom of the template.
        bonds: the bonds within the residue, as pairs of template names, each with its order code.
        required: heavy atoms that a complete residue in a chain has.
    """

    name: str
    aliases: dict[str, str]
    elements: dict[str, str]
    bonds: dict[tuple[str, str], int]
    required: frozenset[str]

    @property
    def is_amino_acid(self) -> bool:
        """Whether this is an amino acid."""
        return self.name in _AMINO_ACIDS

    @property
    def is_nucleotide(self) -> bool:
        """Whether this is a nucleotide."""
        return self.name in _NUCLEOTIDES

    def atom_name(self, name: str) -> str:
        """Return the template's name for the atom that a file calls `name`."""
        if name in self.elements:
            return name
        alias = self.aliases.get(name, name)
        if alias not in self.elements and name[:1] == "D":  # deuterium stands in for hydrogen
            hydrogen = "H" + name[1:]
            return hydrogen if hydrogen in self.elements else self.aliases.get(hydrogen, name)
        return alias


def residue_template(name: str, atom_names: frozenset[str] = frozenset()) -> ResidueTemplate | None:
    """Return the template of the residue called `name`, or None if it is no standard residue.

    Args:
        name: residue name as in the file.
        atom_names: names of the residue's atoms; old files call both DNA and RNA residues A, C, G,
            and these tell which it is.
    """
    if name in ("A", "C", "G") and "O2'" not in atom_names and "O2*" not in atom_names:
        name = "D" + name
    return _templates().get(name)


@cache
def _templates() -> dict[str, ResidueTemplate]:
    data = Path(openmm.app.__file__).parent / "data"
    bonds: dict[str, list[tuple[str, str]]] = {}
    for residue in ElementTree.parse(data / "residues.xml").getroot():
        pairs = [(bond.attrib["from"], bond.attrib["to"]) for bond in residue]
        bonds[residue.attrib["name"]] = [
            p for p in pairs if p[0][0] not in "+-" and p[1][0] not in "+-"
        ]

    common: dict[str, dict[str, str]] = {}
    own: dict[str, dict[str, str]] = {}
    kind: dict[str, str] = {}
    same_template: dict[str, str] = {}
    for residue in ElementTree.parse(data / "pdbNames.xml").getroot():
        name = residue.attrib["name"]
        aliases = {
            alias: atom.attrib["name"]
            for atom in residue
            for key, alias in atom.attrib.items()
            if key != "name"
        }
        if name in ("All", "Protein", "Nucleic"):
            common[name] = aliases
            continue
        own[name] = aliases
        kind[name] = residue.attrib.get("type", "All")
        for key, alias in residue.attrib.items():
            if key.startswith("alt"):
                same_template[alias] = name
    same_template.update(_SAME_TEMPLATE)

    templates = {}
    for name, pairs in bonds.items():
        if name == "HOH":
            continue
        aliases = common.get(kind.get(name, "All"), {}) | own.get(name, {})
        templates[name] = _template(name, pairs, aliases)
    for name, other in same_template.items():
        if name in templates or other not in templates:
            continue
        base = templates[other]
        renamed = _SAME_ATOM.get(name, {})
        templates[name] = ResidueTemplate(
            base.name,
            base.aliases | renamed,
            base.elements | {atom: "Se" for atom in renamed.values()},
            base.bonds,
            base.required - _NOT_MISSING.get(name, set()),
        )
    return templates


def _template(name: str, pairs: list[tuple[str, str]], aliases: dict[str, str]) -> ResidueTemplate:
    orders = dict.fromkeys(pairs, SINGLE)
    special: dict[frozenset[str], int] = {}
    if name in _AMINO_ACIDS:
        special[frozenset(("C", "O"))] = DOUBLE
    if name in _NUCLEOTIDES:
        special[frozenset(("P", "OP1"))] = DOUBLE
    for bond in _DOUBLE_BONDS.get(name, "").split():
        special[frozenset(bond.split("-"))] = DOUBLE
    for ring in _AROMATIC_RINGS.get(name, "").split():
        atoms = ring.split("-")
        for pair in zip(atoms, atoms[1:] + atoms[:1], strict=True):
            special[frozenset(pair)] = AROMATIC
    for pair in pairs:
        orders[pair] = special.get(frozenset(pair), SINGLE)

    names = {atom for pair in pairs for atom in pair}
    # Standard residues hold no elements with two letters, and atom names begin with the element.
    elements = {atom: atom.lstrip("0123456789")[0] for atom in names}
    heavy = {atom for atom, element in elements.items() if element != "H"}
    required = set() if name == "UNK" else heavy - {"OXT", "OP3"}
    return ResidueTemplate(name, aliases, elements, orders, frozenset(required))
