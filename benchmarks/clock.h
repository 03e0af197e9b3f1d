// Clock: seconds of what was done, without those of looking at the clock.

#pragma once
#include <algorithm>  // min, max
#include <chrono>

namespace benchmark {

class Clock {
 public:
  Clock() {
    for (int k = 0; k < 1000; ++k) own_ = std::min(own_, since(now()));
  }

  /// Seconds that `action` takes.
  template <class Action>
  double time(Action&& action) const {
    const auto start = now();
    action();
    return std::max(0.0, since(start) - own_);
  }

 private:
  using Steady = std::chrono::steady_clock;
  static Steady::time_point now() { return Steady::now(); }
  static double since(Steady::time_point start) {
    return std::chrono::duration<double>(now() - start).count();
  }

  double own_ = 1;
};

}  // namespace benchmark
