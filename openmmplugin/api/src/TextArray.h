// Arrays in XML: one child node with one text property, fields separated by spaces. Doubles come
// back exactly.

#pragma once
#include <openmm/serialization/SerializationNode.h>

#include <string>
#include <vector>

namespace ragdoll {

/// Collects fields of an array.
class TextWriter {
 public:
  TextWriter& add(int value);
  TextWriter& add(double value);  ///< the shortest text that reads back to the same value
  TextWriter& add(const std::string& label);  ///< any bytes; all but letters, digits, ._- as %hex

  const std::string& text() const { return text_; }

 private:
  void separate();
  std::string text_;
};

/// Gives the fields back in the same sequence.
class TextReader {
 public:
  TextReader(std::string text, std::string array) : text_(std::move(text)), array_(array) {}

  /// All of them: @throw OpenMMException if the next field is missing or no such value
  int integer();
  int below(int count);  ///< an integer of [0, count), as enums have them
  double real();
  std::string label();

  bool done() const { return at_ >= text_.size(); }

 private:
  std::string field();
  [[noreturn]] void fail(const std::string& field) const;

  std::string text_, array_;
  std::size_t at_ = 0;
};

/// The child node's text, empty where there is no such child.
std::string arrayText(const OpenMM::SerializationNode& node, const std::string& name);

/// Writes a child node; nothing for an empty array. @param write  (TextWriter&, const Item&)
template <class Items, class Write>
void writeArray(OpenMM::SerializationNode& node, const std::string& name, const Items& items,
                const Write& write) {
  if (items.empty()) return;
  TextWriter text;
  for (const auto& item : items) write(text, item);
  node.createChildNode(name).setStringProperty("values", text.text());
}

/// Reads what writeArray wrote. @param read  (TextReader&) -> Item
template <class Item, class Read>
std::vector<Item> readArray(const OpenMM::SerializationNode& node, const std::string& name,
                            const Read& read) {
  std::vector<Item> items;
  for (TextReader text(arrayText(node, name), name); !text.done();) items.push_back(read(text));
  return items;
}

}  // namespace ragdoll
