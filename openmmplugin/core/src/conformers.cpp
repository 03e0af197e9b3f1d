#include "ragdoll/conformers.h"

#include <algorithm>  // min
#include <cmath>      // cos, exp
#include <limits>     // infinity
#include <numbers>    // pi

#include "ragdoll/build_framework.h"  // build_framework
#include "ragdoll/error.h"            // Error
#include "ragdoll/hinge_tree.h"       // HingeTree
#include "ragdoll/random.h"           // Random
#include "ragdoll/superposition.h"    // superposed_rmsd

namespace ragdoll {
namespace {

double torsion_of(std::span<const Vec3> x, const TorsionTerm& t) {
  const auto at = [&](int i) -> const Vec3& { return x[std::size_t(i)]; };
  const Vec3 b = at(t.c) - at(t.b);
  const Vec3 m = (at(t.b) - at(t.a)).cross(b), n = b.cross(at(t.d) - at(t.c));
  return std::atan2(m.cross(n).dot(b) / b.norm(), m.dot(n));
}

}  // namespace

Conformers sample_conformers(const Molecule& molecule, std::span<const TorsionTerm> terms,
                             const ConformerSettings& settings,
                             const std::function<bool()>& keep_going) {
  if (settings.count < 1) throw Error("the number of conformers must be 1 or more");
  if (!(settings.prune_rmsd >= 0)) throw Error("the least RMSD must not be negative");
  const int natom = int(molecule.atoms().size());
  for (const TorsionTerm& t : terms)
    for (const int atom : {t.a, t.b, t.c, t.d})
      if (atom < 0 || atom >= natom) throw Error("a torsion term names an atom that is not there");
  const Framework framework = build_framework(molecule);
  const HingeTree tree(framework);
  const ContactRule& rule = framework.contact_rule();
  const auto score = [&](std::span<const Vec3> x) {
    double energy = 0;
    for (const TorsionTerm& t : terms) energy += energy_of(t, torsion_of(x, t));
    return energy;
  };
  const auto clashes = [&](std::span<const Vec3> x) {
    for (int p = 0; p < natom; ++p)
      for (int q = p + 1; q < natom; ++q)
        if (!rule.excluded(p, q) &&
            (x[std::size_t(p)] - x[std::size_t(q)]).norm() < 0.9 * rule.bound(p, q))
          return true;
    return false;
  };
  std::vector<int> heavy;
  for (int i = 0; i < natom; ++i)
    if (molecule.atoms()[std::size_t(i)].element != 1) heavy.push_back(i);

  Conformers found;
  for (std::uint64_t step = 0; step < 200 * std::uint64_t(settings.count) &&
                               int(found.positions.size()) < settings.count;
       ++step) {
    if (keep_going && !keep_going()) break;
    Random random(settings.seed, RandomStream::generate, step);
    std::vector<Vec3> x = molecule.positions();
    for (const Hinge& hinge : tree.hinges()) {
      const Vec3 origin = x[std::size_t(hinge.inner)];
      const Vec3 axis = (x[std::size_t(hinge.outer)] - origin).normalized();
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(2 * std::numbers::pi * random.uniform(), axis).toRotationMatrix();
      for (int k = hinge.first; k < hinge.last; ++k) {
        Vec3& point = x[std::size_t(tree.joints()[std::size_t(k)])];
        point = origin + turn * (point - origin);
      }
    }
    ++found.candidates;
    if (clashes(x)) {
      ++found.rejected;
      continue;
    }
    const std::vector<Vec3> mine = chosen(x, heavy);
    bool alike = false;
    if (settings.prune_rmsd > 0 && !heavy.empty())
      for (const std::vector<Vec3>& other : found.positions)
        alike = alike || superposed_rmsd(mine, chosen(other, heavy)) < settings.prune_rmsd;
    if (alike) continue;
    found.energies.push_back(score(x));
    found.positions.push_back(std::move(x));
  }
  if (int(found.positions.size()) < settings.count)
    found.reason = "only " + std::to_string(found.positions.size()) +
                   " conformers without clashes and different enough were found";
  return found;
}

}  // namespace ragdoll
