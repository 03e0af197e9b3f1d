// NewtonFactor: the elimination of `newton`: J^T J + mu as a product of block triangles, and the
// step by it. Compiled once for each set of instructions, from newton_engine.cpp.

#if defined(RAGDOLL_NEWTON_FACTOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RAGDOLL_NEWTON_FACTOR_INL_H_
#undef RAGDOLL_NEWTON_FACTOR_INL_H_
#else
#define RAGDOLL_NEWTON_FACTOR_INL_H_
#endif

#include <cstddef>
#include <type_traits>  // conditional, is_same
#include <vector>

#include <hwy/highway.h>

#include "newton_entry-inl.h"  // NewtonEntry
#include "newton_plan.h"       // NewtonPlan
#include "newton_rows-inl.h"   // NewtonLayout

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {

/// Columns are made in panels, which are used anew once no later column is made of them: so what is
/// worked on stays in the cache, however long the framework. What the substitution needs of them is
/// kept closely packed and as floats: a step that is right to seven digits of the size it has is as
/// good as any, and how much is stored and read again is what a long framework's time goes to.
template <class T, bool kSingle>
class NewtonFactor : private NewtonLayout<T, kSingle> {
  using Layout = NewtonLayout<T, kSingle>;
  using Layout::load, Layout::wide, Layout::all;
  using Layout::N, Layout::kJoint, Layout::kBlock, Layout::kPadded;
  using typename Layout::D;
  using typename Layout::P;
  using typename Layout::V;
  using typename Layout::W;

  /// Lanes of floats are packed as they are: panels that are kept need no copy.
  static constexpr bool kInPlace = !kSingle && std::is_same<T, float>::value;
  static constexpr std::size_t kKeptColumn = 3 * N, kKept = 9 * N;

 public:
  /// @param masses  by slot: what mu is multiplied by
  NewtonFactor(const NewtonPlan& plan, const std::vector<T>& masses,
               const NewtonEntry<T, kSingle>& entry)
      : plan_(plan),
        masses_(masses),
        entry_(entry),
        y_(std::size_t(plan.moving) * kJoint),
        panels_((kInPlace ? plan.row.size() + std::size_t(plan.moving)
                          : std::size_t(plan.panel_blocks)) *
                kBlock) {
    // four numbers at a time reach beyond the last one
    if (!kInPlace)
      kept_ = Field<float>((plan.row.size() + std::size_t(plan.moving)) * kKept +
                           std::size_t(plan.moving));
  }

  /// The step from the rows evaluated last; trial = x + step.
  /// @param mu         of each lane
  /// @param predicted  what the step takes from the energy, by the linear rows and mu's hold
  /// @param positive   0 in lanes where the matrix is not positive
  void solve(const Field<T>& x, const T* mu, Field<T>& trial, T* predicted, T* positive) {
    const D d;
    V good = hn::Set(d, T(1));
    const V v_mu = hn::LoadU(d, mu);
    const int* target = plan_.target.data();
    for (int k = 0; k < plan_.moving; ++k) target = eliminate(std::size_t(k), v_mu, target, good);
    hn::StoreU(good, d, positive);
    const W zero = hn::Zero(P());
    W gain[3] = {zero, zero, zero};  // of each axis; or of all in one vector
    for (int k = plan_.moving; k-- > 0;)
      substitute<true>(std::size_t(k), x, trial, hn::Mul(v_mu, hn::Set(d, masses_[std::size_t(k)])),
                       gain);
    keep_fixed(x, trial);
    if constexpr (kPadded) {
      HWY_ALIGN T axes[4];
      hn::StoreU(gain[0], P(), axes);
      *predicted = T(0.5) * ((axes[0] + axes[1]) + axes[2]);
    } else {
      const V sum = hn::Add(hn::Add(gain[0], gain[1]), gain[2]);
      hn::StoreU(hn::Mul(hn::Set(d, T(0.5)), sum), d, predicted);
    }
  }

  /// A step of the same factor and gradients from other rows: corrected = trial + step.
  void correct(const Field<T>& trial, Field<T>& corrected) {
    for (int k = 0; k < plan_.moving; ++k)
      entry_.pull(std::size_t(k), y_ + std::size_t(k) * kJoint);
    for (int k = 0; k < plan_.moving; ++k) forward(std::size_t(k));
    for (int k = plan_.moving; k-- > 0;)
      substitute<false>(std::size_t(k), trial, corrected, hn::Zero(D()), nullptr);
    keep_fixed(trial, corrected);
  }

 private:
  const NewtonPlan& plan_;
  const std::vector<T>& masses_;
  const NewtonEntry<T, kSingle>& entry_;
  Field<T> y_;       ///< the right side, then the step
  Field<T> panels_;  ///< inverse of the diagonal block, then the blocks below
  Field<float> kept_;

  std::size_t blocks(std::size_t s) const {
    return std::size_t(plan_.column[s + 1] - plan_.column[s]);
  }
  T* panel(std::size_t s) const {
    if constexpr (kInPlace) return panels_ + (std::size_t(plan_.column[s]) + s) * kBlock;
    return panels_ + std::size_t(plan_.panel[s]) * kBlock;
  }
  T* panel(const NewtonPlan::Source& source) const {
    if constexpr (kInPlace) return panel(std::size_t(source.column));
    return panels_ + std::size_t(source.panel) * kBlock;
  }
  void keep_fixed(const Field<T>& from, Field<T>& to) const {
    for (std::size_t e = std::size_t(plan_.moving) * kJoint; e < to.size(); ++e) to[e] = from[e];
  }
  float* kept(std::size_t s) const {
    if constexpr (kInPlace) return panel(s);
    return kept_ + (std::size_t(plan_.column[s]) + s) * kKept + s;
  }

  static HWY_INLINE V load_kept(const float* at) {
    const hn::Rebind<float, D> d;
    if constexpr (std::is_same<T, float>::value)
      return hn::LoadU(d, at);
    else
      return hn::PromoteTo(D(), hn::LoadU(d, at));
  }
  static HWY_INLINE W wide_kept(const float* at) {
    const hn::Rebind<float, P> d;
    if constexpr (std::is_same<T, float>::value)
      return hn::LoadU(d, at);
    else
      return hn::PromoteTo(P(), hn::LoadU(d, at));
  }
  static HWY_INLINE void keep(V value, float* to) {
    const hn::Rebind<float, D> d;
    if constexpr (std::is_same<T, float>::value)
      hn::StoreU(value, d, to);
    else
      hn::StoreU(hn::DemoteTo(d, value), d, to);
  }
  /// Packs a column of one conformer that no other is made of any more.
  HWY_INLINE void keep_column(std::size_t s, std::size_t count, const T* from) {
    const hn::Rebind<float, P> d;
    float* to = kept(s);
    for (std::size_t e = 0; e < 3 * (count + 1); ++e, from += 4, to += 3) {
      // what comes next is stored over the fourth number
      if constexpr (std::is_same<T, float>::value)
        hn::StoreU(wide(from), d, to);
      else
        hn::StoreU(hn::DemoteTo(d, wide(from)), d, to);
    }
  }

  // === Elimination

  /// Column s: entered, less the columns before it, its diagonal inverted; the right side beside.
  HWY_INLINE const int* eliminate(std::size_t s, V mu, const int* target, V& good) {
    const D d;
    T* inverse = panel(s);
    V a[6];
    const V hold = hn::Mul(mu, hn::Set(d, masses_[s]));
    if constexpr (kPadded) {
      target = eliminate_padded(s, hold, inverse, target, a);
    } else {
      target = eliminate_lanes(s, hold, inverse, target, a);
    }
    invert(a, good);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t r = 0; r < 3; ++r) {
        const V value = a[triangle(r, c)];
        hn::StoreU(value, d, inverse + c * kJoint + r * N);
        if constexpr (!kInPlace && !kPadded) keep(value, kept(s) + c * kKeptColumn + r * N);
      }
    if constexpr (kPadded)
      if (blocks(s) == 0) keep_column(s, 0, inverse);
    return target;
  }

  /// Place of row r and column c in a lower triangle by columns.
  static constexpr std::size_t triangle(std::size_t r, std::size_t c) {
    return r < c ? triangle(c, r) : (c == 0 ? r : c == 1 ? r + 2 : 5);
  }

  /// Of a lower triangle by columns, 00 10 20 11 21 22; in place.
  static HWY_INLINE void invert(V* a, V& good) {
    const D d;
    const V c00 = hn::NegMulAdd(a[4], a[4], hn::Mul(a[3], a[5]));
    const V c01 = hn::NegMulAdd(a[1], a[5], hn::Mul(a[2], a[4]));
    const V c02 = hn::NegMulAdd(a[2], a[3], hn::Mul(a[1], a[4]));
    const V determinant = hn::MulAdd(a[2], c02, hn::MulAdd(a[1], c01, hn::Mul(a[0], c00)));
    const V r = hn::Div(hn::Set(d, T(1)), determinant);
    const V c11 = hn::NegMulAdd(a[2], a[2], hn::Mul(a[0], a[5]));
    const V c12 = hn::NegMulAdd(a[0], a[4], hn::Mul(a[1], a[2]));
    const V c22 = hn::NegMulAdd(a[1], a[1], hn::Mul(a[0], a[3]));
    const V zero = hn::Zero(d);
    const auto fine = hn::And(hn::Gt(a[0], zero), hn::Gt(determinant, zero));
    good = hn::IfThenElseZero(fine, good);
    const V result[6] = {c00, c01, c02, c11, c12, c22};
    for (std::size_t e = 0; e < 6; ++e) a[e] = hn::Mul(result[e], r);
  }

  HWY_INLINE const int* eliminate_lanes(std::size_t s, V hold, T* own, const int* target, V* a) {
    const D d;
    V b[3];
    entry_.enter(s, hold, own + kBlock, a, b);
    for (auto e = plan_.source_begin[s]; e < plan_.source_begin[s + 1]; ++e) {
      const auto& source = plan_.sources[std::size_t(e)];
      const std::size_t j = std::size_t(source.column);
      const T* inverse = panel(source);
      T* block = panel(source) + std::size_t(source.place) * kBlock;
      float* kept_block = kept(j) + std::size_t(source.place) * kKept;
      V w[3][3], l[3][3];  // [column][row]
      for (std::size_t q = 0; q < 3; ++q)
        for (std::size_t r = 0; r < 3; ++r) w[q][r] = load(block + q * kJoint + r * N);
      for (std::size_t q = 0; q < 3; ++q) {
        const V i0 = load(inverse + q * kJoint), i1 = load(inverse + q * kJoint + N),
                i2 = load(inverse + q * kJoint + 2 * N);
        for (std::size_t r = 0; r < 3; ++r)
          l[q][r] = hn::MulAdd(w[2][r], i2, hn::MulAdd(w[1][r], i1, hn::Mul(w[0][r], i0)));
      }
      for (std::size_t q = 0; q < 3; ++q) {
        a[0] = hn::NegMulAdd(w[q][0], l[q][0], a[0]);
        a[1] = hn::NegMulAdd(w[q][1], l[q][0], a[1]);
        a[2] = hn::NegMulAdd(w[q][2], l[q][0], a[2]);
        a[3] = hn::NegMulAdd(w[q][1], l[q][1], a[3]);
        a[4] = hn::NegMulAdd(w[q][2], l[q][1], a[4]);
        a[5] = hn::NegMulAdd(w[q][2], l[q][2], a[5]);
      }
      const T* y = y_ + j * kJoint;
      for (std::size_t q = 0; q < 3; ++q) {
        const V yq = load(y + q * N);
        for (std::size_t r = 0; r < 3; ++r) {
          b[r] = hn::NegMulAdd(yq, l[q][r], b[r]);
          keep(l[q][r], kept_block + q * kKeptColumn + r * N);
        }
      }
      const T* from = block + kBlock;
      for (int i = 0; i < source.below; ++i, ++target, from += kBlock) {
        T* to = own + std::size_t(1 + *target) * kBlock;
        V f[3][3];
        for (std::size_t q = 0; q < 3; ++q)
          for (std::size_t r = 0; r < 3; ++r) f[q][r] = load(from + q * kJoint + r * N);
        for (std::size_t c = 0; c < 3; ++c)
          for (std::size_t r = 0; r < 3; ++r) {
            T* at = to + c * kJoint + r * N;
            V t = load(at);
            for (std::size_t q = 0; q < 3; ++q) t = hn::NegMulAdd(f[q][r], l[q][c], t);
            hn::StoreU(t, d, at);
          }
      }
    }
    for (std::size_t c = 0; c < 3; ++c) hn::StoreU(b[c], d, y_ + s * kJoint + c * N);
    return target;
  }

  /// The same, three rows at once.
  HWY_INLINE const int* eliminate_padded(std::size_t s, V hold, T* own, const int* target, V* a) {
    const P d;
    const D one;
    W columns[3], right;
    entry_.enter_padded(s, hn::GetLane(hold), own + 12, columns, right);
    W a0 = columns[0], a1 = columns[1], a2 = columns[2];
    for (auto e = plan_.source_begin[s]; e < plan_.source_begin[s + 1]; ++e) {
      const auto& source = plan_.sources[std::size_t(e)];
      const std::size_t j = std::size_t(source.column);
      const T* inverse = panel(source);
      T* block = panel(source) + std::size_t(source.place) * 12;
      const W w0 = wide(block), w1 = wide(block + 4), w2 = wide(block + 8);
      const auto column_of = [&](const T* i) HWY_ATTR {
        return hn::MulAdd(w2, all(i[2]), hn::MulAdd(w1, all(i[1]), hn::Mul(w0, all(i[0]))));
      };
      const W l0 = column_of(inverse), l1 = column_of(inverse + 4), l2 = column_of(inverse + 8);
      hn::StoreU(l0, d, block);
      hn::StoreU(l1, d, block + 4);
      hn::StoreU(l2, d, block + 8);
      const T* y = y_ + j * 4;
      right = hn::NegMulAdd(all(y[0]), l0, right);
      right = hn::NegMulAdd(all(y[1]), l1, right);
      right = hn::NegMulAdd(all(y[2]), l2, right);
      const W l00 = all(block[0]), l01 = all(block[1]), l02 = all(block[2]), l10 = all(block[4]),
              l11 = all(block[5]), l12 = all(block[6]), l20 = all(block[8]), l21 = all(block[9]),
              l22 = all(block[10]);
      a0 = hn::NegMulAdd(w2, l20, hn::NegMulAdd(w1, l10, hn::NegMulAdd(w0, l00, a0)));
      a1 = hn::NegMulAdd(w2, l21, hn::NegMulAdd(w1, l11, hn::NegMulAdd(w0, l01, a1)));
      a2 = hn::NegMulAdd(w2, l22, hn::NegMulAdd(w1, l12, hn::NegMulAdd(w0, l02, a2)));
      const T* from = block + 12;
      for (int i = 0; i < source.below; ++i, ++target, from += 12) {
        T* to = own + std::size_t(1 + *target) * 12;
        const W f0 = wide(from), f1 = wide(from + 4), f2 = wide(from + 8);
        hn::StoreU(hn::NegMulAdd(f2, l20, hn::NegMulAdd(f1, l10, hn::NegMulAdd(f0, l00, wide(to)))),
                   d, to);
        hn::StoreU(
            hn::NegMulAdd(f2, l21, hn::NegMulAdd(f1, l11, hn::NegMulAdd(f0, l01, wide(to + 4)))), d,
            to + 4);
        hn::StoreU(
            hn::NegMulAdd(f2, l22, hn::NegMulAdd(f1, l12, hn::NegMulAdd(f0, l02, wide(to + 8)))), d,
            to + 8);
      }
      if (source.below == 0) keep_column(j, std::size_t(source.place), inverse);
    }
    HWY_ALIGN T diagonal[12];
    hn::StoreU(a0, d, diagonal);
    hn::StoreU(a1, d, diagonal + 4);
    hn::StoreU(a2, d, diagonal + 8);
    const T places[6] = {diagonal[0], diagonal[1], diagonal[2],
                         diagonal[5], diagonal[6], diagonal[10]};
    for (std::size_t e = 0; e < 6; ++e) a[e] = hn::Set(one, places[e]);
    hn::StoreU(right, d, y_ + s * 4);
    return target;
  }

  // === Substitution

  /// Takes column s from the right sides below it.
  HWY_INLINE void forward(std::size_t s) {
    const T* y = y_ + s * kJoint;
    const float* l = kept(s) + kKept;
    if constexpr (kPadded) {
      const P d;
      const W y0 = all(y[0]), y1 = all(y[1]), y2 = all(y[2]);
      for (auto e = plan_.column[s]; e < plan_.column[s + 1]; ++e, l += kKept) {
        T* to = y_ + std::size_t(plan_.row[std::size_t(e)]) * 4;
        W right = hn::NegMulAdd(y0, wide_kept(l), wide(to));
        right = hn::NegMulAdd(y1, wide_kept(l + 3), right);
        hn::StoreU(hn::NegMulAdd(y2, wide_kept(l + 6), right), d, to);
      }
    } else {
      const D d;
      const V y0 = load(y), y1 = load(y + N), y2 = load(y + 2 * N);
      for (auto e = plan_.column[s]; e < plan_.column[s + 1]; ++e, l += kKept) {
        T* to = y_ + std::size_t(plan_.row[std::size_t(e)]) * kJoint;
        for (std::size_t r = 0; r < 3; ++r) {
          V right = hn::NegMulAdd(y0, load_kept(l + r * N), load(to + r * N));
          right = hn::NegMulAdd(y1, load_kept(l + kKeptColumn + r * N), right);
          hn::StoreU(hn::NegMulAdd(y2, load_kept(l + 2 * kKeptColumn + r * N), right), d,
                     to + r * N);
        }
      }
    }
  }

  /// The step of slot s, from those eliminated after it; to = from + step.
  template <bool kGain>
  HWY_INLINE void substitute(std::size_t s, const Field<T>& from, Field<T>& to, V hold, W* gain) {
    T* y = y_ + s * kJoint;
    const float* inverse = kept(s);
    const float* l = inverse + kKept;
    if constexpr (kPadded) {
      const P d;
      W sum0 = hn::Zero(d), sum1 = hn::Zero(d), sum2 = hn::Zero(d);
      for (auto e = plan_.column[s]; e < plan_.column[s + 1]; ++e, l += kKept) {
        const W step = wide(y_ + std::size_t(plan_.row[std::size_t(e)]) * 4);
        sum0 = hn::MulAdd(wide_kept(l), step, sum0);
        sum1 = hn::MulAdd(wide_kept(l + 3), step, sum1);
        sum2 = hn::MulAdd(wide_kept(l + 6), step, sum2);
      }
      const W z = hn::MulAdd(
          wide_kept(inverse + 6), all(y[2]),
          hn::MulAdd(wide_kept(inverse + 3), all(y[1]), hn::Mul(wide_kept(inverse), all(y[0]))));
      if constexpr (kGain) gain[0] = hn::MulAdd(wide(y), z, gain[0]);
      const W step = hn::Sub(z, sums_of_three(sum0, sum1, sum2));
      if constexpr (kGain)
        gain[0] = hn::MulAdd(step, hn::Mul(all(hn::GetLane(hold)), step), gain[0]);
      hn::StoreU(step, d, y);
      hn::StoreU(hn::Add(wide(from + s * 4), step), d, to + s * 4);
    } else {
      const D d;
      V sum[3][3], z[3];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t r = 0; r < 3; ++r) sum[c][r] = hn::Zero(d);
      for (auto e = plan_.column[s]; e < plan_.column[s + 1]; ++e, l += kKept) {
        const T* step = y_ + std::size_t(plan_.row[std::size_t(e)]) * kJoint;
        for (std::size_t r = 0; r < 3; ++r) {
          const V value = load(step + r * N);
          for (std::size_t c = 0; c < 3; ++c)
            sum[c][r] = hn::MulAdd(load_kept(l + c * kKeptColumn + r * N), value, sum[c][r]);
        }
      }
      for (std::size_t c = 0; c < 3; ++c)
        z[c] = hn::MulAdd(load_kept(inverse + 2 * kKeptColumn + c * N), load(y + 2 * N),
                          hn::MulAdd(load_kept(inverse + kKeptColumn + c * N), load(y + N),
                                     hn::Mul(load_kept(inverse + c * N), load(y))));
      for (std::size_t c = 0; c < 3; ++c) {
        if constexpr (kGain) gain[c] = hn::MulAdd(load(y + c * N), z[c], gain[c]);
        const V step = hn::Sub(z[c], hn::Add(hn::Add(sum[c][0], sum[c][1]), sum[c][2]));
        if constexpr (kGain) gain[c] = hn::MulAdd(step, hn::Mul(hold, step), gain[c]);
        hn::StoreU(step, d, y + c * N);
        const std::size_t at = s * kJoint + c * N;
        hn::StoreU(hn::Add(load(from + at), step), d, to + at);
      }
    }
  }

#if HWY_TARGET != HWY_SCALAR
  /// The first three numbers of each, summed up; in registers, since the next slot waits for it.
  static HWY_INLINE W sums_of_three(W a, W b, W c) {
    const P d;
    const W zero = hn::Zero(d);
    const W lower_ab = hn::InterleaveLower(d, a, b), lower_c = hn::InterleaveLower(d, c, zero);
    const W upper_ab = hn::InterleaveUpper(d, a, b), upper_c = hn::InterleaveUpper(d, c, zero);
    const W first = hn::ConcatLowerLower(d, lower_c, lower_ab);
    const W other = hn::ConcatUpperUpper(d, lower_c, lower_ab);
    const W upper = hn::ConcatLowerLower(d, upper_c, upper_ab);
    // vectors of doubles are interleaved by halves
    constexpr bool halves = sizeof(T) == 8;
    return hn::Add(hn::Add(first, halves ? upper : other), halves ? other : upper);
  }
#endif
};

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#endif
