#include "block_newton.h"

#include <algorithm>  // max, min, copy
#include <cmath>      // abs, sqrt, isfinite
#include <limits>     // infinity

namespace ragdoll {
namespace {

constexpr int most_dense_bars = 64;
constexpr int most_dense_width = 12;  ///< of the matrix' rows up to the diagonal, on average
constexpr int most_steps = 60;
constexpr int most_slow_steps = 8;  ///< that lower the sum of squares by less than 2 %
constexpr double least_mu = 1e-10, most_mu = 1e4;

}  // namespace

BlockNewton::BlockNewton(const CycleBlock& block, double tolerance)
    : block_(block),
      tolerance_(tolerance),
      // below 1e-13 rounding decides
      inside_(std::max(tolerance / 2, std::min(tolerance, 1e-13))),
      unit_(block.bars.size()),
      error_(Eigen::Index(block.bars.size())),
      multiplier_(Eigen::Index(block.bars.size())),
      trial_(block.joints.size()) {
  const int bars = int(block.bars.size());
  int entries = 0;
  for (int k = 0; k < bars; ++k) entries += k + 1 - block.first_coupled[std::size_t(k)];
  if (bars > most_dense_width && (bars > most_dense_bars || entries > bars * most_dense_width))
    analyse();
  else
    dense_.resize(block.bars.size() * block.bars.size());
}

double BlockNewton::worst(std::span<const Vec3> x) {
  double largest = 0;
  merit_ = 0;
  for (std::size_t k = 0; k < unit_.size(); ++k) {
    const auto& bar = block_.local_bars[k];
    const Vec3 d = x[std::size_t(bar.q)] - x[std::size_t(bar.p)];
    const double distance = d.norm();
    const double error = distance - bar.length;
    error_[Eigen::Index(k)] = error;
    merit_ += error * error;
    unit_[k] = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
    largest = std::max(largest, std::abs(error) / bar.length);
  }
  visits += std::int64_t(unit_.size());
  return std::isfinite(merit_) ? largest : std::numeric_limits<double>::infinity();
}

bool BlockNewton::resolve(std::span<Vec3> x, std::span<const std::uint8_t> pinned,
                          double first_mu) {
  double largest = worst(x);
  double mu = first_mu;
  int slow = 0;
  for (int step = 0; step < most_steps && largest > inside_ && std::isfinite(merit_); ++step) {
    if (!solve(pinned, mu)) {
      if ((mu *= 100) > most_mu) break;
      continue;
    }
    std::copy(x.begin(), x.end(), trial_.begin());
    for (std::size_t k = 0; k < unit_.size(); ++k) {
      const auto& bar = block_.local_bars[k];
      const Vec3 move = multiplier_[Eigen::Index(k)] * unit_[k];
      if (!pinned[std::size_t(bar.p)]) trial_[std::size_t(bar.p)] += move;
      if (!pinned[std::size_t(bar.q)]) trial_[std::size_t(bar.q)] -= move;
    }
    const double before = merit_;
    const double trial_largest = worst(trial_);
    if (!(merit_ < before)) {
      // back, and smaller; what rounding leaves is near enough
      largest = worst(x);
      visits -= std::int64_t(unit_.size());  // the bars were not looked at anew
      if (largest <= tolerance_ || (mu = std::max(mu, 1e-6) * 30) > most_mu) break;
      continue;
    }
    std::copy(trial_.begin(), trial_.end(), x.begin());
    largest = trial_largest;
    mu = std::max(mu * 0.03, least_mu);
    slow = merit_ > 0.98 * before ? slow + 1 : 0;
    if (slow == most_slow_steps) break;
  }
  return largest <= tolerance_;
}

bool BlockNewton::solve(std::span<const std::uint8_t> pinned, double mu) {
  if (!(sparse_ ? solve_sparse(pinned, mu) : solve_dense(pinned, mu))) return false;
  return multiplier_.allFinite();
}

/// Cholesky, in place in the lower triangle, each row from its first entry on.
bool BlockNewton::solve_dense(std::span<const std::uint8_t> pinned, double mu) {
  const std::size_t n = unit_.size();
  double* const a = dense_.data();
  double* const y = multiplier_.data();
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = std::size_t(block_.first_coupled[i]);
    std::fill(a + i * n + first, a + i * n + i, 0.0);
    a[i * n + i] = diagonal(i, pinned) + mu;
  }
  // two bars between one pair of joints do not exist: each entry has one coupling
  for (const auto& c : block_.couplings)
    a[std::size_t(c.row) * n + std::size_t(c.column)] = coupling(c, pinned);
  for (std::size_t i = 0; i < n; ++i) {
    double* const row = a + i * n;
    const auto first = std::size_t(block_.first_coupled[i]);
    double pivot = row[i], sum = error_[Eigen::Index(i)];
    for (std::size_t j = first; j < i; ++j) {
      const double* const other = a + j * n;
      double entry = row[j];
      for (std::size_t k = std::max(first, std::size_t(block_.first_coupled[j])); k < j; ++k)
        entry -= row[k] * other[k];
      row[j] = entry * other[j];  // the diagonal holds inverses
      pivot -= row[j] * row[j];
      sum -= row[j] * y[j];
    }
    if (!(pivot > 0)) return false;
    row[i] = 1 / std::sqrt(pivot);
    y[i] = sum * row[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    y[i] *= a[i * n + i];
    for (std::size_t k = std::size_t(block_.first_coupled[i]); k < i; ++k)
      y[k] -= a[i * n + k] * y[i];
  }
  return true;
}

void BlockNewton::analyse() {
  sparse_ = std::make_unique<SparseSystem>();
  std::vector<Eigen::Triplet<double>> entries;
  const int n = int(unit_.size());
  for (int k = 0; k < n; ++k) entries.emplace_back(k, k, 1.0);
  for (const auto& c : block_.couplings) entries.emplace_back(c.row, c.column, 1.0);
  Sparse& matrix = sparse_->matrix;
  matrix.resize(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  matrix.makeCompressed();
  // couplings are sorted as the matrix' columns are, each behind its diagonal
  for (int k = 0; k < n; ++k) sparse_->diagonal.push_back(matrix.outerIndexPtr()[k]);
  int place = 0, column = -1;
  for (const auto& c : block_.couplings) {
    if (c.column != column) place = matrix.outerIndexPtr()[column = c.column];
    sparse_->couplings.push_back(++place);
  }
  sparse_->solver.analyzePattern(matrix);
}

bool BlockNewton::solve_sparse(std::span<const std::uint8_t> pinned, double mu) {
  SparseSystem& s = *sparse_;
  double* const values = s.matrix.valuePtr();
  for (std::size_t k = 0; k < unit_.size(); ++k) values[s.diagonal[k]] = diagonal(k, pinned) + mu;
  for (std::size_t k = 0; k < s.couplings.size(); ++k)
    values[s.couplings[k]] = coupling(block_.couplings[k], pinned);
  s.solver.factorize(s.matrix);
  if (s.solver.info() != Eigen::Success) return false;
  multiplier_ = s.solver.solve(error_);
  return true;
}

}  // namespace ragdoll
