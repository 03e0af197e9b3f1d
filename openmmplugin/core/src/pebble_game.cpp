#include "pebble_game.h"

#include <algorithm>  // count, find, find_if
#include <utility>    // exchange, swap

namespace ragdoll {

PebbleGame::PebbleGame(int bodies)
    : pebbles_(std::size_t(bodies)),
      sets_(bodies),
      mark_(std::size_t(bodies), 0),
      from_(std::size_t(bodies), -1),
      ring_(std::size_t(bodies), -1) {
  for (auto& own : pebbles_) own.fill(free_pebble);
}

int PebbleGame::free_count(int body) const {
  const auto& own = pebbles_[std::size_t(body)];
  return int(std::count(own.begin(), own.end(), free_pebble));
}

int PebbleGame::free_slot(int body) const {
  const auto& own = pebbles_[std::size_t(body)];
  const auto slot = std::find(own.begin(), own.end(), free_pebble);
  return slot == own.end() ? -1 : int(slot - own.begin());
}

int PebbleGame::add(int a, int b, int bars) {
  link(a, b);
  link(b, a);
  for (int done = 0; done < bars; ++done) {
    const int u = representative(a), v = representative(b);
    if (u == v) return done;
    gather(u);
    if (!search(v, u)) {
      merge_visited(u);
      return done;
    }
    carry(v, queue_.back());
    // v has a pebble beside the six of u: the bar is independent, and v pays
    pebbles_[std::size_t(v)][std::size_t(free_slot(v))] = a;
  }
  return bars;
}

bool PebbleGame::join_if_rigid(int a, int b) {
  const int u = representative(a), v = representative(b);
  if (u == v) return true;
  if (free_count(u) + free_count(v) > pebbles_each) return false;
  gather(u);
  if (search(v, u)) return false;
  merge_visited(u);
  return true;
}

std::vector<int> PebbleGame::rigid_set(int a, int b) {
  const int u = representative(a), v = representative(b);
  if (u == v) return {u};
  gather(u);
  if (search(v, u)) return {};
  std::vector<int> set = queue_;
  set.push_back(u);
  return set;
}

void PebbleGame::settle(int body) {
  int home = representative(body);
  gather(home);
  // Bodies beside the set are tried in turn. Once one can move against it, later merges do not
  // change that: no way to its free pebble leads through what is merged.
  std::vector<int> ends, outside;
  list_ends(home, ends);
  while (!ends.empty()) {
    const int end = ends.back();
    ends.pop_back();
    const int neighbour = representative(ends_[std::size_t(end)].other);
    if (neighbour == home) continue;
    if (search(neighbour, home)) {
      outside.push_back(end);
      continue;
    }
    for (const int visited : queue_) list_ends(visited, ends);
    home = merge_visited(home);
  }
  // bonds within the set are of no use any more
  int& ring = ring_[std::size_t(home)];
  ring = -1;
  for (const int end : outside)
    if (representative(ends_[std::size_t(end)].other) != home) put_into(ring, end);
}

/// Appends the ends of all bonds that meet a body.
void PebbleGame::list_ends(int body, std::vector<int>& list) const {
  const int first = ring_[std::size_t(body)];
  for (int end = first; end >= 0;) {
    list.push_back(end);
    end = ends_[std::size_t(end)].next;
    if (end == first) break;
  }
}

/// Brings all six pebbles of a body home; that can always be done.
void PebbleGame::gather(int body) {
  while (free_count(body) < pebbles_each) {
    // its own free pebbles stay where they are: look past it
    ++search_;
    mark_[std::size_t(body)] = search_;
    queue_.clear();
    bool found = false;
    const auto see = [&](int whence) {
      for (const int target : pebbles_[std::size_t(whence)]) {
        if (target == free_pebble) continue;
        const int next = representative(target);
        if (mark_[std::size_t(next)] == search_) continue;
        mark_[std::size_t(next)] = search_;
        from_[std::size_t(next)] = whence;
        queue_.push_back(next);
        if (free_slot(next) >= 0) {
          found = true;
          return;
        }
      }
    };
    see(body);
    for (std::size_t head = 0; !found && head < queue_.size(); ++head) see(queue_[head]);
    visits_ += long(queue_.size());
    carry(body, queue_.back());
  }
}

/// Breadth first from a body along the arrows to one with a free pebble, not through `held`. The
/// bodies seen are in queue_, the one with the pebble last.
bool PebbleGame::search(int start, int held) {
  ++search_;
  mark_[std::size_t(held)] = search_;
  mark_[std::size_t(start)] = search_;
  from_[std::size_t(start)] = -1;
  queue_.assign(1, start);
  if (free_slot(start) >= 0) return true;
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const int body = queue_[head];
    for (const int target : pebbles_[std::size_t(body)]) {
      const int next = representative(target);
      if (mark_[std::size_t(next)] == search_) continue;
      mark_[std::size_t(next)] = search_;
      from_[std::size_t(next)] = body;
      queue_.push_back(next);
      if (free_slot(next) >= 0) {
        visits_ += long(queue_.size());
        return true;
      }
    }
  }
  visits_ += long(queue_.size());
  return false;
}

/// Turns the arrows from `start` to `end` round, so that the free pebble of `end` is at `start`.
void PebbleGame::carry(int start, int end) {
  for (int body = end; body != start;) {
    const int before = from_[std::size_t(body)];
    auto& paid = pebbles_[std::size_t(before)];
    const auto arrow = std::find_if(paid.begin(), paid.end(), [&](int target) {
      return target != free_pebble && representative(target) == body;
    });
    pebbles_[std::size_t(body)][std::size_t(free_slot(body))] = before;
    *arrow = free_pebble;
    body = before;
  }
}

/// Makes one body of those in queue_ and the one that holds all free pebbles of theirs.
int PebbleGame::merge_visited(int held) {
  int home = held;
  int ring = ring_[std::size_t(held)];
  for (const int body : queue_) {
    merges_.emplace_back(held, body);
    const int other = ring_[std::size_t(body)];
    if (ring < 0)
      ring = other;
    else if (other >= 0)
      std::swap(ends_[std::size_t(ring)].next, ends_[std::size_t(other)].next);
    home = sets_.join(home, body);
  }
  ring_[std::size_t(home)] = ring;
  pebbles_[std::size_t(home)].fill(free_pebble);
  return home;
}

/// Adds the end of a bond to the ring of its body.
void PebbleGame::link(int body, int other) {
  ends_.push_back({other, -1});
  put_into(ring_[std::size_t(representative(body))], int(ends_.size()) - 1);
}

void PebbleGame::put_into(int& ring, int end) {
  int& next = ends_[std::size_t(end)].next;
  if (ring < 0)
    ring = next = end;
  else
    next = std::exchange(ends_[std::size_t(ring)].next, end);
}

}  // namespace ragdoll
