#include "contender.h"

#include <algorithm>  // min
#include <numeric>    // accumulate

#include "clock.h"                      // Clock
#include "coloured_sweep.h"             // ColouredSweep
#include "plain_loop.h"                 // PlainLoop
#include "ragdoll/ensemble_resolver.h"  // make_ensemble_resolver
#include "record.h"                     // Record

namespace benchmark {
namespace {

using ragdoll::ResolveReport;
using ragdoll::Tolerance;

constexpr std::int64_t most_iterations = 10000;

void make_room(const std::vector<Positions>& breaks, std::size_t times, Result& result) {
  result.positions.resize(breaks.size());
  result.converged.resize(breaks.size());
  result.iterations.resize(breaks.size());
  result.seconds.resize(times);
}

template <class Loop>
class LoopContender final : public Contender {
 public:
  template <class... Options>
  LoopContender(const char* name, const Network& network, Tolerance tolerance, Options... options)
      : Contender(name, true), loop_(*network.framework, tolerance, most_iterations, options...) {}

  void resolve(const std::vector<Positions>& breaks, Result& result) override {
    make_room(breaks, breaks.size(), result);
    for (std::size_t k = 0; k < breaks.size(); ++k) {
      loop_.load(breaks[k]);
      bool converged = false;
      result.seconds[k] = clock_.time([&] { converged = loop_.resolve(); });
      result.converged[k] = converged;
      result.iterations[k] = loop_.iterations();
      result.positions[k].resize(breaks[k].size());
      loop_.store(result.positions[k]);
    }
  }

 private:
  Loop loop_;
  Clock clock_;
};

class SolverContender final : public Contender {
 public:
  SolverContender(const std::string& name, const Network& network,
                  const ragdoll::ResolverSettings& settings)
      : Contender(name, false), resolver_(make_resolver(network.framework, settings)) {}

  void resolve(const std::vector<Positions>& breaks, Result& result) override {
    make_room(breaks, breaks.size(), result);
    for (std::size_t k = 0; k < breaks.size(); ++k) {
      result.positions[k] = breaks[k];
      ResolveReport report;
      result.seconds[k] =
          clock_.time([&] { report = resolver_->resolve(result.positions[k], {.step = k}); });
      result.converged[k] = report.converged;
      result.iterations[k] = report.iterations;
    }
  }

 private:
  std::unique_ptr<ragdoll::Resolver> resolver_;
  Clock clock_;
};

/// Loading the lanes and unloading them is in the time.
class EnsembleContender final : public Contender {
 public:
  EnsembleContender(const std::string& name, const Network& network,
                    const ragdoll::ResolverSettings& settings)
      : Contender(name, false),
        joints_(std::size_t(network.framework->joint_count())),
        resolver_(make_ensemble_resolver(network.framework, settings)) {}

  void resolve(const std::vector<Positions>& breaks, Result& result) override {
    make_room(breaks, 1, result);
    Positions all;
    for (const Positions& x : breaks) all.insert(all.end(), x.begin(), x.end());
    std::vector<ResolveReport> reports;
    result.seconds[0] = clock_.time([&] { reports = resolve_all(*resolver_, all); });
    for (std::size_t k = 0; k < breaks.size(); ++k) {
      const auto first = all.begin() + std::ptrdiff_t(k * joints_);
      result.positions[k].assign(first, first + std::ptrdiff_t(joints_));
      result.converged[k] = reports[k].converged;
      result.iterations[k] = reports[k].iterations;
    }
  }

 private:
  std::size_t joints_;
  std::unique_ptr<ragdoll::EnsembleResolver> resolver_;
  Clock clock_;
};

/// The better time of each break.
void keep_best(const std::vector<double>& best, std::vector<double>& seconds) {
  for (std::size_t k = 0; k < best.size(); ++k) seconds[k] = std::min(seconds[k], best[k]);
}

void print(const Network& network, const Contender& contender, const Result& result,
           Tolerance tolerance) {
  std::int64_t converged = 0, wrong = 0, inverted = 0;
  double iterations = 0;
  for (std::size_t k = 0; k < result.positions.size(); ++k) {
    iterations += double(result.iterations[k]) / double(result.positions.size());
    if (!result.converged[k]) continue;
    ++converged;
    const Positions& x = result.positions[k];
    // rounding may decide the last digit
    wrong +=
        worst_excess(*network.framework, x, tolerance, contender.baseline()) > 1 + 1e-9 ? 1 : 0;
    inverted += inverted_centres(*network.framework, x);
  }
  Record("network")
      .text("network", network.name)
      .count("joints", network.framework->joint_count())
      .count("bars", std::int64_t(network.framework->bars().size()))
      .text("tolerance_kind", tolerance.absolute() ? "angstrom" : "relative")
      .number("tolerance", tolerance.value() * (tolerance.absolute() ? 10 : 1))
      .text("contender", contender.name())
      .count("breaks", std::int64_t(result.positions.size()))
      .count("converged", converged)
      .count("wrong", wrong)
      .count("inverted", inverted)
      .number("iterations", iterations)
      .count("most_iterations",
             *std::max_element(result.iterations.begin(), result.iterations.end()))
      .number("ms", 1e3 * result.total_seconds() / double(result.positions.size()))
      .print();
}

}  // namespace

double Result::total_seconds() const {
  return std::accumulate(seconds.begin(), seconds.end(), 0.0);
}

Contenders plain_contenders(const Network& network, Tolerance tolerance) {
  Contenders all;
  const auto add = [&](const char* name, Corrects corrects, Shuffles shuffles) {
    all.push_back(
        std::make_unique<LoopContender<PlainLoop>>(name, network, tolerance, corrects, shuffles));
  };
  add("plain", Corrects::every_bar, Shuffles::each_iteration);
  add("plain lean", Corrects::broken_bars, Shuffles::each_iteration);
  add("plain once", Corrects::every_bar, Shuffles::once);
  return all;
}

std::unique_ptr<Contender> coloured_contender(const Network& network, Tolerance tolerance) {
  return std::make_unique<LoopContender<ColouredSweep>>("coloured", network, tolerance);
}

std::unique_ptr<Contender> solver_contender(const std::string& name, const Network& network,
                                            const ragdoll::ResolverSettings& settings) {
  return std::make_unique<SolverContender>(name, network, settings);
}

std::unique_ptr<Contender> ensemble_contender(const std::string& name, const Network& network,
                                              const ragdoll::ResolverSettings& settings) {
  return std::make_unique<EnsembleContender>(name, network, settings);
}

std::vector<Result> compete(const Network& network, const std::vector<Positions>& breaks,
                            const Contenders& contenders, Tolerance tolerance,
                            double seconds_each) {
  std::vector<Result> results(contenders.size());
  std::vector<double> spent(contenders.size(), 0);
  for (bool again = true; again;) {
    again = false;
    for (std::size_t k = 0; k < contenders.size(); ++k) {
      if (spent[k] >= seconds_each) continue;
      const std::vector<double> best = results[k].seconds;
      contenders[k]->resolve(breaks, results[k]);
      spent[k] += results[k].total_seconds();
      keep_best(best, results[k].seconds);
      again |= spent[k] < seconds_each;
    }
  }
  for (std::size_t k = 0; k < contenders.size(); ++k)
    print(network, *contenders[k], results[k], tolerance);
  return results;
}

}  // namespace benchmark
