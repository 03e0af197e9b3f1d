// RDKit's messages, caught instead of printed. Private to chemistry.

#pragma once
#include <RDGeneral/RDLog.h>

#include <memory>
#include <sstream>
#include <string>
#include <utility>  // exchange

namespace ragdoll {

/// While it lives, errors are kept and nothing is printed. Not for several threads at a time.
class RdkitMessages {
 public:
  RdkitMessages()
      : before_(std::exchange(rdErrorLog, std::make_shared<boost::logging::rdLogger>(&text_))) {
    const auto silent = [](std::shared_ptr<boost::logging::rdLogger>& log) {
      return log ? std::exchange(log->df_enabled, false) : false;
    };
    warned_ = silent(rdWarningLog);
    informed_ = silent(rdInfoLog);
  }
  ~RdkitMessages() {
    rdErrorLog = before_;
    if (rdWarningLog) rdWarningLog->df_enabled = warned_;
    if (rdInfoLog) rdInfoLog->df_enabled = informed_;
  }
  RdkitMessages(const RdkitMessages&) = delete;
  RdkitMessages& operator=(const RdkitMessages&) = delete;

  /// The first line that says something, without the time of day; empty where none does.
  std::string first() const {
    std::istringstream lines(text_.str());
    std::string line;
    while (std::getline(lines, line)) {
      if (line.starts_with("[") && line.find("] ") == 9) line.erase(0, 11);
      if (line.size() > 3) return line;
    }
    return "";
  }

 private:
  std::ostringstream text_;
  std::shared_ptr<boost::logging::rdLogger> before_;
  bool warned_ = false, informed_ = false;
};

}  // namespace ragdoll
