#include "ragdoll/contact_list.h"

#include <algorithm>  // sort, max

#include "ragdoll/cell_list.h"  // CellList

namespace ragdoll {

ContactList::ContactList(const ContactRule& rule, double skin) : rule_(rule), skin_(skin) {}

bool ContactList::update(std::span<const Vec3> positions, const Box* box, double reach) {
  if (still_valid(positions, box, reach)) return false;
  search(positions, box);
  return true;
}

bool ContactList::still_valid(std::span<const Vec3> positions, const Box* box, double reach) const {
  if (reference_.size() != positions.size() || (box != nullptr) != box_.has_value()) return false;
  if (box && (box->a != box_->a || box->b != box_->b || box->c != box_->c)) return false;
  // two joints may each have come nearer by the largest move
  double largest2 = 0;
  for (std::size_t j = 0; j < positions.size(); ++j)
    largest2 = std::max(largest2, (positions[j] - reference_[j]).squaredNorm());
  const double room = (skin_ - reach) / 2;
  return room > 0 && largest2 < room * room;
}

void ContactList::search(std::span<const Vec3> positions, const Box* box) {
  ++searches_;
  pairs_.clear();
  reference_.assign(positions.begin(), positions.end());
  box_ = box ? std::optional<Box>(*box) : std::nullopt;

  const CellList cells(positions, rule_.largest_bound() + skin_, box);
  std::vector<int> partners;
  auto close = rule_.close_pairs.begin();
  for (int p = 0; p < int(positions.size()); ++p) {
    if (rule_.radii[std::size_t(p)] <= 0) continue;
    partners.clear();
    cells.append_partners(p, partners);
    std::sort(partners.begin(), partners.end());
    // exclusions and close pairs are sorted too: walk the three lists together
    const int* excluded = rule_.exclusions.data() + rule_.exclusion_begin[std::size_t(p)];
    const int* excluded_end = rule_.exclusions.data() + rule_.exclusion_begin[std::size_t(p) + 1];
    while (close != rule_.close_pairs.end() && close->p < p) ++close;
    for (const int q : partners) {
      while (excluded != excluded_end && *excluded < q) ++excluded;
      if (excluded != excluded_end && *excluded == q) continue;
      while (close != rule_.close_pairs.end() && close->p == p && close->q < q) ++close;
      const bool started_closer =
          close != rule_.close_pairs.end() && close->p == p && close->q == q;
      const double bound = started_closer ? close->length : rule_.rule_bound(p, q);
      if (bound <= 0) continue;
      Vec3 d = positions[std::size_t(q)] - positions[std::size_t(p)];
      if (box) d = box->minimum_image(d);
      const double limit = bound + skin_;
      if (d.squaredNorm() < limit * limit) pairs_.push_back({p, q, bound});
    }
  }
}

}  // namespace ragdoll
