#include "xml_writer.h"

#include <fcntl.h>   // open
#include <unistd.h>  // write, close, unlink

#include <cerrno>
#include <cstdio>  // rename
#include <filesystem>

#include "descriptor.h"     // system_reason
#include "numbers.h"        // append_number
#include "ragdoll/error.h"  // Error
#include "text.h"           // find_bad_byte

namespace fs = std::filesystem;

namespace ragdoll {
namespace {

constexpr std::size_t kFlushSize = 1 << 20;

void check_name(const std::string& path, bool force) {
  if (path.empty()) throw Error("the file to write has no name");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw Error(path + " is a folder; give the name of a file in it");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw Error(path + " is not a regular file; give another name");
  if (!force && fs::exists(fs::symlink_status(path, error)))
    throw Error(path + " exists already; give --force to replace it");
}

}  // namespace

XmlWriter::XmlWriter(const std::string& path, const WriteOptions& options)
    : path_(path), part_(path + ".part"), digits_(options.digits) {
  if (digits_ < 0 || digits_ > 17) throw Error("numbers are written with 1 to 17 digits");
  check_name(path, options.force);
  file_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) throw Error(path + " cannot be written: " + system_reason(errno));
}

XmlWriter::~XmlWriter() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(part_.c_str());
}

XmlWriter& XmlWriter::begin(const char* element) {
  element_ = element;
  pending_.append(2 * opened_.size(), ' ').append("<").append(element);
  return *this;
}

XmlWriter& XmlWriter::text(const char* attribute, std::string_view value) {
  pending_.append(" ").append(attribute).append("=\"");
  append_escaped(value);
  pending_.append("\"");
  return *this;
}

XmlWriter& XmlWriter::number(const char* attribute, double value) {
  pending_.append(" ").append(attribute).append("=\"");
  append_number(pending_, value, digits_);
  pending_.append("\"");
  return *this;
}

XmlWriter& XmlWriter::whole_number(const char* attribute, std::uint64_t value) {
  return text(attribute, std::to_string(value));
}

XmlWriter& XmlWriter::pair(const char* attribute, std::string_view p, std::string_view q) {
  pending_.append(" ").append(attribute).append("=\"");
  append_escaped(p);
  pending_.append(" ");
  append_escaped(q);
  pending_.append("\"");
  return *this;
}

void XmlWriter::end() {
  pending_.append("/>\n");
  if (pending_.size() >= kFlushSize) flush();
}

void XmlWriter::open() {
  pending_.append(">\n");
  opened_.push_back(element_);
}

void XmlWriter::close() {
  const char* const element = opened_.back();
  opened_.pop_back();
  pending_.append(2 * opened_.size(), ' ').append("</").append(element).append(">\n");
}

void XmlWriter::commit() {
  flush();
  const int closed = ::close(file_);
  file_ = -1;
  if (closed != 0 || ::rename(part_.c_str(), path_.c_str()) != 0) fail(errno);
}

void XmlWriter::append_escaped(std::string_view value) {
  if (find_bad_byte(value) != std::string_view::npos)
    throw Error(path_ + " cannot hold \"" + excerpt(value) + "\", which is not text in UTF-8");
  for (const char c : value) {
    switch (c) {
      case '&':
        pending_.append("&amp;");
        break;
      case '<':
        pending_.append("&lt;");
        break;
      case '>':
        pending_.append("&gt;");
        break;
      case '"':
        pending_.append("&quot;");
        break;
      case '\t':
        pending_.append("&#9;");
        break;
      case '\n':
        pending_.append("&#10;");
        break;
      case '\r':
        pending_.append("&#13;");
        break;
      default:
        pending_.push_back(c);
    }
  }
}

void XmlWriter::flush() {
  std::string_view rest = pending_;
  while (!rest.empty()) {
    const ssize_t count = ::write(file_, rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(errno);
    rest.remove_prefix(std::size_t(count));
  }
  pending_.clear();
}

void XmlWriter::fail(int error) {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
  ::unlink(part_.c_str());
  throw FileError(path_ + " cannot be written: " + system_reason(error));
}

}  // namespace ragdoll
