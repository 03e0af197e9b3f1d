#include "walk_board.h"

#include <chrono>

namespace ragdoll {
namespace {

/// So many frames more than others a walker makes before it leaves its lane to them. What a lane
/// knows of its walker, such as the pairs that are near each other, is of no use to the next.
constexpr std::int64_t at_a_stretch = 32;

}  // namespace

WalkBoard::WalkBoard(std::vector<Walker> walkers, std::int64_t frames, std::int64_t ahead)
    : walkers_(std::move(walkers)),
      ended_(walkers_.size()),
      live_(int(walkers_.size())),
      frames_(frames),
      ahead_(ahead) {
  for (const Walker& walker : walkers_) waiting_.emplace(0, walker.number);
}

bool WalkBoard::may_go_on(const Walker& walker) const {
  return walker.report.frames < turn_.first + ahead_;
}

void WalkBoard::tell_threads() {
  ++news_;
  work_.notify_all();
}

Walker* WalkBoard::next(Walker* back) {
  const std::lock_guard lock(mutex_);
  Walker* first = waiting_.empty() ? nullptr : &walkers_[std::size_t(waiting_.begin()->second)];
  const bool back_is_first =
      back && (!first || back->report.frames < first->report.frames + at_a_stretch);
  if (back_is_first && may_go_on(*back)) return back;
  if (first && may_go_on(*first))
    waiting_.erase(waiting_.begin());
  else
    first = nullptr;
  if (back) {
    waiting_.emplace(back->report.frames, back->number);
    tell_threads();
  }
  return first;
}

void WalkBoard::add(WalkFrame frame) {
  const std::lock_guard lock(mutex_);
  const Place place{frame.number, frame.walker};
  made_.emplace(place, std::move(frame));
  if (place == turn_) frame_.notify_one();
}

void WalkBoard::end(const Walker& walker) {
  const std::lock_guard lock(mutex_);
  ended_[std::size_t(walker.number)] = true;
  --live_;
  tell_threads();
  frame_.notify_one();
}

bool WalkBoard::wait_for_news(unsigned known) {
  std::unique_lock lock(mutex_);
  work_.wait(lock, [&] { return news_ != known || live_ == 0 || stop_; });
  return live_ > 0 && !stop_;
}

void WalkBoard::stop() {
  const std::lock_guard lock(mutex_);
  stop_ = true;
  tell_threads();
  frame_.notify_one();
}

void WalkBoard::fail(std::exception_ptr error) {
  {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
  }
  stop();
}

void WalkBoard::pass_turn() {
  if (++turn_.second < int(walkers_.size())) return;
  turn_ = {turn_.first + 1, 0};
  // walkers that waited for the slowest may go on
  tell_threads();
}

std::optional<WalkFrame> WalkBoard::take() {
  std::unique_lock lock(mutex_);
  const auto something_happened = [&] {
    // walkers that have ended are left out
    while (turn_.first < frames_ && ended_[std::size_t(turn_.second)] && !made_.contains(turn_))
      pass_turn();
    return made_.contains(turn_) || turn_.first == frames_ || stop_;
  };
  frame_.wait_for(lock, std::chrono::milliseconds(50), something_happened);
  auto found = made_.extract(turn_);
  if (found.empty()) return std::nullopt;
  pass_turn();
  return std::move(found.mapped());
}

std::optional<WalkFrame> WalkBoard::take_left() {
  const std::lock_guard lock(mutex_);
  if (made_.empty()) return std::nullopt;
  return std::move(made_.extract(made_.begin()).mapped());
}

bool WalkBoard::done() {
  const std::lock_guard lock(mutex_);
  return turn_.first == frames_;
}

std::exception_ptr WalkBoard::error() {
  const std::lock_guard lock(mutex_);
  return error_;
}

}  // namespace ragdoll
