#include "text.h"

#include <cstdint>
#include <cstring>  // memcpy

namespace ragdoll {
namespace {

constexpr std::size_t kLongestExcerpt = 40;

/// Length of the character at the beginning of `text`, 0 if it is none.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 || is_space(text[0]) ? 1 : 0;

  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  unsigned long code = first & (0x7fU >> length);
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(k) & 0xc0U) != 0x80) return 0;
    code = code << 6 | (byte(k) & 0x3fU);
  }
  constexpr unsigned long kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  return code >= kLeast[length] && is_xml_character(code) ? length : 0;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::size_t find_bad_byte(std::string_view text) {
  constexpr std::uint64_t kHigh = 0x8080808080808080, kBlanks = 0x2020202020202020;
  std::size_t k = 0;
  while (k < text.size()) {
    // eight printable ASCII characters at once: none has its high bit, none is below 0x20
    if (text.size() - k >= 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, text.data() + k, 8);
      if (((word | ((word - kBlanks) & ~word)) & kHigh) == 0) {
        k += 8;
        continue;
      }
    }
    const std::size_t length = character_length(text.substr(k));
    if (length == 0) return k;
    k += length;
  }
  return std::string_view::npos;
}

bool is_xml_character(unsigned long code) {
  if (code < 0x20) return code == '\t' || code == '\n' || code == '\r';
  return code < 0xd800 || (code > 0xdfff && code < 0xfffe) || (code > 0xffff && code < 0x110000);
}

std::string excerpt(std::string_view text) {
  std::size_t length = text.size();
  if (length > kLongestExcerpt) {
    length = kLongestExcerpt;
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xc0U) == 0x80) --length;
  }
  std::string result(text.substr(0, length));
  for (char& c : result)
    if (is_space(c)) c = ' ';
  return length < text.size() ? result + "..." : result;
}

}  // namespace ragdoll
