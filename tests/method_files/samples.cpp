#include "samples.h"

#include <stdlib.h>  // mkdtemp

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace ragdoll {

Folder::Folder() {
  std::string name = (std::filesystem::temp_directory_path() / "ragdoll.XXXXXX").string();
  if (mkdtemp(name.data())) path_ = name;
}

Folder::~Folder() {
  std::filesystem::remove_all(path_);
}

std::string Folder::write(const std::string& name, const std::string& text) const {
  std::ofstream(path_ / name, std::ios::binary) << text;
  return *this / name;
}

std::vector<std::string> Folder::names() const {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    found.push_back(entry.path().filename().string());
  std::sort(found.begin(), found.end());
  return found;
}

std::string text_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string in_structure(const std::string& lines, const std::string& attributes) {
  return "<structure version=\"1\" length-unit=\"none\"" + attributes + ">\n" + lines +
         "\n</structure>\n";
}

std::string square_text() {
  return in_structure(R"(<joint id="a" x="0" y="0" z="0"/>
<joint id="b" x="1" y="0" z="0"/>
<joint id="c" x="1" y="1" z="0"/>
<joint id="d" x="0" y="1" z="0"/>
<bar joints="a b"/>
<bar joints="b c"/>
<bar joints="c d"/>
<bar joints="d a"/>)",
                      " class=\"1-cycle\"");
}

Structure square() {
  Structure structure;
  structure.ids = {"a", "b", "c", "d"};
  structure.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
  structure.parts.masses = {1, 1, 1, 1};
  structure.parts.fixed = {0, 0, 0, 0};
  structure.parts.bars = {{0, 1, 1}, {1, 2, 1}, {2, 3, 1}, {3, 0, 1}};
  structure.class_name = "1-cycle";
  return structure;
}

std::string fingerprint(const Structure& structure) {
  std::string text = structure.length_unit + " " + structure.class_name + "\n";
  const auto add = [&](double value) {
    char hexadecimal[64];
    std::snprintf(hexadecimal, sizeof hexadecimal, " %a", value);
    text += hexadecimal;
  };
  for (std::size_t j = 0; j < structure.ids.size(); ++j) {
    text += structure.ids[j];
    for (int k = 0; k < 3; ++k) add(structure.positions[j][k]);
    add(structure.parts.masses[j]);
    text += structure.parts.fixed[j] ? " fixed\n" : "\n";
  }
  const auto add_pairs = [&](const char* kind, const auto& pairs) {
    for (const auto& pair : pairs) {
      text += std::string(kind) + " " + std::to_string(pair.p) + " " + std::to_string(pair.q);
      add(pair.length);
      text += "\n";
    }
  };
  add_pairs("bar", structure.parts.bars);
  add_pairs("tether", structure.parts.tethers);
  add_pairs("contact", structure.parts.contacts);
  return text;
}

}  // namespace ragdoll
