#include "ragdoll/contact_list.h"

#include <algorithm>  // max, min, min_element
#include <cmath>      // sqrt

#include "contact_kernels.h"  // measure_moves

namespace ragdoll {
namespace {

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

double squared_distance(std::span<const Vec3> x, int p, int q, const Box* box) {
  Vec3 d = x[std::size_t(q)] - x[std::size_t(p)];
  if (box) d = box->minimum_image(d);
  return d.squaredNorm();
}

}  // namespace

ContactList::ContactList(const ContactRule& rule, double skin) : table_(rule), skin_(skin) {}

bool ContactList::update(std::span<const Vec3> positions, const Box* box, double reach) {
  if (same_space(positions.size(), box)) {
    const double lost =
        rounding(table_.largest_bound() + outer_.skin) + (box ? image_rounding(positions) : 0);
    // two joints may each have come nearer by what they moved
    double apart = contact_kernels::measure_moves(positions, middle_.reference, moved_).sum();
    if (apart + reach + lost < middle_.skin) return false;
    apart = contact_kernels::measure_moves(positions, outer_.reference, moved_).sum();
    const double room = outer_.skin - apart - lost, wanted = std::max(skin_, reach);
    // what would have to be chosen again soon is better searched for
    if (room > (wanted + reach) / 2) {
      choose(positions, box, std::min(room, wanted));
      return true;
    }
  }
  search(positions, box, reach);
  return true;
}

void ContactList::find_near(std::span<const Vec3> positions, const Box* box, double reach,
                            std::vector<NearPair>& near) {
  update(positions, box, reach);
  near.clear();
  select(middle_.pairs, reach);
  for (const int k : selected_) {
    const NearPair& pair = pairs_[std::size_t(k)];
    const double limit = pair.bound + reach;
    if (squared_distance(positions, pair.p, pair.q, box) < limit * limit) near.push_back(pair);
  }
}

/// Whether the levels are of these joints in this box, and hold as long as joints stay near.
bool ContactList::same_space(std::size_t joints, const Box* box) const {
  if (!lasting_ || outer_.reference.size() != joints || (box != nullptr) != box_.has_value())
    return false;
  return !box || (box->a == box_->a && box->b == box_->b && box->c == box_->c);
}

void ContactList::search(std::span<const Vec3> positions, const Box* box, double reach) {
  ++searches_;
  box_ = box ? std::optional<Box>(*box) : std::nullopt;
  outer_.reference.assign(positions.begin(), positions.end());
  const double skin = std::max(skin_, reach);
  outer_.skin = skin + skin_;
  lasting_ = true;
  if (box) {
    // up to half the box the minimum image is the nearest, and moves tell how far that has come
    const double room = std::min({box->a[0], box->b[1], box->c[2]}) / 2 - table_.largest_bound();
    lasting_ = skin <= room;
    outer_.skin = std::max(skin, std::min(outer_.skin, room));
  }

  const double largest = table_.largest_bound() + outer_.skin;
  candidates_.clear();
  CellList(positions, largest, box).find_candidates(candidates_);
  const std::span<const float> shares = table_.shares();
  const float farthest = float(outer_.skin + rounding(largest));
  unsorted_.resize(candidates_.size());
  std::size_t kept = 0;
  for (const CellPair& pair : candidates_) {
    const float slack = pair.distance - (shares[std::size_t(pair.p)] + shares[std::size_t(pair.q)]);
    // written before it is known whether it stays: branches would be guessed wrongly
    unsorted_[kept] = {pair.p, pair.q, slack};
    kept += std::size_t(slack < farthest && !table_.excluded(pair.p, pair.q));
  }
  unsorted_.resize(kept);
  sort_outer(positions.size());
  moved_.assign(positions.size(), 0);
  choose(positions, box, skin);
}

/// By q, then by p, each time keeping the order of equals.
void ContactList::sort_outer(std::size_t joints) {
  outer_.pairs.resize(unsorted_.size());
  const auto sort = [&](const std::vector<Spaced>& from, std::vector<Spaced>& to,
                        int Spaced::*key) {
    cursor_.assign(joints + 1, 0);
    for (const Spaced& pair : from) ++cursor_[std::size_t(pair.*key) + 1];
    for (std::size_t j = 0; j < joints; ++j) cursor_[j + 1] += cursor_[j];
    for (const Spaced& pair : from) to[std::size_t(cursor_[std::size_t(pair.*key)]++)] = pair;
  };
  sort(unsorted_, outer_.pairs, &Spaced::q);
  sort(outer_.pairs, unsorted_, &Spaced::p);
  outer_.pairs.swap(unsorted_);
}

/// The middle level, from the outer one, since whose search the joints have moved by `moved_`.
void ContactList::choose(std::span<const Vec3> positions, const Box* box, double skin) {
  middle_.skin = skin;
  select(outer_.pairs, skin);
  middle_.pairs.clear();
  pairs_.clear();
  for (const int k : selected_) {
    const auto [p, q, slack] = outer_.pairs[std::size_t(k)];
    const double bound = table_.bound(p, q), limit = bound + skin;
    const double square = squared_distance(positions, p, q, box);
    if (bound <= 0 || !(square < limit * limit)) continue;
    const double distance = std::sqrt(square);
    middle_.pairs.push_back({p, q, float(distance - bound)});
    pairs_.push_back({p, q, bound});
  }
  middle_.reference.assign(positions.begin(), positions.end());
  std::fill(moved_.begin(), moved_.end(), 0.0F);
}

/// Those of the pairs that may now be closer than their bound plus the limit.
void ContactList::select(const std::vector<Spaced>& pairs, double limit) {
  const float farthest = float(limit + 2 * rounding(table_.largest_bound() + outer_.skin));
  selected_.resize(pairs.size());
  const float* const moved = moved_.data();
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Spaced& pair = pairs[k];
    selected_[kept] = int(k);
    kept += std::size_t(pair.slack <= farthest + moved[pair.p] + moved[pair.q]);
  }
  selected_.resize(kept);
}

}  // namespace ragdoll
