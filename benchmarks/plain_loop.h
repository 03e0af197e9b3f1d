// PlainLoop: the baseline R. Ragdoll physics written down plainly: objects for joints and bars in
// doubles, bars in random order, shuffled anew for each iteration, each error shared .5/.5.

#pragma once
#include <algorithm>  // shuffle
#include <cmath>      // sqrt, abs
#include <cstdint>
#include <limits>
#include <random>  // mt19937_64
#include <vector>

#include "network.h"        // Positions
#include "ragdoll/order.h"  // Order

namespace benchmark {

/// Which bars a visit corrects: every one, as the goals were set, or broken ones only.
enum class Corrects { every_bar, broken_bars };

/// When bars are shuffled: before each iteration but a break's first, as the method has it, or only
/// when the loop is made.
enum class Shuffles { each_iteration, once };

/// Random words for std::shuffle, as quick as they come: Steele, Lea and Flood's SplitMix.
class QuickWords {
 public:
  using result_type = std::uint64_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

  result_type operator()() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

 private:
  std::uint64_t state_ = 0;
};

/// The first order is drawn when the loop is made, later ones in the time. A pass that met no
/// broken bar tells that all are satisfied; where its own corrections may have broken one, a look
/// at all bars decides.
class PlainLoop {
 public:
  PlainLoop(const ragdoll::Framework& framework, ragdoll::Tolerance tolerance,
            std::int64_t max_iterations, Corrects corrects, Shuffles shuffles);

  /// Instead of the random order; stays if bars are shuffled only once.
  void set_order(const ragdoll::Order& order);

  void load(const Positions& x);
  void store(Positions& x) const;
  void move(int joint, const ragdoll::Vec3& by);

  /// @return whether every bar is within tolerance
  bool resolve() {
    const bool every = corrects_ == Corrects::every_bar;
    for (iterations_ = 0; iterations_ < max_iterations_; ++iterations_) {
      if (iterations_ > 0 && shuffles_ == Shuffles::each_iteration)
        std::shuffle(order_.begin(), order_.end(), words_);
      const bool broken = every ? pass<true>() : pass<false>();
      if (!broken && (!every || satisfied())) return true;
    }
    return false;
  }

  /// Passes that corrected something.
  std::int64_t iterations() const { return iterations_; }

 private:
  struct Joint {
    double x = 0, y = 0, z = 0;
  };
  struct Bar {
    Joint *p, *q;
    double length, slack;
  };

  static double distance(const Bar& bar) {
    const double dx = bar.q->x - bar.p->x, dy = bar.q->y - bar.p->y, dz = bar.q->z - bar.p->z;
    return std::sqrt(dx * dx + dy * dy + dz * dz);
  }

  /// @return whether the bar was broken
  template <bool every>
  static bool visit(const Bar& bar) {
    const double dx = bar.q->x - bar.p->x, dy = bar.q->y - bar.p->y, dz = bar.q->z - bar.p->z;
    const double d = std::sqrt(dx * dx + dy * dy + dz * dz);
    const double error = bar.length - d;
    const bool broken = std::abs(error) > bar.slack;
    if (!every && !broken) return false;
    const double share = 0.5 * error / d;
    bar.p->x -= share * dx;
    bar.p->y -= share * dy;
    bar.p->z -= share * dz;
    bar.q->x += share * dx;
    bar.q->y += share * dy;
    bar.q->z += share * dz;
    return broken;
  }

  template <bool every>
  bool pass() const {
    bool broken = false;
    for (const std::uint32_t bar : order_) broken |= visit<every>(bars_[bar]);
    return broken;
  }

  bool satisfied() const {
    for (const Bar& bar : bars_)
      if (std::abs(bar.length - distance(bar)) > bar.slack) return false;
    return true;
  }

  std::vector<Joint> joints_;
  std::vector<Bar> bars_;
  std::vector<std::uint32_t> order_;
  std::int64_t max_iterations_, iterations_ = 0;
  Corrects corrects_;
  Shuffles shuffles_;
  QuickWords words_;
};

inline PlainLoop::PlainLoop(const ragdoll::Framework& framework, ragdoll::Tolerance tolerance,
                            std::int64_t max_iterations, Corrects corrects, Shuffles shuffles)
    : joints_(std::size_t(framework.joint_count())),
      max_iterations_(max_iterations),
      corrects_(corrects),
      shuffles_(shuffles) {
  for (const ragdoll::Bar& bar : framework.bars())
    bars_.push_back({&joints_[std::size_t(bar.p)], &joints_[std::size_t(bar.q)], bar.length,
                     tolerance.slack(bar.length)});
  for (std::size_t k = 0; k < bars_.size(); ++k) order_.push_back(std::uint32_t(k));
  std::mt19937_64 random;
  std::shuffle(order_.begin(), order_.end(), random);
}

inline void PlainLoop::set_order(const ragdoll::Order& order) {
  for (std::size_t k = 0; k < order.size(); ++k) order_[k] = std::uint32_t(order[k].bar);
}

inline void PlainLoop::load(const Positions& x) {
  for (std::size_t j = 0; j < x.size(); ++j) joints_[j] = {x[j][0], x[j][1], x[j][2]};
}

inline void PlainLoop::store(Positions& x) const {
  for (std::size_t j = 0; j < x.size(); ++j) x[j] = {joints_[j].x, joints_[j].y, joints_[j].z};
}

inline void PlainLoop::move(int joint, const ragdoll::Vec3& by) {
  Joint& moved = joints_[std::size_t(joint)];
  moved.x += by[0];
  moved.y += by[1];
  moved.z += by[2];
}

}  // namespace benchmark
