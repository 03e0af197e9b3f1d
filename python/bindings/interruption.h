// Interruption: whether Python wants a long call to go on.

#pragma once
#include <nanobind/nanobind.h>

#include <utility>  // move

namespace ragdoll::bindings {

/// False after Ctrl-C; any other signal's exception is thrown. Called without Python's lock.
inline bool no_interruption() {
  const nanobind::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() == 0) return true;
  nanobind::python_error error;
  if (!error.matches(PyExc_KeyboardInterrupt)) throw nanobind::python_error(std::move(error));
  return false;
}

}  // namespace ragdoll::bindings
