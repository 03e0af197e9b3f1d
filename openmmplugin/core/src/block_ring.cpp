#include "block_ring.h"

#include <algorithm>  // min, max, find, swap
#include <cmath>      // abs, sqrt, isfinite

namespace ragdoll {
namespace {

constexpr int most_steps = 20;
constexpr double first_mu = 1e-6, least_mu = 1e-10;
constexpr double inside = 0.5;  ///< share of the tolerance that is aimed at

}  // namespace

BlockRing::BlockRing(std::size_t most_bars)
    : x_(most_bars + 1),
      trial_(most_bars + 1),
      chain_(most_bars),
      trial_chain_(most_bars),
      pivot_(most_bars),
      coupling_(most_bars),
      multiplier_(most_bars) {}

bool BlockRing::resolve(const CycleBlock& block, int entry, std::span<Vec3> y) {
  load(block, entry, y);
  hang_arms();
  if (!newton()) return false;
  if (moved_)
    for (std::size_t k = 1, at = first_; k < bars_; ++k) {
      if (++at == bars_) at = 0;
      y[std::size_t(block.ring[at])] = x_[k];
    }
  return true;
}

void BlockRing::load(const CycleBlock& block, int entry, std::span<const Vec3> y) {
  bars_ = block.bars.size();
  first_ = std::size_t(std::find(block.ring.begin(), block.ring.end(), entry) - block.ring.begin());
  std::size_t at = first_;
  for (std::size_t k = 0; k < bars_; ++k) {
    x_[k] = y[std::size_t(block.ring[at])];
    const CycleBlock::LocalBar& bar = block.local_bars[at];
    chain_[k].length = trial_chain_[k].length = bar.length;
    chain_[k].per_slack = trial_chain_[k].per_slack = bar.per_slack;
    if (++at == bars_) at = 0;
  }
  x_[bars_] = trial_[0] = trial_[bars_] = x_[0];
  moved_ = false;
}

inline void BlockRing::see(Link& link, const Vec3& from, const Vec3& to) const {
  const double x = to[0] - from[0], y = to[1] - from[1], z = to[2] - from[2];
  const double distance = std::sqrt(x * x + y * y + z * z);
  const double inverse = 1 / std::max(distance, 1e-300);
  link.unit = {x * inverse, y * inverse, z * inverse};
  link.error = distance - link.length;
}

/// 1/0. @return true if the far joint moved
inline bool BlockRing::hang(std::size_t bar, std::size_t near, std::size_t far) {
  Link& link = chain_[bar];
  see(link, x_[bar], x_[bar + 1]);
  if (std::abs(link.error) * link.per_slack <= 1) return false;
  x_[far] = x_[near] + (far > near ? link.length : -link.length) * link.unit;
  link.error = 0;
  return true;
}

void BlockRing::hang_arms() {
  visits += std::int64_t(bars_);
  std::size_t left = 0, right = bars_;
  while (true) {
    if (left + 1 == right) break;
    moved_ |= hang(left, left, left + 1);
    if (++left + 1 == right) break;
    moved_ |= hang(right - 1, right, right - 1);
    --right;
  }
  see(chain_[left], x_[left], x_[right]);
}

bool BlockRing::newton() {
  double most = 0, merit = 0;
  for (std::size_t k = 0; k < bars_; ++k) {
    most = std::max(most, std::abs(chain_[k].error) * chain_[k].per_slack);
    merit += chain_[k].error * chain_[k].error;
  }
  if (most <= 1 && !moved_) return true;
  // what the pre-pass takes for exact has to be looked at, too
  bool looked = false;
  double mu = first_mu;
  for (int step = 0; step < most_steps && (most > inside || !looked); ++step) {
    if (!std::isfinite(merit) || !solve(mu)) return false;
    visits += std::int64_t(bars_);
    for (std::size_t k = 1; k < bars_; ++k)
      trial_[k] =
          x_[k] + (multiplier_[k] * chain_[k].unit - multiplier_[k - 1] * chain_[k - 1].unit);
    double trial_most = 0, trial_merit = 0;
    for (std::size_t k = 0; k < bars_; ++k) {
      see(trial_chain_[k], trial_[k], trial_[k + 1]);
      const double error = trial_chain_[k].error;
      trial_most = std::max(trial_most, std::abs(error) * trial_chain_[k].per_slack);
      trial_merit += error * error;
    }
    if (!(trial_merit < merit) && (looked || most > 1)) {
      if (most <= 1) return true;
      mu = std::max(mu, 1e-6) * 30;
      continue;
    }
    std::swap(x_, trial_);
    std::swap(chain_, trial_chain_);
    most = trial_most;
    merit = trial_merit;
    looked = moved_ = true;
    mu = std::max(mu * 0.03, least_mu);
  }
  return most <= 1;
}

bool BlockRing::solve(double mu) {
  double* const d = pivot_.data();
  double* const c = coupling_.data();
  double* const y = multiplier_.data();
  const std::size_t n = bars_, half = n / 2;
  for (std::size_t k = 0; k < n; ++k) {
    d[k] = 2 + mu;
    y[k] = chain_[k].error;
  }
  for (std::size_t k = 0; k + 1 < n; ++k) c[k] = -chain_[k].unit.dot(chain_[k + 1].unit);
  d[0] = d[n - 1] = 1 + mu;
  // down from both ends to the bars half - 1 and half
  double least = std::min(d[0], d[n - 1]);
  d[0] = 1 / d[0];
  d[n - 1] = 1 / d[n - 1];
  for (std::size_t k = 1, r = n - 2; k < half || r >= half; ++k, --r) {
    if (k < half) {
      const double factor = c[k - 1] * d[k - 1];
      const double pivot = d[k] - factor * c[k - 1];
      least = std::min(least, pivot);
      y[k] -= factor * y[k - 1];
      d[k] = 1 / pivot;
    }
    if (r >= half) {
      const double factor = c[r] * d[r + 1];
      const double pivot = d[r] - factor * c[r];
      least = std::min(least, pivot);
      y[r] -= factor * y[r + 1];
      d[r] = 1 / pivot;
    }
  }
  const double factor = c[half - 1] * d[half - 1];
  const double pivot = 1 / d[half] - factor * c[half - 1];
  // also where one of them is no number
  if (!(least > 0 && pivot > 0)) return false;
  y[half] = (y[half] - factor * y[half - 1]) / pivot;
  y[half - 1] = (y[half - 1] - c[half - 1] * y[half]) * d[half - 1];
  for (std::size_t k = half - 1; k-- > 0;) y[k] = (y[k] - c[k] * y[k + 1]) * d[k];
  for (std::size_t k = half + 1; k < n; ++k) y[k] = (y[k] - c[k - 1] * y[k - 1]) * d[k];
  return true;
}

}  // namespace ragdoll
