// NewtonRows: the rows of `newton` and their gradients, by which its factor is made, and how
// numbers lie in memory: one conformer's, or one in each lane of a vector. Compiled once for each
// set of instructions.

#if defined(RAGDOLL_NEWTON_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RAGDOLL_NEWTON_ROWS_INL_H_
#undef RAGDOLL_NEWTON_ROWS_INL_H_
#else
#define RAGDOLL_NEWTON_ROWS_INL_H_
#endif

#include <algorithm>  // fill_n
#include <cstddef>
#include <cstdint>
#include <type_traits>  // conditional

#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

#include "newton_plan.h"  // NewtonPlan

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Zeros, aligned for vectors.
template <class T>
class Field {
 public:
  Field() = default;
  HWY_NOINLINE explicit Field(std::size_t count)
      // vectors of a padded column reach beyond the last number
      : data_(hwy::AllocateAligned<T>(count + 64 / sizeof(T))), count_(count) {
    std::fill_n(data_.get(), count + 64 / sizeof(T), T(0));
  }
  T* operator+(std::size_t k) const { return data_.get() + k; }
  T& operator[](std::size_t k) const { return data_[k]; }
  std::size_t size() const { return count_; }

 private:
  hwy::AlignedFreeUniquePtr<T[]> data_;
  std::size_t count_ = 0;
};

template <class T, bool kSingle>
struct NewtonLayout {
  using D = typename std::conditional<kSingle, hn::CappedTag<T, 1>, hn::ScalableTag<T>>::type;
  using V = hn::VFromD<D>;
  static constexpr std::size_t kLanes = kSingle ? 1 : hn::MaxLanes(D());

  // strides: of an axis, of a joint, of a block's column, of a block
  static constexpr std::size_t N = kLanes;
  static constexpr std::size_t kJoint = kSingle ? 4 : 3 * N;
  static constexpr std::size_t kBlock = 3 * kJoint;
  static constexpr bool kPadded = kSingle && HWY_MAX_BYTES >= 4 * sizeof(T);

  // one conformer's four numbers side by side
  using P = typename std::conditional<kPadded, hn::CappedTag<T, 4>, D>::type;
  using W = hn::VFromD<P>;

  static HWY_INLINE V load(const T* at) { return hn::LoadU(D(), at); }
  static HWY_INLINE W wide(const T* at) { return hn::LoadU(P(), at); }
  static HWY_INLINE W all(T value) { return hn::Set(P(), value); }
};

template <class T, bool kSingle>
struct NewtonRows {
  using Layout = NewtonLayout<T, kSingle>;
  explicit NewtonRows(const NewtonPlan& plan)
      : unit(plan.pairs.size() * 4 * Layout::N),
        row(plan.pairs.size() * Layout::N),
        gradient(plan.volumes.size() * 4 * Layout::kJoint),
        excess(plan.volumes.size() * Layout::N),
        active(plan.volumes.size()) {}

  Field<T> unit;      ///< from p to q, and how far the pair resists turning
  Field<T> row;       ///< distance less length
  Field<T> gradient;  ///< of volumes over their area; those that are not active are not kept
  Field<T> excess;    ///< over the area
  Field<std::uint8_t> active;
};

}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#endif
