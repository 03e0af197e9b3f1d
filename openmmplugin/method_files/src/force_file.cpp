#include "ragdoll/method_files/force_file.h"

#include <limits>   // numeric_limits
#include <utility>  // move

#include "names.h"          // NameIndex
#include "ragdoll/error.h"  // Error
#include "text.h"           // excerpt
#include "xml_reader.h"     // XmlReader
#include "xml_writer.h"     // XmlWriter

namespace ragdoll {
namespace {

void read_root(XmlReader& xml, ForceSet& set) {
  const auto [version, structure, max_iterations, tolerance, timestep] =
      xml.attributes({"version", "structure", "max-iterations", "tolerance", "timestep"});
  xml.check_version(version);
  if (structure) set.structure = xml.text(structure);
  if (max_iterations) {
    const std::uint64_t count = xml.whole_number(max_iterations);
    if (count == 0) xml.fail(max_iterations, "which is not positive");
    if (count > std::uint64_t(std::numeric_limits<long>::max()))
      xml.fail(max_iterations, "which is too large");
    set.max_iterations = long(count);
  }
  if (tolerance) set.tolerance = xml.positive_number(tolerance);
  if (timestep) set.timestep = xml.positive_number(timestep);
}

/// `joint_of` gives the number of an id, or fails.
template <class JointOf>
ForceSet read(XmlReader& xml, JointOf joint_of) {
  ForceSet set;
  xml.enter_root("forces");
  read_root(xml, set);
  while (xml.next_child()) {
    if (xml.name() != "force") xml.fail_unknown_element("force");
    const auto [joint, x, y, z] = xml.attributes({"joint", "x", "y", "z"});
    set.forces.push_back(
        {joint_of(joint, xml.id(joint)), Vec3(xml.number(x), xml.number(y), xml.number(z))});
    xml.end_empty();
  }
  xml.end_file();
  return set;
}

void check_forces(const Structure& structure, const ForceSet& set) {
  if (set.max_iterations <= 0) throw Error("the maximum of iterations is not positive");
  if (!(set.tolerance > 0) || !(set.timestep > 0) ||
      !(set.tolerance + set.timestep <= std::numeric_limits<double>::max()))
    throw Error("the tolerance and the timestep of forces are to be positive numbers");
  for (std::size_t k = 0; k < set.forces.size(); ++k) {
    const Force& force = set.forces[k];
    if (force.joint < 0 || std::size_t(force.joint) >= structure.ids.size())
      throw Error("force " + std::to_string(k) + " acts on joint " + std::to_string(force.joint) +
                  ", but there are " + std::to_string(structure.ids.size()));
    if (!force.force.allFinite()) throw Error("force " + std::to_string(k) + " is not finite");
  }
}

}  // namespace

ForceSet read_forces(const std::string& path, const Structure& structure, Warnings* warnings) {
  XmlReader xml(path, warnings);
  const NameIndex joints(structure.ids);
  return read(xml, [&](const Attribute& attribute, std::string_view id) {
    const int joint = joints.find(id);
    if (joint < 0)
      xml.fail(attribute.line, "the force acts on the joint " + excerpt(id) +
                                   ", which the structure does not have");
    return joint;
  });
}

NamedForces read_forces(const std::string& path, Warnings* warnings) {
  XmlReader xml(path, warnings);
  NamedForces named;
  NameIndex joints;
  named.set = read(xml, [&](const Attribute&, std::string_view id) {
    if (joints.add(id)) named.ids.emplace_back(id);
    return joints.find(id);
  });
  return named;
}

void write_forces(const std::string& path, const Structure& structure, const ForceSet& set,
                  const WriteOptions& options) {
  check_forces(structure, set);
  XmlWriter xml(path, options);
  xml.begin("forces").text("version", "1");
  if (!set.structure.empty()) xml.text("structure", set.structure);
  xml.whole_number("max-iterations", std::uint64_t(set.max_iterations));
  xml.number("tolerance", set.tolerance).number("timestep", set.timestep);
  xml.open();
  for (const Force& force : set.forces) {
    xml.begin("force").text("joint", structure.ids[std::size_t(force.joint)]);
    xml.number("x", force.force[0]).number("y", force.force[1]).number("z", force.force[2]).end();
  }
  xml.close();
  xml.commit();
}

}  // namespace ragdoll
