"""Complexes: ligands of files and SMILES, their bonds, and what stays where it is."""

import gzip
import json
from dataclasses import replace

import numpy as np
import pytest
from rdkit import Chem
from rdkit.Chem import AllChem

import ragdoll
from ragdoll.constraint_options import ConstraintOptions
from ragdoll.errors import InputError
from ragdoll.molecule import Molecule
from ragdoll.user_constraints import UserConstraint, fixed_atoms

SINGLE, DOUBLE, TRIPLE, AROMATIC = 1, 2, 3, 4
PERTURBATIONS = ("thermal", "gaussian", "ball", "momentum", "hinge", "modes", "away", "steer")


def embedded(mol, seed=7):
    mol = Chem.AddHs(mol, addResidueInfo=True)
    assert AllChem.EmbedMolecule(mol, randomSeed=seed) == 0
    AllChem.MMFFOptimizeMolecule(mol)
    return mol


def from_smiles(smiles, hydrogens=True):
    mol = embedded(Chem.MolFromSmiles(smiles))
    return mol if hydrogens else Chem.RemoveHs(mol)


def places(mol):
    return mol.GetConformer().GetPositions()


def moved_to(mol, points):
    mol = Chem.Mol(mol)
    for k, point in enumerate(np.asarray(points).tolist()):
        mol.GetConformer().SetAtomPosition(k, point)
    return mol


def shifted(mol, *by):
    return moved_to(mol, places(mol) + np.array(by))


def without(mol, dropped):
    rest = Chem.RWMol(mol)
    for index in sorted(dropped, reverse=True):
        rest.RemoveAtom(index)
    return rest.GetMol()


def light(mol):
    return [atom.GetIdx() for atom in mol.GetAtoms() if atom.GetAtomicNum() == 1]


def write_protein(mol, path):
    """A PDB file without a record of bonds."""
    lines = Chem.MolToPDBBlock(mol, flavor=2).splitlines()
    path.write_text("\n".join(line for line in lines if line.startswith("ATOM")) + "\nEND\n")
    return path


def hetatm(mol, name, number=1, chain="B", serial=900):
    """The HETATM records of a molecule, atoms called by element and number."""
    counts, lines = {}, []
    for atom, place in zip(mol.GetAtoms(), places(mol), strict=True):
        symbol = atom.GetSymbol()
        counts[symbol] = counts.get(symbol, 0) + 1
        x, y, z = place
        lines.append(
            f"HETATM{serial + atom.GetIdx():5d}  {symbol + str(counts[symbol]):<4s}{name:>3s} "
            f"{chain}{number:4d}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00          {symbol:>2s}"
        )
    return lines


def write_sdf(mols, path):
    with Chem.SDWriter(str(path)) as writer:
        for mol in mols:
            writer.write(mol)
    return path


def bond_table(molecule, name):
    """Orders of the bonds within the residue of this name, by atom names."""
    atoms = list(molecule.topology.atoms())
    return {
        frozenset((atoms[i].name, atoms[j].name)): int(order)
        for (i, j), order in zip(molecule.bonds.tolist(), molecule.bond_orders, strict=True)
        if atoms[i].residue.name == atoms[j].residue.name == name
    }


def of_residue(molecule, name):
    return [atom.index for atom in molecule.topology.atoms() if atom.residue.name == name]


def neighbours(molecule, index):
    return sorted(
        molecule.labels[b if a == index else a]
        for a, b in molecule.bonds.tolist()
        if index in (a, b)
    )


@pytest.fixture(scope="module")
def peptide():
    """GACAG with all hydrogens."""
    return embedded(Chem.MolFromSequence("GACAG"))


@pytest.fixture(scope="module")
def bound(peptide):
    """N-methylacetamide whose oxygen takes the hydrogen of a peptide bond, posed by code."""
    ligand = from_smiles("CC(=O)NC")
    oxygen, carbon = 2, 1
    x = places(peptide)
    heavy = np.array([atom.GetAtomicNum() > 1 for atom in peptide.GetAtoms()])
    best = None
    for atom in peptide.GetAtoms():
        info = atom.GetPDBResidueInfo()
        if info.GetName().strip() != "N" or info.GetResidueNumber() == 1:
            continue
        hydrogen = next(n.GetIdx() for n in atom.GetNeighbors() if n.GetAtomicNum() == 1)
        axis = x[hydrogen] - x[atom.GetIdx()]
        axis /= np.linalg.norm(axis)
        own = places(ligand)
        line = own[carbon] - own[oxygen]
        for turn in np.linspace(0, 2 * np.pi, 24, endpoint=False):
            pose = (own - own[oxygen]) @ turned(line, axis, turn).T + x[atom.GetIdx()] + 2.9 * axis
            apart = np.linalg.norm(pose[:, None] - x[None], axis=2)
            apart[oxygen] = np.linalg.norm(pose[oxygen] - x[heavy & (np.arange(len(x)) >= 0)][:1])
            least = apart[[k for k in range(len(pose)) if k != oxygen]].min()
            if best is None or least > best[0]:
                best = (least, pose)
    assert best[0] > 2.2
    return moved_to(ligand, best[1])


def turned(first, second, angle):
    """A rotation that brings one direction to another, then turns about that."""
    a, b = first / np.linalg.norm(first), second / np.linalg.norm(second)
    v, c = np.cross(a, b), a @ b
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    align = np.eye(3) + k + k @ k / (1 + c) if c > -0.999 else np.diag([1.0, -1.0, -1.0])
    w = np.array([[0, -b[2], b[1]], [b[2], 0, -b[0]], [-b[1], b[0], 0]])
    return (np.eye(3) + np.sin(angle) * w + (1 - np.cos(angle)) * w @ w) @ align


@pytest.fixture(scope="module")
def protein_file(peptide, tmp_path_factory):
    return write_protein(peptide, tmp_path_factory.mktemp("complex") / "protein.pdb")


@pytest.fixture(scope="module")
def bare_protein_file(peptide, tmp_path_factory):
    return write_protein(
        without(peptide, light(peptide)), tmp_path_factory.mktemp("complex") / "bare.pdb"
    )


@pytest.fixture(scope="module")
def ligand_file(bound, tmp_path_factory):
    return write_sdf([bound], tmp_path_factory.mktemp("complex") / "ligand.sdf")


# === Ligands of files


def test_a_posed_ligand_is_a_residue_in_a_chain_of_its_own(protein_file, ligand_file, bound):
    protein = Molecule.from_file(protein_file)
    molecule = Molecule.from_file(protein_file, ligands=ligand_file)
    own = of_residue(molecule, "LIG")
    assert own == list(range(len(protein), len(protein) + bound.GetNumAtoms()))
    residue = next(r for r in molecule.topology.residues() if r.name == "LIG")
    assert [r.name for r in residue.chain.residues()] == ["LIG"]
    assert residue.chain.id not in {chain.id for chain in protein.topology.chains()}
    np.testing.assert_allclose(molecule.positions[own], places(bound) / 10, atol=1e-5)
    np.testing.assert_array_equal(molecule.positions[: len(protein)], protein.positions)


@pytest.mark.parametrize(
    "smiles",
    ["C[N+](C)(C)CC([O-])=O", "N#Cc1cc[nH]c1", "OP([O-])(=O)OCC#C", "c1ccc2[nH]ccc2c1", "CS(C)=O"],
)
def test_bonds_orders_and_charges_are_those_of_the_file(smiles, protein_file, tmp_path):
    mol = from_smiles(smiles)
    mol = shifted(mol, 25.0, 0, 0)
    alone = Molecule.from_rdkit(mol)
    molecule = Molecule.from_file(protein_file, ligands=write_sdf([mol], tmp_path / "a.sdf"))
    own = np.array(of_residue(molecule, "LIG"))
    inside = np.isin(molecule.bonds, own).all(axis=1)
    np.testing.assert_array_equal(molecule.bonds[inside] - own[0], alone.bonds)
    np.testing.assert_array_equal(molecule.bond_orders[inside], alone.bond_orders)
    np.testing.assert_array_equal(molecule.charges[own], alone.charges)


def test_a_mol2_file_gives_the_names_of_its_atoms(protein_file, tmp_path):
    path = tmp_path / "ethanol.mol2"
    path.write_text(
        "@<TRIPOS>MOLECULE\nEOH\n 3 2 1 0 0\nSMALL\nNO_CHARGES\n\n@<TRIPOS>ATOM\n"
        "1 CA1 30.000 0.000 0.000 C.3 1 EOH 0.0\n2 CB1 31.520 0.000 0.000 C.3 1 EOH 0.0\n"
        "3 OX1 32.000 1.350 0.000 O.3 1 EOH 0.0\n@<TRIPOS>BOND\n1 1 2 1\n2 2 3 1\n"
    )
    molecule = Molecule.from_file(protein_file, ligands=path)
    own = of_residue(molecule, "EOH")
    names = [atom.name for atom in molecule.topology.atoms() if atom.index in own]
    assert names[:3] == ["CA1", "CB1", "OX1"]
    assert len(own) == 9  # with the hydrogens, as the protein has them


def test_a_record_is_chosen_by_number_or_title_and_the_first_one_is_said(protein_file, tmp_path):
    mols = []
    for k, smiles in enumerate(("CO", "CCO", "CCCO")):
        mol = from_smiles(smiles)
        mol = shifted(mol, 30.0, 0, 0)
        mol.SetProp("_Name", f"mol_{k}")
        mols.append(mol)
    path = write_sdf(mols, tmp_path / "three.sdf")
    counts = [
        len(of_residue(Molecule.from_file(protein_file, ligands=f"{path}{which}"), "LIG"))
        for which in ("", ":2", ":mol_2")
    ]
    assert counts == [6, 9, 12]
    notes = Molecule.from_file(protein_file, ligands=path).notes
    assert any("3 records; the first, mol_0, was read" in note for note in notes)
    zipped = tmp_path / "three.sdf.gz"
    zipped.write_bytes(gzip.compress(path.read_bytes()))
    assert len(of_residue(Molecule.from_file(protein_file, ligands=f"{zipped}:2"), "LIG")) == 9


def test_several_ligands_have_chains_of_their_own(protein_file):
    one, other = from_smiles("CO"), from_smiles("CCO")
    one, other = shifted(one, 30, 0, 0), shifted(other, 0, 30, 0)
    molecule = Molecule.from_file(protein_file, ligands=[one, other])
    chains = [r.chain.id for r in molecule.topology.residues() if r.name == "LIG"]
    assert len(set(chains)) == 2


def test_a_ligand_takes_the_place_of_the_residue_that_is_there(peptide, bound, tmp_path):
    path = write_protein(peptide, tmp_path / "p.pdb")
    text = path.read_text().replace("END\n", "")
    crystal = without(bound, light(bound))
    far = shifted(crystal, 30, 0, 0)
    lines = hetatm(crystal, "OLD", 7) + hetatm(far, "OLD", 8, serial=950)
    path.write_text(text + "\n".join(lines) + "\nEND\n")
    molecule = Molecule.from_file(path, ligands=bound)
    assert any("takes the place of OLD7 B" in note for note in molecule.notes)
    residues = [(r.name, r.id, r.chain.id, len(r)) for r in molecule.topology.residues()][5:]
    # the other copy stays; what came has the name of the same molecule that was there
    assert residues == [("OLD", "8", "B", 5), ("OLD", "7", "B", bound.GetNumAtoms())]


def test_a_molecule_is_joined_with_its_ligand(protein_file, ligand_file):
    read = Molecule.from_file(protein_file, ligands=ligand_file)
    joined = Molecule.from_file(protein_file).joined(ligand_file)
    np.testing.assert_array_equal(joined.bonds, read.bonds)
    np.testing.assert_array_equal(joined.bond_orders, read.bond_orders)
    np.testing.assert_array_equal(joined.charges, read.charges)
    np.testing.assert_allclose(joined.positions, read.positions, atol=1e-12)
    assert joined.labels == read.labels


# === SMILES over residues of the file


@pytest.mark.parametrize(
    "smiles",
    ["CC(=O)Oc1ccccc1C([O-])=O", "C[C@H](N)C(=O)NCc1ccncc1", "O=[N+]([O-])c1ccc(C#N)cc1",
     "CC(C)(C)OC(=O)N1CCOCC1", "NC(=[NH2+])c1ccccc1"],
)  # fmt: skip
@pytest.mark.parametrize("hydrogens", [True, False])
def test_a_smiles_gives_a_residue_its_bonds(smiles, hydrogens, bare_protein_file, tmp_path):
    mol = from_smiles(smiles, hydrogens)
    mol = shifted(mol, 25.0, 0, 0)
    path = tmp_path / "complex.pdb"
    lines = hetatm(mol, "LGA") + hetatm(shifted(mol, 0, 25, 0), "LGA", 2)
    text = bare_protein_file.read_text().replace("END\n", "")
    path.write_text(text + "\n".join(lines) + "\nEND\n")
    molecule = Molecule.from_file(path, ligand_smiles={"lga": smiles})
    truth = Molecule.from_rdkit(mol)
    for copy in ("1", "2"):
        own = np.array(
            [
                atom.index
                for atom in molecule.topology.atoms()
                if atom.residue.name == "LGA" and atom.residue.id == copy
            ]
        )
        inside = np.isin(molecule.bonds, own).all(axis=1)
        np.testing.assert_array_equal(molecule.bonds[inside] - own[0], truth.bonds)
        found, given = molecule.bond_orders[inside], truth.bond_orders
        if "[O-])=O" in smiles or "[NH2+]" in smiles:  # either end may have the double bond
            found, given = np.sort(found), np.sort(given)
            assert sorted(molecule.charges[own]) == sorted(truth.charges)
        else:
            np.testing.assert_array_equal(molecule.charges[own], truth.charges)
        np.testing.assert_array_equal(found, given)


def complex_of(mol, protein, path, name="LGA"):
    text = protein.read_text().replace("END\n", "")
    path.write_text(text + "\n".join(hetatm(mol, name)) + "\nEND\n")
    return path


def test_hydrogens_are_placed_as_the_protein_has_them(protein_file, bare_protein_file, tmp_path):
    smiles = "OCC[NH+](C)C"
    mol = from_smiles(smiles, False)
    mol = shifted(mol, 25.0, 0, 0)
    counts = []
    for protein, add in ((bare_protein_file, False), (bare_protein_file, True), (protein_file, 0)):
        path = complex_of(mol, protein, tmp_path / "c.pdb")
        molecule = Molecule.from_file(path, ligand_smiles={"LGA": smiles}, add_hydrogens=bool(add))
        own = np.array(of_residue(molecule, "LGA"))
        counts.append(int((molecule.elements[own] == 1).sum()))
        assert molecule.charges[own].sum() == 1
    assert counts == [0, 12, 12]
    inside = molecule.bonds[np.isin(molecule.bonds, own).all(axis=1)]
    lengths = np.linalg.norm(
        molecule.positions[inside[:, 0]] - molecule.positions[inside[:, 1]], axis=1
    )
    assert lengths.min() > 0.09 and lengths.max() < 0.16


def test_the_pH_does_not_change_what_the_smiles_says(bare_protein_file, tmp_path):
    mol = from_smiles("CCN", False)
    path = complex_of(shifted(mol, 25, 0, 0), bare_protein_file, tmp_path / "c.pdb")
    molecule = Molecule.from_file(path, ligand_smiles={"LGA": "CCN"}, add_hydrogens=True)
    own = of_residue(molecule, "LGA")
    assert len(own) == 10 and molecule.charges[own].sum() == 0
    charged = Molecule.from_file(path, ligand_smiles={"LGA": "CC[NH3+]"}, add_hydrogens=True)
    own = of_residue(charged, "LGA")
    assert len(own) == 11 and charged.charges[own].sum() == 1


def test_hydrogens_of_the_file_say_how_an_acid_is_protonated(protein_file, tmp_path):
    mol = from_smiles("CCC(=O)[O-]")
    path = complex_of(shifted(mol, 25, 0, 0), protein_file, tmp_path / "c.pdb")
    molecule = Molecule.from_file(path, ligand_smiles={"LGA": "CCC(=O)O"})
    own = of_residue(molecule, "LGA")
    # the file has no hydrogen on N, O or S at all, so the SMILES decides
    assert len(own) == 11
    amine = from_smiles("OCC[NH3+]")
    path = complex_of(shifted(amine, 25, 0, 0), protein_file, tmp_path / "d.pdb")
    molecule = Molecule.from_file(path, ligand_smiles={"LGA": "OCCN"})
    own = of_residue(molecule, "LGA")
    assert len(own) == amine.GetNumAtoms() and molecule.charges[own].sum() == 1


def test_a_residue_that_lacks_atoms_still_matches(bare_protein_file, tmp_path):
    mol = from_smiles("CCCCc1ccc(C(=O)N)cc1", False)
    part = without(mol, [0, 1])
    path = complex_of(shifted(part, 25, 0, 0), bare_protein_file, tmp_path / "c.pdb")
    molecule = Molecule.from_file(path, ligand_smiles={"LGA": "CCCCc1ccc(C(=O)N)cc1"})
    assert any("lacks 2 of the 13 heavy atoms" in note for note in molecule.notes)
    orders = sorted(bond_table(molecule, "LGA").values())
    assert orders == [SINGLE] * 4 + [DOUBLE] + [AROMATIC] * 6


def test_a_smiles_whose_hand_is_another_is_said_and_the_coordinates_stay(
    bare_protein_file, tmp_path
):
    mol = from_smiles("C[C@H](O)c1ccccc1", False)
    path = complex_of(shifted(mol, 25, 0, 0), bare_protein_file, tmp_path / "c.pdb")
    good = Molecule.from_file(path, ligand_smiles={"LGA": "C[C@H](O)c1ccccc1"})
    assert not any("other hand" in note for note in good.notes)
    bad = Molecule.from_file(path, ligand_smiles={"LGA": "C[C@@H](O)c1ccccc1"})
    assert any("1 of 1 centres have the other hand" in note for note in bad.notes)
    np.testing.assert_array_equal(good.positions, bad.positions)


# === Polar contacts


def cross_bonds(molecule, framework, name="LIG"):
    own = set(of_residue(molecule, name))
    return [
        (molecule.labels[donor].split()[0], molecule.labels[acceptor].split()[0])
        for donor, _, acceptor in framework.hydrogen_bonds
        if (donor in own) != (acceptor in own)
    ]


@pytest.mark.parametrize("protein_has", [True, False])
@pytest.mark.parametrize("ligand_has", [True, False])
def test_a_hydrogen_bond_of_the_ligand_is_held(
    protein_has, ligand_has, protein_file, bare_protein_file, bound
):
    ligand = bound if ligand_has else Chem.RemoveHs(bound)
    molecule = Molecule.from_file(
        protein_file if protein_has else bare_protein_file, ligands=ligand
    )
    framework = ragdoll.build_framework(molecule, constraints=ConstraintOptions())
    assert ("N", "O1") in cross_bonds(molecule, framework)


@pytest.fixture(scope="module")
def sampled_complex(protein_file, ligand_file, tmp_path_factory):
    molecule = Molecule.from_file(protein_file, ligands=ligand_file)
    path = tmp_path_factory.mktemp("complex") / "frames.h5"
    options = ragdoll.SampleOptions(frames=6, stride=5, perturbation="momentum", seed=4)
    report = ragdoll.sample(molecule, path, options)
    assert report.frames == 6
    return molecule, path


def test_frames_keep_the_ligand_and_its_hydrogen_bond(sampled_complex, bound):
    molecule, path = sampled_complex
    own = of_residue(molecule, "LIG")
    framework = ragdoll.build_framework(molecule, constraints=ConstraintOptions())
    held = framework.tether_kinds == 1
    pairs, bounds = framework.tethers[held], framework.tether_lengths[held]
    across = np.isin(pairs, own).sum(axis=1) == 1
    assert across.any()
    bonds = [(b.GetBeginAtomIdx(), b.GetEndAtomIdx()) for b in bound.GetBonds()]

    def lengths(x):
        return np.array([np.linalg.norm(x[i] - x[j]) for i, j in bonds])

    with ragdoll.open_trajectory(path) as trajectory:
        for frame in trajectory:
            x = frame.positions.astype(float)
            apart = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
            assert (apart[across] <= bounds[across] + 1e-6).all()
            assert np.abs(lengths(10 * x[own]) / lengths(places(bound)) - 1).max() < 0.0101
            assert np.linalg.norm(x - molecule.positions, axis=1).max() > 0.02


def test_stacked_rings_and_non_polar_contacts_of_a_ligand_are_held(tmp_path):
    tyrosine = embedded(Chem.MolFromSequence("AFA"))
    ring = [
        atom.GetIdx()
        for atom in tyrosine.GetAtoms()
        if atom.GetPDBResidueInfo().GetName().strip() in ("CG", "CD1", "CD2", "CE1", "CE2", "CZ")
    ]
    x = places(tyrosine)
    centre = x[ring].mean(axis=0)
    normal = np.linalg.svd(x[ring] - centre)[2][2]
    rest = np.delete(x, ring, axis=0)
    benzene = from_smiles("c1ccccc1")
    own = places(benzene) - places(benzene)[:6].mean(axis=0)
    rotation = turned(np.linalg.svd(own[:6])[2][2], normal, 0.0)
    poses = [own @ rotation.T + centre + sign * 3.7 * normal for sign in (1, -1)]
    pose = max(poses, key=lambda pose: np.linalg.norm(pose[:, None] - rest[None], axis=2).min())
    path = write_protein(tyrosine, tmp_path / "p.pdb")
    molecule = Molecule.from_file(path, ligands=moved_to(benzene, pose))
    ligand = of_residue(molecule, "LIG")

    def kinds(**options):
        options = ConstraintOptions(**options)
        framework = ragdoll.build_framework(molecule, constraints=options)
        across = np.isin(framework.tethers, ligand).sum(axis=1) == 1
        return framework.tether_kinds[across].tolist()

    assert 3 in kinds()
    assert kinds(hydrophobic=False) == [4, 4, 4]


# === Covalent ligands


@pytest.fixture(scope="module")
def adduct(peptide):
    """Cysteine with N-benzylacrylamide bound to it: the peptide, the ligand, and the whole."""
    bare = Chem.MolFromSequence("GACAG")
    sulfur = next(
        a.GetIdx() for a in bare.GetAtoms() if a.GetPDBResidueInfo().GetName().strip() == "SG"
    )
    count = bare.GetNumAtoms()
    both = Chem.RWMol(Chem.CombineMols(bare, Chem.MolFromSmiles("CCC(=O)NCc1ccccc1")))
    both.AddBond(sulfur, count, Chem.BondType.SINGLE)
    Chem.SanitizeMol(both)
    whole = embedded(both.GetMol())
    heavy = whole.GetNumAtoms() - len(light(whole))
    ours = {
        a.GetIdx()
        for a in whole.GetAtoms()
        if (a.GetIdx() if a.GetAtomicNum() > 1 else a.GetNeighbors()[0].GetIdx()) < count
    }
    assert heavy == count + 12
    protein = without(whole, set(range(whole.GetNumAtoms())) - ours)
    ligand = Chem.RWMol(without(whole, ours))
    for atom in ligand.GetAtoms():
        atom.SetNoImplicit(False)
    return protein, ligand.GetMol(), whole


def sulfur_of(molecule):
    return next(k for k, label in enumerate(molecule.labels) if label.startswith("SG "))


@pytest.mark.parametrize("protein_has", [True, False])
@pytest.mark.parametrize("ligand_has", [True, False])
def test_a_ligand_at_the_distance_of_a_bond_is_bonded(adduct, protein_has, ligand_has, tmp_path):
    protein, ligand, whole = adduct
    path = write_protein(
        protein if protein_has else without(protein, light(protein)), tmp_path / "p.pdb"
    )
    sdf = write_sdf([ligand if ligand_has else Chem.RemoveHs(ligand)], tmp_path / "l.sdf")
    molecule = Molecule.from_file(path, ligands=sdf, add_hydrogens=not protein_has)
    assert neighbours(molecule, sulfur_of(molecule)) == ["C1 LIG1 L", "CB CYS3 A"]
    assert any("Covalent bond by distance: C1 of LIG1 L - SG of CYS3" in n for n in molecule.notes)
    # no hydrogen too many, none too few
    own = np.array(of_residue(molecule, "LIG"))
    assert (molecule.elements[own] == 1).sum() == 12
    assert len(molecule) == whole.GetNumAtoms()


def test_the_hydrogen_of_a_cysteine_leaves_for_the_bond(peptide, adduct, tmp_path):
    protein, ligand, whole = adduct
    sulfur = next(a for a in protein.GetAtoms() if a.GetPDBResidueInfo().GetName().strip() == "SG")
    rest = Chem.RWMol(protein)
    index = rest.AddAtom(Chem.Atom(1))
    place = places(protein)[sulfur.GetIdx()] + np.array([0, 0, 1.34])
    info = Chem.AtomPDBResidueInfo(" HG ", 99, residueName="CYS", residueNumber=3, chainId="A")
    rest.GetAtomWithIdx(index).SetMonomerInfo(info)
    rest.GetConformer().SetAtomPosition(index, place.tolist())
    path = write_protein(rest.GetMol(), tmp_path / "p.pdb")
    assert " HG  CYS" in path.read_text()
    molecule = Molecule.from_file(path, ligands=ligand)
    assert neighbours(molecule, sulfur_of(molecule)) == ["C1 LIG1 L", "CB CYS3 A"]
    assert any("there left: HG of CYS3 A" in note for note in molecule.notes)


@pytest.mark.parametrize("smiles", ["C=CC(=O)NCc1ccccc1", "CCC(=O)NCc1ccccc1"])
def test_the_smiles_of_a_covalent_ligand_may_be_that_of_its_warhead(adduct, smiles, tmp_path):
    protein, ligand, whole = adduct
    bare = write_protein(without(protein, light(protein)), tmp_path / "p.pdb")
    path = complex_of(Chem.RemoveHs(ligand), bare, tmp_path / "c.pdb")
    molecule = Molecule.from_file(path, ligand_smiles={"LGA": smiles}, add_hydrogens=True)
    assert neighbours(molecule, sulfur_of(molecule)) == ["C1 LGA1 B", "CB CYS3 A"]
    table = bond_table(molecule, "LGA")
    assert table[frozenset(("C1", "C2"))] == SINGLE
    assert (molecule.elements[of_residue(molecule, "LGA")] == 1).sum() == 12


def test_a_covalent_ligand_without_flags_is_bonded_and_said(adduct, tmp_path):
    protein, ligand, _ = adduct
    bare = write_protein(without(protein, light(protein)), tmp_path / "p.pdb")
    path = complex_of(Chem.RemoveHs(ligand), bare, tmp_path / "c.pdb")
    molecule = Molecule.from_file(path, add_hydrogens=True)
    assert neighbours(molecule, sulfur_of(molecule)) == ["C1 LGA1 B", "CB CYS3 A"]
    assert any("C1 of LGA1 B" in n and "by distance" in n for n in molecule.notes)


@pytest.mark.parametrize(
    "text", ["A:CYS3:SG=LIG:C1", "LIG1:C1=3:SG", "name SG; resname LIG and name C1"]
)
def test_a_bond_is_made_as_asked(adduct, text, tmp_path):
    protein, ligand, _ = adduct
    # pulled away, so that its distance tells nothing
    away = places(ligand)
    sulfur = next(
        a.GetIdx() for a in protein.GetAtoms() if a.GetPDBResidueInfo().GetName().strip() == "SG"
    )
    line = away[0] - places(protein)[sulfur]
    pulled = moved_to(ligand, away + 0.5 * line / np.linalg.norm(line))
    path = write_protein(protein, tmp_path / "p.pdb")
    loose = Molecule.from_file(path, ligands=pulled)
    assert neighbours(loose, sulfur_of(loose)) == ["CB CYS3 A"]
    bonded = Molecule.from_file(path, ligands=pulled, covalent_bonds=text)
    assert neighbours(bonded, sulfur_of(bonded)) == ["C1 LIG1 L", "CB CYS3 A"]


@pytest.mark.parametrize("kind", ["pdb", "cif"])
@pytest.mark.parametrize("smiles", [None, {"LGA": "CCC(=O)NCc1ccccc1"}])
def test_a_recorded_bond_is_made_where_the_distance_alone_tells_nothing(
    adduct, kind, smiles, tmp_path
):
    import gemmi

    protein, ligand, _ = adduct
    bare = Chem.RemoveHs(ligand)
    sulfur = next(
        a.GetIdx() for a in protein.GetAtoms() if a.GetPDBResidueInfo().GetName().strip() == "SG"
    )
    line = places(bare)[0] - places(protein)[sulfur]
    pulled = shifted(bare, *(0.5 * line / np.linalg.norm(line)))
    rest = write_protein(without(protein, light(protein)), tmp_path / "p.pdb")
    text = complex_of(pulled, rest, tmp_path / "c.pdb").read_text()
    link = link_record((" SG", "CYS", "A", 3), (" C1", "LGA", "B", 1))
    path = tmp_path / f"complex.{kind}"
    path.write_text(link + "\n" + text)
    if kind == "cif":
        structure = gemmi.read_pdb_string(link + "\n" + text)
        structure.setup_entities()
        path.write_text(structure.make_mmcif_document().as_string())
    loose = Molecule.from_file(tmp_path / "c.pdb", ligand_smiles=smiles)
    assert neighbours(loose, sulfur_of(loose)) == ["CB CYS3 A"]
    bonded = Molecule.from_file(path, ligand_smiles=smiles)
    assert [label.split()[0] for label in neighbours(bonded, sulfur_of(bonded))] == ["C1", "CB"]
    assert any("record" in note for note in bonded.notes)


def test_frames_keep_the_bond_its_angles_and_its_hands(adduct, tmp_path):
    protein, ligand, _ = adduct
    path = write_protein(protein, tmp_path / "p.pdb")
    molecule = Molecule.from_file(path, ligands=ligand)
    options = ragdoll.SampleOptions(frames=4, stride=5, seed=2)
    ragdoll.sample(molecule, tmp_path / "c.h5", options)
    labels = [label.split()[:2] for label in molecule.labels]
    cb, sg = labels.index(["CB", "CYS3"]), labels.index(["SG", "CYS3"])
    c1, c2 = labels.index(["C1", "LIG1"]), labels.index(["C2", "LIG1"])

    def angle(x, a, b, c):
        u, v = x[a] - x[b], x[c] - x[b]
        return np.degrees(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v)))

    x0 = molecule.positions
    with ragdoll.open_trajectory(tmp_path / "c.h5") as trajectory:
        for frame in trajectory:
            x = frame.positions.astype(float)
            assert np.linalg.norm(x[sg] - x[c1]) == pytest.approx(
                np.linalg.norm(x0[sg] - x0[c1]), rel=0.0101
            )
            for three in ((cb, sg, c1), (sg, c1, c2)):
                assert angle(x, *three) == pytest.approx(angle(x0, *three), abs=3.5)


# === What stays where it is


@pytest.mark.parametrize("perturbation", PERTURBATIONS)
@pytest.mark.parametrize("replicas", [None, 3])
def test_fixed_atoms_keep_their_bits(perturbation, replicas, sampled_complex, tmp_path):
    molecule, _ = sampled_complex
    user = (UserConstraint("move", "resname LIG or resid 1:2"),)
    steer = ("resname LIG; 0 0 0.1",) if perturbation == "steer" else ()
    motion = ragdoll.MotionOptions(steer=steer, modes="1-3")
    options = ragdoll.SampleOptions(
        frames=2,
        stride=3,
        perturbation=perturbation,
        motion=motion,
        replicas=replicas,
        constraints=ConstraintOptions(user=user),
        allow_low_quality=True,
    )
    ragdoll.sample(molecule, tmp_path / "f.h5", options)
    fixed = fixed_atoms(molecule, user)
    assert 0 < len(fixed) < len(molecule)
    ligand = of_residue(molecule, "LIG")
    with ragdoll.open_trajectory(tmp_path / "f.h5") as trajectory:
        x = trajectory.positions[:]
    start = molecule.positions.astype(np.float32)
    assert (x[:, fixed] == start[fixed]).all()
    assert np.linalg.norm(x[-1, ligand] - start[ligand], axis=1).max() > 0.005


def test_move_is_the_opposite_of_fix(sampled_complex):
    molecule, _ = sampled_complex
    moving = fixed_atoms(molecule, (UserConstraint("move", "resname LIG"),))
    fixed = fixed_atoms(molecule, (UserConstraint("fix", "not resname LIG"),))
    assert moving == fixed == [k for k in range(len(molecule)) if "LIG" not in molecule.labels[k]]
    two = (UserConstraint("move", "resname LIG"), UserConstraint("move", "resid 3"))
    assert fixed_atoms(molecule, two) == fixed_atoms(
        molecule, (UserConstraint("move", "resname LIG or resid 3"),)
    )


def test_the_fixed_part_is_one_body_in_rigidity(sampled_complex):
    molecule, _ = sampled_complex
    free = ragdoll.rigidity(molecule)
    held = ragdoll.rigidity(molecule, fixed=(UserConstraint("fix", "resid 1:4"),))
    atoms = fixed_atoms(molecule, (UserConstraint("fix", "resid 1:4"),))
    assert len(set(free.cluster_of_body[atoms].tolist())) > 1
    assert len(set(held.cluster_of_body[atoms].tolist())) == 1
    assert held.floppy_modes < free.floppy_modes
    assert held.as_dict()["fixed_atoms"] == len(atoms)
    json.dumps(held.as_dict())


def test_rigidity_lists_the_hydrogen_bond_of_the_ligand(sampled_complex):
    molecule, _ = sampled_complex
    result = ragdoll.rigidity(molecule).as_dict()
    names = [entry["names"] for entry in result["hydrogen_bond_list"]]
    assert any(n[0].startswith("N ") and n[2].startswith("O1 LIG") for n in names)
    assert len(result["cluster_of_atom"]) == len(molecule)
    (ligand,) = result["ligands"]
    assert ligand["residue"] == "LIG1 L" and ligand["atoms"] == of_residue(molecule, "LIG")
    assert ligand["clusters"] == sorted({result["cluster_of_atom"][k] for k in ligand["atoms"]})
    held = [result["hydrogen_bond_list"][k]["names"] for k in ligand["hydrogen_bonds"]]
    assert held and all(any("LIG" in name for name in names) for names in held)
    dilution = ragdoll.dilution(molecule, fixed=(UserConstraint("fix", "resid 1:4"),))
    assert len(dilution) == len(dilution.bonds.hbonds) + 1


# === Paths


@pytest.fixture(scope="module")
def path_ends(sampled_complex):
    """The complex, and its last frame turned and shifted as a whole."""
    molecule, path = sampled_complex
    with ragdoll.open_trajectory(path) as trajectory:
        x = trajectory.positions[-1].astype(float)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    return molecule, replace(molecule, positions=x @ turn.T + 3.0, source="the end")


def laid(positions, over, atoms):
    from ragdoll.matching import rigid_move

    return rigid_move(positions[atoms], over[atoms])(positions)


def last_frame(path):
    with ragdoll.open_trajectory(path) as trajectory:
        return trajectory.positions[-1].astype(float)


def test_a_path_brings_the_ligand_to_its_place(path_ends, tmp_path):
    start, end = path_ends
    report = ragdoll.target(start, end, tmp_path / "p.h5")
    assert report.arrived
    x = last_frame(tmp_path / "p.h5")
    heavy = [k for k in range(len(start)) if start.elements[k] > 1]
    ligand = [k for k in of_residue(start, "LIG") if start.elements[k] > 1]
    off = (laid(x, end.positions, heavy) - end.positions)[ligand]
    before = (laid(start.positions, end.positions, heavy) - end.positions)[ligand]
    assert (off**2).sum() < 0.5 * (before**2).sum()


def test_ligands_match_by_their_bonds_whatever_their_names(path_ends, bound):
    from ragdoll.matching import match

    start, end = path_ends
    order = list(reversed(range(bound.GetNumAtoms())))
    own = of_residue(end, "LIG")
    other = moved_to(bound, 10 * end.positions[own])
    shuffled = Chem.RenumberAtoms(other, order)
    shuffled.SetProp("_Name", "XYZ")
    bare = replace_ligand(end, shuffled)
    pair = match(start, bare)
    assert pair.alone == ([], [])
    n = len(start) - len(own)
    pairs = dict(zip(pair.first.tolist(), pair.second.tolist(), strict=True))
    for k, atom in enumerate(own):
        if start.elements[atom] > 1:
            assert pairs[atom] == n + order.index(k)


def replace_ligand(molecule, ligand):
    """The same protein with another ligand."""
    keep = np.array(["LIG" not in label for label in molecule.labels])
    return without_ligand(molecule, keep).joined(ligand)


def without_ligand(molecule, keep):
    from ragdoll.selection import copy_topology
    from ragdoll.topology_bonds import add_bonds

    number = np.cumsum(keep) - 1
    inside = keep[molecule.bonds].all(axis=1)
    topology = copy_topology(molecule.topology, keep)
    add_bonds(topology, number[molecule.bonds[inside]], molecule.bond_orders[inside])
    return Molecule.from_topology(topology, molecule.positions[keep])


@pytest.mark.parametrize("whose", ["start", "end"])
def test_a_ligand_that_one_end_has_alone_is_no_hindrance(path_ends, whose, tmp_path):
    start, end = path_ends
    keep = np.array(["LIG" not in label for label in start.labels])
    if whose == "start":
        end = without_ligand(end, keep)
    else:
        start = without_ligand(start, keep)
    report = ragdoll.target(start, end, tmp_path / "p.h5")
    assert report.arrived
    words = "goes with what is around it" if whose == "start" else "was left out"
    assert any("LIG1 L" in note and words in note for note in report.notes)


def test_a_path_leaves_what_is_fixed(path_ends, tmp_path):
    start, _ = path_ends
    user = (UserConstraint("move", "resname LIG or resid 1:2"),)
    constraints = ConstraintOptions(user=user)
    options = ragdoll.SampleOptions(
        frames=3, stride=5, perturbation="momentum", seed=6, constraints=constraints,
        allow_low_quality=True,
    )  # fmt: skip
    ragdoll.sample(start, tmp_path / "s.h5", options)
    x = last_frame(tmp_path / "s.h5")
    turn = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    end = replace(start, positions=x @ turn.T - 2.0, source="the end")
    report = ragdoll.target(
        start, end, tmp_path / "p.h5", ragdoll.TargetOptions(constraints=constraints)
    )
    fixed = fixed_atoms(start, user)
    with ragdoll.open_trajectory(tmp_path / "p.h5") as trajectory:
        frames = trajectory.positions[:]
    assert (frames[:, fixed] == start.positions[fixed].astype(np.float32)).all()
    assert report.arrived
    # it is at the end's place without superposition
    moving = [a.index for a in start.topology.atoms() if a.name == "CA" and a.index not in fixed]
    off = np.linalg.norm(frames[-1][moving] - x[moving], axis=1)
    assert 10 * np.sqrt((off**2).mean()) <= 0.2


# === Refusals


def flat_sdf(path):
    mol = Chem.MolFromSmiles("CCO")
    AllChem.Compute2DCoords(mol)
    return write_sdf([mol], path)


def test_what_cannot_be_used_is_refused_in_one_sentence(
    run_many, protein_file, bare_protein_file, peptide, bound, tmp_path
):
    where = places(peptide)[[a.GetAtomicNum() > 1 for a in peptide.GetAtoms()]]
    inside = from_smiles("C1CCCCC1", False)
    shift = where[len(where) // 2] - places(inside).mean(axis=0)
    write_sdf([moved_to(inside, places(inside) + shift)], tmp_path / "inside.sdf")
    flat_sdf(tmp_path / "flat.sdf")
    (tmp_path / "broken.sdf").write_text("x\n\n\n  3  2 nonsense\n")
    zero = from_smiles("CCO", False)
    write_sdf([moved_to(zero, 0 * places(zero))], tmp_path / "zero.sdf")
    (tmp_path / "empty.sdf").write_text("")
    (tmp_path / "lig.pdb").write_text("END\n")
    write_sdf([bound], tmp_path / "good.sdf")
    far = from_smiles("CCO")
    write_sdf([shifted(far, 12, 0, 0)], tmp_path / "far.sdf")
    hexane = from_smiles("CCCCCC", False)
    crystal = complex_of(shifted(hexane, 25, 0, 0), bare_protein_file, tmp_path / "c.pdb")
    cases = [
        (["--ligand", tmp_path / "no.sdf"], "no.sdf cannot be read"),
        (["--ligand", tmp_path / "inside.sdf"], "overlaps .* are [0-9.]+ angstrom apart"),
        (["--ligand", tmp_path / "flat.sdf"], "flat"),
        (["--ligand", tmp_path / "broken.sdf"], "cannot be parsed"),
        (["--ligand", tmp_path / "zero.sdf"], "no coordinates"),
        (["--ligand", tmp_path / "empty.sdf"], "no record"),
        (["--ligand", tmp_path / "lig.pdb"], "give .sdf, .mol or .mol2"),
        (["--ligand", f"{tmp_path / 'good.sdf'}:7"], "no record 7; it has 1"),
        (["--ligand-smiles", "LGA"], "must be a residue name and a SMILES"),
        (["--ligand-smiles", "LGA=C1CC"], "cannot be parsed"),
        (["--ligand-smiles", "LGA=CF(C)C"], "no molecule that makes sense"),
        (["--ligand-smiles", "LGA=CCCCCO"], "LGA1 B: it has 6 heavy atoms .* residue 6"),
        (["--ligand-smiles", "XXX=CCO"], "no residue XXX; its ligands are LGA"),
        (["--ligand-smiles", "ALA=CCO"], "part of a chain"),
        (
            ["--ligand", tmp_path / "far.sdf", "--covalent-bond", "CYS3:SG=LIG:C1"],
            "angstrom apart, which is no bond",
        ),
        (["--covalent-bond", "CYS3:SG"], "must name two atoms"),
        (["--covalent-bond", "CYS3:SG=CYS3:CB"], "two atoms of one residue"),
        (["--covalent-bond", "CYS3:XX=ALA2:CB"], "matches no atom"),
        (["--covalent-bond", "ALA:CB=CYS3:SG"], "matches 2 atoms"),
        (["--covalent-bond", "nonsense x; name SG"], "no selection of atoms"),
        (["--fix", "all"], "selects all .* nothing could move"),
        (["--move", "all"], "selects all .* nothing would be fixed"),
        (["--move", "resname FOO"], "matches no atom"),
    ]
    runs = run_many(
        [
            ["sample", crystal, "-o", tmp_path / "o.h5", "--frames", "1", *flags]
            for flags, _ in cases
        ]
    )
    import re

    for (flags, words), run in zip(cases, runs, strict=True):
        assert run.code == 2, (flags, run.stderr)
        assert re.search(words, run.sentence), (flags, run.sentence)
    assert not (tmp_path / "o.h5").exists()


def test_a_ligand_with_five_bonds_at_a_carbon_is_refused(protein_file, tmp_path):
    block = Chem.MolToMolBlock(from_smiles("CC(C)(C)C", False))
    lines = block.splitlines()
    lines = [line.replace("  5  4", "  5  5") if "V2000" in line else line for line in lines]
    lines.insert(-1, "  2  3  2  0")
    del lines[-3]
    path = tmp_path / "bad.sdf"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match="parsed|makes sense"):
        Molecule.from_file(protein_file, ligands=path)


def test_the_commands_take_ligands(run_many, protein_file, ligand_file, tmp_path):
    flags = ["--ligand", ligand_file, "--json", "--quiet"]
    runs = run_many(
        [
            ["sample", protein_file, "-o", tmp_path / "a.h5", "--frames", "1", *flags],
            ["rigidity", protein_file, *flags, "--move", "resname LIG"],
            ["rigidity", protein_file, *flags, "--dilution"],
            ["modes", protein_file, *flags],
            ["prepare", protein_file, "-o", tmp_path / "p.pdb", *flags],
            ["target", protein_file, protein_file, "-o", tmp_path / "t.h5", *flags],
        ]
    )
    assert [run.code for run in runs[:5]] == [0] * 5, [run.stderr for run in runs]
    parameters = runs[0].json["parameters"]
    assert parameters["ligands"] == [str(ligand_file)]
    assert len(parameters["ligand_hashes"][0]) == 64
    assert runs[1].json["fixed_atoms"] > 0
    # the ends are the same: refused by that, not by a flag
    assert runs[5].code == 2 and "same conformation" in runs[5].sentence
    assert " LIG L   1 " in (tmp_path / "p.pdb").read_text()


# === Real complexes


@pytest.mark.parametrize("record", ["lig_ejm_31", "lig_jmc_28"])
def test_a_kinase_inhibitor_is_held_at_the_hinge(record, proteins):
    molecule = Molecule.from_file(
        proteins / "tyk2_protein.pdb", ligands=f"{proteins / 'tyk2_ligands.sdf'}:{record}"
    )
    framework = ragdoll.build_framework(molecule, constraints=ConstraintOptions())
    own = set(of_residue(molecule, "LIG"))
    found = {
        tuple(" ".join(molecule.labels[k].split()[:2]) for k in (donor, acceptor))
        for donor, _, acceptor in framework.hydrogen_bonds
        if (donor in own) != (acceptor in own)
    }
    assert {("N3 LIG1", "O VAL981"), ("N VAL981", "N2 LIG1")} <= found


def test_residues_of_the_file_take_their_smiles(proteins):
    molecule = Molecule.from_file(
        proteins / "181l.pdb", ligand_smiles={"BNZ": "c1ccccc1", "HED": "OCCSSCCO"}
    )
    assert sorted(bond_table(molecule, "BNZ").values()) == [AROMATIC] * 6
    assert sorted(bond_table(molecule, "HED").values()) == [SINGLE] * 7


def test_an_amino_acid_that_stands_alone_is_a_ligand(proteins):
    smiles = "[NH3+][C@@H](CCC(=O)[O-])C(=O)[O-]"
    molecule = Molecule.from_file(
        proteins / "1ewk.pdb.gz", chains="A", ligand_smiles={"GLU": smiles}
    )
    own = [
        a.index
        for a in molecule.topology.atoms()
        if a.residue.name == "GLU" and a.residue.id == "701"
    ]
    assert len(own) == 10 and molecule.charges[own].sum() == -1
    inside = np.isin(molecule.bonds, own).all(axis=1)
    assert np.bincount(molecule.bond_orders[inside]).tolist() == [0, 7, 2]


# === Metals and nucleic acids


def link_record(first, second):
    """A LINK record; each end is (atom name, residue name, chain, number)."""
    ends = [f"{atom:<4s} {name:>3s} {chain}{k:4d} " for atom, name, chain, k in (first, second)]
    return f"LINK        {ends[0]}               {ends[1]}     1555   1555  2.95"


@pytest.mark.parametrize("recorded", [True, False])
def test_a_recorded_bond_of_a_metal_is_a_bar(recorded, peptide, tmp_path):
    sulfur = next(
        a.GetIdx() for a in peptide.GetAtoms() if a.GetPDBResidueInfo().GetName().strip() == "SG"
    )
    x = places(peptide)
    outward = x[sulfur] - x.mean(axis=0)
    zinc = x[sulfur] + 2.95 * outward / np.linalg.norm(outward)
    path = write_protein(without(peptide, light(peptide)), tmp_path / "p.pdb")
    lines = path.read_text().replace("END\n", "").splitlines()
    lines.append(
        f"HETATM  900 ZN    ZN B   1    {zinc[0]:8.3f}{zinc[1]:8.3f}{zinc[2]:8.3f}"
        "  1.00  0.00          ZN"
    )
    if recorded:
        lines.insert(0, link_record((" SG", "CYS", "A", 3), ("ZN", "ZN", "B", 1)))
    path.write_text("\n".join(lines) + "\nEND\n")
    molecule = Molecule.from_file(path, keep_solvent=True)
    framework = ragdoll.build_framework(molecule, constraints=ConstraintOptions())
    metal = framework.bars[framework.bar_kinds == 3]
    assert len(metal) == int(recorded)
    assert len(molecule.coordination) == int(recorded)
    # it is no bond: there are no angles at the metal
    assert not (molecule.bonds == len(molecule) - 1).any()
    free = ConstraintOptions(metals=False)
    assert (ragdoll.build_framework(molecule, constraints=free).bar_kinds != 3).all()


def test_an_intercalator_is_stacked_between_bases(proteins):
    dna = Molecule.from_file(proteins / "1bna.pdb")
    atoms = list(dna.topology.atoms())
    ring = {"N1", "C2", "N3", "C4", "C5", "C6"}
    ends = [
        np.array([a.index for a in atoms if a.residue.index == step and a.name in ring])
        for step in (5, 6)
    ]
    # the duplex is opened by moving all that is above the sixth step up along the bases' normal
    x = 10 * dna.positions
    normal = np.linalg.svd(x[ends[0]] - x[ends[0]].mean(axis=0))[2][2]
    normal *= np.sign(normal @ (x[ends[1]].mean(axis=0) - x[ends[0]].mean(axis=0)))
    upper = np.array([6 <= a.residue.index < 18 for a in atoms])
    opened = x + 3.4 * upper[:, None] * normal
    dye = from_smiles("c1ccc2cc3ccccc3cc2c1")
    own = places(dye) - places(dye).mean(axis=0)
    middle = 0.5 * (opened[ends[0]].mean(axis=0) + opened[ends[1]].mean(axis=0))
    pose = own @ turned(np.linalg.svd(own)[2][2], normal, 0.3).T + middle
    keep = replace(dna, positions=opened / 10)
    molecule = keep.joined(moved_to(dye, pose))
    framework = ragdoll.build_framework(molecule, constraints=ConstraintOptions(hydrophobic=False))
    ligand = of_residue(molecule, "LIG")
    across = np.isin(framework.tethers, ligand).sum(axis=1) == 1
    partners = {
        molecule.labels[atom].split(" ", 1)[1]
        for pair in framework.tethers[across].tolist()
        for atom in pair
        if atom not in ligand
    }
    assert len(partners) >= 2
    assert set(framework.tether_kinds[across].tolist()) == {4}


def test_fixed_atoms_do_not_stand_in_the_way_of_the_rest(proteins, tmp_path):
    smiles = (
        "O=C1N(Cc2ccc3ccccc3c2)[C@H](Cc2ccccc2)[C@H](O)[C@@H](O)[C@@H](Cc2ccccc2)N1Cc1ccc2ccccc2c1"
    )
    molecule = Molecule.from_file(proteins / "1hvr.pdb", ligand_smiles={"XK2": smiles})
    user = (UserConstraint("move", "resname XK2 or byres around 8 resname XK2"),)
    options = ragdoll.SampleOptions(
        frames=3, stride=3, perturbation="momentum", constraints=ConstraintOptions(user=user)
    )
    report = ragdoll.sample(molecule, tmp_path / "p.h5", options)
    assert report.frames == 3
    assert report.rejected_share < 0.2


def test_hydrogens_that_are_added_to_carbons_lie_where_their_neighbours_say(proteins):
    molecule = Molecule.from_file(proteins / "181l.pdb", ligand_smiles={"BNZ": "c1ccccc1"},
                                  add_hydrogens=True)  # fmt: skip
    around = [[] for _ in range(len(molecule))]
    for i, j in molecule.bonds.tolist():
        around[i].append(j)
        around[j].append(i)
    atoms = list(molecule.topology.atoms())
    rings = {"PHE": ("CD1", "CE1", "CZ"), "TYR": ("CD1", "CE1"), "TRP": ("CE3", "CZ3"), "BNZ": "*"}
    seen = 0
    for atom in atoms:
        names = rings.get(atom.residue.name, ())
        if atom.element.symbol != "C" or not (names == "*" or atom.name in names):
            continue
        hydrogen = next(k for k in around[atom.index] if molecule.elements[k] == 1)
        a, b = (molecule.positions[k] - molecule.positions[atom.index]
                for k in around[atom.index] if k != hydrogen)  # fmt: skip
        h = molecule.positions[hydrogen] - molecule.positions[atom.index]
        normal = np.cross(a, b)
        off = abs(h @ normal) / np.linalg.norm(h) / np.linalg.norm(normal)
        assert off < np.sin(np.radians(3))
        seen += 1
    assert seen > 20
