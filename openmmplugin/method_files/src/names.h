// Joints by their ids, bars by their joints.

#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ragdoll/structure.h"  // Structure

namespace ragdoll {

/// Numbers of names. Keeps views: the texts must outlive it.
class NameIndex {
 public:
  NameIndex() = default;
  explicit NameIndex(const std::vector<std::string>& names);

  int count() const { return int(names_.size()); }
  /// Gives a new name the next number; false: it has one.
  bool add(std::string_view name);
  int find(std::string_view name) const;  ///< -1: unknown

 private:
  struct Slot {
    std::uint32_t hash = 0;
    int number = -1;  ///< -1: free
  };

  std::size_t slot_of(std::string_view name, std::uint32_t hash) const;
  void grow();

  std::vector<std::string_view> names_;
  std::vector<Slot> slots_ = std::vector<Slot>(16);  ///< a power of two, at most half of it taken
};

/// Bars by their two joints, in either order.
class BarIndex {
 public:
  explicit BarIndex(const std::vector<Bar>& bars);
  int find(int p, int q) const;  ///< -1: no bar

 private:
  struct Entry {
    std::uint64_t pair;
    int bar;
  };
  std::vector<Entry> entries_;  ///< sorted by pair
};

/// One number for two joints, whichever comes first.
std::uint64_t pair_key(int p, int q);

/// @throw Error on a structure that a file cannot hold, or that no reader would accept
void check_structure(const Structure& structure);

/// Refuses a class that the bars contradict, or an unknown one. Families such as "grid" are names
/// of how a structure was made, and are taken as they are. Of several components, the largest and
/// all together may both give the class.
/// @throw Error
void check_class(const std::string& class_name, int joint_count, const std::vector<Bar>& bars);

}  // namespace ragdoll
