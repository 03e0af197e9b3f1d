#include "ragdoll/method_files/order_file.h"

#include "names.h"          // NameIndex, BarIndex
#include "ragdoll/error.h"  // Error
#include "text.h"           // excerpt
#include "xml_reader.h"     // XmlReader
#include "xml_writer.h"     // XmlWriter

namespace ragdoll {
namespace {

class OrderReader {
 public:
  OrderReader(const std::string& path, const Structure& structure, Warnings* warnings)
      : xml_(path, warnings), joints_(structure.ids), bars_(structure.parts.bars) {}

  OrderFile read() {
    OrderFile file;
    xml_.enter_root("order");
    const auto [version, structure, root, name] =
        xml_.attributes({"version", "structure", "root", "order"});
    xml_.check_version(version);
    if (structure) file.structure = xml_.text(structure);
    if (name) file.name = xml_.text(name);
    if (root) {
      file.root = xml_.id(root);
      find_joint(root, file.root);
    }
    while (xml_.next_child()) {
      if (xml_.name() != "bar") xml_.fail_unknown_element("bar");
      file.order.push_back(read_visit());
      xml_.end_empty();
    }
    xml_.end_file();
    return file;
  }

 private:
  int find_joint(const Attribute& attribute, std::string_view id) const {
    const int joint = joints_.find(id);
    if (joint < 0)
      xml_.fail(attribute.line,
                "the order names the joint " + excerpt(id) + ", which the structure does not have");
    return joint;
  }

  Visit read_visit() {
    const auto [joints, problem] = xml_.attributes({"joints", "problem"});
    const auto [p, q] = xml_.two_ids(joints);
    Visit visit;
    visit.near = find_joint(joints, p);
    visit.far = find_joint(joints, q);
    visit.bar = bars_.find(visit.near, visit.far);
    visit.problem = problem && xml_.flag(problem);
    if (visit.bar < 0)
      xml_.fail(joints.line,
                "the structure has no bar that joins " + excerpt(p) + " and " + excerpt(q));
    return visit;
  }

  XmlReader xml_;
  NameIndex joints_;
  BarIndex bars_;
};

void check_order(const Structure& structure, const OrderFile& file) {
  const std::vector<Bar>& bars = structure.parts.bars;
  const int joint_count = int(structure.ids.size());
  for (std::size_t k = 0; k < file.order.size(); ++k) {
    const Visit& visit = file.order[k];
    const bool known = visit.bar >= 0 && std::size_t(visit.bar) < bars.size() &&
                       std::min(visit.near, visit.far) >= 0 &&
                       std::max(visit.near, visit.far) < joint_count;
    if (!known || pair_key(bars[std::size_t(visit.bar)].p, bars[std::size_t(visit.bar)].q) !=
                      pair_key(visit.near, visit.far))
      throw Error("visit " + std::to_string(k) + " of the order is not of a bar of the structure");
  }
  if (!file.root.empty() && NameIndex(structure.ids).find(file.root) < 0)
    throw Error("the order's root, " + excerpt(file.root) + ", is no joint of the structure");
}

}  // namespace

OrderFile read_order(const std::string& path, const Structure& structure, Warnings* warnings) {
  return OrderReader(path, structure, warnings).read();
}

Order order_from_pairs(const Structure& structure, const std::vector<std::pair<int, int>>& pairs,
                       const std::vector<bool>& problem) {
  if (problem.size() != pairs.size())
    throw Error("the order has " + std::to_string(pairs.size()) + " pairs of joints, but " +
                std::to_string(problem.size()) + " marks of problem constraints");
  const BarIndex bars(structure.parts.bars);
  Order order;
  order.reserve(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [near, far] = pairs[k];
    const int bar = std::min(near, far) < 0 ? -1 : bars.find(near, far);
    if (bar < 0)
      throw Error("the structure has no bar that joins joint " + std::to_string(near) +
                  " and joint " + std::to_string(far));
    order.push_back({bar, near, far, problem[k]});
  }
  return order;
}

void write_order(const std::string& path, const Structure& structure, const OrderFile& file,
                 const WriteOptions& options) {
  check_order(structure, file);
  XmlWriter xml(path, options);
  xml.begin("order").text("version", "1");
  if (!file.structure.empty()) xml.text("structure", file.structure);
  if (!file.root.empty()) xml.text("root", file.root);
  if (!file.name.empty()) xml.text("order", file.name);
  xml.open();
  for (const Visit& visit : file.order) {
    xml.begin("bar").pair("joints", structure.ids[std::size_t(visit.near)],
                          structure.ids[std::size_t(visit.far)]);
    if (visit.problem) xml.text("problem", "true");
    xml.end();
  }
  xml.close();
  xml.commit();
}

}  // namespace ragdoll
