// Quality of frames: stereochemistry, clashes, backbone and bounds, measured on positions alone and
// told from any solver's residual.

#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/box.h"                   // Box
#include "ragdoll/molecule.h"              // Molecule
#include "ragdoll/ramachandran_density.h"  // RamachandranDensity

namespace ragdoll {

/// A bond with the length that such bonds have.
struct IdealBond {
  int a = 0, b = 0;
  double length = 0, deviation = 0;  ///< nm
};

/// An angle, b in the middle, with the value that such angles have.
struct IdealAngle {
  int a = 0, b = 0, c = 0;
  double degree = 0, deviation = 0;
};

/// An upper bound that should have been kept.
struct QualityBound {
  int p = 0, q = 0;
  double length = 0;  ///< nm
  int group = 0;      ///< bounds of a group are told together
};

/// What is measured beyond what the molecule itself tells; all plain data.
struct QualityTerms {
  std::vector<IdealBond> ideal_bonds = {};
  std::vector<IdealAngle> ideal_angles = {};
  std::vector<std::array<int, 4>> omegas = {};     ///< CA C N CA
  std::vector<std::array<int, 5>> backbones = {};  ///< C N CA C N: phi and psi
  std::vector<int> alphas = {};  ///< centres that are told apart from the others: CA
  std::optional<RamachandranDensity> ramachandran = {};
  std::vector<QualityBound> bounds = {};
  int groups = 0;  ///< of the bounds
};

/// Of one frame.
struct FrameQuality {
  double bond_rms = 0, bond_max = 0;     ///< from the input, nm
  double angle_rms = 0, angle_max = 0;   ///< from the input, degree
  double bond_rmsz = 0, angle_rmsz = 0;  ///< from ideal values, in their deviations
  std::int64_t clashes = 0;              ///< pairs of heavy atoms
  double clash_worst = 0;                ///< the deepest overlap beyond what is allowed, nm
  std::int64_t all_atom_clashes = 0;     ///< the same with hydrogens
  std::int64_t core = 0, outliers = 0;   ///< residues on the Ramachandran map
  double omega_rms = 0, omega_max = 0;   ///< from cis or trans, as the input is, degree
  std::int64_t omegas_off = 0;           ///< by more than 30 degrees
  std::int64_t alphas_inverted = 0;      ///< of the alphas
  std::int64_t centres_inverted = 0;     ///< of all centres, alphas included
  std::vector<double> excess = {};       ///< over the bounds of each group, nm; 0: all kept
};

/// Heavy atoms clash where they overlap by 0.04 nm (radii C 0.170, N 0.155, O 0.152, S 0.180, other
/// elements by Bondi); pairs within four bonds and of two S do not, and pairs of N and O may
/// overlap by 0.04 nm more. Metals do not clash. With hydrogens the radii and exceptions are those
/// of MolProbity's all-atom contacts: a polar hydrogen may overlap an acceptor by 0.06 nm more, and
/// pairs of heavy atoms are left out within three bonds, others within four.
class QualityCheck {
 public:
  /// @param molecule  its positions are the input that frames are held against
  /// @throw Error     on a term that names an unknown atom
  QualityCheck(const Molecule& molecule, QualityTerms terms);

  /// @throw Error if the frame has another size, or a coordinate that is not finite
  FrameQuality measure(std::span<const Vec3> frame, const Box* box = nullptr) const;

  int atom_count() const { return int(start_.size()); }
  int heavy_count() const { return heavy_; }
  int centre_count() const { return int(centres_.size()); }
  const QualityTerms& terms() const { return terms_; }
  const std::vector<Vec3>& start() const { return start_; }

 private:
  /// Three neighbours in order around a centre.
  struct Hand {
    int centre, a, b, c;
    bool positive;  ///< sign of their volume in the input
  };
  struct Centre {
    std::size_t begin, end;  ///< of its hands
    bool alpha;
  };
  /// How an atom takes part in clashes.
  struct Clasher {
    float heavy_radius = 0;     ///< nm; 0: takes no part
    float all_atom_radius = 0;  ///< nm; 0: takes no part
    std::uint8_t element = 0;
    bool polar_hydrogen = false;
    bool acceptor = false;
  };

  void find_angles(const Molecule& molecule);
  void find_hands(const Molecule& molecule);
  void find_clashers(const Molecule& molecule);
  void check_terms() const;
  void add_internal(std::span<const Vec3> x, FrameQuality& q) const;
  void add_backbone(std::span<const Vec3> x, FrameQuality& q) const;
  void add_hands(std::span<const Vec3> x, FrameQuality& q) const;
  void add_clashes(std::span<const Vec3> x, const Box* box, FrameQuality& q) const;

  QualityTerms terms_;
  std::vector<Vec3> start_;
  std::vector<std::array<int, 2>> bonds_;
  std::vector<double> bond_lengths_;  ///< nm
  std::vector<std::array<int, 3>> angles_;
  std::vector<double> angle_values_;  ///< rad
  std::vector<std::uint8_t> cis_;     ///< of the omegas, in the input
  std::vector<Hand> hands_;
  std::vector<Centre> centres_;
  std::vector<Clasher> clashers_;
  std::vector<std::size_t> near_begin_;   ///< (natom + 1)
  std::vector<int> near_;                 ///< sorted partners q > p within four bonds
  std::vector<std::uint8_t> near_bonds_;  ///< how many bonds apart
  double reach_ = 0;                      ///< the largest distance at which atoms may clash, nm
  int heavy_ = 0;
};

}  // namespace ragdoll
