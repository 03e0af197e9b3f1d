#include "ragdoll/contact_list.h"

#include <algorithm>  // max, min, min_element
#include <cmath>      // sqrt

#include "contact_kernels.h"  // measure_moves

namespace ragdoll {
namespace {

/// How much wider the skin of the outer level is than that of the middle one, relative to it; and
/// the share of the skin that has to be left for pairs to be chosen again from the outer level.
/// Both only decide how often the cells are searched; these made walks of proteins fastest.
constexpr double wider = 1.5;
constexpr double worth_choosing = 0.35;

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
  if (same_space(positions.size(), box)) {
    const double lost =
        rounding(table_.largest_bound() + outer_.skin) + (box ? image_rounding(positions) : 0);
    // two joints may each have come nearer by what they moved
    most_moved_ = contact_kernels::measure_moves(positions, middle_.reference, moved_).sum();
    if (double(most_moved_) + reach + lost < middle_.skin) return false;
    most_moved_ = contact_kernels::measure_moves(positions, outer_.reference, moved_).sum();
    const double room = outer_.skin - double(most_moved_) - lost, wanted = std::max(skin_, reach);
    // what would have to be chosen again soon is better searched for
    if (room > reach + worth_choosing * (wanted - reach)) {
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
  for (const int k : select(middle_, reach)) {
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
  std::size_t kept = 0;
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) {
    candidates_.clear();
    cells.find_candidates(cell, candidates_);
    if (unsorted_.size() < kept + candidates_.size())
      unsorted_.resize(2 * (kept + candidates_.size()));
    for (const CellPair& pair : candidates_) {
      const float slack =
          pair.distance - (shares[std::size_t(pair.p)] + shares[std::size_t(pair.q)]);
      // written before it is known whether it stays: branches would be guessed wrongly
      unsorted_[kept] = {pair.p, pair.q, slack};
      kept += std::size_t((slack < farthest) & !table_.excluded(pair.p, pair.q));
    }
  }
  sort_outer(positions.size(), kept);
  moved_.assign(positions.size(), 0);
  most_moved_ = 0;
  choose(positions, box, skin);
}

/// By q, then by p, each time keeping the order of equals.
void ContactList::sort_outer(std::size_t joints, std::size_t pairs) {
  const std::span<const Spaced> unsorted(unsorted_.data(), pairs);
  const auto count = [&](int Spaced::*key) {
    cursor_.assign(joints + 1, 0);
    for (const Spaced& pair : unsorted) ++cursor_[std::size_t(pair.*key) + 1];
    for (std::size_t j = 0; j < joints; ++j) cursor_[j + 1] += cursor_[j];
  };
  half_sorted_.resize(pairs);
  count(&Spaced::q);
  for (const Spaced& pair : unsorted)
    half_sorted_[std::size_t(cursor_[std::size_t(pair.q)]++)] = pair;
  outer_.joints.resize(pairs);
  outer_.slacks.resize(pairs);
  count(&Spaced::p);
  for (const auto& [p, q, slack] : half_sorted_) {
    const std::size_t place = std::size_t(cursor_[std::size_t(p)]++);
    outer_.joints[place] = {p, q};
    outer_.slacks[place] = slack;
  }
}

/// The middle level, from the outer one, since whose search the joints have moved by `moved_`.
void ContactList::choose(std::span<const Vec3> positions, const Box* box, double skin) {
  middle_.skin = skin;
  const std::span<const int> selected = select(outer_, skin);
  // each is written before it is known whether it stays: branches would be guessed wrongly
  middle_.joints.resize(selected.size());
  middle_.slacks.resize(selected.size());
  pairs_.resize(selected.size());
  std::size_t kept = 0;
  for (const int k : selected) {
    const auto [p, q] = outer_.joints[std::size_t(k)];
    const double bound = table_.bound(p, q), limit = bound + skin;
    const double square = squared_distance(positions, p, q, box);
    middle_.joints[kept] = {p, q};
    middle_.slacks[kept] = std::sqrt(float(square)) - float(bound);
    pairs_[kept] = {p, q, bound};
    kept += std::size_t((bound > 0) & (square < limit * limit));
  }
  middle_.joints.resize(kept);
  middle_.slacks.resize(kept);
  pairs_.resize(kept);
  middle_.reference.assign(positions.begin(), positions.end());
  std::fill(moved_.begin(), moved_.end(), 0.0F);
  most_moved_ = 0;
}

/// Those of the level's pairs that may now be closer than their bound plus the limit: first by what
/// any two joints have moved, then by what the pair's own have.
std::span<const int> ContactList::select(const Level& level, double limit) {
  const float farthest = float(limit + 2 * rounding(table_.largest_bound() + outer_.skin));
  if (selected_.size() < level.slacks.size()) selected_.resize(level.slacks.size());
  const std::size_t count =
      contact_kernels::select_below(level.slacks, farthest + most_moved_, selected_);
  const float* const moved = moved_.data();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const int k = selected_[i];
    const auto [p, q] = level.joints[std::size_t(k)];
    selected_[kept] = k;
    kept += std::size_t(level.slacks[std::size_t(k)] <= farthest + (moved[p] + moved[q]));
  }
  return {selected_.data(), kept};
}

}  // namespace ragdoll
