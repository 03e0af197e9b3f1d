// Clock: seconds of what was done, without those of looking at the clock.

#pragma once
#include <time.h>  // clock_gettime

#include <algorithm>  // min, max

namespace benchmark {

class Clock {
 public:
  Clock() {
    for (int k = 0; k < 1000; ++k) {
      const double start = now(CLOCK_MONOTONIC);
      own_ = std::min(own_, now(CLOCK_MONOTONIC) - start);
    }
  }

  /// Seconds that `action` takes. What takes longer than a millisecond is not charged for the time
  /// in which the machine gave the core to others.
  template <class Action>
  double time(Action&& action) const {
    const double work = now(CLOCK_PROCESS_CPUTIME_ID);
    const double start = now(CLOCK_MONOTONIC);
    action();
    const double seconds = now(CLOCK_MONOTONIC) - start;
    if (seconds > 1e-3) return std::min(seconds, now(CLOCK_PROCESS_CPUTIME_ID) - work);
    return std::max(0.0, seconds - own_);
  }

  /// The same for what takes microseconds: the other clock is a call of the system, which would
  /// leave the action's code and data behind in the caches.
  template <class Action>
  double time_short(Action&& action) const {
    const double start = now(CLOCK_MONOTONIC);
    action();
    return std::max(0.0, now(CLOCK_MONOTONIC) - start - own_);
  }

 private:
  static double now(clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  }

  double own_ = 1;
};

}  // namespace benchmark
