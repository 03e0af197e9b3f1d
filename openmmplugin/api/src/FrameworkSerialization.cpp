#include "FrameworkSerialization.h"

#include "TextArray.h"             // writeArray, readArray
#include "ragdoll/OpenMMErrors.h"  // withOpenMMErrors

using OpenMM::SerializationNode;

namespace ragdoll {

namespace {

void writePlain(SerializationNode& node, const std::string& name, const auto& values) {
  writeArray(node, name, values, [](TextWriter& text, const auto& value) { text.add(value); });
}

void writePairs(SerializationNode& node, const std::string& name, const auto& pairs) {
  writeArray(node, name, pairs, [](TextWriter& text, const auto& pair) {
    text.add(pair.p).add(pair.q).add(pair.length);
  });
}

std::vector<double> readReals(const SerializationNode& node, const std::string& name) {
  return readArray<double>(node, name, [](TextReader& text) { return text.real(); });
}

std::vector<int> readIntegers(const SerializationNode& node, const std::string& name) {
  return readArray<int>(node, name, [](TextReader& text) { return text.integer(); });
}

template <class Pair>
std::vector<Pair> readPairs(const SerializationNode& node, const std::string& name) {
  // braces evaluate from left to right
  return readArray<Pair>(node, name, [](TextReader& text) {
    return Pair{text.integer(), text.integer(), text.real()};
  });
}

/// Beside the pairs, so that what was written without kinds is read as the user's own.
void writeKinds(SerializationNode& node, const std::string& name, const auto& pairs) {
  writeArray(node, name, pairs,
             [](TextWriter& text, const auto& pair) { text.add(int(pair.kind)); });
}

template <class Pair>
void readKinds(const SerializationNode& node, const std::string& name, std::vector<Pair>& pairs,
               int count) {
  using Kind = decltype(Pair::kind);
  const std::vector<Kind> kinds =
      readArray<Kind>(node, name, [count](TextReader& text) { return Kind(text.below(count)); });
  if (!kinds.empty() && kinds.size() != pairs.size())
    throw OpenMM::OpenMMException("The XML array " + name + " has another length than its pairs.");
  for (std::size_t k = 0; k < kinds.size(); ++k) pairs[k].kind = kinds[k];
}

void writeContactRule(const ContactRule& rule, SerializationNode& node) {
  node.setDoubleProperty("scale", rule.scale);
  node.setDoubleProperty("heavyAllowance", rule.heavy_allowance);
  node.setDoubleProperty("hydrogenAllowance", rule.hydrogen_allowance);
  writePlain(node, "Radii", rule.radii);
  writeArray(node, "Polarity", rule.polarity,
             [](TextWriter& text, Polarity polarity) { text.add(int(polarity)); });
  writePlain(node, "ExclusionBegin", rule.exclusion_begin);
  writePlain(node, "Exclusions", rule.exclusions);
  writePairs(node, "ClosePairs", rule.close_pairs);
}

ContactRule readContactRule(const SerializationNode& node) {
  ContactRule rule;
  rule.scale = node.getDoubleProperty("scale");
  rule.heavy_allowance = node.getDoubleProperty("heavyAllowance");
  rule.hydrogen_allowance = node.getDoubleProperty("hydrogenAllowance");
  rule.radii = readReals(node, "Radii");
  rule.polarity = readArray<Polarity>(node, "Polarity",
                                      [](TextReader& text) { return Polarity(text.below(3)); });
  rule.exclusion_begin = readIntegers(node, "ExclusionBegin");
  rule.exclusions = readIntegers(node, "Exclusions");
  rule.close_pairs = readPairs<ClosePair>(node, "ClosePairs");
  return rule;
}

FrameworkParts readParts(const SerializationNode& node) {
  FrameworkParts parts;
  parts.masses = readReals(node, "Masses");
  parts.fixed = readArray<std::uint8_t>(
      node, "Fixed", [](TextReader& text) { return std::uint8_t(text.below(2)); });
  parts.labels =
      readArray<std::string>(node, "Labels", [](TextReader& text) { return text.label(); });
  parts.bars = readArray<Bar>(node, "Bars", [](TextReader& text) {
    return Bar{text.integer(), text.integer(), text.real(), BarKind(text.below(bar_kind_count))};
  });
  parts.tethers = readPairs<Tether>(node, "Tethers");
  readKinds(node, "TetherKinds", parts.tethers, tether_kind_count);
  parts.contacts = readPairs<Contact>(node, "Contacts");
  readKinds(node, "ContactKinds", parts.contacts, contact_kind_count);
  parts.volumes = readArray<Volume>(node, "Volumes", [](TextReader& text) {
    return Volume{
        text.integer(), text.integer(), text.integer(), text.integer(),
        text.real(),    text.real(),    text.real(),    VolumeKind(text.below(volume_kind_count))};
  });
  parts.held_bonds = readArray<HeldBond>(node, "HeldBonds", [](TextReader& text) {
    return HeldBond{text.integer(), text.integer(), text.integer(), text.real(),
                    text.below(2) == 1};
  });
  for (const SerializationNode& child : node.getChildren())
    if (child.getName() == "ContactRule") parts.contact_rule = readContactRule(child);
  return parts;
}

}  // namespace

void writeFramework(const std::shared_ptr<const Framework>& framework, SerializationNode& parent) {
  if (!framework) return;
  SerializationNode& node = parent.createChildNode("Framework");
  node.setIntProperty("version", 1);
  const FrameworkParts& parts = framework->parts();
  writePlain(node, "Masses", parts.masses);
  writePlain(node, "Fixed", parts.fixed);
  writePlain(node, "Labels", parts.labels);
  writeArray(node, "Bars", parts.bars, [](TextWriter& text, const Bar& bar) {
    text.add(bar.p).add(bar.q).add(bar.length).add(int(bar.kind));
  });
  writePairs(node, "Tethers", parts.tethers);
  writeKinds(node, "TetherKinds", parts.tethers);
  writePairs(node, "Contacts", parts.contacts);
  writeKinds(node, "ContactKinds", parts.contacts);
  writeArray(node, "Volumes", parts.volumes, [](TextWriter& text, const Volume& volume) {
    text.add(volume.a).add(volume.b).add(volume.c).add(volume.d);
    text.add(volume.lower).add(volume.upper).add(volume.scale).add(int(volume.kind));
  });
  writeArray(node, "HeldBonds", parts.held_bonds, [](TextWriter& text, const HeldBond& bond) {
    text.add(bond.donor).add(bond.hydrogen).add(bond.acceptor).add(bond.energy);
    text.add(int(bond.salt_bridge));
  });
  if (!parts.contact_rule.empty())
    writeContactRule(parts.contact_rule, node.createChildNode("ContactRule"));
}

std::shared_ptr<const Framework> readFramework(const SerializationNode& parent) {
  for (const SerializationNode& node : parent.getChildren()) {
    if (node.getName() != "Framework") continue;
    if (node.getIntProperty("version") != 1)
      throw OpenMM::OpenMMException("Unsupported version number of a Framework");
    return withOpenMMErrors([&] { return std::make_shared<const Framework>(readParts(node)); });
  }
  return nullptr;
}

}  // namespace ragdoll
