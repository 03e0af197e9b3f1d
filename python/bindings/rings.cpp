#include "rings.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <memory>
#include <utility>  // move
#include <vector>

#include "arrays.h"
#include "ragdoll/error.h"
#include "ragdoll/random_start.h"
#include "ragdoll/ring_conformers.h"
#include "ragdoll/ring_systems.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace ragdoll::bindings {
namespace {

using InFour = In<std::int32_t, nb::shape<-1, 4>>;
using InSix = In<double, nb::shape<-1, 6>>;

std::vector<TorsionTerm> terms_of(const InFour& atoms, const InSix& amplitudes,
                                  const InSix& signs) {
  const std::size_t n = atoms.shape(0);
  check_size(amplitudes, n, "amplitudes");
  check_size(signs, n, "signs");
  std::vector<TorsionTerm> terms(n);
  for (std::size_t k = 0; k < n; ++k) {
    terms[k].a = atoms(k, 0);
    terms[k].b = atoms(k, 1);
    terms[k].c = atoms(k, 2);
    terms[k].d = atoms(k, 3);
    for (std::size_t j = 0; j < 6; ++j) {
      terms[k].amplitude[j] = amplitudes(k, j);
      terms[k].sign[j] = signs(k, j) < 0 ? -1 : 1;
    }
  }
  return terms;
}

nb::list pools_of(const Molecule& molecule, const InFour& torsions, const InSix& amplitudes,
                  const InSix& signs, int count, std::uint64_t seed, double tolerance,
                  double angle_play_degree, double distinct_degree, double energy_window, bool fill,
                  int attempts, double contact_scale) {
  RingSettings settings;
  settings.count = count;
  settings.seed = seed;
  settings.tolerance = tolerance;
  settings.angle_play_degree = angle_play_degree;
  settings.distinct_degree = distinct_degree;
  settings.energy_window = energy_window;
  settings.fill = fill;
  settings.attempts = attempts;
  settings.framework.contact_scale = contact_scale;
  const std::vector<TorsionTerm> terms = terms_of(torsions, amplitudes, signs);
  std::vector<RingPool> pools;
  {
    const nb::gil_scoped_release release;
    pools = ring_conformers(molecule, terms, settings);
  }
  nb::list list;
  for (const RingPool& pool : pools) {
    std::vector<double> flat;
    for (const std::vector<Vec3>& shape : pool.conformations)
      for (const Vec3& x : shape) flat.insert(flat.end(), {x[0], x[1], x[2]});
    nb::dict d;
    d["atoms"] = out(std::vector<std::int32_t>(pool.atoms.begin(), pool.atoms.end()));
    d["ring_atoms"] = pool.ring_atoms;
    d["conformations"] = out(flat, {pool.conformations.size(), pool.atoms.size(), 3});
    d["energies"] = out(pool.energies);
    d["minima"] = pool.minima;
    list.append(d);
  }
  return list;
}

std::shared_ptr<Framework> ideal_framework_of(
    const Molecule& molecule, const InPairs& pairs, const InVector<double>& lower,
    const InVector<double>& upper, const InFour& corners, const InVector<double>& volume_lower,
    const InVector<double>& volume_upper, const InVector<double>& volume_scale,
    const InVector<std::uint8_t>& volume_kinds, double contact_scale) {
  check_size(lower, pairs.shape(0), "lower");
  check_size(upper, pairs.shape(0), "upper");
  check_size(volume_lower, corners.shape(0), "volume_lower");
  check_size(volume_upper, corners.shape(0), "volume_upper");
  check_size(volume_scale, corners.shape(0), "volume_scale");
  check_size(volume_kinds, corners.shape(0), "volume_kinds");
  std::vector<DistanceBounds> distances;
  for (std::size_t k = 0; k < pairs.shape(0); ++k)
    distances.push_back({pairs(k, 0), pairs(k, 1), lower(k), upper(k)});
  std::vector<Volume> volumes;
  for (std::size_t k = 0; k < corners.shape(0); ++k)
    volumes.push_back({corners(k, 0), corners(k, 1), corners(k, 2), corners(k, 3), volume_lower(k),
                       volume_upper(k), volume_scale(k),
                       volume_kinds(k) == 0 ? VolumeKind::chirality : VolumeKind::planarity});
  return std::make_shared<Framework>(ideal_framework(molecule, distances, volumes, contact_scale));
}

}  // namespace

void bind_rings(nb::module_& m) {
  m.def(
      "ring_systems",
      [](const Molecule& molecule) {
        nb::list list;
        for (const RingSystem& system : ring_systems(molecule)) {
          nb::dict d;
          d["atoms"] = system.atoms;
          d["bonds"] = system.bonds;
          d["ring_size"] = system.ring_size;
          list.append(d);
        }
        return list;
      },
      "molecule"_a,
      "Ring systems: their atoms, the molecule's bonds in them, and the atoms of the smallest ring "
      "through\neach of these.");
  m.def("ideal_framework", &ideal_framework_of, "molecule"_a, "pairs"_a, "lower"_a, "upper"_a,
        "volumes"_a, "volume_lower"_a, "volume_upper"_a, "volume_scale"_a, "volume_kinds"_a,
        "contact_scale"_a = 0.75,
        "A framework from bounds of distances (nm) and volumes (nm^3) instead of positions; equal "
        "bounds are a bar.");
  m.def(
      "random_start",
      [](const Framework& framework, std::uint64_t seed, double tolerance, int attempts) {
        RandomStart start;
        {
          const nb::gil_scoped_release release;
          start = random_start(framework, {seed, tolerance, attempts});
        }
        return nb::make_tuple(out_points(start.positions), start.attempts);
      },
      "framework"_a, "seed"_a = 0, "tolerance"_a = RandomStartSettings{}.tolerance,
      "attempts"_a = RandomStartSettings{}.attempts,
      "Positions (njoint, 3; nm) from random places, resolved, and how many attempts that took; no "
      "positions\nwhere none was resolved.");
  const RingSettings defaults;
  m.def(
      "ring_conformers", &pools_of, "molecule"_a, "torsions"_a, "amplitudes"_a, "signs"_a,
      nb::kw_only(), "count"_a = defaults.count, "seed"_a = 0, "tolerance"_a = defaults.tolerance,
      "angle_play_degree"_a = defaults.angle_play_degree,
      "distinct_degree"_a = defaults.distinct_degree, "energy_window"_a = defaults.energy_window,
      "fill"_a = false, "attempts"_a = 0, "contact_scale"_a = defaults.framework.contact_scale,
      "Shapes of the ring systems that have more than one: dicts with `atoms` (of the rings, then "
      "those\nbonded to them), `ring_atoms` (how many are in rings), `conformations` (n, natom, "
      "3; nm),\n`energies` (n; torsion score, kJ/mol) and `minima` (how many of the first ones "
      "torsions were led\nto). Terms: torsions (n, 4), amplitudes (n, 6; kJ/mol) and signs "
      "(n, 6).");
}

}  // namespace ragdoll::bindings
