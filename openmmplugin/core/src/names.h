// Tables of names: an enum's values and their texts, and the one sentence for an unknown text.

#pragma once
#include <array>
#include <string>
#include <utility>

#include "ragdoll/error.h"  // Error

namespace ragdoll {

template <class Enum, std::size_t N>
Enum value_of(const std::array<std::pair<Enum, const char*>, N>& table, const std::string& name,
              const char* what) {
  std::string known;
  for (const auto& [value, text] : table) {
    if (name == text) return value;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  throw Error(std::string(what) + " '" + name + "' is not known; choose one of: " + known);
}

template <class Enum, std::size_t N>
std::string name_in(const std::array<std::pair<Enum, const char*>, N>& table, Enum value) {
  for (const auto& [entry, text] : table)
    if (entry == value) return text;
  return "unknown";
}

}  // namespace ragdoll
