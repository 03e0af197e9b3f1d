#include "framework_pieces.h"

#include <numeric>  // iota
#include <utility>  // move

namespace ragdoll {
namespace {

/// Sets of components, joined by and by.
class Unions {
 public:
  explicit Unions(int count) : parent_(std::size_t(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int of(int k) {
    while (parent_[std::size_t(k)] != k) {
      int& parent = parent_[std::size_t(k)];
      parent = parent_[std::size_t(parent)];
      k = parent;
    }
    return k;
  }
  void join(int a, int b) { parent_[std::size_t(of(a))] = of(b); }

 private:
  std::vector<int> parent_;
};

}  // namespace

Pieces pieces_of(const Framework& framework) {
  const Components& components = framework.components();
  const auto component = [&](int joint) { return components.of_joint[std::size_t(joint)]; };
  Unions unions(components.count());
  const auto join = [&](int p, int q) { unions.join(component(p), component(q)); };
  for (const Tether& t : framework.tethers()) join(t.p, t.q);
  for (const Contact& c : framework.contacts()) join(c.p, c.q);
  for (const Volume& v : framework.volumes())
    for (const int joint : {v.b, v.c, v.d}) join(v.a, joint);
  const bool rule = !framework.contact_rule().empty();
  for (int c = 1; rule && c < components.count(); ++c) unions.join(c, 0);

  Pieces result;
  std::vector<int> piece_of(std::size_t(components.count()), -1);
  result.of_joint.reserve(std::size_t(framework.joint_count()));
  for (int joint = 0; joint < framework.joint_count(); ++joint) {
    const int c = component(joint);
    int& index = piece_of[std::size_t(unions.of(c))];
    if (index < 0) {
      index = int(result.pieces.size());
      result.pieces.emplace_back();
      result.pieces.back().bars_only = !rule;
    }
    result.of_joint.push_back(index);
    Piece& piece = result.pieces[std::size_t(index)];
    ++piece.joints;
    if (components.lowest_joint[std::size_t(c)] == joint) ++piece.components;
  }
  const auto piece_at = [&](int joint) -> Piece& {
    return result.pieces[std::size_t(result.of_joint[std::size_t(joint)])];
  };
  for (const Bar& bar : framework.bars()) {
    ++piece_at(bar.p).bars;
    piece_at(bar.p).length += bar.length;
  }
  for (const Tether& t : framework.tethers()) {
    ++piece_at(t.p).tethers;
    piece_at(t.p).bars_only = false;
  }
  for (const Contact& c : framework.contacts()) piece_at(c.p).bars_only = false;
  for (const Volume& v : framework.volumes()) piece_at(v.a).bars_only = false;
  return result;
}

SubFramework sub_framework(const Framework& whole, std::span<const unsigned char> taken) {
  SubFramework result;
  FrameworkParts parts;
  std::vector<int> number(taken.size(), -1);
  for (int joint = 0; joint < whole.joint_count(); ++joint) {
    const auto j = std::size_t(joint);
    if (!taken[j]) continue;
    number[j] = int(result.joints.size());
    result.joints.push_back(joint);
    parts.masses.push_back(whole.masses()[j]);
    parts.fixed.push_back(whole.fixed()[j]);
    parts.labels.push_back(whole.name(joint));
  }
  const auto at = [&](int joint) { return number[std::size_t(joint)]; };
  const auto take_pairs = [&](const auto& from, auto& to) {
    for (auto pair : from) {
      if (at(pair.p) < 0) continue;
      pair.p = at(pair.p);
      pair.q = at(pair.q);
      to.push_back(pair);
    }
  };
  take_pairs(whole.bars(), parts.bars);
  take_pairs(whole.tethers(), parts.tethers);
  take_pairs(whole.contacts(), parts.contacts);
  for (Volume v : whole.volumes()) {
    if (at(v.a) < 0) continue;
    for (int* const joint : {&v.a, &v.b, &v.c, &v.d}) *joint = at(*joint);
    parts.volumes.push_back(v);
  }
  result.framework = std::make_shared<const Framework>(std::move(parts));
  return result;
}

}  // namespace ragdoll
