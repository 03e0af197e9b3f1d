#include "newton_rows.h"

#include <algorithm>  // max, sort, unique
#include <array>
#include <cmath>    // abs, cbrt, isnan
#include <limits>   // infinity
#include <utility>  // move

#include "constraints.h"  // VolumeGradient, volume_violation

namespace ragdoll {
namespace {

/// Pairs of the contact rule are kept up to their bound plus the skin; a sweep looks at those up to
/// their bound plus the reach. nm
constexpr double contact_skin = 0.16;
constexpr double sweep_reach = 0.02;

/// The six pairs of the four joints of a volume.
constexpr std::array<std::pair<int, int>, 6> volume_pairs = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

std::array<int, 4> joints_of(const Volume& v) {
  return {v.a, v.b, v.c, v.d};
}

const Vec3& at(std::span<const Vec3> x, int joint) {
  return x[std::size_t(joint)];
}

template <class Pair>
Vec3 between(std::span<const Vec3> x, const Pair& pair, const Box* box = nullptr) {
  const Vec3 d = at(x, pair.q) - at(x, pair.p);
  return box ? box->minimum_image(d) : d;
}

double volume_of(std::span<const Vec3> x, const Volume& v) {
  return signed_volume(at(x, v.a), at(x, v.b), at(x, v.c), at(x, v.d));
}

/// Volume less its nearer bound; 0 within them. nm^3
double volume_excess(const Volume& v, double volume) {
  if (volume < v.lower) return volume - v.lower;
  if (volume > v.upper) return volume - v.upper;
  return 0;
}

/// What divides a volume into a length. nm^2
double area_of(const Volume& v) {
  const double edge = std::cbrt(v.scale);
  return edge * edge;
}

Vec3 unit_of(const Vec3& d, double distance) {
  return distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
}

/// Calls visit(pair, d, length, side, box) for each pair constraint: side 0 a bar, 1 an upper
/// bound, -1 a lower one.
template <class Visit>
void each_pair(const Framework& framework, Visit visit) {
  for (const Bar& bar : framework.bars()) visit(bar, 0);
  for (const Tether& tether : framework.tethers()) visit(tether, 1);
  for (const Contact& contact : framework.contacts()) visit(contact, -1);
}

}  // namespace

NewtonRows::NewtonRows(std::shared_ptr<const Framework> framework)
    : framework_(std::move(framework)), contact_list_(framework_->contact_rule(), contact_skin) {}

// === Measure

Misfit NewtonRows::measure(std::span<const Vec3> x, const Box* box) {
  Misfit misfit;
  const auto consider = [&misfit](double row, double relative) {
    misfit.energy += 0.5 * row * row;
    if (std::isnan(relative)) relative = std::numeric_limits<double>::infinity();
    misfit.residual = std::max(misfit.residual, relative);
  };
  for (const Vec3& point : x) misfit.energy += 0 * point.sum();
  each_pair(*framework_, [&](const auto& pair, int side) {
    const double row = between(x, pair).norm() - pair.length;
    if (side * row < 0) return;
    consider(row, std::abs(row) / pair.length);
  });
  for (const Volume& v : framework_->volumes()) {
    const double volume = volume_of(x, v);
    const double excess = std::isfinite(volume) ? volume_excess(v, volume) : volume - volume;
    consider(excess / area_of(v), std::isnan(excess) ? excess : volume_violation(v, volume));
  }
  // positions that are no numbers cannot be sorted into cells
  if (framework_->contact_rule().empty() || !misfit.finite()) return misfit;
  contact_list_.update(x, box, 0);
  for (const NearPair& pair : contact_list_.pairs()) {
    const Vec3 d = between(x, pair, box);
    if (d.squaredNorm() > pair.bound * pair.bound * (1 + 1e-12)) continue;
    const double row = d.norm() - pair.bound;
    if (row < 0) consider(row, -row / pair.bound);
  }
  return misfit;
}

std::vector<int> NewtonRows::violated_joints(std::span<const Vec3> x, const Box* box,
                                             double tolerance) {
  std::vector<int> joints;
  const auto take = [&](int joint) {
    if (!fixed(joint)) joints.push_back(joint);
  };
  each_pair(*framework_, [&](const auto& pair, int side) {
    const double row = between(x, pair).norm() - pair.length;
    if (side * row < 0 || std::abs(row) <= tolerance * pair.length) return;
    take(pair.p);
    take(pair.q);
  });
  for (const Volume& v : framework_->volumes())
    if (volume_violation(v, volume_of(x, v)) > tolerance)
      for (const int joint : joints_of(v)) take(joint);
  find_active_pairs(x, box);
  for (const NearPair& pair : active_) {
    if (between(x, pair, box).norm() >= pair.bound * (1 - tolerance)) continue;
    take(pair.p);
    take(pair.q);
  }
  std::sort(joints.begin(), joints.end());
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
  return joints;
}

// === Matrix

/// The pattern of what stays: bars, tethers, contacts of the framework, volumes.
void NewtonRows::prepare_matrix() {
  std::vector<std::pair<int, int>> pairs;
  each_pair(*framework_, [&](const auto& pair, int) { pairs.emplace_back(pair.p, pair.q); });
  for (const Volume& v : framework_->volumes())
    for (const auto& [i, j] : volume_pairs)
      pairs.emplace_back(joints_of(v)[std::size_t(i)], joints_of(v)[std::size_t(j)]);
  std::vector<std::pair<int, int>> free_pairs;
  for (const auto& [p, q] : pairs)
    if (!fixed(p) && !fixed(q) && p != q) free_pairs.emplace_back(p, q);
  matrix_ = std::make_unique<BlockFactor>(framework_->joint_count(), free_pairs);
  for (const auto& [p, q] : pairs)
    places_.push_back(fixed(p) || fixed(q) || p == q ? -1 : matrix_->place_of(p, q));
}

void NewtonRows::find_active_pairs(std::span<const Vec3> x, const Box* box) {
  active_.clear();
  active_pairs_.clear();
  if (framework_->contact_rule().empty()) return;
  contact_list_.update(x, box, 0);
  for (const NearPair& pair : contact_list_.pairs()) {
    const Vec3 d = between(x, pair, box);
    if (d.squaredNorm() >= pair.bound * pair.bound) continue;
    active_.push_back(pair);
    if (!fixed(pair.p) && !fixed(pair.q)) active_pairs_.emplace_back(pair.p, pair.q);
  }
}

void NewtonRows::assemble(std::span<const Vec3> x, const Box* box, std::vector<Vec3>& right) {
  if (!matrix_) prepare_matrix();
  find_active_pairs(x, box);
  if (active_pairs_ != former_pairs_) {
    matrix_->set_extra_pairs(active_pairs_);
    former_pairs_ = active_pairs_;
  }
  matrix_->clear();
  right.assign(x.size(), Vec3::Zero());
  const auto add_end = [&](int joint, const Vec3& gradient, double row, double turn = 0) {
    if (fixed(joint)) return;
    matrix_->add_diagonal(joint, gradient, turn);
    right[std::size_t(joint)] -= row * gradient;
  };

  std::size_t k = 0;
  each_pair(*framework_, [&](const auto& pair, int side) {
    const int place = places_[k++];
    const Vec3 d = between(x, pair);
    const double distance = d.norm(), row = distance - pair.length;
    if (side * row < 0) return;
    const Vec3 u = unit_of(d, distance);
    // a stretched pair resists turning too; what a short one gains by it is left out
    const double turn = row > 0 ? row / distance : 0;
    if (place >= 0) matrix_->add_spring(place, u, turn);
    add_end(pair.q, u, row, turn);
    add_end(pair.p, -u, row, turn);
  });
  for (const Volume& v : framework_->volumes()) {
    const std::size_t first = k;
    k += volume_pairs.size();
    const double excess = volume_excess(v, volume_of(x, v));
    if (excess == 0) continue;
    const double area = area_of(v);
    const VolumeGradient gradient(at(x, v.a), at(x, v.b), at(x, v.c), at(x, v.d));
    const std::array<Vec3, 4> g = {gradient.a / area, gradient.b / area, gradient.c / area,
                                   gradient.d / area};
    const std::array<int, 4> joints = joints_of(v);
    for (std::size_t e = 0; e < volume_pairs.size(); ++e) {
      const std::size_t i = std::size_t(volume_pairs[e].first);
      const std::size_t j = std::size_t(volume_pairs[e].second);
      if (places_[first + e] >= 0)
        matrix_->add(places_[first + e], joints[i], joints[j], g[i], g[j], 1);
    }
    for (std::size_t i = 0; i < 4; ++i) add_end(joints[i], g[i], excess / area);
  }
  std::size_t extra = 0;
  for (const NearPair& pair : active_) {
    const Vec3 d = between(x, pair, box);
    const double distance = d.norm();
    const Vec3 u = unit_of(d, distance);
    if (!fixed(pair.p) && !fixed(pair.q)) matrix_->add_extra(extra++, u, u, -1);
    add_end(pair.q, u, distance - pair.bound);
    add_end(pair.p, -u, distance - pair.bound);
  }
}

// === Sweep

void NewtonRows::sweep(std::span<Vec3> x, const Box* box, double tolerance) {
  const auto correct = [&](const auto& pair, double length, int side, const Box* image) {
    const Vec3 d = between(x, pair, image);
    const double distance = d.norm(), row = distance - length;
    if (side * row < 0 || std::abs(row) <= tolerance * length) return;
    const bool p_fixed = fixed(pair.p), q_fixed = fixed(pair.q);
    const Vec3 move = row * unit_of(d, distance);
    if (!p_fixed) x[std::size_t(pair.p)] += (q_fixed ? 1 : 0.5) * move;
    if (!q_fixed) x[std::size_t(pair.q)] -= (p_fixed ? 1 : 0.5) * move;
  };
  each_pair(*framework_,
            [&](const auto& pair, int side) { correct(pair, pair.length, side, nullptr); });
  // positions that are no numbers cannot be sorted into cells
  double sum = 0;
  for (const Vec3& point : x) sum += point.squaredNorm();
  if (!std::isfinite(sum)) return;
  if (!framework_->contact_rule().empty()) {
    contact_list_.update(x, box, sweep_reach);
    std::vector<NearPair> near;
    for (const NearPair& pair : contact_list_.pairs()) {
      const double limit = pair.bound + sweep_reach;
      if (between(x, pair, box).squaredNorm() < limit * limit) near.push_back(pair);
    }
    for (const NearPair& pair : near) correct(pair, pair.bound, -1, box);
  }
  for (const Volume& volume : framework_->volumes()) sweep_volume(volume, x, tolerance);
}

/// To its nearer bound along its gradient.
void NewtonRows::sweep_volume(const Volume& v, std::span<Vec3> x, double tolerance) const {
  const double volume = volume_of(x, v);
  if (!(volume_violation(v, volume) > tolerance)) return;
  const VolumeGradient gradient(at(x, v.a), at(x, v.b), at(x, v.c), at(x, v.d));
  const std::array<Vec3, 4> g = {gradient.a, gradient.b, gradient.c, gradient.d};
  const std::array<int, 4> joints = joints_of(v);
  double square = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (!fixed(joints[i])) square += g[i].squaredNorm();
  // no direction changes the volume: all fixed, or all joints on a line
  if (!(square > 0)) return;
  const double step = -volume_excess(v, volume) / square;
  for (std::size_t i = 0; i < 4; ++i)
    if (!fixed(joints[i])) x[std::size_t(joints[i])] += step * g[i];
}

}  // namespace ragdoll
