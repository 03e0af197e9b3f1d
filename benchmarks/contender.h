// Contender: one way to resolve breaks of a network, ours or a baseline.

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "network.h"           // Network, Positions
#include "ragdoll/resolver.h"  // ResolverSettings

namespace benchmark {

/// Of one contender: what became of the breaks, and the best times over repetitions.
struct Result {
  std::vector<Positions> positions;      ///< (nbreak)
  std::vector<bool> converged;           ///< says the contender (nbreak)
  std::vector<std::int64_t> iterations;  ///< (nbreak)
  std::vector<double> seconds;           ///< of each break, or one number for all of them

  double total_seconds() const;
};

class Contender {
 public:
  Contender(std::string name, bool baseline) : name_(std::move(name)), baseline_(baseline) {}
  virtual ~Contender() = default;

  const std::string& name() const { return name_; }
  bool baseline() const { return baseline_; }  ///< knows bars only

  /// Fills all of `result`; loading and storing positions is not timed where a user does not pay
  /// for it.
  virtual void resolve(const std::vector<Positions>& breaks, Result& result) = 0;

 private:
  std::string name_;
  bool baseline_;
};

using Contenders = std::vector<std::unique_ptr<Contender>>;

/// Baselines make no more than 10,000 passes. R corrects every bar on every visit and shuffles them
/// anew for each iteration; its sisters correct only those that are broken, or keep the order that
/// was drawn once.
Contenders plain_contenders(const Network& network, ragdoll::Tolerance tolerance);
std::unique_ptr<Contender> coloured_contender(const Network& network, ragdoll::Tolerance tolerance);

/// One of our solvers: one break after the other, or in the lanes of an EnsembleResolver.
std::unique_ptr<Contender> solver_contender(const std::string& name, const Network& network,
                                            const ragdoll::ResolverSettings& settings);
std::unique_ptr<Contender> ensemble_contender(const std::string& name, const Network& network,
                                              const ragdoll::ResolverSettings& settings);

/// All contenders in turn, so that a busy machine slows all of them; each is repeated until it had
/// its share of seconds, once at least. Prints a record for each.
/// @return  results, in the order of the contenders
std::vector<Result> compete(const Network& network, const std::vector<Positions>& breaks,
                            const Contenders& contenders, ragdoll::Tolerance tolerance,
                            double seconds_each);

}  // namespace benchmark
