#include "part_lanes.h"

#include <algorithm>  // min, max
#include <cmath>      // cos, sin
#include <cstddef>    // size_t
#include <numbers>    // pi

// this file is compiled once for each kind of vectors: loops over lanes are left to the compiler
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "part_lanes.cpp"
#include <hwy/foreach_target.h>
// behind it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ragdoll::HWY_NAMESPACE {

constexpr std::size_t L = LanePlan::lanes;

/// Sines and cosines of whole degrees.
struct Circle {
  float cosine[360], sine[360];
  Circle() {
    for (int k = 0; k < 360; ++k) {
      cosine[k] = float(std::cos(k * std::numbers::pi / 180));
      sine[k] = float(std::sin(k * std::numbers::pi / 180));
    }
  }
};

/// out = first * second, moves of 12 numbers.
HWY_INLINE void Compose(const LaneFloats* first, const LaneFloats* second, LaneFloats* out) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      for (std::size_t l = 0; l < L; ++l)
        out[3 * row + column][l] = first[3 * row][l] * second[column][l] +
                                   first[3 * row + 1][l] * second[3 + column][l] +
                                   first[3 * row + 2][l] * second[6 + column][l];
    for (std::size_t l = 0; l < L; ++l)
      out[9 + row][l] = first[3 * row][l] * second[9][l] + first[3 * row + 1][l] * second[10][l] +
                        first[3 * row + 2][l] * second[11][l] + first[9 + row][l];
  }
}

/// The turn about a line, for each lane's angle.
HWY_INLINE void TurnOf(const LanePart& part, const LaneInts& bins, const Circle& circle,
                       LaneFloats* turn) {
  LaneFloats c, s;
  for (std::size_t l = 0; l < L; ++l) {
    c[l] = circle.cosine[bins[l]];
    s[l] = circle.sine[bins[l]];
  }
  const float* const u = part.axis.data();
  const float* const o = part.origin.data();
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      const float product = u[row] * u[column];
      // the cross product's matrix
      const std::size_t other = 3 - row - column;
      const float sign = row == column ? 0.0f : (column == (row + 1) % 3 ? -1.0f : 1.0f);
      const float across = row == column ? 0.0f : sign * u[other];
      const float one = row == column ? 1.0f : 0.0f;
      for (std::size_t l = 0; l < L; ++l)
        turn[3 * row + column][l] = product + (one - product) * c[l] + across * s[l];
    }
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t l = 0; l < L; ++l)
      turn[9 + row][l] = o[row] - (turn[3 * row][l] * o[0] + turn[3 * row + 1][l] * o[1] +
                                   turn[3 * row + 2][l] * o[2]);
}

void Place(const LanePlan& plan, LaneState& state) {
  static const Circle circle;
  LaneFloats turn[12], hung[12], between[12];
  for (std::size_t p = 0; p < plan.parts.size(); ++p) {
    const LanePart& part = plan.parts[p];
    LaneFloats* const move = state.moves.data() + 12 * p;
    const std::size_t natom = std::size_t(part.last - part.first);
    if (part.parent < 0) {
      for (std::size_t k = 0; k < 12; ++k) move[k].fill(k == 0 || k == 4 || k == 8 ? 1.0f : 0.0f);
    } else {
      const std::size_t above = std::size_t(part.parent);
      const LanePart& parent = plan.parts[above];
      TurnOf(part, state.bins[p], circle, turn);
      const LaneFloats* from = state.moves.data() + 12 * above;
      if (parent.shapes > 1) {
        for (std::size_t l = 0; l < L; ++l) {
          const float* const m = parent.moves.data() + 12 * (std::size_t(state.shapes[above][l]) *
                                                                 std::size_t(parent.children) +
                                                             std::size_t(part.place));
          for (std::size_t k = 0; k < 12; ++k) hung[k][l] = m[k];
        }
        Compose(from, hung, between);
        from = between;
      }
      Compose(from, turn, move);
    }
    for (std::size_t a = 0; a < natom; ++a) {
      LaneFloats* const out = state.places.data() + 3 * (std::size_t(part.first) + a);
      if (part.shapes == 1) {
        const float* const x = part.positions.data() + 3 * a;
        for (std::size_t row = 0; row < 3; ++row)
          for (std::size_t l = 0; l < L; ++l)
            out[row][l] = move[3 * row][l] * x[0] + move[3 * row + 1][l] * x[1] +
                          move[3 * row + 2][l] * x[2] + move[9 + row][l];
      } else {
        LaneFloats x[3];
        for (std::size_t l = 0; l < L; ++l)
          for (std::size_t k = 0; k < 3; ++k)
            x[k][l] = part.positions[3 * (std::size_t(state.shapes[p][l]) * natom + a) + k];
        for (std::size_t row = 0; row < 3; ++row)
          for (std::size_t l = 0; l < L; ++l)
            out[row][l] = move[3 * row][l] * x[0][l] + move[3 * row + 1][l] * x[1][l] +
                          move[3 * row + 2][l] * x[2][l] + move[9 + row][l];
      }
    }
  }

  LaneFloats sum{}, worst{};
  LaneInts which;
  which.fill(-1);
  const LaneFloats* const x = state.places.data();
  for (std::size_t k = 0; k < plan.pairs.size(); ++k) {
    const LanePair& pair = plan.pairs[k];
    const LaneFloats* const a = x + 3 * std::size_t(pair.p);
    const LaneFloats* const b = x + 3 * std::size_t(pair.q);
    const int number = int(k);
    for (std::size_t l = 0; l < L; ++l) {
      const float dx = a[0][l] - b[0][l], dy = a[1][l] - b[1][l], dz = a[2][l] - b[2][l];
      const float lack = 1 - (dx * dx + dy * dy + dz * dz) * pair.inverse_reach2;
      const float inside = lack > 0 ? lack : 0;
      sum[l] += inside * inside;
      which[l] = inside > worst[l] ? number : which[l];
      worst[l] = inside > worst[l] ? inside : worst[l];
    }
  }
  for (std::size_t l = 0; l < L; ++l) {
    state.sterics[l] = float(StericRule::strength) * sum[l];
    state.worst[l] = float(StericRule::strength) * worst[l] * worst[l];
  }
  state.worst_pair = which;
}

}  // namespace ragdoll::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll {

HWY_EXPORT(Place);

LanePlan::LanePlan(const Molecule& molecule, const PartTree& tree, const StericRule& sterics) {
  const std::vector<Vec3>& start = molecule.positions();
  for (std::size_t p = 0; p < tree.parts().size(); ++p) {
    const Part& part = tree.parts()[p];
    LanePart lane;
    lane.parent = part.parent;
    lane.children = int(part.children.size());
    lane.shapes = int(part.shapes.size());
    lane.first = int(atoms.size());
    for (const int atom : part.atoms) {
      atoms.push_back(atom);
      part_of.push_back(int(p));
    }
    lane.last = int(atoms.size());
    if (part.parent >= 0) {
      const Vec3& origin = start[std::size_t(part.inner)];
      const Vec3 axis = (start[std::size_t(part.outer)] - origin).normalized();
      for (std::size_t k = 0; k < 3; ++k) {
        lane.origin[k] = float(origin[Eigen::Index(k)]);
        lane.axis[k] = float(axis[Eigen::Index(k)]);
      }
      const std::vector<int>& siblings = tree.parts()[std::size_t(part.parent)].children;
      while (siblings[std::size_t(lane.place)] != int(p)) ++lane.place;
    }
    for (const PartShape& shape : part.shapes) {
      for (const Vec3& x : shape.positions)
        for (const double value : x) lane.positions.push_back(float(value));
      for (const RigidMove& move : shape.moves) {
        for (Eigen::Index row = 0; row < 3; ++row)
          for (Eigen::Index column = 0; column < 3; ++column)
            lane.moves.push_back(float(move.rotation(row, column)));
        for (const double value : move.translation) lane.moves.push_back(float(value));
      }
    }
    parts.push_back(std::move(lane));
  }
  const auto stays = [&](int part) { return parts[std::size_t(part)].shapes == 1; };
  for (std::size_t i = 0; i < atoms.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const int p = part_of[i], q = part_of[j];
      if (p == q) continue;  // a shape of rings has no clashes of its own
      const bool child = parts[std::size_t(p)].parent == q || parts[std::size_t(q)].parent == p;
      const bool roots = parts[std::size_t(p)].parent < 0 && parts[std::size_t(q)].parent < 0;
      // tables of torsions know pairs across one bond, and separate molecules that stay are given
      if ((child || roots) && stays(p) && stays(q)) continue;
      // what is too near in the start may be as near elsewhere
      const double apart = (start[std::size_t(atoms[i])] - start[std::size_t(atoms[j])]).norm();
      const double reach = std::min(sterics.reach(atoms[i], atoms[j]),
                                    std::max(apart, 1e-3) / StericRule::clash_share);
      if (reach > 0) pairs.push_back({int(j), int(i), float(1 / (reach * reach))});
    }
}

LaneState::LaneState(const LanePlan& plan)
    : bins(plan.parts.size()),
      shapes(plan.parts.size()),
      places(3 * plan.atoms.size()),
      moves(12 * plan.parts.size()) {}

void place_lanes(const LanePlan& plan, LaneState& state) {
  HWY_DYNAMIC_DISPATCH(Place)(plan, state);
}

}  // namespace ragdoll
#endif
