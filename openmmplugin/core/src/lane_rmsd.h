// LaneRmsd: the RMSD of one conformer to many, side by side. Private to core.

#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace ragdoll {

/// Conformers' places about their centroids, laid out for comparing many with one.
class ConformerBlock {
 public:
  static constexpr std::size_t lanes = 16;

  explicit ConformerBlock(std::size_t atom_count) : natom_(atom_count) {}

  std::size_t size() const { return count_; }
  /// What a list of distances to all of them has room for.
  std::size_t padded_size() const { return norm_.size(); }
  std::size_t atom_count() const { return natom_; }

  /// @param places  (natom, 3), nm; its centroid is taken away
  void add(std::span<const float> places);

  /// (natom, 3)
  void get(std::size_t conformer, std::span<float> places) const;

  float norm(std::size_t conformer) const { return norm_[conformer]; }

  /// The RMSD of each, from `first` (a multiple of lanes) on, to one whose places are about its
  /// centroid; what is larger than is there already stays. nm
  /// @param norm       sum of its squares
  /// @param distances  (size - first, up to a multiple of lanes)
  void shorten(std::span<const float> places, float norm, std::size_t first,
               std::span<float> distances) const;

 private:
  std::size_t natom_, count_ = 0;
  std::vector<float> places_;  ///< (block, natom, 3, lane)
  std::vector<float> norm_;    ///< sums of squares (n, up to a multiple of lanes)
};

}  // namespace ragdoll
