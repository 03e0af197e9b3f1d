// Order files: the bars in the order in which they are resolved, each with its nearer end first.

#pragma once
#include <string>
#include <utility>  // pair
#include <vector>

#include "ragdoll/method_files/files.h"  // Warnings, WriteOptions
#include "ragdoll/order.h"               // Order
#include "ragdoll/structure.h"           // Structure

namespace ragdoll {

struct OrderFile {
  Order order;
  std::string name = {};       ///< "bfs_cycle", or what a user calls his own; empty: not stated
  std::string root = {};       ///< id of a joint; empty: not stated
  std::string structure = {};  ///< file that the order is meant for; empty: not stated
};

/// A bar may come more than once (bfs_reverse) or not at all (bfs_tree).
/// @throw Error      on what an order file must not hold, a bar that the structure does not have
/// @throw FileError  if reading breaks off
OrderFile read_order(const std::string& path, const Structure& structure,
                     Warnings* warnings = nullptr);

/// The order that visits these pairs (near, far), for orders that are made elsewhere.
/// @throw Error  if there is no bar between the joints of a pair, or the sizes differ
Order order_from_pairs(const Structure& structure, const std::vector<std::pair<int, int>>& pairs,
                       const std::vector<bool>& problem);

/// @throw Error      on an order that could not be read back, or if the file is there already
/// @throw FileError  if writing breaks off; nothing is left behind
void write_order(const std::string& path, const Structure& structure, const OrderFile& file,
                 const WriteOptions& options = {});

}  // namespace ragdoll
