#include "newton_factor.h"

#include <algorithm>  // sort, unique, lower_bound, fill
#include <cmath>      // isfinite
#include <numeric>    // partial_sum

#include <Eigen/OrderingMethods>  // AMDOrdering
#include <Eigen/SparseCore>       // SparseMatrix

namespace ragdoll {
namespace {

constexpr Block3 zero = {};

/// c -= a b
inline void subtract_product(Block3& c, const Block3& a, const Block3& b) {
  for (std::size_t col = 0; col < 9; col += 3)
    for (std::size_t row = 0; row < 3; ++row)
      c[col + row] -= a[row] * b[col] + a[3 + row] * b[col + 1] + a[6 + row] * b[col + 2];
}

/// a^T b
inline Block3 transposed_product(const Block3& a, const Block3& b) {
  Block3 c;
  for (std::size_t col = 0; col < 3; ++col)
    for (std::size_t row = 0; row < 3; ++row)
      c[3 * col + row] = a[3 * row] * b[3 * col] + a[3 * row + 1] * b[3 * col + 1] +
                         a[3 * row + 2] * b[3 * col + 2];
  return c;
}

/// c += factor * a b^T
inline void add_outer(Block3& c, const Vec3& a, const Vec3& b, double factor) {
  for (int col = 0; col < 3; ++col)
    for (int row = 0; row < 3; ++row) c[std::size_t(3 * col + row)] += factor * a[row] * b[col];
}

/// Of a symmetric positive block. @return false if it is not positive
bool invert(const Block3& a, Block3& inverse) {
  const double c00 = a[4] * a[8] - a[5] * a[5];
  const double c01 = a[2] * a[5] - a[1] * a[8];
  const double c02 = a[1] * a[5] - a[2] * a[4];
  const double determinant = a[0] * c00 + a[1] * c01 + a[2] * c02;
  if (!(a[0] > 0) || !(determinant > 0) || !std::isfinite(determinant)) return false;
  const double r = 1 / determinant;
  if (!std::isfinite(r)) return false;
  const double c11 = a[0] * a[8] - a[2] * a[2];
  const double c12 = a[1] * a[2] - a[0] * a[5];
  const double c22 = a[0] * a[4] - a[1] * a[1];
  inverse = {c00 * r, c01 * r, c02 * r, c01 * r, c11 * r, c12 * r, c02 * r, c12 * r, c22 * r};
  return true;
}

Eigen::Map<const Eigen::Matrix3d> matrix(const Block3& block) {
  return Eigen::Map<const Eigen::Matrix3d>(block.data());
}

}  // namespace

BlockFactor::BlockFactor(int joint_count, const std::vector<std::pair<int, int>>& pairs)
    : n_(joint_count) {
  order(joint_count, pairs);
  std::vector<std::pair<int, int>> sorted;  // column, row
  sorted.reserve(pairs.size());
  for (const auto& [p, q] : pairs) {
    const auto [row, column] = std::minmax(rank_[std::size_t(p)], rank_[std::size_t(q)]);
    sorted.emplace_back(column, row);
  }
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  const std::size_t n = std::size_t(n_);
  column_begin_.assign(n + 1, 0);
  row_.reserve(sorted.size());
  for (const auto& [column, row] : sorted) {
    ++column_begin_[std::size_t(column) + 1];
    row_.push_back(row);
  }
  std::partial_sum(column_begin_.begin(), column_begin_.end(), column_begin_.begin());
  block_.assign(row_.size(), zero);
  diagonal_.assign(n, zero);
  extra_begin_.assign(n + 1, 0);
  parent_.resize(n);
  lower_begin_.resize(n + 1);
  lower_end_.resize(n);
  inverse_.resize(n);
  work_.assign(n, zero);
  pattern_.resize(n);
  stack_.resize(n);
  mark_.resize(n);
  analyse();
}

void BlockFactor::order(int joint_count, const std::vector<std::pair<int, int>>& pairs) {
  using Pattern = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * pairs.size());
  for (const auto& [p, q] : pairs) {
    entries.emplace_back(p, q, 1.0);
    entries.emplace_back(q, p, 1.0);
  }
  Pattern pattern(joint_count, joint_count);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  rank_.resize(std::size_t(n_));
  joint_.resize(std::size_t(n_));
  for (int k = 0; k < n_; ++k) {
    joint_[std::size_t(k)] = permutation.indices()[k];
    rank_[std::size_t(permutation.indices()[k])] = k;
  }
}

void BlockFactor::set_extra_pairs(std::span<const std::pair<int, int>> pairs) {
  if (pairs.empty() && extra_row_.empty()) return;
  const std::size_t n = std::size_t(n_);
  extra_begin_.assign(n + 1, 0);
  for (const auto& [p, q] : pairs)
    ++extra_begin_[std::size_t(std::max(rank_[std::size_t(p)], rank_[std::size_t(q)])) + 1];
  std::partial_sum(extra_begin_.begin(), extra_begin_.end(), extra_begin_.begin());
  std::vector<int> next(extra_begin_.begin(), extra_begin_.end() - 1);
  extra_row_.resize(pairs.size());
  extra_place_.resize(pairs.size());
  extra_turned_.resize(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const int p = rank_[std::size_t(pairs[k].first)], q = rank_[std::size_t(pairs[k].second)];
    const int place = next[std::size_t(std::max(p, q))]++;
    extra_place_[k] = place;
    extra_row_[std::size_t(place)] = std::min(p, q);
    extra_turned_[k] = p > q;
  }
  extra_block_.assign(pairs.size(), zero);
  analyse();
}

template <class Visit>
void BlockFactor::each_row_of(int column, Visit visit) const {
  const std::size_t k = std::size_t(column);
  for (int e = column_begin_[k]; e < column_begin_[k + 1]; ++e)
    visit(row_[std::size_t(e)], block_[std::size_t(e)]);
  for (int e = extra_begin_[k]; e < extra_begin_[k + 1]; ++e)
    visit(extra_row_[std::size_t(e)], extra_block_[std::size_t(e)]);
}

/// Elimination tree and the sizes of the factor's columns.
void BlockFactor::analyse() {
  std::vector<std::size_t> count(std::size_t(n_), 0);
  for (int k = 0; k < n_; ++k) {
    parent_[std::size_t(k)] = -1;
    mark_[std::size_t(k)] = k;
    each_row_of(k, [&](int i, const Block3&) {
      for (; mark_[std::size_t(i)] != k; i = parent_[std::size_t(i)]) {
        if (parent_[std::size_t(i)] < 0) parent_[std::size_t(i)] = k;
        ++count[std::size_t(i)];
        mark_[std::size_t(i)] = k;
      }
    });
  }
  lower_begin_[0] = 0;
  std::partial_sum(count.begin(), count.end(), lower_begin_.begin() + 1);
  lower_row_.resize(lower_begin_.back());
  lower_.resize(lower_begin_.back());
}

void BlockFactor::clear() {
  std::fill(block_.begin(), block_.end(), zero);
  std::fill(diagonal_.begin(), diagonal_.end(), zero);
  std::fill(extra_block_.begin(), extra_block_.end(), zero);
}

int BlockFactor::place_of(int p, int q) const {
  const auto [row, column] = std::minmax(rank_[std::size_t(p)], rank_[std::size_t(q)]);
  const auto begin = row_.begin() + column_begin_[std::size_t(column)];
  const auto end = row_.begin() + column_begin_[std::size_t(column) + 1];
  return int(std::lower_bound(begin, end, row) - row_.begin());
}

void BlockFactor::add(int place, int p, int q, const Vec3& a, const Vec3& b, double factor) {
  const bool turned = rank_[std::size_t(p)] > rank_[std::size_t(q)];
  add_outer(block_[std::size_t(place)], turned ? b : a, turned ? a : b, factor);
}

void BlockFactor::add_extra(std::size_t pair, const Vec3& a, const Vec3& b, double factor) {
  const bool turned = extra_turned_[pair] != 0;
  add_outer(extra_block_[std::size_t(extra_place_[pair])], turned ? b : a, turned ? a : b, factor);
}

void BlockFactor::add_spring(int place, const Vec3& u, double turn) {
  Block3& block = block_[std::size_t(place)];
  add_outer(block, u, u, turn - 1);
  for (std::size_t e = 0; e < 9; e += 4) block[e] -= turn;
}

void BlockFactor::add_diagonal(int joint, const Vec3& u, double turn) {
  Block3& block = diagonal_[std::size_t(rank_[std::size_t(joint)])];
  add_outer(block, u, u, 1 - turn);
  for (std::size_t e = 0; e < 9; e += 4) block[e] += turn;
}

bool BlockFactor::factor(double shift) {
  std::copy(lower_begin_.begin(), lower_begin_.end() - 1, lower_end_.begin());
  std::fill(mark_.begin(), mark_.end(), -1);
  for (int k = 0; k < n_; ++k)
    if (!factor_column(k, shift)) {
      std::fill(work_.begin(), work_.end(), zero);
      return false;
    }
  return true;
}

/// Row k of the factor: the columns left of k that reach it are walked up the elimination tree.
bool BlockFactor::factor_column(int k, double shift) {
  std::size_t top = std::size_t(n_);
  mark_[std::size_t(k)] = k;
  each_row_of(k, [&](int i, const Block3& block) {
    Block3& y = work_[std::size_t(i)];
    for (std::size_t e = 0; e < 9; ++e) y[e] += block[e];
    std::size_t length = 0;
    for (; mark_[std::size_t(i)] != k; i = parent_[std::size_t(i)]) {
      stack_[length++] = i;
      mark_[std::size_t(i)] = k;
    }
    while (length > 0) pattern_[--top] = stack_[--length];
  });
  Block3 d = diagonal_[std::size_t(k)];
  d[0] += shift;
  d[4] += shift;
  d[8] += shift;
  for (; top < std::size_t(n_); ++top) {
    const std::size_t i = std::size_t(pattern_[top]);
    const Block3 y = work_[i];
    work_[i] = zero;
    std::size_t& end = lower_end_[i];
    for (std::size_t e = lower_begin_[i]; e < end; ++e)
      subtract_product(work_[std::size_t(lower_row_[e])], lower_[e], y);
    const Block3 l = transposed_product(y, inverse_[i]);
    subtract_product(d, l, y);
    lower_row_[end] = k;
    lower_[end] = l;
    ++end;
  }
  return invert(d, inverse_[std::size_t(k)]);
}

void BlockFactor::solve(std::span<Vec3> x) const {
  std::vector<Vec3> y(x.size());
  const std::size_t n = std::size_t(n_);
  for (std::size_t k = 0; k < n; ++k) y[k] = x[std::size_t(joint_[k])];
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t e = lower_begin_[k]; e < lower_begin_[k + 1]; ++e)
      y[std::size_t(lower_row_[e])] -= matrix(lower_[e]) * y[k];
  for (std::size_t k = n; k-- > 0;) {
    Vec3 sum = matrix(inverse_[k]) * y[k];
    for (std::size_t e = lower_begin_[k]; e < lower_begin_[k + 1]; ++e)
      sum -= matrix(lower_[e]).transpose() * y[std::size_t(lower_row_[e])];
    y[k] = sum;
  }
  for (std::size_t k = 0; k < n; ++k) x[std::size_t(joint_[k])] = y[k];
}

}  // namespace ragdoll
