// benchmark: measures solvers of core beside their baselines. benchmarks/run builds and runs it.

#include <cstdio>   // fprintf
#include <utility>  // pair

#include "commands.h"
#include "ragdoll/error.h"  // Error

int main(int argc, char** argv) {
  using namespace benchmark;
  constexpr std::pair<const char*, void (*)(const Words&)> commands[] = {
      {"visits", measure_visits},         {"cycles", measure_cycles},
      {"forced", measure_forced},         {"molecule", measure_molecule},
      {"bonds", measure_bonds},           {"fails", measure_where_openmm_fails},
      {"conformers", measure_conformers}, {"sizes", measure_sizes},
      {"setup", measure_setup},           {"loop", measure_loop},
      {"peptide", write_peptide},         {"numbering", measure_numbering},
  };
  try {
    const Words words(argv + 1, argv + argc);
    for (const auto& [name, measure] : commands)
      if (!words.empty() && words.front() == name) {
        measure(Words(words.begin() + 1, words.end()));
        return 0;
      }
    throw ragdoll::Error("the first word is no command");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark: %s\n", error.what());
    return 2;
  }
}
