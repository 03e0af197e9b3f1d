#include "ragdoll/conformers.h"

#include "arrays.h"
#include "conformers.h"
#include "interruption.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace ragdoll::bindings {
namespace {

using InQuads = In<std::int32_t, nb::shape<-1, 4>>;
using InAmplitudes = In<double, nb::shape<-1, 6>>;
using InSigns = In<std::int32_t, nb::shape<-1, 6>>;

std::vector<TorsionTerm> terms_of(const InQuads& atoms, const InAmplitudes& amplitudes,
                                  const InSigns& signs) {
  check_size(amplitudes, atoms.shape(0), "torsion_amplitudes");
  check_size(signs, atoms.shape(0), "torsion_signs");
  std::vector<TorsionTerm> terms(atoms.shape(0));
  for (std::size_t t = 0; t < terms.size(); ++t) {
    terms[t].a = atoms(t, 0);
    terms[t].b = atoms(t, 1);
    terms[t].c = atoms(t, 2);
    terms[t].d = atoms(t, 3);
    for (std::size_t k = 0; k < 6; ++k) {
      terms[t].amplitude[k] = amplitudes(t, k);
      terms[t].sign[k] = signs(t, k);
    }
  }
  return terms;
}

nb::object stacked(const std::vector<std::vector<Vec3>>& frames, std::size_t natom) {
  std::vector<double> flat;
  flat.reserve(3 * natom * frames.size());
  for (const std::vector<Vec3>& frame : frames)
    for (const Vec3& point : frame) flat.insert(flat.end(), point.data(), point.data() + 3);
  return out(flat, {frames.size(), natom, 3});
}

}  // namespace

void bind_conformers(nb::module_& m) {
  m.def(
      "sample_conformers",
      [](const Molecule& molecule, const InQuads& atoms, const InAmplitudes& amplitudes,
         const InSigns& signs, int count, std::uint64_t seed, double prune_rmsd, int candidates,
         double energy_window) {
        const std::vector<TorsionTerm> terms = terms_of(atoms, amplitudes, signs);
        const ConformerSettings settings{count, seed, prune_rmsd, candidates, energy_window};
        Conformers found;
        bool interrupted = false;
        {
          nb::gil_scoped_release release;
          found = sample_conformers(molecule, terms, settings,
                                    [&] { return !(interrupted = !no_interruption()); });
        }
        if (interrupted) {
          PyErr_SetNone(PyExc_KeyboardInterrupt);
          throw nb::python_error();
        }
        nb::dict d;
        d["positions"] = stacked(found.positions, molecule.atoms().size());
        d["energies"] = out(found.energies);
        d["candidates"] = found.candidates;
        d["rejected"] = found.rejected;
        d["reason"] = found.reason.c_str();
        return d;
      },
      "molecule"_a, "torsion_atoms"_a, "torsion_amplitudes"_a, "torsion_signs"_a, nb::kw_only(),
      "count"_a = ConformerSettings{}.count, "seed"_a = 0, "prune_rmsd"_a = 0.0, "candidates"_a = 0,
      "energy_window"_a = 0.0,
      "Conformers of a molecule from its positions. Torsion terms: atoms (n, 4) int32, amplitudes "
      "(n, 6) kJ/mol, signs (n, 6) int32. prune_rmsd in nm; energy_window in kJ/mol; 0: none. "
      "Returns positions (k, natom, 3) in nm, energies (k) in kJ/mol, candidates, rejected, and "
      "the reason why there are fewer than asked, or an empty text.");
}

}  // namespace ragdoll::bindings
