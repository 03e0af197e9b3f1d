#include "ragdoll/generate.h"

#include <algorithm>  // sort, replace_if, adjacent_find
#include <array>
#include <cctype>  // isspace
#include <cmath>   // isfinite, sqrt

#include "ragdoll/classify.h"  // classify
#include "ragdoll/error.h"     // Error
#include "sketch.h"

namespace ragdoll {
namespace {

struct Recipe {
  const char* name;
  int least_joints;
  void (*sketch)(Sketch&);
};

constexpr std::array<Recipe, 10> recipes = {{
    {"tree", 2, sketch_tree},
    {"1-cycle", 3, sketch_one_cycle},
    {"2-cycle", 4, sketch_two_cycle},
    {"n-cycle", 4, sketch_n_cycle},
    {"grid", 2, sketch_grid},
    {"cloth", 3, sketch_cloth},
    {"thread", 3, sketch_thread},
    {"ring-chain", 3, sketch_ring_chain},
    {"regular", 2, sketch_regular},
    {"protein", 4, sketch_protein},
}};

constexpr int most_joints = 10'000'000;

const Recipe& recipe_of(const std::string& name) {
  std::string known;
  for (const Recipe& recipe : recipes) {
    if (name == recipe.name) return recipe;
    known += (known.empty() ? "" : ", ") + std::string(recipe.name);
  }
  throw Error("class '" + name + "' is not known; choose one of: " + known);
}

void check(const StructureRequest& request, const Recipe& recipe) {
  const std::string name = recipe.name;
  const auto only_for = [&](bool asked, const char* what, bool fits) {
    if (asked && !fits) throw Error("a structure of class " + name + " has no choice of " + what);
  };
  only_for(!request.type.empty(), "type", name == "2-cycle");
  only_for(!request.construction.empty(), "construction", name == "1-cycle" || name == "2-cycle");
  only_for(request.cycles != 0, "cycles", name == "n-cycle" || name == "ring-chain");
  only_for(request.depth != 0 || request.children != 0, "depth and children",
           name == "tree" || name == "1-cycle" || name == "2-cycle" || name == "n-cycle");
  only_for(request.dimensions != 0, "dimensions", name == "grid");
  only_for(request.degree != 0, "degree", name == "regular");
  if (request.joints < recipe.least_joints)
    throw Error("a structure of class " + name + " has at least " +
                std::to_string(recipe.least_joints) + " joints, not " +
                std::to_string(request.joints));
  if (request.joints > most_joints)
    throw Error("a structure has at most " + std::to_string(most_joints) + " joints, not " +
                std::to_string(request.joints));
}

double length_of(const std::vector<Vec3>& positions, int p, int q) {
  return (positions[std::size_t(q)] - positions[std::size_t(p)]).norm();
}

/// Structures take the even steps of the stream, forces the odd ones: they share no numbers.
std::uint64_t structure_step(std::uint64_t index) {
  return 2 * index;
}
std::uint64_t force_step(std::uint64_t index) {
  return 2 * index + 1;
}

Vec3 direction(Random& random) {
  while (true) {
    const double x = random.gaussian(), y = random.gaussian(), z = random.gaussian();
    const Vec3 vector(x, y, z);
    const double norm = vector.norm();
    if (norm > 1e-6) return vector / norm;
  }
}

/// j0, j1, ...
std::vector<std::string> numbered_ids(std::size_t count) {
  std::vector<std::string> ids(count, "j");
  for (std::size_t j = 0; j < count; ++j) ids[j] += std::to_string(j);
  return ids;
}

/// Labels without spaces if they are all there and all different, else numbers.
std::vector<std::string> ids_of(const Molecule& molecule) {
  std::vector<std::string> ids;
  for (const Atom& atom : molecule.atoms()) {
    ids.push_back(atom.label);
    std::replace_if(
        ids.back().begin(), ids.back().end(), [](unsigned char c) { return std::isspace(c); }, '_');
  }
  std::vector<std::string> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  const bool unique = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  const bool complete = ids.empty() || !sorted.front().empty();
  return unique && complete ? ids : numbered_ids(ids.size());
}

}  // namespace

Sketch::Sketch(const StructureRequest& wanted)
    : request(wanted), random(wanted.seed, RandomStream::generate, structure_step(wanted.index)) {
  positions.reserve(std::size_t(wanted.joints));
}

Vec3 Sketch::random_position() {
  // two random points of a unit cube are 0.6617 apart on average
  constexpr double side = 1.5113;
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return side * Vec3(x, y, z);
}

Vec3 Sketch::random_direction() {
  return direction(random);
}

int Sketch::add_joint(const Vec3& position) {
  positions.push_back(position);
  return joints() - 1;
}

int Sketch::add_lattice_joint(const Vec3& place) {
  constexpr double jitter = 0.05;
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return add_joint(place + jitter * (2 * Vec3(x, y, z) - Vec3(1, 1, 1)));
}

std::vector<int> Sketch::deal(int spare, int parts) {
  // bars among stars: cut positions drawn from spare + parts - 1, without repetition (Floyd)
  std::vector<int> cuts;
  for (int top = spare; top < spare + parts - 1; ++top) {
    const int cut = below(long(top) + 1);
    const bool taken = std::find(cuts.begin(), cuts.end(), cut) != cuts.end();
    cuts.push_back(taken ? top : cut);
  }
  std::sort(cuts.begin(), cuts.end());
  cuts.push_back(spare + parts - 1);
  std::vector<int> shares;
  int before = -1;
  for (const int cut : cuts) {
    shares.push_back(cut - before - 1);
    before = cut;
  }
  return shares;
}

std::vector<std::string> structure_classes() {
  std::vector<std::string> names;
  for (const Recipe& recipe : recipes) names.emplace_back(recipe.name);
  return names;
}

Structure generate_structure(const StructureRequest& request) {
  const Recipe& recipe = recipe_of(request.class_name);
  check(request, recipe);
  Sketch sketch(request);
  recipe.sketch(sketch);

  Structure structure;
  structure.class_name = request.class_name;
  if (request.class_name == "2-cycle")
    structure.type = classify(Graph(sketch.joints(), sketch.bars)).type;
  structure.positions = std::move(sketch.positions);
  const std::size_t n = structure.positions.size();
  structure.ids = numbered_ids(n);
  structure.parts.masses.assign(n, 1);
  structure.parts.fixed.assign(n, 0);
  structure.parts.bars.reserve(sketch.bars.size());
  for (const auto& [p, q] : sketch.bars)
    structure.parts.bars.push_back({p, q, length_of(structure.positions, p, q)});
  return structure;
}

Structure structure_of(const Molecule& molecule) {
  Structure structure;
  structure.ids = ids_of(molecule);
  structure.positions = molecule.positions();
  structure.length_unit = "nm";
  for (const Atom& atom : molecule.atoms()) structure.parts.masses.push_back(atom.mass);
  structure.parts.fixed.assign(molecule.atoms().size(), 0);
  std::vector<std::pair<int, int>> bars;
  for (const Bond& bond : molecule.bonds()) {
    const double length = length_of(structure.positions, bond.a, bond.b);
    if (!(length > 0))
      throw Error("the bonded atoms " + molecule.name(bond.a) + " and " + molecule.name(bond.b) +
                  " are at one place");
    structure.parts.bars.push_back({bond.a, bond.b, length});
    bars.emplace_back(bond.a, bond.b);
  }
  const Classification found = classify(Graph(int(molecule.atoms().size()), bars));
  structure.class_name = found.class_name;
  structure.type = found.type;
  return structure;
}

ForceSet generate_forces(const Structure& structure, const ForceRequest& request) {
  const FrameworkParts& parts = structure.parts;
  if (request.count < 0) throw Error("the number of forces must be 0 or more");
  if (!(request.lo >= 0 && request.lo <= request.hi) || !std::isfinite(request.hi))
    throw Error("the size of the forces lies between two numbers, 0 <= lo <= hi");
  if (parts.bars.empty()) throw Error("a structure without bars has no mean bar length");
  double mean = 0;
  for (const Bar& bar : parts.bars) mean += bar.length;
  mean /= double(parts.bars.size());
  std::vector<int> movable;
  for (std::size_t j = 0; j < parts.masses.size(); ++j)
    if (parts.masses[j] > 0 && (parts.fixed.empty() || !parts.fixed[j])) movable.push_back(int(j));
  if (movable.empty()) throw Error("no joint of the structure can move");

  Random random(request.seed, RandomStream::generate, force_step(request.index));
  ForceSet set;
  set.forces.reserve(std::size_t(request.count));
  for (int k = 0; k < request.count; ++k) {
    const int joint = movable[random.below(movable.size())];
    const double step = mean * (request.lo + (request.hi - request.lo) * random.uniform());
    set.forces.push_back({joint, parts.masses[std::size_t(joint)] * step * direction(random)});
  }
  return set;
}

}  // namespace ragdoll
