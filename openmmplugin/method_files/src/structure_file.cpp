#include "ragdoll/method_files/structure_file.h"

#include <algorithm>  // sort
#include <limits>     // quiet_NaN

#include "names.h"          // NameIndex, check_class, check_structure
#include "numbers.h"        // text_of
#include "ragdoll/error.h"  // Error
#include "text.h"           // excerpt
#include "xml_reader.h"     // XmlReader
#include "xml_writer.h"     // XmlWriter

namespace ragdoll {
namespace {

constexpr double kPresentDistance = std::numeric_limits<double>::quiet_NaN();

/// An end of a pair whose joint comes later in the file, if at all.
struct OpenEnd {
  std::size_t pair;
  bool second;
  std::string_view id;
};

/// Bars, tethers or contacts while they are read.
template <class Pair>
struct PairList {
  const char* kind;
  std::vector<Pair>& pairs;
  std::vector<long> lines = {};  ///< (npair)
  std::vector<OpenEnd> open_ends = {};
};

class StructureReader {
 public:
  StructureReader(const std::string& path, Warnings* warnings) : xml_(path, warnings) {}

  Structure read() {
    xml_.enter_root("structure");
    const long root_line = xml_.line();
    read_root();
    while (xml_.next_child()) {
      if (xml_.name() == "joint")
        read_joint();
      else if (xml_.name() == "bar")
        read_pair(bars_);
      else if (xml_.name() == "tether")
        read_pair(tethers_);
      else if (xml_.name() == "contact")
        read_pair(contacts_);
      else
        xml_.fail_unknown_element("joint, bar, tether and contact");
      xml_.end_empty();
    }
    xml_.end_file();
    if (joints_.count() == 0) xml_.fail(root_line, "the structure has no joints");

    // what takes all joints to be known
    finish(bars_);
    finish(tethers_);
    finish(contacts_);
    try {
      check_class(structure_.class_name, joints_.count(), structure_.parts.bars);
    } catch (const Error& error) {
      xml_.fail(class_line_, error.what());
    }
    return std::move(structure_);
  }

 private:
  void read_root() {
    const auto [version, unit, class_name] = xml_.attributes({"version", "length-unit", "class"});
    xml_.check_version(version);
    if (unit) structure_.length_unit = xml_.text(unit);
    if (class_name) structure_.class_name = xml_.text(class_name);
    class_line_ = class_name.line;
  }

  void read_joint() {
    const auto [id, x, y, z, mass, fixed] = xml_.attributes({"id", "x", "y", "z", "mass", "fixed"});
    const std::string_view name = xml_.id(id);
    if (!joints_.add(name)) xml_.fail(id, "which another joint has already");
    structure_.ids.emplace_back(name);
    structure_.positions.emplace_back(xml_.number(x), xml_.number(y), xml_.number(z));
    structure_.parts.masses.push_back(mass ? xml_.number(mass) : 1);
    if (structure_.parts.masses.back() < 0) xml_.fail(mass, "which is negative");
    structure_.parts.fixed.push_back(fixed && xml_.flag(fixed));
  }

  template <class Pair>
  void read_pair(PairList<Pair>& list) {
    const auto [joints, length] = xml_.attributes({"joints", "length"});
    const auto [p, q] = xml_.two_ids(joints);
    if (p == q)
      xml_.fail(joints.line,
                std::string("the ") + list.kind + " joins " + excerpt(p) + " to itself");

    // only a bar's length is optional
    Pair pair;
    const bool present = !length && &list.lines == &bars_.lines;
    pair.length = present ? kPresentDistance : xml_.positive_number(length);
    const std::size_t index = list.pairs.size();
    pair.p = joints_.find(p);
    pair.q = joints_.find(q);
    if (pair.p < 0) list.open_ends.push_back({index, false, p});
    if (pair.q < 0) list.open_ends.push_back({index, true, q});
    list.pairs.push_back(pair);
    list.lines.push_back(joints.line);
  }

  template <class Pair>
  void finish(PairList<Pair>& list) {
    for (const OpenEnd& end : list.open_ends) {
      const int joint = joints_.find(end.id);
      if (joint < 0)
        xml_.fail(list.lines[end.pair], std::string("the ") + list.kind + " names the joint " +
                                            excerpt(end.id) +
                                            ", which the structure does not have");
      Pair& pair = list.pairs[end.pair];
      (end.second ? pair.q : pair.p) = joint;
    }
    refuse_repeated(list);
    for (std::size_t k = 0; k < list.pairs.size(); ++k) take_present_distance(list, k);
  }

  template <class Pair>
  void refuse_repeated(const PairList<Pair>& list) const {
    struct Entry {
      std::uint64_t pair;
      std::size_t index;
    };
    std::vector<Entry> entries;
    entries.reserve(list.pairs.size());
    for (std::size_t k = 0; k < list.pairs.size(); ++k)
      entries.push_back({pair_key(list.pairs[k].p, list.pairs[k].q), k});
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.pair != b.pair ? a.pair < b.pair : a.index < b.index;
    });

    // the one that comes first in the file
    std::size_t repeated = list.pairs.size();
    for (std::size_t k = 1; k < entries.size(); ++k)
      if (entries[k].pair == entries[k - 1].pair) repeated = std::min(repeated, entries[k].index);
    if (repeated == list.pairs.size()) return;
    xml_.fail(list.lines[repeated],
              std::string("a second ") + list.kind + " joins " + names_of(list.pairs[repeated]));
  }

  template <class Pair>
  void take_present_distance(PairList<Pair>& list, std::size_t k) const {
    Pair& pair = list.pairs[k];
    if (pair.length == pair.length) return;
    const auto& x = structure_.positions;
    pair.length = (x[std::size_t(pair.q)] - x[std::size_t(pair.p)]).norm();
    if (!(pair.length > 0) || pair.length > std::numeric_limits<double>::max())
      xml_.fail(list.lines[k], std::string("the ") + list.kind + " that joins " + names_of(pair) +
                                   " states no length, and its joints are " +
                                   (pair.length > 0 ? "too far apart" : "at one place"));
  }

  template <class Pair>
  std::string names_of(const Pair& pair) const {
    return excerpt(structure_.ids[std::size_t(pair.p)]) + " and " +
           excerpt(structure_.ids[std::size_t(pair.q)]);
  }

  XmlReader xml_;
  Structure structure_ = {};
  NameIndex joints_;
  PairList<Bar> bars_{"bar", structure_.parts.bars};
  PairList<Tether> tethers_{"tether", structure_.parts.tethers};
  PairList<Contact> contacts_{"contact", structure_.parts.contacts};
  long class_line_ = 0;
};

template <class Pair>
void write_pairs(XmlWriter& xml, const char* kind, const std::vector<Pair>& pairs,
                 const std::vector<std::string>& ids) {
  for (const Pair& pair : pairs)
    xml.begin(kind)
        .pair("joints", ids[std::size_t(pair.p)], ids[std::size_t(pair.q)])
        .number("length", pair.length)
        .end();
}

}  // namespace

Structure read_structure(const std::string& path, Warnings* warnings) {
  return StructureReader(path, warnings).read();
}

void write_structure(const std::string& path, const Structure& structure,
                     const WriteOptions& options) {
  check_structure(structure);
  const FrameworkParts& parts = structure.parts;
  XmlWriter xml(path, options);
  xml.begin("structure").text("version", "1").text("length-unit", structure.length_unit);
  if (!structure.class_name.empty()) xml.text("class", structure.class_name);
  xml.open();
  for (std::size_t j = 0; j < structure.ids.size(); ++j) {
    const Vec3& x = structure.positions[j];
    xml.begin("joint").text("id", structure.ids[j]);
    xml.number("x", x[0]).number("y", x[1]).number("z", x[2]);
    if (parts.masses[j] != 1) xml.number("mass", parts.masses[j]);
    if (!parts.fixed.empty() && parts.fixed[j]) xml.text("fixed", "true");
    xml.end();
  }
  write_pairs(xml, "bar", parts.bars, structure.ids);
  write_pairs(xml, "tether", parts.tethers, structure.ids);
  write_pairs(xml, "contact", parts.contacts, structure.ids);
  xml.close();
  xml.commit();
}

}  // namespace ragdoll
