#include "flat_groups.h"

#include <algorithm>  // sort, stable_sort, max, count, all_of, any_of
#include <cmath>      // sqrt, isnan, abs
#include <limits>     // quiet_NaN
#include <numeric>    // iota
#include <utility>    // swap

namespace ragdoll {
namespace {

/// Of the distance of a joint from the plane of the others, over the size of the largest face.
constexpr double flat = 0.15;

/// Lengths of bars may be rounded: smaller differences, over the length, tell nothing.
constexpr double rounding = 1e-6;

/// Joints with more bars than this are not looked at: in so dense a framework nothing hangs by one
/// group.
constexpr std::size_t most_links = 24;

int shared(const FlatGroups::Corners& one, const FlatGroups::Corners& two) {
  int count = 0;
  for (const int joint : one) count += int(std::count(two.begin(), two.end(), joint));
  return count;
}

/// Sorts corners. @return -1 if that turns the volume's sign
int ascend(FlatGroups::Corners& corners) {
  int sign = 1;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 3; j > i; --j)
      if (corners[j] < corners[j - 1]) {
        std::swap(corners[j], corners[j - 1]);
        sign = -sign;
      }
  return sign;
}

}  // namespace

bool FlatGroups::Shape::is_flat() const {
  return volume < flat * scale();
}

double FlatGroups::Shape::scale() const {
  return area * std::sqrt(area);
}

double FlatGroups::square(int p, int q) const {
  for (const Graph::Link& link : framework_.graph().links(p))
    if (link.other == q) {
      const double length = framework_.bars()[std::size_t(link.bar)].length;
      return length * length;
    }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The volume's square is the Gram determinant of the edges from a.
std::optional<FlatGroups::Shape> FlatGroups::shape_of(const Corners& corners) const {
  const auto& [a, b, c, d] = corners;
  const double ab = square(a, b), ac = square(a, c), ad = square(a, d), bc = square(b, c),
               bd = square(b, d), cd = square(c, d);
  if (std::isnan(ab + ac + ad + bc + bd + cd)) return std::nullopt;
  const double p = (ab + ac - bc) / 2, q = (ab + ad - bd) / 2, r = (ac + ad - cd) / 2,
               s = (bc + bd - cd) / 2;
  const double gram = ab * (ac * ad - r * r) - p * (p * ad - r * q) + q * (p * r - ac * q);
  const double area =
      std::max({ab * ac - p * p, ab * ad - q * q, ac * ad - r * r, bc * bd - s * s});
  if (!(area > 0)) return std::nullopt;
  const Shape shape{std::sqrt(std::max(gram, 0.0)), std::sqrt(area)};
  if (gram < -rounding * shape.scale() * shape.scale()) return std::nullopt;
  return shape;
}

void FlatGroups::add_known(const Corners& corners, const Shape& shape, double aim) {
  Group group{corners, shape, aim > 0 ? 1 : aim < 0 ? -1 : 0, -1, true};
  group.sign *= ascend(group.corners);
  groups_.push_back(group);
}

std::vector<FlatGroups::Row> FlatGroups::rows_without_volume() {
  find_flat();
  link();
  settle_signs();
  std::vector<int> order(groups_.size());
  std::iota(order.begin(), order.end(), 0);
  const auto height = [this](int k) {
    const Group& group = groups_[std::size_t(k)];
    return group.known ? -1 : group.shape.volume / group.shape.scale();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](int one, int two) { return height(one) < height(two); });
  std::vector<std::vector<int>> of_joint(std::size_t(framework_.joint_count()));
  std::vector<Row> rows;
  for (const int k : order) {
    const Group& group = groups_[std::size_t(k)];
    const auto held = [&](int joint) {
      const std::vector<int>& others = of_joint[std::size_t(joint)];
      return std::any_of(others.begin(), others.end(), [&](int other) {
        return shared(groups_[std::size_t(other)].corners, group.corners) >= 3;
      });
    };
    // a volume that is not flat holds its joints to others, but none to this plane
    if (!group.shape.is_flat()) continue;
    if (!group.known) {
      if (std::all_of(group.corners.begin(), group.corners.end(), held)) continue;
      const int sign = group.sign < 0 ? -1 : 1;
      rows.push_back({group.corners, group.shape, sign * group.shape.volume, group.mirror});
    }
    for (const int joint : group.corners) of_joint[std::size_t(joint)].push_back(k);
  }
  return rows;
}

/// Those that are not among the known ones.
void FlatGroups::find_flat() {
  const Graph& graph = framework_.graph();
  std::vector<Corners> known;
  for (const Group& group : groups_) known.push_back(group.corners);
  std::sort(known.begin(), known.end());
  std::vector<int> mark(std::size_t(graph.joint_count()), -1);
  std::vector<int> common;
  for (int a = 0; a < graph.joint_count(); ++a) {
    const auto links = graph.links(a);
    if (links.size() < 3 || links.size() > most_links) continue;
    for (const Graph::Link& link : links) mark[std::size_t(link.other)] = a;
    for (const Graph::Link& link : links) {
      const int b = link.other;
      if (b < a || graph.links(b).size() > most_links) continue;
      common.clear();
      for (const Graph::Link& next : graph.links(b))
        if (next.other > b && mark[std::size_t(next.other)] == a) common.push_back(next.other);
      for (std::size_t i = 0; i < common.size(); ++i)
        for (std::size_t j = i + 1; j < common.size(); ++j) {
          const Corners corners = {a, b, std::min(common[i], common[j]),
                                   std::max(common[i], common[j])};
          const std::optional<Shape> shape = shape_of(corners);
          if (!shape || !shape->is_flat()) continue;
          if (std::binary_search(known.begin(), known.end(), corners)) continue;
          groups_.push_back({corners, *shape, 0, -1, false});
        }
    }
  }
}

/// Groups with three joints in common, if there is a bar between the others: it tells whether those
/// are on the same side.
void FlatGroups::link() {
  struct Face {
    std::array<int, 3> joints;
    int group;
    std::size_t apex;
  };
  std::vector<Face> faces;
  for (std::size_t k = 0; k < groups_.size(); ++k)
    for (std::size_t apex = 0; apex < 4; ++apex) {
      Face face{{}, int(k), apex};
      for (std::size_t i = 0, j = 0; i < 4; ++i)
        if (i != apex) face.joints[j++] = groups_[k].corners[i];
      faces.push_back(face);
    }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Face& one, const Face& two) { return one.joints < two.joints; });
  links_.assign(groups_.size(), {});
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t j = i + 1; j < faces.size() && faces[j].joints == faces[i].joints; ++j) {
      const Face &one = faces[i], &two = faces[j];
      const int sign = relation(groups_[std::size_t(one.group)], one.apex,
                                groups_[std::size_t(two.group)], two.apex);
      if (sign == 0) continue;
      links_[std::size_t(one.group)].push_back({two.group, sign});
      links_[std::size_t(two.group)].push_back({one.group, sign});
    }
}

/// Whether the volumes of two groups with a face in common have the same sign (1) or not (-1); 0:
/// nothing tells.
int FlatGroups::relation(const Group& one, std::size_t apex, const Group& other,
                         std::size_t other_apex) const {
  const int d = one.corners[apex], e = other.corners[other_apex];
  const double de = square(d, e);
  if (std::isnan(de)) return 0;
  std::array<int, 3> face{};
  for (std::size_t i = 0, j = 0; i < 4; ++i)
    if (i != apex) face[j++] = one.corners[i];
  const auto& [a, b, c] = face;
  // in the plane of the face, a at the origin and b along x
  const double x = std::sqrt(square(a, b));
  const auto place = [&](int p) {
    const double u = (square(a, b) + square(a, p) - square(b, p)) / (2 * x);
    return std::pair(u, square(a, p) - u * u);  // square of the distance from ab
  };
  const auto [cu, cv_square] = place(c);
  if (!(cv_square > rounding * square(a, c))) return 0;
  const double cv = std::sqrt(cv_square);
  const auto lift = [&](int p) {
    const auto [u, rest] = place(p);
    const double v = (square(a, p) + square(a, c) - square(c, p) - 2 * u * cu) / (2 * cv);
    return std::array<double, 3>{u, v, std::sqrt(std::max(0.0, rest - v * v))};
  };
  const std::array<double, 3> dp = lift(d), ep = lift(e);
  const double across = dp[2] * ep[2];
  if (!(4 * across > rounding * de)) return 0;
  const double du = dp[0] - ep[0], dv = dp[1] - ep[1];
  const double between = du * du + dv * dv + dp[2] * dp[2] + ep[2] * ep[2];
  const int same =
      std::abs(between - 2 * across - de) < std::abs(between + 2 * across - de) ? 1 : -1;
  // the volume has the sign of the apex's side, or the other, by its place among the corners
  return (apex + other_apex) % 2 == 0 ? same : -same;
}

/// From volumes whose sign is known; then from one of each set that hangs together.
void FlatGroups::settle_signs() {
  for (std::size_t k = 0; k < groups_.size(); ++k)
    if (groups_[k].known && groups_[k].sign != 0) spread_sign(int(k));
  int mirrors = 0;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    if (groups_[k].known || groups_[k].sign != 0) continue;
    groups_[k].sign = 1;
    groups_[k].mirror = mirrors++;
    spread_sign(int(k));
  }
}

void FlatGroups::spread_sign(int start) {
  std::vector<int> waiting = {start};
  while (!waiting.empty()) {
    const std::size_t k = std::size_t(waiting.back());
    waiting.pop_back();
    for (const Link& next : links_[k]) {
      Group& other = groups_[std::size_t(next.other)];
      if (other.sign != 0 || other.known) continue;
      other.sign = next.sign * groups_[k].sign;
      other.mirror = groups_[k].mirror;
      waiting.push_back(next.other);
    }
  }
}

}  // namespace ragdoll
