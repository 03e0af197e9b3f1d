#include "ragdoll/geometry.h"

#include <algorithm>  // max
#include <cmath>      // sqrt, abs, remainder
#include <numbers>    // pi
#include <utility>    // move

#include "constraints.h"            // volume_violation
#include "measures.h"               // angle, torsion
#include "ragdoll/contact_list.h"   // ContactList
#include "ragdoll/error.h"          // Error
#include "ragdoll/superposition.h"  // superposed_rmsd
#include "stereo.h"                 // is_inverted, is_cis

namespace ragdoll {
namespace {

constexpr double degree = degrees_per_radian;

}  // namespace

GeometryCheck::GeometryCheck(std::shared_ptr<const Framework> framework, std::vector<Vec3> start,
                             std::vector<std::array<int, 4>> omegas, const Tolerance& tolerance)
    : framework_(std::move(framework)),
      start_(std::move(start)),
      omegas_(std::move(omegas)),
      tolerance_(tolerance) {
  const Graph& bonds = framework_->bond_graph();
  if (int(start_.size()) != framework_->joint_count())
    throw Error("the input has " + std::to_string(start_.size()) + " positions, the framework " +
                std::to_string(framework_->joint_count()) + " joints");
  for (int centre = 0; centre < framework_->joint_count(); ++centre) {
    const auto links = bonds.links(centre);
    for (std::size_t i = 0; i < links.size(); ++i)
      for (std::size_t j = i + 1; j < links.size(); ++j)
        angles_.push_back({links[i].other, centre, links[j].other});
  }
  for (const auto& abc : angles_) start_angles_.push_back(angle(start_, abc));
  for (const auto& abcd : omegas_) {
    for (const int joint : abcd)
      if (joint < 0 || joint >= framework_->joint_count())
        throw Error("a torsion names joint " + std::to_string(joint) + ", which does not exist");
    start_omegas_.push_back(torsion(start_, abcd));
  }
}

void GeometryCheck::add(std::span<const Vec3> frame, const Box* box) {
  if (frame.size() != start_.size())
    throw Error("a frame has " + std::to_string(frame.size()) + " positions instead of " +
                std::to_string(start_.size()));
  ++report_.frames;
  for (const Bar& bar : framework_->bars()) {
    const double length = (frame[std::size_t(bar.q)] - frame[std::size_t(bar.p)]).norm();
    const double deviation = std::abs(length - bar.length);
    report_.bar_max = std::max(report_.bar_max, deviation);
    report_.bar_max_relative = std::max(report_.bar_max_relative, deviation / bar.length);
    if (deviation > tolerance_.slack(bar.length)) ++report_.tolerance_violations;
    if (bar.kind != BarKind::bond) continue;
    bond_squares_ += deviation * deviation;
    ++bonds_;
    report_.bond_max = std::max(report_.bond_max, deviation);
    report_.bond_max_relative = std::max(report_.bond_max_relative, deviation / bar.length);
  }
  add_bounds(frame);
  for (std::size_t k = 0; k < angles_.size(); ++k) {
    const double deviation = angle(frame, angles_[k]) - start_angles_[k];
    angle_squares_ += deviation * deviation;
  }
  for (std::size_t k = 0; k < omegas_.size(); ++k) {
    const double change = torsion(frame, omegas_[k]) - start_omegas_[k];
    const double deviation = std::abs(std::remainder(change, 2 * std::numbers::pi)) * degree;
    report_.omega_max_deviation_degree = std::max(report_.omega_max_deviation_degree, deviation);
  }
  for (std::size_t k = 0; k < framework_->volumes().size(); ++k) {
    const Volume& v = framework_->volumes()[k];
    const auto x = [&](int joint) -> const Vec3& { return frame[std::size_t(joint)]; };
    const double excess =
        volume_violation(v, signed_volume(x(v.a), x(v.b), x(v.c), x(v.d))) * v.scale;
    if (excess > tolerance_.volume_slack(v.scale)) ++report_.tolerance_violations;
    if (is_inverted(*framework_, k, frame)) ++report_.chirality_inverted;
  }
  for (const PlanarTorsion& t : framework_->planar_torsions())
    if (is_cis(frame, t) != t.cis) ++report_.planar_inverted;
  if (!framework_->contact_rule().empty()) add_contacts(frame, box);
  report_.rmsd_last = superposed_rmsd(frame, start_);
  report_.rmsd_max = std::max(report_.rmsd_max, report_.rmsd_last);
}

void GeometryCheck::add_bounds(std::span<const Vec3> frame) {
  const auto consider = [&](const auto& pair, double excess, auto& worst) {
    double& of_kind = worst[std::size_t(pair.kind)];
    of_kind = std::max(of_kind, excess);
    if (excess > tolerance_.slack(pair.length)) ++report_.tolerance_violations;
  };
  const auto distance = [&](const auto& pair) {
    return (frame[std::size_t(pair.q)] - frame[std::size_t(pair.p)]).norm();
  };
  for (const Tether& tether : framework_->tethers())
    consider(tether, distance(tether) - tether.length, report_.tether_worst);
  for (const Contact& contact : framework_->contacts())
    consider(contact, contact.length - distance(contact), report_.held_contact_worst);
}

void GeometryCheck::add_contacts(std::span<const Vec3> frame, const Box* box) {
  ContactList list(framework_->contact_rule(), 1e-9);
  list.update(frame, box, 0);
  for (const NearPair& pair : list.pairs()) {
    Vec3 d = frame[std::size_t(pair.q)] - frame[std::size_t(pair.p)];
    if (box) d = box->minimum_image(d);
    const double depth = pair.bound - d.norm();
    report_.contact_worst = std::max(report_.contact_worst, depth);
    if (depth > tolerance_.slack(pair.bound)) ++report_.contact_violations;
  }
}

GeometryReport GeometryCheck::report() const {
  GeometryReport report = report_;
  if (bonds_ > 0) report.bond_rms = std::sqrt(bond_squares_ / double(bonds_));
  const double angles = double(angles_.size()) * double(report.frames);
  if (angles > 0) report.angle_rms_degree = std::sqrt(angle_squares_ / angles) * degree;
  return report;
}

}  // namespace ragdoll
