// Naive sweep: break, resolve, iterate in plain loops, written from the specification alone, to
// hold the ordered resolver against. One component; deterministic orders.

#pragma once
#include <cmath>  // sqrt, abs
#include <string>
#include <vector>

#include "examples.h"           // Structure
#include "ragdoll/order.h"      // OrderKind
#include "ragdoll/weighting.h"  // Weighting

namespace ragdoll::examples {

struct NaiveSweep {
  std::vector<Bar> bars;
  std::vector<double> x, y, z;
  double tol = 1e-3;
  Weighting weighting;
  long max_iterations = 300;

  struct Step {
    int bar, near, far;
    bool problem;
  };
  int last_problem = -1;

  NaiveSweep(const Structure& structure, const Positions& start) : bars(structure.parts.bars) {
    for (const Vec3& point : start) {
      x.push_back(point[0]);
      y.push_back(point[1]);
      z.push_back(point[2]);
    }
  }

  double distance(int p, int q) const {
    const std::size_t i = std::size_t(p), j = std::size_t(q);
    const double dx = x[j] - x[i], dy = y[j] - y[i], dz = z[j] - z[i];
    return std::sqrt(dx * dx + dy * dy + dz * dz);
  }

  bool broken() const {
    for (const Bar& bar : bars)
      if (std::abs(distance(bar.p, bar.q) - bar.length) > tol * bar.length) return true;
    return false;
  }

  /// Breadth first: the queue and the tree first, then the bars of each joint in its turn; a bar
  /// that is not of the tree comes with the later of its ends.
  std::vector<Step> breadth_first(std::vector<int> queue, int first_bar) const {
    std::vector<int> depth(x.size(), -1), place(x.size(), -1);
    std::vector<bool> tree(bars.size(), false);
    for (const int joint : queue) depth[std::size_t(joint)] = 0;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const int joint = queue[head];
      place[std::size_t(joint)] = int(head);
      for (std::size_t k = 0; k < bars.size(); ++k) {
        if (bars[k].p != joint && bars[k].q != joint) continue;
        const int other = bars[k].p == joint ? bars[k].q : bars[k].p;
        if (depth[std::size_t(other)] >= 0) continue;
        depth[std::size_t(other)] = depth[std::size_t(joint)] + 1;
        tree[k] = true;
        queue.push_back(other);
      }
    }
    std::vector<Step> steps;
    if (first_bar >= 0) {
      const Bar& bar = bars[std::size_t(first_bar)];
      steps.push_back({first_bar, bar.p, bar.q, true});
    }
    for (const int joint : queue)
      for (std::size_t k = 0; k < bars.size(); ++k) {
        if (int(k) == first_bar || (bars[k].p != joint && bars[k].q != joint)) continue;
        const int other = bars[k].p == joint ? bars[k].q : bars[k].p;
        if (tree[k] && place[std::size_t(other)] > place[std::size_t(joint)])
          steps.push_back({int(k), joint, other, false});
        else if (!tree[k] && place[std::size_t(other)] < place[std::size_t(joint)])
          steps.push_back(problem_step(int(k), depth));
      }
    return steps;
  }

  Step problem_step(int k, const std::vector<int>& depth) const {
    const Bar& bar = bars[std::size_t(k)];
    if (depth[std::size_t(bar.q)] < depth[std::size_t(bar.p)]) return {k, bar.q, bar.p, true};
    return {k, bar.p, bar.q, true};
  }

  void depth_first(int joint, std::vector<int>& depth, std::vector<bool>& used,
                   std::vector<Step>& steps) const {
    for (std::size_t k = 0; k < bars.size(); ++k) {
      if (used[k] || (bars[k].p != joint && bars[k].q != joint)) continue;
      used[k] = true;
      const int other = bars[k].p == joint ? bars[k].q : bars[k].p;
      if (depth[std::size_t(other)] >= 0) {
        steps.push_back(problem_step(int(k), depth));
      } else {
        depth[std::size_t(other)] = depth[std::size_t(joint)] + 1;
        steps.push_back({int(k), joint, other, false});
        depth_first(other, depth, used, steps);
      }
    }
  }

  std::vector<Step> order(OrderKind kind, int root) const {
    std::vector<Step> steps;
    const std::string name = name_of(kind);
    if (name.starts_with("dfs")) {
      std::vector<int> depth(x.size(), -1);
      std::vector<bool> used(bars.size(), false);
      depth[std::size_t(root)] = 0;
      depth_first(root, depth, used, steps);
    } else {
      steps = breadth_first({root}, -1);
    }
    if (name.ends_with("reverse"))
      for (std::size_t k = steps.size(); k-- > 0;) steps.push_back(steps[k]);
    return steps;
  }

  void pass(const std::vector<Step>& steps) {
    last_problem = -1;
    for (const Step& step : steps) {
      const double length = bars[std::size_t(step.bar)].length;
      const double d = distance(step.near, step.far), error = length - d;
      if (std::abs(error) <= tol * length) continue;
      if (step.problem) last_problem = step.bar;
      const double w_near = step.problem ? 0.5 : weighting.near;
      const double w_far = step.problem ? 0.5 : weighting.far;
      const std::size_t p = std::size_t(step.near), q = std::size_t(step.far);
      const double ux = (x[q] - x[p]) / d, uy = (y[q] - y[p]) / d, uz = (z[q] - z[p]) / d;
      x[p] -= w_near * error * ux;
      y[p] -= w_near * error * uy;
      z[p] -= w_near * error * uz;
      x[q] += w_far * error * ux;
      y[q] += w_far * error * uy;
      z[q] += w_far * error * uz;
    }
  }

  struct Count {
    long iterations = 0, visits = 0;
    bool converged = false;
  };

  Count run(OrderKind kind, int root) {
    std::vector<Step> steps = order(kind, root);
    Count count;
    while (broken() && count.iterations < max_iterations) {
      if (kind == OrderKind::bfs_adapt && count.iterations > 0 && last_problem >= 0) {
        const Bar& bar = bars[std::size_t(last_problem)];
        steps = breadth_first({bar.p, bar.q}, last_problem);
      }
      pass(steps);
      ++count.iterations;
      count.visits += long(steps.size());
    }
    count.converged = !broken();
    return count;
  }
};

}  // namespace ragdoll::examples
