// Work list: which bars could be violated, because an end moved since they were last found within
// tolerance, by their places in the order. A sweep leaves the others out without changing its
// result. Private to the resolvers.

#pragma once
#include <cstdint>
#include <vector>

#include "ragdoll/graph.h"  // Graph
#include "rank_set.h"       // RankSet

namespace ragdoll {

template <class T>
class WorkList {
 public:
  explicit WorkList(const Graph& graph)
      : graph_(graph),
        waiting_(std::size_t(graph.bar_count()), 1),
        waiting_count_(waiting_.size()),
        first_place_(waiting_.size(), -1) {}

  // === The order

  /// A new order, with no places yet; costs no more than the old one had places.
  /// @param most      places that can be appended
  /// @param and_back  each place k has another of the same bar, 2 most - 1 - k
  void start_over(std::size_t most, bool and_back = false) {
    for (std::size_t place = 0; place < bar_at_.size(); ++place) {
      erase(place);
      first_place_[std::size_t(bar_at_[place])] = -1;
    }
    const std::size_t back_from = and_back ? 2 * most : 0;
    if (most != most_ || back_from != back_from_) {
      places_.resize(and_back ? 2 * most : most);
      most_ = most;
      back_from_ = back_from;
    }
    bar_at_.clear();
    next_place_.clear();
    without_place_ = waiting_count_;
  }

  /// The next place of the order is this bar's.
  void append(int bar) {
    const std::size_t place = bar_at_.size();
    std::int64_t& first = first_place_[std::size_t(bar)];
    if (has(bar)) {
      insert(place);
      without_place_ -= first < 0;
    }
    bar_at_.push_back(bar);
    next_place_.push_back(first);
    first = std::int64_t(place);
  }

  // === The bars

  /// The first place from this one on whose bar could be violated, or RankSet::none.
  std::size_t next(std::size_t place) const { return places_.next(place); }

  /// Whether a place is on the way back.
  bool is_back(std::size_t place) const { return back_from_ != 0 && place >= most_; }

  /// Of a place: the one at which its bar was appended.
  std::size_t appended_at(std::size_t place) const {
    return is_back(place) ? back_from_ - 1 - place : place;
  }

  /// Some bar that could be violated has no place yet.
  bool expects_places() const { return without_place_ > 0; }

  bool has(int bar) const { return waiting_[std::size_t(bar)] != 0; }

  /// The bar is within tolerance where its ends are now.
  void settle(int bar) {
    if (!has(bar)) return;
    waiting_[std::size_t(bar)] = 0;
    --waiting_count_;
    const std::int64_t first = first_place_[std::size_t(bar)];
    without_place_ -= first < 0;
    for (std::int64_t k = first; k >= 0; k = next_place_[std::size_t(k)]) erase(std::size_t(k));
  }

  /// A joint moved: all its bars could be violated.
  void move(int joint) {
    for (const Graph::Link& link : graph_.links(joint)) {
      if (has(link.bar)) continue;
      waiting_[std::size_t(link.bar)] = 1;
      ++waiting_count_;
      const std::int64_t first = first_place_[std::size_t(link.bar)];
      without_place_ += first < 0;
      for (std::int64_t k = first; k >= 0; k = next_place_[std::size_t(k)]) insert(std::size_t(k));
    }
  }

  // === The positions

  /// Keeps the positions, three numbers each, for move_changed.
  void remember(const T* x) { positions_.assign(x, x + 3 * std::size_t(graph_.joint_count())); }

  /// Of one joint.
  void remember(const T* x, int joint) {
    for (std::size_t i = 3 * std::size_t(joint); i < 3 * std::size_t(joint) + 3; ++i)
      positions_[i] = x[i];
  }

  const std::vector<T>& remembered() const { return positions_; }

  /// The joints that are not where remember() saw them have moved. All, if it saw none.
  void move_changed(const T* x) {
    const bool all = positions_.empty();
    for (std::size_t j = 0; j < std::size_t(graph_.joint_count()); ++j)
      if (all || x[3 * j] != positions_[3 * j] || x[3 * j + 1] != positions_[3 * j + 1] ||
          x[3 * j + 2] != positions_[3 * j + 2])
        move(int(j));
  }

 private:
  void insert(std::size_t place) {
    places_.insert(place);
    if (back_from_ != 0) places_.insert(back_from_ - 1 - place);
  }
  void erase(std::size_t place) {
    places_.erase(place);
    if (back_from_ != 0) places_.erase(back_from_ - 1 - place);
  }

  const Graph& graph_;
  std::vector<std::uint8_t> waiting_;  ///< could be violated (nbar)
  std::size_t waiting_count_;
  std::size_t without_place_ = 0;  ///< of those, bars that have no place yet
  std::size_t most_ = 0;
  std::size_t back_from_ = 0;              ///< all places, if half of them are on the way back
  RankSet places_;                         ///< of the bars that could be violated
  std::vector<std::int64_t> first_place_;  ///< one of the bar's places, -1: it has none (nbar)
  std::vector<std::int64_t> next_place_;   ///< another place of the same bar, or -1 (nplace)
  std::vector<int> bar_at_;                ///< (nplace)
  std::vector<T> positions_;               ///< remembered (3 njoint)
};

}  // namespace ragdoll
