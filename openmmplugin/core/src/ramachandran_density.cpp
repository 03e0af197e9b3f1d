#include "ragdoll/ramachandran_density.h"

#include <cmath>    // sqrt, lround
#include <string>   // to_string
#include <utility>  // move

#include "ragdoll/error.h"  // Error

namespace ragdoll {

RamachandranDensity::RamachandranDensity(std::vector<double> density, double core, double allowed)
    : density_(std::move(density)),
      side_(int(std::lround(std::sqrt(double(density_.size()))))),
      core_(core),
      allowed_(allowed) {
  if (side_ == 0 || std::size_t(side_) * std::size_t(side_) != density_.size())
    throw Error("a Ramachandran map of " + std::to_string(density_.size()) +
                " values is no square grid");
  if (!(core_ >= allowed_))
    throw Error("the core of a Ramachandran map lies within what is allowed");
}

double RamachandranDensity::density(double phi_degree, double psi_degree) const {
  const auto nearest = [this](double degree) {
    const int step = int(std::lround((degree + 180) / 360 * side_)) % side_;
    return std::size_t(step < 0 ? step + side_ : step);
  };
  return density_[nearest(psi_degree) * std::size_t(side_) + nearest(phi_degree)];
}

RamachandranRegion RamachandranDensity::region(double phi_degree, double psi_degree) const {
  const double here = density(phi_degree, psi_degree);
  if (here >= core_) return RamachandranRegion::core;
  return here >= allowed_ ? RamachandranRegion::allowed : RamachandranRegion::outlier;
}

}  // namespace ragdoll
