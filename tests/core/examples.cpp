#include "examples.h"

#include <algorithm>  // find
#include <numeric>    // iota
#include <sstream>
#include <utility>  // pair, swap

namespace ragdoll::examples {
namespace {

std::vector<std::pair<int, int>> pairs_of(const std::string& bars) {
  std::vector<std::pair<int, int>> pairs;
  std::istringstream words(bars);
  for (std::string word; words >> word;) pairs.emplace_back(word.at(0) - 'a', word.at(1) - 'a');
  return pairs;
}

std::string name_of_bar(const Graph& graph, int bar) {
  const auto [p, q] = graph.ends(bar);
  return {char('a' + p), char('a' + q)};
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text.append(text.empty() ? "" : " ").append(word);
  return text;
}

}  // namespace

Graph graph_of(const std::string& bars, int joint_count) {
  return Graph(joint_count, pairs_of(bars));
}

std::string text_of(const Graph& graph, const Order& order) {
  std::vector<std::string> words;
  for (const Visit& visit : order) words.push_back(name_of_bar(graph, visit.bar));
  return joined(words);
}

std::string problems_of(const Graph& graph, const Order& order) {
  Order problems;
  for (const Visit& visit : order)
    if (visit.problem) problems.push_back(visit);
  return text_of(graph, problems);
}

std::string spelled(const Graph& graph, const std::string& bars) {
  std::vector<std::string> words;
  for (const auto& [p, q] : pairs_of(bars))
    for (int bar = 0; bar < graph.bar_count(); ++bar)
      if (graph.ends(bar) == std::pair(p, q) || graph.ends(bar) == std::pair(q, p))
        words.push_back(name_of_bar(graph, bar));
  return joined(words);
}

FrameworkParts parts_of(const std::string& bars, const Positions& positions) {
  FrameworkParts parts;
  parts.masses.assign(positions.size(), 1);
  for (const auto& [p, q] : pairs_of(bars))
    parts.bars.push_back({p, q, (positions[std::size_t(q)] - positions[std::size_t(p)]).norm()});
  return parts;
}

std::shared_ptr<const Framework> framework_of(FrameworkParts parts) {
  return std::make_shared<const Framework>(std::move(parts));
}

Structure random_structure(int joints, int cycles, Random& random) {
  Structure structure;
  structure.positions = random_points(joints, 1, random);
  structure.parts.masses.assign(std::size_t(joints), 1);

  // labels at random
  std::vector<int> label(static_cast<std::size_t>(joints));
  std::iota(label.begin(), label.end(), 0);
  for (std::size_t k = label.size(); k > 1; --k) std::swap(label[k - 1], label[random.below(k)]);

  // each joint hangs on an earlier one, then further pairs
  std::vector<std::pair<int, int>> pairs;
  const auto known = [&](std::pair<int, int> pair) {
    return std::find(pairs.begin(), pairs.end(), pair) != pairs.end() ||
           std::find(pairs.begin(), pairs.end(), std::pair(pair.second, pair.first)) != pairs.end();
  };
  for (int j = 1; j < joints; ++j)
    pairs.emplace_back(label[random.below(std::uint64_t(j))], label[std::size_t(j)]);
  while (int(pairs.size()) < joints - 1 + cycles) {
    const int p = int(random.below(std::uint64_t(joints)));
    const int q = int(random.below(std::uint64_t(joints)));
    if (p != q && !known({p, q})) pairs.emplace_back(p, q);
  }

  // bars shuffled, and turned
  for (std::size_t k = pairs.size(); k > 1; --k) std::swap(pairs[k - 1], pairs[random.below(k)]);
  for (auto [p, q] : pairs) {
    if (random.below(2) == 1) std::swap(p, q);
    const double length =
        (structure.positions[std::size_t(q)] - structure.positions[std::size_t(p)]).norm();
    structure.parts.bars.push_back({p, q, length});
  }
  return structure;
}

Positions random_points(int count, double edge, Random& random) {
  Positions points;
  for (int j = 0; j < count; ++j) points.emplace_back(edge * random_vector(random));
  return points;
}

Vec3 random_vector(Random& random) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return Vec3(x, y, z) - Vec3::Constant(0.5);
}

}  // namespace ragdoll::examples
