#include "block_elimination.h"

#include <algorithm>  // min, max
#include <array>
#include <bit>  // popcount, countr_zero
#include <cstdint>
#include <limits>  // max

namespace ragdoll {
namespace {

using Bars = std::uint64_t;  ///< a set

constexpr Bars only(int bar) {
  return Bars(1) << bar;
}

template <class Action>
void for_each(Bars bars, Action action) {
  for (; bars != 0; bars &= bars - 1) action(std::countr_zero(bars));
}

}  // namespace

bool BlockElimination::suits(const CycleBlock& block) {
  const std::size_t bars = block.bars.size();
  return bars <= most_bars &&
         (bars <= most_rows + 1 || block.couplings.size() <= bars * most_rows / 2);
}

BlockElimination::BlockElimination(const CycleBlock& block) {
  const int n = int(block.bars.size());
  std::array<Bars, most_bars> neighbours = {}, column = {};
  std::array<int, most_bars> touched = {}, place = {};
  for (const auto& c : block.couplings) {
    neighbours[std::size_t(c.row)] |= only(c.column);
    neighbours[std::size_t(c.column)] |= only(c.row);
  }
  Bars left = n == most_bars ? ~Bars(0) : only(n) - 1;
  for (int step = 1; step <= n; ++step) {
    int next = -1, fewest = std::numeric_limits<int>::max();
    for_each(left, [&](int bar) {
      const int count = std::popcount(neighbours[std::size_t(bar)]);
      if (count > fewest) return;
      if (count == fewest && touched[std::size_t(bar)] >= touched[std::size_t(next)]) return;
      next = bar;
      fewest = count;
    });
    const Bars around = column[std::size_t(next)] = neighbours[std::size_t(next)];
    for_each(around, [&](int bar) {
      Bars& own = neighbours[std::size_t(bar)];
      own = (own | around) & ~only(bar) & ~only(next);
      touched[std::size_t(bar)] = step;
    });
    left &= ~only(next);
    place[std::size_t(next)] = int(bar_.size());
    bar_.push_back(next);
  }

  // values below the diagonal
  std::vector<int> value(std::size_t(n) * std::size_t(n), -1);  // by column and row, in places
  const auto value_at = [&](int a, int b) -> int& {
    return value[std::size_t(std::min(a, b)) * std::size_t(n) + std::size_t(std::max(a, b))];
  };
  for (int j = 0; j < n; ++j) row_.push_back(j);
  for (int j = 0; j < n; ++j) {
    begin_.push_back(int(row_.size()));
    for_each(column[std::size_t(bar_[std::size_t(j)])], [&](int bar) {
      const int row = place[std::size_t(bar)];
      value_at(j, row) = int(row_.size());
      row_.push_back(row);
    });
  }
  begin_.push_back(int(row_.size()));
  std::vector<char> is_set(row_.size(), 0);
  for (const auto& c : block.couplings) {
    entry_of_.push_back(value_at(place[std::size_t(c.row)], place[std::size_t(c.column)]));
    is_set[std::size_t(entry_of_.back())] = 1;
  }
  for (std::size_t k = std::size_t(n); k < row_.size(); ++k)
    if (!is_set[k]) fill_.push_back(int(k));
  for (int j = 0; j < n; ++j)
    for (int e = begin_[std::size_t(j)]; e < begin_[std::size_t(j) + 1]; ++e)
      for (int g = begin_[std::size_t(j)]; g <= e; ++g) {
        const int a = row_[std::size_t(e)], b = row_[std::size_t(g)];
        target_.push_back(a == b ? a : value_at(a, b));
      }
  value_.resize(row_.size());
  solution_.resize(std::size_t(n));
}

}  // namespace ragdoll
