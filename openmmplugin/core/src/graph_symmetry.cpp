#include "graph_symmetry.h"

#include <algorithm>  // sort, unique, lower_bound
#include <map>
#include <utility>  // pair

namespace ragdoll {
namespace {

/// Steps of the search after which it ends, so that no graph takes long.
constexpr long most_steps = 200'000;

struct Link {
  int to, order;
};

/// The heavy atoms' graph, with bonds told apart as far as symmetry does.
std::vector<std::vector<Link>> links_of(const Molecule& molecule, const std::vector<int>& atoms,
                                        const std::vector<int>& place) {
  const auto size = [&](int atom) { return molecule.neighbours(atom).size(); };
  std::vector<std::vector<Link>> links(atoms.size());
  for (std::size_t i = 0; i < atoms.size(); ++i)
    for (const auto& [other, bond] : molecule.neighbours(atoms[i])) {
      if (place[std::size_t(other)] < 0) continue;
      int order = int(molecule.bonds()[std::size_t(bond)].order);
      // ends on one atom share their double bonds, whoever has them drawn
      const auto is_end = [&](int atom) {
        const int element = molecule.atoms()[std::size_t(atom)].element;
        return (element == 8 || element == 16 || element == 7) && size(atom) == 1;
      };
      if (is_end(atoms[i]) || is_end(other)) order = 0;
      links[i].push_back({place[std::size_t(other)], order});
    }
  return links;
}

class Search {
 public:
  Search(const std::vector<std::vector<Link>>& links, const std::vector<int>& colours,
         std::size_t most)
      : links_(links),
        colours_(colours),
        most_(most),
        image_(links.size(), -1),
        taken_(links.size()) {
    // each atom but the first of a fragment comes behind one of its neighbours
    std::vector<bool> seen(links.size());
    for (std::size_t root = 0; root < links.size(); ++root) {
      if (seen[root]) continue;
      seen[root] = true;
      std::size_t next = order_.size();
      order_.push_back({int(root), -1});
      for (; next < order_.size(); ++next) {
        const int atom = order_[next].first;
        for (const Link& link : links[std::size_t(atom)])
          if (!seen[std::size_t(link.to)]) {
            seen[std::size_t(link.to)] = true;
            order_.push_back({link.to, atom});
          }
      }
    }
  }

  /// @return whether all were found
  bool run(std::vector<std::vector<int>>& found) {
    // depth first with a stack of our own: the candidate that each atom tries next
    const std::size_t n = order_.size();
    std::vector<std::size_t> next(n + 1, 0);
    std::size_t depth = 0;
    long steps = 0;
    while (true) {
      if (depth == n) {
        found.push_back(image_);
        if (found.size() >= most_) return false;
        if (depth == 0) return true;
        release(--depth);
        continue;
      }
      const auto [atom, before] = order_[depth];
      const std::size_t choices =
          before < 0 ? links_.size() : links_[std::size_t(image_[std::size_t(before)])].size();
      bool placed = false;
      while (next[depth] < choices && !placed) {
        if (++steps > most_steps) return false;
        const std::size_t k = next[depth]++;
        // the atom itself first, so that the first permutation changes nothing
        const int candidate =
            before < 0 ? int(k == 0 ? std::size_t(atom) : (k <= std::size_t(atom) ? k - 1 : k))
                       : links_[std::size_t(image_[std::size_t(before)])][k].to;
        placed = fits(atom, candidate);
        if (placed) {
          image_[std::size_t(atom)] = candidate;
          taken_[std::size_t(candidate)] = true;
        }
      }
      if (placed) {
        next[++depth] = 0;
      } else {
        if (depth == 0) return true;
        release(--depth);
      }
    }
  }

 private:
  void release(std::size_t depth) {
    int& image = image_[std::size_t(order_[depth].first)];
    taken_[std::size_t(image)] = false;
    image = -1;
  }

  bool fits(int atom, int candidate) const {
    if (taken_[std::size_t(candidate)] ||
        colours_[std::size_t(atom)] != colours_[std::size_t(candidate)])
      return false;
    for (const Link& link : links_[std::size_t(atom)]) {
      const int image = image_[std::size_t(link.to)];
      if (image < 0) continue;
      bool bonded = false;
      for (const Link& there : links_[std::size_t(candidate)])
        bonded = bonded || (there.to == image && there.order == link.order);
      if (!bonded) return false;
    }
    return true;
  }

  const std::vector<std::vector<Link>>& links_;
  const std::vector<int>& colours_;
  std::size_t most_;
  std::vector<int> image_;
  std::vector<bool> taken_;
  std::vector<std::pair<int, int>> order_;
};

/// Colours until they tell no more atoms apart: each takes in those of its neighbours.
std::vector<int> refined(const std::vector<std::vector<Link>>& links,
                         std::vector<std::vector<int>> kinds) {
  std::vector<int> colours(links.size());
  std::size_t count = 0;
  while (true) {
    std::map<std::vector<int>, int> numbers;
    for (const auto& kind : kinds) numbers.emplace(kind, 0);
    int next = 0;
    for (auto& [kind, number] : numbers) number = next++;
    for (std::size_t i = 0; i < kinds.size(); ++i) colours[i] = numbers[kinds[i]];
    if (numbers.size() == count) return colours;
    count = numbers.size();
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      std::vector<int> around;
      for (const Link& link : links[i])
        around.push_back(8 * colours[std::size_t(link.to)] + link.order);
      std::sort(around.begin(), around.end());
      kinds[i].assign(1, colours[i]);
      kinds[i].insert(kinds[i].end(), around.begin(), around.end());
    }
  }
}

}  // namespace

GraphSymmetry::GraphSymmetry(const Molecule& molecule, std::size_t most) {
  const int natom = int(molecule.atoms().size());
  for (int i = 0; i < natom; ++i)
    if (molecule.atoms()[std::size_t(i)].element != 1) atoms_.push_back(i);
  const bool heavy = !atoms_.empty();
  if (!heavy)
    for (int i = 0; i < natom; ++i) atoms_.push_back(i);
  std::vector<int> place(std::size_t(natom), -1);
  for (std::size_t k = 0; k < atoms_.size(); ++k) place[std::size_t(atoms_[k])] = int(k);

  const auto links = links_of(molecule, atoms_, place);
  std::vector<std::vector<int>> kinds;
  for (std::size_t k = 0; k < atoms_.size(); ++k) {
    const int element = molecule.atoms()[std::size_t(atoms_[k])].element;
    const int hydrogens = int(molecule.neighbours(atoms_[k]).size() - links[k].size());
    // whichever end of an acid has the hydrogen
    const bool acid_end = (element == 8 || element == 16) && links[k].size() == 1;
    kinds.push_back({element, acid_end ? 0 : hydrogens, int(links[k].size())});
  }
  const std::vector<int> colours = refined(links, std::move(kinds));

  for (std::size_t centre = 0; centre < links.size(); ++centre) {
    std::map<int, std::vector<int>> ends;
    for (const Link& link : links[centre])
      if (links[std::size_t(link.to)].size() == 1)
        ends[colours[std::size_t(link.to)]].push_back(link.to);
    for (auto& [colour, group] : ends)
      if (group.size() > 1) equal_ends_.push_back(std::move(group));
  }
  complete_ = Search(links, colours, most).run(permutations_);
  if (permutations_.empty()) {
    permutations_.emplace_back(atoms_.size());
    for (std::size_t k = 0; k < atoms_.size(); ++k) permutations_[0][k] = int(k);
  }
}

}  // namespace ragdoll
