#include "contact_kernels.h"

#include <algorithm>  // min, max
#include <cmath>      // sqrt

// this file is compiled once for each kind of vectors
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "contact_kernels.cpp"
#include <hwy/foreach_target.h>
// behind it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ragdoll::contact_kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The residents that are near one point: filled in vectors, then read one by one.
class Near {
 public:
  void find(const Residents& residents, int first, int last, float x, float y, float z,
            float limit2) {
    constexpr hn::ScalableTag<float> df;
    constexpr hn::RebindToSigned<decltype(df)> di;
    const int lanes = int(hn::Lanes(df));
    const std::size_t needed = count_ + std::size_t(last - first + 2 * lanes);
    if (index_.size() < needed) {
      index_.resize(2 * needed);
      square_.resize(2 * needed);
    }
    const auto px = hn::Set(df, x), py = hn::Set(df, y), pz = hn::Set(df, z);
    const auto far = hn::Set(df, limit2);
    const auto end = hn::Set(di, last);
    for (int k = first; k < last; k += lanes) {
      const auto dx = hn::Sub(hn::LoadU(df, residents.x + k), px);
      const auto dy = hn::Sub(hn::LoadU(df, residents.y + k), py);
      const auto dz = hn::Sub(hn::LoadU(df, residents.z + k), pz);
      const auto d2 = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
      const auto index = hn::Iota(di, k);
      // what is no number is not far
      const auto near = hn::AndNot(hn::Ge(d2, far), hn::RebindMask(df, hn::Lt(index, end)));
      hn::StoreU(hn::Compress(index, hn::RebindMask(di, near)), di, index_.data() + count_);
      hn::StoreU(hn::Compress(d2, near), df, square_.data() + count_);
      count_ += hn::CountTrue(df, near);
    }
  }

  void clear() { count_ = 0; }
  std::size_t count() const { return count_; }
  int index(std::size_t k) const { return index_[k]; }
  float square(std::size_t k) const { return square_[k]; }

 private:
  std::size_t count_ = 0;
  std::vector<int> index_;
  std::vector<float> square_;
};

void FindNear(const Residents& residents, int first, int last, const Neighbours* neighbours,
              std::size_t neighbour_count, float limit, float margin,
              std::vector<CellPair>& pairs) {
  static thread_local Near near;
  const float limit2 = (limit + margin) * (limit + margin);
  for (int home = first; home < last; ++home) {
    const float x = residents.x[home], y = residents.y[home], z = residents.z[home];
    near.clear();
    near.find(residents, home + 1, last, x, y, z, limit2);
    for (std::size_t k = 0; k < neighbour_count; ++k) {
      const Neighbours& cell = neighbours[k];
      near.find(residents, cell.first, cell.last, x - cell.shift[0], y - cell.shift[1],
                z - cell.shift[2], limit2);
    }
    const int joint = residents.joints[home];
    const std::size_t before = pairs.size();
    pairs.resize(before + near.count());
    CellPair* const out = pairs.data() + before;
    for (std::size_t k = 0; k < near.count(); ++k) {
      const int other = residents.joints[near.index(k)];
      const float distance = std::sqrt(near.square(k)) - margin;
      // false for what is no number too
      out[k] = {std::min(joint, other), std::max(joint, other), distance > 0 ? distance : 0};
    }
  }
}

Largest MeasureMoves(const double* x, const double* reference, std::size_t count, float* moved) {
  constexpr hn::ScalableTag<double> dd;
  constexpr hn::Rebind<float, decltype(dd)> df;
  const std::size_t lanes = hn::Lanes(dd);
  // above what rounding, here and where distances are added up, takes away
  const auto above = hn::Set(df, 1 + 1e-6f);
  auto first = hn::Zero(df), second = hn::Zero(df);
  std::size_t j = 0;
  for (; j + lanes <= count; j += lanes) {
    decltype(hn::Zero(dd)) ax, ay, az, bx, by, bz;
    hn::LoadInterleaved3(dd, x + 3 * j, ax, ay, az);
    hn::LoadInterleaved3(dd, reference + 3 * j, bx, by, bz);
    const auto dx = hn::Sub(ax, bx), dy = hn::Sub(ay, by), dz = hn::Sub(az, bz);
    const auto d2 = hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
    const auto d = hn::Mul(hn::Sqrt(hn::DemoteTo(df, d2)), above);
    hn::StoreU(d, df, moved + j);
    second = hn::Max(second, hn::Min(first, d));
    first = hn::Max(first, d);
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

}  // namespace ragdoll::contact_kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll::contact_kernels {

HWY_EXPORT(FindNear);
HWY_EXPORT(MeasureMoves);

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

}  // namespace ragdoll::contact_kernels
#endif
