#include "contact_kernels.h"

#include <algorithm>  // min, max
#include <cmath>      // sqrt
#include <cstdint>

// this file is compiled once for each kind of vectors
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "contact_kernels.cpp"
#include <hwy/foreach_target.h>
// behind it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ragdoll::contact_kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Writes the lanes of a vector that a mask takes, one behind the other; what lies behind them, as
/// far as a vector reaches, is overwritten.
template <class D, class V, class M>
HWY_INLINE void Pack(D d, V vector, M mask, hn::TFromD<D>* to) {
#if !HWY_ARCH_X86 || HWY_TARGET <= HWY_AVX3
  hn::StoreU(hn::Compress(vector, mask), d, to);
#else
  // without an instruction for it, at most eight lanes; compilers would copy the table of
  // permutations to the stack each time
  HWY_ALIGN hn::TFromD<D> lanes[hn::MaxLanes(D())];
  hn::Store(vector, d, lanes);
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  for (unsigned bits = bytes[0]; bits != 0; bits &= bits - 1)
    *to++ = lanes[hwy::Num0BitsBelowLS1Bit_Nonzero32(bits)];
#endif
}

/// Residents that are near one point, and their squared distances.
struct Near {
  int* index;
  float* square;
  std::size_t count = 0;
};

HWY_INLINE void AppendNear(const Residents& residents, int first, int last, float x, float y,
                           float z, float limit2, Near& near) {
  constexpr hn::ScalableTag<float> df;
  constexpr hn::RebindToSigned<decltype(df)> di;
  const int lanes = int(hn::Lanes(df));
  const auto px = hn::Set(df, x), py = hn::Set(df, y), pz = hn::Set(df, z);
  const auto far = hn::Set(df, limit2);
  const auto end = hn::Set(di, last), step = hn::Iota(di, 0);
  for (int k = first; k < last; k += lanes) {
    const auto dx = hn::Sub(hn::LoadU(df, residents.x + k), px);
    const auto dy = hn::Sub(hn::LoadU(df, residents.y + k), py);
    const auto dz = hn::Sub(hn::LoadU(df, residents.z + k), pz);
    const auto d2 = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto index = hn::Add(step, hn::Set(di, k));
    // what is no number is not far
    const auto is_near = hn::AndNot(hn::Ge(d2, far), hn::RebindMask(df, hn::Lt(index, end)));
    Pack(di, index, hn::RebindMask(di, is_near), near.index + near.count);
    Pack(df, d2, is_near, near.square + near.count);
    near.count += hn::CountTrue(df, is_near);
  }
}

void FindNear(const Residents& residents, int first, int last, const Neighbours* neighbours,
              std::size_t neighbour_count, float limit, float margin,
              std::vector<CellPair>& pairs) {
  std::size_t most = std::size_t(last - first) + padding;
  for (std::size_t k = 0; k < neighbour_count; ++k)
    most += std::size_t(neighbours[k].last - neighbours[k].first);
  std::vector<int> index(most);
  std::vector<float> square(most);
  const float limit2 = (limit + margin) * (limit + margin);
  for (int home = first; home < last; ++home) {
    const float x = residents.x[home], y = residents.y[home], z = residents.z[home];
    Near near = {index.data(), square.data()};
    AppendNear(residents, home + 1, last, x, y, z, limit2, near);
    for (std::size_t k = 0; k < neighbour_count; ++k) {
      const Neighbours& cell = neighbours[k];
      AppendNear(residents, cell.first, cell.last, x - cell.shift[0], y - cell.shift[1],
                 z - cell.shift[2], limit2, near);
    }
    const int joint = residents.joints[home];
    const std::size_t before = pairs.size();
    pairs.resize(before + near.count);
    CellPair* const out = pairs.data() + before;
    for (std::size_t k = 0; k < near.count; ++k) {
      const int other = residents.joints[near.index[k]];
      const float distance = std::sqrt(near.square[k]) - margin;
      // false for what is no number too
      out[k] = {std::min(joint, other), std::max(joint, other), distance > 0 ? distance : 0};
    }
  }
}

Largest MeasureMoves(const double* x, const double* reference, std::size_t count, float* moved) {
  constexpr hn::ScalableTag<float> df;
  constexpr hn::Half<decltype(df)> dh;
  constexpr hn::Rebind<double, decltype(dh)> dd;
  const std::size_t lanes = hn::Lanes(df), half = hn::Lanes(dd);
  // above what rounding, here and where distances are added up, takes away
  const auto above = hn::Set(df, 1 + 1e-6f);
  auto first = hn::Zero(df), second = hn::Zero(df);
  // squares are all written before they are read: what was just written is slow to read otherwise
  constexpr std::size_t block = 256;
  HWY_ALIGN float squares[3 * block];
  std::size_t j = 0;
  for (; j + lanes <= count;) {
    const std::size_t size = std::min(block, (count - j) / lanes * lanes);
    for (std::size_t k = 0; k < 3 * size; k += half) {
      const auto d = hn::Sub(hn::LoadU(dd, x + 3 * j + k), hn::LoadU(dd, reference + 3 * j + k));
      hn::StoreU(hn::DemoteTo(dh, hn::Mul(d, d)), dh, squares + k);
    }
    for (std::size_t k = 0; k < size; k += lanes) {
      decltype(hn::Zero(df)) dx2, dy2, dz2;
      hn::LoadInterleaved3(df, squares + 3 * k, dx2, dy2, dz2);
      const auto d = hn::Mul(hn::Sqrt(hn::Add(hn::Add(dx2, dy2), dz2)), above);
      hn::StoreU(d, df, moved + j + k);
      second = hn::Max(second, hn::Min(first, d));
      first = hn::Max(first, d);
    }
    j += size;
  }
  Largest largest;
  const auto take = [&largest](float d) {
    largest.second = std::max(largest.second, std::min(largest.first, d));
    largest.first = std::max(largest.first, d);
  };
  for (; j < count; ++j) {
    double d2 = 0;
    for (std::size_t c = 3 * j; c < 3 * j + 3; ++c)
      d2 += (x[c] - reference[c]) * (x[c] - reference[c]);
    moved[j] = std::sqrt(float(d2)) * (1 + 1e-6f);
    take(moved[j]);
  }
  for (std::size_t lane = 0; lane < hn::Lanes(df) && count >= lanes; ++lane) {
    take(hn::ExtractLane(first, lane));
    take(hn::ExtractLane(second, lane));
  }
  return largest;
}

std::size_t SelectBelow(const float* values, std::size_t count, float limit, int* selected) {
  constexpr hn::ScalableTag<float> df;
  constexpr hn::RebindToSigned<decltype(df)> di;
  const std::size_t lanes = hn::Lanes(df);
  const auto most = hn::Set(df, limit);
  const auto step = hn::Iota(di, 0);
  std::size_t kept = 0, k = 0;
  for (; k + lanes <= count; k += lanes) {
    const auto below = hn::Le(hn::LoadU(df, values + k), most);
    // an index is written before or at the place of its value, so that there is room
    const auto index = hn::Add(step, hn::Set(di, int(k)));
    Pack(di, index, hn::RebindMask(di, below), selected + kept);
    kept += hn::CountTrue(df, below);
  }
  for (; k < count; ++k) {
    selected[kept] = int(k);
    kept += std::size_t(values[k] <= limit);
  }
  return kept;
}

}  // namespace ragdoll::contact_kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll::contact_kernels {

HWY_EXPORT(FindNear);
HWY_EXPORT(MeasureMoves);
HWY_EXPORT(SelectBelow);

void find_near(const Residents& residents, int first, int last,
               std::span<const Neighbours> neighbours, float limit, float margin,
               std::vector<CellPair>& pairs) {
  HWY_DYNAMIC_DISPATCH(FindNear)
  (residents, first, last, neighbours.data(), neighbours.size(), limit, margin, pairs);
}

Largest measure_moves(std::span<const Vec3> positions, std::span<const Vec3> reference,
                      std::span<float> moved) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const double* const x = positions.empty() ? nullptr : positions.data()->data();
  const double* const r = reference.empty() ? nullptr : reference.data()->data();
  return HWY_DYNAMIC_DISPATCH(MeasureMoves)(x, r, positions.size(), moved.data());
}

std::size_t select_below(std::span<const float> values, float limit, std::span<int> selected) {
  return HWY_DYNAMIC_DISPATCH(SelectBelow)(values.data(), values.size(), limit, selected.data());
}

}  // namespace ragdoll::contact_kernels
#endif
