#include "ragdoll/SystemFramework.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "ragdoll/OpenMMErrors.h"  // withOpenMMErrors, OpenMMException

namespace ragdoll {

namespace {

void refuseVirtualSites(const FrameworkParts& parts, const OpenMM::System& system) {
  auto refuse = [&](const char* constraint, std::initializer_list<int> joints) {
    for (int joint : joints)
      if (system.isVirtualSite(joint))
        throw OpenMM::OpenMMException("A " + std::string(constraint) + " is on particle " +
                                      std::to_string(joint) +
                                      ", which is a virtual site and cannot be held.");
  };
  for (const Bar& bar : parts.bars) refuse("bar", {bar.p, bar.q});
  for (const Tether& tether : parts.tethers) refuse("tether", {tether.p, tether.q});
  for (const Contact& contact : parts.contacts) refuse("contact", {contact.p, contact.q});
  for (const Volume& v : parts.volumes) refuse("volume", {v.a, v.b, v.c, v.d});
  for (int joint = 0; joint < int(parts.contact_rule.radii.size()); ++joint)
    if (parts.contact_rule.radii[std::size_t(joint)] > 0) refuse("contact radius", {joint});
}

void addConstraints(FrameworkParts& parts, const OpenMM::System& system) {
  if (system.getNumConstraints() == 0) return;
  std::map<std::pair<int, int>, std::size_t> barOf;
  for (std::size_t bar = 0; bar < parts.bars.size(); ++bar)
    barOf[std::minmax({parts.bars[bar].p, parts.bars[bar].q})] = bar;

  for (int constraint = 0; constraint < system.getNumConstraints(); ++constraint) {
    int p, q;
    double distance;
    system.getConstraintParameters(constraint, p, q, distance);
    auto [known, isNew] = barOf.try_emplace(std::minmax({p, q}), parts.bars.size());
    if (isNew)
      parts.bars.push_back({p, q, distance, BarKind::bond});
    else
      parts.bars[known->second].length = distance;
  }
}

}  // namespace

std::shared_ptr<const Framework> frameworkOf(const Framework& framework,
                                             const OpenMM::System& system) {
  return withOpenMMErrors([&] {
    FrameworkParts parts = framework.parts();
    parts.fixed = framework.fixed();
    for (int joint = 0; joint < framework.joint_count(); ++joint) {
      parts.masses[std::size_t(joint)] = system.getParticleMass(joint);
      if (system.getParticleMass(joint) == 0) parts.fixed[std::size_t(joint)] = 1;
    }
    addConstraints(parts, system);
    refuseVirtualSites(parts, system);
    return std::make_shared<const Framework>(std::move(parts));
  });
}

}  // namespace ragdoll
