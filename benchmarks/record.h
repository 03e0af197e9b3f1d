// Record: what was measured, as one line of JSON. A program's output is such lines.

#pragma once
#include <cmath>    // isfinite
#include <cstdint>  // int64_t
#include <cstdio>   // printf
#include <string>

namespace benchmark {

class Record {
 public:
  explicit Record(const std::string& what) { text("what", what); }

  Record& text(const char* key, const std::string& value) {
    return add(key, '"' + value + '"');  // names of ours: nothing in them has to be escaped
  }
  Record& number(const char* key, double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.6g", value);
    return add(key, std::isfinite(value) ? digits : "null");
  }
  Record& count(const char* key, std::int64_t value) { return add(key, std::to_string(value)); }

  void print() const {
    std::printf("{%s}\n", fields_.c_str());
    std::fflush(stdout);
  }

 private:
  Record& add(const char* key, const std::string& value) {
    fields_ += (fields_.empty() ? "\"" : ", \"") + std::string(key) + "\": " + value;
    return *this;
  }

  std::string fields_;
};

}  // namespace benchmark
