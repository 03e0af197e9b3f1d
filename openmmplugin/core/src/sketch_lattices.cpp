// Sketches of regular structures: grid, cloth, thread, chain of rings.

#include <algorithm>  // max
#include <cmath>      // sqrt, cbrt, cos, sin
#include <numbers>    // pi
#include <string>

#include "ragdoll/error.h"  // Error
#include "sketch.h"

namespace ragdoll {
namespace {

/// The smallest side of a square or cube that holds n joints.
int side_of(int n, int dimensions) {
  const double root = dimensions == 2 ? std::sqrt(n) : std::cbrt(n);
  long side = std::max(1L, long(root) - 1);
  const auto holds = [&](long s) { return (dimensions == 2 ? s * s : s * s * s) >= n; };
  while (!holds(side)) ++side;
  return int(side);
}

/// Sizes of the rings: 3 to 8 joints, or as even as can be where their number is given.
std::vector<int> ring_sizes(Sketch& sketch) {
  const int joints = sketch.request.joints, rings = sketch.request.cycles;
  std::vector<int> sizes;
  if (rings != 0) {
    if (rings < 0 || rings > joints / 3)
      throw Error(std::to_string(joints) + " joints make from 1 to " + std::to_string(joints / 3) +
                  " rings, not " + std::to_string(rings));
    for (int k = 0; k < rings; ++k) sizes.push_back(joints / rings + (k < joints % rings ? 1 : 0));
    return sizes;
  }
  for (int left = joints; left > 0; left -= sizes.back()) {
    // 1 or 2 joints left over make no ring
    int size = sketch.between(3, 8);
    while (size != left && size > left - 3) size = size > 3 ? size - 1 : left;
    sizes.push_back(size);
  }
  return sizes;
}

}  // namespace

void sketch_grid(Sketch& sketch) {
  int dimensions = sketch.request.dimensions;
  if (dimensions == 0) dimensions = sketch.between(2, 3);
  if (dimensions != 2 && dimensions != 3)
    throw Error("a grid has 2 or 3 dimensions, not " + std::to_string(dimensions));
  const int side = side_of(sketch.request.joints, dimensions), layer = side * side;
  for (int j = 0; j < sketch.request.joints; ++j) {
    const int x = j % side, y = j / side % side, z = j / layer;
    sketch.add_lattice_joint(Vec3(x, dimensions == 2 ? j / side : y, dimensions == 2 ? 0 : z));
    if (x > 0) sketch.add_bar(j - 1, j);
    if (dimensions == 2 ? j >= side : y > 0) sketch.add_bar(j - side, j);
    if (dimensions == 3 && z > 0) sketch.add_bar(j - layer, j);
  }
}

void sketch_cloth(Sketch& sketch) {
  // every other row is shifted by half a bar
  const int width = std::max(2, side_of(sketch.request.joints, 2));
  const double height = std::sqrt(3.0) / 2;
  for (int j = 0; j < sketch.request.joints; ++j) {
    const int column = j % width, row = j / width;
    const bool shifted = row % 2 == 1;
    sketch.add_lattice_joint(Vec3(column + (shifted ? 0.5 : 0), height * row, 0));
    if (column > 0) sketch.add_bar(j - 1, j);
    if (row == 0) continue;
    // the two joints of the row below, left and right of this one
    const int left = shifted ? column : column - 1;
    if (left >= 0) sketch.add_bar(j - column - width + left, j);
    if (left + 1 < width) sketch.add_bar(j - column - width + left + 1, j);
  }
}

void sketch_thread(Sketch& sketch) {
  // a zigzag of 120 degrees: a straight thread's bending bars could give way to no side
  const double along = std::sqrt(3.0) / 2;
  for (int j = 0; j < sketch.request.joints; ++j) {
    sketch.add_lattice_joint(Vec3(along * j, j % 2 == 0 ? 0 : 0.5, 0));
    if (j > 0) sketch.add_bar(j - 1, j);
    if (j > 1) sketch.add_bar(j - 2, j);
  }
}

void sketch_ring_chain(Sketch& sketch) {
  Vec3 entry = Vec3::Zero();
  int before = -1;  // the joint by which the ring before is left
  for (const int size : ring_sizes(sketch)) {
    // a regular polygon from entry to exit, turned about that axis at random
    const double step = 2 * std::numbers::pi / size, radius = 0.5 / std::sin(step / 2);
    const int first = sketch.joints(), way = size / 2;
    const double chord = 2 * radius * std::sin(way * step / 2);
    const double turn = 2 * std::numbers::pi * sketch.random.uniform();
    for (int k = 0; k < size; ++k) {
      // across: the entry at 0 and the exit at `way` both on the axis
      const double angle = (k - 0.5 * way) * step;
      const double along = chord / 2 + radius * std::sin(angle);
      const double across = radius * (std::cos(angle) - std::cos(0.5 * way * step));
      sketch.add_lattice_joint(entry +
                               Vec3(along, across * std::cos(turn), across * std::sin(turn)));
    }
    if (before >= 0) sketch.add_bar(before, first);
    for (int k = 1; k < size; ++k) sketch.add_bar(first + k - 1, first + k);
    sketch.add_bar(first + size - 1, first);
    before = first + way;
    entry += Vec3(chord + 1, 0, 0);
  }
}

}  // namespace ragdoll
