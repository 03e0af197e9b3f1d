#include "lane_rmsd.h"

#include <algorithm>  // min, max

// this file is compiled once for each kind of vectors
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lane_rmsd.cpp"
#include <hwy/foreach_target.h>
// behind it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ragdoll::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Theobald's way (Acta Cryst. A 61, 478, 2005): the largest root of the quartic of Horn's matrix,
/// by Newton's steps from above; all is divided by the mean of the two sums of squares.
/// @param block  (natom, 3, 16)
void Rmsd(const float* block, const float* norms, std::size_t natom, const float* places,
          float norm, float* distances) {
  constexpr hn::CappedTag<float, 16> d;
  const std::size_t step = hn::Lanes(d);
  const auto half = hn::Set(d, 0.5f);
  for (std::size_t l = 0; l < 16; l += step) {
    auto xx = hn::Zero(d), xy = hn::Zero(d), xz = hn::Zero(d);
    auto yx = hn::Zero(d), yy = hn::Zero(d), yz = hn::Zero(d);
    auto zx = hn::Zero(d), zy = hn::Zero(d), zz = hn::Zero(d);
    const float* from = block + l;
    for (std::size_t a = 0; a < natom; ++a, from += 48) {
      const auto x = hn::LoadU(d, from), y = hn::LoadU(d, from + 16), z = hn::LoadU(d, from + 32);
      const auto u = hn::Set(d, places[3 * a]), v = hn::Set(d, places[3 * a + 1]),
                 w = hn::Set(d, places[3 * a + 2]);
      xx = hn::MulAdd(x, u, xx);
      xy = hn::MulAdd(x, v, xy);
      xz = hn::MulAdd(x, w, xz);
      yx = hn::MulAdd(y, u, yx);
      yy = hn::MulAdd(y, v, yy);
      yz = hn::MulAdd(y, w, yz);
      zx = hn::MulAdd(z, u, zx);
      zy = hn::MulAdd(z, v, zy);
      zz = hn::MulAdd(z, w, zz);
    }
    const auto mean = hn::Mul(half, hn::Add(hn::LoadU(d, norms + l), hn::Set(d, norm)));
    const auto scale = hn::Div(hn::Set(d, 1), hn::Max(mean, hn::Set(d, 1e-12f)));
    for (auto* const m : {&xx, &xy, &xz, &yx, &yy, &yz, &zx, &zy, &zz}) *m = hn::Mul(*m, scale);

    const auto xx2 = hn::Mul(xx, xx), yy2 = hn::Mul(yy, yy), zz2 = hn::Mul(zz, zz);
    const auto xy2 = hn::Mul(xy, xy), yz2 = hn::Mul(yz, yz), xz2 = hn::Mul(xz, xz);
    const auto yx2 = hn::Mul(yx, yx), zy2 = hn::Mul(zy, zy), zx2 = hn::Mul(zx, zx);
    const auto two = hn::Set(d, 2);
    const auto yzzymyyzz2 = hn::Mul(two, hn::Sub(hn::Mul(yz, zy), hn::Mul(yy, zz)));
    const auto sum = hn::Sub(hn::Add(hn::Add(yy2, zz2), hn::Add(yz2, zy2)), xx2);
    const auto all = hn::Add(hn::Add(hn::Add(xx2, yy2), hn::Add(zz2, xy2)),
                             hn::Add(hn::Add(yz2, xz2), hn::Add(hn::Add(yx2, zy2), zx2)));
    const auto c2 = hn::Mul(hn::Set(d, -2), all);
    const auto determinant =
        hn::Add(hn::Sub(hn::Mul(xx, hn::Sub(hn::Mul(yy, zz), hn::Mul(yz, zy))),
                        hn::Mul(xy, hn::Sub(hn::Mul(yx, zz), hn::Mul(yz, zx)))),
                hn::Mul(xz, hn::Sub(hn::Mul(yx, zy), hn::Mul(yy, zx))));
    const auto c1 = hn::Mul(hn::Set(d, -8), determinant);
    const auto xzpzx = hn::Add(xz, zx), yzpzy = hn::Add(yz, zy), xypyx = hn::Add(xy, yx);
    const auto yzmzy = hn::Sub(yz, zy), xzmzx = hn::Sub(xz, zx), xymyx = hn::Sub(xy, yx);
    const auto xxpyy = hn::Add(xx, yy), xxmyy = hn::Sub(xx, yy);
    const auto a = hn::Sub(hn::Add(xy2, xz2), hn::Add(yx2, zx2));
    const auto b = hn::Mul(hn::Add(sum, yzzymyyzz2), hn::Sub(sum, yzzymyyzz2));
    const auto add = [&](auto p, auto q, auto r, auto s) {
      return hn::Add(hn::Mul(p, q), hn::Mul(r, s));
    };
    const auto neg = [&](auto p) { return hn::Neg(p); };
    const auto e1 = hn::Mul(add(neg(xzpzx), yzmzy, xymyx, hn::Sub(xxmyy, zz)),
                            add(neg(xzmzx), yzpzy, xymyx, hn::Sub(xxmyy, neg(zz))));
    const auto e2 = hn::Mul(add(neg(xzpzx), yzpzy, neg(xypyx), hn::Sub(xxpyy, zz)),
                            add(neg(xzmzx), yzmzy, neg(xypyx), hn::Add(xxpyy, zz)));
    const auto e3 = hn::Mul(add(xypyx, yzpzy, xzpzx, hn::Add(xxmyy, zz)),
                            add(neg(xymyx), yzmzy, xzpzx, hn::Add(xxpyy, zz)));
    const auto e4 = hn::Mul(add(xypyx, yzmzy, xzmzx, hn::Sub(xxmyy, zz)),
                            add(neg(xymyx), yzpzy, xzmzx, hn::Sub(xxpyy, zz)));
    const auto c0 = hn::Add(hn::Add(hn::Mul(a, a), b), hn::Add(hn::Add(e1, e2), hn::Add(e3, e4)));
    auto root = hn::Set(d, 1);
    for (int k = 0; k < 8; ++k) {
      const auto x2 = hn::Mul(root, root);
      const auto q = hn::Mul(hn::Add(x2, c2), root);
      const auto value = hn::Add(hn::Mul(hn::Add(q, c1), root), c0);
      const auto slope = hn::Add(hn::Add(hn::Mul(hn::Mul(two, x2), root), q), hn::Add(q, c1));
      const auto change = hn::Div(value, hn::Max(slope, hn::Set(d, 1e-6f)));
      // from above, steps go down
      root = hn::Sub(root, hn::Max(change, hn::Zero(d)));
    }
    const auto square = hn::Mul(hn::Mul(hn::Set(d, 2), mean), hn::Sub(hn::Set(d, 1), root));
    const auto rmsd =
        hn::Sqrt(hn::Max(hn::Zero(d), hn::Mul(square, hn::Set(d, 1.0f / float(natom)))));
    hn::StoreU(hn::Min(rmsd, hn::LoadU(d, distances + l)), d, distances + l);
  }
}

void Shorten(const float* blocks, const float* norms, std::size_t count, std::size_t natom,
             const float* places, float norm, float* distances) {
  for (std::size_t k = 0; k < count; ++k)
    Rmsd(blocks + k * natom * 48, norms + 16 * k, natom, places, norm, distances + 16 * k);
}

}  // namespace ragdoll::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ragdoll {

HWY_EXPORT(Shorten);

void ConformerBlock::add(std::span<const float> places) {
  const std::size_t n = count_++, block = n / lanes, lane = n % lanes;
  if (lane == 0) {
    places_.resize((block + 1) * natom_ * 3 * lanes);
    norm_.resize((block + 1) * lanes);
  }
  float centre[3] = {0, 0, 0};
  for (std::size_t k = 0; k < 3 * natom_; ++k) centre[k % 3] += places[k];
  for (float& c : centre) c /= float(natom_);
  float norm = 0;
  for (std::size_t k = 0; k < 3 * natom_; ++k) {
    const float x = places[k] - centre[k % 3];
    places_[(block * natom_ * 3 + k) * lanes + lane] = x;
    norm += x * x;
  }
  norm_[n] = norm;
}

void ConformerBlock::get(std::size_t conformer, std::span<float> places) const {
  const std::size_t block = conformer / lanes, lane = conformer % lanes;
  for (std::size_t k = 0; k < 3 * natom_; ++k)
    places[k] = places_[(block * natom_ * 3 + k) * lanes + lane];
}

void ConformerBlock::shorten(std::span<const float> places, float norm, std::size_t first,
                             std::span<float> distances) const {
  const std::size_t block = first / lanes;
  if (block >= norm_.size() / lanes) return;
  HWY_DYNAMIC_DISPATCH(Shorten)
  (places_.data() + block * natom_ * 3 * lanes, norm_.data() + block * lanes,
   norm_.size() / lanes - block, natom_, places.data(), norm, distances.data());
}

}  // namespace ragdoll
#endif
