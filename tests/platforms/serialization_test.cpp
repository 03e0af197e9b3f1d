// XML keeps all parameters and every array of the framework.

#include <chrono>
#include <cmath>
#include <limits>
#include <sstream>

#include "platforms.h"
#include "ragdoll/FrameworkForce.h"  // FrameworkForce

namespace ragdoll::test {

namespace {

template <class Object>
std::unique_ptr<Object> throughXml(const Object& object, const std::string& root) {
  std::stringstream xml;
  OpenMM::XmlSerializer::serialize(&object, root, xml);
  return std::unique_ptr<Object>(OpenMM::XmlSerializer::deserialize<Object>(xml));
}

std::shared_ptr<const Framework> everything() {
  FrameworkParts parts = chainParts(5);
  parts.masses[1] = 1.0 / 3;
  parts.fixed = {0, 1, 0, 0, 0};
  parts.labels = {"", "CA GLY45 A", "100% <&\"'>\n", "\xc3\xa4", "x"};
  parts.bars[1].kind = BarKind::angle;
  parts.bars[2].length = 0.1 + 0.2;
  parts.tethers = {{0, 3, 0.7}, {1, 4, 0.9, TetherKind::hydrogen_bond}};
  parts.contacts = {{0, 4, 1e-9}, {1, 3, 0.1, ContactKind::side_chain}};
  parts.held_bonds = {{0, 1, 4, -12.5, true}, {2, -1, 4, -1.0 / 3, false}};
  Volume volume;
  volume.a = 0, volume.b = 1, volume.c = 2, volume.d = 3;
  volume.lower = 1e-4, volume.upper = 2.0 / 3, volume.scale = 1e-3;
  volume.kind = VolumeKind::planarity;
  parts.volumes = {volume};
  parts.contact_rule.radii = {0.1, 0.2, 0.3, 0.1, 0.17};
  parts.contact_rule.polarity = {Polarity::none, Polarity::heavy, Polarity::hydrogen,
                                 Polarity::none, Polarity::none};
  parts.contact_rule.scale = 0.85;
  parts.contact_rule.heavy_allowance = 0.01;
  parts.contact_rule.hydrogen_allowance = 0.05;
  parts.contact_rule.exclusion_begin = {0, 2, 3, 3, 3, 3};
  parts.contact_rule.exclusions = {1, 2, 2};
  parts.contact_rule.close_pairs = {{0, 3, 0.11}};
  return std::make_shared<const Framework>(parts);
}

template <class Pair>
void expectSamePairs(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].p, b[i].p);
    EXPECT_EQ(a[i].q, b[i].q);
    EXPECT_EQ(a[i].length, b[i].length);
  }
}

void expectSame(const Framework& framework, const Framework& other) {
  const FrameworkParts &a = framework.parts(), &b = other.parts();
  EXPECT_EQ(a.masses, b.masses);
  EXPECT_EQ(a.fixed, b.fixed);
  EXPECT_EQ(a.labels, b.labels);
  expectSamePairs(a.bars, b.bars);
  for (std::size_t i = 0; i < a.bars.size(); ++i) EXPECT_EQ(a.bars[i].kind, b.bars[i].kind);
  expectSamePairs(a.tethers, b.tethers);
  expectSamePairs(a.contacts, b.contacts);
  for (std::size_t i = 0; i < a.tethers.size(); ++i)
    EXPECT_EQ(a.tethers[i].kind, b.tethers[i].kind);
  for (std::size_t i = 0; i < a.contacts.size(); ++i)
    EXPECT_EQ(a.contacts[i].kind, b.contacts[i].kind);
  ASSERT_EQ(a.held_bonds.size(), b.held_bonds.size());
  for (std::size_t i = 0; i < a.held_bonds.size(); ++i) {
    const HeldBond &h = a.held_bonds[i], &k = b.held_bonds[i];
    EXPECT_EQ(std::tie(h.donor, h.hydrogen, h.acceptor, h.energy, h.salt_bridge),
              std::tie(k.donor, k.hydrogen, k.acceptor, k.energy, k.salt_bridge));
  }
  ASSERT_EQ(a.volumes.size(), b.volumes.size());
  for (std::size_t i = 0; i < a.volumes.size(); ++i) {
    const Volume &v = a.volumes[i], &w = b.volumes[i];
    EXPECT_EQ(std::tie(v.a, v.b, v.c, v.d, v.lower, v.upper, v.scale, v.kind),
              std::tie(w.a, w.b, w.c, w.d, w.lower, w.upper, w.scale, w.kind));
  }
  const ContactRule &r = a.contact_rule, &s = b.contact_rule;
  EXPECT_EQ(std::tie(r.radii, r.polarity, r.scale, r.heavy_allowance, r.hydrogen_allowance,
                     r.exclusion_begin, r.exclusions),
            std::tie(s.radii, s.polarity, s.scale, s.heavy_allowance, s.hydrogen_allowance,
                     s.exclusion_begin, s.exclusions));
  expectSamePairs(r.close_pairs, s.close_pairs);
}

}  // namespace

TEST(Serialization, AnIntegratorKeepsAllItsParameters) {
  RagdollIntegrator integrator(0.1 + 0.2);
  integrator.setConstraintTolerance(1.0 / 3);
  integrator.setIntegrationForceGroups(5);
  integrator.setOrder("dfs_reverse");
  integrator.setWeighting("1/0");
  integrator.setSolver("ordered");
  integrator.setMaxIterations(17);
  integrator.setAbsoluteTolerance(0.002);
  integrator.setPrecision("single");
  integrator.setUseMassWeights(true);
  integrator.setVerletScope("all");
  integrator.setUseSystemForces(true);
  integrator.setPerturbation("ball");
  integrator.setPerturbationSize(0.03);
  integrator.setRandomNumberSeed(-4);
  integrator.setRejectUnresolved(true);
  integrator.setFramework(everything());
  const auto copy = throughXml(integrator, "Integrator");
  EXPECT_EQ(copy->getStepSize(), 0.1 + 0.2);
  EXPECT_EQ(copy->getConstraintTolerance(), 1.0 / 3);
  EXPECT_EQ(copy->getIntegrationForceGroups(), 5);
  EXPECT_EQ(copy->getOrder(), "dfs_reverse");
  EXPECT_EQ(copy->getWeighting(), "1/0");
  EXPECT_EQ(copy->getSolver(), "ordered");
  EXPECT_EQ(copy->getMaxIterations(), 17);
  EXPECT_EQ(copy->getAbsoluteTolerance(), 0.002);
  EXPECT_EQ(copy->getPrecision(), "single");
  EXPECT_TRUE(copy->getUseMassWeights());
  EXPECT_EQ(copy->getVerletScope(), "all");
  EXPECT_TRUE(copy->getUseSystemForces());
  EXPECT_EQ(copy->getPerturbation(), "ball");
  EXPECT_EQ(copy->getPerturbationSize(), 0.03);
  EXPECT_EQ(copy->getRandomNumberSeed(), -4);
  EXPECT_TRUE(copy->getRejectUnresolved());
  expectSame(*copy->getFramework(), *integrator.getFramework());
}

TEST(Serialization, AnIntegratorOfAnOlderFileHasARelativeToleranceAndDoublePrecision) {
  std::stringstream xml(R"(<Integrator type="RagdollIntegrator" version="1" stepSize="1"/>)");
  const std::unique_ptr<RagdollIntegrator> old(
      OpenMM::XmlSerializer::deserialize<RagdollIntegrator>(xml));
  EXPECT_EQ(old->getAbsoluteTolerance(), 0);
  EXPECT_FALSE(old->getResolverSettings().tolerance.absolute());
  EXPECT_EQ(old->getPrecision(), "double");
  EXPECT_FALSE(old->getUseMassWeights());
}

TEST(Serialization, AnIntegratorWithoutAFrameworkHasNoneAfterwards) {
  EXPECT_EQ(throughXml(RagdollIntegrator(0.001), "Integrator")->getFramework(), nullptr);
}

TEST(Serialization, ASystemCarriesTheFrameworkOfItsFrameworkForce) {
  auto system = particles(5);
  auto* force = new FrameworkForce(everything());
  force->setUsesPeriodicBoundaryConditions(true);
  force->setForceGroup(3);
  force->setName("bonds");
  system->addForce(force);
  const auto copy = throughXml(*system, "System");
  const auto& kept = dynamic_cast<const FrameworkForce&>(copy->getForce(0));
  EXPECT_TRUE(kept.usesPeriodicBoundaryConditions());
  EXPECT_EQ(kept.getForceGroup(), 3);
  EXPECT_EQ(kept.getName(), "bonds");
  expectSame(*kept.getFramework(), *force->getFramework());
}

TEST(Serialization, SixtyThousandJointsTakeSeconds) {
  const int joints = 60000;
  FrameworkParts parts = chainParts(joints);
  for (int span : {2, 3})
    for (int joint = span; joint < joints; ++joint)
      parts.bars.push_back({joint - span, joint, 0.123456789012345 * span, BarKind::angle});
  RagdollIntegrator integrator(0.001);
  integrator.setFramework(std::make_shared<const Framework>(parts));
  const auto start = std::chrono::steady_clock::now();
  const auto copy = throughXml(integrator, "Integrator");
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(copy->getFramework()->bars().size(), parts.bars.size());
  EXPECT_LT(seconds.count(), 10);
}

TEST(Serialization, BoundsOfAnOlderFileAreTheUsersOwn) {
  std::stringstream xml(
      R"(<Integrator type="RagdollIntegrator" version="1" stepSize="1"><Framework version="1">)"
      R"(<Masses values="1 1"/><Tethers values="0 1 2"/></Framework></Integrator>)");
  const std::unique_ptr<RagdollIntegrator> old(
      OpenMM::XmlSerializer::deserialize<RagdollIntegrator>(xml));
  ASSERT_EQ(old->getFramework()->tethers().size(), 1U);
  EXPECT_EQ(old->getFramework()->tethers()[0].kind, TetherKind::user);
}

TEST(Serialization, BrokenXmlIsRefusedInASentence) {
  for (
      const char* framework :
      {R"(<Framework version="1"><Masses values="1 x"/></Framework>)",
       R"(<Framework version="1"><Masses values="1 1"/><Bars values="0 1 0.1 9"/></Framework>)",
       R"(<Framework version="1"><Masses values="1 1"/><Bars values="0 5 0.1 0"/></Framework>)",
       R"(<Framework version="1"><Masses values="1"/><Labels values="%4"/></Framework>)",
       R"(<Framework version="1"><Masses values="1 1"/><Tethers values="0 1 1"/><TetherKinds values="1 1"/></Framework>)",
       R"(<Framework version="1"><Masses values="1 1"/><Tethers values="0 1 1"/><TetherKinds values="9"/></Framework>)",
       R"(<Framework version="9"/>)"}) {
    std::stringstream xml;
    xml << R"(<Integrator type="RagdollIntegrator" version="1" stepSize="1">)" << framework
        << "</Integrator>";
    EXPECT_THROW(OpenMM::XmlSerializer::deserialize<RagdollIntegrator>(xml),
                 OpenMM::OpenMMException)
        << framework;
  }
}

}  // namespace ragdoll::test
