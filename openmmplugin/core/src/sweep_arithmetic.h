// Sweep arithmetic: how one constraint is tested and corrected, in floats or doubles. The lanes of
// an ensemble do the same operations in the same order (ensemble_ordered.cpp), so that they end
// with the same bits. Private to the resolvers.

#pragma once
#include <cmath>  // sqrt, isfinite
#include <cstdint>
#include <utility>  // pair
#include <vector>

#include "ragdoll/framework.h"  // Framework
#include "ragdoll/tolerance.h"  // Tolerance
#include "ragdoll/weighting.h"  // Weighting

namespace ragdoll {

/// What the passes over all constraints, or one of them, came to.
struct PassTally {
  std::int64_t corrections = 0;
  std::int64_t held = 0;  ///< violated constraints that nothing can move
  int last_problem = -1;  ///< bar of the problem constraint corrected last
  bool finite = true;
};

/// What constraints may be violated by, in T. Floats keep a little of it back for what they round,
/// so that the tolerance holds for what they stand for.
template <class T>
class Slack {
 public:
  explicit Slack(const Tolerance& tolerance) : tolerance_(tolerance) {}

  T of(double length) const { return T(tolerance_.slack(length) - rounding * length); }
  T of_volume(double scale) const {
    return T(tolerance_.volume_slack(scale) - 10 * rounding * scale);
  }

  static constexpr bool single = sizeof(T) == sizeof(float);
  static constexpr double rounding = single ? 4e-7 : 0;

  /// Closer to the bounds of a squared distance than this, the exact test decides.
  static constexpr double hair = single ? 1e-6 : 1e-12;

 private:
  Tolerance tolerance_;
};

template <class T>
struct Difference {
  T x, y, z;

  Difference(const T* p, const T* q) : x(q[0] - p[0]), y(q[1] - p[1]), z(q[2] - p[2]) {}
  T square() const { return x * x + y * y + z * z; }
};

/// Adds `error` to the distance from p to q, shared between them. Two joints at one place part in
/// +x.
template <class T>
void move_apart(T* p, T* q, Difference<T> d, T distance, T error, T p_share, T q_share) {
  if (distance == 0) {
    d.x = distance = 1;
    d.y = d.z = 0;
  }
  if constexpr (Slack<T>::single) {
    // one division
    const T by = error / distance, p_by = p_share * by, q_by = q_share * by;
    p[0] -= p_by * d.x, p[1] -= p_by * d.y, p[2] -= p_by * d.z;
    q[0] += q_by * d.x, q[1] += q_by * d.y, q[2] += q_by * d.z;
  } else {
    const T x = d.x / distance, y = d.y / distance, z = d.z / distance;
    const T p_by = p_share * error, q_by = q_share * error;
    p[0] -= p_by * x, p[1] -= p_by * y, p[2] -= p_by * z;
    q[0] += q_by * x, q[1] += q_by * y, q[2] += q_by * z;
  }
}

/// Shares of a constraint's ends: a fixed end takes 0, the other 1; both fixed: nothing moves.
inline std::pair<double, double> shares_of(const Framework& framework, int near, int far,
                                           const Weighting& weighting) {
  const bool near_fixed = framework.fixed()[std::size_t(near)];
  const bool far_fixed = framework.fixed()[std::size_t(far)];
  if (near_fixed && far_fixed) return {0, 0};
  if (near_fixed) return {0, 1};
  if (far_fixed) return {1, 0};
  return {weighting.near, weighting.far};
}

/// A bar as the sweep visits it: what the first test takes, ...
template <class T>
struct BarVisit {
  int near, far;
  T lower2, upper2;  ///< squared distances between them are surely within tolerance
};

/// ... and what else it takes to correct it.
template <class T>
struct BarCorrection {
  T length, slack;
  T near_share, far_share;  ///< of the error; 0 and 0: both ends are fixed
  int bar;
  bool problem;
};

/// A tether or a contact, .5/.5, corrected only when violated.
template <class T>
struct PairVisit {
  int p, q;
  T sure2;  ///< a squared distance on the safe side of it is surely within tolerance
  T length, slack;
  T p_share, q_share;
};

template <class T>
struct VolumeVisit {
  int joint[4];
  T lower, upper, slack;
  bool fixed[4];
};

template <class T>
std::pair<BarVisit<T>, BarCorrection<T>> bar_visit(const Framework& framework,
                                                   const Slack<T>& slack, int bar, int near,
                                                   int far, bool problem,
                                                   const Weighting& weighting) {
  const double length = framework.bars()[std::size_t(bar)].length;
  const T room = slack.of(length);
  const double lower = std::max(0.0, length - double(room)) * (1 + Slack<T>::hair);
  const double upper = (length + double(room)) * (1 - Slack<T>::hair);
  const auto [near_share, far_share] = shares_of(framework, near, far, weighting);
  return {{near, far, T(lower * lower), T(upper * upper)},
          {T(length), room, T(near_share), T(far_share), bar, problem}};
}

enum class Side { upper, lower };  ///< a tether's bound, a contact's

template <class T, class Pair>
std::vector<PairVisit<T>> pair_visits(const Framework& framework, const Slack<T>& slack, Side side,
                                      const std::vector<Pair>& pairs) {
  std::vector<PairVisit<T>> visits;
  for (const Pair& pair : pairs) {
    const T room = slack.of(pair.length);
    const double sure = side == Side::upper
                            ? (pair.length + double(room)) * (1 - Slack<T>::hair)
                            : std::max(0.0, pair.length - double(room)) * (1 + Slack<T>::hair);
    const auto [p_share, q_share] = shares_of(framework, pair.p, pair.q, Weighting{});
    visits.push_back(
        {pair.p, pair.q, T(sure * sure), T(pair.length), room, T(p_share), T(q_share)});
  }
  return visits;
}

template <class T>
std::vector<VolumeVisit<T>> volume_visits(const Framework& framework, const Slack<T>& slack) {
  std::vector<VolumeVisit<T>> visits;
  const auto& fixed = framework.fixed();
  for (const Volume& v : framework.volumes()) {
    const auto pinned = [&](int joint) { return fixed[std::size_t(joint)] != 0; };
    visits.push_back({{v.a, v.b, v.c, v.d},
                      T(v.lower),
                      T(v.upper),
                      slack.of_volume(v.scale),
                      {pinned(v.a), pinned(v.b), pinned(v.c), pinned(v.d)}});
  }
  return visits;
}

/// @param x  positions, three numbers each
template <Side side, class T>
void sweep_pairs(const std::vector<PairVisit<T>>& visits, T* x, PassTally& tally) {
  for (const PairVisit<T>& pair : visits) {
    T* const p = x + 3 * std::size_t(pair.p);
    T* const q = x + 3 * std::size_t(pair.q);
    const Difference<T> d(p, q);
    const T distance2 = d.square();
    if (side == Side::upper ? distance2 <= pair.sure2 : distance2 >= pair.sure2) continue;
    const T distance = std::sqrt(distance2);
    const T error = pair.length - distance;
    if ((side == Side::upper ? -error : error) <= pair.slack) continue;
    if (pair.p_share == 0 && pair.q_share == 0) {
      ++tally.held;
      continue;
    }
    ++tally.corrections;
    if (!std::isfinite(distance)) tally.finite = false;
    move_apart(p, q, d, distance, error, pair.p_share, pair.q_share);
  }
}

/// Each violated volume to its nearest bound along its gradient: the smallest move that does it.
template <class T>
void sweep_volumes(const std::vector<VolumeVisit<T>>& visits, T* x, PassTally& tally) {
  struct Vector {
    T x, y, z;
    Vector cross(const Vector& o) const {
      return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x};
    }
    T dot(const Vector& o) const { return x * o.x + y * o.y + z * o.z; }
  };
  for (const VolumeVisit<T>& v : visits) {
    T* const p[4] = {x + 3 * std::size_t(v.joint[0]), x + 3 * std::size_t(v.joint[1]),
                     x + 3 * std::size_t(v.joint[2]), x + 3 * std::size_t(v.joint[3])};
    const auto from_a = [&](int k) {
      return Vector{p[k][0] - p[0][0], p[k][1] - p[0][1], p[k][2] - p[0][2]};
    };
    const Vector ab = from_a(1), ac = from_a(2), ad = from_a(3);
    const Vector b = ac.cross(ad);
    const T volume = ab.dot(b);
    const bool below = volume < v.lower;
    const T excess = below ? v.lower - volume : volume - v.upper;
    // not: excess <= slack; a volume that is no number is left to the bars
    if (!(excess > v.slack)) continue;
    const Vector c = ad.cross(ab), d = ab.cross(ac);
    Vector gradient[4] = {{-(b.x + c.x + d.x), -(b.y + c.y + d.y), -(b.z + c.z + d.z)}, b, c, d};
    for (int k = 0; k < 4; ++k)
      if (v.fixed[k]) gradient[k] = {0, 0, 0};
    const T square = gradient[0].dot(gradient[0]) + gradient[1].dot(gradient[1]) +
                     gradient[2].dot(gradient[2]) + gradient[3].dot(gradient[3]);
    // no direction changes the volume: all fixed, or all joints on a line
    if (!(square > 0)) {
      ++tally.held;
      continue;
    }
    const T step = ((below ? v.lower : v.upper) - volume) / square;
    if (!std::isfinite(step)) tally.finite = false;
    for (int k = 0; k < 4; ++k) {
      p[k][0] += step * gradient[k].x;
      p[k][1] += step * gradient[k].y;
      p[k][2] += step * gradient[k].z;
    }
    ++tally.corrections;
  }
}

}  // namespace ragdoll
