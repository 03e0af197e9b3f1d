// Weighting: how a bar's error is shared between its ends.

#pragma once
#include <string>

namespace ragdoll {

/// near + far = 1: shares of the end nearer the root and of the farther one.
struct Weighting {
  double near = 0.5, far = 0.5;
};

/// ".5/.5", ".75/.25", "1/0" or any "a/b" with a + b = 1: the far end's share first, as in the
/// thesis.
/// @throw Error if the text is no such pair
Weighting weighting_of(const std::string& text);

/// The shortest text that weighting_of reads back to the same value, ".75/.25".
std::string name_of(const Weighting& weighting);

}  // namespace ragdoll
