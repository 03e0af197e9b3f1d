#include "options.h"

#include <charconv>  // from_chars
#include <string_view>
#include <system_error>
#include <vector>

const char* const usage =
    "Usage: cpp_conformers INPUT -o OUTPUT [--count N] [--seed S] [--embed] [--force]\n\n"
    "Conformers of small molecules, without Python.\n\n"
    "  INPUT           a file .smi, .sdf, .mol or .mol2, or a SMILES\n"
    "  -o, --output    .sdf or .h5\n"
    "  -n, --count N   conformers of each molecule (50)\n"
    "  --seed S        decides all random numbers (0)\n"
    "  --embed         embed also molecules that have coordinates\n"
    "  --force         replace an existing output\n";

namespace {

template <class Number>
Number number_of(std::string_view name, std::string_view text, Number least, Number most) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < least || value > most)
    throw UsageError(std::string(name) + " must be from " + std::to_string(least) + " to " +
                     std::to_string(most) + ", not " + std::string(text));
  return value;
}

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() > end.size() && text.substr(text.size() - end.size()) == end;
}

}  // namespace

Options read_options(int count, char** words) {
  Options options;
  for (int k = 1; k < count; ++k) {
    const std::string_view word = words[k];
    const auto value = [&]() -> std::string_view {
      if (k + 1 == count) throw UsageError(std::string(word) + " needs a value");
      return words[++k];
    };
    if (word == "-h" || word == "--help")
      options.help = true;
    else if (word == "-o" || word == "--output")
      options.output = value();
    else if (word == "-n" || word == "--count")
      options.count = number_of<int>("--count", value(), 1, 1'000'000);
    else if (word == "--seed")
      options.seed = number_of<std::uint64_t>("--seed", value(), 0, (std::uint64_t{1} << 63) - 1);
    else if (word == "--embed")
      options.embed = true;
    else if (word == "--force")
      options.force = true;
    else if (word.starts_with("--"))
      throw UsageError("There is no option " + std::string(word) +
                       "; --help tells which there are");
    else if (options.input.empty())
      options.input = word;
    else
      throw UsageError("Give one input, not also " + std::string(word));
  }
  if (options.help) return options;
  if (options.input.empty()) throw UsageError("Give an input: a file or a SMILES");
  if (options.output.empty()) throw UsageError("Give an output with -o");
  if (!ends_with(options.output, ".sdf") && !ends_with(options.output, ".h5"))
    throw UsageError("The output must be .sdf or .h5, not " + options.output);
  return options;
}
