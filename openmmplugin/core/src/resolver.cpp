#include "ragdoll/resolver.h"

#include <algorithm>  // max, minmax
#include <array>
#include <cmath>        // abs, cbrt, isfinite
#include <cstdio>       // snprintf
#include <limits>       // infinity
#include <type_traits>  // is_same
#include <utility>      // pair, move

#include "constraints.h"           // volume_violation
#include "names.h"                 // name_in, value_of
#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/error.h"         // Error
#include "resolver_auto.h"         // make_automatic_resolver
#include "resolver_block.h"        // make_block_resolver
#include "resolver_newton.h"       // make_newton_resolver
#include "resolver_ordered.h"      // make_ordered_resolver
#include "resolver_templates.h"    // make_templates_resolver
#include "stereo.h"                // is_inverted, is_cis

namespace ragdoll {
namespace {

constexpr std::array<std::pair<StopReason, const char*>, 5> reasons = {{
    {StopReason::nothing_broken, "nothing broken"},
    {StopReason::within_tolerance, "within tolerance"},
    {StopReason::max_iterations, "maximum of iterations"},
    {StopReason::not_finite, "not a finite number"},
    {StopReason::stagnated, "stagnated"},
}};

constexpr std::array<std::pair<Precision, const char*>, 2> precisions = {{
    {Precision::single, "single"},
    {Precision::double_, "double"},
}};

using MakeResolver = std::unique_ptr<Resolver> (*)(std::shared_ptr<const Framework>,
                                                   const ResolverSettings&);

/// The solvers, by name: a new one adds its line here.
constexpr std::array<std::pair<const char*, MakeResolver>, 5> solvers = {{
    {"block", make_block_resolver},
    {"newton", make_newton_resolver},
    {"ordered", make_ordered_resolver},
    {"templates", make_templates_resolver},
    {"auto", make_automatic_resolver},
}};

void check_settings(const Framework& framework, const ResolverSettings& settings) {
  if (!(settings.tolerance.value() > 0) || !std::isfinite(settings.tolerance.value()))
    throw Error("the tolerance must be a positive number");
  if (settings.max_iterations < 1) throw Error("the maximum of iterations must be 1 or more");
  for (const Visit& visit : settings.custom_order) {
    const bool known = visit.bar >= 0 && visit.bar < int(framework.bars().size());
    const Bar bar = known ? framework.bars()[std::size_t(visit.bar)] : Bar{};
    if (!known || std::minmax(visit.near, visit.far) != std::minmax(bar.p, bar.q))
      throw Error("the custom order visits a bar that the framework does not have");
  }
  const bool tree_order =
      settings.order == OrderKind::bfs_tree || settings.order == OrderKind::dfs_tree;
  if (tree_order && settings.custom_order.empty() &&
      cycle_rank(framework.graph(), framework.components()) > 0)
    throw Error("order " + name_of(settings.order) +
                " leaves out the bars that close cycles, and this framework has cycles; choose "
                "bfs_cycle or dfs_cycle");
}

/// "tether" or the like where the user set it, else where it comes from: "hydrogen bond".
template <class Pair>
std::string noun_of(const Pair& pair, const char* plain) {
  using Kind = decltype(pair.kind);
  if (pair.kind == Kind::user) return plain;
  const std::string name = name_of(pair.kind);
  // what is no noun by itself
  if constexpr (std::is_same_v<Kind, TetherKind>)
    if (pair.kind == Kind::hydrophobic || pair.kind == Kind::stacking ||
        pair.kind == Kind::backbone)
      return name + " tether";
  if constexpr (std::is_same_v<Kind, ContactKind>)
    if (pair.kind == Kind::backbone || pair.kind == Kind::side_chain) return name + " contact";
  return name;
}

std::string pair_sentence(const Framework& framework, const std::string& kind, int p, int q,
                          double distance, double length, const char* relation) {
  char numbers[96];
  std::snprintf(numbers, sizeof numbers, " is %.5g nm long instead of %s%.5g", distance, relation,
                length);
  return kind + " " + framework.name(p) + " - " + framework.name(q) + numbers;
}

/// Keeps the largest violations, and what it takes to describe the one that the tolerance forgives
/// least.
class Worst {
 public:
  explicit Worst(bool by_length) : by_length_(by_length) {}

  void consider(double relative, double nanometers, int kind, std::size_t index, double value) {
    // a violation that is no number is the worst of all
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (std::isnan(relative) || std::isnan(nanometers)) relative = nanometers = infinity;
    const bool worse = by_length_ ? nanometers > nanometers_ : relative > relative_;
    relative_ = std::max(relative_, relative);
    nanometers_ = std::max(nanometers_, nanometers);
    if (!worse) return;
    kind_ = kind;
    index_ = index;
    value_ = value;
  }

  bool by_length_;
  double relative_ = 0, nanometers_ = 0;
  int kind_ = -1;
  std::size_t index_ = 0;
  double value_ = 0;
};

}  // namespace

std::string name_of(StopReason reason) {
  return name_in(reasons, reason);
}

Precision precision_of(const std::string& name) {
  return value_of(precisions, name, "precision");
}

std::string name_of(Precision precision) {
  return name_in(precisions, precision);
}

std::vector<std::string> solver_names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : solvers) names.emplace_back(name);
  return names;
}

std::unique_ptr<Resolver> make_resolver(std::shared_ptr<const Framework> framework,
                                        const ResolverSettings& settings) {
  check_settings(*framework, settings);
  for (const auto& [name, make] : solvers)
    if (settings.solver == name) return make(std::move(framework), settings);
  std::string known;
  for (const std::string& name : solver_names()) known += (known.empty() ? "" : ", ") + name;
  throw Error("solver '" + settings.solver + "' is not known; choose one of: " + known);
}

Violation worst_violation(const Framework& framework, std::span<const Vec3> positions,
                          const Box* box, const Tolerance& tolerance) {
  const auto x = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  const auto distance = [&](int p, int q) { return (x(q) - x(p)).norm(); };
  enum { bar, tether, contact, near_pair, volume };
  Worst worst(tolerance.absolute());
  const auto consider_pair = [&](double excess, double length, int kind, std::size_t k, double d) {
    worst.consider(excess / length, excess, kind, k, d);
  };

  for (std::size_t k = 0; k < framework.bars().size(); ++k) {
    const Bar& b = framework.bars()[k];
    const double d = distance(b.p, b.q);
    consider_pair(std::abs(d - b.length), b.length, bar, k, d);
  }
  for (std::size_t k = 0; k < framework.tethers().size(); ++k) {
    const Tether& t = framework.tethers()[k];
    const double d = distance(t.p, t.q);
    consider_pair(d - t.length, t.length, tether, k, d);
  }
  for (std::size_t k = 0; k < framework.contacts().size(); ++k) {
    const Contact& c = framework.contacts()[k];
    const double d = distance(c.p, c.q);
    consider_pair(c.length - d, c.length, contact, k, d);
  }
  for (std::size_t k = 0; k < framework.volumes().size(); ++k) {
    const Volume& v = framework.volumes()[k];
    const double value = signed_volume(x(v.a), x(v.b), x(v.c), x(v.d));
    const double relative = std::isfinite(value) ? volume_violation(v, value) : value - value;
    worst.consider(relative, relative * std::cbrt(v.scale), volume, k, value);
  }
  // pairs of the contact rule; positions that are no numbers cannot be sorted into cells
  ContactList list(framework.contact_rule(), 1e-9);
  if (!framework.contact_rule().empty() && worst.relative_ < 1e300) {
    list.update(positions, box, 0);
    for (std::size_t k = 0; k < list.pairs().size(); ++k) {
      const NearPair& pair = list.pairs()[k];
      Vec3 d = x(pair.q) - x(pair.p);
      if (box) d = box->minimum_image(d);
      consider_pair(pair.bound - d.norm(), pair.bound, near_pair, k, d.norm());
    }
  }

  Violation result{worst.relative_, worst.nanometers_, ""};
  const std::size_t k = worst.index_;
  if (worst.kind_ == bar) {
    const Bar& b = framework.bars()[k];
    const std::string noun = b.kind == BarKind::metal ? "metal bar" : "bar";
    result.what = pair_sentence(framework, noun, b.p, b.q, worst.value_, b.length, "");
  } else if (worst.kind_ == tether) {
    const Tether& t = framework.tethers()[k];
    result.what = pair_sentence(framework, noun_of(t, "tether"), t.p, t.q, worst.value_, t.length,
                                "at most ");
  } else if (worst.kind_ == contact) {
    const Contact& c = framework.contacts()[k];
    result.what = pair_sentence(framework, noun_of(c, "contact"), c.p, c.q, worst.value_, c.length,
                                "at least ");
  } else if (worst.kind_ == near_pair) {
    const NearPair& c = list.pairs()[k];
    result.what = pair_sentence(framework, "contact", c.p, c.q, worst.value_, c.bound, "at least ");
  } else if (worst.kind_ == volume) {
    const Volume& v = framework.volumes()[k];
    result.what = name_of(v.kind) + " of " + framework.name(v.a) + ", " + framework.name(v.b) +
                  ", " + framework.name(v.c) + ", " + framework.name(v.d) +
                  " is outside its bounds";
  }
  return result;
}

int inverted_centres(const Framework& framework, std::span<const Vec3> positions) {
  int inverted = 0;
  for (std::size_t k = 0; k < framework.volumes().size(); ++k)
    if (is_inverted(framework, k, positions)) ++inverted;
  for (const PlanarTorsion& t : framework.planar_torsions())
    if (is_cis(positions, t) != t.cis) ++inverted;
  return inverted;
}

}  // namespace ragdoll
