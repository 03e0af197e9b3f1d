"""Rigid clusters as files that viewers open."""

from collections import defaultdict

import gemmi
import numpy as np

from .rigidity_analysis import RigidityResult

# colours that stay apart, also for the colour-blind (Okabe and Ito, and Tol)
PALETTE = (
    "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#332288",
    "#88ccee", "#117733", "#882255", "#aa4499", "#999933", "#44aa99", "#661100", "#6699cc",
)  # fmt: skip
_LEAST_ATOMS = 10  # smaller clusters, such as a methyl, stay grey in PyMOL
_MOST_CLUSTERS = 60


def rgb(colour: str) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1."""
    return tuple(int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))


def pymol_script(result: RigidityResult, path: str) -> str:
    """A PyMOL script that loads the input and colours its rigid clusters.

    Args:
        result: the clusters.
        path: of the file that the molecule was read from.
    """
    lines = [
        f"# rigid clusters at {result.options.hbond_cutoff_kcal:g} kcal/mol; "
        f"{result.floppy_modes} floppy modes",
        f"load {path}, ragdoll",
        "hide everything, ragdoll",
        "show cartoon, ragdoll",
        "show lines, ragdoll",
        "color grey70, ragdoll",
    ]
    sizes = result.cluster_sizes[:_MOST_CLUSTERS]
    for cluster in range(int((sizes >= _LEAST_ATOMS).sum())):
        name = f"cluster_{cluster + 1}"
        red, green, blue = rgb(PALETTE[cluster % len(PALETTE)])
        lines.append(f"set_color {name}_colour, [{red:.3f}, {green:.3f}, {blue:.3f}]")
        lines.append(f"select {name}, none")
        for words in _selections(result, np.flatnonzero(result.cluster_of_body == cluster)):
            lines.append(f"select {name}, {name} or (ragdoll and {words})")
        lines.append(f"color {name}_colour, {name}")
        if cluster == 0:
            lines.append(f"show sticks, {name}")
    atoms = list(result.molecule.topology.atoms())

    def one(atom: int) -> str:
        words = (_chain(atoms[atom]), _residue(atoms[atom]), _name(atoms[atom]))
        return f"ragdoll and {' and '.join(words)}"

    for name, colour, pairs in (
        ("hydrogen_bonds", "yellow", result.bonds.hbonds[:, 1:]),
        ("tethers", "grey50", result.bonds.tethers),
    ):
        lines += [f"distance {name}, ({one(a)}), ({one(b)})" for a, b in pairs]
        if len(pairs):
            lines += [f"hide labels, {name}", f"color {colour}, {name}", f"disable {name}"]
    lines += ["deselect", "orient ragdoll"]
    return "\n".join(lines) + "\n"


def _selections(result: RigidityResult, members: np.ndarray) -> list[str]:
    """Selections that together are these atoms: of one chain and one atom name each."""
    atoms = list(result.molecule.topology.atoms())
    residues = defaultdict(list)
    for index in members:
        atom = atoms[index]
        residues[_chain(atom), _name(atom)].append(_residue(atom).removeprefix("resi "))
    return [
        f"{chain} and {name} and resi {'+'.join(ids)}" for (chain, name), ids in residues.items()
    ]


def _chain(atom) -> str:
    return f'chain "{atom.residue.chain.id.strip()}"'


def _residue(atom) -> str:
    return f"resi {atom.residue.id}{atom.residue.insertionCode.strip()}"


def _name(atom) -> str:
    return f'name "{atom.name}"'


def mmcif(result: RigidityResult) -> str:
    """The atoms as mmCIF; their B factors and the column ``ragdoll_cluster`` are the numbers of
    their rigid clusters, counted from 1, the largest first."""
    structure = gemmi.Structure()
    structure.name = "ragdoll"
    model = gemmi.Model(1)
    clusters = []
    for chain in result.molecule.topology.chains():
        new_chain = gemmi.Chain(chain.id.strip() or "A")
        for residue in chain.residues():
            new_residue = gemmi.Residue()
            new_residue.name = residue.name
            code = residue.insertionCode.strip()
            try:
                new_residue.seqid = gemmi.SeqId(f"{int(residue.id)}{code}")
            except ValueError:
                new_residue.seqid = gemmi.SeqId(str(residue.index + 1))
            known = gemmi.find_tabulated_residue(residue.name)
            new_residue.het_flag = "A" if known.is_standard() else "H"
            for atom in residue.atoms():
                new_atom = gemmi.Atom()
                new_atom.name = atom.name
                new_atom.element = gemmi.Element(atom.element.atomic_number)
                new_atom.pos = gemmi.Position(*(10 * result.molecule.positions[atom.index]))
                new_atom.b_iso = float(result.cluster_of_body[atom.index] + 1)
                new_atom.charge = int(result.molecule.charges[atom.index])
                clusters.append(str(result.cluster_of_body[atom.index] + 1))
                new_residue.add_atom(new_atom)
            new_chain.add_residue(new_residue)
        model.add_chain(new_chain)
    structure.add_model(model)
    structure.setup_entities()
    document = structure.make_mmcif_document()
    sites = document[0].find_loop("_atom_site.id").get_loop()
    sites.add_columns(["_atom_site.ragdoll_cluster"], "?")
    table = document[0].find("_atom_site.", ["id", "ragdoll_cluster"])
    for row, cluster in zip(table, clusters, strict=True):
        row[1] = cluster
    return document.as_string()
