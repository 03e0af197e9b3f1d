#include "ragdoll/contact_list.h"

#include <algorithm>  // copy_n, max, min, sort
#include <cmath>      // abs, sqrt
#include <memory>     // make_unique_for_overwrite
#include <utility>    // move

#include "contact_kernels.h"  // measure_moves

namespace ragdoll {
namespace {

/// How much wider the skin of the outer level is than that of the middle one, relative to it; and
/// the share of the skin that has to be left for pairs to be chosen again from the outer level.
/// Both only decide how often the cells are searched; these made walks of proteins fastest.
constexpr double wider = 1.5;
constexpr double worth_choosing = 0.35;

constexpr std::size_t buckets = 32;

/// What rounding may take from a length of the size of a skin or a bound. nm
double rounding(double length) {
  return 1e-6 * (1 + std::abs(length));
}

/// What minimum images of joints far out of the box may be wrong by. nm
double image_rounding(std::span<const Vec3> positions) {
  double largest = 0;
  for (const Vec3& x : positions) largest = std::max(largest, x.cwiseAbs().maxCoeff());
  return 1e-14 * largest;
}

[[gnu::always_inline]] inline double squared_distance(std::span<const Vec3> x, int p, int q,
                                                      const Box* box) {
  Vec3 d = x[std::size_t(q)] - x[std::size_t(p)];
  if (box) d = box->minimum_image(d);
  return d.squaredNorm();
}

}  // namespace

ContactList::ContactList(const ContactRule& rule, double skin) : table_(rule), skin_(skin) {}

bool ContactList::update(std::span<const Vec3> positions, const Box* box, double reach) {
  if (!renew(positions, box, reach) && pairs_known_) return false;
  unsorted_.clear();
  for (const Spaced& pair : middle_.pairs)
    unsorted_.push_back({pair.p, pair.q, table_.bound(pair.p, pair.q)});
  sort(unsorted_, pairs_);
  pairs_known_ = true;
  return true;
}

void ContactList::find_near(std::span<const Vec3> positions, const Box* box, double reach,
                            std::vector<NearPair>& near) {
  renew(positions, box, reach);
  const std::span<const int> selected = select(middle_, reach);
  // each is written before it is known whether it stays: branches would be guessed wrongly
  unsorted_.resize(selected.size());
  std::size_t kept = 0;
  for (const int k : selected) {
    const auto [p, q, slack] = middle_.pairs[std::size_t(k)];
    const double bound = table_.bound(p, q), limit = bound + reach;
    unsorted_[kept] = {p, q, bound};
    kept += std::size_t(squared_distance(positions, p, q, box) < limit * limit);
  }
  sort(std::span(unsorted_).first(kept), near);
}

/// Chooses or searches anew if some pair closer than bound + reach could be missing from the middle
/// level. @return whether it did
bool ContactList::renew(std::span<const Vec3> positions, const Box* box, double reach) {
  if (!same_space(positions.size(), box)) {
    search(positions, box, reach);
    return true;
  }
  if (room_left(middle_, positions, box) > reach) return false;
  const double room = room_left(outer_, positions, box), wanted = std::max(skin_, reach);
  // what would have to be chosen again soon is better searched for
  if (room > reach + worth_choosing * (wanted - reach))
    choose(positions, box, std::min(room, wanted));
  else
    search(positions, box, reach);
  return true;
}

/// Whether the levels are of these joints in this box, and hold as long as joints stay near.
bool ContactList::same_space(std::size_t joints, const Box* box) const {
  if (!lasting_ || outer_.reference.size() != joints || (box != nullptr) != box_.has_value())
    return false;
  return !box || (box->a == box_->a && box->b == box_->b && box->c == box_->c);
}

/// How far beyond their bounds all pairs are listed, now that joints have moved.
double ContactList::room_left(const Level& level, std::span<const Vec3> positions, const Box* box) {
  const double lost =
      rounding(table_.largest_bound() + outer_.skin) + (box ? image_rounding(positions) : 0);
  // two joints may each have come nearer by what they moved
  most_moved_ = contact_kernels::measure_moves(positions, level.reference, moved_).sum();
  return level.skin - double(most_moved_) - lost;
}

void ContactList::search(std::span<const Vec3> positions, const Box* box, double reach) {
  ++searches_;
  box_ = box ? std::optional<Box>(*box) : std::nullopt;
  outer_.reference.assign(positions.begin(), positions.end());
  const double skin = std::max(skin_, reach);
  outer_.skin = skin + wider * skin_;
  lasting_ = true;
  if (box) {
    // up to half the box the minimum image is the nearest, and moves tell how far that has come
    const double room = std::min({box->a[0], box->b[1], box->c[2]}) / 2 - table_.largest_bound();
    lasting_ = skin <= room;
    outer_.skin = std::max(skin, std::min(outer_.skin, room));
  }

  const double largest = table_.largest_bound() + outer_.skin;
  const CellList cells(positions, largest, box);
  const std::span<const float> shares = table_.shares();
  const float farthest = float(outer_.skin + rounding(largest));
  // not kept: what many lanes hold would push each other out of the caches
  std::size_t room = outer_.pairs.size() + outer_.pairs.size() / 4 + 1000, kept = 0;
  auto found = std::make_unique_for_overwrite<Spaced[]>(room);
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) {
    candidates_.clear();
    cells.find_candidates(cell, candidates_);
    if (room < kept + candidates_.size()) {
      room = 2 * (kept + candidates_.size());
      auto more = std::make_unique_for_overwrite<Spaced[]>(room);
      std::copy_n(found.get(), kept, more.get());
      found = std::move(more);
    }
    for (const CellPair& pair : candidates_) {
      const float slack =
          pair.distance - (shares[std::size_t(pair.p)] + shares[std::size_t(pair.q)]);
      // written before it is known whether it stays: branches would be guessed wrongly
      found[kept] = {pair.p, pair.q, slack};
      kept += std::size_t((slack < farthest) & !table_.excluded(pair.p, pair.q));
    }
  }
  outer_.list({found.get(), kept});
  moved_.assign(positions.size(), 0);
  most_moved_ = 0;
  choose(positions, box, skin);
}

/// The middle level, from the outer one, since whose search the joints have moved by `moved_`.
void ContactList::choose(std::span<const Vec3> positions, const Box* box, double skin) {
  const std::span<const int> selected = select(outer_, skin);
  spaced_.resize(selected.size());
  std::size_t kept = 0;
  for (const int k : selected) {
    const auto [p, q, slack] = outer_.pairs[std::size_t(k)];
    const double bound = table_.bound(p, q), limit = bound + skin;
    const double square = squared_distance(positions, p, q, box);
    spaced_[kept] = {p, q, std::sqrt(float(square)) - float(bound)};
    kept += std::size_t((bound > 0) & (square < limit * limit));
  }
  middle_.skin = skin;
  middle_.list(std::span(spaced_).first(kept));
  middle_.reference.assign(positions.begin(), positions.end());
  pairs_known_ = false;
  std::fill(moved_.begin(), moved_.end(), 0.0F);
  most_moved_ = 0;
}

/// Those of the level's pairs that may now be closer than their bound plus the limit: first by what
/// any two joints have moved, then by what the pair's own have.
std::span<const int> ContactList::select(const Level& level, double limit) {
  const float farthest = float(limit + 2 * rounding(table_.largest_bound() + outer_.skin));
  const std::size_t count = level.bucket_end[level.bucket_of(farthest + most_moved_)];
  if (selected_.size() < count) selected_.resize(count);
  const float* const moved = moved_.data();
  std::size_t kept = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto [p, q, slack] = level.pairs[k];
    // written before it is known whether it stays: branches would be guessed wrongly
    selected_[kept] = int(k);
    kept += std::size_t(slack <= farthest + (moved[p] + moved[q]));
  }
  return {selected_.data(), kept};
}

/// By p, keeping the order of equals; then the few of each by q.
void ContactList::sort(std::span<const NearPair> pairs, std::vector<NearPair>& sorted) {
  sorted.resize(pairs.size());
  cursor_.assign(outer_.reference.size() + 1, 0);
  for (const NearPair& pair : pairs) ++cursor_[std::size_t(pair.p) + 1];
  for (std::size_t j = 0; j + 1 < cursor_.size(); ++j) cursor_[j + 1] += cursor_[j];
  for (const NearPair& pair : pairs) sorted[std::size_t(cursor_[std::size_t(pair.p)]++)] = pair;
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    auto end = begin + 1;
    while (end != sorted.end() && end->p == begin->p) ++end;
    if (end - begin > 1)
      std::sort(begin, end, [](const NearPair& a, const NearPair& b) { return a.q < b.q; });
    begin = end;
  }
}

/// Into buckets, by counting.
void ContactList::Level::list(std::span<const Spaced> unsorted) {
  bucket_end.assign(buckets + 1, 0);
  for (const Spaced& pair : unsorted) ++bucket_end[bucket_of(pair.slack) + 1];
  for (std::size_t b = 0; b < buckets; ++b) bucket_end[b + 1] += bucket_end[b];
  pairs.resize(unsorted.size());
  // each holds where its bucket begins, until that is full
  for (const Spaced& pair : unsorted) pairs[bucket_end[bucket_of(pair.slack)]++] = pair;
}

/// Pairs with a larger slack are in no earlier bucket.
std::size_t ContactList::Level::bucket_of(float slack) const {
  const float share = slack * float(double(buckets) / skin);
  // false for what is no number too
  if (!(share > 0)) return 0;
  return std::size_t(std::min(share, float(buckets - 1)));
}

}  // namespace ragdoll
