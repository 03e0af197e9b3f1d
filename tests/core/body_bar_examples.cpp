#include "body_bar_examples.h"

#include <algorithm>  // sort
#include <cmath>      // abs
#include <map>

namespace ragdoll::examples {
namespace {

constexpr double zero = 1e-8;

/// Numbers sets by size, then by lowest member; those smaller than `least` get -1.
std::vector<int> numbered(const std::vector<int>& label, int least) {
  std::map<int, std::vector<int>> sets;
  for (int i = 0; i < int(label.size()); ++i) sets[label[std::size_t(i)]].push_back(i);
  std::vector<std::vector<int>> sorted;
  for (const auto& [unused, members] : sets)
    if (int(members.size()) >= least) sorted.push_back(members);
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  std::vector<int> number(label.size(), -1);
  for (std::size_t k = 0; k < sorted.size(); ++k)
    for (const int member : sorted[k]) number[std::size_t(member)] = int(k);
  return number;
}

void relabel(std::vector<int>& label, int from, int to) {
  for (int& l : label)
    if (l == from) l = to;
}

/// Plücker coordinates of a random line.
Eigen::Matrix<double, 6, 1> random_line(Random& random) {
  const auto vector = [&] {
    return Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
  };
  const Eigen::Vector3d direction = vector().normalized(), point = vector();
  Eigen::Matrix<double, 6, 1> line;
  line << direction, point.cross(direction);
  return line;
}

}  // namespace

BodyBarNetwork chain_of(int bodies, int bars) {
  BodyBarNetwork network{bodies, {}, false};
  for (int k = 0; k + 1 < bodies; ++k) network.bonds.push_back({k, k + 1, bars});
  return network;
}

BodyBarNetwork ring_of(int bodies, int bars) {
  BodyBarNetwork network = chain_of(bodies, bars);
  network.bonds.push_back({bodies - 1, 0, bars});
  return network;
}

BodyBarNetwork random_network(int bodies, int bonds, Random& random) {
  BodyBarNetwork network{bodies, {}, false};
  while (int(network.bonds.size()) < bonds) {
    const int a = int(random.below(std::uint64_t(bodies))),
              b = int(random.below(std::uint64_t(bodies)));
    // hinges are the most frequent, as in molecules
    const int drawn = int(random.below(9)) + 1;
    if (a != b) network.bonds.push_back({a, b, drawn > 6 ? 5 : drawn});
  }
  return network;
}

RigidityMatrix::RigidityMatrix(const BodyBarNetwork& network, Random& random) : network_(network) {
  for (int k = 0; k < int(network.bonds.size()); ++k) {
    for (int bar = 0; bar < network.bonds[std::size_t(k)].bars; ++bar) bond_of_bar_.push_back(k);
    locks_.push_back(random_line(random));
  }
  const Eigen::Index bars = Eigen::Index(bond_of_bar_.size()), columns = 6 * network.bodies;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(bars, columns);
  for (Eigen::Index row = 0; row < bars; ++row) {
    const BodyBond& bond = network.bonds[std::size_t(bond_of_bar_[std::size_t(row)])];
    const auto line = random_line(random);
    matrix.row(row).segment<6>(6 * bond.a) += line.transpose();
    matrix.row(row).segment<6>(6 * bond.b) -= line.transpose();
  }
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > zero) ++rank;
  motions_ = svd.matrixV().rightCols(columns - rank);
  stresses_ = svd.matrixU().rightCols(bars - rank);
}

int RigidityMatrix::degrees_of_freedom() const {
  return int(motions_.cols());
}

int RigidityMatrix::redundant_bars() const {
  return int(stresses_.cols());
}

std::vector<int> RigidityMatrix::cluster_of_body() const {
  std::vector<int> label(std::size_t(network_.bodies));
  for (int i = 0; i < int(label.size()); ++i) {
    label[std::size_t(i)] = i;
    for (int j = 0; j < i; ++j)
      if ((motions_.middleRows(6 * i, 6) - motions_.middleRows(6 * j, 6)).norm() < zero) {
        label[std::size_t(i)] = label[std::size_t(j)];
        break;
      }
  }
  return numbered(label, 1);
}

std::vector<int> RigidityMatrix::region_of_body() const {
  std::vector<int> label(std::size_t(network_.bodies));
  for (int i = 0; i < int(label.size()); ++i) label[std::size_t(i)] = i;
  for (std::size_t bar = 0; bar < bond_of_bar_.size(); ++bar) {
    if (stresses_.row(Eigen::Index(bar)).norm() < zero) continue;
    const BodyBond& bond = network_.bonds[std::size_t(bond_of_bar_[bar])];
    relabel(label, label[std::size_t(bond.b)], label[std::size_t(bond.a)]);
  }
  return numbered(label, 2);
}

std::vector<HingeGroup> RigidityMatrix::hinge_groups(const std::vector<int>& hinges) const {
  // how fast each motion turns each hinge, in reduced row echelon form: a hinge that is no pivot
  // turns with those pivots that it depends on
  Eigen::MatrixXd turns(motions_.cols(), Eigen::Index(hinges.size()));
  for (Eigen::Index k = 0; k < turns.cols(); ++k) {
    const int bond = hinges[std::size_t(k)];
    const BodyBond& ends = network_.bonds[std::size_t(bond)];
    turns.col(k) =
        (motions_.middleRows(6 * ends.a, 6) - motions_.middleRows(6 * ends.b, 6)).transpose() *
        locks_[std::size_t(bond)];
  }
  std::vector<Eigen::Index> pivots;
  for (Eigen::Index k = 0; k < turns.cols(); ++k) {
    const Eigen::Index row = Eigen::Index(pivots.size());
    if (row == turns.rows()) break;
    Eigen::Index best = 0;
    if (turns.col(k).tail(turns.rows() - row).cwiseAbs().maxCoeff(&best) < zero) continue;
    turns.row(row).swap(turns.row(row + best));
    turns.row(row) /= turns(row, k);
    for (Eigen::Index other = 0; other < turns.rows(); ++other)
      if (other != row) turns.row(other) -= turns(other, k) * turns.row(row);
    pivots.push_back(k);
  }
  std::vector<int> label(hinges.size());
  for (int k = 0; k < int(label.size()); ++k) label[std::size_t(k)] = k;
  for (Eigen::Index k = 0; k < turns.cols(); ++k)
    for (std::size_t row = 0; row < pivots.size(); ++row)
      if (std::abs(turns(Eigen::Index(row), k)) > 1e-6)
        relabel(label, label[std::size_t(k)], label[std::size_t(pivots[row])]);
  const std::vector<int> number = numbered(label, 1);
  std::map<int, HingeGroup> groups;
  for (std::size_t k = 0; k < hinges.size(); ++k) groups[number[k]].hinges.push_back(hinges[k]);
  for (const Eigen::Index pivot : pivots) ++groups[number[std::size_t(pivot)]].freedom;
  std::vector<HingeGroup> list;
  for (const auto& [unused, group] : groups) list.push_back(group);
  return list;
}

}  // namespace ragdoll::examples
