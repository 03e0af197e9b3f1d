#include "ragdoll/backbone_guide.h"

#include <algorithm>  // clamp, sort
#include <cmath>      // abs, atan2, hypot, lround
#include <numbers>    // pi
#include <utility>    // move

namespace ragdoll {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// Outliers are led on until they are so far inside what is allowed. degree
constexpr double inside = 4;

/// IUPAC torsion of abcd. degree
double torsion(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, bc = c - b, cd = d - c;
  const Vec3 m = ab.cross(bc), n = bc.cross(cd);
  return std::atan2(bc.norm() * ab.dot(n), m.dot(n)) / degree;
}

}  // namespace

BackboneGuide::BackboneGuide(const RamachandranDensity& map, std::vector<GuidedResidue> residues,
                             std::vector<PeptidePlane> planes, double most)
    : side_(map.side()), residues_(std::move(residues)), planes_(std::move(planes)), most_(most) {
  const int side = side_;
  const double cell = 360.0 / side;
  const auto at = [&](int psi, int phi) {
    return map.region(-180 + cell * phi, -180 + cell * psi);
  };
  // the nearest cell of a region by trying all offsets, nearest first
  struct Offset {
    int phi, psi;
  };
  std::vector<Offset> offsets;
  for (int psi = -side / 2; psi < side - side / 2; ++psi)
    for (int phi = -side / 2; phi < side - side / 2; ++phi) offsets.push_back({phi, psi});
  std::sort(offsets.begin(), offsets.end(), [](const Offset& a, const Offset& b) {
    const int one = a.phi * a.phi + a.psi * a.psi, other = b.phi * b.phi + b.psi * b.psi;
    return one != other ? one < other : a.phi != b.phi ? a.phi < b.phi : a.psi < b.psi;
  });
  const auto fill = [&](std::vector<Way>& ways, auto wanted) {
    ways.resize(std::size_t(side) * std::size_t(side));
    for (int psi = 0; psi < side; ++psi)
      for (int phi = 0; phi < side; ++phi)
        for (const Offset& offset : offsets)
          if (wanted(at((psi + offset.psi + side) % side, (phi + offset.phi + side) % side))) {
            Way& way = ways[std::size_t(psi * side + phi)];
            way.phi = float(cell * offset.phi);
            way.psi = float(cell * offset.psi);
            break;
          }
  };
  fill(to_core_, [](RamachandranRegion region) { return region == RamachandranRegion::core; });
  fill(to_allowed_,
       [](RamachandranRegion region) { return region != RamachandranRegion::outlier; });
}

BackboneGuide::Way BackboneGuide::way(const GuidedResidue& residue,
                                      std::span<const Vec3> positions) const {
  const auto x = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  const double phi = torsion(x(residue.before), x(residue.n), x(residue.ca), x(residue.c));
  const double psi = torsion(x(residue.n), x(residue.ca), x(residue.c), x(residue.after));
  const auto nearest = [this](double angle) {
    const int step = int(std::lround((angle + 180) / 360 * side_)) % side_;
    return std::size_t(step < 0 ? step + side_ : step);
  };
  const std::size_t cell = nearest(psi) * std::size_t(side_) + nearest(phi);
  Way way = residue.to_core ? to_core_[cell] : to_allowed_[cell];
  const double length = std::hypot(way.phi, way.psi);
  if (length > 0) {
    const float further = float((length + inside) / length);
    way.phi *= further;
    way.psi *= further;
  }
  return way;
}

double BackboneGuide::move(std::span<Vec3> positions, double share) const {
  const double most = share * most_;
  std::vector<double> turns(planes_.size(), 0);
  for (const GuidedResidue& residue : residues_) {
    const Way own = way(residue, positions);
    // the plane before is in front of N - CA, the plane after behind CA - C
    if (residue.plane_before >= 0) turns[std::size_t(residue.plane_before)] -= own.phi * degree;
    if (residue.plane_after >= 0) turns[std::size_t(residue.plane_after)] += own.psi * degree;
  }
  double asked = 0;
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    if (turns[k] == 0) continue;
    asked += std::abs(turns[k]);
    const PeptidePlane& plane = planes_[k];
    const Vec3 origin = positions[std::size_t(plane.from)];
    const Vec3 axis = (positions[std::size_t(plane.to)] - origin).normalized();
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(std::clamp(turns[k], -most, most), axis).toRotationMatrix();
    for (const int atom : plane.atoms)
      positions[std::size_t(atom)] = origin + rotation * (positions[std::size_t(atom)] - origin);
  }
  return asked;
}

}  // namespace ragdoll
