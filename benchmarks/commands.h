// Commands of the program `benchmark`: each measures one thing and prints records.

#pragma once
#include <string>
#include <vector>

namespace benchmark {

using Words = std::vector<std::string>;

void measure_visits(const Words& words);              ///< REPETITIONS
void measure_cycles(const Words& words);              ///< FORCES REPETITIONS
void measure_forced(const Words& words);              ///< JOINTS...
void measure_numbering(const Words& words);           ///< JOINTS...
void measure_molecule(const Words& words);            ///< FILE BREAKS SECONDS
void measure_bonds(const Words& words);               ///< FILE BREAKS SECONDS
void measure_where_openmm_fails(const Words& words);  ///< FILE NETWORK DEVIATION
void measure_conformers(const Words& words);          ///< FILE SECONDS
void measure_sizes(const Words& words);               ///< LARGEST_FOR_SWEEPS JOINTS...
void measure_setup(const Words& words);               ///< JOINTS...
void measure_loop(const Words& words);                ///< LOOP REPETITIONS
void write_peptide(const Words& words);               ///< JOINTS FILE

}  // namespace benchmark
