#include "xml_reader.h"

#include <algorithm>  // count, find_if, sort, adjacent_find, lower_bound
#include <charconv>   // from_chars

#include "numbers.h"        // number_of, whole_number_of
#include "ragdoll/error.h"  // Error
#include "text.h"           // is_space, excerpt, find_bad_byte

namespace ragdoll {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr std::size_t kLongestTag = 1 << 20;  ///< keeps pugixml's tree of a tag small
constexpr std::size_t kLongestReference = 64;
constexpr std::size_t kMostWarnings = 20;

std::string quoted(std::string_view text) {
  return std::string("\"").append(excerpt(text)).append("\"");
}

std::string in_brackets(std::string_view name) {
  return std::string("<").append(excerpt(name)).append(">");
}

bool same_ignoring_case(std::string_view a, std::string_view lower) {
  return std::equal(a.begin(), a.end(), lower.begin(), lower.end(), [](char x, char y) {
    return (x >= 'A' && x <= 'Z' ? char(x - 'A' + 'a') : x) == y;
  });
}

/// Whether this is what XML allows between "&" and ";" without a DOCTYPE.
bool is_reference(std::string_view text) {
  for (const char* known : {"lt", "gt", "amp", "quot", "apos"})
    if (text == known) return true;
  if (text.size() < 2 || text[0] != '#') return false;
  const bool hexadecimal = text[1] == 'x';
  text.remove_prefix(hexadecimal ? 2 : 1);
  unsigned long code = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, code, hexadecimal ? 16 : 10);
  return result.ec == std::errc() && result.ptr == end && is_xml_character(code);
}

}  // namespace

XmlReader::XmlReader(const std::string& path, Warnings* warnings)
    : path_(path), warnings_(warnings), buffer_(read_file(path)) {
  all_ = {buffer_.bytes.get(), buffer_.size};
  if (all_.empty()) throw Error(path + " is empty");
  if (all_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
  const std::size_t bad = find_bad_byte(all_);
  if (bad == std::string_view::npos) return;
  move_to(bad);
  const int byte = static_cast<unsigned char>(all_[bad]);
  constexpr char kDigits[] = "0123456789abcdef";
  fail(line_, std::string("the byte 0x") + kDigits[byte / 16] + kDigits[byte % 16] +
                  (byte < 0x80 ? " has no place in XML" : " is not UTF-8"));
}

// === The walk

void XmlReader::enter_root(const char* name) {
  if (next_token() != Token::start)
    fail(last_line(), "there is no <" + std::string(name) + "> in it");
  if (name_ != name)
    fail(tag_line_, "the file holds " + in_brackets(name_) + " instead of <" + name + ">");
  enter();
}

void XmlReader::enter() {
  entered_.emplace_back(name_);
}

bool XmlReader::next_child() {
  if (self_closed_) {
    self_closed_ = false;
    entered_.pop_back();
    return false;
  }
  const Token token = next_token();
  if (token == Token::start) return true;
  if (token == Token::end_of_file)
    fail(last_line(), "the file ends before </" + excerpt(entered_.back()) + ">");
  expect_end();
  entered_.pop_back();
  return false;
}

void XmlReader::end_empty() {
  if (self_closed_) {
    self_closed_ = false;
    return;
  }
  enter();
  const Token token = next_token();
  if (token == Token::start)
    fail(tag_line_, in_brackets(name_) + " stands within " + in_brackets(entered_.back()) +
                        ", which is to be empty");
  if (token == Token::end_of_file)
    fail(last_line(), "the file ends before </" + excerpt(entered_.back()) + ">");
  expect_end();
  entered_.pop_back();
}

void XmlReader::end_file() {
  const Token token = next_token();
  if (token == Token::start) fail(tag_line_, "a second root element, " + in_brackets(name_));
  if (token == Token::end) fail(tag_line_, "</" + excerpt(name_) + "> ends what never began");
}

void XmlReader::expect_end() {
  if (name_ != entered_.back())
    fail(tag_line_,
         "</" + excerpt(name_) + "> stands where </" + excerpt(entered_.back()) + "> should");
}

// === The scanner

void XmlReader::move_to(std::size_t offset) {
  line_ +=
      std::count(all_.begin() + std::ptrdiff_t(at_), all_.begin() + std::ptrdiff_t(offset), '\n');
  at_ = offset;
}

/// Of the end of the file; a line break at the end begins no line.
long XmlReader::last_line() const {
  return all_.ends_with('\n') ? line_ - 1 : line_;
}

XmlReader::Token XmlReader::next_token() {
  while (true) {
    skip_text();
    if (rest().empty()) return Token::end_of_file;
    tag_line_ = line_;
    if (rest().starts_with("<!--")) {
      skip_comment();
    } else if (rest().starts_with("<?")) {
      skip_instruction();
    } else if (rest().starts_with("<!DOCTYPE")) {
      fail(line_, "a DOCTYPE, with which entities are declared, is not accepted");
    } else if (rest().starts_with("<![CDATA[")) {
      fail(line_, "text in a CDATA section has no place in this file");
    } else if (rest().starts_with("<!")) {
      fail(line_, quoted(rest().substr(0, rest().find_first_of(" \t\r\n>"))) + " is not accepted");
    } else if (rest().starts_with("</")) {
      read_end_tag();
      return Token::end;
    } else {
      read_start_tag();
      return Token::start;
    }
  }
}

/// To the next tag; only white space may come before it.
void XmlReader::skip_text() {
  const std::string_view text = rest().substr(0, rest().find('<'));
  const auto first = std::find_if_not(text.begin(), text.end(), is_space);
  if (first != text.end()) {
    move_to(at_ + std::size_t(first - text.begin()));
    fail(line_, "the text " + quoted(trimmed(rest().substr(0, rest().find_first_of("<\n")))) +
                    " stands where only elements may be");
  }
  move_to(at_ + text.size());
}

void XmlReader::skip_comment() {
  const std::size_t dashes = all_.find("--", at_ + 4);
  if (all_.find('>', std::min(dashes, all_.size())) == std::string_view::npos)
    fail(line_, "the comment that begins here has no end");
  if (all_[dashes + 2] != '>') fail(line_, "the comment that begins here has a -- within it");
  move_to(dashes + 3);
}

void XmlReader::skip_instruction() {
  const std::size_t end = rest().find("?>", 2);
  if (end == std::string_view::npos) fail(line_, "the instruction that begins here has no end");
  const std::string_view instruction = rest().substr(0, end + 2);
  if (instruction.starts_with("<?xml") && (is_space(instruction[5]) || instruction[5] == '?'))
    check_declaration(instruction);
  move_to(at_ + instruction.size());
}

/// Refuses a declaration of another encoding than UTF-8 or its part, ASCII.
void XmlReader::check_declaration(std::string_view declaration) {
  const std::string_view before = all_.substr(0, at_);
  if (!before.empty() && before != kByteOrderMark)
    fail(line_, "an XML declaration stands only at the beginning");
  const pugi::xml_parse_result result =
      document_.load_buffer(declaration.data(), declaration.size(),
                            pugi::parse_declaration | pugi::parse_fragment, pugi::encoding_utf8);
  const pugi::xml_node attributes = document_.first_child();
  if (result.status != pugi::status_ok || !attributes.attribute("version"))
    fail(line_, "the XML declaration is not well formed");
  const pugi::xml_attribute encoding = attributes.attribute("encoding");
  for (const char* known : {"utf-8", "utf8", "us-ascii", "ascii"})
    if (!encoding || same_ignoring_case(encoding.value(), known)) return;
  fail(line_, "the encoding " + quoted(encoding.value()) + " is not UTF-8");
}

void XmlReader::read_end_tag() {
  const std::size_t end = tag_end();
  name_ = all_.substr(at_ + 2, end - at_ - 3);
  while (!name_.empty() && is_space(name_.back())) name_.remove_suffix(1);
  self_closed_ = false;
  move_to(end);
}

void XmlReader::read_start_tag() {
  const std::size_t begin = at_, end = tag_end();
  self_closed_ = all_[end - 2] == '/';

  const std::string_view tag = all_.substr(begin, end - begin);

  // the lines, before pugixml writes into them
  tag_breaks_.clear();
  for (std::size_t k = 0; (k = tag.find('\n', k)) != std::string_view::npos; ++k)
    tag_breaks_.push_back(tag.data() + k);
  check_references(tag);
  line_ += long(tag_breaks_.size());
  at_ = end;
  parse_tag(begin, end);
}

/// Offset behind the ">" of the tag that begins here.
std::size_t XmlReader::tag_end() const {
  char quote = 0;
  const std::size_t limit = std::min(all_.size(), at_ + kLongestTag);
  for (std::size_t k = at_ + 1; k < limit; ++k) {
    const char c = all_[k];
    if (c == '<') fail(line_, "the tag that begins here has a \"<\" within it");
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return k + 1;
    }
  }
  if (limit < all_.size()) fail(line_, "the tag that begins here is longer than a mebibyte");
  fail(line_, "the file ends within the tag that begins here");
}

void XmlReader::check_references(std::string_view tag) const {
  for (std::size_t k = 0; (k = tag.find('&', k)) != std::string_view::npos; ++k) {
    const std::string_view text = tag.substr(k + 1, kLongestReference);
    const std::size_t length = text.find(';');
    if (length != std::string_view::npos && is_reference(text.substr(0, length))) continue;
    fail(line_of(tag.data() + k),
         quoted(tag.substr(k, length == std::string_view::npos ? 1 : length + 2)) +
             " stands for no character; write &amp; for an &");
  }
}

void XmlReader::parse_tag(std::size_t begin, std::size_t end) {
  constexpr unsigned kFlags =
      pugi::parse_escapes | pugi::parse_wconv_attribute | pugi::parse_fragment;
  const pugi::xml_parse_result result = document_.load_buffer_inplace(
      buffer_.bytes.get() + begin, end - begin, kFlags, pugi::encoding_utf8);
  // a tag that does not close itself is complete as far as we go
  const bool open = result.status == pugi::status_end_element_mismatch && !self_closed_;
  if (result.status != pugi::status_ok && !open)
    fail(line_of(all_.data() + begin + result.offset), "the tag is not well-formed XML");
  element_ = document_.first_child();
  name_ = element_.name();
}

long XmlReader::line_of(const char* place) const {
  return tag_line_ +
         (std::lower_bound(tag_breaks_.begin(), tag_breaks_.end(), place) - tag_breaks_.begin());
}

// === Attributes

void XmlReader::collect(std::span<Attribute> known) {
  std::vector<std::string_view> others;
  for (const pugi::xml_attribute found : element_.attributes()) {
    const std::string_view name = found.name();
    const Attribute attribute{found.name(), found.value(), line_of(found.name())};
    const auto place = std::find_if(known.begin(), known.end(),
                                    [&](const Attribute& a) { return name == a.name; });
    if (place == known.end()) {
      others.push_back(name);
      warn(attribute);
    } else if (*place) {
      fail(attribute.line, in_brackets(name_) + " has " + attribute.name + " twice");
    } else {
      place->value = attribute.value;
      place->line = attribute.line;
    }
  }
  std::sort(others.begin(), others.end());
  const auto twice = std::adjacent_find(others.begin(), others.end());
  if (twice != others.end())
    fail(line_of(twice->data()), in_brackets(name_) + " has " + excerpt(*twice) + " twice");
}

void XmlReader::warn(const Attribute& unknown) {
  if (!warnings_) return;
  const std::string what =
      in_brackets(name_) + " has the unknown attribute " + excerpt(unknown.name);
  if (warned_.size() > kMostWarnings || !warned_.insert(what).second) return;
  const std::string place = path_ + ", line " + std::to_string(unknown.line) + ": ";
  if (warned_.size() <= kMostWarnings)
    warnings_->push_back(place + what + ", which is ignored");
  else
    warnings_->push_back(place + "further unknown attributes are ignored without a warning");
}

const Attribute& XmlReader::required(const Attribute& attribute) const {
  if (!attribute) fail(tag_line_, in_brackets(name_) + " has no " + attribute.name);
  return attribute;
}

std::string XmlReader::text(const Attribute& attribute) const {
  if (required(attribute).value.empty()) fail(attribute, "which is empty");
  return std::string(attribute.value);
}

std::string_view XmlReader::id(const Attribute& attribute) const {
  if (required(attribute).value.empty()) fail(attribute, "which is empty");
  if (std::any_of(attribute.value.begin(), attribute.value.end(), is_space))
    fail(attribute, "which has a space in it");
  return attribute.value;
}

double XmlReader::number(const Attribute& attribute) const {
  const std::optional<double> value = number_of(required(attribute).value);
  if (!value) fail(attribute, "which is not a finite number");
  return *value;
}

double XmlReader::positive_number(const Attribute& attribute) const {
  const double value = number(attribute);
  if (value <= 0) fail(attribute, "which is not positive");
  return value;
}

std::uint64_t XmlReader::whole_number(const Attribute& attribute) const {
  const std::optional<std::uint64_t> value = whole_number_of(required(attribute).value);
  if (!value) fail(attribute, "which is not a whole number from 0 up");
  return *value;
}

bool XmlReader::flag(const Attribute& attribute) const {
  const std::string_view value = required(attribute).value;
  if (value != "true" && value != "false") fail(attribute, "which is neither true nor false");
  return value == "true";
}

void XmlReader::check_version(const Attribute& attribute) const {
  if (required(attribute).value != "1") fail(attribute, "but only version 1 is known");
}

std::pair<std::string_view, std::string_view> XmlReader::two_ids(const Attribute& attribute) const {
  const std::string_view value = trimmed(required(attribute).value);
  const auto space = std::find_if(value.begin(), value.end(), is_space);
  const std::string_view p = value.substr(0, std::size_t(space - value.begin()));
  const std::string_view q = trimmed(value.substr(p.size()));
  if (q.empty() || std::any_of(q.begin(), q.end(), is_space))
    fail(attribute, "which is not two ids with a space between them");
  return {p, q};
}

// === Sentences

void XmlReader::fail(long line, const std::string& reason) const {
  throw Error(path_ + ", line " + std::to_string(line) + ": " + reason);
}

void XmlReader::fail(const Attribute& attribute, const std::string& reason) const {
  fail(attribute.line, in_brackets(name_) + " has " + attribute.name + "=" +
                           quoted(attribute.value) + ", " + reason);
}

void XmlReader::fail_unknown_element(const std::string& known) const {
  fail(tag_line_, in_brackets(name_) + " is unknown in " + in_brackets(entered_.back()) +
                      "; it may hold " + known);
}

}  // namespace ragdoll
