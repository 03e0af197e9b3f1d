#include "ragdoll/cell_list.h"

#include <algorithm>  // clamp, find, max
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
    : cutoff_(cutoff), box_(box) {
  if (box) {
    count_[0] = std::max<std::int64_t>(1, whole(height(box->a, box->b, box->c) / cutoff));
    count_[1] = std::max<std::int64_t>(1, whole(height(box->b, box->a, box->c) / cutoff));
    count_[2] = std::max<std::int64_t>(1, whole(height(box->c, box->a, box->b) / cutoff));
  }
  // number the cells
  const std::size_t n = positions.size();
  mask_ = std::bit_ceil(2 * n + 1) - 1;
  slots_.assign(mask_ + 1, -1);
  of_joint_.resize(n);
  for (std::size_t j = 0; j < n; ++j) {
    const Cell cell = cell_at(positions[j]);
    int& index = slots_[slot_of(cell)];
    if (index < 0) {
      index = int(cells_.size());
      cells_.push_back(cell);
    }
    of_joint_[j] = index;
  }

  // counting sort by cell
  begin_.assign(cells_.size() + 1, 0);
  for (const int cell : of_joint_) ++begin_[std::size_t(cell) + 1];
  for (std::size_t c = 0; c < cells_.size(); ++c) begin_[c + 1] += begin_[c];
  residents_.resize(n);
  place_.resize(n);
  std::vector<int> cursor(begin_.begin(), begin_.end() - 1);
  for (std::size_t j = 0; j < n; ++j) {
    place_[j] = cursor[std::size_t(of_joint_[j])]++;
    residents_[std::size_t(place_[j])] = {positions[j], int(j)};
  }
  find_neighbours();
}

CellList::Cell CellList::cell_at(const Vec3& position) const {
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

/// The slot of a cell in the hash table, or the free slot where it belongs.
std::size_t CellList::slot_of(const Cell& cell) const {
  std::uint64_t h = std::uint64_t(cell.x) * 0x9e3779b97f4a7c15ull;
  h = (h ^ std::uint64_t(cell.y)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ std::uint64_t(cell.z)) * 0x94d049bb133111ebull;
  std::size_t slot = std::size_t(h >> 20) & mask_;
  while (slots_[slot] >= 0 && !(cells_[std::size_t(slots_[slot])] == cell))
    slot = (slot + 1) & mask_;
  return slot;
}

/// The 27 cells around each cell; in a small box some of them are the same.
void CellList::find_neighbours() {
  around_begin_.reserve(cells_.size() + 1);
  around_begin_.push_back(0);
  for (const Cell& home : cells_) {
    const std::ptrdiff_t first = std::ptrdiff_t(around_.size());
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          Cell cell = {home.x + dx, home.y + dy, home.z + dz};
          if (box_)
            cell = {wrap(cell.x, count_[0]), wrap(cell.y, count_[1]), wrap(cell.z, count_[2])};
          const int index = slots_[slot_of(cell)];
          if (index < 0) continue;
          if (box_ && std::find(around_.begin() + first, around_.end(), index) != around_.end())
            continue;
          around_.push_back(index);
        }
    around_begin_.push_back(int(around_.size()));
  }
}

void CellList::append_partners(int p, std::vector<int>& partners) const {
  const std::size_t home = std::size_t(of_joint_[std::size_t(p)]);
  const Vec3 here = residents_[std::size_t(place_[std::size_t(p)])].position;
  const double cutoff2 = cutoff_ * cutoff_;
  std::size_t kept = partners.size();
  for (int k = around_begin_[home]; k < around_begin_[home + 1]; ++k) {
    const std::size_t cell = std::size_t(around_[std::size_t(k)]);
    const std::size_t first = std::size_t(begin_[cell]), last = std::size_t(begin_[cell + 1]);
    // written before it is known whether it stays: few do, and branches would be guessed wrongly
    partners.resize(std::max(partners.size(), kept + (last - first)));
    for (std::size_t s = first; s < last; ++s) {
      const Resident& other = residents_[s];
      Vec3 d = other.position - here;
      if (box_) d = box_->minimum_image(d);
      partners[kept] = other.joint;
      kept += std::size_t((other.joint > p) & (d.squaredNorm() < cutoff2));
    }
  }
  partners.resize(kept);
}

}  // namespace ragdoll
