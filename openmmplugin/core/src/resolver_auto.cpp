// How `auto` chooses. Forced joints on bars alone: `block`, whose one sweep costs what it moves.
// Else all joints have a say: `ordered` where sweeps converge quickly, which is at loose tolerances
// and, a decade further, where few bars close cycles; `newton` for the rest.

#include "resolver_auto.h"

#include <algorithm>  // max
#include <array>
#include <utility>  // move

#include "constraints.h"       // check_roots
#include "framework_pieces.h"  // Pieces, SubFramework
#include "resolver_block.h"    // make_block_resolver
#include "resolver_newton.h"   // make_newton_resolver
#include "resolver_ordered.h"  // make_ordered_resolver

namespace ragdoll {
namespace {

enum Choice { block, newton, ordered, choices };
constexpr std::array<const char*, choices> names = {"block", "newton", "ordered"};

/// Relative tolerance from which on `ordered` is quicker: of molecules whose joints moved by 0.1 A,
/// one at a time from 2e-2 on, in lanes from 8e-3 on. The choice must not depend on the lanes.
constexpr double loose = 1e-2;

/// Tethers far across, such as a protein's hydrogen bonds, are not in the pattern of `newton`,
/// which takes more iterations for them: of proteins of 600 to 3300 atoms, tethered by default,
/// `ordered` is quicker from 7e-3 to 4e-3 on one at a time, in lanes from 2e-3 to 1e-3 on. By the
/// tethers for each joint, of many joints.
constexpr double loose_if_tethered = 2.5e-3, tethered = 0.02;
constexpr int many = 300;

Choice choice_for(const Piece& piece, const ResolverSettings& settings, bool all_moved) {
  // an order of the user's own is for the solver that has orders
  if (!settings.custom_order.empty()) return ordered;
  if (piece.bars_only && !all_moved) return block;
  const double mean_length = piece.bars > 0 ? piece.length / piece.bars : 1;
  const double relative = settings.tolerance.absolute() ? settings.tolerance.value() / mean_length
                                                        : settings.tolerance.value();
  const bool is_tethered = piece.joints >= many && piece.tethers > tethered * piece.joints;
  return relative >= (is_tethered ? loose_if_tethered : loose) ? ordered : newton;
}

std::unique_ptr<Resolver> make(Choice choice, std::shared_ptr<const Framework> framework,
                               const ResolverSettings& settings) {
  if (choice == block) return make_block_resolver(std::move(framework), settings);
  if (choice == newton) return make_newton_resolver(std::move(framework), settings);
  return make_ordered_resolver(std::move(framework), settings);
}

/// The choices for one kind of break, of all joints or of forced ones.
struct Plan {
  std::vector<Choice> of_piece;
  std::array<int, choices> components = {};

  Plan(const Pieces& pieces, const ResolverSettings& settings, bool all_moved) {
    // joints that nothing holds go along with the others
    Choice any = ordered;
    for (const Piece& piece : pieces.pieces)
      if (!piece.is_free()) any = choice_for(piece, settings, all_moved);
    for (const Piece& piece : pieces.pieces) {
      of_piece.push_back(piece.is_free() ? any : choice_for(piece, settings, all_moved));
      if (!piece.is_free()) components[of_piece.back()] += piece.components;
    }
    if (components == decltype(components){}) components[any] = 1;
  }

  bool takes(Choice choice) const { return components[choice] > 0; }
  bool is_one() const { return takes(block) + takes(newton) + takes(ordered) == 1; }

  std::string text() const {
    std::string all;
    for (const Choice choice : {block, newton, ordered}) {
      if (!takes(choice)) continue;
      if (is_one()) return names[choice];
      const int count = components[choice];
      all += (all.empty() ? "" : ", ") + std::string(names[choice]) + " (" + std::to_string(count) +
             (count == 1 ? " component)" : " components)");
    }
    return all;
  }
};

/// Pieces of one choice, beside others. Positions are copied there and back.
class Share {
 public:
  Share(const Framework& whole, std::span<const unsigned char> taken, Choice choice,
        const ResolverSettings& settings)
      : part_(sub_framework(whole, taken)),
        number_(std::size_t(whole.joint_count()), -1),
        positions_(part_.joints.size()),
        resolver_(make(choice, part_.framework, settings)) {
    for (std::size_t k = 0; k < part_.joints.size(); ++k)
      number_[std::size_t(part_.joints[k])] = int(k);
  }

  const ResolveReport& resolve(std::span<Vec3> x, const Breakage& breakage) {
    roots_.clear();
    for (const int root : breakage.roots)
      if (number_[std::size_t(root)] >= 0) roots_.push_back(number_[std::size_t(root)]);
    // what the promise says of all joints holds for these, which are where they were left
    const bool promised = breakage.only_roots_moved && report_.converged;
    if (promised && roots_.empty()) {
      report_.iterations = report_.bar_visits = report_.carried = 0;
      report_.reason = StopReason::nothing_broken;
      return report_;
    }
    if (promised)
      for (const int root : roots_) take(x, std::size_t(root));
    else
      for (std::size_t k = 0; k < positions_.size(); ++k) take(x, k);
    Breakage own = breakage;
    own.roots = roots_;
    own.only_roots_moved = promised;
    report_ = resolver_->resolve(positions_, own);
    const std::vector<int>* const moved = resolver_->moved_joints();
    if (moved)
      for (const int k : *moved) give(x, std::size_t(k));
    else
      for (std::size_t k = 0; k < positions_.size(); ++k) give(x, k);
    return report_;
  }

 private:
  void take(std::span<const Vec3> x, std::size_t k) {
    positions_[k] = x[std::size_t(part_.joints[k])];
  }
  void give(std::span<Vec3> x, std::size_t k) const {
    x[std::size_t(part_.joints[k])] = positions_[k];
  }

  SubFramework part_;
  std::vector<int> number_;  ///< in the part; -1: not in it (njoint of the whole)
  std::vector<Vec3> positions_;
  std::vector<int> roots_;
  std::unique_ptr<Resolver> resolver_;
  ResolveReport report_;
};

/// The worse of two reasons, of parts that are resolved side by side.
StopReason worse(StopReason a, StopReason b) {
  for (const StopReason reason : {StopReason::not_finite, StopReason::max_iterations,
                                  StopReason::stagnated, StopReason::within_tolerance})
    if (a == reason || b == reason) return reason;
  return StopReason::nothing_broken;
}

class AutomaticResolver final : public Resolver {
 public:
  AutomaticResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)),
        settings_(settings),
        pieces_(pieces_of(*framework_)),
        plans_{{{pieces_, settings_, false}, {pieces_, settings_, true}}},
        latest_(&plans_[1]) {}

  std::string solver() const override { return latest_->text(); }

  const std::vector<int>* moved_joints() const override {
    return alone_ ? alone_->moved_joints() : nullptr;
  }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    check_roots(*framework_, breakage.roots);
    const Plan* const plan = &plans_[breakage.roots.empty()];
    Breakage own = breakage;
    // the promise is about what the same resolvers left
    own.only_roots_moved = breakage.only_roots_moved && latest_ == plan && resolved_;
    latest_ = plan;
    const ResolveReport report =
        plan->is_one() ? resolve_whole(positions, own) : resolve_shares(positions, own);
    resolved_ = report.converged;
    return report;
  }

 private:
  ResolveReport resolve_whole(std::span<Vec3> positions, const Breakage& breakage) {
    const Choice choice = latest_->of_piece.front();
    std::unique_ptr<Resolver>& resolver = whole_[choice];
    if (!resolver) resolver = make(choice, framework_, settings_);
    alone_ = resolver.get();
    return resolver->resolve(positions, breakage);
  }

  ResolveReport resolve_shares(std::span<Vec3> positions, const Breakage& breakage) {
    alone_ = nullptr;
    auto& shares = shares_[std::size_t(latest_ - plans_.data())];
    if (shares.empty()) make_shares(shares);
    ResolveReport all;
    all.converged = true;
    double worst = 0;
    for (Share& share : shares) {
      const ResolveReport& one = share.resolve(positions, breakage);
      all.converged = all.converged && one.converged;
      all.iterations = std::max(all.iterations, one.iterations);
      all.bar_visits += one.bar_visits;
      all.carried += one.carried;
      all.residual = std::max(all.residual, one.residual);
      all.residual_nm = std::max(all.residual_nm, one.residual_nm);
      all.reason = worse(all.reason, one.reason);
      const double violation = settings_.tolerance.absolute() ? one.residual_nm : one.residual;
      if (one.converged || (!all.worst.empty() && !(violation > worst))) continue;
      worst = violation;
      all.worst = one.worst;
    }
    return all;
  }

  void make_shares(std::vector<Share>& shares) const {
    std::vector<unsigned char> taken(pieces_.of_joint.size());
    for (const Choice choice : {block, newton, ordered}) {
      if (!latest_->takes(choice)) continue;
      for (std::size_t j = 0; j < taken.size(); ++j)
        taken[j] = latest_->of_piece[std::size_t(pieces_.of_joint[j])] == choice;
      shares.emplace_back(*framework_, taken, choice, settings_);
    }
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  Pieces pieces_;
  std::array<Plan, 2> plans_;  ///< for forced joints, and for all
  const Plan* latest_;
  bool resolved_ = false;
  std::array<std::unique_ptr<Resolver>, choices> whole_;  ///< made when needed
  std::array<std::vector<Share>, 2> shares_;              ///< of the plans, made when needed
  Resolver* alone_ = nullptr;                             ///< which worked last, if one did
};

}  // namespace

std::string automatic_solver(const Framework& framework, const ResolverSettings& settings,
                             bool all_moved) {
  return Plan(pieces_of(framework), settings, all_moved).text();
}

std::unique_ptr<Resolver> make_automatic_resolver(std::shared_ptr<const Framework> framework,
                                                  const ResolverSettings& settings) {
  return std::make_unique<AutomaticResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
