#include "ragdoll/approach.h"

#include <algorithm>  // any_of, binary_search, erase_if, max, min
#include <cmath>      // sqrt
#include <limits>     // numeric_limits
#include <utility>    // move

#include "ragdoll/common_framework.h"  // nearest_along_bonds
#include "ragdoll/error.h"             // Error
#include "ragdoll/superposition.h"     // superposition

namespace ragdoll {
namespace {

/// A step has to win this share of what the cap was lowered by.
constexpr double least_gain = 0.1;

/// Resolutions of one step, each with more tethers and contacts, before it is taken back.
constexpr int most_rounds = 8;

/// Tethers and contacts so near to their bounds are held beside those that are violated, and
/// released when they are so far inside. nm
constexpr double near_bound = 0.001, released = 0.03;

/// Random moves of one retry.
constexpr int shakes = 4;

/// dalton; hydrogen and deuterium are lighter
constexpr double heavy = 2.5;

/// By how much a step wants to move a close pair apart. nm
constexpr double parting = 0.006;

/// Rounds of mending before the first step.
constexpr int mending_rounds = 60;

/// It ends where more than so many rounds in a row did not bring what is left below this share.
constexpr int most_idle = 4;
constexpr double worth_while = 0.98;

/// Bounds of close pairs follow them in steps of this. nm
constexpr double least_parted = 0.002;

/// Without superposition. nm
double plain_rmsd(std::span<const Vec3> a, std::span<const Vec3> b) {
  double squares = 0;
  for (std::size_t k = 0; k < a.size(); ++k) squares += (a[k] - b[k]).squaredNorm();
  return std::sqrt(squares / double(a.size()));
}

void check(const Framework& framework, std::span<const Vec3> start,
           const ApproachSettings& settings) {
  const std::size_t count = settings.joints.size();
  if (int(start.size()) != framework.joint_count())
    throw Error("there are " + std::to_string(start.size()) + " positions for " +
                std::to_string(framework.joint_count()) + " joints");
  if (count < 3) throw Error("a target needs three joints at least");
  if (settings.target.size() != count)
    throw Error("there are " + std::to_string(settings.target.size()) + " places for " +
                std::to_string(count) + " joints that have a target");
  if (settings.stages.empty()) throw Error("an approach needs a stage");
  for (const std::vector<double>& weights : settings.stages)
    if (weights.size() != count) throw Error("a stage needs one weight for each target");
  if (settings.sites.empty()) throw Error("an approach needs sites");
  for (const int site : settings.sites)
    if (site < 0 || site >= int(count))
      throw Error("site " + std::to_string(site) + " is none of the targets");
  if (!(settings.step > 0) || !(settings.least_step > 0) || !(settings.site_step > 0) ||
      !(settings.spacing > 0) || !(settings.widest >= settings.spacing))
    throw Error("the steps and spacings of an approach must be positive");
}

class Approach {
 public:
  Approach(std::shared_ptr<const Framework> framework, std::span<const Vec3> start,
           const ApproachSettings& settings, const Box* box,
           const std::function<void(const ApproachFrame&)>& take,
           const std::function<bool()>& keep_going)
      : parts_(framework->parts()),
        framework_(std::move(framework)),
        settings_(settings),
        box_(box),
        take_(take),
        keep_going_(keep_going),
        motion_(motion_factory(framework_, start, settings.motion)(settings.resolver.seed)),
        leader_(nearest_along_bonds(*framework_, settings.joints)),
        x_(start.begin(), start.end()),
        shown_(x_),
        in_place_(std::any_of(framework_->fixed().begin(), framework_->fixed().end(),
                              [](std::uint8_t fixed) { return fixed != 0; })),
        held_tethers_(parts_.tethers.size(), false),
        held_contacts_(parts_.contacts.size(), false) {
    make_working_framework();
    for (const int site : settings_.sites) {
      site_joints_.push_back(settings_.joints[std::size_t(site)]);
      site_target_.push_back(settings_.target[std::size_t(site)]);
    }
    // hydrogens are placed less well than what they may keep from
    const auto is_heavy = [&](int joint) {
      return framework_->masses()[std::size_t(joint)] > heavy;
    };
    for (const ClosePair& pair : framework_->contact_rule().close_pairs)
      if (is_heavy(pair.p) && is_heavy(pair.q) &&
          distance(pair.p, pair.q) <= pair.length + least_parted)
        to_part_.emplace_back(pair.p, pair.q);
  }

  ApproachReport run() {
    report_.solver = resolver_->solver();
    report_.rmsd_start = site_rmsd(x_);
    mend_start();
    for (stage_ = 0; stage_ < settings_.stages.size() && !ended(); ++stage_) {
      step_ = settings_.step;
      descend();
      for (int retry = 0; retry < settings_.retries && may_retry(); ++retry) {
        ++report_.retries;
        shake();
      }
    }
    if (report_.steps > 0 && site_rmsd(x_) < shown_rmsd_or_start()) show();
    report_.rmsd_end = site_rmsd(x_);
    report_.target_rmsd_end = rmsd(x_, settings_.joints, settings_.target);
    report_.arrived = report_.rmsd_end <= settings_.arrived;
    report_.solver = resolver_->solver();
    return std::move(report_);
  }

 private:
  using Positions = std::vector<Vec3>;

  double distance(int p, int q) const {
    const Vec3 line = x_[std::size_t(q)] - x_[std::size_t(p)];
    return (box_ ? box_->minimum_image(line) : line).norm();
  }

  bool ended() const { return report_.interrupted || site_rmsd(x_) <= settings_.close; }
  bool may_retry() const { return !ended() && site_rmsd(x_) > settings_.arrived; }

  /// Where joints are fixed, the targets are where they are to be, and are not laid over anything.
  double rmsd(const Positions& x, std::span<const int> joints, const Positions& target) const {
    const Positions here = chosen(x, joints);
    return in_place_ ? plain_rmsd(here, target) : superposed_rmsd(here, target);
  }
  double site_rmsd(const Positions& x) const { return rmsd(x, site_joints_, site_target_); }
  double shown_rmsd_or_start() const {
    return report_.frames > 0 ? shown_rmsd_ : report_.rmsd_start;
  }

  /// The targets as they would lie over the positions, and the stage's RMSD from them.
  double lay(const Positions& x, Positions& targets) const {
    const std::vector<double>& weights = settings_.stages[stage_];
    const Positions here = chosen(x, settings_.joints);
    const RigidMove move = in_place_ ? RigidMove{} : superposition(settings_.target, here, weights);
    targets.resize(here.size());
    double squares = 0, sum = 0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      targets[k] = move(settings_.target[k]);
      squares += weights[k] * (targets[k] - here[k]).squaredNorm();
      sum += weights[k];
    }
    return std::sqrt(squares / sum);
  }
  double stage_rmsd(const Positions& x) const {
    Positions targets;
    return lay(x, targets);
  }

  /// Projects on a cap `lower` below the stage's RMSD; returns the RMSD before.
  double project(Positions& x, double lower) const {
    Positions targets;
    const double rmsd = lay(x, targets);
    const std::vector<double>& weights = settings_.stages[stage_];
    double farthest = 0;
    for (const int site : settings_.sites)
      if (weights[std::size_t(site)] > 0)
        farthest = std::max(farthest, (targets[std::size_t(site)] -
                                       x[std::size_t(settings_.joints[std::size_t(site)])])
                                          .norm());
    double share = rmsd > lower ? lower / rmsd : 1;
    if (share * farthest > settings_.site_step) share = settings_.site_step / farthest;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const double own = weights[k] > 0 ? share : 0;
      targets[k] = own * (targets[k] - x[std::size_t(settings_.joints[k])]);
    }
    for (std::size_t j = 0; j < x.size(); ++j)
      if (leader_[j] >= 0 && !framework_->fixed()[j]) x[j] += targets[std::size_t(leader_[j])];
    return rmsd;
  }

  /// Resolves a trial; whether it can be kept. Most tethers and contacts are far from their bounds,
  /// but each that a solver looks at couples distant parts and slows it: only those are looked at
  /// that were violated before.
  bool resolve(Positions& trial, ResolveReport& resolved) {
    ++report_.steps;
    report_.iterations.push_back(0);
    for (int round = 0; round < most_rounds; ++round) {
      resolved = resolver_->resolve(trial, {.step = std::uint64_t(report_.steps - 1), .box = box_});
      report_.iterations.back() += resolved.iterations;
      if (!resolved.converged) break;
      if (!hold_violated(trial)) break;
      resolved.converged = false;
    }
    if (!resolved.converged) {
      report_.last_rejection = name_of(resolved.reason) + ": " + resolved.worst;
      return false;
    }
    if (const int inverted = inverted_centres(*framework_, trial); inverted > 0) {
      report_.last_rejection = std::to_string(inverted) + " inverted centre(s)";
      return false;
    }
    return true;
  }

  /// Takes violated tethers and contacts into the working framework; whether there were any.
  bool hold_violated(const Positions& x) {
    const Tolerance& tolerance = settings_.resolver.tolerance;
    const auto far = [&](const auto& pair) {
      const Vec3 line = x[std::size_t(pair.q)] - x[std::size_t(pair.p)];
      return (box_ ? box_->minimum_image(line) : line).norm() - pair.length;
    };
    bool changed = false;
    const auto look = [&](const auto& pairs, std::vector<bool>& held, double sign) {
      for (std::size_t k = 0; k < pairs.size(); ++k)
        if (!held[k] && sign * far(pairs[k]) > tolerance.slack(pairs[k].length))
          changed = held[k] = true;
    };
    look(parts_.tethers, held_tethers_, 1);
    look(parts_.contacts, held_contacts_, -1);
    if (!changed) return false;
    const auto tidy = [&](const auto& pairs, std::vector<bool>& held, double sign) {
      for (std::size_t k = 0; k < pairs.size(); ++k)
        held[k] = sign * far(pairs[k]) > (held[k] ? -released : -near_bound);
    };
    tidy(parts_.tethers, held_tethers_, 1);
    tidy(parts_.contacts, held_contacts_, -1);
    make_working_framework();
    return true;
  }

  /// Everything but the tethers and contacts that are not held.
  void make_working_framework() {
    FrameworkParts working = parts_;
    const auto choose = [](auto& pairs, const std::vector<bool>& held) {
      std::size_t kept = 0;
      for (std::size_t k = 0; k < pairs.size(); ++k)
        if (held[k]) pairs[kept++] = pairs[k];
      pairs.resize(kept);
    };
    choose(working.tethers, held_tethers_);
    choose(working.contacts, held_contacts_);
    framework_ = std::make_shared<const Framework>(std::move(working));
    resolver_ = make_resolver(framework_, settings_.resolver);
  }

  Random random() const {
    return {settings_.resolver.seed, RandomStream::perturbation, std::uint64_t(report_.steps)};
  }

  /// What is wrong with the start is mended on the way: implausible torsions, pairs too close.
  /// @return  how much there is to mend: nm, and 0.1 nm for each radian
  double mend(Positions& x, double share = 1) const {
    double asked = 0;
    if (settings_.guide) {
      const Positions before = in_place_ ? x : Positions{};
      asked += 0.1 * settings_.guide->move(x, share);
      for (std::size_t j = 0; j < before.size(); ++j)
        if (framework_->fixed()[j]) x[j] = before[j];
    }
    if (!settings_.part_close_pairs) return asked;
    const ContactRule& rule = framework_->contact_rule();
    for (const auto& [first, second] : to_part_) {
      Vec3& p = x[std::size_t(first)];
      Vec3& q = x[std::size_t(second)];
      const Vec3 line = box_ ? box_->minimum_image(q - p) : Vec3(q - p);
      const double distance = line.norm();
      const double lacking = rule.rule_bound(first, second) - distance;
      if (!(lacking > 0) || !(distance > 0)) continue;
      asked += lacking;
      const Vec3 half = line * (0.5 * std::min(share * parting, lacking) / distance);
      if (!framework_->fixed()[std::size_t(first)]) p -= half;
      if (!framework_->fixed()[std::size_t(second)]) q += half;
    }
    return asked;
  }

  /// The start, before it moves.
  void mend_start() {
    if (settings_.mended_stages == 0) return;
    double share = 1, least = std::numeric_limits<double>::infinity();
    int idle = 0;
    for (int round = 0; round < mending_rounds && go_on(); ++round) {
      Positions trial = x_;
      const double asked = mend(trial, share);
      idle = asked > worth_while * least ? idle + 1 : 0;
      if (asked == 0 || idle > most_idle) break;
      least = std::min(least, asked);
      ResolveReport resolved;
      if (!resolve(trial, resolved) || moved(trial) > settings_.widest) {
        ++report_.rejected_steps;
        share *= 0.5;
        continue;
      }
      share = std::min(1.0, 1.4 * share);
      x_ = std::move(trial);
      last_ = std::move(resolved);
      if (round % 4 == 3) hold_parted_pairs();
    }
    hold_parted_pairs();
  }

  /// Pairs that came apart stay so: their bounds follow them up to the rule's.
  void hold_parted_pairs() {
    if (!settings_.part_close_pairs || to_part_.empty()) return;
    ContactRule& rule = parts_.contact_rule;
    bool changed = false;
    std::erase_if(rule.close_pairs, [&](ClosePair& pair) {
      if (!std::binary_search(to_part_.begin(), to_part_.end(), std::pair(pair.p, pair.q)))
        return false;
      const double now = distance(pair.p, pair.q), most = rule.rule_bound(pair.p, pair.q);
      if (now <= pair.length + least_parted) return false;
      changed = true;
      pair.length = std::min(now, most);
      return now >= most;
    });
    if (changed) make_working_framework();
  }

  /// How far the site that moved most is from where the last frame had it.
  double moved(const Positions& x) const {
    double most = 0;
    for (const int joint : site_joints_)
      most = std::max(most, (x[std::size_t(joint)] - shown_[std::size_t(joint)]).norm());
    return most;
  }

  bool go_on() {
    if (keep_going_ && !keep_going_()) report_.interrupted = true;
    return !report_.interrupted;
  }

  /// Lowers the cap until the stage comes no further.
  void descend() {
    while (step_ >= settings_.least_step && !ended() && go_on()) {
      Positions trial = x_;
      if (settings_.wander) {
        Random numbers = random();
        motion_->move(trial, numbers);
      }
      const double lower = std::min(step_, std::max(stage_rmsd(x_), settings_.least_step));
      project(trial, lower);
      if (stage_ < settings_.mended_stages) mend(trial);
      ResolveReport resolved;
      const double before = stage_rmsd(x_);
      const bool kept = resolve(trial, resolved) && moved(trial) <= settings_.widest &&
                        stage_rmsd(trial) < before - least_gain * lower_of(x_, lower);
      if (!kept) {
        ++report_.rejected_steps;
        if (settings_.wander) motion_->taken_back();
        step_ *= 0.5;
        continue;
      }
      if (settings_.wander) motion_->kept(x_, trial);
      x_ = std::move(trial);
      last_ = std::move(resolved);
      step_ = std::min(settings_.step, 1.4 * step_);
      if (moved(x_) >= settings_.spacing && site_rmsd(x_) < shown_rmsd_or_start()) show();
    }
  }

  /// What a step really asks for, where sites may not move as far.
  double lower_of(const Positions& x, double lower) const {
    Positions asked = x;
    const double before = project(asked, lower);
    return std::max(0.0, before - stage_rmsd(asked));
  }

  /// Random moves, then down again; what comes of it stays where it is nearer in the end.
  void shake() {
    const Positions before = x_;
    const ResolveReport report = last_;
    const double rmsd = site_rmsd(x_);
    for (int k = 0; k < shakes && go_on(); ++k) {
      Positions trial = x_;
      Random numbers = random();
      motion_->move(trial, numbers);
      ResolveReport resolved;
      if (resolve(trial, resolved) && moved(trial) <= settings_.widest) {
        motion_->kept(x_, trial);
        x_ = std::move(trial);
        last_ = std::move(resolved);
      } else {
        ++report_.rejected_steps;
        motion_->taken_back();
      }
    }
    step_ = settings_.step;
    const std::int64_t frames = report_.frames;
    descend();
    if (report_.frames == frames && site_rmsd(x_) >= rmsd) {
      x_ = before;
      last_ = report;
    }
  }

  void show() {
    hold_parted_pairs();
    shown_ = x_;
    shown_rmsd_ = site_rmsd(x_);
    ApproachFrame frame;
    frame.number = report_.frames++;
    frame.steps = report_.steps;
    frame.rmsd = shown_rmsd_;
    frame.target_rmsd = rmsd(x_, settings_.joints, settings_.target);
    frame.report = last_;
    frame.positions = x_;
    take_(frame);
  }

  FrameworkParts parts_;                        ///< of the whole framework
  std::shared_ptr<const Framework> framework_;  ///< the one that is worked with
  const ApproachSettings& settings_;
  const Box* box_;
  const std::function<void(const ApproachFrame&)>& take_;
  const std::function<bool()>& keep_going_;
  std::unique_ptr<Resolver> resolver_;
  std::unique_ptr<Motion> motion_;
  std::vector<int> leader_;                   ///< target whose way a joint goes (njoint)
  std::vector<std::pair<int, int>> to_part_;  ///< pairs too close at the start, in their order
  std::vector<int> site_joints_;
  Positions site_target_;
  Positions x_, shown_;  ///< now, and in the last frame, nm (njoint)
  double shown_rmsd_ = 0;
  bool in_place_;                                   ///< there are fixed joints
  std::vector<bool> held_tethers_, held_contacts_;  ///< that are in the working framework
  std::size_t stage_ = 0;
  double step_ = 0;
  ResolveReport last_ = {};
  ApproachReport report_ = {};
};

}  // namespace

ApproachReport approach(std::shared_ptr<const Framework> framework, std::span<const Vec3> start,
                        const ApproachSettings& settings, const Box* box,
                        const std::function<void(const ApproachFrame&)>& take,
                        const std::function<bool()>& keep_going) {
  check(*framework, start, settings);
  return Approach(std::move(framework), start, settings, box, take, keep_going).run();
}

}  // namespace ragdoll
