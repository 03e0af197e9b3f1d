// DisjointSets: union-find, and the sets numbered by size.

#pragma once
#include <algorithm>  // stable_sort
#include <numeric>    // iota
#include <utility>    // exchange, swap
#include <vector>

namespace ragdoll {

class DisjointSets {
 public:
  explicit DisjointSets(int members)
      : parent_(std::size_t(members)), size_(std::size_t(members), 1) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  int find(int member) {
    int root = member;
    while (parent_[std::size_t(root)] != root) root = parent_[std::size_t(root)];
    while (parent_[std::size_t(member)] != root)
      member = std::exchange(parent_[std::size_t(member)], root);
    return root;
  }

  int size(int root) const { return size_[std::size_t(root)]; }

  /// @return the root of both; it is that of the larger
  int join(int a, int b) {
    a = find(a);
    b = find(b);
    if (a == b) return a;
    if (size(a) < size(b)) std::swap(a, b);
    parent_[std::size_t(b)] = a;
    size_[std::size_t(a)] += size(b);
    return a;
  }

  /// Numbers the sets of at least `least` members by size, the largest first, by their lowest
  /// members on ties; members of others get -1.
  void number(int least, std::vector<int>& of_member, std::vector<int>& sizes) {
    const int n = int(parent_.size());
    std::vector<int> roots;  // by lowest member
    std::vector<bool> seen(parent_.size(), false);
    for (int i = 0; i < n; ++i) {
      const int root = find(i);
      if (seen[std::size_t(root)] || size(root) < least) continue;
      seen[std::size_t(root)] = true;
      roots.push_back(root);
    }
    std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return size(a) > size(b); });
    std::vector<int> number_of(parent_.size(), -1);
    sizes.clear();
    for (const int root : roots) {
      number_of[std::size_t(root)] = int(sizes.size());
      sizes.push_back(size(root));
    }
    of_member.resize(parent_.size());
    for (int i = 0; i < n; ++i) of_member[std::size_t(i)] = number_of[std::size_t(find(i))];
  }

 private:
  std::vector<int> parent_, size_;
};

}  // namespace ragdoll
