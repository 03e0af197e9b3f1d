#include "output.h"

#include <GraphMol/FileParsers/MolWriters.h>
#include <GraphMol/RWMol.h>
#include <ragdoll/chemistry/rdkit_molecule.h>  // add_conformer
#include <ragdoll/trajectory/collection.h>
#include <ragdoll/trajectory/writer.h>

#include <cstdio>  // remove, snprintf
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::string quoted(const std::string& text) {
  std::string json = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') json += '\\';
    json += letter;
  }
  return json + "\"";
}

std::string parameters_of(const Options& options) {
  return "{\"count\": " + std::to_string(options.count) +
         ", \"seed\": " + std::to_string(options.seed) +
         ", \"start\": " + (options.embed ? "\"embed\"" : "\"input\"") +
         ", \"input\": " + quoted(options.input) + "}";
}

class SdOutput : public Output {
 public:
  explicit SdOutput(const Options& options)
      : options_(options), part_(options.output + ".part"), stream_(part_, std::ios::binary) {
    if (!stream_) throw UsageError(options.output + " cannot be written; check its folder");
    writer_.emplace(&stream_, false);
  }

  ~SdOutput() override {
    if (!writer_) return;
    writer_.reset();
    stream_.close();
    std::remove(part_.c_str());
  }

  void add(const Made& made) override {
    RDKit::RWMol& mol = made.start;
    mol.clearConformers();
    mol.setProp("ragdoll_seed", std::to_string(made.seed));
    mol.setProp("ragdoll_version", std::string(RAGDOLL_VERSION));
    mol.setProp("ragdoll_options", parameters_of(options_));
    int number = 0;
    for (const std::vector<ragdoll::Vec3>& positions : made.conformers.positions) {
      mol.setProp("ragdoll_conformer", ++number);
      writer_->write(mol, int(ragdoll::add_conformer(mol, positions)));
    }
    if (!stream_) throw std::runtime_error(part_ + " takes no more; is the disk full?");
  }

  void close() override {
    writer_->close();
    stream_.close();
    if (!stream_) throw std::runtime_error(part_ + " takes no more; is the disk full?");
    fs::rename(part_, options_.output);
    writer_.reset();
  }

 private:
  Options options_;
  std::string part_;
  std::ofstream stream_;
  std::optional<RDKit::SDWriter> writer_;
};

/// One molecule is a trajectory, several are a collection with a group for each.
class H5Output : public Output {
 public:
  explicit H5Output(const Options& options) : options_(options) {
    ragdoll::check_output(options.output, options.force);
  }

  void add(const Made& made) override {
    Entry entry{header_of(made), {}, made.conformers.energies};
    for (const std::vector<ragdoll::Vec3>& positions : made.conformers.positions)
      for (const ragdoll::Vec3& x : positions)
        for (int axis = 0; axis < 3; ++axis) entry.positions.push_back(float(x[axis]));
    if (first_) {
      collection();
      add_to_collection(*first_);
      first_.reset();
    }
    if (collection_)
      add_to_collection(entry);
    else
      first_ = std::move(entry);
  }

  void close() override {
    if (first_) {
      ragdoll::TrajectoryWriter writer(options_.output, first_->header, {.force = options_.force});
      for (const ragdoll::Frame& frame : first_->frames()) writer.append(frame);
      writer.close();
    } else if (collection_) {
      collection_->close();
    }
  }

 private:
  struct Entry {
    ragdoll::TrajectoryHeader header;
    std::vector<float> positions;
    std::vector<double> energies;

    std::vector<ragdoll::Frame> frames() const {
      std::vector<ragdoll::Frame> frames;
      const std::size_t size = std::size_t(3 * header.atom_count);
      for (std::size_t k = 0; k < energies.size(); ++k) {
        ragdoll::Frame frame;
        frame.positions = std::span(positions).subspan(k * size, size);
        frame.time = double(k);
        frame.step = std::int64_t(k);
        frame.observables = std::span(energies).subspan(k, 1);
        frames.push_back(frame);
      }
      return frames;
    }
  };

  ragdoll::TrajectoryHeader header_of(const Made& made) const {
    ragdoll::TrajectoryHeader header;
    header.atom_count = std::int64_t(made.molecule.atoms().size());
    std::string atoms, bonds;
    for (const RDKit::Atom* atom : made.start.atoms()) {
      const std::string index = std::to_string(atom->getIdx());
      atoms += (atoms.empty() ? "" : ", ") + std::string("{\"index\": ") + index +
               ", \"name\": \"" + atom->getSymbol() + index + "\", \"element\": \"" +
               atom->getSymbol() + "\"}";
      header.atomic_numbers.push_back(atom->getAtomicNum());
    }
    for (const ragdoll::Bond& bond : made.molecule.bonds()) {
      bonds += (bonds.empty() ? "[" : ", [") + std::to_string(bond.a) + ", " +
               std::to_string(bond.b) + "]";
      header.bonds.insert(header.bonds.end(), {bond.a, bond.b});
    }
    header.topology_json =
        "{\"chains\": [{\"index\": 0, \"residues\": [{\"index\": 0, \"name\": \"LIG\", "
        "\"resSeq\": 1, \"segmentID\": \"\", \"atoms\": [" +
        atoms + "]}]}], \"bonds\": [" + bonds + "]}";
    header.observables = {{"energy", false, "kJ mol-1"}};
    header.program = "cpp_conformers";
    header.program_version = RAGDOLL_VERSION;
    header.attributes["version"] = std::string(RAGDOLL_VERSION);
    header.attributes["seed"] = std::int64_t(made.seed);
    header.attributes["title"] = made.record.title;
    header.attributes["reason"] = made.conformers.reason;
    header.texts["parameters"] = parameters_of(options_);
    return header;
  }

  void collection() {
    ragdoll::TrajectoryHeader about;
    about.atom_count = 1;
    about.program = "cpp_conformers";
    about.program_version = RAGDOLL_VERSION;
    about.attributes["version"] = std::string(RAGDOLL_VERSION);
    about.attributes["seed"] = std::int64_t(options_.seed);
    about.texts["parameters"] = parameters_of(options_);
    collection_.emplace(options_.output, about, options_.force, 1);
  }

  void add_to_collection(const Entry& entry) {
    char name[16];
    std::snprintf(name, sizeof name, "%07d", ++number_);
    collection_->add(name, entry.header, entry.frames());
  }

  Options options_;
  std::optional<Entry> first_;
  std::optional<ragdoll::CollectionWriter> collection_;
  int number_ = 0;
};

}  // namespace

std::unique_ptr<Output> open_output(const Options& options) {
  const fs::path path(options.output);
  if (fs::exists(path) && !options.force)
    throw UsageError(options.output + " exists; give another name, or --force to replace it");
  if (fs::is_directory(path)) throw UsageError(options.output + " is a folder; give a file");
  if (path.has_parent_path() && !fs::is_directory(path.parent_path()))
    throw UsageError("There is no folder " + path.parent_path().string() + "; make it first");
  if (path.extension() == ".h5") return std::make_unique<H5Output>(options);
  return std::make_unique<SdOutput>(options);
}
