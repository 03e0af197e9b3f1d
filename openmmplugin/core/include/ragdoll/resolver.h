// Resolver: the one interface of the solvers. A solver is one file, resolver_<name>.cpp, and one
// line in resolver.cpp.

#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/box.h"        // Box
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/order.h"      // Order, OrderKind
#include "ragdoll/tolerance.h"  // Tolerance
#include "ragdoll/weighting.h"  // Weighting

namespace ragdoll {

/// Of the numbers that a solver works with; positions are doubles before and after.
enum class Precision { single, double_ };

/// "single" or "double". @throw Error
Precision precision_of(const std::string& name);
std::string name_of(Precision precision);

struct ResolverSettings {
  std::string solver = "auto";  ///< one of solver_names(); "auto" chooses
  OrderKind order = OrderKind::bfs_cycle;
  Weighting weighting = {};
  Tolerance tolerance = 1e-3;
  long max_iterations = 10000;
  std::uint64_t seed = 0;                    ///< of random orders
  Order custom_order = {};                   ///< replaces `order` where it is not empty
  Precision precision = Precision::double_;  ///< of `ordered` and `newton`
  bool work_list = false;  ///< `ordered` leaves out bars that nothing moved; the same result, and
                           ///< counts of iterations
  bool mass_weights = false;  ///< `newton` moves heavy joints less
};

/// What broke: where the traversal starts, and which step it is (it addresses random streams).
struct Breakage {
  std::span<const int> roots =
      {};  ///< forced joints; empty: all joints moved, middle joints are roots
  std::uint64_t step = 0;
  const Box* box = nullptr;  ///< contacts by minimum image; null: no periodic box
  /// A promise: the positions are those that this resolver left, resolved, but for the roots. Then
  /// the cost of a break does not grow with the structure.
  bool only_roots_moved = false;
};

enum class StopReason { nothing_broken, within_tolerance, max_iterations, not_finite, stagnated };

/// "nothing broken", "within tolerance", ...
std::string name_of(StopReason reason);

struct ResolveReport {
  bool converged = false;
  std::int64_t iterations = 0;  ///< passes over the order
  std::int64_t bar_visits = 0;  ///< bars visited in these passes, satisfied ones included
  double residual = 0;          ///< largest relative violation of any constraint
  double residual_nm = 0;       ///< largest violation as a length; of a volume: over scale^(2/3)
  std::int64_t carried = 0;     ///< `block`: cycle blocks that no deformation resolved, planar and
                                ///< mirror traps; they kept their shape and were carried whole
  StopReason reason = StopReason::nothing_broken;
  std::string worst =
      {};  ///< the constraint with the largest violation; filled where not converged
};

class Resolver {
 public:
  virtual ~Resolver() = default;

  /// Moves the joints until every constraint is within tolerance, or says why not.
  /// @param positions  nm (njoint), changed in place; an unresolved break leaves them where the
  /// last
  ///                   iteration left them
  virtual ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) = 0;

  /// The solver that works: what "auto" chose.
  virtual std::string solver() const = 0;

  /// The joints that may not be where they were before the last resolve, forced ones included, in
  /// any order and maybe more than once; null: any of them.
  virtual const std::vector<int>* moved_joints() const { return nullptr; }
};

/// @throw Error on an unknown solver, a tolerance that is not positive, a maximum below 1, a tree
///              order on a framework with cycles
std::unique_ptr<Resolver> make_resolver(std::shared_ptr<const Framework> framework,
                                        const ResolverSettings& settings);

/// Names that make_resolver knows.
std::vector<std::string> solver_names();

/// How far the constraints are violated, and the one that is violated most, as the tolerance
/// measures it.
struct Violation {
  double relative = 0;    ///< largest, relative to the constraint's length or scale
  double nanometers = 0;  ///< largest, as a length
  std::string what = {};  ///< "bar CA GLY45 - C GLY45 is 0.160 nm long instead of 0.153"
};
Violation worst_violation(const Framework& framework, std::span<const Vec3> positions,
                          const Box* box, const Tolerance& tolerance = {});

/// Chirality volumes whose sign differs from the framework's, or whose centre has left them through
/// a face, and planar units that went over from
/// cis to trans or back.
int inverted_centres(const Framework& framework, std::span<const Vec3> positions);

}  // namespace ragdoll
