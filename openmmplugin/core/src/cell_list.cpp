#include "ragdoll/cell_list.h"

#include <algorithm>  // clamp, find, max, min
#include <array>
#include <bit>     // bit_ceil
#include <cmath>   // abs, floor
#include <limits>  // quiet_NaN

#include "contact_kernels.h"  // find_near

namespace ragdoll {
namespace {

/// So much wider than the cutoff are cells, relative to it, that rounding never puts two joints
/// that are nearer than the cutoff two cells apart.
constexpr double wider = 1e-3;

/// Farther out, in cells, all joints are put into the last cell.
constexpr double last_cell = 1e12;

/// Farther out, in cells or boxes, places within a cell are not told apart.
constexpr double far_out = 1e8;

/// What distances in single precision within and between neighbouring cells may be wrong by,
/// relative to the width of a cell.
constexpr double rounding = 1e-5;

/// Distance between the two faces of the box that are spanned by the other two vectors.
double height(const Vec3& along, const Vec3& u, const Vec3& v) {
  const Vec3 normal = u.cross(v).normalized();
  return std::abs(along.dot(normal));
}

std::int64_t wrap(std::int64_t cell, std::int64_t count) {
  const std::int64_t rest = cell % count;
  return rest < 0 ? rest + count : rest;
}

std::int64_t whole(double widths) {
  return std::int64_t(std::floor(std::clamp(widths, -last_cell, last_cell)));
}

}  // namespace

CellList::CellList(std::span<const Vec3> positions, double cutoff, const Box* box)
    : positions_(positions), cutoff_(cutoff), width_(cutoff * (1 + wider)), box_(box) {
  if (box) {
    const auto count = [this](double edge) {
      return std::max<std::int64_t>(1, whole(edge / width_));
    };
    count_[0] = count(height(box->a, box->b, box->c));
    count_[1] = count(height(box->b, box->a, box->c));
    count_[2] = count(height(box->c, box->a, box->b));
    edges_[0] = box->a / double(count_[0]);
    edges_[1] = box->b / double(count_[1]);
    edges_[2] = box->c / double(count_[2]);
  } else {
    for (int i = 0; i < 3; ++i) edges_[i] = width_ * Vec3::Unit(i);
  }
  // number the cells
  const std::size_t n = positions.size();
  mask_ = std::bit_ceil(2 * n + 1) - 1;
  slots_.assign(mask_ + 1, -1);
  std::vector<int> of_joint(n);
  std::vector<Vec3> from_centre(n);
  for (std::size_t j = 0; j < n; ++j) {
    const Cell cell = cell_at(positions[j], from_centre[j]);
    int& index = slots_[slot_of(cell)];
    if (index < 0) {
      index = int(cells_.size());
      cells_.push_back(cell);
    }
    of_joint[j] = index;
  }

  // counting sort by cell
  begin_.assign(cells_.size() + 1, 0);
  for (const int cell : of_joint) ++begin_[std::size_t(cell) + 1];
  for (std::size_t c = 0; c < cells_.size(); ++c) begin_[c + 1] += begin_[c];
  joints_.resize(n);
  for (std::vector<float>* one : {&x_, &y_, &z_}) one->assign(n + contact_kernels::padding, 0);
  std::vector<int> cursor(begin_.begin(), begin_.end() - 1);
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t place = std::size_t(cursor[std::size_t(of_joint[j])]++);
    joints_[place] = int(j);
    x_[place] = float(from_centre[j][0]);
    y_[place] = float(from_centre[j][1]);
    z_[place] = float(from_centre[j][2]);
  }
}

/// The cell of a position, and where it is in it; not a number where rounding leaves that open.
CellList::Cell CellList::cell_at(const Vec3& position, Vec3& from_centre) const {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  if (!box_) {
    const Vec3 widths = position / width_;
    const Cell cell = {whole(widths[0]), whole(widths[1]), whole(widths[2])};
    from_centre =
        position - width_ * Vec3(double(cell.x) + 0.5, double(cell.y) + 0.5, double(cell.z) + 0.5);
    if (!(widths.cwiseAbs().maxCoeff() < far_out)) from_centre[0] = unknown;
    return cell;
  }
  // the reduced form is lower triangular: solve from the last coordinate
  Vec3 fraction;
  fraction[2] = position[2] / box_->c[2];
  fraction[1] = (position[1] - fraction[2] * box_->c[1]) / box_->b[1];
  fraction[0] = (position[0] - fraction[2] * box_->c[0] - fraction[1] * box_->b[0]) / box_->a[0];
  std::int64_t cell[3];
  from_centre.setZero();
  for (int i = 0; i < 3; ++i) {
    const double rest = fraction[i] - std::floor(fraction[i]);
    // a little below 0 is rounded to 1
    const double widths = rest < 1 ? rest * double(count_[i]) : 0;
    cell[i] = std::min(whole(widths), count_[i] - 1);
    from_centre += (widths - double(cell[i]) - 0.5) * edges_[i];
  }
  if (!(fraction.cwiseAbs().maxCoeff() < far_out)) from_centre[0] = unknown;
  return {cell[0], cell[1], cell[2]};
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

/// Whether some cells around a cell are the same.
bool CellList::small_box() const {
  return box_ && *std::min_element(count_, count_ + 3) < 3;
}

void CellList::find_candidates(std::size_t cell, std::vector<CellPair>& pairs) const {
  if (small_box()) {
    find_in_small_box(cell, pairs);
    return;
  }
  const Cell& home = cells_[cell];
  // half of the 26 cells around it; it is around the others
  std::array<contact_kernels::Neighbours, 13> around;
  std::size_t count = 0;
  for (int half = 14; half < 27; ++half) {
    const int dx = half / 9 - 1, dy = half / 3 % 3 - 1, dz = half % 3 - 1;
    Cell other = {home.x + dx, home.y + dy, home.z + dz};
    if (box_)
      other = {wrap(other.x, count_[0]), wrap(other.y, count_[1]), wrap(other.z, count_[2])};
    const int index = index_of(other);
    if (index < 0) continue;
    const Vec3 shift = dx * edges_[0] + dy * edges_[1] + dz * edges_[2];
    around[count++] = {begin_[std::size_t(index)],
                       begin_[std::size_t(index) + 1],
                       {float(shift[0]), float(shift[1]), float(shift[2])}};
  }
  contact_kernels::find_near({joints_.data(), x_.data(), y_.data(), z_.data()}, begin_[cell],
                             begin_[cell + 1], {around.data(), count}, float(cutoff_),
                             float(rounding * width_), pairs);
}

void CellList::find_in_small_box(std::size_t cell, std::vector<CellPair>& pairs) const {
  const Cell& home = cells_[cell];
  std::vector<int> around;
  for (int k = 0; k < 27; ++k) {
    const int index =
        index_of({wrap(home.x + k / 9 - 1, count_[0]), wrap(home.y + k / 3 % 3 - 1, count_[1]),
                  wrap(home.z + k % 3 - 1, count_[2])});
    if (index >= int(cell) && std::find(around.begin(), around.end(), index) == around.end())
      around.push_back(index);
  }
  for (const int other : around)
    for (int i = begin_[cell]; i < begin_[cell + 1]; ++i)
      for (int k = other == int(cell) ? i + 1 : begin_[std::size_t(other)];
           k < begin_[std::size_t(other) + 1]; ++k) {
        const int p = joints_[std::size_t(i)], q = joints_[std::size_t(k)];
        const Vec3 d = positions_[std::size_t(q)] - positions_[std::size_t(p)];
        const double distance = box_->minimum_image(d).norm();
        if (distance < cutoff_)
          pairs.push_back({std::min(p, q), std::max(p, q), float(distance * (1 - 1e-6))});
      }
}

}  // namespace ragdoll
