#include "part_tree.h"

#include <algorithm>  // sort, max, min, find
#include <cmath>      // abs
#include <utility>    // move

#include "chemistry_rules.h"       // is_metal, PlanarUnits
#include "ragdoll/ring_systems.h"  // ring_systems

namespace ragdoll {
namespace {

constexpr int hydrogen = 1, nitrogen = 7;

/// Terms of rings add up to much more than what their shapes really differ by.
constexpr double ring_energy_share = 1;

/// A frame at a bond: the origin at its first atom, one axis along it, one towards a third atom.
struct BondFrame {
  Vec3 origin;
  Eigen::Matrix3d axes;

  BondFrame(const Vec3& first, const Vec3& second, const Vec3& third) : origin(first) {
    const Vec3 along = (second - first).normalized();
    Vec3 side = third - first;
    side -= along * along.dot(side);
    // three atoms on a line have no side: any will do, as long as it is the same one each time
    if (side.norm() < 1e-6) side = along.unitOrthogonal();
    side.normalize();
    axes.col(0) = along;
    axes.col(1) = side;
    axes.col(2) = along.cross(side);
  }
};

/// What brings one frame over another.
RigidMove move_of(const BondFrame& from, const BondFrame& to) {
  RigidMove move;
  move.rotation = to.axes * from.axes.transpose();
  move.translation = to.origin - move.rotation * from.origin;
  return move;
}

RigidMove after(const RigidMove& second, const RigidMove& first) {
  RigidMove move;
  move.rotation = second.rotation * first.rotation;
  move.translation = second.rotation * first.translation + second.translation;
  return move;
}

std::vector<bool> bonds_that_turn(const Molecule& molecule) {
  std::vector<bool> turns(molecule.bonds().size());
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const Bond& bond = molecule.bonds()[k];
    const auto ends_there = [&](int atom) { return molecule.neighbours(atom).size() < 2; };
    const auto metal = [&](int atom) {
      return is_metal(molecule.atoms()[std::size_t(atom)].element);
    };
    turns[k] = (bond.order == BondOrder::single || bond.order == BondOrder::unknown) &&
               !ends_there(bond.a) && !ends_there(bond.b) && !metal(bond.a) && !metal(bond.b);
  }
  for (const RingSystem& system : ring_systems(molecule))
    for (const int bond : system.bonds) turns[std::size_t(bond)] = false;
  return turns;
}

}  // namespace

PartTree::PartTree(const Molecule& molecule, std::span<const TorsionTerm> terms)
    : molecule_(molecule), turns_(bonds_that_turn(molecule)) {
  find_parts();
  choose_references(terms);
  for (Part& part : parts_) {
    PartShape own;
    for (const int atom : part.atoms)
      own.positions.push_back(molecule.positions()[std::size_t(atom)]);
    own.moves.assign(part.children.size(), RigidMove());
    part.shapes.push_back(std::move(own));
  }
}

void PartTree::find_parts() {
  const int natom = int(molecule_.atoms().size());
  part_of_.assign(std::size_t(natom), -1);
  struct Entry {
    int parent, inner, outer;
  };
  const auto grow = [&](const Entry& entry, std::vector<Entry>& waiting) {
    const int number = int(parts_.size());
    Part part;
    part.parent = entry.parent;
    part.inner = entry.inner;
    part.outer = entry.outer;
    part.atoms.push_back(entry.outer);
    part_of_[std::size_t(entry.outer)] = number;
    for (std::size_t k = 0; k < part.atoms.size(); ++k) {
      const int atom = part.atoms[k];
      for (const auto& [other, bond] : molecule_.neighbours(atom)) {
        if (part_of_[std::size_t(other)] >= 0) continue;
        if (turns_[std::size_t(bond)]) {
          waiting.push_back({number, atom, other});
        } else {
          part_of_[std::size_t(other)] = number;
          part.atoms.push_back(other);
        }
      }
    }
    std::sort(part.atoms.begin(), part.atoms.end());
    if (entry.parent >= 0) parts_[std::size_t(entry.parent)].children.push_back(number);
    depth_.push_back(entry.parent < 0 ? 0 : depth_[std::size_t(entry.parent)] + 1);
    parts_.push_back(std::move(part));
  };
  for (int root = 0; root < natom; ++root) {
    if (part_of_[std::size_t(root)] >= 0) continue;
    std::vector<Entry> waiting;
    grow({-1, -1, root}, waiting);
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      const Entry entry = waiting[k];
      grow(entry, waiting);
    }
    parts_[std::size_t(part_of_[std::size_t(root)])].outer = -1;
  }
}

void PartTree::choose_references(std::span<const TorsionTerm> terms) {
  const auto heaviest = [&](int atom, int without) {
    int best = -1;
    for (const auto& [other, bond] : molecule_.neighbours(atom)) {
      if (other == without) continue;
      if (best < 0 || molecule_.atoms()[std::size_t(other)].element >
                          molecule_.atoms()[std::size_t(best)].element)
        best = other;
    }
    return best;
  };
  for (Part& part : parts_) {
    if (part.parent < 0) continue;
    part.before = heaviest(part.inner, part.outer);
    part.behind = heaviest(part.outer, part.inner);
  }
  for (const TorsionTerm& t : terms) {
    const int inner = part_of_[std::size_t(t.b)], outer = part_of_[std::size_t(t.c)];
    for (const bool forward : {true, false}) {
      Part& part = parts_[std::size_t(forward ? outer : inner)];
      if (part.inner != (forward ? t.b : t.c) || part.outer != (forward ? t.c : t.b)) continue;
      part.before = forward ? t.a : t.d;
      part.behind = forward ? t.d : t.a;
    }
  }
}

std::vector<int> PartTree::path(int one, int other) const {
  std::vector<int> found;
  const auto up = [&](int& part) {
    if (parts_[std::size_t(part)].parent >= 0) found.push_back(part);
    part = parts_[std::size_t(part)].parent;
  };
  while (one != other && (one >= 0 || other >= 0)) {
    if (other < 0 || (one >= 0 && depth_of(one) >= depth_of(other)))
      up(one);
    else
      up(other);
  }
  return found;
}

PartShape PartTree::shape_of(int number, std::span<const RingPool> pools,
                             std::span<const int> chosen, std::span<const int> inverted) const {
  const Part& part = parts_[std::size_t(number)];
  std::vector<Vec3> x = molecule_.positions();  // only the part and what is bonded to it is kept
  PartShape shape;
  shape.moves.assign(part.children.size(), RigidMove());

  // what hangs on a bond from `from` to `to` follows a move
  std::vector<int> stack;
  std::vector<char> seen(x.size());
  const auto carry = [&](int from, int to, const RigidMove& move) {
    std::fill(seen.begin(), seen.end(), 0);
    seen[std::size_t(from)] = seen[std::size_t(to)] = 1;
    stack.assign(1, to);
    while (!stack.empty()) {
      const int atom = stack.back();
      stack.pop_back();
      x[std::size_t(atom)] = move(x[std::size_t(atom)]);
      if (part_of(atom) != number) {
        // all beyond follows as a whole; of the parent nothing is asked
        for (std::size_t c = 0; c < part.children.size(); ++c)
          if (part.children[c] == part_of(atom)) shape.moves[c] = after(move, shape.moves[c]);
        continue;
      }
      for (const auto& [other, bond] : molecule_.neighbours(atom)) {
        if (seen[std::size_t(other)]) continue;
        seen[std::size_t(other)] = 1;
        stack.push_back(other);
      }
    }
  };
  const auto at = [&](int atom) -> const Vec3& { return x[std::size_t(atom)]; };
  // the atom beside `centre` that the torsion about its bond to `end` is measured by
  const auto reference_of = [&](int centre, int end, std::span<const int> among) {
    for (const int c : part.children) {
      const Part& child = parts_[std::size_t(c)];
      if (child.inner == centre && child.outer == end &&
          std::find(among.begin(), among.end(), child.before) != among.end())
        return child.before;
    }
    if (part.outer == centre && part.inner == end &&
        std::find(among.begin(), among.end(), part.behind) != among.end())
      return part.behind;
    for (const auto& [other, bond] : molecule_.neighbours(centre))
      if (other != end && std::find(among.begin(), among.end(), other) != among.end()) return other;
    return end;
  };

  for (std::size_t s = 0; s < pools.size(); ++s) {
    const RingPool& pool = pools[s];
    const std::vector<Vec3>& wanted = pool.conformations[std::size_t(chosen[s])];
    const std::span<const int> ring(pool.atoms.data(), std::size_t(pool.ring_atoms));
    shape.energy +=
        ring_energy_share * (pool.energies[std::size_t(chosen[s])] - pool.energies.front());
    const auto place_of = [&](int atom) {
      const auto found = std::find(pool.atoms.begin(), pool.atoms.end(), atom);
      return wanted[std::size_t(found - pool.atoms.begin())];
    };
    struct Branch {
      int from, to;
      RigidMove move;
    };
    std::vector<Branch> branches;
    for (const int r : ring)
      for (const auto& [other, bond] : molecule_.neighbours(r)) {
        if (std::find(ring.begin(), ring.end(), other) != ring.end()) continue;
        const int reference = reference_of(r, other, ring);
        branches.push_back({r, other,
                            move_of({at(r), at(other), at(reference)},
                                    {place_of(r), place_of(other), place_of(reference)})});
      }
    for (const int r : ring) x[std::size_t(r)] = place_of(r);
    for (const Branch& branch : branches) carry(branch.from, branch.to, branch.move);
  }

  for (const int centre : inverted) {
    // the last neighbour goes to its image beyond the plane of the centre and the other two
    const auto& around = molecule_.neighbours(centre);
    int keep[2] = {around[0].atom, around[1].atom}, turned = around[2].atom;
    const auto is_way_in = [&](int atom) { return centre == part.outer && atom == part.inner; };
    if (is_way_in(turned)) std::swap(turned, keep[0]);
    const Vec3 normal = (at(keep[0]) - at(centre)).cross(at(keep[1]) - at(centre)).normalized();
    const Vec3 image = at(turned) - 2 * normal * normal.dot(at(turned) - at(centre));
    const int reference = reference_of(centre, turned, keep);
    carry(centre, turned,
          move_of({at(centre), at(turned), at(reference)}, {at(centre), image, at(reference)}));
  }

  RigidMove home;
  if (part.parent >= 0) {
    const std::vector<Vec3>& start = molecule_.positions();
    const auto first = [&](int atom) -> const Vec3& { return start[std::size_t(atom)]; };
    home = move_of({at(part.outer), at(part.inner), at(part.behind)},
                   {first(part.outer), first(part.inner), first(part.behind)});
  }
  for (const int atom : part.atoms) shape.positions.push_back(home(at(atom)));
  for (RigidMove& move : shape.moves) move = after(home, move);
  return shape;
}

void PartTree::add_shapes(std::span<const RingPool> pools, int most_shapes) {
  const PlanarUnits planar(molecule_);
  std::vector<int> in_ring(molecule_.atoms().size(), 0);  // the largest ring of its system
  for (const RingSystem& system : ring_systems(molecule_))
    for (const int atom : system.atoms) in_ring[std::size_t(atom)] = system.largest_ring();
  for (int number = 0; number < int(parts_.size()); ++number) {
    Part& part = parts_[std::size_t(number)];
    std::vector<RingPool> own;
    for (const RingPool& pool : pools)
      if (part_of(pool.atoms.front()) == number && !pool.conformations.empty()) {
        own.push_back(pool);
        part.even = part.even || in_ring[std::size_t(pool.atoms.front())] >= large_ring;
      }

    // nitrogens that turn inside out: pyramids of three different single bonds outside of rings
    std::vector<int> pyramids;
    for (const int atom : part.atoms) {
      const Atom& a = molecule_.atoms()[std::size_t(atom)];
      const auto& around = molecule_.neighbours(atom);
      if (a.element != nitrogen || a.formal_charge != 0 || around.size() != 3 ||
          in_ring[std::size_t(atom)] > 0 || planar.planar_atom(atom))
        continue;
      int heavy = 0;
      for (const auto& [other, bond] : around)
        heavy += molecule_.atoms()[std::size_t(other)].element != hydrogen;
      if (heavy >= 2) pyramids.push_back(atom);
    }
    if (own.empty() && pyramids.empty()) continue;
    if (pyramids.size() > 4) pyramids.resize(4);

    // combinations: the rings' shapes are sorted by energy, so that low ones come first
    std::vector<std::pair<double, std::vector<int>>> combined = {{0, {}}};
    for (const RingPool& pool : own) {
      std::vector<std::pair<double, std::vector<int>>> next;
      for (const auto& [energy, picks] : combined)
        for (std::size_t k = 0; k < pool.conformations.size(); ++k) {
          next.emplace_back(energy + pool.energies[k], picks);
          next.back().second.push_back(int(k));
        }
      std::stable_sort(next.begin(), next.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      if (int(next.size()) > most_shapes) next.resize(std::size_t(most_shapes));
      combined = std::move(next);
    }
    std::vector<PartShape> shapes;
    for (const auto& [energy, picks] : combined)
      for (unsigned bits = 0; bits < 1u << pyramids.size(); ++bits) {
        std::vector<int> inverted;
        for (std::size_t k = 0; k < pyramids.size(); ++k)
          if (bits >> k & 1) inverted.push_back(pyramids[k]);
        shapes.push_back(shape_of(number, own, picks, inverted));
      }
    part.shapes = std::move(shapes);
  }
}

std::vector<Vec3> place_parts(const PartTree& tree, std::size_t atom_count,
                              std::span<const double> angles, std::span<const int> shapes,
                              std::span<const Vec3> start) {
  std::vector<Vec3> x(atom_count);
  std::vector<RigidMove> moves(tree.parts().size());
  for (std::size_t p = 0; p < moves.size(); ++p) {
    const Part& part = tree.parts()[p];
    if (part.parent >= 0) {
      const Vec3& origin = start[std::size_t(part.inner)];
      RigidMove turn;
      turn.rotation =
          Eigen::AngleAxisd(angles[p], (start[std::size_t(part.outer)] - origin).normalized())
              .toRotationMatrix();
      turn.translation = origin - turn.rotation * origin;
      const Part& parent = tree.parts()[std::size_t(part.parent)];
      const std::size_t place =
          std::size_t(std::find(parent.children.begin(), parent.children.end(), int(p)) -
                      parent.children.begin());
      const PartShape& hung = parent.shapes[std::size_t(shapes[std::size_t(part.parent)])];
      moves[p] = after(after(moves[std::size_t(part.parent)], hung.moves[place]), turn);
    }
    const PartShape& own = part.shapes[std::size_t(shapes[p])];
    for (std::size_t k = 0; k < part.atoms.size(); ++k)
      x[std::size_t(part.atoms[k])] = moves[p](own.positions[k]);
  }
  return x;
}

}  // namespace ragdoll
