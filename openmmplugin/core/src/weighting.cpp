#include "ragdoll/weighting.h"

#include <charconv>  // from_chars, to_chars
#include <cmath>     // abs, isfinite
#include <utility>   // pair

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

std::pair<double, bool> number_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return {value, error == std::errc() && stop == end && std::isfinite(value)};
}

std::string text_of(double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  std::string text(buffer, result.ptr);
  return text.starts_with("0.") ? text.substr(1) : text;
}

}  // namespace

Weighting weighting_of(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string::npos) {
    const auto [far, far_ok] = number_of(text.substr(0, slash));
    const auto [near, near_ok] = number_of(text.substr(slash + 1));
    if (far_ok && near_ok && far >= 0 && near >= 0 && std::abs(far + near - 1) <= 1e-9)
      return {near, far};
  }
  throw Error("weighting '" + text +
              "' is not two shares a/b that add to 1, such as .5/.5, .75/.25 or 1/0");
}

std::string name_of(const Weighting& weighting) {
  return text_of(weighting.far) + "/" + text_of(weighting.near);
}

}  // namespace ragdoll
