"""The one conformer that sampling starts from: the given one, or one that RDKit embeds."""

import time

import numpy as np
from rdkit import Chem
from rdkit.Chem import rdDistGeom, rdForceFieldHelpers
from rdkit.Chem.EnumerateStereoisomers import EnumerateStereoisomers, StereoEnumerationOptions

from ..errors import InputError
from .joining import join_pieces
from .rdkit_messages import rdkit_messages
from .refining import configuration

MOST_ATOMS = 5000  # with hydrogens; embedding takes memory by their square
LARGE = 100  # heavy atoms; above it pieces are embedded and joined
_LARGEST_TO_RELAX = 300  # atoms
_RELAXATIONS = 200  # iterations
_GAP = 3.0  # angstrom between the spheres around fragments
_FLAT = 1e-3  # angstrom
_SHORTEST_BOND = 0.3  # angstrom
_STEREO = (Chem.StereoType.Atom_Tetrahedral, Chem.StereoType.Bond_Double)


def with_hydrogens(mol: Chem.Mol) -> Chem.Mol:
    """A copy with all hydrogens as atoms, after the others, which keep their order.

    Raises:
        InputError: atoms without an element, or too many.
    """
    dummies = [atom.GetIdx() for atom in mol.GetAtoms() if atom.GetAtomicNum() == 0]
    if dummies:
        raise InputError(
            f"atom {dummies[0] + 1} has no element (*); replace it by what it stands for"
        )
    count = mol.GetNumAtoms() + sum(atom.GetTotalNumHs() for atom in mol.GetAtoms())
    if count > MOST_ATOMS:
        raise InputError(f"it has {count} atoms with hydrogens, more than {MOST_ATOMS}")
    return Chem.AddHs(mol, addCoords=has_places(mol))


def has_places(mol: Chem.Mol) -> bool:
    """Whether the molecule has a conformer in three dimensions."""
    if mol.GetNumConformers() == 0:
        return False
    conformer = mol.GetConformer()
    places = np.array(conformer.GetPositions())
    if not np.isfinite(places).all():
        raise InputError("it has coordinates that are no numbers")
    if mol.GetNumAtoms() == 1:
        return True
    if len(np.unique(places, axis=0)) < len(places):  # such as all at the origin
        return False
    return conformer.Is3D() and bool(np.ptp(places[:, 2]) > _FLAT or _is_flat(mol))


def _is_flat(mol: Chem.Mol) -> bool:
    """Whether a molecule may lie in a plane: no atom has four neighbours, as water and benzene."""
    return all(atom.GetTotalDegree() < 4 for atom in mol.GetAtoms())


def unspecified_stereo(mol: Chem.Mol) -> int:
    """Centres and double bonds whose configuration is not said."""
    found = Chem.FindPotentialStereo(Chem.Mol(mol))
    return sum(
        info.specified == Chem.StereoSpecified.Unspecified and info.type in _STEREO
        for info in found
    )


def isomers(mol: Chem.Mol, most: int, seed: int) -> list[Chem.Mol]:
    """The molecule in the configurations that are left open, at most so many; itself for 0."""
    if most == 0 or not unspecified_stereo(mol):
        return [mol]
    options = StereoEnumerationOptions(
        onlyUnassigned=True, unique=True, maxIsomers=most, rand=seed % 2**31
    )
    with rdkit_messages():
        return list(EnumerateStereoisomers(mol, options=options)) or [mol]


def place(
    mol: Chem.Mol, start: str, seed: int, seconds: float, relax: bool = False
) -> tuple[Chem.Mol, list[str]]:
    """The molecule with all hydrogens, one conformer, and the configuration that this one has.

    Args:
        mol: sanitized.
        start: "input": the given coordinates where they are in three dimensions, else embedded;
            "embed": embedded always.
        seed: of the embedding.
        seconds: how long embedding may take in all.
        relax: minimise what was embedded by MMFF94s, or UFF.

    Returns:
        The molecule, and notes on it: how it was embedded, what configuration was not given.

    Raises:
        InputError: no start can be had.
    """
    notes: list[str] = []
    is_placed = has_places(mol)
    if is_placed:
        mol = Chem.Mol(mol)
        Chem.AssignStereochemistryFrom3D(mol)
    full = with_hydrogens(mol)
    if is_placed and start == "input":
        _check_distances(full)
        _keep_one_conformer(full)
        return full, notes
    count = unspecified_stereo(full)
    if count:
        notes.append(
            f"configuration not given at {count} centre(s) or double bond(s); the start's is kept"
        )
    full.RemoveAllConformers()
    how = _joined(full, seed, seconds) if full.GetNumHeavyAtoms() > LARGE else ""
    if not how:
        how = _embed(full, seed, seconds)
        _separate_fragments(full)
    if how:
        notes.append(how)
    if relax:
        _relax(full)
    Chem.AssignStereochemistryFrom3D(full)
    return full, notes


def _check_distances(mol: Chem.Mol) -> None:
    places = np.array(mol.GetConformer().GetPositions())
    for bond in mol.GetBonds():
        i, j = bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()
        if np.linalg.norm(places[i] - places[j]) < _SHORTEST_BOND:
            raise InputError(
                f"atoms {i + 1} and {j + 1} are bonded and in one place; use --start embed"
            )


def _keep_one_conformer(mol: Chem.Mol) -> None:
    conformer = Chem.Conformer(mol.GetConformer())
    mol.RemoveAllConformers()
    conformer.SetId(0)
    mol.AddConformer(conformer)


def _relax(mol: Chem.Mol) -> None:
    """Give an embedded conformer the bonds and angles of MMFF94s, or of UFF.

    All conformers have those of the start. Where the configuration changes, or neither force field
    has parameters, or the molecule is large, nothing is done.
    """
    if not 2 < mol.GetNumAtoms() <= _LARGEST_TO_RELAX:
        return
    relaxed = Chem.Mol(mol)
    with rdkit_messages():
        if rdForceFieldHelpers.MMFFHasAllMoleculeParams(relaxed):
            rdForceFieldHelpers.MMFFOptimizeMolecule(relaxed, "MMFF94s", _RELAXATIONS)
        elif rdForceFieldHelpers.UFFHasAllMoleculeParams(relaxed):
            rdForceFieldHelpers.UFFOptimizeMolecule(relaxed, _RELAXATIONS)
        else:
            return
    places = relaxed.GetConformer().GetPositions()
    if np.isfinite(places).all() and configuration(relaxed, -1) == configuration(mol, -1):
        mol.GetConformer().SetPositions(places)


def _joined(mol: Chem.Mol, seed: int, seconds: float) -> str:
    """Place a large molecule piece by piece; gives how, or nothing where that cannot be."""
    end = time.monotonic() + 0.5 * seconds

    def embed(piece: Chem.Mol, number: int) -> None:
        _embed(piece, seed + 7 * number, end - time.monotonic())

    try:
        with rdkit_messages():
            join_pieces(mol, embed, seed)
    except (InputError, RuntimeError):  # of RDKit's; the whole may still be embedded
        mol.RemoveAllConformers()
        return ""
    return "joined from pieces that were embedded"


# what each attempt changes, and how it is told
_ATTEMPTS = (
    ({}, ""),
    ({"useRandomCoords": True}, "embedded from random coordinates"),
    (
        {
            "useRandomCoords": True,
            "useExpTorsionAnglePrefs": False,
            "useBasicKnowledge": False,
            "ignoreSmoothingFailures": True,
        },
        "embedded without knowledge of torsions",
    ),
)


def _embed(mol: Chem.Mol, seed: int, seconds: float) -> str:
    """Give the molecule one conformer by RDKit's ETKDGv3, or by less strict ways.

    Wang et al., J. Chem. Inf. Model. 60, 2044 (2020). Returns how, if not by the first way.
    """
    end = time.monotonic() + seconds
    said: list[str] = []
    for number, (changes, how) in enumerate(_ATTEMPTS):
        left = end - time.monotonic()
        if number and left <= 0:
            raise InputError(f"RDKit embedded no start within {seconds:.3g} s")
        settings = rdDistGeom.ETKDGv3()
        settings.randomSeed = (seed + number) % (2**31 - 1)
        settings.numThreads = 1
        settings.timeout = max(int(left / (len(_ATTEMPTS) - number)), 1)  # whole seconds
        settings.trackFailures = True
        for name, value in changes.items():
            setattr(settings, name, value)
        with rdkit_messages() as messages:
            try:
                identifier = rdDistGeom.EmbedMolecule(mol, settings)
            except Exception as error:  # RDKit throws many kinds, by no rule
                messages.append(str(error))
                identifier = -1
        if identifier >= 0 and mol.GetNumConformers() == 1:
            places = mol.GetConformer().GetPositions()
            if np.isfinite(places).all():
                return how
        mol.RemoveAllConformers()
        causes = _causes(settings)
        said = [*([causes] if causes else []), *messages]
    why = " ".join(said[0].split()).removesuffix(".") if said else "it gives no reason"
    raise InputError(f"RDKit embeds no start: {why}")


def _causes(settings: rdDistGeom.EmbedParameters) -> str:
    """What most attempts of RDKit failed by."""
    names = sorted(rdDistGeom.EmbedFailureCauses.names.items(), key=lambda item: int(item[1]))
    counts = list(settings.GetFailureCounts())
    found = [
        (count, name)
        for (name, cause) in names
        if int(cause) < len(counts) and (count := counts[int(cause)])
    ]
    if not found:
        return ""
    name = max(found)[1].lower().replace("_", " ")
    return f"most attempts failed by {name}"


def _separate_fragments(mol: Chem.Mol) -> None:
    """Put unbonded fragments, which RDKit embeds on top of each other, side by side."""
    fragments = Chem.GetMolFrags(mol)
    if len(fragments) < 2:
        return
    conformer = mol.GetConformer()
    places = np.array(conformer.GetPositions())
    edge = 0.0
    for atoms in map(list, fragments):
        centre = places[atoms].mean(axis=0)
        radius = float(np.linalg.norm(places[atoms] - centre, axis=1).max())
        if edge:
            places[atoms] += np.array([edge + _GAP + radius, 0, 0]) - centre
            edge += _GAP + 2 * radius
        else:
            places[atoms] -= centre
            edge = radius or 1e-9
    conformer.SetPositions(places)
