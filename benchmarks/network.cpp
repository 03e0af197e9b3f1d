#include "network.h"

#include <algorithm>  // max
#include <cmath>      // abs, isfinite
#include <limits>     // infinity
#include <utility>    // move

#include "ragdoll/break.h"            // perturb
#include "ragdoll/build_framework.h"  // build_framework

namespace benchmark {

using ragdoll::Framework;
using ragdoll::Vec3;

Network network_of_bars(std::string name, Positions positions, std::vector<ragdoll::Bar> bars) {
  ragdoll::FrameworkParts parts;
  parts.masses.assign(positions.size(), 1.0);
  parts.bars = std::move(bars);
  return {std::move(name), std::make_shared<const Framework>(std::move(parts)),
          std::move(positions)};
}

Network network_of_bonds(const ragdoll::Molecule& molecule) {
  std::vector<ragdoll::Bar> bars;
  const Positions& x = molecule.positions();
  for (const ragdoll::Bond& bond : molecule.bonds())
    bars.push_back({bond.a, bond.b, (x[std::size_t(bond.b)] - x[std::size_t(bond.a)]).norm()});
  return network_of_bars("bonds", x, std::move(bars));
}

Network network_of_molecule(const ragdoll::Molecule& molecule, bool contacts) {
  ragdoll::FrameworkOptions options;
  options.contacts = contacts;
  return {contacts ? "contacts" : "molecule",
          std::make_shared<const Framework>(build_framework(molecule, options)),
          molecule.positions()};
}

std::vector<Positions> breaks_of(const Network& network, double deviation, int count,
                                 std::uint64_t first_step) {
  std::vector<Positions> all(std::size_t(count), network.positions);
  for (std::size_t k = 0; k < all.size(); ++k) {
    ragdoll::Random random(7, ragdoll::RandomStream::perturbation, first_step + k);
    perturb(all[k], network.framework->fixed(), ragdoll::PerturbationKind::gaussian, deviation,
            random);
  }
  return all;
}

namespace {

class Worst {
 public:
  void see(double excess) {
    worst_ =
        std::isfinite(excess) ? std::max(worst_, excess) : std::numeric_limits<double>::infinity();
  }
  double worst() const { return worst_; }

 private:
  double worst_ = 0;
};

}  // namespace

double worst_excess(const Framework& framework, const Positions& positions,
                    ragdoll::Tolerance tolerance, bool bars_alone) {
  const auto x = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  Worst worst;
  for (const ragdoll::Bar& b : framework.bars())
    worst.see(std::abs((x(b.q) - x(b.p)).norm() - b.length) / tolerance.slack(b.length));
  if (bars_alone) return worst.worst();
  for (const ragdoll::Volume& v : framework.volumes()) {
    const double volume = (x(v.b) - x(v.a)).dot((x(v.c) - x(v.a)).cross(x(v.d) - x(v.a)));
    const double excess = std::max({0.0, v.lower - volume, volume - v.upper});
    worst.see(std::isfinite(volume) ? excess / tolerance.volume_slack(v.scale) : volume);
  }
  const ragdoll::ContactRule& rule = framework.contact_rule();
  if (rule.empty()) return worst.worst();
  const double farthest = rule.largest_bound();
  for (int p = 0; p < framework.joint_count(); ++p)
    for (int q = p + 1; q < framework.joint_count(); ++q) {
      const double d = (x(q) - x(p)).norm();
      if (!(d < farthest) || rule.excluded(p, q)) continue;
      const double bound = rule.bound(p, q);
      worst.see(std::max(0.0, bound - d) / tolerance.slack(bound));
    }
  return worst.worst();
}

}  // namespace benchmark
