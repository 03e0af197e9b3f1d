// Tests for openmmplugin/method_files: structures that are read and written.

#include "ragdoll/method_files/structure_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "samples.h"

namespace ragdoll {
namespace {

Structure read_text(const std::string& text, Warnings* warnings = nullptr) {
  const Folder folder;
  return read_structure(folder.write("s.xml", text), warnings);
}

TEST(StructureFile, ExampleOfTheSpecificationIsRead) {
  const Structure s = read_text(R"(<structure version="1" length-unit="nm" class="tree">
  <joint id="a" x="0" y="0" z="0" mass="12.5"/>          <!-- mass optional, 1; fixed="true" -->
  <joint id="b" x="1" y="0" z="0"/>
  <joint id="c" x="3" y="4" z="0" fixed="true"/><joint id="d" x="2" y="0.5" z="-1e-3"/>
  <bar joints="a b"/>                                  <!-- length optional: the present distance -->
  <bar joints="c a"/>  <bar joints="d a" length="0.25"/>
  <tether joints="a c" length="3.0"/>  <contact joints="b d" length="0.8"/>
</structure>
)");
  EXPECT_EQ(s.length_unit, "nm");
  EXPECT_EQ(s.class_name, "tree");
  EXPECT_EQ(s.ids, (std::vector<std::string>{"a", "b", "c", "d"}));
  EXPECT_EQ(s.parts.masses, (std::vector<double>{12.5, 1, 1, 1}));
  EXPECT_EQ(s.parts.fixed, (std::vector<std::uint8_t>{0, 0, 1, 0}));
  EXPECT_EQ(s.positions[3], Vec3(2, 0.5, -1e-3));
  ASSERT_EQ(s.parts.bars.size(), 3U);
  EXPECT_EQ(s.parts.bars[0].length, 1);
  EXPECT_EQ(s.parts.bars[1].p, 2);
  EXPECT_EQ(s.parts.bars[1].q, 0);
  EXPECT_EQ(s.parts.bars[1].length, 5);
  EXPECT_EQ(s.parts.bars[2].length, 0.25);
  ASSERT_EQ(s.parts.tethers.size(), 1U);
  EXPECT_EQ(s.parts.tethers[0].length, 3);
  ASSERT_EQ(s.parts.contacts.size(), 1U);
  EXPECT_EQ(s.parts.contacts[0].length, 0.8);
}

TEST(StructureFile, AttributesAndElementsComeInAnyOrder) {
  const Structure s = read_text(R"(<?xml version="1.0" encoding="utf-8"?>
<!-- a comment > with "quotes" -->
<structure class='tree' version='1'><bar length="2" joints="  b	a "/>
<joint z="3" y="2" x="1" id="a"></joint><joint fixed="false" z="0" id="b" y="0" x=" +5. "
/></structure  >
<!-- the end -->)");
  EXPECT_EQ(s.positions[0], Vec3(1, 2, 3));
  EXPECT_EQ(s.positions[1], Vec3(5, 0, 0));
  EXPECT_EQ(s.parts.bars[0].p, 1);
  EXPECT_EQ(s.parts.bars[0].q, 0);
  EXPECT_EQ(s.parts.bars[0].length, 2);
  EXPECT_EQ(s.length_unit, "none");
}

TEST(StructureFile, WindowsLineEndsAndByteOrderMarkMakeNoDifference) {
  std::string windows = "\xef\xbb\xbf";
  for (const char c : square_text()) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(fingerprint(read_text(windows)), fingerprint(square()));
  EXPECT_EQ(fingerprint(read_text(square_text())), fingerprint(square()));
}

TEST(StructureFile, UnknownAttributesAreWarnedOfOnceAndIgnored) {
  Warnings warnings;
  const Structure s = read_text(in_structure(R"(<joint id="a" x="0" y="0" z="0"
   colour="red"/>
<joint id="b" x="1" y="0" z="0" colour="blue"/>
<bar joints="a b" weight="&amp;"/>)"),
                                &warnings);
  EXPECT_EQ(s.ids.size(), 2U);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[0].find("s.xml, line 3: <joint> has the unknown attribute colour, which is "
                             "ignored"),
            std::string::npos);
  EXPECT_NE(warnings[1].find("line 5: <bar> has the unknown attribute weight"), std::string::npos);
}

TEST(StructureFile, WarningsOfManyUnknownAttributesAreCutShort) {
  std::string joint = "<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\"";
  for (int k = 0; k < 1000; ++k) joint += " u" + std::to_string(k) + "=\"\"";
  Warnings warnings;
  read_text(in_structure(joint + "/>"), &warnings);
  ASSERT_EQ(warnings.size(), 21U);
  EXPECT_NE(warnings.back().find("further unknown attributes are ignored"), std::string::npos);
}

TEST(StructureFile, FamiliesAreTakenByTheirLabel) {
  for (const char* family : {"grid", "ring-chain", "regular", "cloth", "thread", "protein"})
    EXPECT_EQ(read_text(in_structure("<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\"/>",
                                     std::string(" class=\"") + family + "\""))
                  .class_name,
              family);
}

TEST(StructureFile, ClassOfSeveralComponentsIsThatOfTheLargestOrOfAll) {
  const std::string two_triangles = R"(<joint id="a" x="0" y="0" z="0"/>
<joint id="b" x="1" y="0" z="0"/><joint id="c" x="0" y="1" z="0"/>
<joint id="d" x="5" y="0" z="0"/><joint id="e" x="6" y="0" z="0"/><joint id="f" x="5" y="1" z="0"/>
<bar joints="a b"/><bar joints="b c"/><bar joints="c a"/>
<bar joints="d e"/><bar joints="e f"/><bar joints="f d"/>)";
  for (const char* name : {"1-cycle", "2-cycle"})
    EXPECT_EQ(
        read_text(in_structure(two_triangles, std::string(" class=\"") + name + "\"")).class_name,
        name);
  EXPECT_NE(error_of([&] { read_text(in_structure(two_triangles, " class=\"tree\"")); }), "");
}

TEST(StructureFile, RoundTripsAreExact) {
  std::mt19937_64 random(1);
  const auto any_double = [&] {
    while (true) {
      const std::uint64_t bits = random();
      double value = 0;
      std::memcpy(&value, &bits, sizeof value);
      if (std::isfinite(value)) return value;
    }
  };
  Structure s;
  s.length_unit = "half a \"cubit\" & <more>\n\t";
  s.class_name = "tree";
  for (int j = 0; j < 2000; ++j) {
    s.ids.push_back("j<&>\"'é" + std::to_string(j));
    s.positions.emplace_back(any_double(), any_double(), any_double());
    s.parts.masses.push_back(j % 3 == 0 ? 1 : std::abs(any_double()));
    s.parts.fixed.push_back(j % 5 == 0);
    if (j > 0) s.parts.bars.push_back({j, j / 2, std::abs(any_double())});
    if (j > 9) s.parts.tethers.push_back({j, j - 9, std::abs(any_double())});
    if (j > 7) s.parts.contacts.push_back({j - 7, j, std::abs(any_double())});
  }
  s.positions[0] = Vec3(-0.0, std::numeric_limits<double>::denorm_min(), 0.1);
  s.positions[1] = Vec3(std::numeric_limits<double>::max(), -std::numeric_limits<double>::min(), 1);

  const Folder folder;
  for (const int digits : {0, 17}) {
    const std::string path = folder / ("s" + std::to_string(digits) + ".xml");
    write_structure(path, s, {false, digits});
    Warnings warnings;
    const Structure back = read_structure(path, &warnings);
    EXPECT_EQ(fingerprint(back), fingerprint(s));
    EXPECT_TRUE(warnings.empty());
  }
}

TEST(StructureFile, NumbersAreShortUnlessDigitsAreAskedFor) {
  Structure s = square();
  s.positions[0][0] = 0.1;
  const Folder folder;
  write_structure(folder / "short.xml", s);
  write_structure(folder / "long.xml", s, {false, 17});
  EXPECT_NE(text_of_file(folder / "short.xml").find("<joint id=\"a\" x=\"0.1\" y=\"0\" z=\"0\"/>"),
            std::string::npos);
  EXPECT_NE(text_of_file(folder / "long.xml").find("x=\"0.10000000000000001\""), std::string::npos);
}

}  // namespace
}  // namespace ragdoll
