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

/// Whether Ctrl-C came, while Python was given a frame or between frames. Called without Python's
/// lock.
class Interruption {
 public:
  /// Calls Python with its lock; Ctrl-C in there is kept, not thrown.
  template <class Call>
  void guard(const Call& call) {
    const nanobind::gil_scoped_acquire acquire;
    try {
      call();
    } catch (nanobind::python_error& error) {
      if (!error.matches(PyExc_KeyboardInterrupt)) throw;
      came_ = true;
    }
  }
  bool keep_going() const { return !came_ && no_interruption(); }

 private:
  bool came_ = false;
};

}  // namespace ragdoll::bindings
