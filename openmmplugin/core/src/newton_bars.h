// Newton bars: Newton steps on the bars' multipliers, for frameworks of bars whose cycles are few.
// Private to the resolvers.

#pragma once
#include <hwy/aligned_allocator.h>

#include <memory>
#include <span>
#include <vector>

#include "lane_transfer.h"       // LaneSource
#include "newton_bars_kernel.h"  // NewtonBarsTask
#include "newton_bars_plan.h"    // NewtonBarsPlan
#include "pass_frame.h"          // PassFrame
#include "residual.h"            // Residual

namespace ragdoll {

/// Conformers in lanes, or one. dx = -M^-1 J^T (J M^-1 J^T)^-1 c, the smallest move that the
/// linearised bars allow, so that a few steps do: each squares what is left. Nothing is damped; a
/// lane in which that leads nowhere gives up.
template <class T>
class NewtonBars {
 public:
  NewtonBars(std::shared_ptr<const NewtonBarsPlan> plan, const Framework& framework,
             const Tolerance& tolerance, bool wide);

  int lanes() const { return int(kernel_.lanes); }

  enum class State { free, busy, ended, given_up };
  State state(int lane) const { return lanes_[std::size_t(lane)].state; }
  int steps(int lane) const { return lanes_[std::size_t(lane)].steps; }

  /// Of a lane that was unloaded, where that told it.
  const Residual& residual(int lane) const { return lanes_[std::size_t(lane)].residual; }

  /// @param start  becomes the positions' copy, which stays until the lane is unloaded (njoint)
  /// @param most   steps
  void load(int lane, std::span<const Vec3> positions, std::vector<Vec3>& start, int most);

  /// The same for one conformer in doubles, whose positions are the caller's own until unload.
  void load_in_place(std::span<Vec3> positions, int most);

  /// A step in every lane that is busy.
  void iterate();

  /// Frees a lane that has ended. @return false if its residual in doubles is still to be found
  bool unload(int lane, std::span<Vec3> positions);

  void free(int lane) { lanes_[std::size_t(lane)].state = State::free; }

 private:
  struct Lane {
    explicit Lane(const PassFrame<T>& from) : frame(from) {}
    PassFrame<T> frame;
    State state = State::free;
    const Vec3* start = nullptr;  ///< as loaded; null: in place
    bool waits = false;           ///< loaded, and not in x_ yet
    bool fresh = false;           ///< not looked at yet
    bool settled = false;         ///< ended, and its row is taken and measured
    bool stands = true;           ///< floats tell the residual of what they stand for
    Residual residual;
    int steps = 0, most = 0;
    double worst = 0;
  };

  using Array = hwy::AlignedFreeUniquePtr<T[]>;
  Array zeros(std::size_t vectors) const;
  StridedPoints<T> points(int lane) const {
    return {x_.get() + lane, plan_->joint_count, 3 * kernel_.lanes, kernel_.lanes};
  }
  void begin(Lane& lane, int most) const;
  void put_waiting();
  void settle();
  static bool is_unsettled(const Lane& lane) {
    return !lane.settled && (lane.state == State::ended || lane.state == State::given_up) &&
           !lane.waits;
  }
  void look();

  std::shared_ptr<const NewtonBarsPlan> plan_;
  const NewtonBarsKernel<T>& kernel_;
  std::vector<typename NewtonBarsTask<T>::BarRow> bars_;
  std::vector<typename NewtonBarsTask<T>::Entry> entries_;
  std::vector<int> taken_from_;
  std::vector<std::uint8_t> is_taken_from_;
  Array x_, d_, value_, z_, busy_, worst_, relative_, largest_, sum_, wanted_;
  Array relative_from_, largest_from_;
  Array rows_;  ///< of the lanes that ended (nlane, njoint, 3)
  std::vector<double> lengths_, exact_relative_, exact_largest_;
  double longest_ = 0;  ///< bar
  Tolerance tolerance_;
  NewtonBarsTask<T> task_;
  std::vector<Lane> lanes_;
  std::vector<LaneSource> sources_;  ///< scratch
};

extern template class NewtonBars<float>;
extern template class NewtonBars<double>;

}  // namespace ragdoll
