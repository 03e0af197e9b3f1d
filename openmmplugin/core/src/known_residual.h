// Known residual: every bar's violation, kept, so that the largest is known when a few bars change.
// Private to the resolvers.

#pragma once
#include <cmath>  // abs

#include "conclusion.h"         // Residual
#include "max_tree.h"           // MaxTree
#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

class KnownResidual {
 public:
  /// @param at  position of a joint
  template <class At>
  KnownResidual(const Framework& framework, At at)
      : framework_(framework), violations_(framework.bars().size()) {
    for (int bar = 0; bar < framework.graph().bar_count(); ++bar) update(bar, at);
    settle();
  }

  /// Counts from the next settle() on.
  template <class At>
  void update(int bar, At at) {
    const Bar& b = framework_.bars()[std::size_t(bar)];
    const double excess = std::abs((at(b.q) - at(b.p)).norm() - b.length);
    violations_.set(std::size_t(bar), {excess / b.length, excess});
  }

  void settle() { violations_.settle(); }

  Residual largest() const {
    const BarViolation largest = violations_.largest();
    return {largest.relative, largest.nanometers};
  }

 private:
  const Framework& framework_;
  MaxTree violations_;  ///< (nbar)
};

}  // namespace ragdoll
