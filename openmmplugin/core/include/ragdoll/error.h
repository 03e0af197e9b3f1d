// The one exception of core: a sentence that names the object and says what is wrong with it.

#pragma once
#include <stdexcept>
#include <string>

namespace ragdoll {

/// Bad input or an impossible request. what() is one sentence for the user.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& sentence) : std::runtime_error(sentence) {}
};

}  // namespace ragdoll
