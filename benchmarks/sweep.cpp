// benchmark_sweep: nanoseconds per bar visit of the `ordered` solver, and of a plain loop as the
// thesis describes it, on the same frameworks and perturbations. Prints JSON; asserts nothing.
//
//   benchmark_sweep [--quick] [NAME=FILE]...
//
// FILE is text: "njoint nbar", njoint lines "x y z" (nm), nbar lines "p q length" (nm).

#include <algorithm>  // shuffle, min
#include <chrono>
#include <cmath>    // sqrt, abs
#include <cstdio>   // printf
#include <fstream>  // ifstream
#include <functional>
#include <limits>
#include <memory>
#include <numeric>  // iota
#include <random>   // mt19937_64
#include <string>
#include <vector>

#include "ragdoll/break.h"     // perturb
#include "ragdoll/error.h"     // Error
#include "ragdoll/resolver.h"  // make_resolver

namespace {

using ragdoll::Framework;
using ragdoll::Vec3;
using Positions = std::vector<Vec3>;

constexpr double tolerance = 0.01;
constexpr long max_iterations = 100000;
constexpr double perturbation = 0.07;  // of the mean bar length, per coordinate
constexpr int breaks = 4;              // perturbations that each repetition resolves

struct Case {
  std::string name;
  std::shared_ptr<const Framework> framework;
  Positions positions;  // nm (njoint), every bar at its length
};

// === Frameworks

Case make_case(const std::string& name, Positions positions, std::vector<ragdoll::Bar> bars) {
  ragdoll::FrameworkParts parts;
  parts.masses.assign(positions.size(), 1.0);
  parts.fixed.assign(positions.size(), 0);
  parts.bars = std::move(bars);
  return {name, std::make_shared<const Framework>(std::move(parts)), std::move(positions)};
}

/// Each joint gets a bar to its parent, one bar length away in a random direction.
Case grown(const std::string& name, int joints, const std::function<int(int)>& parent) {
  ragdoll::Random random(1, ragdoll::RandomStream::generate, 0);
  constexpr double length = 0.15;
  Positions x = {Vec3::Zero()};
  std::vector<ragdoll::Bar> bars;
  for (int j = 1; j < joints; ++j) {
    const Vec3 direction = Vec3(random.gaussian(), random.gaussian(), random.gaussian());
    const int p = parent(j);
    x.push_back(x[std::size_t(p)] + length * direction.normalized());
    bars.push_back({p, j, (x.back() - x[std::size_t(p)]).norm()});
  }
  return make_case(name, std::move(x), std::move(bars));
}

Case read_case(const std::string& name, const std::string& path) {
  std::ifstream file(path);
  std::size_t joints = 0, bars = 0;
  file >> joints >> bars;
  Positions x(joints);
  for (Vec3& joint : x) file >> joint[0] >> joint[1] >> joint[2];
  std::vector<ragdoll::Bar> list(bars);
  for (ragdoll::Bar& bar : list) file >> bar.p >> bar.q >> bar.length;
  if (!file) throw ragdoll::Error(path + " is no framework");
  return make_case(name, std::move(x), std::move(list));
}

std::vector<Positions> perturbed(const Case& example) {
  const auto& bars = example.framework->bars();
  double mean = 0;
  for (const ragdoll::Bar& bar : bars) mean += bar.length / double(bars.size());
  std::vector<Positions> all(breaks, example.positions);
  for (std::size_t k = 0; k < all.size(); ++k) {
    ragdoll::Random random(7, ragdoll::RandomStream::perturbation, k);
    perturb(all[k], example.framework->fixed(), ragdoll::PerturbationKind::gaussian,
            perturbation * mean, random);
  }
  return all;
}

// === Baseline

/// Ragdoll physics written down plainly: objects for joints and bars, the distance of every bar on
/// every visit, each error shared .5/.5, and a pass over all bars to see whether another one is
/// needed.
class PlainLoop {
 public:
  explicit PlainLoop(const Framework& framework) : joints_(std::size_t(framework.joint_count())) {
    for (const ragdoll::Bar& bar : framework.bars())
      bars_.push_back({&joints_[std::size_t(bar.p)], &joints_[std::size_t(bar.q)], bar.length});
    order_.resize(bars_.size());
    forget_order();
  }

  /// Back to the bars' own order.
  void forget_order() { std::iota(order_.begin(), order_.end(), std::size_t(0)); }

  void set_order(const ragdoll::Order& order) {
    for (std::size_t k = 0; k < order.size(); ++k) order_[k] = std::size_t(order[k].bar);
  }

  void load(const Positions& x) {
    for (std::size_t j = 0; j < x.size(); ++j) joints_[j] = {x[j][0], x[j][1], x[j][2]};
  }

  /// @param random  shuffles the order anew for each iteration; null: the order stays
  /// @return iterations
  long resolve(std::mt19937_64* random) {
    long iterations = 0;
    while (!satisfied() && iterations < max_iterations) {
      if (random) std::shuffle(order_.begin(), order_.end(), *random);
      for (const std::size_t bar : order_) visit(bars_[bar]);
      ++iterations;
    }
    return iterations;
  }

  /// nm by which the farthest joint is elsewhere.
  double deviation(const Positions& x) const {
    double largest = 0;
    for (std::size_t j = 0; j < x.size(); ++j)
      largest = std::max(largest, (Vec3(joints_[j].x, joints_[j].y, joints_[j].z) - x[j]).norm());
    return largest;
  }

 private:
  struct Joint {
    double x = 0, y = 0, z = 0;
  };
  struct Bar {
    Joint *p, *q;
    double length;
  };

  static double distance(const Bar& bar) {
    const double dx = bar.q->x - bar.p->x, dy = bar.q->y - bar.p->y, dz = bar.q->z - bar.p->z;
    return std::sqrt(dx * dx + dy * dy + dz * dz);
  }

  static void visit(const Bar& bar) {
    const double d = distance(bar);
    const double error = bar.length - d;
    if (std::abs(error) <= tolerance * bar.length) return;
    const double share = 0.5 * error / d;
    const double dx = bar.q->x - bar.p->x, dy = bar.q->y - bar.p->y, dz = bar.q->z - bar.p->z;
    bar.p->x -= share * dx;
    bar.p->y -= share * dy;
    bar.p->z -= share * dz;
    bar.q->x += share * dx;
    bar.q->y += share * dy;
    bar.q->z += share * dz;
  }

  bool satisfied() const {
    bool all = true;
    for (const Bar& bar : bars_)
      if (std::abs(bar.length - distance(bar)) > tolerance * bar.length) all = false;
    return all;
  }

  std::vector<Joint> joints_;
  std::vector<Bar> bars_;
  std::vector<std::size_t> order_;
};

// === Measurement

/// One way to resolve, and the best of its repetitions.
struct Contender {
  std::string name;
  std::function<void(const Positions&, std::uint64_t)> prepare;
  std::function<long(std::uint64_t)> resolve;  // returns bar visits
  double seconds = std::numeric_limits<double>::infinity();
  long visits = 0;
};

void repeat(Contender& contender, const std::vector<Positions>& broken) {
  double seconds = 0;
  contender.visits = 0;
  for (std::size_t k = 0; k < broken.size(); ++k) {
    contender.prepare(broken[k], k);
    const auto start = std::chrono::steady_clock::now();
    contender.visits += contender.resolve(k);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  contender.seconds = std::min(contender.seconds, seconds);
}

ragdoll::Order breadth_first(const Framework& framework) {
  std::vector<int> roots;
  ragdoll::MiddleJoint middle(framework.graph());
  for (const int lowest : framework.components().lowest_joint) roots.push_back(middle.of(lowest));
  ragdoll::Random unused(0, ragdoll::RandomStream::order, 0);
  return order_of(framework.graph(), ragdoll::OrderKind::bfs_cycle, roots, unused);
}

void measure(const Case& example, double seconds, bool last) {
  const Framework& framework = *example.framework;
  const std::vector<Positions> broken = perturbed(example);
  const long bars = long(framework.bars().size());

  Positions x;
  const auto ordered = [&](const char* name, ragdoll::OrderKind order) {
    ragdoll::ResolverSettings settings;
    settings.solver = "ordered";
    settings.order = order;
    settings.tolerance = tolerance;
    settings.max_iterations = max_iterations;
    std::shared_ptr<ragdoll::Resolver> resolver = make_resolver(example.framework, settings);
    return Contender{name, [&](const Positions& start, std::uint64_t) { x = start; },
                     [&x, resolver](std::uint64_t step) {
                       return long(resolver->resolve(x, {.step = step}).bar_visits);
                     }};
  };

  PlainLoop plain(framework), plain_ordered(framework);
  plain_ordered.set_order(breadth_first(framework));
  std::mt19937_64 random;
  std::vector<Contender> contenders = {
      ordered("ordered_bfs_cycle", ragdoll::OrderKind::bfs_cycle),
      ordered("ordered_random", ragdoll::OrderKind::random),
      {"plain_bfs_cycle", [&](const Positions& start, std::uint64_t) { plain_ordered.load(start); },
       [&](std::uint64_t) { return plain_ordered.resolve(nullptr) * bars; }},
      {"plain_random",
       [&](const Positions& start, std::uint64_t step) {
         plain.load(start);
         plain.forget_order();
         random.seed(step);
       },
       [&](std::uint64_t) { return plain.resolve(&random) * bars; }},
  };

  // all contenders in turn, so that a busy machine slows all of them
  const auto start = std::chrono::steady_clock::now();
  int repetitions = 0;
  do {
    for (Contender& contender : contenders) repeat(contender, broken);
    ++repetitions;
  } while (repetitions < 3 ||
           std::chrono::steady_clock::now() - start < std::chrono::duration<double>(seconds));

  // the same order must give the same joints
  contenders[0].prepare(broken[0], 0);
  contenders[0].resolve(0);
  contenders[2].prepare(broken[0], 0);
  contenders[2].resolve(0);

  std::printf("  {\"name\": \"%s\", \"joints\": %d, \"bars\": %ld, \"repetitions\": %d,\n",
              example.name.c_str(), framework.joint_count(), bars, repetitions);
  std::printf("   \"deviation_nm\": %.3g, \"contenders\": {\n", plain_ordered.deviation(x));
  for (std::size_t k = 0; k < contenders.size(); ++k) {
    const Contender& c = contenders[k];
    std::printf("    \"%s\": {\"ns_per_visit\": %.4g, \"iterations\": %.4g, \"ms\": %.4g}%s\n",
                c.name.c_str(), c.seconds * 1e9 / double(c.visits),
                double(c.visits) / double(bars) / breaks, c.seconds * 1e3 / breaks,
                k + 1 < contenders.size() ? "," : "}");
  }
  std::printf("  }%s\n", last ? "" : ",");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    constexpr int joints = 2000;
    ragdoll::Random random(2, ragdoll::RandomStream::generate, 0);
    std::vector<Case> cases;
    cases.push_back(grown("tree", joints, [&](int j) { return int(random.below(unsigned(j))); }));
    cases.push_back(grown("chain", joints, [](int j) { return j - 1; }));
    double seconds = 3;  // for each case
    for (int k = 1; k < argc; ++k) {
      const std::string word = argv[k];
      const std::size_t equals = word.find('=');
      if (word == "--quick")
        seconds = 0.3;
      else if (equals != std::string::npos)
        cases.push_back(read_case(word.substr(0, equals), word.substr(equals + 1)));
      else
        throw ragdoll::Error("usage: benchmark_sweep [--quick] [NAME=FILE]...");
    }
    std::printf("[\n");
    for (const Case& example : cases) measure(example, seconds, &example == &cases.back());
    std::printf("]\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_sweep: %s\n", error.what());
    return 2;
  }
  return 0;
}
