// Examples: frameworks spelled as the thesis spells them ("ab ac bd"), and random ones.

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "ragdoll/framework.h"  // Framework
#include "ragdoll/graph.h"      // Graph
#include "ragdoll/order.h"      // Order
#include "ragdoll/random.h"     // Random
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll::examples {

using Positions = std::vector<Vec3>;

/// Joints are letters, a = 0. Bars in the order of the text.
Graph graph_of(const std::string& bars, int joint_count);

/// The bars of an order, each spelled as the graph spells it: "ab bd de ce".
std::string text_of(const Graph& graph, const Order& order);

/// The problem constraints of an order, spelled alike.
std::string problems_of(const Graph& graph, const Order& order);

/// A text with each bar spelled as the graph spells it: "ec" becomes "ce" where the graph has "ce".
std::string spelled(const Graph& graph, const std::string& bars);

/// Bars at the distances that the positions have; masses of 1.
FrameworkParts parts_of(const std::string& bars, const Positions& positions);
std::shared_ptr<const Framework> framework_of(FrameworkParts parts);

/// A framework and positions in which nothing is broken.
struct Structure {
  FrameworkParts parts;
  Positions positions;
};

/// A random tree of `joints` joints at random places in the unit cube, and `cycles` further bars.
/// Bars are shuffled and turned, and joints are labelled at random.
Structure random_structure(int joints, int cycles, Random& random);

/// `count` points in a cube with the given edge.
Positions random_points(int count, double edge, Random& random);

/// Uniform in the unit cube about the origin.
Vec3 random_vector(Random& random);

/// what() of the Error that a call throws, or "" where it throws none.
template <class Call>
std::string refusal_of(Call call);

}  // namespace ragdoll::examples

#include "ragdoll/error.h"  // Error

template <class Call>
std::string ragdoll::examples::refusal_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}
