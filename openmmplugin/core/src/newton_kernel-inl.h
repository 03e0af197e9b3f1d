// NewtonKernel: the arithmetic of `newton`, one conformer or one in each lane of a vector. Compiled
// once for each set of instructions, from newton_engine.cpp.
//
// What happens to one conformer's numbers is the same chain of operations in every lane and in the
// single run, whose vectors hold the three rows of a block's column (and one row of padding)
// instead: so a lane's result is the single run's, bit for bit.

#if defined(RAGDOLL_NEWTON_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RAGDOLL_NEWTON_KERNEL_INL_H_
#undef RAGDOLL_NEWTON_KERNEL_INL_H_
#else
#define RAGDOLL_NEWTON_KERNEL_INL_H_
#endif

#include <cstddef>
#include <optional>
#include <type_traits>  // is_same
#include <vector>

#include <hwy/highway.h>

#include "newton_entry-inl.h"      // NewtonEntry
#include "newton_factor-inl.h"     // NewtonFactor
#include "newton_gradients-inl.h"  // NewtonGradients
#include "newton_plan.h"           // NewtonPlan
#include "newton_rows-inl.h"       // NewtonRows
#include "newton_tables.h"         // NewtonTables

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {

template <class T, bool kSingle>
class NewtonKernel : private NewtonLayout<T, kSingle> {
  using Layout = NewtonLayout<T, kSingle>;
  using Layout::kPadded;
  using Layout::load, Layout::wide, Layout::all;
  using typename Layout::P;
  using typename Layout::W;

 public:
  using Layout::kLanes, Layout::N, Layout::kJoint;
  using typename Layout::D;
  using typename Layout::V;

  NewtonKernel(const NewtonPlan& plan, const NewtonTables<T>& tables, bool with_extras)
      : plan_(plan),
        tables_(tables),
        mirror(std::size_t(plan.mirrors) * N),
        x(std::size_t(plan.joints) * kJoint),
        trial(std::size_t(plan.joints) * kJoint),
        corrected(std::size_t(plan.joints) * kJoint),
        rows_(plan),
        entry_(plan, rows_, with_extras) {
    if constexpr (kMakesGradients)
      if (plan.is_bulky) gradients_.emplace(plan, tables.masses, rows_);
    if (!plan.is_bulky) factor_.emplace(plan, tables.masses, entry_);
  }

  /// Of lanes: half the sum of the squared rows, the largest violations.
  struct Measure {
    HWY_ALIGN T energy[N], relative[N], nanometers[N];
  };

  /// How rows are made, of lanes: T(1) or 0.
  struct Manner {
    HWY_ALIGN T pulled[N];   ///< volumes that the bars leave one value are rows within bounds too
    HWY_ALIGN T turning[N];  ///< stretched pairs resist turning
  };

  /// Rows, their gradients, and what they sum up to. Violations are those of the bounds.
  /// @tparam kGradients  whether gradients are made, or left as they were, for `correct`
  template <bool kGradients = true>
  void evaluate(const Field<T>& at, const Manner& manner, Measure& measure) {
    const D d;
    V energy[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    V relative = hn::Zero(d), nanometers = hn::Zero(d);
    const V turning = hn::LoadU(d, manner.turning), pulled = hn::LoadU(d, manner.pulled);
    const std::size_t count = tables_.pairs.size();
    std::size_t k = 0;
    if constexpr (kPadded) {
      k = evaluate_four_pairs<kGradients>(at, manner.turning[0], energy, relative, nanometers);
    } else {
      for (; k + 4 <= count; k += 4) {
        evaluate_pair<kGradients>(at, k, turning, energy[0], relative, nanometers);
        evaluate_pair<kGradients>(at, k + 1, turning, energy[1], relative, nanometers);
        evaluate_pair<kGradients>(at, k + 2, turning, energy[2], relative, nanometers);
        evaluate_pair<kGradients>(at, k + 3, turning, energy[3], relative, nanometers);
      }
    }
    for (std::size_t e = 0; k < count; ++k, ++e)
      evaluate_pair<kGradients>(at, k, turning, energy[e], relative, nanometers);
    V sum = hn::Add(hn::Add(energy[0], energy[1]), hn::Add(energy[2], energy[3]));
    V volume_energy = hn::Zero(d);
    for (std::size_t v = 0; v < tables_.volumes.size(); ++v)
      evaluate_volume<kGradients>(at, v, pulled, volume_energy, relative, nanometers);
    sum = hn::Mul(hn::Set(d, T(0.5)), hn::Add(sum, volume_energy));
    hn::StoreU(sum, d, measure.energy);
    hn::StoreU(relative, d, measure.relative);
    hn::StoreU(nanometers, d, measure.nanometers);
  }

  /// The largest violations at x in doubles, of lanes.
  struct Exact {
    HWY_ALIGN double relative[N], nanometers[N];
  };
  void measure_exactly(const NewtonTables<double>& tables, Exact& exact) const {
    const Doubles d;
    constexpr std::size_t step = hn::MaxLanes(Doubles());
    for (std::size_t lane = 0; lane < N; lane += step) {
      DoublesOf relative = hn::Zero(d), nanometers = hn::Zero(d);
      for (const auto& pair : tables.pairs) {
        DoublesOf e[3];
        edge(pair.p, pair.q, lane, e);
        const DoublesOf row =
            row_of(d, e[0], e[1], e[2], hn::Set(d, pair.length), hn::Set(d, pair.side));
        const DoublesOf size = hn::Abs(row);
        relative = hn::Max(hn::Mul(size, hn::Set(d, pair.inverse_length)), relative);
        nanometers = hn::Max(size, nanometers);
      }
      for (const auto& v : tables.volumes) {
        DoublesOf e[3][3], g[3];
        for (std::size_t j = 0; j < 3; ++j) edge(v.slot[0], v.slot[j + 1], lane, e[j]);
        cross(e[1], e[2], g);
        const DoublesOf size = hn::Abs(excess_of(d, v, dot(e[0], g)));
        relative = hn::Max(hn::Mul(size, hn::Set(d, v.inverse_scale)), relative);
        nanometers = hn::Max(hn::Mul(size, hn::Set(d, v.inverse_area)), nanometers);
      }
      hn::StoreU(relative, d, exact.relative + lane);
      hn::StoreU(nanometers, d, exact.nanometers + lane);
    }
  }

  /// One Gauss-Seidel sweep over pairs and volumes in the lanes of `mask` (T(1) or 0); what is
  /// violated beyond its slack is corrected. `changed` is 1 in lanes where something was.
  void sweep(const T* mask, T* changed) {
    const D d;
    const auto on = hn::Gt(hn::LoadU(d, mask), hn::Zero(d));
    V any = hn::Zero(d);
    for (const auto& pair : tables_.pairs) sweep_pair(pair, on, any);
    for (const auto& pair : tables_.far) sweep_pair(pair, on, any);
    for (const auto& volume : tables_.volumes) sweep_volume(volume, on, any);
    hn::StoreU(any, d, changed);
  }

  NewtonEntry<T, kSingle>& entry() { return entry_; }

  /// Instead of a factor, for plans that are bulky: one conformer in doubles.
  static constexpr bool kMakesGradients = kSingle && std::is_same<T, double>::value;
  NewtonGradients& gradients() { return *gradients_; }

  /// The step from the rows evaluated last; trial = x + step.
  void solve(const T* mu, T* predicted, T* positive) {
    if constexpr (kMakesGradients)
      if (gradients_) return gradients_->solve(x, *mu, trial, predicted, positive);
    factor_->solve(x, mu, trial, predicted, positive);
  }

  /// One more step by the factor and the gradients at hand, from rows that were evaluated at the
  /// trial without gradients; corrected = trial + step.
  void correct() { factor_->correct(trial, corrected); }

  /// trial = corrected in the lanes of `mask`.
  void keep_correction(const T* mask) { blend(mask, corrected, trial); }

  /// x = trial in the lanes of `mask`.
  void accept(const T* mask) { blend(mask, trial, x); }

  /// The squares of how far that joint has moved which moved furthest.
  void furthest(const Field<T>& at, const Field<T>& from, T* largest2) const {
    const D d;
    V largest = hn::Zero(d);
    const std::size_t end = std::size_t(plan_.moving) * kJoint;
    for (std::size_t e = 0; e < end; e += kJoint) {
      const V d0 = hn::Sub(load(at + e), load(from + e)),
              d1 = hn::Sub(load(at + e + N), load(from + e + N)),
              d2 = hn::Sub(load(at + e + 2 * N), load(from + e + 2 * N));
      largest = hn::Max(hn::MulAdd(d2, d2, hn::MulAdd(d1, d1, hn::Mul(d0, d0))), largest);
    }
    hn::StoreU(largest, d, largest2);
  }

 private:
  using Doubles =
      typename std::conditional<kSingle, hn::CappedTag<double, 1>, hn::ScalableTag<double>>::type;
  using DoublesOf = hn::VFromD<Doubles>;

  /// From p to q at x, of as many lanes as doubles have.
  HWY_INLINE void edge(int p, int q, std::size_t lane, DoublesOf* e) const {
    const hn::Rebind<T, Doubles> d;
    const T* from = x + std::size_t(p) * kJoint + lane;
    const T* to = x + std::size_t(q) * kJoint + lane;
    for (std::size_t c = 0; c < 3; ++c)
      e[c] = hn::Sub(hn::PromoteTo(Doubles(), hn::LoadU(d, to + c * N)),
                     hn::PromoteTo(Doubles(), hn::LoadU(d, from + c * N)));
  }

  const NewtonPlan& plan_;
  const NewtonTables<T>& tables_;

 public:
  Field<T> mirror;  ///< 1 or -1, by group and lane
  Field<T> x, trial,
      corrected;  ///< positions; [slot][axis][lane], padded to four axes for one conformer

 private:
  void blend(const T* mask, const Field<T>& from, Field<T>& to) const {
    const D d;
    const auto on = hn::Gt(hn::LoadU(d, mask), hn::Zero(d));
    const std::size_t end = std::size_t(plan_.moving) * kJoint;
    for (std::size_t e = 0; e < end; e += N)
      hn::StoreU(hn::IfThenElse(on, load(from + e), load(to + e)), d, to + e);
  }

  NewtonRows<T, kSingle> rows_;
  NewtonEntry<T, kSingle> entry_;
  std::optional<NewtonFactor<T, kSingle>> factor_;
  std::optional<NewtonGradients> gradients_;

  // === Rows

  template <bool kGradients>
  HWY_INLINE void evaluate_pair(const Field<T>& at, std::size_t k, V turning, V& energy,
                                V& relative, V& nanometers) {
    const D d;
    const auto& pair = tables_.pairs[k];
    const T* p = at + std::size_t(pair.p) * kJoint;
    const T* q = at + std::size_t(pair.q) * kJoint;
    const V d0 = hn::Sub(load(q), load(p)), d1 = hn::Sub(load(q + N), load(p + N)),
            d2 = hn::Sub(load(q + 2 * N), load(p + 2 * N));
    V row;
    if constexpr (kGradients) {
      V u[3], turn;
      rows_of(d, d0, d1, d2, hn::Set(d, pair.length), hn::Set(d, pair.side), turning, u, turn, row);
      T* unit = rows_.unit + k * 4 * N;
      hn::StoreU(u[0], d, unit);
      hn::StoreU(u[1], d, unit + N);
      hn::StoreU(u[2], d, unit + 2 * N);
      hn::StoreU(turn, d, unit + 3 * N);
    } else {
      row = row_of(d, d0, d1, d2, hn::Set(d, pair.length), hn::Set(d, pair.side));
    }
    hn::StoreU(row, d, rows_.row + k * N);
    energy = hn::MulAdd(row, row, energy);
    const V size = hn::Abs(row);
    relative = hn::Max(hn::Mul(size, hn::Set(d, pair.inverse_length)), relative);
    nanometers = hn::Max(size, nanometers);
  }

  /// A stretched pair resists turning too; what a short one gains by it is left out. A pair on the
  /// right side of its bound is no row.
  template <class Tag, class Vec>
  static HWY_INLINE void rows_of(Tag d, Vec d0, Vec d1, Vec d2, Vec length, Vec side, Vec turning,
                                 Vec* u, Vec& turn, Vec& row) {
    const Vec zero = hn::Zero(d), one = hn::Set(d, T(1));
    const Vec square = hn::MulAdd(d2, d2, hn::MulAdd(d1, d1, hn::Mul(d0, d0)));
    const Vec distance = hn::Sqrt(square);
    const Vec inverse = hn::Div(one, distance);
    row = hn::Sub(distance, length);
    const auto apart = hn::Gt(square, zero);
    u[0] = hn::IfThenElse(apart, hn::Mul(d0, inverse), one);
    u[1] = hn::IfThenElseZero(apart, hn::Mul(d1, inverse));
    u[2] = hn::IfThenElseZero(apart, hn::Mul(d2, inverse));
    turn = hn::IfThenElseZero(apart, hn::Max(hn::Mul(hn::Mul(row, inverse), turning), zero));
    const auto idle = hn::Lt(hn::Mul(side, row), zero);
    for (int c = 0; c < 3; ++c) u[c] = hn::IfThenZeroElse(idle, u[c]);
    turn = hn::IfThenZeroElse(idle, turn);
    row = hn::IfThenZeroElse(idle, row);
  }

  template <class Tag, class Vec>
  static HWY_INLINE Vec row_of(Tag d, Vec d0, Vec d1, Vec d2, Vec length, Vec side) {
    const Vec square = hn::MulAdd(d2, d2, hn::MulAdd(d1, d1, hn::Mul(d0, d0)));
    const Vec row = hn::Sub(hn::Sqrt(square), length);
    return hn::IfThenZeroElse(hn::Lt(hn::Mul(side, row), hn::Zero(d)), row);
  }

  /// Four pairs in one vector. @return how many pairs are done
  template <bool kGradients>
  HWY_INLINE std::size_t evaluate_four_pairs(const Field<T>& at, T turning, V* energy, V& relative,
                                             V& nanometers) {
    const P d;
    W sum = hn::Zero(d), far = hn::Zero(d), long_ = hn::Zero(d);
    const std::size_t count = tables_.pairs.size();
    HWY_ALIGN T buffer[16];
    std::size_t k = 0;
    for (; k + 4 <= count; k += 4) {
      const auto* pair = &tables_.pairs[k];
      for (std::size_t e = 0; e < 4; ++e)
        hn::StoreU(
            hn::Sub(wide(at + std::size_t(pair[e].q) * 4), wide(at + std::size_t(pair[e].p) * 4)),
            d, buffer + 4 * e);
      W d0, d1, d2, pad;
      hn::LoadInterleaved4(d, buffer, d0, d1, d2, pad);
      HWY_ALIGN const T lengths[4] = {pair[0].length, pair[1].length, pair[2].length,
                                      pair[3].length};
      HWY_ALIGN const T inverses[4] = {pair[0].inverse_length, pair[1].inverse_length,
                                       pair[2].inverse_length, pair[3].inverse_length};
      HWY_ALIGN const T sides[4] = {pair[0].side, pair[1].side, pair[2].side, pair[3].side};
      W row;
      if constexpr (kGradients) {
        W u[3], turn;
        rows_of(d, d0, d1, d2, wide(lengths), wide(sides), all(turning), u, turn, row);
        hn::StoreInterleaved4(u[0], u[1], u[2], turn, d, rows_.unit + 4 * k);
      } else {
        row = row_of(d, d0, d1, d2, wide(lengths), wide(sides));
      }
      hn::StoreU(row, d, rows_.row + k);
      sum = hn::MulAdd(row, row, sum);
      const W size = hn::Abs(row);
      far = hn::Max(hn::Mul(size, wide(inverses)), far);
      long_ = hn::Max(size, long_);
    }
    const D one;
    HWY_ALIGN T sums[4], fars[4], longs[4];
    hn::StoreU(sum, d, sums);
    hn::StoreU(far, d, fars);
    hn::StoreU(long_, d, longs);
    for (std::size_t e = 0; e < 4; ++e) {
      energy[e] = hn::Set(one, sums[e]);
      relative = hn::Max(hn::Set(one, fars[e]), relative);
      nanometers = hn::Max(hn::Set(one, longs[e]), nanometers);
    }
    return k;
  }

  using Corners = typename NewtonTables<T>::Corners;

  /// Signed volume; the edges from a, and the gradient at b.
  HWY_INLINE V volume_of(const Field<T>& at, const Corners& volume, V (*e)[3], V* g) const {
    const T* a = at + std::size_t(volume.slot[0]) * kJoint;
    for (std::size_t j = 0; j < 3; ++j) {
      const T* end = at + std::size_t(volume.slot[j + 1]) * kJoint;
      for (std::size_t c = 0; c < 3; ++c) e[j][c] = hn::Sub(load(end + c * N), load(a + c * N));
    }
    cross(e[1], e[2], g);
    return dot(e[0], g);
  }

  /// Volume less its nearer bound, 0 between them.
  template <class Tag, class Volume, class Vec>
  static HWY_INLINE Vec excess_of(Tag d, const Volume& volume, Vec size) {
    // in this order what is no number stays none
    const Vec zero = hn::Zero(d);
    return hn::Add(hn::Min(zero, hn::Sub(size, hn::Set(d, volume.lower))),
                   hn::Max(zero, hn::Sub(size, hn::Set(d, volume.upper))));
  }

  using Pair = typename NewtonTables<T>::Pair;

  /// To its length, or back to its bound.
  template <class Mask>
  HWY_INLINE void sweep_pair(const Pair& pair, Mask on, V& any) {
    const D d;
    T* p = x + std::size_t(pair.p) * kJoint;
    T* q = x + std::size_t(pair.q) * kJoint;
    const V d0 = hn::Sub(load(q), load(p)), d1 = hn::Sub(load(q + N), load(p + N)),
            d2 = hn::Sub(load(q + 2 * N), load(p + 2 * N));
    const V square = hn::MulAdd(d2, d2, hn::MulAdd(d1, d1, hn::Mul(d0, d0)));
    const V distance = hn::Sqrt(square);
    const V row = hn::Sub(distance, hn::Set(d, pair.length));
    auto wrong = hn::And(hn::Gt(hn::Abs(row), hn::Set(d, pair.slack)), on);
    if (pair.side != 0)
      wrong = hn::AndNot(hn::Lt(hn::Mul(row, hn::Set(d, pair.side)), hn::Zero(d)), wrong);
    if (hn::AllFalse(d, wrong)) return;
    any = hn::IfThenElse(wrong, hn::Set(d, T(1)), any);
    const auto apart = hn::Gt(square, hn::Zero(d));
    const V factor = hn::IfThenElseZero(wrong, hn::Div(row, distance));
    const V m0 = hn::IfThenElse(apart, hn::Mul(factor, d0), hn::IfThenElseZero(wrong, row));
    const V m1 = hn::IfThenElseZero(apart, hn::Mul(factor, d1));
    const V m2 = hn::IfThenElseZero(apart, hn::Mul(factor, d2));
    const V sp = hn::Set(d, pair.share_p), sq = hn::Set(d, pair.share_q);
    hn::StoreU(hn::MulAdd(sp, m0, load(p)), d, p);
    hn::StoreU(hn::MulAdd(sp, m1, load(p + N)), d, p + N);
    hn::StoreU(hn::MulAdd(sp, m2, load(p + 2 * N)), d, p + 2 * N);
    hn::StoreU(hn::NegMulAdd(sq, m0, load(q)), d, q);
    hn::StoreU(hn::NegMulAdd(sq, m1, load(q + N)), d, q + N);
    hn::StoreU(hn::NegMulAdd(sq, m2, load(q + 2 * N)), d, q + 2 * N);
  }

  /// To its nearer bound along its gradient.
  template <class Mask>
  HWY_INLINE void sweep_volume(const Corners& volume, Mask on, V& any) {
    const D d;
    V e[3][3], g[4][3];
    const V excess = excess_of(d, volume, volume_of(x, volume, e, g[1]));
    auto wrong = hn::And(hn::Gt(hn::Abs(excess), hn::Set(d, volume.slack)), on);
    if (hn::AllFalse(d, wrong)) return;
    finish_gradient(e, g);
    V square = hn::Zero(d);
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t c = 0; c < 3; ++c)
        square = hn::MulAdd(hn::Mul(hn::Set(d, volume.share[j]), g[j][c]), g[j][c], square);
    // where no direction changes the volume: all fixed, or all joints on a line
    wrong = hn::And(wrong, hn::Gt(square, hn::Zero(d)));
    any = hn::IfThenElse(wrong, hn::Set(d, T(1)), any);
    const V step = hn::IfThenElseZero(wrong, hn::Div(excess, square));
    for (std::size_t j = 0; j < 4; ++j) {
      T* corner = x + std::size_t(volume.slot[j]) * kJoint;
      const V move = hn::Mul(step, hn::Set(d, volume.share[j]));
      for (std::size_t c = 0; c < 3; ++c)
        hn::StoreU(hn::NegMulAdd(move, g[j][c], load(corner + c * N)), d, corner + c * N);
    }
  }

  static HWY_INLINE void finish_gradient(const V (*e)[3], V (*g)[3]) {
    cross(e[2], e[0], g[2]);
    cross(e[0], e[1], g[3]);
    for (std::size_t c = 0; c < 3; ++c)
      g[0][c] = hn::Sub(hn::Zero(D()), hn::Add(hn::Add(g[1][c], g[2][c]), g[3][c]));
  }

  template <bool kGradients>
  HWY_INLINE void evaluate_volume(const Field<T>& at, std::size_t v, V pulled, V& energy,
                                  V& relative, V& nanometers) {
    const D d;
    const auto& volume = tables_.volumes[v];
    V e[3][3], g[4][3];
    const V size = volume_of(at, volume, e, g[1]), excess = excess_of(d, volume, size);
    const auto aimed = hn::Gt(hn::Mul(pulled, hn::Set(d, volume.pulled)), hn::Zero(d));
    V aim = hn::Set(d, volume.aim);
    if (volume.mirror >= 0) aim = hn::Mul(aim, load(mirror + std::size_t(volume.mirror) * N));
    const V off = hn::IfThenElse(aimed, hn::Sub(size, aim), excess);
    const auto active = hn::Ne(off, hn::Zero(d));
    if constexpr (kGradients) rows_.active[v] = !hn::AllFalse(d, active);
    if (hn::AllFalse(d, active)) {
      if (!kGradients) hn::StoreU(hn::Zero(d), d, rows_.excess + v * N);
      return;
    }
    const V scale = hn::IfThenElseZero(active, hn::Set(d, volume.inverse_area));
    if constexpr (kGradients) {
      finish_gradient(e, g);
      T* gradient = rows_.gradient + v * 4 * kJoint;
      for (std::size_t j = 0; j < 4; ++j)
        for (std::size_t c = 0; c < 3; ++c)
          hn::StoreU(hn::Mul(g[j][c], scale), d, gradient + j * kJoint + c * N);
    }
    const V row = hn::Mul(off, scale);
    hn::StoreU(row, d, rows_.excess + v * N);
    energy = hn::MulAdd(row, row, energy);
    const V absolute = hn::Abs(excess);
    relative = hn::Max(hn::Mul(absolute, hn::Set(d, volume.inverse_scale)), relative);
    nanometers = hn::Max(hn::Mul(absolute, scale), nanometers);
  }

  template <class Vec>
  static HWY_INLINE void cross(const Vec* a, const Vec* b, Vec* result) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t i = (c + 1) % 3, j = (c + 2) % 3;
      result[c] = hn::NegMulAdd(a[j], b[i], hn::Mul(a[i], b[j]));
    }
  }
  template <class Vec>
  static HWY_INLINE Vec dot(const Vec* a, const Vec* b) {
    return hn::MulAdd(a[2], b[2], hn::MulAdd(a[1], b[1], hn::Mul(a[0], b[0])));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#endif
