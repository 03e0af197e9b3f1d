"""The C++ program builds against what is installed, and gives the conformers that Python gives."""

import shutil
import signal
import subprocess
import time
from pathlib import Path

import h5py
import mdtraj
import numpy as np
import pytest
from rdkit import Chem
from rdkit.Chem import rdDistGeom

import ragdoll
from ragdoll.batch.conforming import ConformerOptions

ROOT = Path(__file__).resolve().parents[2]
SMILES = [
    "CC(C)Cc1ccc(cc1)[C@@H](C)C(=O)O",
    "C[C@H](N)C(=O)N[C@@H](Cc1ccccc1)C(=O)OC",
    "O=C1CCCCCCCCCCN1",
    "C/C=C\\CCO",
    "CN1CCN(CC1)S(=O)(=O)c1ccccc1",
]


def finished(command, **options):
    return subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, timeout=300, **options
    )


@pytest.fixture(scope="module")
def prefix():
    """Where the C++ libraries are installed: the Python package has them too."""
    package = Path(ragdoll.__file__).parent
    if not (package / "lib" / "cmake" / "openmm-ragdoll" / "chemistry-targets.cmake").is_file():
        pytest.skip("RDKit's adaptor is not built; its headers are needed (librdkit-dev)")
    return package


@pytest.fixture(scope="module")
def program(prefix, tmp_path_factory):
    """The example, built as its page says."""
    folder = tmp_path_factory.mktemp("cpp_conformers")
    shutil.copytree(ROOT / "examples" / "cpp_conformers", folder / "source")
    settings = [f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Debug"]  # compiles sooner
    for words in (
        ["-S", folder / "source", "-B", folder / "build", *settings],
        ["--build", folder / "build"],
    ):
        ended = finished(["cmake", *words])
        assert ended.returncode == 0, ended.stdout + ended.stderr
    return folder / "build" / "cpp_conformers"


def sentence(ended):
    lines = ended.stderr.splitlines()
    assert lines[-1].startswith("cpp_conformers: ") and lines[-1].endswith("."), ended.stderr
    return lines[-1]


def starts(path, smiles=SMILES, hydrogens=True):
    with Chem.SDWriter(str(path)) as writer:
        for number, text in enumerate(smiles):
            mol = Chem.AddHs(Chem.MolFromSmiles(text))
            assert rdDistGeom.EmbedMolecule(mol, randomSeed=3) == 0
            if not hydrogens:
                mol = Chem.RemoveHs(mol)
            mol.SetProp("_Name", f"start {number}")
            writer.write(mol)
    return path


def places(path):
    return [
        (mol.GetProp("_Name"), mol.GetConformer().GetPositions())
        for mol in Chem.SDMolSupplier(str(path), removeHs=False)
    ]


@pytest.mark.parametrize("hydrogens", [True, False])
def test_it_gives_the_conformers_that_python_gives(program, tmp_path, hydrogens):
    start = starts(tmp_path / "start.sdf", hydrogens=hydrogens)
    ended = finished([program, start, "-o", tmp_path / "cpp.sdf", "--count", 4, "--seed", 5])
    assert ended.returncode == 0, ended.stderr
    ragdoll.conformers_of_file(
        start, tmp_path / "python.sdf", ConformerOptions(count=4, seed=5), workers=1
    )
    ours, theirs = places(tmp_path / "cpp.sdf"), places(tmp_path / "python.sdf")
    assert [name for name, _ in ours] == [name for name, _ in theirs]
    assert len(ours) == 4 * len(SMILES)
    for (_, x), (_, y) in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(x, y)


def test_a_file_of_one_molecule_gives_what_the_function_gives(program, tmp_path):
    start = starts(tmp_path / "start.sdf", SMILES[:1])
    ended = finished([program, start, "-o", tmp_path / "cpp.sdf", "--count", 3, "--seed", 9])
    assert ended.returncode == 0, ended.stderr
    mol = next(Chem.SDMolSupplier(str(start), removeHs=False))
    made = ragdoll.conformers(mol, 3, seed=9)
    for (_, x), conformer in zip(places(tmp_path / "cpp.sdf"), made.GetConformers(), strict=True):
        np.testing.assert_allclose(x, conformer.GetPositions(), atol=6e-5)


def test_a_smiles_is_embedded_and_keeps_its_configuration(program, tmp_path):
    output = tmp_path / "out.sdf"
    ended = finished([program, SMILES[1], "-o", output, "-n", 5])
    assert ended.returncode == 0, ended.stderr
    expected = Chem.CanonSmiles(SMILES[1])
    count = 0
    for mol in Chem.SDMolSupplier(str(output), removeHs=False):
        Chem.AssignStereochemistryFrom3D(mol)
        assert Chem.MolToSmiles(Chem.RemoveHs(mol)) == expected
        assert mol.GetIntProp("ragdoll_conformer") == count + 1
        count += 1
    assert count == 5


def test_hdf5_of_one_molecule_is_a_trajectory_and_of_more_a_collection(program, tmp_path):
    one, more = tmp_path / "one.h5", tmp_path / "more.h5"
    assert finished([program, "CCCCO", "-o", one, "-n", 3]).returncode == 0
    loaded = mdtraj.load(one)
    assert (loaded.n_frames, loaded.n_atoms) == (3, 15)
    (tmp_path / "two.smi").write_text("CCCCO butanol\nCCCC butane\n")
    assert finished([program, tmp_path / "two.smi", "-o", more, "-n", 2]).returncode == 0
    with h5py.File(more) as file:
        assert [len(group["coordinates"]) for group in file["molecules"].values()] == [2, 2]


def test_a_bad_molecule_costs_a_line_and_exit_code_3(program, tmp_path):
    path = tmp_path / "mixed.smi"
    path.write_text("# comment\nCCCO good\nC(C)(C)(C)(C)C five\n*C dummy\nC[Fe open\nCCCN also\n")
    ended = finished([program, path, "-o", tmp_path / "out.sdf", "-n", 2])
    assert ended.returncode == 3
    lines = ended.stderr.splitlines()
    assert [line.split(":")[0] for line in lines] == [
        "line 3 (five)",
        "line 4 (dummy)",
        "line 5 (open)",
        "cpp_conformers",
    ]
    assert [name for name, _ in places(tmp_path / "out.sdf")] == ["good"] * 2 + ["also"] * 2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "Give an input"),
        (["CCO"], "Give an output"),
        (["CCO", "-o", "out.xyz"], "must be .sdf or .h5"),
        (["CC(", "-o", "out.sdf"], "no SMILES"),
        (["none.sdf", "-o", "out.sdf"], "cannot be read"),
        (["CCO", "-o", "nowhere/out.sdf"], "no folder"),
        (["CCO", "-o", "out.sdf", "--count", "0"], "--count must be from 1"),
        (["CCO", "-o", "out.sdf", "--seed", "x"], "--seed must be from 0"),
        (["CCO", "-o", "out.sdf", "--colour"], "no option --colour"),
        (["CCO", "-o", "there.sdf"], "there.sdf exists"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(program, tmp_path, words, says):
    (tmp_path / "there.sdf").write_text("mine")
    ended = finished([program, *words], cwd=tmp_path)
    assert ended.returncode == 2
    assert says in sentence(ended)
    assert len(ended.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["there.sdf"]
    assert (tmp_path / "there.sdf").read_text() == "mine"


def test_an_interrupted_run_leaves_nothing(program, tmp_path):
    (tmp_path / "many.smi").write_text("CCCCCCCCCCCC(=O)NCCCCCC\n" * 2000)
    with subprocess.Popen(
        [program, "many.smi", "-o", "out.sdf", "-n", "50"], cwd=tmp_path, stderr=subprocess.PIPE
    ) as running:
        time.sleep(1)
        running.send_signal(signal.SIGINT)
        said = running.stderr.read().decode()
    assert running.returncode == 130
    assert said == "cpp_conformers: Interrupted; out.sdf was not written.\n"
    assert [path.name for path in tmp_path.iterdir()] == ["many.smi"]


def test_a_component_that_was_not_installed_is_named(prefix, tmp_path):
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.25)\nproject(none LANGUAGES C CXX)\n"
        "find_package(openmm-ragdoll CONFIG REQUIRED COMPONENTS alchemy)\n"
    )
    ended = finished(
        ["cmake", "-S", tmp_path, "-B", tmp_path / "b", f"-DCMAKE_PREFIX_PATH={prefix}"]
    )
    assert ended.returncode != 0
    assert "without alchemy" in " ".join(ended.stderr.split())
