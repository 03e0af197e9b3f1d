// ContactRule: which pairs of joints may not come closer than what. The pairs themselves are found
// while the joints move (contact_list.h).

#pragma once
#include <cstdint>
#include <vector>

namespace ragdoll {

/// How a joint takes part in hydrogen bonds, which may bring it closer to its partner.
enum class Polarity : std::uint8_t { none = 0, heavy = 1, hydrogen = 2 };

/// Lower bound of a pair that starts closer than the rule allows: its starting distance.
struct ClosePair {
  int p = 0, q = 0;   ///< p < q
  double length = 0;  ///< nm
};

/// bound(p, q) = scale * (radius_p + radius_q) - allowance of the pair's polarity, unless the pair
/// is excluded (bonded neighbours) or started closer. Empty radii: no contacts.
struct ContactRule {
  std::vector<double> radii = {};           ///< van der Waals radii, nm (njoint, or empty)
  std::vector<Polarity> polarity = {};      ///< (njoint)
  double scale = 0;                         ///< dimensionless
  double heavy_allowance = 0;               ///< nm, both ends polar heavy atoms
  double hydrogen_allowance = 0;            ///< nm, a polar hydrogen and a polar heavy atom
  std::vector<int> exclusion_begin = {};    ///< (njoint + 1)
  std::vector<int> exclusions = {};         ///< sorted partners q > p of each p
  std::vector<ClosePair> close_pairs = {};  ///< sorted by (p, q)

  bool empty() const { return radii.empty(); }

  /// The rule's bound for a pair, exclusions and close pairs not considered. nm
  double rule_bound(int p, int q) const;

  /// The bound that holds: of the rule, or of the close pair. nm
  double bound(int p, int q) const;

  /// p < q
  bool excluded(int p, int q) const;

  /// The largest bound that any pair can have. nm
  double largest_bound() const;
};

}  // namespace ragdoll
