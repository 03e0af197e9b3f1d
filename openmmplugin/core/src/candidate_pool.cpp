#include "candidate_pool.h"

#include <algorithm>  // max, upper_bound
#include <cmath>      // exp
#include <numbers>    // pi
#include <optional>

namespace ragdoll {
namespace {

constexpr double shape_temperature = 4;  ///< kJ/mol

/// Redraws before an attempt is given up: so many, and more for each part that moves.
constexpr int least_repairs = 10, repairs_each = 2;

/// So many attempts in a row are looked at together: where all clash, a pair may come a little
/// nearer from then on; where most do, so it may up to a limit.
constexpr int looked_at = 64, most_given_up = 48;
constexpr float nearer = 1.2f, nearest_of_most = 1.5f;  ///< of the energy of a clash

/// Pairs looked at for one call of fill(); a few seconds.
constexpr double work_limit = 4e9;

/// Pairs looked at before the caller is asked whether to go on; some milliseconds.
constexpr double ask_after = 1e7;

}  // namespace

struct CandidatePool::Lane {
  std::optional<Random> random;
  int repairs = 0;
  int tried = -1;          ///< part that was redrawn last
  int bin = 0, shape = 0;  ///< what it was before
  float sterics = 0;       ///< before, kJ/mol
};

CandidatePool::CandidatePool(const Molecule& molecule, const PartTree& tree,
                             const StericRule& sterics, std::vector<TorsionTable> tables,
                             std::uint64_t seed, std::vector<int> places)
    : molecule_(molecule),
      tree_(tree),
      tables_(std::move(tables)),
      plan_(molecule, tree, sterics),
      state_(plan_),
      seed_(seed) {
  std::vector<int> place(molecule.atoms().size());
  for (std::size_t k = 0; k < plan_.atoms.size(); ++k) place[std::size_t(plan_.atoms[k])] = int(k);
  for (const int atom : places) compared_.push_back(place[std::size_t(atom)]);
  for (std::size_t p = 0; p < tree.parts().size(); ++p) {
    const Part& part = tree.parts()[p];
    if (part.parent >= 0 || part.shapes.size() > 1) movable_.push_back(int(p));
    std::vector<float> chance;
    double sum = 0;
    for (const PartShape& shape : part.shapes)
      chance.push_back(float(sum += part.even ? 1 : std::exp(-shape.energy / shape_temperature)));
    for (float& c : chance) c /= float(sum);
    shape_chance_.push_back(std::move(chance));
  }
}

void CandidatePool::draw_one(Lane& lane, std::size_t l, int number) {
  const std::size_t p = std::size_t(number);
  const Part& part = tree_.parts()[p];
  if (part.parent >= 0) state_.bins[p][l] = tables_[p].draw(*lane.random);
  if (part.shapes.size() > 1) {
    const std::vector<float>& chance = shape_chance_[p];
    const float u = float(lane.random->uniform());
    const auto found = std::upper_bound(chance.begin(), chance.end(), u);
    state_.shapes[p][l] = std::min(int(found - chance.begin()), int(chance.size()) - 1);
  }
}

void CandidatePool::draw(Lane& lane, std::size_t l) {
  lane.random.emplace(seed_, RandomStream::conformers, attempts_++);
  lane.repairs = least_repairs + repairs_each * int(movable_.size());
  lane.tried = -1;
  for (const int part : movable_) draw_one(lane, l, part);
}

void CandidatePool::harvest(std::size_t l) {
  double energy = state_.sterics[l];
  for (std::size_t p = 0; p < tree_.parts().size(); ++p) {
    const Part& part = tree_.parts()[p];
    const int bin = state_.bins[p][l], shape = state_.shapes[p][l];
    if (part.parent >= 0) energy += tables_[p].energy(bin);
    energy += part.shapes[std::size_t(shape)].energy;
    bins_.push_back(std::uint16_t(bin));
    shapes_.push_back(std::uint16_t(shape));
  }
  energies_.push_back(float(energy));
  for (const int place : compared_)
    for (std::size_t k = 0; k < 3; ++k)
      places_.push_back(state_.places[3 * std::size_t(place) + k][l]);
}

bool CandidatePool::repair(Lane& lane, std::size_t l) {
  if (lane.tried >= 0 && state_.sterics[l] > lane.sterics) {
    state_.bins[std::size_t(lane.tried)][l] = lane.bin;
    state_.shapes[std::size_t(lane.tried)][l] = lane.shape;
  } else {
    lane.sterics = state_.sterics[l];
  }
  if (lane.repairs-- == 0) return false;
  // the pair that was worst before the last redraw serves as well: any bond between its ends
  const LanePair& pair = plan_.pairs[std::size_t(state_.worst_pair[l])];
  const int p = plan_.part_of[std::size_t(pair.p)], q = plan_.part_of[std::size_t(pair.q)];
  std::vector<int> between = tree_.path(p, q);
  for (const int part : {p, q})
    if (tree_.parts()[std::size_t(part)].shapes.size() > 1) between.push_back(part);
  if (between.empty()) return false;
  const int part = between[lane.random->below(between.size())];
  lane.tried = part;
  lane.bin = state_.bins[std::size_t(part)][l];
  lane.shape = state_.shapes[std::size_t(part)][l];
  draw_one(lane, l, part);
  return true;
}

bool CandidatePool::fill(std::size_t wanted, const std::function<bool()>& keep_going) {
  if (size() >= wanted) return true;
  std::array<Lane, LanePlan::lanes> lanes;
  work_ = 0;
  most_work_ = work_limit;
  const double round =
      double(LanePlan::lanes) * double(plan_.pairs.size() + 20 * plan_.atoms.size());
  for (std::size_t l = 0; l < lanes.size(); ++l) draw(lanes[l], l);
  while (true) {
    place_lanes(plan_, state_);
    work_ += round;
    for (std::size_t l = 0; l < lanes.size(); ++l) {
      if (state_.worst[l] <= worst_allowed_) {
        harvest(l);
        judge(true);
        if (size() >= wanted) return true;
        draw(lanes[l], l);
      } else if (!repair(lanes[l], l)) {
        ++rejected_;
        judge(false);
        draw(lanes[l], l);
      }
    }
    if (exhausted()) return true;
    unasked_ += round;
    if (unasked_ > ask_after) {
      unasked_ = 0;
      if (keep_going && !keep_going()) return false;
    }
  }
}

bool CandidatePool::only_shapes() const {
  return tree_.parts().size() == 1 && tree_.parts()[0].even;
}

int CandidatePool::even_shape(std::size_t k) const {
  const std::vector<Part>& parts = tree_.parts();
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (parts[p].even) return int(shapes_[k * parts.size() + p]);
  return -1;
}

void CandidatePool::fill_with_shapes() {
  const int count = int(tree_.parts()[0].shapes.size());
  for (int first = 0; first < count; first += int(LanePlan::lanes)) {
    const int used = std::min(int(LanePlan::lanes), count - first);
    for (int l = 0; l < int(LanePlan::lanes); ++l)
      state_.shapes[0][std::size_t(l)] = first + std::min(l, used - 1);
    place_lanes(plan_, state_);
    for (int l = 0; l < used; ++l) harvest(std::size_t(l));
  }
}

void CandidatePool::judge(bool accepted) {
  ++ended_;
  given_up_ += !accepted;
  if (ended_ < looked_at) return;
  const float most = nearest_of_most * float(StericRule::clash_energy);
  if (given_up_ == looked_at || (given_up_ > most_given_up && nearer * worst_allowed_ < most))
    worst_allowed_ *= nearer;
  ended_ = given_up_ = 0;
}

std::vector<Vec3> CandidatePool::positions(std::size_t k) const {
  const std::size_t nparts = tree_.parts().size();
  std::vector<double> angles;
  std::vector<int> shapes;
  for (std::size_t p = 0; p < nparts; ++p) {
    angles.push_back(bins_[k * nparts + p] * std::numbers::pi / 180);
    shapes.push_back(shapes_[k * nparts + p]);
  }
  return place_parts(tree_, molecule_.atoms().size(), angles, shapes, molecule_.positions());
}

void CandidatePool::clear() {
  energies_.clear();
  places_.clear();
  bins_.clear();
  shapes_.clear();
}

}  // namespace ragdoll
