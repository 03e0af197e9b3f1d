"""``ragdoll.conformers``: conformers of one molecule."""

import numpy as np
import pytest
from openmm import unit
from rdkit import Chem, rdBase
from rdkit.Chem import AllChem, rdDistGeom, rdMolAlign, rdMolTransforms

import ragdoll
from ragdoll.batch import conforming
from ragdoll.batch.starting import place

pytestmark = pytest.mark.filterwarnings("ignore:.*conformers. ")


def positions(mol):
    return np.array([conformer.GetPositions() for conformer in mol.GetConformers()])


def embedded(smiles, seed=1):
    mol = Chem.AddHs(Chem.MolFromSmiles(smiles))
    rdDistGeom.EmbedMolecule(mol, randomSeed=seed)
    return mol


def heavy_rmsds(mol):
    heavy = Chem.RemoveAllHs(mol)
    return list(rdMolAlign.GetAllConformerBestRMS(heavy))


def test_as_many_as_asked_come_back_with_hydrogens_after_the_atoms_given():
    mol = Chem.MolFromSmiles("CCCCO")
    made = ragdoll.conformers(mol, 12, seed=3)
    assert made.GetNumConformers() == 12
    assert [c.GetId() for c in made.GetConformers()] == list(range(12))
    assert all(c.Is3D() for c in made.GetConformers())
    assert made.GetNumAtoms() == 15
    assert [a.GetSymbol() for a in made.GetAtoms()][:5] == ["C", "C", "C", "C", "O"]
    assert mol.GetNumAtoms() == 5 and mol.GetNumConformers() == 0
    assert not made.HasProp("ragdoll_reason")


def test_the_seed_decides_all():
    mol = Chem.MolFromSmiles("CCCCO")
    one = positions(ragdoll.conformers(mol, 5, seed=3))
    assert np.array_equal(one, positions(ragdoll.conformers(mol, 5, seed=3)))
    assert not np.allclose(one, positions(ragdoll.conformers(mol, 5, seed=4)))


def test_bonds_and_angles_are_those_of_the_given_start():
    mol = embedded("CC(C)CC(=O)NCC")
    made = ragdoll.conformers(mol, 8, seed=1)
    assert made.GetNumAtoms() == mol.GetNumAtoms()
    start = mol.GetConformer()
    for conformer in made.GetConformers():
        for bond in mol.GetBonds():
            i, j = bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()
            length = rdMolTransforms.GetBondLength(conformer, i, j)
            assert length == pytest.approx(rdMolTransforms.GetBondLength(start, i, j), abs=0.02)
    assert max(heavy_rmsds(made)) > 0.5


def test_without_a_start_or_with_a_flat_one_it_is_embedded():
    flat = Chem.MolFromSmiles("CC(C)CC")
    AllChem.Compute2DCoords(flat)
    for mol in (flat, Chem.MolFromSmiles("CC(C)CC")):
        made = ragdoll.conformers(mol, 2, seed=1)
        assert np.ptp(positions(made)[0][:, 2]) > 0.5


def test_a_relaxed_start_gives_all_conformers_the_bonds_of_a_minimum():
    mol = Chem.MolFromSmiles("C[C@H](O)CCN")
    minimum = embedded("C[C@H](O)CCN")
    AllChem.MMFFOptimizeMolecule(minimum, "MMFF94s")
    first, second = np.array(
        [(bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()) for bond in minimum.GetBonds()]
    ).T

    def lengths(mol):
        found = positions(mol)
        return np.linalg.norm(found[:, first] - found[:, second], axis=2)

    off = {}
    for relax in (False, True):
        made = ragdoll.conformers(mol, 4, seed=1, relax_start=relax)
        assert Chem.MolToSmiles(Chem.RemoveHs(made)) == Chem.CanonSmiles("C[C@H](O)CCN")
        off[relax] = np.sqrt(((lengths(made) - lengths(minimum)) ** 2).mean(axis=1))
    assert off[True].max() < 0.004
    assert off[False].min() > 2 * off[True].max()


def test_a_given_start_can_be_left_aside():
    mol = embedded("CCCCO", seed=5)
    fresh = ragdoll.conformers(Chem.RemoveHs(mol), 3, seed=1, start="embed")
    bare = ragdoll.conformers(Chem.MolFromSmiles("CCCCO"), 3, seed=1)
    assert np.allclose(positions(fresh), positions(bare))


def test_flat_molecules_in_three_dimensions_are_starts_too():
    made = ragdoll.conformers(embedded("c1ccccc1"), 1)
    assert made.GetNumConformers() == 1
    water = ragdoll.conformers(embedded("O"), 1)
    assert water.GetNumAtoms() == 3


@pytest.mark.parametrize("smiles", ["C[C@H](O)[C@@H](F)Cl", "F/C=C/[C@H](C)O", "F/C=C\\CCC"])
@pytest.mark.parametrize("minimize", [None, "mmff94s"])
def test_the_configuration_is_kept(smiles, minimize):
    made = ragdoll.conformers(Chem.MolFromSmiles(smiles), 6, seed=2, minimize=minimize)
    assert made.GetNumConformers() == 6
    wanted = Chem.CanonSmiles(smiles)
    for conformer in made.GetConformers():
        copy = Chem.Mol(made, False, conformer.GetId())
        Chem.AssignStereochemistryFrom3D(copy)
        assert Chem.MolToSmiles(Chem.RemoveHs(copy)) == wanted


def test_a_configuration_that_is_not_given_is_one_for_all_and_told():
    made = ragdoll.conformers(Chem.MolFromSmiles("CC(O)C(F)C=CC"), 6, seed=2)
    assert "configuration not given at 3" in made.GetProp("ragdoll_notes")
    found = set()
    for conformer in made.GetConformers():
        copy = Chem.Mol(made, False, conformer.GetId())
        Chem.AssignStereochemistryFrom3D(copy)
        found.add(Chem.MolToSmiles(Chem.RemoveHs(copy)))
    assert len(found) == 1


def test_minimised_conformers_are_ranked_within_the_window_and_not_alike():
    mol = Chem.MolFromSmiles("CCCCCO")
    with pytest.warns(UserWarning, match="of 40 conformers"):
        made = ragdoll.conformers(
            mol,
            40,
            seed=1,
            minimize="mmff94s",
            energy_window=2 * unit.kilocalorie_per_mole,
            prune_rmsd=0.3 * unit.angstrom,
        )
    energies = [c.GetDoubleProp("energy_kcal_mol") for c in made.GetConformers()]
    assert made.GetProp("ragdoll_energy") == "MMFF94s"
    assert len(energies) > 2
    assert energies == sorted(energies)
    assert energies[-1] - energies[0] <= 2
    assert min(heavy_rmsds(made)) >= 0.3
    properties = AllChem.MMFFGetMoleculeProperties(made, "MMFF94s")
    for conformer in made.GetConformers():
        field = AllChem.MMFFGetMoleculeForceField(made, properties, confId=conformer.GetId())
        energy = conformer.GetDoubleProp("energy_kcal_mol")
        assert field.CalcEnergy() == pytest.approx(energy, abs=1e-6)
        assert np.abs(field.CalcGrad()).max() < 0.1
    assert "energy window" in made.GetProp("ragdoll_reason")


def test_units_are_those_of_the_house_without_a_quantity():
    mol = Chem.MolFromSmiles("CCCCCO")
    plain = ragdoll.conformers(
        mol, 20, seed=1, minimize="uff", prune_rmsd=0.05, energy_window=8.368
    )
    quantity = ragdoll.conformers(
        mol,
        20,
        seed=1,
        minimize="uff",
        prune_rmsd=0.5 * unit.angstrom,
        energy_window=2 * unit.kilocalorie_per_mole,
    )
    assert np.array_equal(positions(plain), positions(quantity))
    assert plain.GetProp("ragdoll_energy") == "UFF"


def test_where_mmff_has_no_parameters_uff_does_it_and_that_is_said():
    made = ragdoll.conformers(Chem.MolFromSmiles("CC[SiH2]B(C)CC"), 3, seed=1, minimize="mmff94s")
    assert made.GetProp("ragdoll_energy") == "UFF"
    assert "no parameters" in made.GetProp("ragdoll_notes")


def test_a_rigid_molecule_has_one_conformer_and_the_reason_is_told():
    with pytest.warns(UserWarning, match="1 of 10 conformers"):
        made = ragdoll.conformers(Chem.MolFromSmiles("c1ccccc1"), 10, prune_rmsd=0.05)
    assert made.GetNumConformers() == 1
    assert made.GetProp("ragdoll_reason")


def test_pruning_takes_symmetric_atoms_into_account():
    made = ragdoll.conformers(Chem.MolFromSmiles("CC(C)(C)CCc1ccccc1"), 30, prune_rmsd=0.05)
    assert made.GetNumConformers() > 1
    assert min(heavy_rmsds(made)) >= 0.5 - 1e-3


def test_unbonded_parts_lie_side_by_side():
    made = ragdoll.conformers(Chem.MolFromSmiles("CC(=O)[O-].[Na+].C[NH3+]"), 3, seed=1)
    parts = Chem.GetMolFrags(made)
    for places in positions(made):
        for part in parts:
            others = [k for k in range(len(places)) if k not in part]
            gaps = np.linalg.norm(places[list(part)][:, None] - places[others], axis=-1)
            assert gaps.min() > 1.5


def test_the_largest_part_can_be_taken_alone():
    mol = Chem.MolFromSmiles("[Na+].CC(=O)[O-].[Cl-]")
    made = ragdoll.conformers(mol, 2, fragments="largest")
    assert Chem.MolToSmiles(Chem.RemoveHs(made)) == "CC(=O)[O-]"
    assert "left out: [Na+].[Cl-]" in made.GetProp("ragdoll_notes")


@pytest.mark.parametrize(
    "smiles",
    ["[H][H]", "[He]", "[Fe]", "[H+]", "O", "C#C", "C[CH2]", "[2H]C([2H])([2H])O", "[C-]#[O+]"]
    + ["[Fe+2].c1cc[cH-]c1.c1cc[cH-]c1", "N[Pt](N)(Cl)Cl", "F[P-](F)(F)(F)(F)F", "C=C=C", "[U]"],
)
def test_odd_molecules_have_conformers(smiles):
    mol = Chem.MolFromSmiles(smiles)
    made = ragdoll.conformers(mol, 2, seed=1)
    assert made.GetNumConformers() >= 1
    assert np.isfinite(positions(made)).all()
    assert Chem.MolToSmiles(Chem.RemoveHs(made)) == Chem.MolToSmiles(Chem.RemoveHs(mol))


@pytest.mark.parametrize(
    "smiles, words", [("*CC*", "has no element"), ("C" * 2000, "more than 5000")]
)
def test_what_cannot_be_done_is_refused_with_the_reason(smiles, words):
    mol = Chem.MolFromSmiles(smiles)
    mol.SetProp("_Name", "mine")
    with pytest.raises(ragdoll.InputError, match=f"^mine: .*{words}"):
        ragdoll.conformers(mol, 2)


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"n": 0}, "--count"),
        ({"n": -1}, "--count"),
        ({"prune_rmsd": float("nan")}, "--rmsd-prune-angstrom"),
        ({"prune_rmsd": -0.1}, "--rmsd-prune-angstrom"),
        ({"energy_window": 0.0}, "--energy-window-kcal"),
        ({"energy_window": float("nan")}, "--energy-window-kcal"),
        ({"minimize": "amber"}, "--minimize"),
        ({"start": "dream"}, "--start"),
        ({"fragments": "some"}, "--fragments"),
        ({"seed": -1}, "--seed"),
        ({"seconds": 0}, "--seconds-per-molecule"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(arguments, words):
    with pytest.raises(ragdoll.InputError, match=words):
        ragdoll.conformers(Chem.MolFromSmiles("CCO"), **arguments)


def test_places_that_are_no_numbers_or_coincide_are_refused():
    mol = embedded("CCO")
    mol.GetConformer().SetAtomPosition(0, [float("nan"), 0, 0])
    with pytest.raises(ragdoll.InputError, match="no numbers"):
        ragdoll.conformers(mol, 2)
    mol = embedded("CCO")
    mol.GetConformer().SetAtomPosition(
        0, list(np.array(mol.GetConformer().GetAtomPosition(1)) + 0.1)
    )
    with pytest.raises(ragdoll.InputError, match="in one place"):
        ragdoll.conformers(mol, 2)


def test_what_is_no_molecule_is_refused():
    with pytest.raises(ragdoll.InputError, match="RDKit molecule"):
        ragdoll.conformers("CCO", 2)
    with pytest.raises(ragdoll.InputError, match="no atoms"):
        ragdoll.conformers(Chem.Mol(), 2)


def test_where_sampling_finds_nothing_the_start_is_given(monkeypatch):
    def nothing(mol, **options):
        return {"positions": np.empty((0, 9, 3)), "energies": np.empty(0), "reason": "All clash."}

    monkeypatch.setattr(conforming, "sample", nothing)
    with pytest.warns(UserWarning, match="the start alone: All clash"):
        made = ragdoll.conformers(Chem.MolFromSmiles("CCO"), 2)
    assert made.GetNumConformers() == 1
    made = ragdoll.conformers(Chem.MolFromSmiles("CCO"), 1, minimize="uff")
    assert made.GetNumConformers() == 1


def test_when_time_is_up_what_is_minimised_is_given(monkeypatch):
    now = [0.0]

    class Clock:
        @staticmethod
        def monotonic():
            now[0] += 1.0
            return now[0]

    monkeypatch.setattr(conforming, "time", Clock)
    monkeypatch.setattr("ragdoll.batch.refining.time", Clock)
    monkeypatch.setattr("ragdoll.batch.starting.time", Clock)
    with pytest.warns(UserWarning, match="time was up"):
        made = ragdoll.conformers(
            Chem.MolFromSmiles("CCCCO"), 50, minimize="uff", seconds=20 * unit.second
        )
    assert 1 <= made.GetNumConformers() < 50


def test_seeds_of_records_are_cores():
    assert len({conforming.record_seed(seed, k) for seed in range(10) for k in range(100)}) == 1000
    assert conforming.record_seed(1, 2) == conforming.record_seed(1, 2) < 2**63


@pytest.mark.parametrize(
    "smiles",
    [
        "C" * 130,
        "N" + "[C@@H](C)C(=O)N" * 30 + "C",
        "N" + "[C@H](Cc1ccc(O)cc1)C(=O)N" * 12 + "C",
        "CC/C=C\\CCC/C=C/C" * 12,
        "OC[C@H]1O[C@@H](OC)[C@H](O)[C@@H](O)[C@@H]1O" + "C" * 100 + ".[Na+].[Cl-]",
    ],
)
def test_large_molecules_start_from_pieces(smiles):
    mol = Chem.MolFromSmiles(smiles)
    full, notes = place(mol, "input", seed=1, seconds=60)
    assert "joined from pieces that were embedded" in notes
    found = full.GetConformer().GetPositions()
    copy = Chem.Mol(full)
    Chem.AssignStereochemistryFrom3D(copy)
    assert Chem.MolToSmiles(Chem.RemoveHs(copy)) == Chem.CanonSmiles(smiles)
    gaps = np.linalg.norm(found[:, None] - found, axis=-1)
    ideal = {("C", "C"): (1.2, 1.65), ("C", "H"): (0.95, 1.2), ("C", "N"): (1.2, 1.6)}
    bonded = np.zeros_like(gaps, dtype=bool)
    for bond in full.GetBonds():
        i, j = bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()
        bonded[i, j] = bonded[j, i] = True
        kind = tuple(sorted((bond.GetBeginAtom().GetSymbol(), bond.GetEndAtom().GetSymbol())))
        low, high = ideal.get(kind, (0.9, 1.7))
        assert low < gaps[i, j] < high, (kind, gaps[i, j])
    gaps[bonded] = np.inf
    np.fill_diagonal(gaps, np.inf)
    assert gaps.min() > 0.9
    again, _ = place(mol, "input", seed=1, seconds=60)
    assert np.array_equal(again.GetConformer().GetPositions(), found)


def test_what_rdkit_logs_is_left_as_it_was():
    try:
        for switch in (rdBase.DisableLog, rdBase.EnableLog):
            switch("rdApp.error")
            before = rdBase.LogStatus()
            ragdoll.conformers(Chem.MolFromSmiles("CCO"), 2)
            assert rdBase.LogStatus() == before
    finally:
        rdBase.EnableLog("rdApp.error")
