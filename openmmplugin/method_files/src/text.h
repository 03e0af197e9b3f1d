// Text in files: white space, UTF-8, quotations in messages.

#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace ragdoll {

/// The white space of XML.
constexpr bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

std::string_view trimmed(std::string_view text);

/// Offset of the first byte that XML 1.0 in UTF-8 does not allow: a broken or overlong sequence, a
/// surrogate, a control character. npos if there is none.
std::size_t find_bad_byte(std::string_view text);

/// Whether XML allows a character of this number.
bool is_xml_character(unsigned long code);

/// The beginning of a text for a message: in one line, cut short between characters.
std::string excerpt(std::string_view text);

}  // namespace ragdoll
