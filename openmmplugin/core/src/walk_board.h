// WalkBoard: which walker works next, and which frame is given out next. The one thing that the
// threads of a walk share.

#pragma once
#include <atomic>
#include <condition_variable>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "ragdoll/ensemble_resolver.h"  // EnsembleResolver
#include "ragdoll/walkers.h"            // WalkFrame, WalkerReport

namespace ragdoll {

/// A walker on its way. Between WalkBoard::next() calls it belongs to the thread that has it.
struct Walker {
  int number = 0;
  std::vector<Vec3> good;   ///< after the last accepted step, nm (njoint)
  std::vector<Vec3> trial;  ///< where the present step goes, nm (njoint)
  std::int64_t accepted = 0;
  std::int64_t first_step = 0;  ///< steps that were taken before this walk
  std::unique_ptr<Motion> motion = {};
  int rounds = 0;  ///< that the present step was resolved again, to be symmetric
  WalkerReport report = {};
  std::unique_ptr<EnsembleResolver> own = {};  ///< where no other walker can share one
};

class WalkBoard {
 public:
  /// @param frames  of each walker
  /// @param ahead   frames that a walker may be ahead of the frame that is given out next
  WalkBoard(std::vector<Walker> walkers, std::int64_t frames, std::int64_t ahead);

  // ---- for the threads that work

  /// The walker to work on until its next frame: of those that wait and the one handed back, one
  /// with the fewest frames. Null: none may go on now.
  /// @param back  a walker that made a frame; null where there is none
  Walker* next(Walker* back);

  /// Takes a frame that a walker made, before the walker is handed back or ended.
  void add(WalkFrame frame);

  /// Takes a walker that will make no more frames.
  void end(const Walker& walker);

  /// Changes when a walker may have become free to go on.
  unsigned news() const { return news_; }

  /// Waits for news that came after `known`; false when there is nothing more to do.
  bool wait_for_news(unsigned known);

  bool stopped() const { return stop_; }
  void stop();
  void fail(std::exception_ptr error);  ///< everything stops; the first error is kept

  // ---- for the thread that takes the frames

  /// The next frame in the fixed order. Waits a little while for it; nothing where it did not come.
  std::optional<WalkFrame> take();

  /// After the threads have ended: the next of the frames that are left, whatever is missing.
  std::optional<WalkFrame> take_left();

  bool done();  ///< all frames were taken that there will be
  std::exception_ptr error();
  std::vector<Walker>& walkers() { return walkers_; }

 private:
  using Place = std::pair<std::int64_t, int>;  ///< number of a frame, walker

  bool may_go_on(const Walker& walker) const;
  void pass_turn();
  void tell_threads();

  std::mutex mutex_;
  std::condition_variable work_, frame_;
  std::vector<Walker> walkers_;
  std::vector<bool> ended_;  ///< (nwalker)
  int live_;                 ///< walkers that have not ended
  std::set<Place> waiting_;  ///< walkers by the number of their next frame
  std::map<Place, WalkFrame> made_;
  Place turn_ = {0, 0};  ///< of the frame that is given out next
  std::int64_t frames_, ahead_;
  std::exception_ptr error_;
  std::atomic<unsigned> news_ = 0;
  std::atomic<bool> stop_ = false;
};

}  // namespace ragdoll
