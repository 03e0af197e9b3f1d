#include "ragdoll/cell_list.h"

#include <algorithm>  // sort, unique
#include <bit>        // bit_ceil
#include <cmath>      // floor

namespace ragdoll {
namespace {

/// Distance between the two faces of the box that are spanned by the other two vectors.
double height(const Vec3& along, const Vec3& u, const Vec3& v) {
  const Vec3 normal = u.cross(v).normalized();
  return std::abs(along.dot(normal));
}

std::int64_t wrap(std::int64_t cell, std::int64_t count) {
  const std::int64_t rest = cell % count;
  return rest < 0 ? rest + count : rest;
}

/// Cell coordinate of a number of cell widths; far flights are all put into the last cell.
std::int64_t whole(double widths) {
  return std::int64_t(std::floor(std::clamp(widths, -1e15, 1e15)));
}

}  // namespace

CellList::CellList(std::span<const Vec3> positions, double cutoff, const Box* box)
    : positions_(positions), cutoff_(cutoff), box_(box) {
  if (box) {
    count_[0] = std::max<std::int64_t>(1, whole(height(box->a, box->b, box->c) / cutoff));
    count_[1] = std::max<std::int64_t>(1, whole(height(box->b, box->a, box->c) / cutoff));
    count_[2] = std::max<std::int64_t>(1, whole(height(box->c, box->a, box->b) / cutoff));
  }
  const std::size_t n = positions.size();
  mask_ = std::bit_ceil(2 * n + 1) - 1;
  cells_.reserve(n);
  for (const Vec3& position : positions) cells_.push_back(cell_of(position));

  // counting sort by bucket
  bucket_begin_.assign(mask_ + 2, 0);
  std::vector<std::size_t> bucket(n);
  for (std::size_t j = 0; j < n; ++j) ++bucket_begin_[(bucket[j] = bucket_of(cells_[j])) + 1];
  for (std::size_t b = 0; b <= mask_; ++b) bucket_begin_[b + 1] += bucket_begin_[b];
  bucket_joints_.resize(n);
  std::vector<int> cursor(bucket_begin_.begin(), bucket_begin_.end() - 1);
  for (std::size_t j = 0; j < n; ++j) bucket_joints_[std::size_t(cursor[bucket[j]]++)] = int(j);
}

CellList::Cell CellList::cell_of(const Vec3& position) const {
  if (!box_)
    return {whole(position[0] / cutoff_), whole(position[1] / cutoff_),
            whole(position[2] / cutoff_)};
  // the reduced form is lower triangular: solve from the last coordinate
  const double fc = position[2] / box_->c[2];
  const double fb = (position[1] - fc * box_->c[1]) / box_->b[1];
  const double fa = (position[0] - fc * box_->c[0] - fb * box_->b[0]) / box_->a[0];
  const auto cell = [](double fraction, std::int64_t count) {
    return wrap(whole((fraction - std::floor(fraction)) * double(count)), count);
  };
  return {cell(fa, count_[0]), cell(fb, count_[1]), cell(fc, count_[2])};
}

std::size_t CellList::bucket_of(const Cell& cell) const {
  std::uint64_t h = std::uint64_t(cell.x) * 0x9e3779b97f4a7c15ull;
  h = (h ^ std::uint64_t(cell.y)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ std::uint64_t(cell.z)) * 0x94d049bb133111ebull;
  return std::size_t(h >> 20) & mask_;
}

void CellList::append_partners(int p, std::vector<int>& partners) const {
  const Cell& home = cells_[std::size_t(p)];
  const Vec3& here = positions_[std::size_t(p)];
  const double cutoff2 = cutoff_ * cutoff_;

  // the 27 cells around; in a small box some of them are the same
  Cell around[27];
  std::size_t cells = 0;
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz) {
        Cell cell = {home.x + dx, home.y + dy, home.z + dz};
        if (box_)
          cell = {wrap(cell.x, count_[0]), wrap(cell.y, count_[1]), wrap(cell.z, count_[2])};
        bool known = false;
        if (box_)
          for (std::size_t k = 0; k < cells && !known; ++k) known = around[k] == cell;
        if (!known) around[cells++] = cell;
      }

  for (std::size_t k = 0; k < cells; ++k) {
    const std::size_t bucket = bucket_of(around[k]);
    for (int s = bucket_begin_[bucket]; s < bucket_begin_[bucket + 1]; ++s) {
      const int q = bucket_joints_[std::size_t(s)];
      if (q <= p || !(cells_[std::size_t(q)] == around[k])) continue;
      Vec3 d = positions_[std::size_t(q)] - here;
      if (box_) d = box_->minimum_image(d);
      if (d.squaredNorm() < cutoff2) partners.push_back(q);
    }
  }
}

}  // namespace ragdoll
