#include "newton_plan.h"

#include <algorithm>  // sort, min, max, clamp, lower_bound
#include <cmath>      // cbrt, abs, copysign, isfinite
#include <numeric>    // partial_sum, iota
#include <optional>
#include <utility>  // pair, minmax

#include <Eigen/OrderingMethods>  // AMDOrdering
#include <Eigen/SparseCore>       // SparseMatrix

#include "flat_groups.h"   // FlatGroups
#include "newton_range.h"  // NewtonRange

namespace ragdoll {
namespace {

/// The six pairs of the four joints of a volume.
constexpr std::array<std::pair<int, int>, 6> volume_pairs = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// The one of +-size that the bounds allow; of two, the one on the side that they lean to. What is
/// flat is taken to be just that.
double aim_of(double size, const NewtonPlan::Corners& v) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto allowed = [&v](double value) { return v.lower <= value && value <= v.upper; };
  const double middle = v.lower + v.upper;
  if (allowed(size) && allowed(-size)) {
    if (middle != 0 && std::isfinite(middle)) return std::copysign(size, middle);
    return size <= 1e-3 * v.scale ? 0 : nan;
  }
  return allowed(size) ? size : allowed(-size) ? -size : nan;
}

using Edges = std::vector<std::pair<int, int>>;

/// Joints whose columns the largest cache holds; how many more products are worth it to find
/// everything where the last was.
constexpr int most_in_caches = 4000;
constexpr double worth_a_stream = 1.5;

/// Tethers and contacts enter the pattern if their ends are so few bars apart, the most of these
/// that take not many more products than bars and volumes alone.
constexpr std::array<int, 5> reaches = {NewtonRange::anywhere, 16, 8, 4, 2};
constexpr double worth_its_rows = 1.6;
constexpr double cheap_products = 2e4;

/// Pairs of different joints that a constraint joins and that move.
Edges edges_of(const Framework& framework, const NewtonRange& range) {
  Edges edges;
  const auto add = [&](int p, int q) {
    if (p != q && !framework.fixed()[std::size_t(p)] && !framework.fixed()[std::size_t(q)])
      edges.emplace_back(std::min(p, q), std::max(p, q));
  };
  for (const Bar& bar : framework.bars()) add(bar.p, bar.q);
  for (std::size_t k = 0; k < framework.tethers().size(); ++k)
    if (range.covers_tether(k)) add(framework.tethers()[k].p, framework.tethers()[k].q);
  for (std::size_t k = 0; k < framework.contacts().size(); ++k)
    if (range.covers_contact(k)) add(framework.contacts()[k].p, framework.contacts()[k].q);
  for (const Volume& v : framework.volumes()) {
    const std::array<int, 4> j = {v.a, v.b, v.c, v.d};
    for (const auto& [a, b] : volume_pairs) add(j[std::size_t(a)], j[std::size_t(b)]);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Joints in the order of their degree when they are eliminated.
std::vector<int> minimum_degree(const Framework& framework, const Edges& edges) {
  using Pattern = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  const int n = framework.joint_count();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * edges.size());
  for (const auto& [p, q] : edges) {
    entries.emplace_back(p, q, 1.0);
    entries.emplace_back(q, p, 1.0);
  }
  // without its own entry a joint counts as one that has all others for neighbours
  for (int k = 0; k < n; ++k) entries.emplace_back(k, k, 1.0);
  Pattern pattern(n, n);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  std::vector<int> order(std::size_t(n), 0);
  for (int k = 0; k < n; ++k) order[std::size_t(k)] = permutation.indices()[k];
  return order;
}

Edges renumbered(const Edges& edges, const std::vector<int>& number) {
  Edges result;
  result.reserve(edges.size());
  for (const auto& [p, q] : edges)
    result.emplace_back(number[std::size_t(p)], number[std::size_t(q)]);
  return result;
}

/// Neighbours of smaller number, for each joint.
struct Upper {
  std::vector<std::int64_t> begin;
  std::vector<int> neighbour;

  Upper(int count, const Edges& edges) : begin(std::size_t(count) + 1, 0) {
    for (const auto& edge : edges) ++begin[std::size_t(std::max(edge.first, edge.second)) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
    neighbour.resize(edges.size());
    for (const auto& [p, q] : edges)
      neighbour[std::size_t(next[std::size_t(std::max(p, q))]++)] = std::min(p, q);
  }
};

/// The column that each column is first subtracted from; -1 for none.
std::vector<int> elimination_tree(int count, const Upper& upper) {
  std::vector<int> parent(std::size_t(count), -1), ancestor(std::size_t(count), -1);
  for (int k = 0; k < count; ++k)
    for (std::int64_t e = upper.begin[std::size_t(k)]; e < upper.begin[std::size_t(k) + 1]; ++e)
      for (int i = upper.neighbour[std::size_t(e)]; i != -1 && i < k;) {
        const int next = ancestor[std::size_t(i)];
        ancestor[std::size_t(i)] = k;
        if (next == -1) parent[std::size_t(i)] = k;
        i = next;
      }
  return parent;
}

/// Products of two blocks that the elimination takes; where there are more than `most`, some number
/// above it.
double products_of(const std::vector<int>& order, const Edges& edges, double most) {
  std::vector<int> rank(order.size(), 0);
  for (std::size_t k = 0; k < order.size(); ++k) rank[std::size_t(order[k])] = int(k);
  const int count = int(order.size());
  const Upper upper(count, renumbered(edges, rank));
  const std::vector<int> parent = elimination_tree(count, upper);
  std::vector<int> mark(order.size(), -1), blocks(order.size(), 0);
  double products = 0;
  for (int k = 0; k < count; ++k) {
    mark[std::size_t(k)] = k;
    for (std::int64_t e = upper.begin[std::size_t(k)]; e < upper.begin[std::size_t(k) + 1]; ++e)
      for (int i = upper.neighbour[std::size_t(e)]; mark[std::size_t(i)] != k;
           i = parent[std::size_t(i)]) {
        mark[std::size_t(i)] = k;
        products += blocks[std::size_t(i)]++;
      }
    if (products > most) break;  // counting takes time too
  }
  return products;
}

/// How far apart the ends of pairs in the pattern may be.
/// @param most  products that a factor may take
void choose_reach(const Framework& framework, double most, NewtonRange& range) {
  if (framework.tethers().empty() && framework.contacts().empty()) return;
  const auto products = [&](int reach, double limit) {
    range.set_reach(reach);
    const Edges edges = edges_of(framework, range);
    return products_of(minimum_degree(framework, edges), edges, limit);
  };
  const double least = products(-1, most);
  const double limit = std::min(most, std::max(worth_its_rows * least, cheap_products));
  for (const int reach : reaches)
    if (products(reach, limit) <= limit) return;
}

/// Joints in the order of elimination, fixed joints last: that which takes the fewest products; but
/// a framework that does not fit into the caches is gone through from end to end, if that takes not
/// many more.
/// @param products  those it takes
std::vector<int> elimination_order(const Framework& framework, const Edges& edges, double most,
                                   double& products) {
  const int n = framework.joint_count();
  std::vector<int> order = minimum_degree(framework, edges);
  products = products_of(order, edges, most);
  if (n > most_in_caches) {
    std::vector<int> natural(std::size_t(n), 0);
    std::iota(natural.begin(), natural.end(), 0);
    const double worth = std::min(most, worth_a_stream * products);
    if (const double others = products_of(natural, edges, worth); others <= worth) {
      order = std::move(natural);
      products = others;
    }
  }
  if (products > most) std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(),
                        [&](int joint) { return !framework.fixed()[std::size_t(joint)]; });
  return order;
}

/// Children before parents and each subtree in one piece. @return the new number of each
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = int(parent.size());
  std::vector<int> first_child(std::size_t(n), -1), sibling(std::size_t(n), -1),
      number(std::size_t(n), 0);
  for (int k = n - 1; k >= 0; --k)
    if (const int p = parent[std::size_t(k)]; p >= 0) {
      sibling[std::size_t(k)] = first_child[std::size_t(p)];
      first_child[std::size_t(p)] = k;
    }
  int next = 0;
  for (int root = 0; root < n; ++root) {
    if (parent[std::size_t(root)] >= 0) continue;
    int k = root;
    while (true) {
      while (first_child[std::size_t(k)] >= 0) k = first_child[std::size_t(k)];
      // k has no child left: number it, go on with its sibling or back to its parent
      number[std::size_t(k)] = next++;
      if (k == root) break;
      const int p = parent[std::size_t(k)];
      first_child[std::size_t(p)] = sibling[std::size_t(k)];
      k = p;
    }
  }
  return number;
}

/// Neighbours in the list that share a joint wait for each other when they are corrected one after
/// the other: takes from the next few the first that is free of those just taken.
template <class Pair>
void spread(std::vector<Pair>& pairs, int slots) {
  constexpr std::size_t window = 24;
  constexpr std::ptrdiff_t apart = 8;
  // as if no joint had been used lately
  std::vector<std::ptrdiff_t> used(std::size_t(slots), -1 - apart);  // when, of each slot
  std::vector<Pair> result, waiting;
  result.reserve(pairs.size());
  std::size_t next = 0;
  while (result.size() < pairs.size()) {
    while (waiting.size() < window && next < pairs.size()) waiting.push_back(pairs[next++]);
    const auto now = std::ptrdiff_t(result.size());
    std::size_t best = 0;
    std::ptrdiff_t longest = -1;
    for (std::size_t k = 0; k < waiting.size() && longest < apart; ++k) {
      const auto last = std::max(used[std::size_t(waiting[k].p)], used[std::size_t(waiting[k].q)]);
      const auto distance = std::min(now - 1 - last, apart);
      if (distance <= longest) continue;
      best = k;
      longest = distance;
    }
    used[std::size_t(waiting[best].p)] = used[std::size_t(waiting[best].q)] = now;
    result.push_back(waiting[best]);
    waiting.erase(waiting.begin() + std::ptrdiff_t(best));
  }
  pairs = std::move(result);
}

}  // namespace

double NewtonPlan::most_products(int joints) {
  // all of them are seconds, and gigabytes to know them by
  constexpr double of_any = 5e8;
  // from here on conjugate gradients are quicker, of one conformer three to thirty times
  constexpr double of_each = 2000, of_few = 1e6;
  return std::clamp(of_each * joints, of_few, of_any);
}

NewtonPlan::NewtonPlan(const Framework& framework, double most, bool whole)
    : joints(framework.joint_count()) {
  NewtonRange range(framework);
  if (!whole) choose_reach(framework, most, range);
  place_joints(framework, most, range);
  // without a factor, nothing is too far
  if (is_bulky) range.set_reach(NewtonRange::anywhere);
  place_constraints(framework, range);
  aim_volumes(framework);
  if (is_bulky) return;
  make_pattern();
  fill_pattern();
  place_panels();
  enter_constraints();
}

void NewtonPlan::place_joints(const Framework& framework, double most, const NewtonRange& range) {
  const Edges edges = edges_of(framework, range);
  double products = 0;
  const std::vector<int> order = elimination_order(framework, edges, most, products);
  is_bulky = products > most;
  std::vector<int> rank(std::size_t(joints), 0);
  double mass = 0;
  for (int k = 0; k < joints; ++k) {
    const std::size_t j = std::size_t(order[std::size_t(k)]);
    rank[j] = k;
    if (framework.fixed()[j]) continue;
    ++moving;
    mass += framework.masses()[j];
  }
  std::vector<int> number(std::size_t(moving), 0);
  std::iota(number.begin(), number.end(), 0);
  if (!is_bulky)
    number = postorder(elimination_tree(moving, Upper(moving, renumbered(edges, rank))));
  slot.resize(std::size_t(joints));
  joint.resize(std::size_t(joints));
  masses.resize(std::size_t(joints));
  for (int j = 0; j < joints; ++j) {
    const int r = rank[std::size_t(j)];
    const int s = r < moving ? number[std::size_t(r)] : r;
    slot[std::size_t(j)] = s;
    joint[std::size_t(s)] = j;
    masses[std::size_t(s)] =
        mass > 0 ? framework.masses()[std::size_t(j)] * double(moving) / mass : 1;
  }
}

void NewtonPlan::place_constraints(const Framework& framework, const NewtonRange& range) {
  const auto add = [this](const auto& list, int side, auto covers) {
    for (std::size_t k = 0; k < list.size(); ++k)
      (covers(k) ? pairs : far)
          .push_back(
              {slot[std::size_t(list[k].p)], slot[std::size_t(list[k].q)], side, list[k].length});
  };
  add(framework.bars(), 0, [](std::size_t) { return true; });
  add(framework.tethers(), 1, [&](std::size_t k) { return range.covers_tether(k); });
  add(framework.contacts(), -1, [&](std::size_t k) { return range.covers_contact(k); });
  const auto earlier = [](const Pair& one, const Pair& two) {
    const auto key = [](const Pair& pair) {
      return std::array<int, 3>{std::min(pair.p, pair.q), std::max(pair.p, pair.q), pair.side};
    };
    return key(one) < key(two);
  };
  std::sort(pairs.begin(), pairs.end(), earlier);
  std::sort(far.begin(), far.end(), earlier);
  spread(pairs, joints);
  for (const Volume& v : framework.volumes())
    volumes.push_back({{slot[std::size_t(v.a)], slot[std::size_t(v.b)], slot[std::size_t(v.c)],
                        slot[std::size_t(v.d)]},
                       v.lower,
                       v.upper,
                       v.scale});
}

/// What six bars leave a volume. Flat groups that have no volume get one without bounds.
void NewtonPlan::aim_volumes(const Framework& framework) {
  FlatGroups groups(framework);
  for (Corners& v : volumes) {
    FlatGroups::Corners four{};
    for (std::size_t i = 0; i < 4; ++i) four[i] = joint[std::size_t(v.slot[i])];
    const std::optional<FlatGroups::Shape> shape = groups.shape_of(four);
    if (!shape) continue;
    v.aim = aim_of(shape->volume, v);
    if (std::isfinite(v.aim)) groups.add_known(four, *shape, v.aim);
  }
  for (const FlatGroups::Row& flat : groups.rows_without_volume()) {
    Corners v;
    for (std::size_t i = 0; i < 4; ++i) v.slot[i] = slot[std::size_t(flat.corners[i])];
    v.lower = -std::numeric_limits<double>::infinity();
    v.upper = -v.lower;
    v.scale = flat.shape.scale();
    v.aim = flat.aim;
    v.mirror = flat.mirror;
    mirrors = std::max(mirrors, flat.mirror + 1);
    volumes.push_back(v);
  }
  std::stable_sort(volumes.begin(), volumes.end(), [](const Corners& one, const Corners& two) {
    return *std::min_element(one.slot.begin(), one.slot.end()) <
           *std::min_element(two.slot.begin(), two.slot.end());
  });
}

/// Rows of the factor: from each neighbour up the elimination tree.
void NewtonPlan::make_pattern() {
  Edges edges;
  const auto add = [&](int p, int q) {
    if (p != q && p < moving && q < moving) edges.emplace_back(std::min(p, q), std::max(p, q));
  };
  for (const Pair& pair : pairs) add(pair.p, pair.q);
  for (const Corners& v : volumes)
    for (const auto& [a, b] : volume_pairs) add(v.slot[std::size_t(a)], v.slot[std::size_t(b)]);
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const Upper upper(moving, edges);
  const std::vector<int> parent = elimination_tree(moving, upper);

  std::vector<int> mark(std::size_t(moving), -1);
  column.assign(std::size_t(moving) + 1, 0);
  source_begin.assign(std::size_t(moving) + 1, 0);
  for (int k = 0; k < moving; ++k) {
    mark[std::size_t(k)] = k;
    const std::size_t first = sources.size();
    for (std::int64_t e = upper.begin[std::size_t(k)]; e < upper.begin[std::size_t(k) + 1]; ++e)
      for (int i = upper.neighbour[std::size_t(e)]; mark[std::size_t(i)] != k;
           i = parent[std::size_t(i)]) {
        mark[std::size_t(i)] = k;
        ++column[std::size_t(i) + 1];
        sources.push_back({.column = i});
      }
    std::sort(sources.begin() + std::ptrdiff_t(first), sources.end(),
              [](const Source& one, const Source& two) { return one.column < two.column; });
    source_begin[std::size_t(k) + 1] = int(sources.size());
  }
  std::partial_sum(column.begin(), column.end(), column.begin());
}

void NewtonPlan::fill_pattern() {
  row.resize(std::size_t(column.back()));
  std::vector<std::int64_t> next(column.begin(), column.end() - 1);
  for (int k = 0; k < moving; ++k)
    for (int s = source_begin[std::size_t(k)]; s < source_begin[std::size_t(k) + 1]; ++s) {
      Source& source = sources[std::size_t(s)];
      const std::int64_t block = next[std::size_t(source.column)]++;
      source.place = int(block - column[std::size_t(source.column)]) + 1;
      source.below = blocks_of(source.column) - source.place;
      row[std::size_t(block)] = k;
    }
  std::int64_t products = 0;
  for (const Source& source : sources) products += source.below;
  target.reserve(std::size_t(products));
  std::vector<int> place(std::size_t(moving), 0);
  for (int k = 0; k < moving; ++k) {
    const std::int64_t begin = column[std::size_t(k)];
    for (std::int64_t e = begin; e < column[std::size_t(k) + 1]; ++e)
      place[std::size_t(row[std::size_t(e)])] = int(e - begin);
    for (int s = source_begin[std::size_t(k)]; s < source_begin[std::size_t(k) + 1]; ++s) {
      const Source& source = sources[std::size_t(s)];
      for (std::int64_t e = column[std::size_t(source.column) + 1] - source.below;
           e < column[std::size_t(source.column) + 1]; ++e)
        target.push_back(place[std::size_t(row[std::size_t(e)])]);
    }
  }
}

void NewtonPlan::place_panels() {
  panel.resize(std::size_t(moving));
  std::vector<std::vector<int>> free;  // places, by size
  const auto give_back = [&](int k) {
    free[std::size_t(blocks_of(k))].push_back(panel[std::size_t(k)]);
  };
  for (int k = 0; k < moving; ++k) {
    const std::size_t blocks = std::size_t(blocks_of(k));
    if (free.size() <= blocks) free.resize(blocks + 1);
    int& place = panel[std::size_t(k)];
    if (free[blocks].empty()) {
      place = panel_blocks;
      panel_blocks += int(blocks) + 1;
    } else {
      place = free[blocks].back();
      free[blocks].pop_back();
    }
    if (blocks == 0) give_back(k);
    for (int s = source_begin[std::size_t(k)]; s < source_begin[std::size_t(k) + 1]; ++s) {
      Source& source = sources[std::size_t(s)];
      source.panel = panel[std::size_t(source.column)];
      if (source.below == 0) give_back(source.column);
    }
  }
}

void NewtonPlan::enter_constraints() {
  block_pair.assign(row.size(), -1);
  std::vector<std::pair<int, Addition>> found;  // column
  const auto enter = [&](int p, int q, Addition addition) {
    const auto [c, r] = std::minmax(p, q);
    const auto begin = row.begin() + column[std::size_t(c)];
    const auto end = row.begin() + column[std::size_t(c) + 1];
    const auto at = std::lower_bound(begin, end, r);
    int& first = block_pair[std::size_t(at - row.begin())];
    if (addition.volume < 0 && first < 0) {
      first = addition.pair();
      return;
    }
    addition.block = int(at - begin);
    found.emplace_back(c, addition);
  };
  end_begin.assign(std::size_t(moving) + 1, 0);
  corner_begin.assign(std::size_t(moving) + 1, 0);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [p, q, side, length] = pairs[k];
    if (p < moving) ++end_begin[std::size_t(p) + 1];
    if (q < moving) ++end_begin[std::size_t(q) + 1];
    if (p < moving && q < moving) enter(p, q, {.volume = -1 - int(k)});
  }
  for (std::size_t k = 0; k < volumes.size(); ++k) {
    const std::array<int, 4>& s = volumes[k].slot;
    for (const int corner : s)
      if (corner < moving) ++corner_begin[std::size_t(corner) + 1];
    for (const auto& [i, j] : volume_pairs) {
      const int p = s[std::size_t(i)], q = s[std::size_t(j)];
      if (p == q || p >= moving || q >= moving) continue;
      enter(p, q,
            {.volume = int(k),
             .row = std::uint8_t(p > q ? i : j),
             .col = std::uint8_t(p > q ? j : i)});
    }
  }
  std::partial_sum(end_begin.begin(), end_begin.end(), end_begin.begin());
  std::partial_sum(corner_begin.begin(), corner_begin.end(), corner_begin.begin());
  ends.resize(std::size_t(end_begin.back()));
  corners.resize(std::size_t(corner_begin.back()));
  std::vector<int> next(end_begin.begin(), end_begin.end() - 1);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (pairs[k].p < moving) ends[std::size_t(next[std::size_t(pairs[k].p)]++)] = int(2 * k);
    if (pairs[k].q < moving) ends[std::size_t(next[std::size_t(pairs[k].q)]++)] = int(2 * k + 1);
  }
  next.assign(corner_begin.begin(), corner_begin.end() - 1);
  for (std::size_t k = 0; k < volumes.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i)
      if (const int s = volumes[k].slot[i]; s < moving)
        corners[std::size_t(next[std::size_t(s)]++)] = int(4 * k + i);

  std::stable_sort(found.begin(), found.end(),
                   [](const auto& one, const auto& two) { return one.first < two.first; });
  addition_begin.assign(std::size_t(moving) + 1, 0);
  for (const auto& [c, addition] : found) {
    ++addition_begin[std::size_t(c) + 1];
    additions.push_back(addition);
  }
  std::partial_sum(addition_begin.begin(), addition_begin.end(), addition_begin.begin());
}

std::pair<double, double> NewtonPlan::measure(std::span<const Vec3> positions) const {
  const auto at = [&](int s) -> const Vec3& {
    return positions[std::size_t(joint[std::size_t(s)])];
  };
  double relative = 0, nanometers = 0;
  const auto consider = [&](const Pair& pair) {
    // |d - L| <= |d^2 - L^2| / L; what is below both maxima so far needs no root
    const double square = (at(pair.q) - at(pair.p)).squaredNorm();
    const double excess = std::abs(square - pair.length * pair.length);
    if (excess < pair.length * std::min(nanometers, relative * pair.length)) return;
    const double error = std::sqrt(square) - pair.length;
    if (pair.side * error < 0) return;
    relative = std::max(relative, std::abs(error) / pair.length);
    nanometers = std::max(nanometers, std::abs(error));
  };
  for (const Pair& pair : pairs) consider(pair);
  for (const Pair& pair : far) consider(pair);
  for (const Corners& v : volumes) {
    const double volume = signed_volume(at(v.slot[0]), at(v.slot[1]), at(v.slot[2]), at(v.slot[3]));
    const double excess = std::max({0.0, v.lower - volume, volume - v.upper});
    if (excess == 0) continue;
    relative = std::max(relative, excess / v.scale);
    nanometers = std::max(nanometers, excess / v.scale * std::cbrt(v.scale));
  }
  return {relative, nanometers};
}

}  // namespace ragdoll
