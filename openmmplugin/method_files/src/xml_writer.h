// XmlWriter: writes an XML file that is either complete or not there.

#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ragdoll/method_files/files.h"  // WriteOptions

namespace ragdoll {

class XmlWriter {
 public:
  /// @throw Error if the file may not or cannot be made under this name
  XmlWriter(const std::string& path, const WriteOptions& options);
  ~XmlWriter();  ///< without commit(), nothing is left
  XmlWriter(const XmlWriter&) = delete;
  XmlWriter& operator=(const XmlWriter&) = delete;

  // --- an element: begin, its attributes, then end or open

  XmlWriter& begin(const char* element);
  XmlWriter& text(const char* attribute, std::string_view value);
  XmlWriter& number(const char* attribute, double value);
  XmlWriter& whole_number(const char* attribute, std::uint64_t value);
  XmlWriter& pair(const char* attribute, std::string_view p, std::string_view q);
  void end();    ///< the element is empty
  void open();   ///< children follow
  void close();  ///< of the element opened last

  /// Gives the file its name.
  /// @throw FileError
  void commit();

 private:
  void append_escaped(std::string_view value);
  void flush();
  [[noreturn]] void fail(int error);

  std::string path_, part_;
  int digits_;
  int file_ = -1;
  std::string pending_;
  const char* element_ = nullptr;
  std::vector<const char*> opened_;
};

}  // namespace ragdoll
