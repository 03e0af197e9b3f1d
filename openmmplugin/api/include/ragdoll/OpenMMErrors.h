// The border of the two worlds' exceptions: core throws Error, OpenMM's users expect
// OpenMMException.

#pragma once
#include <openmm/OpenMMException.h>

#include <utility>

#include "ragdoll/error.h"  // Error

namespace ragdoll {

/// Runs `call` and turns core's Error into an OpenMMException with the same sentence.
template <class Call>
decltype(auto) withOpenMMErrors(Call&& call) {
  try {
    return std::forward<Call>(call)();
  } catch (const Error& error) {
    throw OpenMM::OpenMMException(error.what());
  }
}

}  // namespace ragdoll
