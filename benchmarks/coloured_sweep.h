// ColouredSweep: the baseline of position-based dynamics. Bars coloured greedily, each with the
// first colour that neither joint has yet; resolved colour by colour, each error shared .5/.5.

#pragma once
#include <algorithm>  // find
#include <cmath>      // sqrt, abs
#include <cstdint>
#include <vector>

#include "network.h"            // Positions
#include "ragdoll/tolerance.h"  // Tolerance

namespace benchmark {

/// Bars of a colour share no joint: the processor may overlap their roots and divisions.
class ColouredSweep {
 public:
  ColouredSweep(const ragdoll::Framework& framework, ragdoll::Tolerance tolerance,
                std::int64_t max_iterations)
      : x_(std::size_t(framework.joint_count())), max_iterations_(max_iterations) {
    std::vector<std::vector<std::size_t>> taken(x_.size());  // colours of a joint's bars
    const auto has = [&](int joint, std::size_t colour) {
      const std::vector<std::size_t>& colours = taken[std::size_t(joint)];
      return std::find(colours.begin(), colours.end(), colour) != colours.end();
    };
    std::vector<std::vector<Bar>> by_colour;
    for (const ragdoll::Bar& bar : framework.bars()) {
      std::size_t colour = 0;
      while (has(bar.p, colour) || has(bar.q, colour)) ++colour;
      taken[std::size_t(bar.p)].push_back(colour);
      taken[std::size_t(bar.q)].push_back(colour);
      if (colour == by_colour.size()) by_colour.emplace_back();
      by_colour[colour].push_back({bar.p, bar.q, bar.length, tolerance.slack(bar.length)});
    }
    for (const std::vector<Bar>& bars : by_colour)
      bars_.insert(bars_.end(), bars.begin(), bars.end());
  }

  void load(const Positions& x) { x_ = x; }
  void store(Positions& x) const { x = x_; }

  /// Every bar is corrected on every visit. A pass that met no broken bar is looked at once more,
  /// because its own corrections may have broken one.
  /// @return whether every bar is within tolerance
  bool resolve() {
    for (iterations_ = 0; iterations_ < max_iterations_; ++iterations_)
      if (!pass() && satisfied()) return true;
    return false;
  }

  std::int64_t iterations() const { return iterations_; }

 private:
  struct Bar {
    int p, q;
    double length, slack;
  };

  /// @return whether a bar was broken
  bool pass() {
    bool broken = false;
    for (const Bar& bar : bars_) {
      ragdoll::Vec3 &p = x_[std::size_t(bar.p)], &q = x_[std::size_t(bar.q)];
      const ragdoll::Vec3 along = q - p;
      const double d = std::sqrt(along.squaredNorm());
      const double error = bar.length - d;
      broken |= std::abs(error) > bar.slack;
      const ragdoll::Vec3 correction = (0.5 * error / d) * along;
      p -= correction;
      q += correction;
    }
    return broken;
  }

  bool satisfied() const {
    for (const Bar& bar : bars_) {
      const double d = (x_[std::size_t(bar.q)] - x_[std::size_t(bar.p)]).norm();
      if (std::abs(bar.length - d) > bar.slack) return false;
    }
    return true;
  }

  Positions x_;
  std::vector<Bar> bars_;
  std::int64_t max_iterations_, iterations_ = 0;
};

}  // namespace benchmark
