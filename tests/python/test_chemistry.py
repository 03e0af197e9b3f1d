"""The RDKit adaptor of C++ and that of Python make the same of the same molecule."""

import gzip
import json
import os
import subprocess
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from rdkit import Chem, RDConfig, rdBase
from rdkit.Chem import rdDistGeom

import ragdoll
from ragdoll.torsion_terms import torsion_terms

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("RAGDOLL_DATA", ROOT.parent / "shared" / "data"))
SHIPPED = Path(RDConfig.RDDataDir)
CONTRIBUTED = Path(RDConfig.RDContribDir)


def built(program):
    """A program of the C++ tests, the newest build of it; skips where RDKit's headers are not."""
    named = os.environ.get("RAGDOLL_CPP_TESTS")
    folders = [Path(named)] if named else list(ROOT.glob("build/*/tests"))
    found = [path for folder in folders if (path := folder / "chemistry" / program).is_file()]
    if not found:
        pytest.skip(f"{program} is not built; RDKit's headers are needed (librdkit-dev)")
    return max(found, key=lambda path: path.stat().st_mtime)


def smiles_of(path, stride=1):
    """The first word of every line that RDKit reads as one connected molecule."""
    with rdBase.BlockLogs():
        for line in islice(path.read_text().splitlines(), 0, None, stride):
            words = line.split()
            mol = Chem.MolFromSmiles(words[0]) if words else None
            if mol is not None and 4 <= mol.GetNumHeavyAtoms() <= 60:
                yield mol


def embedded(mol):
    """The molecule with hydrogens and places; None where RDKit finds none soon."""
    mol = Chem.AddHs(mol)
    settings = rdDistGeom.ETKDGv3()
    settings.randomSeed = 11
    settings.maxIterations = 5
    with rdBase.BlockLogs():
        return mol if rdDistGeom.EmbedMolecule(mol, settings) == 0 else None


def shipped_molecules():
    """Real molecules that the RDKit wheel brings: of NCI, ZINC and ChEMBL."""
    files = [
        (SHIPPED / "NCI" / "first_5K.smi", 11),
        (CONTRIBUTED / "SA_Score" / "data" / "zim.100.txt", 1),
        (CONTRIBUTED / "fraggle" / "data" / "ChEMBL_11265_actives.smi", 2),
    ]
    for path, stride in files:
        if path.is_file():
            for mol in smiles_of(path, stride):
                placed = embedded(mol)
                if placed is not None:
                    yield placed


def write(path, mols):
    with Chem.SDWriter(str(path)) as writer:
        for mol in mols:
            writer.write(mol)


def python_side(mol):
    """What print_frameworks prints of a molecule, by the Python adaptor."""
    molecule = ragdoll.Molecule.from_rdkit(mol)
    framework = ragdoll.build_framework(molecule)
    atoms, amplitudes, signs = torsion_terms(mol)

    def beside(*columns):
        wide = [value if value.ndim > 1 else value[:, None] for value in map(np.asarray, columns)]
        return np.hstack(wide)

    return {
        "masses": framework.masses,
        "labels": np.array(molecule.labels),
        "charges": molecule.charges,
        "bonds": beside(molecule.bonds, molecule.bond_orders),
        "bars": beside(framework.bars, framework.bar_kinds),
        "bar_lengths": framework.bar_lengths,
        "volumes": beside(framework.volumes, framework.volume_kinds),
        "volume_bounds": beside(
            framework.volume_lower, framework.volume_upper, framework.volume_scale
        ),
        "contact_radii": framework.contact_radii,
        "contact_polarity": framework.contact_polarity,
        "contact_exclusions": framework.contact_exclusions,
        "close_pairs": framework.close_pairs,
        "close_pair_lengths": framework.close_pair_lengths,
        "term_atoms": atoms,
        "term_amplitudes": amplitudes,
        "term_signs": signs,
    }


def differences(path):
    """Molecules of an SD file with all hydrogens, and what the adaptors disagree on."""
    ended = subprocess.run([built("print_frameworks"), path], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    lines = ended.stdout.splitlines()
    with rdBase.BlockLogs():
        mols = list(Chem.SDMolSupplier(str(path), removeHs=False))
    assert len(mols) == len(lines)
    found, count = [], 0
    for number, (mol, line) in enumerate(zip(mols, lines, strict=True)):
        theirs = json.loads(line)
        if mol is None:
            assert "fault" in theirs
            continue
        count += 1
        whole = Chem.AddHs(mol, addCoords=True)
        for name, value in python_side(whole).items():
            value = np.asarray(value).ravel()
            if not np.array_equal(np.array(theirs[name], dtype=value.dtype), value):
                found.append((number, name, Chem.MolToSmiles(mol)))
    return found, count


def test_both_adaptors_make_the_same_framework_of_500_molecules(tmp_path):
    built("print_frameworks")
    path = tmp_path / "shipped.sdf"
    write(path, islice(shipped_molecules(), 510))
    found, count = differences(path)
    assert count >= 500
    assert found == []


@pytest.mark.parametrize(
    "name",
    [
        "cod_crystals_public.sdf",
        "macrocycles_public.sdf",
        "medium_rings_public.sdf",
        "minidrugbank.sdf.gz",
        "platinum_subset_public.sdf",
    ],
)
def test_both_adaptors_make_the_same_framework_of_ligands(name, tmp_path):
    path = DATA / "ligands" / name
    if not path.is_file():
        pytest.skip("no ligand files; set RAGDOLL_DATA to the folder that holds ligands/")
    if path.suffix == ".gz":
        plain = tmp_path / path.stem
        plain.write_bytes(gzip.decompress(path.read_bytes()))
        path = plain
    found, count = differences(path)
    assert count >= 20
    assert found == []


def test_a_macrocycles_bond_to_a_smaller_ring_has_no_term():
    mol = Chem.AddHs(Chem.MolFromSmiles("O=C1c2coc(n2)CCCCCCCC(=O)NC[C@@H]2CCCN12"))
    _, carbon, _, nitrogen = mol.GetSubstructMatch(Chem.MolFromSmarts("O=C(c)N"))
    atoms, amplitudes, signs = torsion_terms(mol)
    about = [{int(b), int(c)} for _, b, c, _ in atoms]
    assert {carbon, nitrogen} not in about
    assert len(about) == len(amplitudes) == len(signs) == 9


def test_what_python_and_openmm_load_links_no_rdkit_of_the_system():
    libraries = list(Path(ragdoll.__file__).parent.rglob("*.so*"))
    assert len(libraries) >= 4
    assert not [path.name for path in libraries if b"libRDKit" in path.read_bytes()]
