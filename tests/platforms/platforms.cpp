#include "platforms.h"

#include <algorithm>
#include <cmath>

namespace ragdoll::test {

namespace {

void loadPlugins() {
  static const bool loaded = [] {
    // CPU's library needs a processor that it knows; where it does not load, its tests are skipped
    try {
      OpenMM::Platform::loadPluginLibrary(OPENMM_PLUGINS "/libOpenMMCPU.so");
    } catch (const OpenMM::OpenMMException&) {
    }
    OpenMM::Platform::loadPluginLibrary(RAGDOLL_REFERENCE_LIBRARY);
    return true;
  }();
  (void)loaded;
}

}  // namespace

OpenMM::Platform* findPlatform(const std::string& name) {
  loadPlugins();
  for (int i = 0; i < OpenMM::Platform::getNumPlatforms(); ++i)
    if (OpenMM::Platform::getPlatform(i).getName() == name)
      return &OpenMM::Platform::getPlatform(i);
  return nullptr;
}

void OnPlatform::SetUp() {
  platform = findPlatform(GetParam());
  if (platform == nullptr) GTEST_SKIP() << "OpenMM has no " << GetParam() << " platform here.";
}

FrameworkParts chainParts(int joints) {
  FrameworkParts parts;
  parts.masses.assign(std::size_t(joints), 12.0);
  for (int joint = 1; joint < joints; ++joint)
    parts.bars.push_back({joint - 1, joint, 0.15, BarKind::bond});
  return parts;
}

std::shared_ptr<const Framework> chain(int joints) {
  return std::make_shared<const Framework>(chainParts(joints));
}

std::shared_ptr<const Framework> chainWithContacts(int joints) {
  FrameworkParts parts = chainParts(joints);
  ContactRule& rule = parts.contact_rule;
  rule.radii.assign(std::size_t(joints), 0.1);
  rule.polarity.assign(std::size_t(joints), Polarity::none);
  rule.scale = 0.85;
  rule.exclusion_begin = {0};
  for (int joint = 0; joint < joints; ++joint) {
    if (joint + 1 < joints) rule.exclusions.push_back(joint + 1);
    rule.exclusion_begin.push_back(int(rule.exclusions.size()));
  }
  return std::make_shared<const Framework>(parts);
}

Positions straight(int joints) {
  Positions positions;
  for (int joint = 0; joint < joints; ++joint) positions.emplace_back(0.15 * joint, 0, 0);
  return positions;
}

std::unique_ptr<OpenMM::System> particles(int count) {
  auto system = std::make_unique<OpenMM::System>();
  for (int i = 0; i < count; ++i) system->addParticle(12.0);
  return system;
}

double distance(const OpenMM::Vec3& a, const OpenMM::Vec3& b) {
  return std::sqrt((a - b).dot(a - b));
}

Positions positionsOf(const OpenMM::Context& context) {
  return context.getState(State::Positions).getPositions();
}

Positions velocitiesOf(const OpenMM::Context& context) {
  return context.getState(State::Velocities).getVelocities();
}

double largestViolation(const Framework& framework, const Positions& positions) {
  double largest = 0;
  for (const Bar& bar : framework.bars()) {
    const double length = distance(positions[std::size_t(bar.p)], positions[std::size_t(bar.q)]);
    largest = std::max(largest, std::abs(length - bar.length) / bar.length);
  }
  return largest;
}

}  // namespace ragdoll::test
