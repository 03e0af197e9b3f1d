#include "ragdoll/chemistry/molecule_reader.h"

#include <GraphMol/FileParsers/FileParsers.h>
#include <GraphMol/FileParsers/MolSupplier.h>
#include <GraphMol/RWMol.h>
#include <GraphMol/SmilesParse/SmilesParse.h>

#include <algorithm>  // transform
#include <cctype>     // tolower, isspace, iscntrl
#include <cstddef>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <utility>  // move, pair
#include <vector>

#include "ragdoll/error.h"  // Error
#include "rdkit_messages.h"

namespace ragdoll {
namespace {

constexpr std::size_t longest_record = 16'000'000;  // bytes of one molecule
constexpr std::size_t longest_reason = 200;         // characters

using Mol = std::shared_ptr<RDKit::RWMol>;

std::string suffix_of(const std::string& path) {
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char letter) { return char(std::tolower(letter)); });
  return suffix;
}

enum class Format { none, smiles, sd, mol2 };

Format format_of(const std::string& path) {
  const std::string suffix = suffix_of(path);
  if (suffix == ".smi" || suffix == ".smiles" || suffix == ".txt") return Format::smiles;
  if (suffix == ".sdf" || suffix == ".sd" || suffix == ".mol") return Format::sd;
  if (suffix == ".mol2") return Format::mol2;
  return Format::none;
}

/// One line of a sentence that RDKit wrote.
std::string clause(const std::string& text) {
  std::string words;
  bool is_gap = false;
  for (const char letter : text) {
    if (std::isspace(static_cast<unsigned char>(letter))) {
      is_gap = !words.empty();
      continue;
    }
    if (is_gap) words += ' ';
    is_gap = false;
    words += letter;
  }
  if (words.size() > longest_reason) words = words.substr(0, longest_reason) + "...";
  while (!words.empty() && (words.back() == '.' || words.back() == '\0')) words.pop_back();
  return words.empty() ? "RDKit cannot read it" : words;
}

/// Control characters become spaces, since a title has one line in an SD file.
std::string clean_title(std::string title) {
  for (char& letter : title)
    if (std::iscntrl(static_cast<unsigned char>(letter))) letter = ' ';
  const auto first = title.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  title = title.substr(first, title.find_last_not_of(' ') - first + 1);
  return title.starts_with("$$$$") ? "'" + title + "'" : title;
}

Mol read_smiles(const std::string& text) {
  RDKit::SmilesParserParams settings;
  settings.parseName = false;
  return Mol(RDKit::SmilesToMol(text, settings));
}

/// An SD record with its data as properties.
Mol read_sd(const std::string& text) {
  std::istringstream stream(text + "$$$$\n");
  RDKit::ForwardSDMolSupplier supplier(&stream, false, true, false, true);
  if (RDKit::ROMol* mol = supplier.next()) return Mol(static_cast<RDKit::RWMol*>(mol));
  // the supplier keeps the reason to itself
  return Mol(RDKit::MolBlockToMol(text, true, false, true));
}

Mol read_mol2(const std::string& text) {
  return Mol(RDKit::Mol2BlockToMol(text, true, false));
}

Mol parsed(const std::function<Mol(const std::string&)>& read, const std::string& text) {
  const RdkitMessages messages;
  Mol mol;
  try {
    mol = read(text);
  } catch (const std::exception& error) {
    throw Error(clause(error.what()));
  }
  if (!mol) throw Error(clause(messages.first()));
  if (mol->getNumAtoms() == 0) throw Error("it has no atoms");
  return mol;
}

/// The text of one molecule.
struct Cut {
  long line = 1;
  std::string title, text, fault;
};

}  // namespace

struct MoleculeReader::State {
  State(std::ifstream opened, Format chosen) : file(std::move(opened)), format(chosen) {}

  std::ifstream file;
  Format format;
  long line = 0, number = 0;
  bool is_first = true;  ///< of a file of SMILES: it may be a header
  std::string waiting;   ///< of a MOL2 file: the line that begins the next molecule
  bool has_waiting = false;

  /// A line without its end, at most `longest_record` of it. @return whether there was one
  bool read_line(std::string& text, bool& is_cut) {
    text.clear();
    is_cut = false;
    std::streambuf& buffer = *file.rdbuf();
    int letter = buffer.sbumpc();
    if (letter == std::char_traits<char>::eof()) return false;
    ++line;
    for (; letter != std::char_traits<char>::eof() && letter != '\n'; letter = buffer.sbumpc())
      if (text.size() < longest_record)
        text += char(letter);
      else
        is_cut = true;
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return true;
  }

  std::optional<Cut> cut_smiles() {
    static const std::regex header("^[#\"']?(canonical|isomeric)?[ _-]?smiles?\\b.*",
                                   std::regex::icase);
    std::string text;
    bool is_cut = false;
    while (read_line(text, is_cut)) {
      if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
      std::istringstream words(text.substr(0, std::min<std::size_t>(text.size(), 200)));
      std::string word;
      if (!(words >> word) || word.starts_with("#")) continue;
      const bool may_be_header = std::exchange(is_first, false);
      if (may_be_header && std::regex_match(text.substr(0, 80), header)) continue;
      if (is_cut) return Cut{line, "", "", "the line is too long"};
      const auto begin = text.find_first_not_of(" \t");
      const auto end = text.find_first_of(" \t", begin);
      Cut cut{line, "", text.substr(begin, end - begin), ""};
      std::string rest = end == std::string::npos ? "" : text.substr(end);
      const auto bar = rest.find_first_not_of(" \t");
      if (bar != std::string::npos && rest[bar] == '|') {  // ChemAxon's extension
        const auto close = rest.find('|', bar + 1);
        if (close != std::string::npos) {
          cut.text += " " + rest.substr(bar, close + 1 - bar);
          rest.erase(0, close + 1);
        }
      }
      cut.title = rest;
      return cut;
    }
    return std::nullopt;
  }

  /// Adds a line to a block, within its bounds.
  static void add(Cut& cut, const std::string& text, bool is_cut) {
    if (is_cut || cut.text.size() + text.size() > longest_record) {
      cut.fault = "it has more than " + std::to_string(longest_record) + " bytes";
      return;
    }
    cut.text += text + "\n";
  }

  std::optional<Cut> cut_sd() {
    Cut cut{line + 1, "", "", ""};
    std::string text;
    bool is_cut = false, has_text = false;
    long count = 0;
    while (read_line(text, is_cut)) {
      if (text.starts_with("$$$$")) {
        if (!has_text) cut.fault = "the record is empty";
        return cut;
      }
      if (++count == 1) cut.title = text;
      has_text = has_text || text.find_first_not_of(" \t") != std::string::npos;
      add(cut, text, is_cut);
    }
    if (!has_text) return std::nullopt;
    return cut;
  }

  std::optional<Cut> cut_mol2() {
    const auto begins = [](const std::string& text) {
      return text.starts_with("@<TRIPOS>MOLECULE");
    };
    std::string text = std::exchange(waiting, "");
    bool is_cut = false;
    if (!std::exchange(has_waiting, false)) do {
        if (!read_line(text, is_cut)) return std::nullopt;
      } while (!begins(text));
    Cut cut{line, "", text + "\n", ""};
    for (long count = 0; read_line(text, is_cut); ++count) {
      if (begins(text)) {
        waiting = text;
        has_waiting = true;
        break;
      }
      if (count == 0) cut.title = text;
      add(cut, text, is_cut);
    }
    return cut;
  }
};

bool names_molecule_file(const std::string& path) {
  return format_of(path) != Format::none;
}

std::shared_ptr<RDKit::RWMol> molecule_of_smiles(const std::string& smiles) {
  return parsed(read_smiles, smiles);
}

MoleculeReader::MoleculeReader(const std::string& path) {
  const Format format = format_of(path);
  if (format == Format::none)
    throw Error(path +
                " has no name that tells its format; give a file .smi, .smiles, .txt, "
                ".sdf, .sd, .mol or .mol2");
  if (std::filesystem::is_directory(path)) throw Error(path + " is a folder; give a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(path + " cannot be read; check its name and permissions");
  state_ = std::make_unique<State>(std::move(file), format);
}

MoleculeReader::~MoleculeReader() = default;
MoleculeReader::MoleculeReader(MoleculeReader&&) noexcept = default;
MoleculeReader& MoleculeReader::operator=(MoleculeReader&&) noexcept = default;

std::optional<MoleculeRecord> MoleculeReader::next() {
  State& state = *state_;
  const std::optional<Cut> cut = state.format == Format::smiles ? state.cut_smiles()
                                 : state.format == Format::sd   ? state.cut_sd()
                                                                : state.cut_mol2();
  if (!cut) return std::nullopt;
  MoleculeRecord record{state.number++, cut->line, clean_title(cut->title), nullptr, cut->fault};
  if (record.title.empty())
    record.title = state.format == Format::smiles ? "line " + std::to_string(record.line)
                                                  : "molecule " + std::to_string(record.number + 1);
  if (!record.fault.empty()) return record;
  try {
    record.mol = parsed(state.format == Format::smiles ? read_smiles
                        : state.format == Format::sd   ? read_sd
                                                       : read_mol2,
                        cut->text);
    record.mol->setProp("_Name", record.title);
  } catch (const Error& error) {
    record.fault = error.what();
  }
  return record;
}

}  // namespace ragdoll
