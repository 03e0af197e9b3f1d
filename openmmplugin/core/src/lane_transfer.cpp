// This file is compiled once for each instruction set, by foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lane_transfer.cpp"
// vectors whose length only the machine knows cannot be kept in arrays
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#include <hwy/foreach_target.h>  // first, by its rules
// then
#include <hwy/highway.h>

#include <algorithm>  // min, max
#include <array>
#include <limits>  // infinity

#include "lane_transfer.h"

HWY_BEFORE_NAMESPACE();
namespace ragdoll {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kPeriod = 12;          ///< after so many numbers axes repeat
constexpr std::size_t kChunk = 4 * kPeriod;  ///< numbers of a lane before it is the next ones' turn
using Reference = std::array<double, kPeriod>;

Reference Repeated(const Vec3& reference) {
  Reference all;
  for (std::size_t e = 0; e < kPeriod; ++e) all[e] = reference[Eigen::Index(e % 3)];
  return all;
}

#if HWY_TARGET != HWY_SCALAR  // which has no fours

/// Four lanes at a time, four numbers of each.
using Four = hn::FixedTag<float, 4>;
using FourOf = hn::Vec<Four>;
using Doubles = hn::CappedTag<double, 4>;

/// Four numbers, as floats about the reference. @tparam D  as many doubles as a vector has, up to 4
template <class D>
HWY_INLINE FourOf Rounded(D d, const double* from, const double* reference) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::DemoteTo(Four(), hn::Sub(hn::LoadU(d, from), hn::LoadU(d, reference)));
  } else {
    const hn::Half<Four> half;
    const auto lower = hn::Sub(hn::LoadU(d, from), hn::LoadU(d, reference));
    const auto upper = hn::Sub(hn::LoadU(d, from + 2), hn::LoadU(d, reference + 2));
    return hn::Combine(Four(), hn::DemoteTo(half, upper), hn::DemoteTo(half, lower));
  }
}

HWY_INLINE void Transpose(FourOf (&v)[4]) {
  const Four d;
  const FourOf a = hn::InterleaveLower(d, v[0], v[1]), b = hn::InterleaveLower(d, v[2], v[3]);
  const FourOf e = hn::InterleaveUpper(d, v[0], v[1]), f = hn::InterleaveUpper(d, v[2], v[3]);
  v[0] = hn::ConcatLowerLower(d, b, a);
  v[1] = hn::ConcatUpperUpper(d, b, a);
  v[2] = hn::ConcatLowerLower(d, f, e);
  v[3] = hn::ConcatUpperUpper(d, f, e);
}

struct FourSources {
  const double* from[4];
  Reference reference[4];
  float on[4];  ///< 0: the lane stays
  bool any = false, all = true;
};

template <bool kAll>
void PutFour(const FourSources& four, std::size_t first, std::size_t last, std::size_t stride,
             float* lanes) {
  const Four d;
  const auto on = hn::Ne(hn::LoadU(d, four.on), hn::Zero(d));
  std::size_t e = first;
  for (std::size_t phase = 0; e + 4 <= last; e += 4, phase = phase == 8 ? 0 : phase + 4) {
    FourOf v[4];
    for (std::size_t l = 0; l < 4; ++l)
      v[l] = Rounded(Doubles(), four.from[l] + e, four.reference[l].data() + phase);
    Transpose(v);
    for (std::size_t i = 0; i < 4; ++i) {
      float* const to = lanes + (e + i) * stride;
      hn::StoreU(kAll ? v[i] : hn::IfThenElse(on, v[i], hn::LoadU(d, to)), d, to);
    }
  }
  for (; e < last; ++e)
    for (std::size_t l = 0; l < 4; ++l)
      if (four.on[l] != 0)
        lanes[e * stride + l] = float(four.from[l][e] - four.reference[l][e % kPeriod]);
}

void PutFours(std::span<const LaneSource> sources, std::size_t count, float* lanes) {
  const std::size_t stride = sources.size();
  constexpr std::size_t most_groups = hn::MaxLanes(hn::ScalableTag<float>()) / 4;
  FourSources groups[most_groups];
  for (std::size_t g = 0; 4 * g < stride; ++g)
    for (std::size_t l = 0; l < 4; ++l) {
      FourSources& group = groups[g];
      const LaneSource& source = sources[4 * g + l];
      group.on[l] = source.positions ? 1 : 0;
      group.any |= source.positions != nullptr;
      group.all &= source.positions != nullptr;
      group.reference[l] = Repeated(source.reference);
      // any that can be read
      for (std::size_t k = 0; k < 4; ++k)
        if (const Vec3* other = sources[4 * g + k].positions) group.from[l] = other->data();
      if (source.positions) group.from[l] = source.positions->data();
    }
  for (std::size_t first = 0; first < count; first += kChunk) {
    const std::size_t last = std::min(count, first + kChunk);
    for (std::size_t g = 0; 4 * g < stride; ++g) {
      if (groups[g].all)
        PutFour<true>(groups[g], first, last, stride, lanes + 4 * g);
      else if (groups[g].any)
        PutFour<false>(groups[g], first, last, stride, lanes + 4 * g);
    }
  }
}

void TakeFours(const float* lanes, std::size_t count, std::span<const float> wanted, float* rows) {
  const std::size_t stride = wanted.size();
  const Four d;
  for (std::size_t first = 0; first < count; first += kChunk) {
    const std::size_t last = std::min(count, first + kChunk);
    for (std::size_t g = 0; g < stride; g += 4) {
      if (wanted[g] == 0 && wanted[g + 1] == 0 && wanted[g + 2] == 0 && wanted[g + 3] == 0)
        continue;
      std::size_t e = first;
      for (; e + 4 <= last; e += 4) {
        FourOf v[4];
        for (std::size_t i = 0; i < 4; ++i) v[i] = hn::LoadU(d, lanes + (e + i) * stride + g);
        Transpose(v);
        for (std::size_t l = 0; l < 4; ++l) hn::StoreU(v[l], d, rows + (g + l) * count + e);
      }
      for (; e < last; ++e)
        for (std::size_t l = 0; l < 4; ++l) rows[(g + l) * count + e] = lanes[e * stride + g + l];
    }
  }
}

#endif

void Put(std::span<const LaneSource> sources, std::size_t joints, float* lanes) {
  const std::size_t stride = sources.size(), count = 3 * joints;
#if HWY_TARGET != HWY_SCALAR
  if (stride % 4 == 0) return PutFours(sources, count, lanes);
#endif
  for (std::size_t l = 0; l < stride; ++l) {
    if (!sources[l].positions) continue;
    const double* const from = sources[l].positions->data();
    const Reference reference = Repeated(sources[l].reference);
    for (std::size_t e = 0; e < count; ++e)
      lanes[e * stride + l] = float(from[e] - reference[e % kPeriod]);
  }
}

void Take(const float* lanes, std::size_t joints, std::span<const float> wanted, float* rows) {
  const std::size_t stride = wanted.size(), count = 3 * joints;
#if HWY_TARGET != HWY_SCALAR
  if (stride % 4 == 0) return TakeFours(lanes, count, wanted, rows);
#endif
  for (std::size_t l = 0; l < stride; ++l)
    if (wanted[l] != 0)
      for (std::size_t e = 0; e < count; ++e) rows[l * count + e] = lanes[e * stride + l];
}

/// @return how many numbers round to the row's
std::size_t PlaceAll(const float* row, const Vec3& reference, const double* start,
                     std::size_t count, double* to) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<float, decltype(d)> narrow;
  constexpr std::size_t N = hn::MaxLanes(d);
  HWY_ALIGN double about[3 * N];
  for (std::size_t e = 0; e < 3 * N; ++e) about[e] = reference[Eigen::Index(e % 3)];
  std::size_t same = 0, e = 0;
  for (; e + 3 * N <= count; e += 3 * N)
    for (std::size_t i = 0; i < 3 * N; i += N) {
      const auto centre = hn::Load(d, about + i);
      const auto point = hn::LoadU(narrow, row + e + i);
      const auto was = hn::DemoteTo(narrow, hn::Sub(hn::LoadU(d, start + e + i), centre));
      same += hn::CountTrue(narrow, hn::Eq(point, was));
      hn::StoreU(hn::Add(centre, hn::PromoteTo(d, point)), d, to + e + i);
    }
  for (; e < count; ++e) {
    const double centre = reference[Eigen::Index(e % 3)];
    same += row[e] == float(start[e] - centre);
    to[e] = centre + double(row[e]);
  }
  return same;
}

std::size_t PlaceRow(const float* row, const Vec3& reference, const Vec3* start,
                     std::span<Vec3> positions) {
  const std::size_t same =
      PlaceAll(row, reference, start->data(), 3 * positions.size(), positions.data()->data());
  if (same < 3) return 0;
  std::size_t kept = 0;
  for (std::size_t j = 0; j < positions.size(); ++j) {
    const Eigen::Vector3f was = (start[j] - reference).cast<float>();
    if (was[0] != row[3 * j] || was[1] != row[3 * j + 1] || was[2] != row[3 * j + 2]) continue;
    positions[j] = start[j];
    ++kept;
  }
  return kept;
}

Extent Survey(const double* from, std::size_t joints, double* to) {
  const hn::ScalableTag<double> d;
  using V = hn::Vec<decltype(d)>;
  constexpr std::size_t N = hn::MaxLanes(d);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::size_t count = 3 * joints;
  const V zero = hn::Zero(d);
  V lowest[3], highest[3], sum[3];
  for (int i = 0; i < 3; ++i) {
    lowest[i] = hn::Set(d, infinity);
    highest[i] = hn::Set(d, -infinity);
    sum[i] = zero;
  }
  std::size_t e = 0;
  for (; e + 3 * N <= count; e += 3 * N)
    for (std::size_t i = 0; i < 3; ++i) {
      const V v = hn::LoadU(d, from + e + i * N);
      lowest[i] = hn::Min(lowest[i], v);
      highest[i] = hn::Max(highest[i], v);
      sum[i] = hn::MulAdd(v, zero, sum[i]);
      hn::StoreU(v, d, to + e + i * N);
    }
  Extent extent = {Vec3::Constant(infinity), Vec3::Constant(-infinity), true};
  const auto consider = [&](std::size_t number, double low, double high, double nought) {
    const auto axis = Eigen::Index(number % 3);
    extent.lowest[axis] = std::min(extent.lowest[axis], low);
    extent.highest[axis] = std::max(extent.highest[axis], high);
    extent.finite = extent.finite && nought == 0;
  };
  HWY_ALIGN double low[N], high[N], nought[N];
  for (std::size_t i = 0; i < 3; ++i) {
    hn::Store(lowest[i], d, low);
    hn::Store(highest[i], d, high);
    hn::Store(sum[i], d, nought);
    for (std::size_t l = 0; l < N; ++l) consider(i * N + l, low[l], high[l], nought[l]);
  }
  for (; e < count; ++e) {
    consider(e, from[e], from[e], from[e] * 0);
    to[e] = from[e];
  }
  return extent;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace ragdoll
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll {

HWY_EXPORT(Put);
HWY_EXPORT(Take);
HWY_EXPORT(PlaceRow);
HWY_EXPORT(Survey);

Extent copy_and_survey(std::span<const Vec3> positions, Vec3* to) {
  if (positions.empty()) return {Vec3::Zero(), Vec3::Zero(), true};
  return HWY_DYNAMIC_DISPATCH(Survey)(positions.data()->data(), positions.size(), to->data());
}

void put_lanes(std::span<const LaneSource> sources, std::size_t joints, float* lanes) {
  HWY_DYNAMIC_DISPATCH(Put)(sources, joints, lanes);
}

void take_lanes(const float* lanes, std::size_t joints, std::span<const float> wanted,
                float* rows) {
  HWY_DYNAMIC_DISPATCH(Take)(lanes, joints, wanted, rows);
}

std::size_t place_row(const float* row, const Vec3& reference, const Vec3* start,
                      std::span<Vec3> positions) {
  return positions.empty() ? 0 : HWY_DYNAMIC_DISPATCH(PlaceRow)(row, reference, start, positions);
}

}  // namespace ragdoll
#endif
