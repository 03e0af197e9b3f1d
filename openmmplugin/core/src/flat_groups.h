// FlatGroups: joints near a plane, held there by bars alone. Private to the solver `newton`.

#pragma once
#include <array>
#include <optional>
#include <vector>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// Bars between joints in a plane hardly change when a joint leaves it: there bars alone are slow
/// to resolve, and a volume that is pulled to what the bars leave it is quick. Looks for four
/// joints with bars between all of them, which are flat and have no volume.
class FlatGroups {
 public:
  using Corners = std::array<int, 4>;  ///< joints

  struct Shape {
    double volume = 0;  ///< nm^3, |(b-a) . ((c-a) x (d-a))|
    double area = 0;    ///< nm^2, twice that of the largest face

    /// A joint is nearer to the plane of the others than bars hold it well.
    bool is_flat() const;
    /// So that a volume over scale^(2/3) is the distance of a joint from its plane. nm^3
    double scale() const;
  };

  struct Row {
    Corners corners{};
    Shape shape;
    double aim = 0;  ///< signed volume, nm^3
    int mirror =
        -1;  ///< of rows that are mirrored together or not at all, the same number; -1: not
  };

  explicit FlatGroups(const Framework& framework) : framework_(framework) {}

  /// By the lengths of bars; none where one is missing, or where no four points are so far apart.
  std::optional<Shape> shape_of(const Corners& corners) const;

  /// A volume that is pulled to its aim already.
  void add_known(const Corners& corners, const Shape& shape, double aim);

  /// As many as it takes, with those known, to hold each joint of flat four to others; the flattest
  /// first.
  std::vector<Row> rows_without_volume();

 private:
  struct Group {
    Corners corners{};  ///< ascending
    Shape shape;
    int sign = 0;  ///< of the volume; 0: not known
    int mirror = -1;
    bool known = false;
  };
  struct Link {
    int other = 0;  ///< group
    int sign = 1;   ///< relative to the other's
  };

  double square(int p, int q) const;  ///< of a bar's length; NaN without one
  void find_flat();
  void link();
  int relation(const Group& one, std::size_t apex, const Group& other,
               std::size_t other_apex) const;
  void settle_signs();
  void spread_sign(int start);

  const Framework& framework_;
  std::vector<Group> groups_;
  std::vector<std::vector<Link>> links_;
};

}  // namespace ragdoll
