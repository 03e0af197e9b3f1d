#include "ragdoll/method_files/results_file.h"

#include <string_view>
#include <unordered_set>

#include "ragdoll/error.h"  // Error
#include "text.h"           // excerpt
#include "xml_reader.h"     // XmlReader
#include "xml_writer.h"     // XmlWriter

namespace ragdoll {
namespace {

/// Why a path must not stand in an index; empty: it may.
std::string objection_to(std::string_view path) {
  if (path.empty()) return "which is empty";
  if (path.front() == '/') return "which is not a relative path";
  while (true) {
    const std::size_t slash = path.find('/');
    if (path.substr(0, slash) == "..") return "which leads out of the set";
    if (slash == std::string_view::npos) return "";
    path.remove_prefix(slash + 1);
  }
}

std::string read_path(const XmlReader& xml, const Attribute& attribute) {
  const std::string path = xml.text(attribute);
  if (const std::string objection = objection_to(path); !objection.empty())
    xml.fail(attribute, objection);
  return path;
}

void read_structure_entry(XmlReader& xml, ResultStructure& entry) {
  xml.enter();
  while (xml.next_child()) {
    if (xml.name() == "order") {
      const auto [path] = xml.attributes({"path"});
      if (!entry.order.empty()) xml.fail(xml.line(), "a second <order> of one structure");
      entry.order = read_path(xml, path);
    } else if (xml.name() == "forces") {
      const auto [path] = xml.attributes({"path"});
      entry.forces.push_back(read_path(xml, path));
    } else if (xml.name() == "technique") {
      const auto [folder, order, weighting] = xml.attributes({"folder", "order", "weighting"});
      ResultTechnique technique{read_path(xml, folder)};
      if (order) technique.order = xml.text(order);
      if (weighting) technique.weighting = xml.text(weighting);
      entry.techniques.push_back(std::move(technique));
    } else {
      xml.fail_unknown_element("order, forces and technique");
    }
    xml.end_empty();
  }
}

void check_results(const ResultSet& results) {
  const auto check_path = [](const std::string& path) {
    if (const std::string objection = objection_to(path); !objection.empty())
      throw Error("the results name the path \"" + excerpt(path) + "\", " + objection);
  };
  std::unordered_set<std::string_view> paths;
  for (const ResultStructure& entry : results.structures) {
    check_path(entry.structure);
    if (!paths.insert(entry.structure).second)
      throw Error("the results name the structure " + excerpt(entry.structure) + " twice");
    if (entry.class_name.empty())
      throw Error("the results name no class for the structure " + excerpt(entry.structure));
    if (!entry.order.empty()) check_path(entry.order);
    for (const std::string& path : entry.forces) check_path(path);
    for (const ResultTechnique& technique : entry.techniques) check_path(technique.folder);
  }
}

}  // namespace

ResultSet read_results(const std::string& path, Warnings* warnings) {
  XmlReader xml(path, warnings);
  ResultSet results;
  std::unordered_set<std::string> paths;
  xml.enter_root("results");
  const auto [version, seed] = xml.attributes({"version", "seed"});
  xml.check_version(version);
  results.seed = xml.whole_number(seed);
  while (xml.next_child()) {
    if (xml.name() != "structure") xml.fail_unknown_element("structure");
    const auto [class_name, file] = xml.attributes({"class", "path"});
    ResultStructure entry{xml.text(class_name), read_path(xml, file)};
    if (!paths.insert(entry.structure).second) xml.fail(file, "which is in the set already");
    read_structure_entry(xml, entry);
    results.structures.push_back(std::move(entry));
  }
  xml.end_file();
  return results;
}

void write_results(const std::string& path, const ResultSet& results, const WriteOptions& options) {
  check_results(results);
  XmlWriter xml(path, options);
  xml.begin("results").text("version", "1").whole_number("seed", results.seed).open();
  for (const ResultStructure& entry : results.structures) {
    xml.begin("structure").text("class", entry.class_name).text("path", entry.structure).open();
    if (!entry.order.empty()) xml.begin("order").text("path", entry.order).end();
    for (const std::string& forces : entry.forces) xml.begin("forces").text("path", forces).end();
    for (const ResultTechnique& technique : entry.techniques) {
      xml.begin("technique");
      if (!technique.order.empty()) xml.text("order", technique.order);
      if (!technique.weighting.empty()) xml.text("weighting", technique.weighting);
      xml.text("folder", technique.folder).end();
    }
    xml.close();
  }
  xml.close();
  xml.commit();
}

}  // namespace ragdoll
