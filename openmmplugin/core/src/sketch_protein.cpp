// Sketch of a protein: the heavy atoms of random residues, as a graph.

#include <array>
#include <cmath>    // sqrt, cos, sin
#include <numbers>  // pi
#include <string_view>
#include <utility>  // swap

#include "sketch.h"

namespace ragdoll {
namespace {

/// A residue's atoms are N, CA, C, O and those of its side chain, each of which hangs on an atom
/// before it; `rings` are the bonds that close its rings.
struct Residue {
  const char* name;
  int share;  ///< of the residues in natural proteins, in 1/1000
  int side_atoms;
  std::array<int, 10> hangs_on;
  int ring_count;
  std::array<std::pair<int, int>, 2> rings;

  int atoms() const { return 4 + side_atoms; }
};

constexpr std::array<Residue, 18> residues = {{
    {"Gly", 71, 0, {}, 0, {}},
    {"Ala", 83, 1, {1}, 0, {}},
    {"Ser", 66, 2, {1, 4}, 0, {}},
    {"Cys", 14, 2, {1, 4}, 0, {}},
    {"Val", 69, 3, {1, 4, 4}, 0, {}},
    {"Thr", 53, 3, {1, 4, 4}, 0, {}},
    {"Pro", 47, 3, {1, 4, 5}, 1, {{{6, 0}}}},
    {"Leu", 97, 4, {1, 4, 5, 5}, 0, {}},
    {"Ile", 59, 4, {1, 4, 4, 5}, 0, {}},
    {"Asp, Asn", 95, 4, {1, 4, 5, 5}, 0, {}},
    {"Met", 24, 4, {1, 4, 5, 6}, 0, {}},
    {"Glu, Gln", 107, 5, {1, 4, 5, 6, 6}, 0, {}},
    {"Lys", 58, 5, {1, 4, 5, 6, 7}, 0, {}},
    {"His", 23, 6, {1, 4, 5, 5, 6, 7}, 1, {{{8, 9}}}},
    {"Arg", 55, 7, {1, 4, 5, 6, 7, 8, 8}, 0, {}},
    {"Phe", 39, 7, {1, 4, 5, 5, 6, 7, 8}, 1, {{{9, 10}}}},
    {"Tyr", 29, 8, {1, 4, 5, 5, 6, 7, 8, 10}, 1, {{{9, 10}}}},
    {"Trp", 11, 10, {1, 4, 5, 5, 6, 7, 7, 9, 10, 11}, 2, {{{8, 9}, {12, 13}}}},
}};

/// Drawn by its share in nature, but so that what is left is nothing or at least a glycine.
const Residue& draw_residue(Sketch& sketch, int left) {
  while (true) {
    int lot = sketch.below(1000);
    std::size_t k = 0;
    while (lot >= residues[k].share) lot -= residues[k++].share;
    const int rest = left - residues[k].atoms();
    if (rest == 0 || rest >= 4) return residues[k];
  }
}

/// Grows the atoms one bar length from those they hang on, at 112 degrees to the bar before.
class Growth {
 public:
  explicit Growth(Sketch& sketch) : sketch_(sketch) {}

  int first() { return place(Vec3::Zero(), Vec3::UnitX()); }

  int add(int on) {
    const Way& way = ways_[std::size_t(on)];
    // the first neighbour at any torsion, the others a third of a turn on
    const double torsion = way.torsion + ways_[std::size_t(on)].children++ * third;
    const Vec3 u = way.direction.unitOrthogonal(), v = way.direction.cross(u);
    const Vec3 side = std::cos(torsion) * u + std::sin(torsion) * v;
    const Vec3 direction = cosine * way.direction + std::sqrt(1 - cosine * cosine) * side;
    const int joint = place(sketch_.positions[std::size_t(on)] + direction, direction);
    sketch_.add_bar(on, joint);
    return joint;
  }

 private:
  static constexpr double third = 2 * std::numbers::pi / 3;
  static constexpr double cosine = 0.3746;  // of 180 - 112 degrees

  /// How a joint was reached, and where its neighbours go.
  struct Way {
    Vec3 direction;
    double torsion;
    int children;
  };

  int place(const Vec3& position, const Vec3& direction) {
    ways_.push_back({direction, 2 * std::numbers::pi * sketch_.random.uniform(), 0});
    return sketch_.add_joint(position);
  }

  Sketch& sketch_;
  std::vector<Way> ways_;  ///< (njoint)
};

}  // namespace

void sketch_protein(Sketch& sketch) {
  Growth growth(sketch);
  std::vector<int> sulphurs;
  int carbonyl = -1;  // C of the residue before
  while (sketch.missing() > 0) {
    const Residue& residue = draw_residue(sketch, sketch.missing());
    const int n = carbonyl < 0 ? growth.first() : growth.add(carbonyl);
    const int ca = growth.add(n);
    carbonyl = growth.add(ca);
    growth.add(carbonyl);
    for (int k = 0; k < residue.side_atoms; ++k) growth.add(n + residue.hangs_on[std::size_t(k)]);
    for (int k = 0; k < residue.ring_count; ++k)
      sketch.add_bar(n + residue.rings[std::size_t(k)].first,
                     n + residue.rings[std::size_t(k)].second);
    if (std::string_view(residue.name) == "Cys") sulphurs.push_back(n + 5);
  }
  // disulfides between random pairs of cysteines
  for (std::size_t left = sulphurs.size(); left >= 2; left -= 2) {
    std::swap(sulphurs[left - 1], sulphurs[std::size_t(sketch.below(long(left)))]);
    std::swap(sulphurs[left - 2], sulphurs[std::size_t(sketch.below(long(left) - 1))]);
    sketch.add_bar(sulphurs[left - 1], sulphurs[left - 2]);
  }
}

}  // namespace ragdoll
