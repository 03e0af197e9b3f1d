#include "near_contacts.h"

#include <algorithm>  // binary_search, lower_bound, max, upper_bound
#include <cmath>      // isfinite
#include <utility>    // move

namespace ragdoll {
namespace {

/// Pairs are searched for up to their bound plus the skin, and looked at in each pass up to their
/// bound plus the reach. Both only decide how often the pairs are looked up, never the result.
constexpr double skin = 0.14;   // nm
constexpr double reach = 0.02;  // nm

/// How often a pass looks pairs up anew, each time that a joint leaves its room; a break that
/// resolves needs none or a few. After that, only each time that so many joints have left it.
constexpr int most_renewals = 64;
constexpr std::size_t most_strays = 256;

}  // namespace

template <class T>
NearContacts<T>::NearContacts(const Framework& framework, const Slack<T>& slack,
                              std::shared_ptr<ContactList> list, StridedPoints<T> looked_up_at)
    : framework_(framework), slack_(slack), list_(std::move(list)), looked_up_at_(looked_up_at) {
  static_assert(room == reach / 2);
}

template <class T>
void NearContacts<T>::begin(const Box* box) {
  box_ = box;
  scattered_ = false;
  const bool same_box =
      had_box_ == (box != nullptr) &&
      (!box || (box->a == last_box_.a && box->b == last_box_.b && box->c == last_box_.c));
  if (!same_box) known_ = false;
}

template <class T>
bool NearContacts<T>::reach_holds(StridedPoints<T> x) const {
  if (!known_) return false;
  double largest2 = 0;
  for (std::size_t j = 0; j < x.count; ++j)
    largest2 = std::max(largest2, (x.at(int(j)) - looked_up_at_.at(int(j))).squaredNorm());
  return largest2 < room * room;
}

template <class T>
bool NearContacts<T>::moved_within_room(StridedPoints<T> x, int joint) const {
  return (x.at(joint) - looked_up_at_.at(joint)).squaredNorm() < room * room;
}

template <class T>
bool NearContacts<T>::start_pass(StridedPoints<T> x, bool holds, PassTally& tally) {
  renewals_ = 0;
  scattered_ = false;
  if (holds) return true;
  for (std::size_t j = 0; j < x.count; ++j) tally.finite &= x.at(int(j)).allFinite();
  if (tally.finite) look_up(x);
  return tally.finite;
}

template <class T>
bool NearContacts<T>::visit(StridedPoints<T> x, const NearPair& pair, PassTally& tally) {
  Vec3 d = x.at(pair.q) - x.at(pair.p);
  if (box_) d = box_->minimum_image(d);
  const double lower = pair.bound - double(slack_.of(pair.bound));
  if (d.squaredNorm() > lower * lower * (1 + 1e-12)) return false;
  if (!correct(x, pair, tally)) return false;
  if (moved_within_room(x, pair.p) && moved_within_room(x, pair.q)) return false;
  if (!tally.finite) return false;
  if (renewals_++ == most_renewals) scattered_ = true;
  if (scattered_) return false;
  look_up(x);
  return true;
}

/// The rest of a pass behind a pair: those that were near, and all pairs of strays.
template <class T>
void NearContacts<T>::finish_scattered(StridedPoints<T> x, NearPair pair, PassTally& tally) {
  scattered_ = false;
  find_strays(x);
  for (pair = next_pair(pair); pair.p >= 0 && tally.finite; pair = next_pair(pair)) {
    if (!correct(x, pair, tally)) continue;
    for (const int joint : {pair.p, pair.q}) {
      const auto place = std::lower_bound(strays_.begin(), strays_.end(), joint);
      const bool strayed = place != strays_.end() && *place == joint;
      if (!strayed && !moved_within_room(x, joint)) strays_.insert(place, joint);
    }
    if (strays_.size() <= most_strays || !tally.finite) continue;
    look_up(x);
    strays_.clear();
  }
}

template <class T>
void NearContacts<T>::find_strays(StridedPoints<T> x) {
  strays_.clear();
  for (std::size_t j = 0; j < x.count; ++j)
    if (!moved_within_room(x, int(j))) strays_.push_back(int(j));
}

/// The first pair behind this one that was near or is of a stray; p is -1 where there is none.
template <class T>
NearPair NearContacts<T>::next_pair(const NearPair& pair) const {
  const ContactRule& rule = framework_.contact_rule();
  const std::size_t place = place_behind(near_, pair);
  const NearPair near = place < near_.size() ? near_[place] : NearPair{-1, -1, 0};
  const int joints = framework_.joint_count();
  int p = pair.p, q = pair.q;
  while (p < joints) {
    const bool all = std::binary_search(strays_.begin(), strays_.end(), p);
    const auto stray = std::upper_bound(strays_.begin(), strays_.end(), std::max(p, q));
    if (all)
      q = std::max(p, q) + 1;
    else
      q = stray != strays_.end() ? *stray : joints;
    if (near.p == p && near.q <= q) return near;
    if (q >= joints) {
      ++p;
      q = -1;
      continue;
    }
    if (rule.excluded(p, q) || rule.radii[std::size_t(p)] <= 0) continue;
    if (rule.radii[std::size_t(q)] <= 0) continue;
    const double bound = rule.bound(p, q);
    if (bound > 0) return {p, q, bound};
  }
  return {-1, -1, 0};
}

/// @return true if the joints moved
template <class T>
bool NearContacts<T>::correct(StridedPoints<T> x, const NearPair& pair, PassTally& tally) const {
  const Vec3 p = x.at(pair.p), q = x.at(pair.q);
  Vec3 d = q - p;
  if (box_) d = box_->minimum_image(d);
  const double distance = d.norm();
  const double error = pair.bound - distance;
  if (error <= double(slack_.of(pair.bound))) return false;
  const auto [p_share, q_share] = shares_of(framework_, pair.p, pair.q, Weighting{});
  if (p_share == 0 && q_share == 0) {
    ++tally.held;
    return false;
  }
  ++tally.corrections;
  if (!std::isfinite(distance)) tally.finite = false;
  const Vec3 unit = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
  x.set(pair.p, p - (p_share * error) * unit);
  x.set(pair.q, q + (q_share * error) * unit);
  return true;
}

/// The pairs within reach of their bounds, from the list that the skin keeps.
template <class T>
void NearContacts<T>::look_up(StridedPoints<T> x) {
  ++look_ups_;
  x.copy_to(gathered_);
  const std::int64_t searches = list_->searches();
  list_->find_near(gathered_, box_, reach, near_);
  // conformers that went apart would make each other search
  const bool apart = searches > 0 && list_->searches() != searches;
  if (apart && list_.use_count() > 1) list_ = near_contact_list(framework_);
  for (std::size_t j = 0; j < x.count; ++j) looked_up_at_.set(int(j), gathered_[j]);
  known_ = true;
  had_box_ = box_ != nullptr;
  if (box_) last_box_ = *box_;
}

template <class T>
std::span<const NearPair> NearContacts<T>::pairs(StridedPoints<T> x) {
  if (!empty() && !reach_holds(x)) look_up(x);
  return near_;
}

std::shared_ptr<ContactList> near_contact_list(const Framework& framework) {
  return std::make_shared<ContactList>(framework.contact_rule(), skin);
}

template class NearContacts<float>;
template class NearContacts<double>;

}  // namespace ragdoll
