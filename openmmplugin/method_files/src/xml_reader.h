// XmlReader: walks through an XML file element by element and knows the line of each.
//
// A small scanner finds where a tag begins and ends, and holds the file to what pugixml lets pass:
// text between elements, DOCTYPE, unknown references, several roots. pugixml then parses that one
// tag in place. So memory is the file and not its tree, which would be five to sixteen times as
// large, and nothing is built of a file before the line that makes it useless.

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <pugixml.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>  // pair
#include <vector>

#include "input.h"                       // Buffer
#include "ragdoll/method_files/files.h"  // Warnings

namespace ragdoll {

/// Value of an attribute; valid as long as the reader.
struct Attribute {
  const char* name = nullptr;
  std::string_view value = {};
  long line = 0;  ///< 0: the element has no such attribute

  explicit operator bool() const { return line > 0; }
};

class XmlReader {
 public:
  /// @throw Error if the file cannot be read or is not text in UTF-8
  XmlReader(const std::string& path, Warnings* warnings);
  XmlReader(const XmlReader&) = delete;
  XmlReader& operator=(const XmlReader&) = delete;

  // --- the walk

  /// Goes to the root element, which is to have this name, and enters it.
  void enter_root(const char* name);
  /// Enters the present element, for its children.
  void enter();
  /// Goes to the next child of the element entered last; false: it has no more, and is left.
  bool next_child();
  /// Passes the end of the present element, which is to be empty.
  void end_empty();
  /// There is to be nothing more in the file.
  void end_file();

  // --- the present element

  std::string_view name() const { return name_; }
  long line() const { return tag_line_; }

  /// Its attributes of these names; warns of all others.
  template <std::size_t n>
  std::array<Attribute, n> attributes(const char* const (&names)[n]) {
    std::array<Attribute, n> found;
    for (std::size_t k = 0; k < n; ++k) found[k].name = names[k];
    collect(found);
    return found;
  }

  std::string text(const Attribute& attribute) const;        ///< neither missing nor empty
  std::string_view id(const Attribute& attribute) const;     ///< text without spaces
  double number(const Attribute& attribute) const;           ///< finite
  double positive_number(const Attribute& attribute) const;  ///< finite
  std::uint64_t whole_number(const Attribute& attribute) const;
  bool flag(const Attribute& attribute) const;           ///< "true" or "false"
  void check_version(const Attribute& attribute) const;  ///< 1

  /// Two ids with white space between them.
  std::pair<std::string_view, std::string_view> two_ids(const Attribute& attribute) const;

  // --- sentences

  [[noreturn]] void fail(long line, const std::string& reason) const;
  /// "<joint> has x="nan", which is not a finite number"
  [[noreturn]] void fail(const Attribute& attribute, const std::string& reason) const;
  /// The present element is none of `known`, a list in words.
  [[noreturn]] void fail_unknown_element(const std::string& known) const;

 private:
  enum class Token { start, end, end_of_file };

  Token next_token();
  void skip_text();
  void skip_comment();
  void skip_instruction();
  void check_declaration(std::string_view declaration);
  void read_start_tag();
  void read_end_tag();
  std::size_t tag_end() const;
  void check_references(std::string_view tag) const;
  void parse_tag(std::size_t begin, std::size_t end);

  void collect(std::span<Attribute> known);
  void warn(const Attribute& unknown);
  const Attribute& required(const Attribute& attribute) const;
  void expect_end();

  std::string_view rest() const { return all_.substr(at_); }
  void move_to(std::size_t offset);  ///< counts the lines on the way
  long line_of(const char* place) const;
  long last_line() const;

  std::string path_;
  Warnings* warnings_;
  Buffer buffer_;
  std::string_view all_;
  std::size_t at_ = 0;
  long line_ = 1;  ///< of at_

  pugi::xml_document document_;  ///< the present tag alone
  pugi::xml_node element_;
  std::string_view name_;  ///< of the present element or end tag
  long tag_line_ = 1;
  std::vector<const char*> tag_breaks_;  ///< line breaks within the tag
  bool self_closed_ = false;

  std::vector<std::string> entered_;
  std::set<std::string> warned_;  ///< each once, however many elements have the attribute
};

}  // namespace ragdoll
