#include "ragdoll/symmetry.h"

#include <algorithm>  // max
#include <string>     // to_string

#include "ragdoll/error.h"  // Error

namespace ragdoll {

Symmetry::Symmetry(std::vector<std::vector<int>> copies, std::span<const Vec3> start)
    : copies_(std::move(copies)) {
  if (copies_.size() < 2) throw Error("symmetry needs two copies at least");
  std::vector<bool> taken(start.size(), false);
  for (const std::vector<int>& copy : copies_) {
    if (copy.size() != copies_.front().size() || copy.size() < 3)
      throw Error("copies must have as many joints each, three at least");
    for (const int joint : copy) {
      if (joint < 0 || joint >= int(start.size()))
        throw Error("joint " + std::to_string(joint) + " of a copy is no joint");
      if (taken[std::size_t(joint)])
        throw Error("joint " + std::to_string(joint) + " is in two copies");
      taken[std::size_t(joint)] = true;
    }
  }
  const std::vector<Vec3> first = chosen(start, copies_.front());
  moves_.emplace_back();
  for (std::size_t k = 1; k < copies_.size(); ++k)
    moves_.push_back(superposition(first, chosen(start, copies_[k])));
}

void Symmetry::carry(std::span<Vec3> positions) const {
  for (std::size_t k = 1; k < copies_.size(); ++k)
    for (std::size_t n = 0; n < copies_[k].size(); ++n)
      positions[std::size_t(copies_[k][n])] = moves_[k](positions[std::size_t(copies_.front()[n])]);
}

void Symmetry::average(std::span<Vec3> positions) const {
  for (std::size_t n = 0; n < copies_.front().size(); ++n) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < copies_.size(); ++k)
      sum += moves_[k].inverse()(positions[std::size_t(copies_[k][n])]);
    positions[std::size_t(copies_.front()[n])] = sum / double(copies_.size());
  }
  carry(positions);
}

double Symmetry::deviation(std::span<const Vec3> positions) const {
  double worst = 0;
  for (std::size_t k = 1; k < copies_.size(); ++k)
    for (std::size_t n = 0; n < copies_[k].size(); ++n) {
      const Vec3 there = moves_[k](positions[std::size_t(copies_.front()[n])]);
      worst = std::max(worst, (positions[std::size_t(copies_[k][n])] - there).norm());
    }
  return worst;
}

}  // namespace ragdoll
