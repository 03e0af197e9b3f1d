// SPDX-License-Identifier: MIT

#include "segments.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "files.h"

namespace fs = std::filesystem;

namespace ragdoll {
namespace {

// ".000.h5" -> true: a dot, three digits or more, ".h5"
bool is_number_and_ending(std::string text) {
  const std::string ending = ".h5";
  if (!text.starts_with('.') || !text.ends_with(ending)) return false;
  const std::string digits = text.substr(1, text.size() - ending.size() - 1);
  return digits.size() >= 3 && std::all_of(digits.begin(), digits.end(),
                                           [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

std::string segment_path(const std::string& path, std::size_t number) {
  std::string digits = std::to_string(number);
  digits.insert(0, 3 - std::min<std::size_t>(3, digits.size()), '0');
  const fs::path whole(path);
  return (whole.parent_path() / (whole.stem().string() + "." + digits + ".h5")).string();
}

Leftovers leftovers_of(const std::string& path) {
  const fs::path whole(path);
  const fs::path parent = whole.parent_path();
  const std::string stem = whole.stem().string(), part = ".part";
  Leftovers found;
  if (fs::exists(part_of(path))) found.parts.push_back(part_of(path));

  for (const fs::directory_entry& entry : fs::directory_iterator(parent.empty() ? "." : parent)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(stem)) continue;
    const std::string rest = name.substr(stem.size());
    const std::string here = (parent / name).string();
    if (is_number_and_ending(rest)) found.segments.push_back(here);
    if (rest.ends_with(part) && is_number_and_ending(rest.substr(0, rest.size() - part.size())))
      found.parts.push_back(here);
  }
  std::sort(found.segments.begin(), found.segments.end());
  std::sort(found.parts.begin(), found.parts.end());
  return found;
}

}  // namespace ragdoll
