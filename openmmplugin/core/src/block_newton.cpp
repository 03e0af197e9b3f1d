#include "block_newton.h"

#include <algorithm>  // max, copy, fill, swap
#include <cmath>      // abs, isfinite
#include <limits>     // infinity

namespace ragdoll {
namespace {

constexpr int most_steps = 60;
constexpr int most_slow_steps = 8;  ///< that lower the sum of squares by less than 2 %
constexpr double least_mu = 1e-10, most_mu = 1e4;
constexpr double inside = 0.5;  ///< share of the tolerance that is aimed at
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

BlockNewton::BlockNewton(const BlockTree& tree)
    : tree_(tree),
      eliminations_(std::size_t(tree.block_count())),
      sparse_(std::size_t(tree.block_count())),
      looks_(tree.most_bars),
      trial_looks_(tree.most_bars),
      multiplier_(tree.most_bars),
      trial_(tree.most_joints) {
  // rings are mostly done without
  for (int index = 0; index < tree.block_count(); ++index) {
    const CycleBlock block = tree.block(index);
    if (block.ring.empty() && BlockElimination::suits(block))
      eliminations_[std::size_t(index)] = std::make_unique<BlockElimination>(block);
  }
}

void BlockNewton::enter(int index) {
  index_ = index;
  block_ = tree_.block(index);
}

double BlockNewton::look(std::span<const Vec3> x) {
  visits += std::int64_t(block_.bars.size());
  return look(x, looks_);
}

double BlockNewton::look(std::span<const Vec3> x, std::vector<Look>& looks) {
  double most = 0, sum = 0;
  for (std::size_t k = 0; k < block_.local_bars.size(); ++k) {
    const auto& bar = block_.local_bars[k];
    const double violation = see(looks[k], bar, x[std::size_t(bar.p)], x[std::size_t(bar.q)]);
    most = std::max(most, violation);
    sum += violation;
  }
  // a maximum does not tell of what is no number
  return std::isfinite(sum) ? most : infinity;
}

double BlockNewton::merit_of(const std::vector<Look>& looks) const {
  double sum = 0;
  for (std::size_t k = 0; k < block_.bars.size(); ++k) sum += looks[k].error * looks[k].error;
  return sum;
}

double BlockNewton::largest() const {
  double most = 0;
  for (std::size_t k = 0; k < block_.bars.size(); ++k) most = std::max(most, share(k));
  return most;
}

bool BlockNewton::resolve(std::span<Vec3> x, std::span<const std::uint8_t> pinned,
                          double first_mu) {
  double most = largest(), merit = merit_of(looks_);
  double mu = first_mu;
  int slow = 0;
  for (int step = 0; step < most_steps && most > inside && std::isfinite(merit); ++step) {
    if (!solve(pinned, mu)) {
      if ((mu *= 100) > most_mu) break;
      continue;
    }
    std::copy(x.begin(), x.end(), trial_.begin());
    for (std::size_t k = 0; k < block_.local_bars.size(); ++k) {
      const auto& bar = block_.local_bars[k];
      const Vec3 move = multiplier_[k] * looks_[k].unit;
      if (!pinned[std::size_t(bar.p)]) trial_[std::size_t(bar.p)] += move;
      if (!pinned[std::size_t(bar.q)]) trial_[std::size_t(bar.q)] -= move;
    }
    visits += std::int64_t(block_.bars.size());
    const double trial_most = look({trial_.data(), x.size()}, trial_looks_);
    const double trial_merit = merit_of(trial_looks_);
    if (!(trial_merit < merit)) {
      // stays, and goes on smaller; what rounding leaves is near enough
      if (most <= 1 || (mu = std::max(mu, 1e-6) * 30) > most_mu) break;
      continue;
    }
    std::copy_n(trial_.begin(), x.size(), x.begin());
    std::swap(looks_, trial_looks_);
    most = trial_most;
    mu = std::max(mu * 0.03, least_mu);
    slow = trial_merit > 0.98 * merit ? slow + 1 : 0;
    merit = trial_merit;
    if (slow == most_slow_steps) break;
  }
  return most <= 1;
}

bool BlockNewton::solve(std::span<const std::uint8_t> pinned, double mu) {
  std::unique_ptr<BlockElimination>& elimination = eliminations_[std::size_t(index_)];
  std::unique_ptr<SparseSystem>& system = sparse_[std::size_t(index_)];
  if (!elimination && !system) {
    if (BlockElimination::suits(block_)) {
      elimination = std::make_unique<BlockElimination>(block_);
    } else {
      system = std::make_unique<SparseSystem>();
      analyse(*system);
    }
  }
  if (!(elimination ? eliminate(*elimination, pinned, mu) : solve_sparse(*system, pinned, mu)))
    return false;
  double sum = 0;
  for (std::size_t k = 0; k < block_.bars.size(); ++k) sum += multiplier_[k];
  return std::isfinite(sum);
}

bool BlockNewton::eliminate(BlockElimination& elimination, std::span<const std::uint8_t> pinned,
                            double mu) {
  return elimination.solve(
      mu, [&](std::size_t bar) { return diagonal(bar, pinned); },
      [&](std::size_t k) { return coupling(block_.couplings[k], pinned); },
      [&](std::size_t bar) { return looks_[bar].error; }, multiplier_.data());
}

void BlockNewton::analyse(SparseSystem& system) const {
  std::vector<Eigen::Triplet<double>> entries;
  const int n = int(block_.bars.size());
  for (int k = 0; k < n; ++k) entries.emplace_back(k, k, 1.0);
  for (const auto& c : block_.couplings) entries.emplace_back(c.row, c.column, 1.0);
  Sparse& matrix = system.matrix;
  matrix.resize(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  matrix.makeCompressed();
  // couplings are sorted as the matrix' columns are, each behind its diagonal
  for (int k = 0; k < n; ++k) system.diagonal.push_back(matrix.outerIndexPtr()[k]);
  int place = 0, column = -1;
  for (const auto& c : block_.couplings) {
    if (c.column != column) place = matrix.outerIndexPtr()[column = c.column];
    system.couplings.push_back(++place);
  }
  system.solver.analyzePattern(matrix);
  system.right.resize(n);
}

bool BlockNewton::solve_sparse(SparseSystem& s, std::span<const std::uint8_t> pinned, double mu) {
  const std::size_t n = block_.bars.size();
  double* const values = s.matrix.valuePtr();
  for (std::size_t k = 0; k < n; ++k) values[s.diagonal[k]] = diagonal(k, pinned) + mu;
  for (std::size_t k = 0; k < s.couplings.size(); ++k)
    values[s.couplings[k]] = coupling(block_.couplings[k], pinned);
  s.solver.factorize(s.matrix);
  if (s.solver.info() != Eigen::Success) return false;
  for (std::size_t k = 0; k < n; ++k) s.right[Eigen::Index(k)] = looks_[k].error;
  s.solution = s.solver.solve(s.right);
  std::copy_n(s.solution.data(), n, multiplier_.data());
  return true;
}

}  // namespace ragdoll
