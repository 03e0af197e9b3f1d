// Framework: joints, and the constraints that hold them. Immutable; positions live elsewhere.

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ragdoll/contact_rule.h"  // ContactRule
#include "ragdoll/graph.h"         // Graph, Components

namespace ragdoll {

/// Where a bar comes from. The bond graph is made of the bars of kind `bond`.
enum class BarKind : std::uint8_t { bond = 0, angle = 1, planar = 2 };

/// A fixed distance, |q - p| = length.
struct Bar {
  int p = 0, q = 0;
  double length = 0;  ///< nm
  BarKind kind = BarKind::bond;
};

/// An upper bound, |q - p| <= length.
struct Tether {
  int p = 0, q = 0;
  double length = 0;  ///< nm
};

/// A lower bound, |q - p| >= length.
struct Contact {
  int p = 0, q = 0;
  double length = 0;  ///< nm
};

enum class VolumeKind : std::uint8_t { chirality = 0, planarity = 1 };

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

}  // namespace ragdoll
