// Sketch of a random connected graph in which every joint has the same number of bars.

#include <algorithm>  // find, swap
#include <string>

#include "ragdoll/error.h"  // Error
#include "ragdoll/graph.h"  // components_of
#include "sketch.h"

namespace ragdoll {
namespace {

int degree_of(const StructureRequest& request) {
  const int n = request.joints;
  int degree = request.degree;
  if (degree == 0) degree = std::min(n - 1, n % 2 == 0 ? 3 : 4);
  const std::string wanted =
      "a regular graph of " + std::to_string(n) + " joints and degree " + std::to_string(degree);
  if (degree < 1 || degree >= n)
    throw Error(wanted + " does not exist: the degree lies between 1 and " + std::to_string(n - 1));
  if (degree % 2 == 1 && n % 2 == 1)
    throw Error(wanted + " does not exist: one of the two must be even");
  if (degree == 1 && n > 2) throw Error(wanted + " is not connected");
  if (long(n) * degree > 1'000'000'000) throw Error(wanted + " has too many bars");
  return degree;
}

/// Simple graphs of one degree, each joint with its row of neighbours.
class RegularGraph {
 public:
  /// Each joint joined to the nearest on a circle, and, for odd degrees, to the opposite one.
  RegularGraph(int joints, int degree)
      : joints_(joints), degree_(degree), neighbours_(std::size_t(joints) * std::size_t(degree)) {
    for (int j = 0; j < joints; ++j) {
      int* row = row_of(j);
      for (int k = 1; k <= degree / 2; ++k) {
        *row++ = (j + k) % joints;
        *row++ = (j + joints - k) % joints;
      }
      if (degree % 2 == 1) *row = (j + joints / 2) % joints;
    }
  }

  /// Two bars a-b and c-d become a-d and c-b, unless one of these is there already.
  void switch_bars(Sketch& sketch) {
    const int a = sketch.below(joints_), c = sketch.below(joints_);
    const int b = row_of(a)[sketch.below(degree_)], d = row_of(c)[sketch.below(degree_)];
    if (a == c || a == d || b == c || b == d || joined(a, d) || joined(c, b)) return;
    replace(a, b, d);
    replace(b, a, c);
    replace(c, d, b);
    replace(d, c, a);
  }

  std::vector<std::pair<int, int>> bars() {
    std::vector<std::pair<int, int>> list;
    for (int j = 0; j < joints_; ++j)
      for (int k = 0; k < degree_; ++k)
        if (j < row_of(j)[k]) list.emplace_back(j, row_of(j)[k]);
    return list;
  }

 private:
  int* row_of(int joint) { return neighbours_.data() + std::ptrdiff_t(joint) * degree_; }
  bool joined(int p, int q) {
    return std::find(row_of(p), row_of(p) + degree_, q) != row_of(p) + degree_;
  }
  void replace(int joint, int old_one, int new_one) {
    *std::find(row_of(joint), row_of(joint) + degree_, old_one) = new_one;
  }

  int joints_, degree_;
  std::vector<int> neighbours_;  ///< (njoint, degree)
};

bool connected(int joints, const std::vector<std::pair<int, int>>& bars) {
  return components_of(Graph(joints, bars)).count() == 1;
}

}  // namespace

void sketch_regular(Sketch& sketch) {
  const int n = sketch.request.joints, degree = degree_of(sketch.request);
  // random switches of bars lead from any regular graph to any other
  RegularGraph graph(n, degree);
  const long switches = 10L * n * degree / 2;
  std::vector<std::pair<int, int>> bars = graph.bars();
  // with degree 2 the only connected one is the cycle
  for (int round = 0; degree > 2 && round < 100; ++round) {
    for (long k = 0; k < switches; ++k) graph.switch_bars(sketch);
    bars = graph.bars();
    if (connected(n, bars)) break;
  }
  if (!connected(n, bars)) throw Error("no connected regular graph was found in 100 attempts");
  for (int j = 0; j < n; ++j) sketch.add_random_joint();
  sketch.bars = std::move(bars);
}

}  // namespace ragdoll
