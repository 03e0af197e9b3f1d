// Numbers in attributes: the same in every locale, and exact.

#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ragdoll {

/// White space around a number is allowed, as is a plus sign; anything else around it is not.
/// Empty if `text` is not a finite number within the range of a double.
std::optional<double> number_of(std::string_view text);

/// Decimal digits alone, white space around them.
std::optional<std::uint64_t> whole_number_of(std::string_view text);

/// Appends `value` with so many significant digits; 0: the fewest that read back exactly.
void append_number(std::string& text, double value, int digits = 0);
std::string text_of(double value);

}  // namespace ragdoll
