// NewtonFactor: the elimination of `newton`: J^T J + mu as a product of block triangles, and the
// step by it. Compiled once for each set of instructions, from newton_engine.cpp.

#if defined(RAGDOLL_NEWTON_FACTOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RAGDOLL_NEWTON_FACTOR_INL_H_
#undef RAGDOLL_NEWTON_FACTOR_INL_H_
#else
#define RAGDOLL_NEWTON_FACTOR_INL_H_
#endif

#include <cstddef>
#include <vector>

#include <hwy/highway.h>

#include "newton_plan.h"      // NewtonPlan
#include "newton_rows-inl.h"  // NewtonRows

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {

template <class T, bool kSingle>
class NewtonFactor : private NewtonLayout<T, kSingle> {
  using Layout = NewtonLayout<T, kSingle>;
  using Layout::load, Layout::wide, Layout::all;
  using Layout::N, Layout::kJoint, Layout::kBlock, Layout::kPadded;
  using typename Layout::D;
  using typename Layout::P;
  using typename Layout::V;
  using typename Layout::W;

 public:
  /// @param masses  by slot: what mu is multiplied by
  NewtonFactor(const NewtonPlan& plan, const std::vector<T>& masses,
               const NewtonRows<T, kSingle>& rows, bool with_extras)
      : plan_(plan),
        masses_(masses),
        rows_(rows),
        right_(std::size_t(plan.moving) * kJoint),
        y_(std::size_t(plan.moving) * kJoint),
        block_(plan.row.size() * kBlock),
        inverse_(std::size_t(plan.moving) * kBlock) {
    if (with_extras) {
      extra_ = Field<T>(std::size_t(plan.moving) * kBlock);
      extra_right_ = Field<T>(std::size_t(plan.moving) * kJoint);
    }
  }

  /// Adds a row that no block below the diagonal knows of: stiffness * u u^T at a slot, and its
  /// pull.
  void add_extra(int slot, std::size_t lane, const T* u, T stiffness, T pull) {
    T* block = extra_ + std::size_t(slot) * kBlock + lane;
    T* right = extra_right_ + std::size_t(slot) * kJoint + lane;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t r = 0; r < 3; ++r) block[c * kJoint + r * N] += stiffness * u[c] * u[r];
      right[c * N] += pull * u[c];
    }
    touched_.push_back(slot);
  }
  /// A pull alone.
  void add_pull(int slot, std::size_t lane, const T* u, T pull) {
    T* right = extra_right_ + std::size_t(slot) * kJoint + lane;
    for (std::size_t c = 0; c < 3; ++c) right[c * N] += pull * u[c];
  }
  void clear_pulls() {
    for (const int slot : touched_) {
      T* right = extra_right_ + std::size_t(slot) * kJoint;
      for (std::size_t e = 0; e < kJoint; ++e) right[e] = 0;
    }
  }
  void clear_extras() {
    for (const int slot : touched_) {
      T* block = extra_ + std::size_t(slot) * kBlock;
      T* right = extra_right_ + std::size_t(slot) * kJoint;
      for (std::size_t e = 0; e < kBlock; ++e) block[e] = 0;
      for (std::size_t e = 0; e < kJoint; ++e) right[e] = 0;
    }
    touched_.clear();
  }

  /// The step from the rows evaluated last; trial = x + step.
  /// @param mu         of each lane
  /// @param predicted  what the step takes from the energy, by the linear rows and mu's hold
  /// @param positive   0 in lanes where the matrix is not positive
  void solve(const Field<T>& x, const T* mu, Field<T>& trial, T* predicted, T* positive) {
    const D d;
    V good = hn::Set(d, T(1));
    const int* target = plan_.target.data();
    for (int k = 0; k < plan_.moving; ++k) target = eliminate(k, mu, target, good);
    hn::StoreU(good, d, positive);
    V gain = hn::Zero(d);
    const V v_mu = hn::LoadU(d, mu);
    for (int k = plan_.moving; k-- > 0;) {
      substitute(k);
      const std::size_t at = std::size_t(k) * kJoint;
      const V held = hn::Mul(v_mu, hn::Set(d, masses_[std::size_t(k)]));
      for (std::size_t c = 0; c < 3; ++c) {
        const V step = load(y_ + at + c * N);
        gain = hn::MulAdd(step, hn::MulAdd(held, step, load(right_ + at + c * N)), gain);
        hn::StoreU(hn::Add(load(x + at + c * N), step), d, trial + at + c * N);
      }
    }
    const std::size_t rest = std::size_t(plan_.moving) * kJoint;
    for (std::size_t e = rest; e < trial.size(); ++e) trial[e] = x[e];
    hn::StoreU(hn::Mul(gain, hn::Set(d, T(0.5))), d, predicted);
  }

  /// A step of the same factor and gradients from other rows: corrected = trial + step.
  void correct(const Field<T>& trial, Field<T>& corrected) {
    const D d;
    for (int k = 0; k < plan_.moving; ++k) pull(std::size_t(k));
    for (int k = 0; k < plan_.moving; ++k) forward(std::size_t(k));
    for (int k = plan_.moving; k-- > 0;) {
      substitute(k);
      const std::size_t at = std::size_t(k) * kJoint;
      for (std::size_t c = 0; c < 3; ++c)
        hn::StoreU(hn::Add(load(trial + at + c * N), load(y_ + at + c * N)), d,
                   corrected + at + c * N);
    }
    const std::size_t rest = std::size_t(plan_.moving) * kJoint;
    for (std::size_t e = rest; e < trial.size(); ++e) corrected[e] = trial[e];
  }

 private:
  const NewtonPlan& plan_;
  const std::vector<T>& masses_;
  const NewtonRows<T, kSingle>& rows_;
  Field<T> right_, y_, block_, inverse_, extra_, extra_right_;
  std::vector<int> touched_;

  // === Elimination

  /// Column k: entered, less the columns before it, its diagonal inverted; the right side beside.
  HWY_INLINE const int* eliminate(int k, const T* mu, const int* target, V& good) {
    const D d;
    const std::size_t s = std::size_t(k);
    const std::size_t first = std::size_t(plan_.column[s]), last = std::size_t(plan_.column[s + 1]);
    V a[6], b[3];
    if constexpr (kPadded) {
      target = eliminate_padded(s, first, last, target, a, b);
    } else {
      target = eliminate_lanes(s, first, last, target, a, b);
    }
    const V hold = hn::Mul(hn::LoadU(d, mu), hn::Set(d, masses_[s]));
    a[0] = hn::Add(a[0], hold);
    a[3] = hn::Add(a[3], hold);
    a[5] = hn::Add(a[5], hold);
    invert(a, inverse_ + s * kBlock, good);
    return target;
  }

  /// Lower triangle by columns: 00 10 20 11 21 22.
  static HWY_INLINE void invert(const V* a, T* inverse, V& good) {
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
    const V r00 = hn::Mul(c00, r), r01 = hn::Mul(c01, r), r02 = hn::Mul(c02, r),
            r11 = hn::Mul(c11, r), r12 = hn::Mul(c12, r), r22 = hn::Mul(c22, r);
    const V full[9] = {r00, r01, r02, r01, r11, r12, r02, r12, r22};
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < 3; ++i)
        hn::StoreU(full[3 * c + i], d, inverse + c * kJoint + i * N);
  }

  HWY_INLINE const int* eliminate_lanes(std::size_t s, std::size_t first, std::size_t last,
                                        const int* target, V* a, V* b) {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, T(1));
    V turned = zero;
    for (std::size_t e = 0; e < 6; ++e) a[e] = zero;
    for (std::size_t e = 0; e < 3; ++e) b[e] = zero;
    const auto add_outer = [&](const V* left, const V* right) HWY_ATTR {
      a[0] = hn::MulAdd(right[0], left[0], a[0]);
      a[1] = hn::MulAdd(right[0], left[1], a[1]);
      a[2] = hn::MulAdd(right[0], left[2], a[2]);
      a[3] = hn::MulAdd(right[1], left[1], a[3]);
      a[4] = hn::MulAdd(right[1], left[2], a[4]);
      a[5] = hn::MulAdd(right[2], left[2], a[5]);
    };
    for (auto e = plan_.end_begin[s]; e < plan_.end_begin[s + 1]; ++e) {
      const int end = plan_.ends[std::size_t(e)];
      const std::size_t pair = std::size_t(end >> 1);
      const T* unit = rows_.unit + pair * 4 * N;
      const V u[3] = {load(unit), load(unit + N), load(unit + 2 * N)};
      const V turn = load(unit + 3 * N), spring = hn::Sub(one, turn);
      const V su[3] = {hn::Mul(spring, u[0]), hn::Mul(spring, u[1]), hn::Mul(spring, u[2])};
      add_outer(su, u);
      turned = hn::Add(turned, turn);
      const V row = load(rows_.row + pair * N);
      const V pull = (end & 1) ? row : hn::Sub(zero, row);
      for (std::size_t c = 0; c < 3; ++c) b[c] = hn::NegMulAdd(pull, u[c], b[c]);
    }
    for (auto e = plan_.corner_begin[s]; e < plan_.corner_begin[s + 1]; ++e) {
      const std::size_t corner = std::size_t(plan_.corners[std::size_t(e)]), v = corner >> 2;
      if (!rows_.active[v]) continue;
      const T* gradient = rows_.gradient + corner * kJoint;
      const V g[3] = {load(gradient), load(gradient + N), load(gradient + 2 * N)};
      add_outer(g, g);
      const V row = load(rows_.excess + v * N);
      for (std::size_t c = 0; c < 3; ++c) b[c] = hn::NegMulAdd(row, g[c], b[c]);
    }
    if (extra_.size() != 0) {
      const T* extra = extra_ + s * kBlock;
      for (std::size_t c = 0, e = 0; c < 3; ++c)
        for (std::size_t r = c; r < 3; ++r, ++e)
          a[e] = hn::Add(a[e], load(extra + c * kJoint + r * N));
      for (std::size_t c = 0; c < 3; ++c)
        b[c] = hn::Add(b[c], load(extra_right_ + s * kJoint + c * N));
    }
    for (std::size_t c = 0; c < 3; ++c) hn::StoreU(b[c], d, right_ + s * kJoint + c * N);

    for (std::size_t e = first; e < last; ++e) {
      T* block = block_ + e * kBlock;
      const int pair = plan_.block_pair[e];
      if (pair < 0) {
        for (std::size_t c = 0; c < 3; ++c)
          for (std::size_t r = 0; r < 3; ++r) hn::StoreU(zero, d, block + c * kJoint + r * N);
        continue;
      }
      enter_pair(block, std::size_t(pair), false);
    }
    for (auto e = plan_.addition_begin[s]; e < plan_.addition_begin[s + 1]; ++e) {
      const auto& more = plan_.additions[std::size_t(e)];
      T* block = block_ + (first + std::size_t(more.block)) * kBlock;
      if (more.pair >= 0) {
        enter_pair(block, std::size_t(more.pair), true);
        continue;
      }
      const std::size_t v = std::size_t(more.volume);
      if (!rows_.active[v]) continue;
      const T* row = rows_.gradient + (4 * v + std::size_t(more.row)) * kJoint;
      const T* col = rows_.gradient + (4 * v + std::size_t(more.col)) * kJoint;
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t r = 0; r < 3; ++r) {
          T* at = block + c * kJoint + r * N;
          hn::StoreU(hn::MulAdd(load(col + c * N), load(row + r * N), load(at)), d, at);
        }
    }

    for (auto e = plan_.source_begin[s]; e < plan_.source_begin[s + 1]; ++e) {
      const auto& source = plan_.sources[std::size_t(e)];
      const std::size_t j = std::size_t(source.column);
      T* block = block_ + std::size_t(source.block) * kBlock;
      const T* inverse = inverse_ + j * kBlock;
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
          hn::StoreU(l[q][r], d, block + q * kJoint + r * N);
        }
      }
      const std::size_t end = std::size_t(plan_.column[j + 1]);
      for (std::size_t i = std::size_t(source.block) + 1; i < end; ++i, ++target) {
        const T* from = block_ + i * kBlock;
        T* to = block_ + (first + std::size_t(*target)) * kBlock;
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
    a[0] = hn::Add(a[0], turned);
    a[3] = hn::Add(a[3], turned);
    a[5] = hn::Add(a[5], turned);
    for (std::size_t c = 0; c < 3; ++c) hn::StoreU(b[c], d, y_ + s * kJoint + c * N);
    return target;
  }

  /// A pair's block below the diagonal: -(1 - turn) u u^T - turn.
  HWY_INLINE void enter_pair(T* block, std::size_t pair, bool add) {
    const D d;
    const T* unit = rows_.unit + pair * 4 * N;
    const V turn = load(unit + 3 * N), spring = hn::Sub(hn::Set(d, T(1)), turn);
    V su[3];
    for (std::size_t r = 0; r < 3; ++r) su[r] = hn::Mul(spring, load(unit + r * N));
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t r = 0; r < 3; ++r) {
        T* at = block + c * kJoint + r * N;
        V value = hn::NegMulAdd(load(unit + c * N), su[r], add ? load(at) : hn::Zero(d));
        if (r == c) value = hn::Sub(value, turn);
        hn::StoreU(value, d, at);
      }
  }

  /// The same, three rows at once.
  HWY_INLINE const int* eliminate_padded(std::size_t s, std::size_t first, std::size_t last,
                                         const int* target, V* a, V* b) {
    const P d;
    const D one;
    W a0 = hn::Zero(d), a1 = hn::Zero(d), a2 = hn::Zero(d), right = hn::Zero(d);
    T turned = 0;
    for (auto e = plan_.end_begin[s]; e < plan_.end_begin[s + 1]; ++e) {
      const int end = plan_.ends[std::size_t(e)];
      const std::size_t pair = std::size_t(end >> 1);
      const T* unit = rows_.unit + pair * 4;
      const W u = wide(unit), su = hn::Mul(all(T(1) - unit[3]), u);
      a0 = hn::MulAdd(all(unit[0]), su, a0);
      a1 = hn::MulAdd(all(unit[1]), su, a1);
      a2 = hn::MulAdd(all(unit[2]), su, a2);
      turned += unit[3];
      const T row = rows_.row[pair];
      right = hn::NegMulAdd(all((end & 1) ? row : T(0) - row), u, right);
    }
    for (auto e = plan_.corner_begin[s]; e < plan_.corner_begin[s + 1]; ++e) {
      const std::size_t corner = std::size_t(plan_.corners[std::size_t(e)]), v = corner >> 2;
      if (!rows_.active[v]) continue;
      const T* gradient = rows_.gradient + corner * 4;
      const W g = wide(gradient);
      a0 = hn::MulAdd(all(gradient[0]), g, a0);
      a1 = hn::MulAdd(all(gradient[1]), g, a1);
      a2 = hn::MulAdd(all(gradient[2]), g, a2);
      right = hn::NegMulAdd(all(rows_.excess[v]), g, right);
    }
    if (extra_.size() != 0) {
      const T* extra = extra_ + s * 12;
      a0 = hn::Add(a0, wide(extra));
      a1 = hn::Add(a1, wide(extra + 4));
      a2 = hn::Add(a2, wide(extra + 8));
      right = hn::Add(right, wide(extra_right_ + s * 4));
    }
    hn::StoreU(right, d, right_ + s * 4);

    for (std::size_t e = first; e < last; ++e) {
      T* block = block_ + e * 12;
      const int pair = plan_.block_pair[e];
      if (pair >= 0) {
        enter_pair_padded(block, std::size_t(pair), false);
        continue;
      }
      hn::StoreU(hn::Zero(d), d, block);
      hn::StoreU(hn::Zero(d), d, block + 4);
      hn::StoreU(hn::Zero(d), d, block + 8);
    }
    for (auto e = plan_.addition_begin[s]; e < plan_.addition_begin[s + 1]; ++e) {
      const auto& more = plan_.additions[std::size_t(e)];
      T* block = block_ + (first + std::size_t(more.block)) * 12;
      if (more.pair >= 0) {
        enter_pair_padded(block, std::size_t(more.pair), true);
        continue;
      }
      const std::size_t v = std::size_t(more.volume);
      if (!rows_.active[v]) continue;
      const W row = wide(rows_.gradient + (4 * v + std::size_t(more.row)) * 4);
      const T* col = rows_.gradient + (4 * v + std::size_t(more.col)) * 4;
      for (std::size_t c = 0; c < 3; ++c)
        hn::StoreU(hn::MulAdd(all(col[c]), row, wide(block + 4 * c)), d, block + 4 * c);
    }

    for (auto e = plan_.source_begin[s]; e < plan_.source_begin[s + 1]; ++e) {
      const auto& source = plan_.sources[std::size_t(e)];
      const std::size_t j = std::size_t(source.column);
      T* block = block_ + std::size_t(source.block) * 12;
      const T* inverse = inverse_ + j * 12;
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
      const std::size_t end = std::size_t(plan_.column[j + 1]);
      for (std::size_t i = std::size_t(source.block) + 1; i < end; ++i, ++target) {
        const T* from = block_ + i * 12;
        T* to = block_ + (first + std::size_t(*target)) * 12;
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
    }
    HWY_ALIGN T diagonal[12];
    hn::StoreU(a0, d, diagonal);
    hn::StoreU(a1, d, diagonal + 4);
    hn::StoreU(a2, d, diagonal + 8);
    a[0] = hn::Set(one, diagonal[0] + turned);
    a[1] = hn::Set(one, diagonal[1]);
    a[2] = hn::Set(one, diagonal[2]);
    a[3] = hn::Set(one, diagonal[5] + turned);
    a[4] = hn::Set(one, diagonal[6]);
    a[5] = hn::Set(one, diagonal[10] + turned);
    hn::StoreU(right, d, y_ + s * 4);
    (void)b;
    return target;
  }

  HWY_INLINE void enter_pair_padded(T* block, std::size_t pair, bool add) {
    const P d;
    const T* unit = rows_.unit + pair * 4;
    const W su = hn::Mul(all(T(1) - unit[3]), wide(unit));
    HWY_ALIGN static constexpr T axes[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    for (std::size_t c = 0; c < 3; ++c) {
      const W value = hn::NegMulAdd(all(unit[c]), su, add ? wide(block + 4 * c) : hn::Zero(d));
      // a product with one and a sum with zero round nothing
      hn::StoreU(hn::NegMulAdd(all(unit[3]), wide(axes + 4 * c), value), d, block + 4 * c);
    }
  }

  // === Substitution

  /// The right side of slot s.
  HWY_INLINE void pull(std::size_t s) {
    if constexpr (kPadded) {
      const P d;
      W right = extra_.size() != 0 ? wide(extra_right_ + s * 4) : hn::Zero(d);
      for (auto e = plan_.end_begin[s]; e < plan_.end_begin[s + 1]; ++e) {
        const int end = plan_.ends[std::size_t(e)];
        const std::size_t pair = std::size_t(end >> 1);
        const T row = rows_.row[pair];
        right =
            hn::NegMulAdd(all((end & 1) ? row : T(0) - row), wide(rows_.unit + pair * 4), right);
      }
      for (auto e = plan_.corner_begin[s]; e < plan_.corner_begin[s + 1]; ++e) {
        const std::size_t corner = std::size_t(plan_.corners[std::size_t(e)]), v = corner >> 2;
        if (!rows_.active[v]) continue;
        right = hn::NegMulAdd(all(rows_.excess[v]), wide(rows_.gradient + corner * 4), right);
      }
      hn::StoreU(right, d, y_ + s * 4);
    } else {
      const D d;
      const V zero = hn::Zero(d);
      V b[3] = {zero, zero, zero};
      if (extra_.size() != 0)
        for (std::size_t c = 0; c < 3; ++c) b[c] = load(extra_right_ + s * kJoint + c * N);
      for (auto e = plan_.end_begin[s]; e < plan_.end_begin[s + 1]; ++e) {
        const int end = plan_.ends[std::size_t(e)];
        const std::size_t pair = std::size_t(end >> 1);
        const T* unit = rows_.unit + pair * 4 * N;
        const V row = load(rows_.row + pair * N);
        const V pull = (end & 1) ? row : hn::Sub(zero, row);
        for (std::size_t c = 0; c < 3; ++c) b[c] = hn::NegMulAdd(pull, load(unit + c * N), b[c]);
      }
      for (auto e = plan_.corner_begin[s]; e < plan_.corner_begin[s + 1]; ++e) {
        const std::size_t corner = std::size_t(plan_.corners[std::size_t(e)]), v = corner >> 2;
        if (!rows_.active[v]) continue;
        const V row = load(rows_.excess + v * N);
        for (std::size_t c = 0; c < 3; ++c)
          b[c] = hn::NegMulAdd(row, load(rows_.gradient + corner * kJoint + c * N), b[c]);
      }
      for (std::size_t c = 0; c < 3; ++c) hn::StoreU(b[c], d, y_ + s * kJoint + c * N);
    }
  }

  /// Takes column s from the right sides below it.
  HWY_INLINE void forward(std::size_t s) {
    const std::size_t first = std::size_t(plan_.column[s]), last = std::size_t(plan_.column[s + 1]);
    const T* y = y_ + s * kJoint;
    if constexpr (kPadded) {
      const P d;
      const W y0 = all(y[0]), y1 = all(y[1]), y2 = all(y[2]);
      for (std::size_t e = first; e < last; ++e) {
        const T* l = block_ + e * 12;
        T* to = y_ + std::size_t(plan_.row[e]) * 4;
        W right = hn::NegMulAdd(y0, wide(l), wide(to));
        right = hn::NegMulAdd(y1, wide(l + 4), right);
        hn::StoreU(hn::NegMulAdd(y2, wide(l + 8), right), d, to);
      }
    } else {
      const D d;
      const V y0 = load(y), y1 = load(y + N), y2 = load(y + 2 * N);
      for (std::size_t e = first; e < last; ++e) {
        const T* l = block_ + e * kBlock;
        T* to = y_ + std::size_t(plan_.row[e]) * kJoint;
        for (std::size_t r = 0; r < 3; ++r) {
          V right = hn::NegMulAdd(y0, load(l + r * N), load(to + r * N));
          right = hn::NegMulAdd(y1, load(l + kJoint + r * N), right);
          hn::StoreU(hn::NegMulAdd(y2, load(l + 2 * kJoint + r * N), right), d, to + r * N);
        }
      }
    }
  }

  /// The step of slot k, from those eliminated after it.
  HWY_INLINE void substitute(int k) {
    const std::size_t s = std::size_t(k);
    const std::size_t first = std::size_t(plan_.column[s]), last = std::size_t(plan_.column[s + 1]);
    T* y = y_ + s * kJoint;
    const T* inverse = inverse_ + s * kBlock;
    if constexpr (kPadded) {
      const P d;
      W sum0 = hn::Zero(d), sum1 = hn::Zero(d), sum2 = hn::Zero(d);
      for (std::size_t e = first; e < last; ++e) {
        const T* l = block_ + e * 12;
        const W step = wide(y_ + std::size_t(plan_.row[e]) * 4);
        sum0 = hn::MulAdd(wide(l), step, sum0);
        sum1 = hn::MulAdd(wide(l + 4), step, sum1);
        sum2 = hn::MulAdd(wide(l + 8), step, sum2);
      }
      const W z =
          hn::MulAdd(wide(inverse + 8), all(y[2]),
                     hn::MulAdd(wide(inverse + 4), all(y[1]), hn::Mul(wide(inverse), all(y[0]))));
      HWY_ALIGN T sums[12];
      hn::StoreU(sum0, d, sums);
      hn::StoreU(sum1, d, sums + 4);
      hn::StoreU(sum2, d, sums + 8);
      hn::StoreU(z, d, y);
      for (std::size_t c = 0; c < 3; ++c) y[c] -= (sums[4 * c] + sums[4 * c + 1]) + sums[4 * c + 2];
    } else {
      const D d;
      V sum[3][3], z[3];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t r = 0; r < 3; ++r) sum[c][r] = hn::Zero(d);
      for (std::size_t e = first; e < last; ++e) {
        const T* l = block_ + e * kBlock;
        const T* step = y_ + std::size_t(plan_.row[e]) * kJoint;
        for (std::size_t r = 0; r < 3; ++r) {
          const V value = load(step + r * N);
          for (std::size_t c = 0; c < 3; ++c)
            sum[c][r] = hn::MulAdd(load(l + c * kJoint + r * N), value, sum[c][r]);
        }
      }
      for (std::size_t c = 0; c < 3; ++c)
        z[c] = hn::MulAdd(load(inverse + 2 * kJoint + c * N), load(y + 2 * N),
                          hn::MulAdd(load(inverse + kJoint + c * N), load(y + N),
                                     hn::Mul(load(inverse + c * N), load(y))));
      for (std::size_t c = 0; c < 3; ++c)
        hn::StoreU(hn::Sub(z[c], hn::Add(hn::Add(sum[c][0], sum[c][1]), sum[c][2])), d, y + c * N);
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#endif
