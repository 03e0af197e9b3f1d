// Conformers of small molecules in C++: SMILES, SD or MOL2 in, SD or HDF5 out.

#include <GraphMol/RWMol.h>
#include <ragdoll/chemistry/molecule_reader.h>  // MoleculeReader
#include <ragdoll/chemistry/rdkit_molecule.h>   // molecule_from_rdkit
#include <ragdoll/chemistry/start.h>            // make_start
#include <ragdoll/chemistry/torsion_terms.h>    // torsion_terms
#include <ragdoll/conformers.h>                 // sample_conformers
#include <ragdoll/error.h>
#include <ragdoll/random.h>  // record_seed
#include <ragdoll/trajectory/error.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>

#include "options.h"
#include "output.h"

namespace {

constexpr int done = 0, failed = 1, bad_usage = 2, incomplete = 3, interrupted = 130;

volatile std::sig_atomic_t is_interrupted = 0;

void note_signal(int) {
  is_interrupted = 1;
}

struct Tally {
  long molecules = 0, conformers = 0, short_of = 0, without = 0;
};

void tell(const ragdoll::MoleculeRecord& record, std::size_t conformers, std::string reason) {
  while (!reason.empty() && reason.back() == '.') reason.pop_back();
  std::fprintf(stderr, "line %ld (%s): %zu conformers: %s.\n", record.line, record.title.c_str(),
               conformers, reason.c_str());
}

/// Gives each molecule to `use`, until it says stop.
void for_each_molecule(const Options& options,
                       const std::function<bool(ragdoll::MoleculeRecord&)>& use) {
  const bool is_file =
      ragdoll::names_molecule_file(options.input) || std::filesystem::exists(options.input);
  if (is_file) {
    ragdoll::MoleculeReader reader(options.input);
    while (auto record = reader.next())
      if (!use(*record)) return;
    return;
  }
  ragdoll::MoleculeRecord record;
  record.title = options.input;
  try {
    record.mol = ragdoll::molecule_of_smiles(options.input);
    record.mol->setProp("_Name", record.title);
  } catch (const ragdoll::Error& error) {
    throw UsageError(options.input + " is no file and no SMILES: " + error.what());
  }
  use(record);
}

void make(const ragdoll::MoleculeRecord& record, const Options& options, Output& output,
          Tally& tally) {
  const std::uint64_t seed = ragdoll::record_seed(options.seed, std::uint64_t(record.number));
  const ragdoll::Start start =
      ragdoll::make_start(*record.mol, {.seed = seed, .embed = options.embed});
  const ragdoll::Molecule molecule = ragdoll::molecule_from_rdkit(*start.mol);
  ragdoll::ConformerSettings settings;
  settings.count = options.count;
  settings.seed = seed;
  const ragdoll::Conformers conformers = ragdoll::sample_conformers(
      molecule, ragdoll::torsion_terms(*start.mol), settings, [] { return !is_interrupted; });
  if (is_interrupted) return;
  const std::size_t count = conformers.positions.size();
  if (count < std::size_t(options.count)) {
    tell(record, count, conformers.reason.empty() ? "no more were found" : conformers.reason);
    ++(count ? tally.short_of : tally.without);
  }
  if (!count) return;
  output.add({record, *start.mol, molecule, conformers, seed});
  tally.conformers += long(count);
}

int run(const Options& options) {
  const std::unique_ptr<Output> output = open_output(options);
  Tally tally;
  for_each_molecule(options, [&](ragdoll::MoleculeRecord& record) {
    ++tally.molecules;
    try {
      if (!record.mol) throw ragdoll::Error(record.fault);
      make(record, options, *output, tally);
    } catch (const ragdoll::Error& error) {
      tell(record, 0, error.what());
      ++tally.without;
    }
    return !is_interrupted;
  });
  if (is_interrupted) {
    std::fprintf(stderr, "cpp_conformers: Interrupted; %s was not written.\n",
                 options.output.c_str());
    return interrupted;
  }
  if (tally.molecules == 0) throw UsageError(options.input + " holds no molecules");
  if (tally.conformers == 0) {
    std::fprintf(stderr, "cpp_conformers: No molecule gave conformers, so %s was not written.\n",
                 options.output.c_str());
    return incomplete;
  }
  output->close();
  std::printf("%s: %ld conformers of %ld molecules\n", options.output.c_str(), tally.conformers,
              tally.molecules - tally.without);
  if (!tally.short_of && !tally.without) return done;
  std::fprintf(stderr,
               "cpp_conformers: Of %ld molecules, %ld have no conformers and %ld fewer than %d.\n",
               tally.molecules, tally.without, tally.short_of, options.count);
  return incomplete;
}

int complain(const std::exception& error, int code) {
  std::string sentence = error.what();
  while (!sentence.empty() && sentence.back() == '.') sentence.pop_back();
  std::fprintf(stderr, "cpp_conformers: %s.\n", sentence.c_str());
  return code;
}

}  // namespace

int main(int count, char** words) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(number, note_signal) == SIG_IGN) std::signal(number, SIG_IGN);
  try {
    const Options options = read_options(count, words);
    if (options.help) {
      std::fputs(usage, stdout);
      return done;
    }
    return run(options);
  } catch (const UsageError& error) {
    return complain(error, bad_usage);
  } catch (const ragdoll::Error& error) {
    return complain(error, bad_usage);
  } catch (const ragdoll::TrajectoryUsageError& error) {
    return complain(error, bad_usage);
  } catch (const std::exception& error) {
    return complain(error, failed);
  }
}
