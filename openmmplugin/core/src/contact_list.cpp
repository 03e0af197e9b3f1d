#include "ragdoll/contact_list.h"

#include <algorithm>  // copy_n, max, min, sort
#include <cmath>      // abs
#include <limits>     // infinity, max
#include <memory>     // make_unique_for_overwrite
#include <utility>    // move

#include "contact_kernels.h"  // measure_moves

namespace ragdoll {
namespace {

/// How much wider the skin of the list is than that of the chosen pairs, relative to it; and the
/// share of the skin that has to be left for pairs to be chosen again. Both only decide how often
/// the cells are searched; these made walks of proteins fastest.
constexpr double wider = 1.5;
constexpr double worth_choosing = 0.35;

constexpr std::size_t buckets = 128;

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
  const double wanted = std::max(skin_, reach);
  double skin = wanted;
  if (!same_space(positions.size(), box)) {
    search(positions, box, reach);
  } else {
    if (pairs_skin_ >= 0 && room_left(pairs_skin_, pairs_at_, positions, box) > reach) return false;
    const double room = room_left(listed_skin_, listed_at_, positions, box);
    // what would have to be chosen again soon is better searched for
    if (room > reach + worth_choosing * (wanted - reach))
      skin = std::min(room, wanted);
    else
      search(positions, box, reach);
  }
  find_listed(positions, box, skin, pairs_);
  pairs_skin_ = skin;
  pairs_at_.assign(positions.begin(), positions.end());
  return true;
}

void ContactList::find_near(std::span<const Vec3> positions, const Box* box, double reach,
                            std::vector<NearPair>& near) {
  if (!same_space(positions.size(), box) ||
      !(room_left(listed_skin_, listed_at_, positions, box) > reach))
    search(positions, box, reach);
  find_listed(positions, box, reach, near);
}

/// Whether the list is of these joints in this box, and hold as long as joints stay near.
bool ContactList::same_space(std::size_t joints, const Box* box) const {
  if (!lasting_ || listed_at_.size() != joints || (box != nullptr) != box_.has_value())
    return false;
  return !box || (box->a == box_->a && box->b == box_->b && box->c == box_->c);
}

/// How far beyond their bounds all pairs are known that were up to `skin` at the reference.
double ContactList::room_left(double skin, const std::vector<Vec3>& reference,
                              std::span<const Vec3> positions, const Box* box) {
  const double lost =
      rounding(table_.largest_bound() + listed_skin_) + (box ? image_rounding(positions) : 0);
  // two joints may each have come nearer by what they moved
  most_moved_ = contact_kernels::measure_moves(positions, reference, moved_).sum();
  return skin - double(most_moved_) - lost;
}

void ContactList::search(std::span<const Vec3> positions, const Box* box, double reach) {
  ++searches_;
  box_ = box ? std::optional<Box>(*box) : std::nullopt;
  pairs_skin_ = -1;
  listed_at_.assign(positions.begin(), positions.end());
  const double skin = std::max(skin_, reach);
  listed_skin_ = skin + wider * skin_;
  lasting_ = true;
  if (box) {
    // up to half the box the minimum image is the nearest, and moves tell how far that has come
    const double room = std::min({box->a[0], box->b[1], box->c[2]}) / 2 - table_.largest_bound();
    lasting_ = skin <= room;
    listed_skin_ = std::max(skin, std::min(listed_skin_, room));
  }

  const double largest = table_.largest_bound() + listed_skin_;
  const CellList cells(positions, largest, box);
  const std::span<const float> shares = table_.shares();
  const float farthest = float(listed_skin_ + rounding(largest));
  // not kept: what many lanes hold would push each other out of the caches
  const std::size_t before = short_.size() + long_.size();
  std::size_t room = before + before / 4 + 1000, kept = 0;
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
  if (positions.size() <= std::size_t(std::numeric_limits<std::uint16_t>::max()))
    list({found.get(), kept}, short_);
  else
    list({found.get(), kept}, long_);
  moved_.assign(positions.size(), 0);
  most_moved_ = 0;
}

/// Into buckets, by counting.
template <class Index>
void ContactList::list(std::span<const Spaced> pairs, std::vector<Ends<Index>>& listed) {
  short_.clear();
  long_.clear();
  bucket_end_.assign(buckets + 1, 0);
  for (const Spaced& pair : pairs) ++bucket_end_[bucket_of(pair.slack) + 1];
  for (std::size_t b = 0; b < buckets; ++b) bucket_end_[b + 1] += bucket_end_[b];
  listed.resize(pairs.size());
  // each holds where its bucket begins, until that is full
  for (const auto& [p, q, slack] : pairs)
    listed[bucket_end_[bucket_of(slack)]++] = {Index(p), Index(q)};
}

/// Pairs with a larger slack are in no earlier bucket.
std::size_t ContactList::bucket_of(float slack) const {
  const float share = slack * float(double(buckets) / listed_skin_);
  // false for what is no number too
  if (!(share > 0)) return 0;
  return std::size_t(std::min(share, float(buckets - 1)));
}

/// The pairs closer than bound + reach, from the list, since whose search the joints have moved by
/// `moved_`.
void ContactList::find_listed(std::span<const Vec3> positions, const Box* box, double reach,
                              std::vector<NearPair>& near) {
  const float farthest = float(reach + 2 * rounding(table_.largest_bound() + listed_skin_));
  const std::size_t count = long_.empty() ? select(short_, farthest) : select(long_, farthest);
  // each is written before it is known whether it stays: branches would be guessed wrongly
  unsorted_.resize(count);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto [p, q] = selected_[k];
    const double bound = table_.bound(p, q), limit = bound + reach;
    unsorted_[kept] = {p, q, bound};
    kept += std::size_t((bound > 0) & (squared_distance(positions, p, q, box) < limit * limit));
  }
  unsorted_.resize(kept);
  sort(near);
}

/// Those that may now be closer than their bound plus `farthest`: first by what any two joints have
/// moved, then by what the pair's own have. @return how many are in selected_
template <class Index>
std::size_t ContactList::select(const std::vector<Ends<Index>>& listed, float farthest) {
  const std::size_t last = bucket_of(farthest + most_moved_);
  if (selected_.size() < bucket_end_[last]) selected_.resize(bucket_end_[last]);
  const float* const moved = moved_.data();
  std::size_t kept = 0, k = 0;
  for (std::size_t bucket = 0; bucket <= last; ++bucket) {
    // a hair below every slack in the bucket
    const float slack = bucket == 0 ? -std::numeric_limits<float>::infinity()
                                    : float((double(bucket) - 1e-3) / buckets * listed_skin_);
    const float least = slack - farthest;
    for (; k < bucket_end_[bucket]; ++k) {
      const auto [p, q] = listed[k];
      selected_[kept] = {p, q};
      kept += std::size_t(moved[p] + moved[q] >= least);
    }
  }
  return kept;
}

/// `unsorted_`: by p, then the few of each by q.
void ContactList::sort(std::vector<NearPair>& near) {
  near.resize(unsorted_.size());
  cursor_.assign(listed_at_.size() + 1, 0);
  for (const NearPair& pair : unsorted_) ++cursor_[std::size_t(pair.p) + 1];
  for (std::size_t j = 0; j + 1 < cursor_.size(); ++j) cursor_[j + 1] += cursor_[j];
  for (const NearPair& pair : unsorted_) near[std::size_t(cursor_[std::size_t(pair.p)]++)] = pair;
  for (auto begin = near.begin(); begin != near.end();) {
    auto end = begin + 1;
    while (end != near.end() && end->p == begin->p) ++end;
    if (end - begin > 1)
      std::sort(begin, end, [](const NearPair& a, const NearPair& b) { return a.q < b.q; });
    begin = end;
  }
}

}  // namespace ragdoll
