// Framework: joints, and the constraints that hold them. Immutable; positions live elsewhere.

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ragdoll/contact_rule.h"  // ContactRule
#include "ragdoll/graph.h"         // Graph, Components
#include "ragdoll/tolerance.h"     // Tolerance

namespace ragdoll {

/// Where a bar comes from. The bond graph is made of the bars of kind `bond`.
enum class BarKind : std::uint8_t { bond = 0, angle = 1, planar = 2, metal = 3, user = 4 };
inline constexpr int bar_kind_count = 5;

/// A fixed distance, |q - p| = length.
struct Bar {
  int p = 0, q = 0;
  double length = 0;  ///< nm
  BarKind kind = BarKind::bond;
};

/// Where an upper bound comes from. `backbone` holds phi and psi in a basin.
enum class TetherKind : std::uint8_t {
  user = 0,
  hydrogen_bond = 1,
  salt_bridge = 2,
  hydrophobic = 3,
  stacking = 4,
  backbone = 5,
};
inline constexpr int tether_kind_count = 6;

/// An upper bound, |q - p| <= length.
struct Tether {
  int p = 0, q = 0;
  double length = 0;  ///< nm
  TetherKind kind = TetherKind::user;
};

/// Where a lower bound comes from. `backbone` holds phi and psi in a basin, `side_chain` keeps
/// bonds from being eclipsed.
enum class ContactKind : std::uint8_t {
  user = 0,
  hydrogen_bond = 1,
  salt_bridge = 2,
  backbone = 3,
  side_chain = 4,
};
inline constexpr int contact_kind_count = 5;

/// A lower bound, |q - p| >= length.
struct Contact {
  int p = 0, q = 0;
  double length = 0;  ///< nm
  ContactKind kind = ContactKind::user;
};

/// The words for a kind: "bond", "hydrogen bond", "side chain", ...
std::string name_of(BarKind kind);
std::string name_of(TetherKind kind);
std::string name_of(ContactKind kind);

enum class VolumeKind : std::uint8_t { chirality = 0, planarity = 1 };
inline constexpr int volume_kind_count = 2;
std::string name_of(VolumeKind kind);

/// lower <= (b-a) . ((c-a) x (d-a)) <= upper. Violations are relative to `scale`.
struct Volume {
  int a = 0, b = 0, c = 0, d = 0;
  double lower = 0, upper = 0;  ///< nm^3
  double scale = 0;             ///< nm^3, positive
  VolumeKind kind = VolumeKind::chirality;
};

/// A planar unit across the bond bc: a and d on the same side of it (cis), or on opposite ones.
struct PlanarTorsion {
  int a = 0, b = 0, c = 0, d = 0;
  bool cis = false;
};

/// A hydrogen bond or salt bridge that tethers and contacts of a framework hold.
struct HeldBond {
  int donor = 0, hydrogen = -1, acceptor = 0;  ///< joints; hydrogen -1: the molecule has none there
  double energy = 0;                           ///< kJ/mol, at the start
  bool salt_bridge = false;
};

/// What a Framework is made from; all plain data.
struct FrameworkParts {
  std::vector<double> masses;            ///< dalton (njoint)
  std::vector<std::uint8_t> fixed;       ///< 1 = pinned (njoint, or empty: none)
  std::vector<std::string> labels = {};  ///< names for messages (njoint, or empty)
  std::vector<Bar> bars = {};
  std::vector<Tether> tethers = {};
  std::vector<Contact> contacts = {};  ///< explicit pairs, beside the rule
  std::vector<Volume> volumes = {};
  ContactRule contact_rule = {};  ///< lower bounds between all pairs that come near each other
  std::vector<HeldBond> held_bonds = {};  ///< strongest first; what they are, not what holds them
};

class Framework {
 public:
  /// @throw Error  on an unknown joint, a bar from a joint to itself, two bars on one pair, a
  /// length
  ///               that is not positive and finite, an empty framework, sizes that disagree
  explicit Framework(FrameworkParts parts);

  int joint_count() const { return int(parts_.masses.size()); }
  const std::vector<double>& masses() const { return parts_.masses; }
  const std::vector<std::uint8_t>& fixed() const { return parts_.fixed; }  ///< (njoint)
  const std::vector<Bar>& bars() const { return parts_.bars; }
  const std::vector<Tether>& tethers() const { return parts_.tethers; }
  const std::vector<Contact>& contacts() const { return parts_.contacts; }
  const std::vector<Volume>& volumes() const { return parts_.volumes; }
  const ContactRule& contact_rule() const { return parts_.contact_rule; }
  const std::vector<HeldBond>& held_bonds() const { return parts_.held_bonds; }
  const FrameworkParts& parts() const { return parts_; }  ///< to derive another framework from

  const Graph& graph() const { return graph_; }                 ///< all bars
  const Components& components() const { return components_; }  ///< of all bars
  const Graph& bond_graph() const { return bond_graph_; }       ///< bars of kind bond
  const Components& bond_components() const { return bond_components_; }
  int chirality_count() const;
  /// One for each bond that planar bars go across; which side follows from the bars' lengths.
  const std::vector<PlanarTorsion>& planar_torsions() const { return planar_torsions_; }
  /// The joint within the four of each chirality volume, -1 where none is (nvolume).
  const std::vector<int>& centres() const { return centres_; }

  /// Label of a joint, or "joint 17".
  std::string name(int joint) const;

 private:
  FrameworkParts parts_;
  Graph graph_, bond_graph_;
  Components components_, bond_components_;
  std::vector<PlanarTorsion> planar_torsions_;
  std::vector<int> centres_;
};

/// The framework with tethers and explicit contacts tighter by the tolerance: what resolves it
/// within the tolerance keeps the bounds of the first one.
Framework tightened(const Framework& framework, const Tolerance& tolerance);

}  // namespace ragdoll
