// This file is compiled once for each instruction set, by foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lane_sweep.cpp"
// vectors whose length only the machine knows cannot be kept in arrays
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include <hwy/foreach_target.h>  // first, by its rules
// then
#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

#include <limits>  // max

#include "lane_sweep.h"

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Vectors that are worked on together, so that one computes while the other waits.
constexpr std::size_t together = 2;

template <class D>
struct Kernel {
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;
  using M = hn::Mask<D>;

  static M None() { return hn::MaskFromVec(hn::Zero(D())); }
  static M Load(const T* flags) { return hn::Ne(hn::Load(D(), flags), hn::Zero(D())); }
  static void Raise(M mask, T* flags) {
    const D d;
    hn::Store(hn::IfThenElse(mask, hn::Set(d, T(1)), hn::Load(d, flags)), d, flags);
  }

  struct Point {
    V x, y, z;

    static Point At(const T* p, std::size_t lanes) {
      const D d;
      return {hn::Load(d, p), hn::Load(d, p + lanes), hn::Load(d, p + 2 * lanes)};
    }
    void Store(M mask, const Point& old, T* p, std::size_t lanes) const {
      const D d;
      hn::Store(hn::IfThenElse(mask, x, old.x), d, p);
      hn::Store(hn::IfThenElse(mask, y, old.y), d, p + lanes);
      hn::Store(hn::IfThenElse(mask, z, old.z), d, p + 2 * lanes);
    }
    Point operator-(const Point& o) const {
      return {hn::Sub(x, o.x), hn::Sub(y, o.y), hn::Sub(z, o.z)};
    }
    Point operator+(const Point& o) const {
      return {hn::Add(x, o.x), hn::Add(y, o.y), hn::Add(z, o.z)};
    }
    Point operator*(V by) const { return {hn::Mul(by, x), hn::Mul(by, y), hn::Mul(by, z)}; }
    Point operator/(V by) const { return {hn::Div(x, by), hn::Div(y, by), hn::Div(z, by)}; }
    V dot(const Point& o) const {
      return hn::Add(hn::Add(hn::Mul(x, o.x), hn::Mul(y, o.y)), hn::Mul(z, o.z));
    }
    Point cross(const Point& o) const {
      return {hn::Sub(hn::Mul(y, o.z), hn::Mul(z, o.y)), hn::Sub(hn::Mul(z, o.x), hn::Mul(x, o.z)),
              hn::Sub(hn::Mul(x, o.y), hn::Mul(y, o.x))};
    }
  };

  /// What a sweep finds out about its lanes.
  struct Flags {
    M busy, corrected, held, not_finite;

    Flags() = default;
    Flags(const LaneSweep<T>& sweep, std::size_t first)
        : busy(Load(sweep.busy + first)), corrected(None()), held(None()), not_finite(None()) {}

    void Correct(M mask, V number) {
      corrected = hn::Or(corrected, mask);
      const M number_is = hn::Le(hn::Abs(number), hn::Set(D(), std::numeric_limits<T>::max()));
      not_finite = hn::Or(not_finite, hn::AndNot(number_is, mask));
    }
    void Hold(M mask) { held = hn::Or(held, mask); }

    void Store(const LaneSweep<T>& sweep, std::size_t first) const {
      Raise(corrected, sweep.corrected + first);
      Raise(held, sweep.held + first);
      Raise(not_finite, sweep.not_finite + first);
    }
  };

  /// move_apart() of sweep_arithmetic.h, in the lanes of a mask.
  static void MoveApart(M mask, T* p, T* q, std::size_t lanes, const Point& old_p,
                        const Point& old_q, Point by, V distance, V error, T p_share, T q_share) {
    const D d;
    const V one = hn::Set(d, T(1));
    const M zero = hn::And(mask, hn::Eq(distance, hn::Zero(d)));
    if (HWY_UNLIKELY(!hn::AllFalse(d, zero))) {
      by.x = hn::IfThenElse(zero, one, by.x);
      by.y = hn::IfThenZeroElse(zero, by.y);
      by.z = hn::IfThenZeroElse(zero, by.z);
      distance = hn::IfThenElse(zero, one, distance);
    }
    V p_by, q_by;
    if constexpr (Slack<T>::single) {
      const V whole = hn::Div(error, distance);
      p_by = hn::Mul(hn::Set(d, p_share), whole);
      q_by = hn::Mul(hn::Set(d, q_share), whole);
    } else {
      by = by / distance;
      p_by = hn::Mul(hn::Set(d, p_share), error);
      q_by = hn::Mul(hn::Set(d, q_share), error);
    }
    (old_p - by * p_by).Store(mask, old_p, p, lanes);
    (old_q + by * q_by).Store(mask, old_q, q, lanes);
  }

  /// @tparam count  vectors, side by side
  template <std::size_t count>
  static void Bars(const LaneSweep<T>& sweep, std::size_t first) {
    const D d;
    const std::size_t lanes = sweep.lanes, vector = hn::Lanes(d);
    Flags flags[count];
    for (std::size_t v = 0; v < count; ++v) flags[v] = Flags(sweep, first + v * vector);
    T* const x = sweep.x + first;
    const auto* const corrections = sweep.constraints->corrections.data();
    const auto* const bars = sweep.constraints->bars.data();
    const std::size_t bar_count = sweep.constraints->bars.size();
    for (std::size_t k = 0; k < bar_count; ++k) {
      T* const p = x + std::size_t(bars[k].near) * 3 * lanes;
      T* const q = x + std::size_t(bars[k].far) * 3 * lanes;
      const V lower2 = hn::Set(d, bars[k].lower2), upper2 = hn::Set(d, bars[k].upper2);
      Point at_p[count], at_q[count], by[count];
      V distance2[count];
      M broken[count];
      M any = None();
      for (std::size_t v = 0; v < count; ++v) {
        at_p[v] = Point::At(p + v * vector, lanes);
        at_q[v] = Point::At(q + v * vector, lanes);
        by[v] = at_q[v] - at_p[v];
        distance2[v] = by[v].dot(by[v]);
        const M sure = hn::And(hn::Ge(distance2[v], lower2), hn::Le(distance2[v], upper2));
        broken[v] = hn::AndNot(sure, flags[v].busy);
        any = hn::Or(any, broken[v]);
      }
      if (hn::AllFalse(d, any)) continue;
      const BarCorrection<T>& bar = corrections[k];
      const V length = hn::Set(d, bar.length), slack = hn::Set(d, bar.slack);
      const bool movable = bar.near_share != 0 || bar.far_share != 0;
      for (std::size_t v = 0; v < count; ++v) {
        const V distance = hn::Sqrt(distance2[v]);
        const V error = hn::Sub(length, distance);
        const M wrong = hn::AndNot(hn::Le(hn::Abs(error), slack), broken[v]);
        if (!movable) {
          flags[v].Hold(wrong);
          continue;
        }
        flags[v].Correct(wrong, distance);
        MoveApart(wrong, p + v * vector, q + v * vector, lanes, at_p[v], at_q[v], by[v], distance,
                  error, bar.near_share, bar.far_share);
      }
    }
    for (std::size_t v = 0; v < count; ++v) flags[v].Store(sweep, first + v * vector);
  }

  template <Side side>
  static void Pairs(const std::vector<PairVisit<T>>& pairs, const LaneSweep<T>& sweep,
                    std::size_t first) {
    const D d;
    const std::size_t lanes = sweep.lanes;
    Flags flags(sweep, first);
    for (const PairVisit<T>& pair : pairs) {
      T* const p = sweep.x + first + std::size_t(pair.p) * 3 * lanes;
      T* const q = sweep.x + first + std::size_t(pair.q) * 3 * lanes;
      const Point at_p = Point::At(p, lanes), at_q = Point::At(q, lanes), by = at_q - at_p;
      const V distance2 = by.dot(by), sure2 = hn::Set(d, pair.sure2);
      const M sure = side == Side::upper ? hn::Le(distance2, sure2) : hn::Ge(distance2, sure2);
      const M broken = hn::AndNot(sure, flags.busy);
      if (hn::AllFalse(d, broken)) continue;
      const V distance = hn::Sqrt(distance2);
      const V error = hn::Sub(hn::Set(d, pair.length), distance);
      const V excess = side == Side::upper ? hn::Neg(error) : error;
      const M wrong = hn::AndNot(hn::Le(excess, hn::Set(d, pair.slack)), broken);
      if (pair.p_share == 0 && pair.q_share == 0) {
        flags.Hold(wrong);
        continue;
      }
      flags.Correct(wrong, distance);
      MoveApart(wrong, p, q, lanes, at_p, at_q, by, distance, error, pair.p_share, pair.q_share);
    }
    flags.Store(sweep, first);
  }

  static void BarsAndPairs(const LaneSweep<T>& sweep) {
    const std::size_t vector = hn::Lanes(D());
    std::size_t first = 0;
    for (; first + together * vector <= sweep.lanes; first += together * vector)
      Bars<together>(sweep, first);
    for (; first < sweep.lanes; first += vector) Bars<1>(sweep, first);
    for (first = 0; first < sweep.lanes; first += vector) {
      Pairs<Side::upper>(sweep.constraints->tethers, sweep, first);
      Pairs<Side::lower>(sweep.constraints->contacts, sweep, first);
    }
  }

  static void VolumesOf(const LaneSweep<T>& sweep, std::size_t first) {
    const D d;
    const std::size_t lanes = sweep.lanes;
    Flags flags(sweep, first);
    for (const VolumeVisit<T>& v : sweep.constraints->volumes) {
      T* p[4];
      Point at[4];
      for (int k = 0; k < 4; ++k) {
        p[k] = sweep.x + first + std::size_t(v.joint[k]) * 3 * lanes;
        at[k] = Point::At(p[k], lanes);
      }
      const Point ab = at[1] - at[0], ac = at[2] - at[0], ad = at[3] - at[0];
      const Point b = ac.cross(ad);
      const V volume = ab.dot(b);
      const V lower = hn::Set(d, v.lower), upper = hn::Set(d, v.upper);
      const M below = hn::Lt(volume, lower);
      const V excess = hn::IfThenElse(below, hn::Sub(lower, volume), hn::Sub(volume, upper));
      const M wrong = hn::And(hn::Gt(excess, hn::Set(d, v.slack)), flags.busy);
      if (hn::AllFalse(d, wrong)) continue;
      const Point c = ad.cross(ab), e = ab.cross(ac), sum = b + c + e;
      Point gradient[4] = {{hn::Neg(sum.x), hn::Neg(sum.y), hn::Neg(sum.z)}, b, c, e};
      for (int k = 0; k < 4; ++k)
        if (v.fixed[k]) gradient[k] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
      const V square =
          hn::Add(hn::Add(hn::Add(gradient[0].dot(gradient[0]), gradient[1].dot(gradient[1])),
                          gradient[2].dot(gradient[2])),
                  gradient[3].dot(gradient[3]));
      const M movable = hn::Gt(square, hn::Zero(d));
      flags.Hold(hn::AndNot(movable, wrong));
      const M moves = hn::And(wrong, movable);
      const V step = hn::Div(hn::Sub(hn::IfThenElse(below, lower, upper), volume), square);
      flags.Correct(moves, step);
      for (int k = 0; k < 4; ++k) (at[k] + gradient[k] * step).Store(moves, at[k], p[k], lanes);
    }
    flags.Store(sweep, first);
  }

  static void Volumes(const LaneSweep<T>& sweep) {
    for (std::size_t first = 0; first < sweep.lanes; first += hn::Lanes(D()))
      VolumesOf(sweep, first);
  }

  static M Suspects(const LaneSweep<T>& sweep, const NearVisit<T>& pair, std::size_t first) {
    const D d;
    const T* const x = sweep.x + first;
    const Point by = Point::At(x + std::size_t(pair.q) * 3 * sweep.lanes, sweep.lanes) -
                     Point::At(x + std::size_t(pair.p) * 3 * sweep.lanes, sweep.lanes);
    return hn::AndNot(hn::Gt(by.dot(by), hn::Set(d, pair.sure2)), Load(sweep.busy + first));
  }

  static std::size_t NextContact(const LaneSweep<T>& sweep, const NearVisit<T>* pairs,
                                 std::size_t from, std::size_t count, T* suspects) {
    const D d;
    const std::size_t vector = hn::Lanes(d);
    for (; from < count; ++from) {
      bool found = false;
      for (std::size_t first = 0; first < sweep.lanes; first += vector)
        found |= !hn::AllFalse(d, Suspects(sweep, pairs[from], first));
      if (!found) continue;
      for (std::size_t first = 0; first < sweep.lanes; first += vector)
        hn::Store(hn::IfThenElseZero(Suspects(sweep, pairs[from], first), hn::Set(d, T(1))), d,
                  suspects + first);
      break;
    }
    return from;
  }

  static void Furthest(const T* x, const T* from, std::size_t joints, std::size_t lanes,
                       T* largest2) {
    const D d;
    for (std::size_t first = 0; first < lanes; first += hn::Lanes(d)) {
      V largest = hn::Zero(d);
      for (std::size_t j = 0; j < joints; ++j) {
        const Point move = Point::At(x + first + 3 * j * lanes, lanes) -
                           Point::At(from + first + 3 * j * lanes, lanes);
        largest = hn::Max(largest, move.dot(move));
      }
      hn::Store(largest, d, largest2 + first);
    }
  }

  static LaneKernels<T> Table() {
    return {BarsAndPairs, Volumes,        NextContact,
            Furthest,     hn::Lanes(D()), hwy::TargetName(HWY_TARGET)};
  }
};

const LaneKernels<float>& SingleTable() {
  static const LaneKernels<float> table = Kernel<hn::ScalableTag<float>>::Table();
  return table;
}
const LaneKernels<double>& DoubleTable() {
  static const LaneKernels<double> table = Kernel<hn::ScalableTag<double>>::Table();
  return table;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll {

HWY_EXPORT(SingleTable);
HWY_EXPORT(DoubleTable);

const LaneKernels<float>& single_kernels() {
  return HWY_DYNAMIC_DISPATCH(SingleTable)();
}
const LaneKernels<double>& double_kernels() {
  return HWY_DYNAMIC_DISPATCH(DoubleTable)();
}

}  // namespace ragdoll
#endif
