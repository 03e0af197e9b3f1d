// Sketch: a structure while it is being generated. Private to the generators.

#pragma once
#include <utility>
#include <vector>

#include "ragdoll/generate.h"  // StructureRequest
#include "ragdoll/random.h"    // Random
#include "ragdoll/vec3.h"      // Vec3

namespace ragdoll {

struct Sketch {
  explicit Sketch(const StructureRequest& wanted);

  const StructureRequest& request;
  Random random;
  std::vector<Vec3> positions;            ///< of the joints so far
  std::vector<std::pair<int, int>> bars;  ///< so far

  int joints() const { return int(positions.size()); }
  int missing() const { return request.joints - joints(); }

  /// [0, n)
  int below(long n) { return int(random.below(std::uint64_t(n))); }
  /// [least, most]
  int between(long least, long most) { return int(least) + below(most - least + 1); }

  /// Uniform in the box of the random classes.
  Vec3 random_position();
  /// Uniform on the sphere.
  Vec3 random_direction();

  int add_joint(const Vec3& position);
  int add_random_joint() { return add_joint(random_position()); }
  /// At its place in a lattice, moved a little.
  int add_lattice_joint(const Vec3& place);
  void add_bar(int p, int q) { bars.emplace_back(p, q); }

  /// `spare` things dealt out to `parts` places, every way of it equally likely.
  std::vector<int> deal(int spare, int parts);
};

// each adds the joints that are asked for
void sketch_tree(Sketch& sketch);
void sketch_one_cycle(Sketch& sketch);
void sketch_two_cycle(Sketch& sketch);
void sketch_n_cycle(Sketch& sketch);
void sketch_grid(Sketch& sketch);
void sketch_cloth(Sketch& sketch);
void sketch_thread(Sketch& sketch);
void sketch_ring_chain(Sketch& sketch);
void sketch_regular(Sketch& sketch);
void sketch_protein(Sketch& sketch);

}  // namespace ragdoll
