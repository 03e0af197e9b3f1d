#include "ragdoll/chemistry/rdkit_molecule.h"

#include <GraphMol/Conformer.h>
#include <GraphMol/MonomerInfo.h>
#include <GraphMol/PeriodicTable.h>
#include <GraphMol/ROMol.h>

#include <algorithm>  // sort, minmax
#include <cmath>      // abs, isfinite, nearbyint
#include <map>
#include <memory>   // make_unique
#include <tuple>    // tie
#include <utility>  // move

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

constexpr double angstroms = 10;             // per nm
constexpr double nanometers = 0.1;           // per angstrom
constexpr double largest_coordinate = 9999;  // angstrom, what files of molecules can hold
constexpr int largest_element = 116;         // that OpenMM, too, has a mass for

/// Places are multiples of this: versions of RDKit place hydrogens that differ in their last bits.
/// nm
constexpr double grid = 0x1p-33;

double on_grid(double x) {
  return std::nearbyint(x / grid) * grid;
}

BondOrder order_of(const RDKit::Bond& bond) {
  using RDKit::Bond;
  if (bond.getIsAromatic()) return BondOrder::aromatic;
  switch (bond.getBondType()) {
    case Bond::SINGLE:
      return BondOrder::single;
    case Bond::DOUBLE:
      return BondOrder::double_bond;
    case Bond::TRIPLE:
      return BondOrder::triple;
    case Bond::AROMATIC:
      return BondOrder::aromatic;
    case Bond::DATIVE:
    case Bond::DATIVEONE:
    case Bond::DATIVEL:
    case Bond::DATIVER:
    case Bond::ZERO:
      return BondOrder::dative;
    default:
      return BondOrder::unknown;
  }
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// "C4 LIG1 A": symbols are counted where the molecule names no atoms.
class Labels {
 public:
  std::string of(const RDKit::Atom& atom) {
    const std::string counted = atom.getSymbol() + std::to_string(++counts_[atom.getSymbol()]);
    const auto* info = dynamic_cast<const RDKit::AtomPDBResidueInfo*>(atom.getMonomerInfo());
    if (!info) return counted + " LIG1 A";
    const std::string name = trimmed(info->getName()), residue = trimmed(info->getResidueName());
    const std::string label = (name.empty() ? counted : name) + " " +
                              (residue.empty() ? "LIG" : residue) +
                              std::to_string(info->getResidueNumber()) +
                              trimmed(info->getInsertionCode()) + " " + info->getChainId();
    return label.substr(0, label.find_last_not_of(' ') + 1);
  }

 private:
  std::map<std::string, int> counts_;
};

const RDKit::Conformer& conformer_of(const RDKit::ROMol& mol, int id) {
  for (auto it = mol.beginConformers(); it != mol.endConformers(); ++it)
    if (id == -1 || int((*it)->getId()) == id) {
      if (!(*it)->is3D())
        throw Error(title_of(mol) + " has a flat conformer; embed it in three dimensions first");
      return **it;
    }
  throw Error(title_of(mol) + " has no conformer" + (id == -1 ? "" : " " + std::to_string(id)) +
              "; embed it, or ask for one it has");
}

std::vector<Atom> atoms_of(const RDKit::ROMol& mol) {
  std::vector<Atom> atoms;
  atoms.reserve(mol.getNumAtoms());
  Labels labels;
  for (const RDKit::Atom* atom : mol.atoms()) {
    const int element = atom->getAtomicNum();
    const std::string where = title_of(mol) + ": atom " + std::to_string(atom->getIdx());
    if (element == 0) throw Error(where + " has no element; replace the dummy atom");
    if (element > largest_element) throw Error(where + " is of an element without a mass");
    atoms.push_back({element, atom->getFormalCharge(), atom->getMass(), labels.of(*atom)});
  }
  return atoms;
}

std::vector<Vec3> places_of(const RDKit::ROMol& mol, const RDKit::Conformer& conformer,
                            const std::vector<Atom>& atoms) {
  std::vector<Vec3> places;
  places.reserve(atoms.size());
  const auto is_usable = [](double value) {
    return std::isfinite(value) && std::abs(value) < largest_coordinate;
  };
  for (unsigned int i = 0; i < conformer.getNumAtoms(); ++i) {
    const RDGeom::Point3D& p = conformer.getAtomPos(i);
    if (!is_usable(p.x) || !is_usable(p.y) || !is_usable(p.z))
      throw Error(title_of(mol) + ": " + atoms[i].label +
                  " has no usable place; give it finite coordinates");
    places.emplace_back(on_grid(p.x * nanometers), on_grid(p.y * nanometers),
                        on_grid(p.z * nanometers));
  }
  return places;
}

}  // namespace

std::string title_of(const RDKit::ROMol& mol, const std::string& otherwise) {
  std::string title;
  mol.getPropIfPresent("_Name", title);
  title = trimmed(title);
  return title.empty() ? otherwise : title;
}

bool has_places(const RDKit::ROMol& mol) {
  return mol.getNumConformers() > 0 && mol.getConformer().is3D();
}

Molecule molecule_from_rdkit(const RDKit::ROMol& mol, int conformer) {
  if (mol.getNumAtoms() == 0) throw Error(title_of(mol) + " has no atoms; give a molecule");
  const RDKit::Conformer& chosen = conformer_of(mol, conformer);
  std::vector<Atom> atoms = atoms_of(mol);
  std::vector<Vec3> places = places_of(mol, chosen, atoms);
  std::vector<Bond> bonds;
  bonds.reserve(mol.getNumBonds());
  for (const RDKit::Bond* bond : mol.bonds()) {
    if (bond->getBondType() == RDKit::Bond::HYDROGEN) continue;  // holds nothing
    const auto [a, b] = std::minmax({int(bond->getBeginAtomIdx()), int(bond->getEndAtomIdx())});
    bonds.push_back({a, b, order_of(*bond)});
  }
  std::sort(bonds.begin(), bonds.end(), [](const Bond& one, const Bond& other) {
    return std::tie(one.a, one.b) < std::tie(other.a, other.b);
  });
  return Molecule(std::move(atoms), std::move(bonds), std::move(places));
}

unsigned int add_conformer(RDKit::ROMol& mol, std::span<const Vec3> positions) {
  if (positions.size() != mol.getNumAtoms())
    throw Error(title_of(mol) + " has " + std::to_string(mol.getNumAtoms()) + " atoms but " +
                std::to_string(positions.size()) + " positions were given");
  auto conformer = std::make_unique<RDKit::Conformer>(mol.getNumAtoms());
  conformer->set3D(true);
  for (unsigned int i = 0; i < mol.getNumAtoms(); ++i) {
    const Vec3 x = positions[i] * angstroms;
    conformer->setAtomPos(i, RDGeom::Point3D(x.x(), x.y(), x.z()));
  }
  return mol.addConformer(conformer.release(), true);
}

}  // namespace ragdoll
