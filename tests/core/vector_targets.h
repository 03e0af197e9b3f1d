// Runs what a test does with each kind of vectors that this processor has.

#pragma once
#include <hwy/targets.h>

#include <cstdint>

namespace ragdoll::examples {

template <class Body>
void for_each_vector_target(Body body) {
  const auto choose = [](std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
    choose(rest & -rest);
    body();
  }
  choose(0);
}

}  // namespace ragdoll::examples
