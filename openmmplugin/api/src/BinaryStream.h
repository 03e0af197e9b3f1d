// Values in a binary checkpoint. Checkpoints are read by the machine and build that wrote them.

#pragma once
#include <openmm/OpenMMException.h>

#include <istream>
#include <ostream>
#include <string>
#include <type_traits>

namespace ragdoll {

template <class Value>
void writeValue(std::ostream& stream, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  stream.write(reinterpret_cast<const char*>(&value), sizeof value);
}

/// @throw OpenMMException if the stream ends early
template <class Value>
Value readValue(std::istream& stream) {
  static_assert(std::is_trivially_copyable_v<Value>);
  Value value;
  stream.read(reinterpret_cast<char*>(&value), sizeof value);
  if (!stream)
    throw OpenMM::OpenMMException("The checkpoint ends within RagdollIntegrator's part.");
  return value;
}

inline void writeText(std::ostream& stream, const std::string& text) {
  writeValue(stream, text.size());
  stream.write(text.data(), std::streamsize(text.size()));
}

/// @throw OpenMMException if the stream ends early
inline std::string readText(std::istream& stream) {
  std::string text;
  for (auto left = readValue<std::size_t>(stream); left > 0; --left)
    text += readValue<char>(stream);
  return text;
}

}  // namespace ragdoll
