#include "ragdoll/ring_conformers.h"

#include <algorithm>  // max, min, sort, any_of
#include <array>
#include <cmath>  // cos, exp, isfinite
#include <limits>
#include <memory>
#include <numbers>  // pi
#include <numeric>  // iota
#include <optional>
#include <utility>  // move

#include "pliant_rings.h"               // PliantRings
#include "ragdoll/ensemble_resolver.h"  // make_ensemble_resolver, resolve_all
#include "ragdoll/error.h"              // Error
#include "ragdoll/random.h"             // Random
#include "ragdoll/superposition.h"      // superposition
#include "ring_break.h"                 // RingBreak
#include "ring_frame.h"                 // restricted, add_ring_centres
#include "ring_sterics.h"               // RingSterics
#include "ring_torsions.h"              // RingTorsions, TorsionScore

namespace ragdoll {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// Rings from this size on are opened to change their shape.
constexpr int large_ring = 9;

/// Of resolving on the way, relative.
constexpr double rough_tolerance = 4e-3;

/// No break is worth more iterations than this.
constexpr long most_iterations = 40;

/// How often torsions are led on and constraints resolved again, and how far a joint goes at most.
constexpr int leads = 12;
constexpr double longest_lead = 0.02, momentum = 0.85;  // nm

/// Of large rings, the same with all that hangs on them, whose crowding has a say by so much; from
/// so many times as many shapes as are wanted. Contacts are held at the end.
constexpr int large_leads = 30, large_choice = 6;
constexpr double steric_step = 2.5e-4;  // nm^2 mol/kJ

/// Breaks in one round; a round that finds nothing new is the last.
constexpr int round_size = 16, large_round_size = 128;

/// Rings of at most so many atoms have their contacts written out.
constexpr std::size_t few_atoms = 16;

/// A term's amplitudes are scaled down to this sum. As fitted, those of small rings put a twist
/// boat five times as high above a chair as it is. kJ/mol
constexpr double largest_amplitude = 7;

/// Bonds of rings that no term knows of are staggered by this. kJ/mol, one of two sides of a
/// threefold term
constexpr double staggering = 6;

/// Where gaps are filled, atoms of one ring system may be strained together to this share of what
/// contacts allow else, and angles play by so many times as much.
constexpr double strained_scale = 0.42, strained_play = 1.5;

/// What is bonded to a small ring is gauche to the ring at this cost at most. kJ/mol
constexpr double crowding = 4.5;
constexpr int crowded_ring = 8;

/// Where large rings are broken, torsions are drawn as if at this temperature. kJ/mol
constexpr double warmth = 4;

/// Shapes of one ring system's atoms.
struct Shapes {
  std::size_t atoms = 0;
  std::vector<Vec3> positions;  ///< one behind the other

  std::size_t count() const { return atoms == 0 ? 0 : positions.size() / atoms; }
  std::span<Vec3> at(std::size_t k) { return std::span(positions).subspan(k * atoms, atoms); }
  std::span<const Vec3> at(std::size_t k) const {
    return std::span(positions).subspan(k * atoms, atoms);
  }
  void add(std::span<const Vec3> shape) {
    positions.insert(positions.end(), shape.begin(), shape.end());
  }
};

/// A shape that was resolved, and what tells it apart.
struct Candidate {
  std::vector<Vec3> positions;  ///< of the ring atoms, then of others where they are placed
  std::vector<float> torsions;
  double energy = 0;
};

class RingSampler {
 public:
  RingSampler(const Molecule& molecule, const RingSystem& system, const PliantRings& pliant,
              const FrameworkParts& loosened, std::span<const TorsionTerm> terms,
              const RingSettings& settings, std::uint64_t stream)
      : molecule_(molecule),
        system_(system),
        pliant_(pliant),
        settings_(settings),
        stream_(stream),
        atoms_(system.atoms),
        torsions_(molecule, system, pliant),
        score_(score_terms(terms)) {
    for (const int atom : system.atoms)
      for (const auto& [other, bond] : molecule.neighbours(atom))
        if (!pliant.in_ring(bond)) atoms_.push_back(other);
    ring_ = system.atoms.size();
    FrameworkParts rings = restricted(loosened, system.atoms);
    add_ring_centres(molecule, pliant, system.atoms, rings);
    if (ring_ <= few_atoms) write_out_contacts(rings);
    rings_ = std::make_shared<const Framework>(std::move(rings));
    FrameworkParts all = restricted(loosened, atoms_);
    all_ = std::make_shared<const Framework>(all);
    all.contact_rule = {};
    yielding_ = std::make_shared<const Framework>(std::move(all));
    sterics_.emplace(molecule, atoms_);
    for (const int atom : system.atoms) start_.push_back(molecule.positions()[std::size_t(atom)]);
    find_crowded();
  }

  std::optional<RingPool> sample() {
    if (torsions_.torsions().empty()) return std::nullopt;
    add(start_, true);
    search();
    fill();
    return place();
  }

 private:
  // === What is looked for

  int local(int atom) const {
    const auto at = std::lower_bound(system_.atoms.begin(), system_.atoms.end(), atom);
    return at != system_.atoms.end() && *at == atom ? int(at - system_.atoms.begin()) : -1;
  }

  int ring_neighbour(int atom, int but) const {
    for (const auto& [other, bond] : molecule_.neighbours(atom))
      if (other != but && pliant_.in_ring(bond) && local(other) >= 0) return other;
    return -1;
  }

  double torsion_at_start(int a, int b, int c, int d) const {
    const auto& x = molecule_.positions();
    return torsion_of(x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)], x[std::size_t(d)]);
  }

  bool is_turning_bond(int b, int c) const {
    for (const auto& [other, bond] : molecule_.neighbours(b))
      if (other == c) return pliant_.turns(bond);
    return false;
  }

  /// Terms about bonds of the rings that turn, by ring atoms alone: another end is told by a ring
  /// atom beside it. Bonds without a term are staggered.
  std::vector<ShiftedTerm> score_terms(std::span<const TorsionTerm> terms) const {
    std::vector<ShiftedTerm> found;
    std::vector<std::pair<int, int>> known;
    for (const TorsionTerm& term : terms) {
      if (local(term.b) < 0 || local(term.c) < 0 || !is_turning_bond(term.b, term.c)) continue;
      const int a = local(term.a) >= 0 ? term.a : ring_neighbour(term.b, term.c);
      const int d = local(term.d) >= 0 ? term.d : ring_neighbour(term.c, term.b);
      if (a < 0 || d < 0 || a == d) continue;
      ShiftedTerm shifted{term, torsion_at_start(term.a, term.b, term.c, term.d) -
                                    torsion_at_start(a, term.b, term.c, d)};
      shifted.term.a = local(a);
      shifted.term.b = local(term.b);
      shifted.term.c = local(term.c);
      shifted.term.d = local(d);
      double sum = 0;
      for (const double amplitude : term.amplitude) sum += std::abs(amplitude);
      if (sum > largest_amplitude)
        for (double& amplitude : shifted.term.amplitude) amplitude *= largest_amplitude / sum;
      found.push_back(shifted);
      known.push_back(std::minmax(term.b, term.c));
    }
    for (const int bond : system_.bonds) {
      const Bond& of = molecule_.bonds()[std::size_t(bond)];
      if (!pliant_.turns(bond) || pliant_.units().planar_atom(of.a) ||
          pliant_.units().planar_atom(of.b))
        continue;
      const std::pair<int, int> axis = std::minmax(of.a, of.b);
      if (std::find(known.begin(), known.end(), axis) != known.end()) continue;
      const int a = ring_neighbour(of.a, of.b), d = ring_neighbour(of.b, of.a);
      if (a < 0 || d < 0 || a == d) continue;
      found.push_back(
          {{local(a), local(of.a), local(of.b), local(d), {0, 0, staggering}, {0, 0, 1}}, 0});
    }
    return found;
  }

  /// Heavy atoms beside the rings and the ring atoms that they may crowd.
  void find_crowded() {
    for (std::size_t k = ring_; k < atoms_.size(); ++k) {
      if (molecule_.atoms()[std::size_t(atoms_[k])].element == 1) continue;
      for (const auto& [b, bond] : molecule_.neighbours(atoms_[k])) {
        if (local(b) < 0 || pliant_.units().planar_atom(b)) continue;
        for (const auto& [c, bc] : molecule_.neighbours(b)) {
          if (local(c) < 0 || !pliant_.turns(bc) || size_of(bc) > crowded_ring) continue;
          for (const auto& [d, cd] : molecule_.neighbours(c))
            if (d != b && pliant_.in_ring(cd) && local(d) >= 0)
              crowded_.push_back({int(k), local(b), local(c), local(d)});
        }
      }
    }
  }

  int size_of(int bond) const {
    const auto at = std::lower_bound(system_.bonds.begin(), system_.bonds.end(), bond);
    return system_.ring_size[std::size_t(at - system_.bonds.begin())];
  }

  RingBreak ring_break() const {
    std::vector<RingBreak::Link> links;
    for (std::size_t k = 0; k < system_.bonds.size(); ++k) {
      const Bond& bond = molecule_.bonds()[std::size_t(system_.bonds[k])];
      RingBreak::Link link{local(bond.a),
                           local(bond.b),
                           pliant_.turns(system_.bonds[k]),
                           system_.ring_size[k] >= large_ring,
                           {},
                           {}};
      if (link.turns) {
        link.torsion = {local(ring_neighbour(bond.a, bond.b)), link.a, link.b,
                        local(ring_neighbour(bond.b, bond.a))};
        link.share = shares(link);
      }
      links.push_back(std::move(link));
    }
    return RingBreak(int(ring_), std::move(links));
  }

  std::vector<float> shares(const RingBreak::Link& link) const {
    std::array<double, RingBreak::bins> energy{};
    const auto at = [&](int which) -> const Vec3& { return start_[std::size_t(which)]; };
    const double own = torsion_of(at(link.torsion[0]), at(link.torsion[1]), at(link.torsion[2]),
                                  at(link.torsion[3]));
    for (const auto& [t, shift] : score_.terms()) {
      if (std::minmax(t.b, t.c) != std::minmax(link.a, link.b)) continue;
      const double offset = torsion_of(at(t.a), at(t.b), at(t.c), at(t.d)) + shift - own;
      for (int k = 0; k < RingBreak::bins; ++k)
        energy[std::size_t(k)] +=
            value_of(t, 2 * std::numbers::pi * (k + 0.5) / RingBreak::bins + offset).energy;
    }
    const double least = *std::min_element(energy.begin(), energy.end());
    std::vector<float> share(RingBreak::bins);
    double sum = 0;
    for (std::size_t k = 0; k < share.size(); ++k)
      share[k] = float(sum += std::exp((least - energy[k]) / warmth));
    for (float& s : share) s /= float(sum);
    return share;
  }

  // === Break and resolve

  std::unique_ptr<EnsembleResolver> resolver(std::shared_ptr<const Framework> framework,
                                             double tolerance) const {
    return make_ensemble_resolver(
        std::move(framework),
        {.solver = "newton", .tolerance = tolerance, .max_iterations = most_iterations});
  }

  /// Resolved, and nothing turned inside out; others are left out.
  void keep_resolved(EnsembleResolver& resolver, const Framework& framework, Shapes& shapes) const {
    const std::vector<ResolveReport> reports = resolve_all(resolver, shapes.positions);
    Shapes kept{shapes.atoms, {}};
    for (std::size_t k = 0; k < reports.size(); ++k)
      if (reports[k].converged && inverted_centres(framework, shapes.at(k)) == 0)
        kept.add(shapes.at(k));
    shapes = std::move(kept);
  }

  Shapes broken(const RingBreak& breaks, int first, int count) const {
    Shapes shapes{ring_, {}};
    for (int k = first; k < first + count; ++k) {
      Random random(settings_.seed, RandomStream::perturbation, (stream_ << 32) + std::uint64_t(k));
      std::vector<Vec3> x = start_;
      // every other one from a shape that was found before
      if (k % 2 == 1 && !minima_.empty()) {
        const Candidate& from = minima_[random.below(minima_.size())];
        x.assign(from.positions.begin(), from.positions.end());
      }
      breaks.apply(x, random);
      shapes.add(x);
    }
    return shapes;
  }

  /// Torsions are led to what they like, and constraints resolved, again and again.
  void lead(EnsembleResolver& rough, Shapes& shapes, int rounds, bool crowds) const {
    std::vector<Vec3> before = shapes.positions, step(shapes.positions.size(), Vec3::Zero());
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t k = 0; k < shapes.count(); ++k) {
        const std::span<Vec3> x = shapes.at(k),
                              d = std::span(step).subspan(k * shapes.atoms, shapes.atoms);
        std::vector<Vec3> led(shapes.atoms, Vec3::Zero());
        score_.lead(x, led);
        if (crowds) sterics_->push(x, steric_step, led);
        double along = 0, longest = 0;
        for (std::size_t j = 0; j < led.size(); ++j) along += led[j].dot(d[j]);
        for (std::size_t j = 0; j < led.size(); ++j) {
          if (along > 0) led[j] += momentum * d[j];
          longest = std::max(longest, led[j].norm());
        }
        const double scale = longest > longest_lead ? longest_lead / longest : 1;
        for (std::size_t j = 0; j < led.size(); ++j) x[j] += scale * led[j];
      }
      resolve_all(rough, shapes.positions);
      for (std::size_t j = 0; j < step.size(); ++j) step[j] = shapes.positions[j] - before[j];
      before = shapes.positions;
    }
  }

  bool is_large() const { return system_.largest_ring() >= large_ring; }

  int attempts() const {
    if (settings_.attempts > 0) return settings_.attempts;
    if (settings_.fill) return std::max(64, 6 * settings_.count);
    const int turning = int(torsions_.torsions().size());
    return is_large() ? std::clamp(10 * settings_.count, 192, 1024)
                      : std::clamp(8 * turning, 32, 192);
  }

  void search() {
    rough_ = resolver(rings_, rough_tolerance);
    exact_ = resolver(rings_, settings_.tolerance);
    breaks_.emplace(ring_break());
    const int most = attempts();
    for (tried_ = 0; tried_ < most;) {
      const int count = std::min(is_large() ? large_round_size : round_size, most - tried_);
      Shapes shapes = broken(*breaks_, tried_, count);
      tried_ += count;
      keep_resolved(*rough_, *rings_, shapes);
      if (settings_.fill)
        for (std::size_t k = 0; k < shapes.count(); ++k) add(shapes.at(k), false);
      lead(*rough_, shapes, leads, false);
      keep_resolved(*exact_, *rings_, shapes);
      bool is_new = false;
      for (std::size_t k = 0; k < shapes.count(); ++k)
        is_new = add(shapes.at(k), true) && minima_.back().energy <= most_energy() ? true : is_new;
      if (!is_new && !is_large() && !settings_.fill) break;
    }
  }

  double most_energy() const {
    double least = std::numeric_limits<double>::infinity();
    for (const Candidate& one : minima_) least = std::min(least, one.energy);
    return least + settings_.energy_window;
  }

  /// @return whether it is another one than those before
  bool add(std::span<const Vec3> shape, bool led) {
    Candidate candidate{
        {shape.begin(), shape.end()}, torsions_.measure(shape), score_.energy(shape)};
    if (!led) {
      others_.push_back(std::move(candidate));
      return true;
    }
    for (Candidate& before : minima_) {
      if (torsions_.distance(before.torsions, candidate.torsions) >
          settings_.distinct_degree * degree)
        continue;
      if (candidate.energy < before.energy) before = std::move(candidate);
      return false;
    }
    minima_.push_back(std::move(candidate));
    return true;
  }

  // === Choice

  /// Furthest from those chosen, one after the other.
  std::vector<std::size_t> furthest(const std::vector<Candidate>& of, std::size_t wanted,
                                    double least, const std::vector<const Candidate*>& beside,
                                    bool lowest_first) const {
    std::vector<double> distance(of.size(), std::numeric_limits<double>::infinity());
    std::vector<std::size_t> chosen;
    const auto take = [&](const Candidate& one) {
      for (std::size_t k = 0; k < of.size(); ++k)
        if (distance[k] > 0)
          distance[k] = std::min(distance[k], torsions_.distance(one.torsions, of[k].torsions));
    };
    for (const Candidate* one : beside) take(*one);
    if (lowest_first && !of.empty()) {
      std::size_t lowest = 0;
      for (std::size_t k = 1; k < of.size(); ++k)
        if (of[k].energy < of[lowest].energy) lowest = k;
      chosen.push_back(lowest);
      take(of[lowest]);
    }
    while (chosen.size() < wanted) {
      const auto far = std::max_element(distance.begin(), distance.end());
      if (far == distance.end() || !(*far > least)) break;
      chosen.push_back(std::size_t(far - distance.begin()));
      take(of[chosen.back()]);
    }
    return chosen;
  }

  void sort_by_energy(std::vector<Candidate>& candidates) const {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.energy < b.energy; });
  }

  /// Those that no one before is like.
  std::vector<Candidate> leaders(std::vector<Candidate> of) const {
    std::vector<Candidate> kept;
    for (Candidate& one : of)
      if (std::none_of(kept.begin(), kept.end(), [&](const Candidate& before) {
            return torsions_.distance(before.torsions, one.torsions) <=
                   settings_.distinct_degree * degree;
          }))
        kept.push_back(std::move(one));
    return kept;
  }

  /// Of too many minima those that are apart; of too few, shapes between them.
  void fill() {
    sort_by_energy(minima_);
    const double most = most_energy();
    std::erase_if(minima_, [&](const Candidate& c) { return c.energy > most; });
    const std::size_t wanted = std::size_t(settings_.count * (is_large() ? large_choice : 1));
    if (minima_.size() > wanted) {
      std::vector<Candidate> kept;
      for (const std::size_t k : furthest(minima_, wanted, 0, {}, true)) kept.push_back(minima_[k]);
      minima_ = std::move(kept);
      sort_by_energy(minima_);
    }
  }

  // === All atoms

  /// Atoms beside the rings go where they were, seen from the ring atoms about them. An inverted
  /// nitrogen's goes to the other side.
  std::vector<Vec3> with_others(std::span<const Vec3> ring, unsigned inverted) const {
    std::vector<Vec3> x(ring.begin(), ring.end());
    int nitrogen = 0;
    std::size_t next = ring_;
    for (const int centre : system_.atoms) {
      std::vector<int> ring_around, beside;
      for (const auto& [other, bond] : molecule_.neighbours(centre))
        (pliant_.in_ring(bond) ? ring_around : beside).push_back(other);
      const bool turned =
          pliant_.inverts(centre) && beside.size() == 1 && ((inverted >> nitrogen++) & 1u);
      for (const int atom : beside) {
        x.push_back(placed(atom, centre, ring_around, ring, turned));
        ++next;
      }
    }
    return x;
  }

  Vec3 placed(int atom, int centre, const std::vector<int>& around, std::span<const Vec3> ring,
              bool turned) const {
    const auto old = [&](int of) -> const Vec3& { return molecule_.positions()[std::size_t(of)]; };
    const auto now = [&](int of) -> const Vec3& { return ring[std::size_t(local(of))]; };
    std::vector<Vec3> from = {old(centre)}, to = {now(centre)};
    for (const int other : around) {
      from.push_back(old(other));
      to.push_back(now(other));
    }
    Vec3 point = old(atom);
    if (turned) {
      const Vec3 normal = (from[1] - from[0]).cross(from[2] - from[0]).normalized();
      point -= 2 * normal.dot(point - from[0]) * normal;
    }
    return superposition(from, to)(point);
  }

  unsigned inversions() const {
    unsigned count = 0;
    for (const int atom : system_.atoms) count += pliant_.inverts(atom);
    return 1u << std::min(count, 2u);
  }

  double energy_of(std::span<const Vec3> x) const {
    double energy = score_.energy(x.first(ring_));
    // small rings were not led away from what crowds them, and their terms know of it
    if (is_large()) energy += sterics_->energy(x);
    for (const auto& [a, b, c, d] : crowded_)
      energy += crowding / 2 *
                (1 + std::cos(torsion_of(x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)],
                                         x[std::size_t(d)])));
    return energy;
  }

  void resolve_whole(const std::vector<Candidate>& from, std::vector<Candidate>& to,
                     EnsembleResolver& exact, EnsembleResolver* yielding) const {
    Shapes shapes{atoms_.size(), {}};
    for (std::size_t k = 0; k < from.size(); ++k) {
      const std::span<const Vec3> ring = std::span(from[k].positions).first(ring_);
      const unsigned sides = inversions();
      // large rings have shapes enough to try one of the sides each
      if (is_large())
        shapes.add(with_others(ring, unsigned(k) % sides));
      else
        for (unsigned inverted = 0; inverted < sides; ++inverted)
          shapes.add(with_others(ring, inverted));
    }
    if (yielding) {
      resolve_all(*yielding, shapes.positions);
      lead(*yielding, shapes, large_leads, true);
    }
    keep_resolved(exact, *all_, shapes);
    for (std::size_t k = 0; k < shapes.count(); ++k) {
      const std::span<const Vec3> x = shapes.at(k);
      to.push_back({{x.begin(), x.end()}, torsions_.measure(x.first(ring_)), energy_of(x)});
    }
  }

  std::optional<RingPool> place() {
    const auto exact = resolver(all_, settings_.tolerance);
    std::vector<Candidate> placed;
    const auto yielding = is_large() ? resolver(yielding_, rough_tolerance) : nullptr;
    resolve_whole(minima_, placed, *exact, yielding.get());
    sort_by_energy(placed);
    const std::size_t wanted = std::size_t(settings_.count);
    if (is_large()) placed = leaders(std::move(placed));
    if (!placed.empty() && !is_large()) {
      const double most = placed.front().energy + settings_.energy_window;
      std::erase_if(placed, [&](const Candidate& c) { return c.energy > most; });
    }
    if (placed.size() > wanted) placed.resize(wanted);
    RingPool pool;
    pool.minima = int(placed.size());
    if (settings_.fill && placed.size() < wanted) {
      std::vector<const Candidate*> beside;
      for (const Candidate& one : placed) beside.push_back(&one);
      std::vector<Candidate> more;
      // some will not bear what hangs on them
      const std::size_t most = (wanted - placed.size()) * 5 / 4 + 1;
      for (const std::size_t k : furthest(others_, most, 0, beside, false))
        more.push_back(others_[k]);
      resolve_whole(more, placed, *exact, nullptr);
      if (placed.size() > wanted) placed.resize(wanted);
    }
    if (placed.size() < 2) return std::nullopt;
    pool.atoms = atoms_;
    pool.ring_atoms = int(ring_);
    for (Candidate& one : placed) {
      pool.energies.push_back(one.energy);
      pool.conformations.push_back(std::move(one.positions));
    }
    return pool;
  }

  const Molecule& molecule_;
  const RingSystem& system_;
  const PliantRings& pliant_;
  const RingSettings& settings_;
  std::uint64_t stream_;
  std::vector<int> atoms_;  ///< of the pool
  std::size_t ring_ = 0;
  RingTorsions torsions_;
  TorsionScore score_;
  std::shared_ptr<const Framework> rings_, all_, yielding_;
  std::optional<RingSterics> sterics_;
  std::vector<Vec3> start_;
  std::vector<std::array<int, 4>> crowded_;
  std::unique_ptr<EnsembleResolver> rough_, exact_;
  std::optional<RingBreak> breaks_;
  int tried_ = 0;
  std::vector<Candidate> minima_, others_;
};

void check(const Molecule& molecule, std::span<const TorsionTerm> terms,
           const RingSettings& settings) {
  if (settings.count < 1) throw Error("the number of ring conformations must be 1 or more");
  if (!(settings.tolerance > 0) || !(settings.tolerance < 0.1))
    throw Error("the tolerance of ring conformations must be above 0 and below 0.1");
  if (!(settings.angle_play_degree > 0) || !(settings.angle_play_degree <= 20))
    throw Error("the play of angles in rings must be above 0 and at most 20 degrees");
  if (!(settings.distinct_degree >= 0) || !(settings.energy_window >= 0))
    throw Error(
        "what tells ring conformations apart, and their energy window, must not be "
        "negative");
  for (const TorsionTerm& term : terms)
    for (const int atom : {term.a, term.b, term.c, term.d})
      if (atom < 0 || std::size_t(atom) >= molecule.atoms().size())
        throw Error("a torsion term names atom " + std::to_string(atom) + ", but there are " +
                    std::to_string(molecule.atoms().size()));
}

}  // namespace

std::vector<RingPool> ring_conformers(const Molecule& molecule, std::span<const TorsionTerm> terms,
                                      const RingSettings& settings) {
  check(molecule, terms, settings);
  const std::vector<RingSystem> systems = ring_systems(molecule);
  const PliantRings pliant(molecule, systems);
  const bool any = std::any_of(systems.begin(), systems.end(), [&](const RingSystem& system) {
    return std::any_of(system.bonds.begin(), system.bonds.end(),
                       [&](int bond) { return pliant.turns(bond); });
  });
  std::vector<RingPool> pools;
  if (!any) return pools;
  FrameworkOptions options = settings.framework;
  options.constraints.reset();
  if (settings.fill) options.contact_scale *= strained_scale;
  const double play = settings.angle_play_degree * degree * (settings.fill ? strained_play : 1);
  const FrameworkParts loosened = pliant.loosen(build_framework(molecule, options).parts(), play);
  for (std::size_t k = 0; k < systems.size(); ++k) {
    auto pool = RingSampler(molecule, systems[k], pliant, loosened, terms, settings, k).sample();
    if (pool) pools.push_back(std::move(*pool));
  }
  return pools;
}

}  // namespace ragdoll
