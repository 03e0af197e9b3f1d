#include "TextArray.h"

#include <openmm/OpenMMException.h>

#include <algorithm>
#include <cctype>
#include <charconv>

namespace ragdoll {

namespace {

const char HEX[] = "0123456789abcdef";

bool isPlain(unsigned char byte) {
  return byte < 128 && (std::isalnum(byte) || byte == '.' || byte == '_' || byte == '-');
}

}  // namespace

// ---- writing

void TextWriter::separate() {
  if (!text_.empty()) text_ += ' ';
}

TextWriter& TextWriter::add(int value) {
  separate();
  text_ += std::to_string(value);
  return *this;
}

TextWriter& TextWriter::add(double value) {
  separate();
  char digits[32];
  text_.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  return *this;
}

TextWriter& TextWriter::add(const std::string& label) {
  separate();
  if (label.empty()) text_ += '%';  // a field is never empty, and an escape never that short
  for (unsigned char byte : label)
    if (isPlain(byte))
      text_ += char(byte);
    else
      text_.append({'%', HEX[byte / 16], HEX[byte % 16]});
  return *this;
}

// ---- reading

std::string TextReader::field() {
  const std::size_t end = std::min(text_.find(' ', at_), text_.size());
  std::string field = text_.substr(std::min(at_, end), end - std::min(at_, end));
  at_ = end + 1;
  return field;
}

void TextReader::fail(const std::string& field) const {
  throw OpenMM::OpenMMException("The XML array " + array_ + " is broken at \"" + field + "\".");
}

int TextReader::integer() {
  const std::string digits = field();
  int value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) fail(digits);
  return value;
}

int TextReader::below(int count) {
  const int value = integer();
  if (value < 0 || value >= count) fail(std::to_string(value));
  return value;
}

double TextReader::real() {
  const std::string digits = field();
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) fail(digits);
  return value;
}

std::string TextReader::label() {
  const std::string escaped = field();
  if (escaped.empty()) fail(escaped);
  if (escaped == "%") return {};
  std::string label;
  for (std::size_t i = 0; i < escaped.size(); ++i) {
    if (escaped[i] != '%') {
      label += escaped[i];
      continue;
    }
    int byte = 0;
    const char* digits = escaped.data() + i + 1;
    if (i + 2 >= escaped.size() || std::from_chars(digits, digits + 2, byte, 16).ptr != digits + 2)
      fail(escaped);
    label += char(byte);
    i += 2;
  }
  return label;
}

std::string arrayText(const OpenMM::SerializationNode& node, const std::string& name) {
  for (const OpenMM::SerializationNode& child : node.getChildren())
    if (child.getName() == name) return child.getStringProperty("values");
  return {};
}

}  // namespace ragdoll
