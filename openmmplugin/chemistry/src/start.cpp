#include "ragdoll/chemistry/start.h"

#include <DistGeom/BoundsMatrix.h>
#include <GraphMol/Conformer.h>
#include <GraphMol/DistGeomHelpers/Embedder.h>
#include <GraphMol/MolOps.h>
#include <GraphMol/RWMol.h>

#include <algorithm>  // max, minmax
#include <cmath>      // isfinite
#include <exception>
#include <limits>
#include <set>
#include <tuple>

#include "ragdoll/chemistry/rdkit_molecule.h"  // has_places
#include "ragdoll/error.h"                     // Error
#include "rdkit_messages.h"

namespace ragdoll {
namespace {

using RDGeom::Point3D;

constexpr unsigned int most_atoms = 5000;  // embedding takes memory by their square
constexpr double flat = 1e-3;              // angstrom
constexpr double shortest_bond = 0.3;      // angstrom
constexpr double gap = 3;                  // angstrom between the spheres around fragments

/// Whether a molecule may lie in a plane: no atom has four neighbours.
bool may_be_flat(const RDKit::ROMol& mol) {
  for (const RDKit::Atom* atom : mol.atoms())
    if (atom->getTotalDegree() >= 4) return false;
  return true;
}

/// Whether the coordinates are of use: in three dimensions, no two atoms in one place.
bool has_useful_places(const RDKit::ROMol& mol) {
  if (mol.getNumConformers() == 0) return false;
  const RDKit::Conformer& conformer = mol.getConformer();
  std::set<std::tuple<double, double, double>> places;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (unsigned int i = 0; i < mol.getNumAtoms(); ++i) {
    const Point3D& p = conformer.getAtomPos(i);
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw Error("it has coordinates that are no numbers");
    places.insert({p.x, p.y, p.z});
    least = std::min(least, p.z);
    most = std::max(most, p.z);
  }
  if (mol.getNumAtoms() == 1) return true;
  if (places.size() < mol.getNumAtoms()) return false;
  return conformer.is3D() && (most - least > flat || may_be_flat(mol));
}

void check_atoms(const RDKit::ROMol& mol) {
  unsigned int count = mol.getNumAtoms();
  for (const RDKit::Atom* atom : mol.atoms()) {
    if (atom->getAtomicNum() == 0)
      throw Error("atom " + std::to_string(atom->getIdx() + 1) +
                  " has no element (*); replace it by what it stands for");
    count += atom->getTotalNumHs();
  }
  if (count > most_atoms)
    throw Error("it has " + std::to_string(count) + " atoms with hydrogens, more than " +
                std::to_string(most_atoms));
}

void check_bonds(const RDKit::ROMol& mol) {
  const RDKit::Conformer& conformer = mol.getConformer();
  for (const RDKit::Bond* bond : mol.bonds()) {
    const unsigned int a = bond->getBeginAtomIdx(), b = bond->getEndAtomIdx();
    if ((conformer.getAtomPos(a) - conformer.getAtomPos(b)).length() < shortest_bond)
      throw Error("atoms " + std::to_string(a + 1) + " and " + std::to_string(b + 1) +
                  " are bonded and in one place; have it embedded");
  }
}

void keep_one_conformer(RDKit::RWMol& mol) {
  auto* kept = new RDKit::Conformer(mol.getConformer());
  mol.clearConformers();
  kept->setId(0);
  mol.addConformer(kept);
}

bool is_usable(const RDKit::ROMol& mol) {
  if (mol.getNumConformers() != 1) return false;
  const RDKit::Conformer& conformer = mol.getConformer();
  for (unsigned int i = 0; i < mol.getNumAtoms(); ++i)
    if (!std::isfinite(conformer.getAtomPos(i).lengthSq())) return false;
  return true;
}

/// @return how, if not in the usual way
std::string embed(RDKit::RWMol& mol, std::uint64_t seed) {
  constexpr std::uint64_t seeds = std::numeric_limits<int>::max();
  std::string reason = "it gives no reason";
  for (std::uint64_t attempt = 0; attempt < 3; ++attempt) {
    RDKit::DGeomHelpers::EmbedParameters settings = RDKit::DGeomHelpers::ETKDGv3;
    settings.randomSeed = int((seed % seeds + attempt) % seeds);
    settings.numThreads = 1;
    settings.useRandomCoords = attempt >= 1;
    if (attempt == 2) {
      settings.useExpTorsionAnglePrefs = false;
      settings.useBasicKnowledge = false;
      settings.ignoreSmoothingFailures = true;
    }
    try {
      RDKit::DGeomHelpers::EmbedMolecule(mol, settings);
    } catch (const std::exception& error) {
      reason = error.what();
      mol.clearConformers();
    }
    if (is_usable(mol))
      return attempt == 0   ? ""
             : attempt == 1 ? "embedded from random coordinates"
                            : "embedded without knowledge of torsions";
    mol.clearConformers();
  }
  throw Error("RDKit embeds no start: " + reason);
}

/// Puts unbonded fragments, which RDKit embeds on top of each other, side by side.
void separate_fragments(RDKit::RWMol& mol) {
  std::vector<std::vector<int>> fragments;
  if (RDKit::MolOps::getMolFrags(mol, fragments) < 2) return;
  RDKit::Conformer& conformer = mol.getConformer();
  double edge = 0;
  for (const std::vector<int>& atoms : fragments) {
    Point3D centre;
    for (const int atom : atoms) centre += conformer.getAtomPos(unsigned(atom));
    centre /= double(atoms.size());
    double radius = 0;
    for (const int atom : atoms)
      radius = std::max(radius, (conformer.getAtomPos(unsigned(atom)) - centre).length());
    const Point3D shift = Point3D(edge > 0 ? edge + gap + radius : 0, 0, 0) - centre;
    for (const int atom : atoms) conformer.getAtomPos(unsigned(atom)) += shift;
    edge = edge > 0 ? edge + gap + 2 * radius : std::max(radius, 1e-9);
  }
}

}  // namespace

Start make_start(const RDKit::ROMol& mol, const StartOptions& options) {
  const RdkitMessages messages;
  const bool has_places = has_useful_places(mol);
  check_atoms(mol);
  Start start{std::make_shared<RDKit::RWMol>(mol), {}};
  RDKit::RWMol& full = *start.mol;
  if (has_places) RDKit::MolOps::assignStereochemistryFrom3D(full);
  RDKit::MolOps::addHs(full, false, has_places);
  if (has_places && !options.embed) {
    check_bonds(full);
    keep_one_conformer(full);
    return start;
  }
  full.clearConformers();
  const std::string how = embed(full, options.seed);
  if (!how.empty()) start.notes.push_back(how);
  separate_fragments(full);
  RDKit::MolOps::assignStereochemistryFrom3D(full);
  return start;
}

}  // namespace ragdoll
