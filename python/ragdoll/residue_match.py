"""Residues of a structure laid over their templates."""

from collections.abc import Sequence
from dataclasses import dataclass

from openmm.app import Residue

from .errors import InputError
from .residues import ResidueTemplate, residue_template


@dataclass(frozen=True)
class TemplateMatch:
    """A residue laid over its template.

    Attributes:
        template: the template.
        indices: atom index by template name.
        unmatched: indices of atoms that the template does not know.
    """

    template: ResidueTemplate
    indices: dict[str, int]
    unmatched: list[int]


@dataclass(frozen=True)
class MissingAtoms:
    """Heavy atoms that a standard residue lacks.

    Attributes:
        residue: the residue, such as "LYS27 A".
        names: names of the missing atoms.
    """

    residue: str
    names: tuple[str, ...]


def residue_label(residue: Residue) -> str:
    """Return a residue's name for messages, such as "LYS27 A"."""
    return f"{residue.name}{residue.id}{residue.insertionCode.strip()} {residue.chain.id}".rstrip()


def match_residue(residue: Residue) -> TemplateMatch | None:
    """Lay a residue over its template; None if it is no standard residue.

    Raises:
        InputError: two atoms of a standard residue have one name.
    """
    atoms = list(residue.atoms())
    names = [atom.name for atom in atoms]
    template = residue_template(residue.name, frozenset(names))
    if template is None:
        return None
    indices = {atom.name: atom.index for atom in atoms if atom.name in template.elements}
    unmatched = []
    strange = 0
    for atom in atoms:
        name = template.atom_name(atom.name)
        if indices.get(atom.name) == atom.index:
            continue
        if name in template.elements and name not in indices:
            indices[name] = atom.index
        else:
            unmatched.append(atom.index)
            strange += atom.element.atomic_number > 1
    if 2 * strange > sum(atom.element.atomic_number > 1 for atom in atoms):
        return None  # something else that happens to have the name of a standard residue
    # Some programs call all hydrogens of an atom the same; their places tell them apart.
    heavy_names = [atom.name for atom in atoms if atom.element.atomic_number > 1]
    if len(set(heavy_names)) < len(heavy_names):
        twice = next(name for name in heavy_names if heavy_names.count(name) > 1)
        raise InputError(
            f"Atom {twice} occurs twice in {residue_label(residue)}; "
            "number the residues apart or mark the atoms as alternate locations."
        )
    return TemplateMatch(template, indices, unmatched)


def missing_atoms(
    residues: Sequence[Residue], matches: Sequence[TemplateMatch | None]
) -> list[MissingAtoms]:
    """List the residues that lack heavy atoms of their template, terminal atoms not counted."""
    found = []
    chain = None
    for residue, match in zip(residues, matches, strict=True):
        begins_chain = residue.chain is not chain
        chain = residue.chain
        if match is None:
            continue
        required = match.template.required
        if begins_chain:
            required = required - {"P", "OP1", "OP2"}  # a 5' end has no phosphate
        names = required - match.indices.keys()
        if names:
            found.append(MissingAtoms(residue_label(residue), tuple(sorted(names))))
    return found
