// Prints what the C++ adaptor makes of each molecule of a file: one JSON object a line. The tests
// of the Python adaptor compare it with theirs.
//
//   print_frameworks FILE.sdf|.mol2

#include <GraphMol/RWMol.h>

#include <cstddef>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "ragdoll/build_framework.h"            // build_framework
#include "ragdoll/chemistry/molecule_reader.h"  // MoleculeReader
#include "ragdoll/chemistry/rdkit_molecule.h"   // molecule_from_rdkit
#include "ragdoll/chemistry/start.h"            // make_start
#include "ragdoll/chemistry/torsion_terms.h"    // torsion_terms

namespace ragdoll {
namespace {

/// Writes one object, number by number; doubles keep all their bits.
class Line {
 public:
  void begin(const char* name) {
    std::printf("%s\"%s\": [", is_first_ ? "{" : "], ", name);
    is_first_ = false;
    is_empty_ = true;
  }
  void end() { std::printf("]}\n"); }

  void add(int value) { std::printf("%s%d", comma(), value); }
  void add(double value) {
    // JSON knows no infinity
    if (value > 1e300 || value < -1e300)
      std::printf("%s%s1e999", comma(), value < 0 ? "-" : "");
    else
      std::printf("%s%.17g", comma(), value);
  }
  void add(const std::string& text) { std::printf("%s\"%s\"", comma(), text.c_str()); }

  template <class... Values>
  void add_all(const Values&... values) {
    (add(values), ...);
  }

 private:
  const char* comma() {
    const bool was_empty = is_empty_;
    is_empty_ = false;
    return was_empty ? "" : ", ";
  }
  bool is_first_ = true, is_empty_ = true;
};

void print(const RDKit::ROMol& mol) {
  const Molecule molecule = molecule_from_rdkit(mol);
  const Framework framework = build_framework(molecule);
  Line line;
  line.begin("masses");
  for (const double mass : framework.masses()) line.add(mass);
  line.begin("labels");
  for (const Atom& atom : molecule.atoms()) line.add(atom.label);
  line.begin("charges");
  for (const Atom& atom : molecule.atoms()) line.add(atom.formal_charge);
  line.begin("bonds");
  for (const Bond& bond : molecule.bonds()) line.add_all(bond.a, bond.b, int(bond.order));
  line.begin("bars");
  for (const Bar& bar : framework.bars()) line.add_all(bar.p, bar.q, int(bar.kind));
  line.begin("bar_lengths");
  for (const Bar& bar : framework.bars()) line.add(bar.length);
  line.begin("volumes");
  for (const Volume& v : framework.volumes()) line.add_all(v.a, v.b, v.c, v.d, int(v.kind));
  line.begin("volume_bounds");
  for (const Volume& v : framework.volumes()) line.add_all(v.lower, v.upper, v.scale);
  const ContactRule& rule = framework.contact_rule();
  line.begin("contact_radii");
  for (const double radius : rule.radii) line.add(radius);
  line.begin("contact_polarity");
  for (const Polarity polarity : rule.polarity) line.add(int(polarity));
  line.begin("contact_exclusions");
  for (std::size_t p = 0; p + 1 < rule.exclusion_begin.size(); ++p)
    for (int k = rule.exclusion_begin[p]; k < rule.exclusion_begin[p + 1]; ++k)
      line.add_all(int(p), rule.exclusions[std::size_t(k)]);
  line.begin("close_pairs");
  for (const ClosePair& pair : rule.close_pairs) line.add_all(pair.p, pair.q);
  line.begin("close_pair_lengths");
  for (const ClosePair& pair : rule.close_pairs) line.add(pair.length);
  const std::vector<TorsionTerm> terms = torsion_terms(mol);
  line.begin("term_atoms");
  for (const TorsionTerm& term : terms) line.add_all(term.a, term.b, term.c, term.d);
  line.begin("term_amplitudes");
  for (const TorsionTerm& term : terms)
    for (const double amplitude : term.amplitude) line.add(amplitude);
  line.begin("term_signs");
  for (const TorsionTerm& term : terms)
    for (const int sign : term.sign) line.add(sign);
  line.end();
}

}  // namespace
}  // namespace ragdoll

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "print_frameworks: Give one file.\n");
    return 2;
  }
  try {
    ragdoll::MoleculeReader reader(words[1]);
    while (const auto record = reader.next()) {
      if (record->mol)
        ragdoll::print(*ragdoll::make_start(*record->mol).mol);
      else
        std::printf("{\"fault\": true}\n");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "print_frameworks: %s.\n", error.what());
    return 2;
  }
  return 0;
}
