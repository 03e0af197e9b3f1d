#include "stereo.h"

#include <algorithm>  // max
#include <array>
#include <cmath>  // sqrt, abs, isfinite
#include <optional>
#include <utility>  // move

namespace ragdoll {
namespace {

const Bar* bar_between(const FrameworkParts& parts, const Graph& graph, int p, int q) {
  for (const Graph::Link& link : graph.links(p))
    if (link.other == q) return &parts.bars[std::size_t(link.bar)];
  return nullptr;
}

/// Finds for planar bars ad the bond bc that they go across, by the bond graph and the bars'
/// lengths.
class PlanarTorsions {
 public:
  PlanarTorsions(const FrameworkParts& parts, const Graph& graph)
      : parts_(parts), graph_(graph), across_(parts.bars.size()) {}

  std::vector<PlanarTorsion> find() {
    for (const Bar& bar : parts_.bars)
      if (bar.kind == BarKind::planar) add(bar);
    return std::move(found_);
  }

 private:
  const Bar& bar(const Graph::Link& link) const { return parts_.bars[std::size_t(link.bar)]; }
  bool is_bond(const Graph::Link& link) const { return bar(link).kind == BarKind::bond; }

  void add(const Bar& planar) {
    const int a = planar.p, d = planar.q;
    for (const Graph::Link& ab : graph_.links(a)) {
      if (!is_bond(ab)) continue;
      const int b = ab.other;
      for (const Graph::Link& bc : graph_.links(b)) {
        const int c = bc.other;
        if (c == a || c == d || !is_bond(bc) || across_[std::size_t(bc.bar)]) continue;
        const Bar* cd = bar_between(parts_, graph_, c, d);
        const Bar* ac = bar_between(parts_, graph_, a, c);
        const Bar* bd = bar_between(parts_, graph_, b, d);
        if (!cd || cd->kind != BarKind::bond || !ac || !bd) continue;
        const double cosine = cosine_of(bar(ab), bar(bc), *cd, *ac, *bd, planar);
        // a bond turned by a quarter has no sides
        if (!(std::abs(cosine) > least_cosine)) continue;
        across_[std::size_t(bc.bar)] = true;
        found_.push_back({a, b, c, d, cosine > 0});
      }
    }
  }

  /// Of the torsion abcd: with b at the origin and c along x, a and d are at known places along x
  /// and distances from it.
  static double cosine_of(const Bar& ab, const Bar& bc, const Bar& cd, const Bar& ac, const Bar& bd,
                          const Bar& ad) {
    const auto square = [](const Bar& bar) { return bar.length * bar.length; };
    const double xa = (square(ab) + square(bc) - square(ac)) / (2 * bc.length);
    const double xd = (square(bd) + square(bc) - square(cd)) / (2 * bc.length);
    const double ya = std::sqrt(square(ab) - xa * xa), yd = std::sqrt(square(bd) - xd * xd);
    return ((xa - xd) * (xa - xd) + ya * ya + yd * yd - square(ad)) / (2 * ya * yd);
  }

  static constexpr double least_cosine = 0.3;
  const FrameworkParts& parts_;
  const Graph& graph_;
  std::vector<bool> across_;  ///< whether a torsion across this bond is found (nbar)
  std::vector<PlanarTorsion> found_;
};

/// Finds the centres of volumes: the four and the centre are built from the lengths of their bars.
class Centres {
 public:
  Centres(const FrameworkParts& parts, const Graph& graph) : parts_(parts), graph_(graph) {}

  int of(const Volume& v) const {
    if (v.kind != VolumeKind::chirality) return -1;
    for (const Graph::Link& link : graph_.links(v.a))
      if (is_bonded(link.other, v) && lies_within(link.other, v)) return link.other;
    return -1;
  }

 private:
  bool is_bonded(int centre, const Volume& v) const {
    for (const int joint : {v.a, v.b, v.c, v.d}) {
      const Bar* bar = bar_between(parts_, graph_, centre, joint);
      if (!bar || bar->kind != BarKind::bond) return false;
    }
    return true;
  }

  bool lies_within(int centre, const Volume& v) const {
    const std::optional<double> bc = length(v.b, v.c), bd = length(v.b, v.d), cd = length(v.c, v.d);
    if (!bc || !bd || !cd) return false;
    // b at the origin, c along x, d in the plane
    const double x = (*bc * *bc + *bd * *bd - *cd * *cd) / (2 * *bc);
    std::array<Vec3, 4> corners;
    corners[1] = Vec3::Zero();
    corners[2] = Vec3(*bc, 0, 0);
    corners[3] = Vec3(x, std::sqrt(std::max(0.0, *bd * *bd - x * x)), 0);
    const std::optional<Vec3> a = placed(v.a, v, corners), above = placed(centre, v, corners);
    if (!a || !above) return false;
    corners[0] = *a;
    // the centre is on that side of bcd which has it at its distance from a
    const Vec3 below(above->x(), above->y(), -above->z());
    const double distance = *length(centre, v.a);
    const bool up =
        std::abs((*above - *a).norm() - distance) < std::abs((below - *a).norm() - distance);
    const bool right_handed = signed_volume(corners[0], corners[1], corners[2], corners[3]) > 0;
    return is_within(corners, {0, 1, 2, 3}, up ? *above : below, right_handed);
  }

  std::optional<double> length(int p, int q) const {
    const Bar* bar = bar_between(parts_, graph_, p, q);
    return bar ? std::optional(bar->length) : std::nullopt;
  }

  /// A joint at its distances from b, c and d, on the upper side.
  std::optional<Vec3> placed(int joint, const Volume& v, const std::array<Vec3, 4>& at) const {
    const std::optional<double> b = length(joint, v.b), c = length(joint, v.c),
                                d = length(joint, v.d);
    if (!b || !c || !d || !(at[3].y() > 0)) return std::nullopt;
    const double x = (*b * *b - *c * *c + at[2].squaredNorm()) / (2 * at[2].x());
    const double y =
        (*b * *b - *d * *d + at[3].squaredNorm() - 2 * at[3].x() * x) / (2 * at[3].y());
    return Vec3(x, y, std::sqrt(std::max(0.0, *b * *b - x * x - y * y)));
  }

  const FrameworkParts& parts_;
  const Graph& graph_;
};

}  // namespace

std::vector<PlanarTorsion> find_planar_torsions(const FrameworkParts& parts, const Graph& graph) {
  return PlanarTorsions(parts, graph).find();
}

std::vector<int> find_centres(const FrameworkParts& parts, const Graph& graph) {
  const Centres centres(parts, graph);
  std::vector<int> found;
  found.reserve(parts.volumes.size());
  for (const Volume& v : parts.volumes) found.push_back(centres.of(v));
  return found;
}

bool is_inverted(const Framework& framework, std::size_t volume, std::span<const Vec3> positions) {
  const Volume& v = framework.volumes()[volume];
  if (v.kind != VolumeKind::chirality) return false;
  const bool right_handed = std::isfinite(v.lower);
  const auto x = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  const int centre = framework.centres()[volume];
  if (centre >= 0) return !is_within(positions, v, x(centre), right_handed);
  const double value = signed_volume(x(v.a), x(v.b), x(v.c), x(v.d));
  return !(right_handed ? value > 0 : value < 0);
}

}  // namespace ragdoll
