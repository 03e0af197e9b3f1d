// NewtonEntry: columns of J^T J + mu and of the right side of `newton`, from rows and their
// gradients. Compiled once for each set of instructions, from newton_engine.cpp.

#if defined(RAGDOLL_NEWTON_ENTRY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RAGDOLL_NEWTON_ENTRY_INL_H_
#undef RAGDOLL_NEWTON_ENTRY_INL_H_
#else
#define RAGDOLL_NEWTON_ENTRY_INL_H_
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
class NewtonEntry : private NewtonLayout<T, kSingle> {
  using Layout = NewtonLayout<T, kSingle>;
  using Layout::load, Layout::wide, Layout::all;
  using Layout::N, Layout::kJoint, Layout::kBlock, Layout::kPadded;
  using typename Layout::D;
  using typename Layout::P;
  using typename Layout::V;
  using typename Layout::W;

 public:
  NewtonEntry(const NewtonPlan& plan, const NewtonRows<T, kSingle>& rows, bool with_extras)
      : plan_(plan), rows_(rows) {
    is_touched_.assign(std::size_t(plan.moving), 0);
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
    if (!is_touched_[std::size_t(slot)]) touched_.push_back(slot);
    is_touched_[std::size_t(slot)] = 1;
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
      is_touched_[std::size_t(slot)] = 0;
      T* block = extra_ + std::size_t(slot) * kBlock;
      T* right = extra_right_ + std::size_t(slot) * kJoint;
      for (std::size_t e = 0; e < kBlock; ++e) block[e] = 0;
      for (std::size_t e = 0; e < kJoint; ++e) right[e] = 0;
    }
    touched_.clear();
  }

  /// @param a  the diagonal block's lower triangle by columns: 00 10 20 11 21 22
  /// @param b  the right side
  HWY_INLINE void enter(std::size_t s, V hold, T* below, V* a, V* b) const {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, T(1));
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
      hold = hn::Add(hold, turn);
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
    if (is_touched_[s]) {
      const T* extra = extra_ + s * kBlock;
      for (std::size_t c = 0, e = 0; c < 3; ++c)
        for (std::size_t r = c; r < 3; ++r, ++e)
          a[e] = hn::Add(a[e], load(extra + c * kJoint + r * N));
      for (std::size_t c = 0; c < 3; ++c)
        b[c] = hn::Add(b[c], load(extra_right_ + s * kJoint + c * N));
    }
    for (const std::size_t e : {0, 3, 5}) a[e] = hn::Add(a[e], hold);

    T* block = below;
    for (auto e = plan_.column[s]; e < plan_.column[s + 1]; ++e, block += kBlock) {
      const int pair = plan_.block_pair[std::size_t(e)];
      if (pair < 0) {
        for (std::size_t c = 0; c < 3; ++c)
          for (std::size_t r = 0; r < 3; ++r) hn::StoreU(zero, d, block + c * kJoint + r * N);
        continue;
      }
      enter_pair(block, std::size_t(pair), false);
    }
    for (auto e = plan_.addition_begin[s]; e < plan_.addition_begin[s + 1]; ++e) {
      const auto& more = plan_.additions[std::size_t(e)];
      block = below + std::size_t(more.block) * kBlock;
      if (more.volume < 0) {
        enter_pair(block, std::size_t(more.pair()), true);
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
  }

  /// The same for one conformer, three rows at once.
  /// @param a  columns of the diagonal block
  HWY_INLINE void enter_padded(std::size_t s, T hold, T* below, W* a, W& right) const {
    const P d;
    W a0 = hn::Zero(d), a1 = hn::Zero(d), a2 = hn::Zero(d);
    right = hn::Zero(d);
    for (auto e = plan_.end_begin[s]; e < plan_.end_begin[s + 1]; ++e) {
      const int end = plan_.ends[std::size_t(e)];
      const std::size_t pair = std::size_t(end >> 1);
      const T* unit = rows_.unit + pair * 4;
      const W u = wide(unit), su = hn::Mul(all(T(1) - unit[3]), u);
      a0 = hn::MulAdd(all(unit[0]), su, a0);
      a1 = hn::MulAdd(all(unit[1]), su, a1);
      a2 = hn::MulAdd(all(unit[2]), su, a2);
      hold += unit[3];
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
    if (is_touched_[s]) {
      const T* extra = extra_ + s * 12;
      a0 = hn::Add(a0, wide(extra));
      a1 = hn::Add(a1, wide(extra + 4));
      a2 = hn::Add(a2, wide(extra + 8));
      right = hn::Add(right, wide(extra_right_ + s * 4));
    }
    a[0] = hn::MulAdd(all(hold), axis(0), a0);
    a[1] = hn::MulAdd(all(hold), axis(1), a1);
    a[2] = hn::MulAdd(all(hold), axis(2), a2);

    T* block = below;
    for (auto e = plan_.column[s]; e < plan_.column[s + 1]; ++e, block += 12) {
      const int pair = plan_.block_pair[std::size_t(e)];
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
      block = below + std::size_t(more.block) * 12;
      if (more.volume < 0) {
        enter_pair_padded(block, std::size_t(more.pair()), true);
        continue;
      }
      const std::size_t v = std::size_t(more.volume);
      if (!rows_.active[v]) continue;
      const W row = wide(rows_.gradient + (4 * v + std::size_t(more.row)) * 4);
      const T* col = rows_.gradient + (4 * v + std::size_t(more.col)) * 4;
      for (std::size_t c = 0; c < 3; ++c)
        hn::StoreU(hn::MulAdd(all(col[c]), row, wide(block + 4 * c)), d, block + 4 * c);
    }
  }

  /// The right side of slot s.
  HWY_INLINE void pull(std::size_t s, T* to) const {
    if constexpr (kPadded) {
      const P d;
      W right = is_touched_[s] ? wide(extra_right_ + s * 4) : hn::Zero(d);
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
      hn::StoreU(right, d, to);
    } else {
      const D d;
      const V zero = hn::Zero(d);
      V b[3] = {zero, zero, zero};
      if (is_touched_[s])
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
      for (std::size_t c = 0; c < 3; ++c) hn::StoreU(b[c], d, to + c * N);
    }
  }

 private:
  const NewtonPlan& plan_;
  const NewtonRows<T, kSingle>& rows_;
  Field<T> extra_, extra_right_;
  std::vector<int> touched_;              ///< slots that have extra rows
  std::vector<std::uint8_t> is_touched_;  ///< (nmoving)

  /// A pair's block below the diagonal: -(1 - turn) u u^T - turn.
  HWY_INLINE void enter_pair(T* block, std::size_t pair, bool add) const {
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

  static HWY_INLINE W axis(std::size_t c) {
    HWY_ALIGN static constexpr T axes[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    return wide(axes + 4 * c);
  }

  HWY_INLINE void enter_pair_padded(T* block, std::size_t pair, bool add) const {
    const P d;
    const T* unit = rows_.unit + pair * 4;
    const W su = hn::Mul(all(T(1) - unit[3]), wide(unit));
    for (std::size_t c = 0; c < 3; ++c) {
      const W value = hn::NegMulAdd(all(unit[c]), su, add ? wide(block + 4 * c) : hn::Zero(d));
      // a product with one and a sum with zero round nothing
      hn::StoreU(hn::NegMulAdd(all(unit[3]), axis(c), value), d, block + 4 * c);
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#endif
