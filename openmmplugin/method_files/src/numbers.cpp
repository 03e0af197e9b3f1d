#include "numbers.h"

#include <charconv>      // from_chars, to_chars
#include <cmath>         // isfinite
#include <system_error>  // errc

#include "text.h"  // trimmed

namespace ragdoll {
namespace {

template <class T>
std::optional<T> parsed(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> number_of(std::string_view text) {
  text = trimmed(text);
  // from_chars knows no plus sign
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const std::optional<double> value = parsed<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::uint64_t> whole_number_of(std::string_view text) {
  return parsed<std::uint64_t>(trimmed(text));
}

void append_number(std::string& text, double value, int digits) {
  char characters[64];
  char* const end = characters + sizeof characters;
  const auto result =
      digits == 0 ? std::to_chars(characters, end, value)
                  : std::to_chars(characters, end, value, std::chars_format::general, digits);
  text.append(characters, result.ptr);
}

std::string text_of(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

}  // namespace ragdoll
