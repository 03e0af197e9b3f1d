// This file is compiled once for each instruction set, by foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "newton_bars_kernel.cpp"
// vectors whose length only the machine knows cannot be kept in arrays
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include <hwy/foreach_target.h>  // first, by its rules
// then
#include <hwy/highway.h>

#include <algorithm>    // fill
#include <type_traits>  // conditional

#include "newton_bars_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// A bar's constraint d - length = 0 is taken times d, so that its gradient is the vector between
/// its ends and needs no division.
template <class D>
struct Kernel {
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;
  using Task = NewtonBarsTask<T>;

  static void Look(const Task& t) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    V worst = hn::Zero(d), sum = hn::Zero(d), relative = hn::Zero(d), largest = hn::Zero(d);
    T* to = t.d;
    for (std::size_t k = 0; k < t.bar_count; ++k, to += 3 * lanes) {
      const auto& bar = t.bars[k];
      const T* const p = t.x + 3 * lanes * std::size_t(bar.p);
      const T* const q = t.x + 3 * lanes * std::size_t(bar.q);
      const V x = hn::Sub(hn::Load(d, q), hn::Load(d, p));
      const V y = hn::Sub(hn::Load(d, q + lanes), hn::Load(d, p + lanes));
      const V z = hn::Sub(hn::Load(d, q + 2 * lanes), hn::Load(d, p + 2 * lanes));
      const V square = hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x)));
      const V distance = hn::Sqrt(square);
      const V error = hn::Sub(distance, hn::Set(d, bar.length));
      const V excess = hn::Abs(error);
      worst = hn::Max(worst, hn::Mul(excess, hn::Set(d, bar.per_slack)));
      relative = hn::Max(relative, hn::Mul(excess, hn::Set(d, bar.per_length)));
      largest = hn::Max(largest, excess);
      sum = hn::Add(sum, square);
      hn::Store(x, d, to);
      hn::Store(y, d, to + lanes);
      hn::Store(z, d, to + 2 * lanes);
      hn::Store(hn::Mul(error, distance), d, t.z + k * lanes);
      hn::Store(hn::Mul(square, hn::Set(d, bar.weight)), d, t.value + k * lanes);
    }
    hn::Store(worst, d, t.worst);
    hn::Store(relative, d, t.relative);
    hn::Store(largest, d, t.largest);
    hn::Store(sum, d, t.sum);
  }

  static HWY_INLINE V Coupled(const Task& t, std::size_t entry, V x, V y, V z) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    const T* const a = t.d + 3 * lanes * std::size_t(t.entries[entry].row);
    const V product = hn::MulAdd(hn::Load(d, a + 2 * lanes), z,
                                 hn::MulAdd(hn::Load(d, a + lanes), y, hn::Mul(hn::Load(d, a), x)));
    return hn::Mul(product, hn::Set(d, t.entries[entry].coupling));
  }

  /// One conformer alone fits into the caches: there it is quicker to couple all bars at first than
  /// to tell the entries apart. For lanes each look at an entry is a way to memory.
  static constexpr bool kAlone = hn::MaxLanes(D()) == 1;

  /// Entries that other columns are taken from; alone, all.
  static void Couple(const Task& t) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    T* const values = t.value + t.bar_count * lanes;
    const std::size_t count = kAlone ? t.entry_count : t.taken_from_count;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t e = kAlone ? i : std::size_t(t.taken_from[i]);
      const T* const along = t.d + 3 * lanes * std::size_t(t.entries[e].column);
      hn::Store(Coupled(t, e, hn::Load(d, along), hn::Load(d, along + lanes),
                        hn::Load(d, along + 2 * lanes)),
                d, values + e * lanes);
    }
  }

  static void Step(const Task& t) {
    Couple(t);
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    const V least = hn::Set(d, t.least_pivot), one = hn::Set(d, T(1));
    T* const values = t.value + t.bar_count * lanes;
    const int* target = t.targets;
    for (std::size_t k = 0; k < t.bar_count; ++k) {
      // what a redundant bar leaves: others meet it
      const V inverse = hn::Div(one, hn::Max(hn::Load(d, t.value + k * lanes), least));
      hn::Store(inverse, d, t.value + k * lanes);
      const V right = hn::Load(d, t.z + k * lanes);
      const T* const along = t.d + 3 * lanes * k;
      V x = right, y = right, z = right;
      if (!kAlone) {
        x = hn::Load(d, along);
        y = hn::Load(d, along + lanes);
        z = hn::Load(d, along + 2 * lanes);
      }
      for (int e = t.begin[k]; e < t.begin[k + 1]; ++e) {
        const auto& entry = t.entries[e];
        T* const own = values + std::size_t(e) * lanes;
        V value;
        if (kAlone || t.is_taken_from[e]) {
          value = hn::Load(d, own);
        } else {
          value = Coupled(t, std::size_t(e), x, y, z);
          hn::Store(value, d, own);
        }
        const V factor = hn::Mul(value, inverse);
        T* const to_right = t.z + std::size_t(entry.row) * lanes;
        hn::Store(hn::NegMulAdd(factor, right, hn::Load(d, to_right)), d, to_right);
        for (int g = t.begin[k]; g < (kAlone ? e + 1 : e); ++g) {
          T* const to = t.value + std::size_t(*target++) * lanes;
          hn::Store(
              hn::NegMulAdd(factor, hn::Load(d, values + std::size_t(g) * lanes), hn::Load(d, to)),
              d, to);
        }
        if (kAlone) continue;
        T* const to = t.value + std::size_t(*target++) * lanes;
        hn::Store(hn::NegMulAdd(factor, value, hn::Load(d, to)), d, to);
      }
    }
    Finish(t);
  }

  /// From the right side, forward solved, to the joints.
  static void Finish(const Task& t) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    const T* const values = t.value + t.bar_count * lanes;
    const auto busy = hn::Ne(hn::Load(d, t.busy), hn::Zero(d));
    for (std::size_t k = t.bar_count; k-- > 0;) {
      const V right = hn::Load(d, t.z + k * lanes);
      V sum = right;
      for (int e = t.begin[k]; e < t.begin[k + 1]; ++e)
        sum = hn::NegMulAdd(hn::Load(d, values + std::size_t(e) * lanes),
                            hn::Load(d, t.z + std::size_t(t.entries[e].row) * lanes), sum);
      const V multiplier = hn::Mul(sum, hn::Load(d, t.value + k * lanes));
      hn::Store(hn::IfThenElse(busy, multiplier, right), d, t.z + k * lanes);
      const V moves = hn::IfThenElseZero(busy, multiplier);
      const auto& bar = t.bars[k];
      const V by_p = hn::Mul(moves, hn::Set(d, bar.near_weight));
      const V by_q = hn::Mul(moves, hn::Set(d, bar.far_weight));
      T* const p = t.x + 3 * lanes * std::size_t(bar.p);
      T* const q = t.x + 3 * lanes * std::size_t(bar.q);
      const T* const along = t.d + 3 * lanes * k;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t at = axis * lanes;
        const V by = hn::IfThenElseZero(busy, hn::Load(d, along + at));
        hn::Store(hn::MulAdd(by_p, by, hn::Load(d, p + at)), d, p + at);
        hn::Store(hn::NegMulAdd(by_q, by, hn::Load(d, q + at)), d, q + at);
      }
    }
  }

  using Doubles = typename std::conditional<hn::MaxLanes(D()) == 1, hn::FixedTag<double, 1>,
                                            hn::ScalableTag<double>>::type;

  static void Measure(const Task& t) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    const Doubles wide;
    std::fill(t.exact_relative, t.exact_relative + lanes, 0.0);
    std::fill(t.exact_largest, t.exact_largest + lanes, 0.0);
    const V relative = hn::Load(d, t.relative_from), largest = hn::Load(d, t.largest_from);
    for (std::size_t k = 0; k < t.bar_count; ++k) {
      const auto& bar = t.bars[k];
      const V size = hn::Mul(hn::Abs(hn::Load(d, t.z + k * lanes)), hn::Set(d, bar.per_length));
      const auto small = hn::And(hn::Lt(size, largest),
                                 hn::Lt(hn::Mul(size, hn::Set(d, bar.per_length)), relative));
      if (hn::AllTrue(d, small)) continue;
      for (std::size_t lane = 0; lane < lanes; lane += hn::Lanes(wide)) MeasureBar(t, k, lane);
    }
  }

  static void MeasureBar(const Task& t, std::size_t k, std::size_t lane) {
    const Doubles d;
    using W = hn::Vec<Doubles>;
    const hn::Rebind<T, Doubles> narrow;
    const std::size_t lanes = hn::Lanes(D());
    const T* const p = t.x + 3 * lanes * std::size_t(t.bars[k].p) + lane;
    const T* const q = t.x + 3 * lanes * std::size_t(t.bars[k].q) + lane;
    const auto along = [&](std::size_t at) {
      return hn::Sub(hn::PromoteTo(d, hn::LoadU(narrow, q + at)),
                     hn::PromoteTo(d, hn::LoadU(narrow, p + at)));
    };
    const W x = along(0), y = along(lanes), z = along(2 * lanes);
    const W square = hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x)));
    const W excess = hn::Abs(hn::Sub(hn::Sqrt(square), hn::Set(d, t.lengths[2 * k])));
    const W share = hn::Mul(excess, hn::Set(d, t.lengths[2 * k + 1]));
    double *const relative = t.exact_relative + lane, *const largest = t.exact_largest + lane;
    hn::StoreU(hn::Max(hn::LoadU(d, relative), share), d, relative);
    hn::StoreU(hn::Max(hn::LoadU(d, largest), excess), d, largest);
  }

  static const NewtonBarsKernel<T>& Table() {
    static const NewtonBarsKernel<T> table = [] {
      NewtonBarsKernel<T> all = {Look, Step, nullptr, hn::Lanes(D())};
      if constexpr (sizeof(T) == sizeof(float)) all.measure = Measure;
      return all;
    }();
    return table;
  }
};

const NewtonBarsKernel<float>& WideSingles() {
  return Kernel<hn::ScalableTag<float>>::Table();
}
const NewtonBarsKernel<double>& WideDoubles() {
  return Kernel<hn::ScalableTag<double>>::Table();
}
const NewtonBarsKernel<float>& Singles() {
  return Kernel<hn::FixedTag<float, 1>>::Table();
}
const NewtonBarsKernel<double>& Doubles() {
  return Kernel<hn::FixedTag<double, 1>>::Table();
}
const char* Instructions() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll {

HWY_EXPORT(WideSingles);
HWY_EXPORT(WideDoubles);
HWY_EXPORT(Singles);
HWY_EXPORT(Doubles);
HWY_EXPORT(Instructions);

template <>
const NewtonBarsKernel<float>& newton_bars_kernel<float>(bool wide) {
  return wide ? HWY_DYNAMIC_DISPATCH(WideSingles)() : HWY_DYNAMIC_DISPATCH(Singles)();
}
template <>
const NewtonBarsKernel<double>& newton_bars_kernel<double>(bool wide) {
  return wide ? HWY_DYNAMIC_DISPATCH(WideDoubles)() : HWY_DYNAMIC_DISPATCH(Doubles)();
}
const char* newton_bars_instructions() {
  return HWY_DYNAMIC_DISPATCH(Instructions)();
}

}  // namespace ragdoll
#endif
