// Tests for openmmplugin/method_files: what is refused, with the line and the reason.

#include <gtest/gtest.h>

#include <functional>

#include "ragdoll/method_files/force_file.h"
#include "ragdoll/method_files/order_file.h"
#include "ragdoll/method_files/results_file.h"
#include "ragdoll/method_files/structure_file.h"
#include "samples.h"

namespace ragdoll {
namespace {

struct Hostile {
  const char* name;
  std::string text;
  const char* sentence;  ///< what follows the path
};

std::ostream& operator<<(std::ostream& out, const Hostile& hostile) {
  return out << hostile.name;
}

std::string name_of(const testing::TestParamInfo<Hostile>& info) {
  return info.param.name;
}

void expect_refusal(const Hostile& hostile,
                    const std::function<void(const std::string& path)>& read) {
  const Folder folder;
  const std::string path = folder.write("x.xml", hostile.text);
  EXPECT_EQ(error_of([&] { read(path); }), path + hostile.sentence);
}

const std::string joint_a = "<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\"/>\n";
const std::string joints_ab = joint_a + "<joint id=\"b\" x=\"1\" y=\"0\" z=\"0\"/>\n";
const std::string joints_abc = joints_ab + "<joint id=\"c\" x=\"1\" y=\"1\" z=\"0\"/>\n";

std::string joint_with(const std::string& attributes) {
  return in_structure("<joint " + attributes + "/>");
}

// === Structures

class StructureRefusal : public testing::TestWithParam<Hostile> {};

TEST_P(StructureRefusal, NamesTheLineAndTheReason) {
  expect_refusal(GetParam(), [](const std::string& path) { read_structure(path); });
}

const std::string laughs = R"(<?xml version="1.0"?>
<!DOCTYPE lolz [
 <!ENTITY lol "lol">
 <!ENTITY lol1 "&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;">
]>
<structure version="1"><joint id="&lol1;" x="0" y="0" z="0"/></structure>)";

INSTANTIATE_TEST_SUITE_P(
    Graph, StructureRefusal,
    testing::Values(
        Hostile{"EmptyStructure", in_structure(""), ", line 1: the structure has no joints"},
        Hostile{"SelfClosedStructure", "<structure version=\"1\"/>",
                ", line 1: the structure has no joints"},
        Hostile{"UnknownJoint", in_structure(joint_a + "<bar joints=\"a zz\"/>"),
                ", line 3: the bar names the joint zz, which the structure does not have"},
        Hostile{"UnknownJointOfTether",
                in_structure(joint_a + "<tether length=\"1\" joints=\"zz a\"/>"),
                ", line 3: the tether names the joint zz, which the structure does not have"},
        Hostile{"BarToItself", in_structure(joint_a + "<bar joints=\"a a\"/>"),
                ", line 3: the bar joins a to itself"},
        Hostile{"ContactToItself", in_structure(joint_a + "<contact joints=\"a a\" length=\"1\"/>"),
                ", line 3: the contact joins a to itself"},
        Hostile{"TwoBarsOnOnePair",
                in_structure(joints_abc +
                             "<bar joints=\"a b\"/>\n<bar joints=\"b c\"/>\n<bar joints=\"a b\"/>"),
                ", line 7: a second bar joins a and b"},
        Hostile{"TwoBarsOnOnePairReversed",
                in_structure(joints_ab + "<bar joints=\"a b\"/>\n<bar joints=\"b a\"/>"),
                ", line 5: a second bar joins b and a"},
        Hostile{"TwoTethersOnOnePair",
                in_structure(joints_ab + "<tether joints=\"a b\" length=\"1\"/>\n"
                                         "<tether joints=\"b a\" length=\"2\"/>"),
                ", line 5: a second tether joins b and a"},
        Hostile{"TwoJointsOfOneId", in_structure(joints_ab + joint_a),
                ", line 4: <joint> has id=\"a\", which another joint has already"},
        Hostile{"JointsAtOnePlace",
                in_structure(joint_a + "<joint id=\"b\" x=\"0\" y=\"0\" z=\"-0\"/>\n"
                                       "<bar joints=\"a b\"/>"),
                ", line 4: the bar that joins a and b states no length, and its joints are at one "
                "place"},
        Hostile{
            "JointsTooFarApart",
            in_structure("<joint id=\"a\" x=\"-1e308\" y=\"0\" z=\"0\"/>\n"
                         "<joint id=\"b\" x=\"1e308\" y=\"0\" z=\"0\"/>\n<bar joints=\"a b\"/>"),
            ", line 4: the bar that joins a and b states no length, and its joints are too far "
            "apart"},
        Hostile{"WrongClass",
                in_structure(joints_ab + "<bar joints=\"a b\"/>", "\nclass=\"1-cycle\""),
                ", line 2: the class is said to be 1-cycle, but the bars make it tree"},
        Hostile{"UnknownClass", in_structure(joint_a, " class=\"forest\""),
                ", line 1: the class \"forest\" is none of tree, 1-cycle, 2-cycle, n-cycle, grid, "
                "cloth, thread, ring-chain, regular and protein"}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    Attributes, StructureRefusal,
    testing::Values(
        Hostile{"MissingCoordinate", joint_with("id=\"a\" x=\"0\" z=\"0\""),
                ", line 2: <joint> has no y"},
        Hostile{"MissingId", joint_with("x=\"0\" y=\"0\" z=\"0\""), ", line 2: <joint> has no id"},
        Hostile{"MissingJoints", in_structure(joints_ab + "<bar length=\"1\"/>"),
                ", line 4: <bar> has no joints"},
        Hostile{"MissingLengthOfTether", in_structure(joints_ab + "<tether joints=\"a b\"/>"),
                ", line 4: <tether> has no length"},
        Hostile{"MissingVersion", "\n<structure>" + joint_a + "</structure>",
                ", line 2: <structure> has no version"},
        Hostile{"WrongVersion", "<structure version=\"2\">" + joint_a + "</structure>",
                ", line 1: <structure> has version=\"2\", but only version 1 is known"},
        Hostile{"EmptyLengthUnit", "<structure version=\"1\" length-unit=\"\"/>",
                ", line 1: <structure> has length-unit=\"\", which is empty"},
        Hostile{"CoordinateNan", joint_with("id=\"a\" x=\"nan\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"nan\", which is not a finite number"},
        Hostile{"CoordinateInf", joint_with("id=\"a\" x=\"0\" y=\"-inf\" z=\"0\""),
                ", line 2: <joint> has y=\"-inf\", which is not a finite number"},
        Hostile{"CoordinateInfinity", joint_with("id=\"a\" x=\"0\" y=\"Infinity\" z=\"0\""),
                ", line 2: <joint> has y=\"Infinity\", which is not a finite number"},
        Hostile{"CoordinateOverflow", joint_with("id=\"a\" x=\"0\" y=\"0\" z=\"1e999\""),
                ", line 2: <joint> has z=\"1e999\", which is not a finite number"},
        Hostile{"CoordinateTrailing", joint_with("id=\"a\" x=\"1.0x\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"1.0x\", which is not a finite number"},
        Hostile{"CoordinateTwoNumbers", joint_with("id=\"a\" x=\"1 2\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"1 2\", which is not a finite number"},
        Hostile{"CoordinateComma", joint_with("id=\"a\" x=\"1,5\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"1,5\", which is not a finite number"},
        Hostile{"CoordinateHex", joint_with("id=\"a\" x=\"0x10\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"0x10\", which is not a finite number"},
        Hostile{"CoordinateEmpty", joint_with("id=\"a\" x=\"\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"\", which is not a finite number"},
        Hostile{"CoordinateTwoSigns", joint_with("id=\"a\" x=\"+-1\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has x=\"+-1\", which is not a finite number"},
        Hostile{"LengthZero", in_structure(joints_ab + "<bar joints=\"a b\" length=\"0\"/>"),
                ", line 4: <bar> has length=\"0\", which is not positive"},
        Hostile{"LengthNegative", in_structure(joints_ab + "<bar joints=\"a b\"\nlength=\"-1\"/>"),
                ", line 5: <bar> has length=\"-1\", which is not positive"},
        Hostile{"LengthNan", in_structure(joints_ab + "<contact joints=\"a b\" length=\"NaN\"/>"),
                ", line 4: <contact> has length=\"NaN\", which is not a finite number"},
        Hostile{"LengthEmpty", in_structure(joints_ab + "<bar joints=\"a b\" length=\"\"/>"),
                ", line 4: <bar> has length=\"\", which is not a finite number"},
        Hostile{"MassNegative", joint_with("id=\"a\" x=\"0\" y=\"0\" z=\"0\" mass=\"-0.5\""),
                ", line 2: <joint> has mass=\"-0.5\", which is negative"},
        Hostile{"MassNoNumber", joint_with("id=\"a\" x=\"0\" y=\"0\" z=\"0\" mass=\"heavy\""),
                ", line 2: <joint> has mass=\"heavy\", which is not a finite number"},
        Hostile{"FixedYes", joint_with("id=\"a\" x=\"0\" y=\"0\" z=\"0\" fixed=\"yes\""),
                ", line 2: <joint> has fixed=\"yes\", which is neither true nor false"},
        Hostile{"IdEmpty", joint_with("id=\"\" x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has id=\"\", which is empty"},
        Hostile{"IdWithSpace", joint_with("id=\"a b\" x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has id=\"a b\", which has a space in it"},
        Hostile{"IdWithHiddenSpace", joint_with("id=\"a&#32;\" x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has id=\"a \", which has a space in it"},
        Hostile{"OneJointOfBar", in_structure(joint_a + "<bar joints=\"a\"/>"),
                ", line 3: <bar> has joints=\"a\", which is not two ids with a space between them"},
        Hostile{"ThreeJointsOfBar", in_structure(joints_abc + "<bar joints=\"a b c\"/>"),
                ", line 5: <bar> has joints=\"a b c\", which is not two ids with a space between "
                "them"},
        Hostile{"NoJointsOfBar", in_structure(joints_abc + "<bar joints=\" \"/>"),
                ", line 5: <bar> has joints=\" \", which is not two ids with a space between them"},
        Hostile{"AttributeTwice", joint_with("id=\"a\" x=\"0\"\nx=\"1\" y=\"0\" z=\"0\""),
                ", line 3: <joint> has x twice"},
        Hostile{"UnknownAttributeTwice",
                joint_with("u=\"\" id=\"a\" x=\"0\" u=\"\" y=\"0\" z=\"0\""),
                ", line 2: <joint> has u twice"}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    Xml, StructureRefusal,
    testing::Values(
        Hostile{"EmptyFile", "", " is empty"},
        Hostile{"NoRoot", "<!-- nothing -->\n", ", line 1: there is no <structure> in it"},
        Hostile{"OtherRoot", "\n\n<forces version=\"1\"/>",
                ", line 3: the file holds <forces> instead of <structure>"},
        Hostile{"NoXmlAtAll", "ATOM      1  N   GLY A   1\n",
                ", line 1: the text \"ATOM      1  N   GLY A   1\" stands where only elements may "
                "be"},
        Hostile{"UnknownElement", in_structure(joint_a + "<spring joints=\"a b\"/>"),
                ", line 3: <spring> is unknown in <structure>; it may hold joint, bar, tether and "
                "contact"},
        Hostile{"ElementInJoint",
                in_structure("<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\">\n<bar/></joint>"),
                ", line 3: <bar> stands within <joint>, which is to be empty"},
        Hostile{"TextContent", in_structure(joint_a + "hello\n" + joint_a),
                ", line 3: the text \"hello\" stands where only elements may be"},
        Hostile{"TextInJoint", in_structure("<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\">1</joint>"),
                ", line 2: the text \"1\" stands where only elements may be"},
        Hostile{"CdataSection", in_structure(joint_a + "<![CDATA[<bar/>]]>"),
                ", line 3: text in a CDATA section has no place in this file"},
        Hostile{"BillionLaughs", laughs,
                ", line 2: a DOCTYPE, with which entities are declared, is not accepted"},
        Hostile{"ExternalEntity",
                "<!DOCTYPE s SYSTEM \"file:///etc/passwd\">\n" + in_structure(joint_a),
                ", line 1: a DOCTYPE, with which entities are declared, is not accepted"},
        Hostile{"EntityDeclarationAlone", in_structure("<!ENTITY lol \"lol\">"),
                ", line 2: \"<!ENTITY\" is not accepted"},
        Hostile{"UnknownEntity", joint_with("id=\"&lol;\" x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: \"&lol;\" stands for no character; write &amp; for an &"},
        Hostile{"BareAmpersand", joint_with("id=\"a&b\"\nx=\"0\" y=\"0\" z=\"0\""),
                ", line 2: \"&\" stands for no character; write &amp; for an &"},
        Hostile{"ReferenceToNothing", joint_with("id=\"&#0;\" x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: \"&#0;\" stands for no character; write &amp; for an &"},
        Hostile{"SecondRoot", in_structure(joint_a) + in_structure(joint_a),
                ", line 5: a second root element, <structure>"},
        Hostile{"TextAfterRoot", in_structure(joint_a) + "bye",
                ", line 5: the text \"bye\" stands where only elements may be"},
        Hostile{"SuperfluousEnd", in_structure(joint_a) + "</structure>",
                ", line 5: </structure> ends what never began"},
        Hostile{"WrongEnd", "<structure version=\"1\">\n" + joint_a + "</forces>",
                ", line 3: </forces> stands where </structure> should"},
        Hostile{"TruncatedBetweenTags", "<structure version=\"1\">\n" + joint_a,
                ", line 2: the file ends before </structure>"},
        Hostile{"TruncatedInTag", "<structure version=\"1\">\n" + joint_a + "<joint id=\"b\" x=\"",
                ", line 3: the file ends within the tag that begins here"},
        Hostile{"TruncatedInJoint",
                "<structure version=\"1\">\n<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\">\n",
                ", line 2: the file ends before </joint>"},
        Hostile{"TruncatedAfterBracket", "<structure version=\"1\">\n<",
                ", line 2: the file ends within the tag that begins here"},
        Hostile{"CommentWithoutEnd", "<structure version=\"1\">\n<!-- never",
                ", line 2: the comment that begins here has no end"},
        Hostile{"CommentOfThreeDashes", "<structure version=\"1\">\n<!-->",
                ", line 2: the comment that begins here has no end"},
        Hostile{"DashesInComment", in_structure("<!-- a -- b -->"),
                ", line 2: the comment that begins here has a -- within it"},
        Hostile{"DashesWithoutEnd", "<structure version=\"1\">\n<!-- a --",
                ", line 2: the comment that begins here has no end"},
        Hostile{"InstructionWithoutEnd", "<structure version=\"1\">\n<?xml",
                ", line 2: the instruction that begins here has no end"},
        Hostile{"DeclarationWithin", in_structure("<?xml version=\"1.0\"?>"),
                ", line 2: an XML declaration stands only at the beginning"},
        Hostile{"BrokenDeclaration", "<?xml?>" + in_structure(joint_a),
                ", line 1: the XML declaration is not well formed"},
        Hostile{"QuoteWithoutEnd", in_structure("<joint id=\"a x=\"0\" y=\"0\" z=\"0\"/>"),
                ", line 2: the tag that begins here has a \"<\" within it"},
        Hostile{"AttributeWithoutQuotes", joint_with("\nid=a x=\"0\" y=\"0\" z=\"0\""),
                ", line 3: the tag is not well-formed XML"},
        Hostile{"AttributesWithoutSpace", joint_with("id=\"a\"x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: the tag is not well-formed XML"},
        Hostile{"TagWithoutName", in_structure("<>"), ", line 2: the tag is not well-formed XML"},
        Hostile{"SpaceBeforeName", in_structure("< joint/>"),
                ", line 2: the tag is not well-formed XML"},
        Hostile{"InvalidUtf8", in_structure("\n<joint id=\"\xc3\x28\" x=\"0\" y=\"0\" z=\"0\"/>"),
                ", line 3: the byte 0xc3 is not UTF-8"},
        Hostile{"Latin1", in_structure("<!-- caf\xe9 -->"), ", line 2: the byte 0xe9 is not UTF-8"},
        Hostile{"OverlongUtf8", in_structure("<!-- \xc0\xaf -->"),
                ", line 2: the byte 0xc0 is not UTF-8"},
        Hostile{"Surrogate", in_structure("<!-- \xed\xa0\x80 -->"),
                ", line 2: the byte 0xed is not UTF-8"},
        Hostile{"Utf16", std::string("\xff\xfe<\0s\0", 6), ", line 1: the byte 0xff is not UTF-8"},
        Hostile{"OtherEncoding",
                "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n" + in_structure(joint_a),
                ", line 1: the encoding \"ISO-8859-1\" is not UTF-8"},
        Hostile{"BinaryNoise", std::string("\x1f\x8b\x08\0\0\0", 6),
                ", line 1: the byte 0x1f has no place in XML"},
        Hostile{"Png", "\x89PNG\r\n", ", line 1: the byte 0x89 is not UTF-8"},
        Hostile{"NulByte", in_structure(joint_a + std::string("\n\0", 2)),
                ", line 4: the byte 0x00 has no place in XML"},
        Hostile{"GiantTag", in_structure("<joint id=\"" + std::string(2 << 20, 'x') + "\"/>"),
                ", line 2: the tag that begins here is longer than a mebibyte"}),
    name_of);

TEST(HostileFiles, DeepNestingEndsAtItsFirstWrongElement) {
  std::string deep = "<structure version=\"1\">\n";
  for (int k = 0; k < 200000; ++k) deep += "<joint id=\"a\" x=\"0\" y=\"0\" z=\"0\">\n";
  const Folder folder;
  const std::string path = folder.write("s.xml", deep);
  EXPECT_EQ(error_of([&] { read_structure(path); }),
            path + ", line 3: <joint> stands within <joint>, which is to be empty");
}

TEST(HostileFiles, LongQuotationsAreCutBetweenCharacters) {
  std::string id;
  for (int k = 0; k < 100; ++k) id += "\xc3\xa9 ";
  const Folder folder;
  const std::string path = folder.write("s.xml", joint_with("id=\"" + id + "\""));
  const std::string error = error_of([&] { read_structure(path); });
  EXPECT_LT(error.size(), path.size() + 120);
  EXPECT_NE(error.find("...\""), std::string::npos);
}

TEST(HostileFiles, WhatIsNoFileIsRefused) {
  const Folder folder;
  const std::string missing = folder / "none.xml", directory = folder / "";
  EXPECT_EQ(error_of([&] { read_structure(missing); }),
            missing + " cannot be read: No such file or directory");
  EXPECT_EQ(error_of([&] { read_structure(directory); }), directory + " is a folder, not a file");
  EXPECT_EQ(error_of([&] { read_structure("/dev/zero"); }),
            "/dev/zero is neither a file nor a pipe");
}

TEST(HostileFiles, ManyJointsOnOneLineAreReadAndKeepTheirLine) {
  std::string line;
  for (int k = 0; k < 100000; ++k)
    line +=
        "<joint id=\"" + std::to_string(k) + "\" x=\"" + std::to_string(k) + "\" y=\"0\" z=\"0\"/>";
  const Folder folder;
  EXPECT_EQ(read_structure(folder.write("s.xml", in_structure(line))).ids.size(), 100000U);
  const std::string path = folder.write("t.xml", in_structure(line + "<bar joints=\"7 7\"/>"));
  EXPECT_EQ(error_of([&] { read_structure(path); }), path + ", line 2: the bar joins 7 to itself");
}

// === Forces

class ForceRefusal : public testing::TestWithParam<Hostile> {};

TEST_P(ForceRefusal, NamesTheLineAndTheReason) {
  expect_refusal(GetParam(), [](const std::string& path) { read_forces(path, square()); });
}

std::string forces_with(const std::string& attributes) {
  return "<forces version=\"1\" " + attributes + "/>";
}

std::string force_with(const std::string& attributes) {
  return "<forces version=\"1\">\n<force " + attributes + "/>\n</forces>";
}

INSTANTIATE_TEST_SUITE_P(
    Files, ForceRefusal,
    testing::Values(
        Hostile{"UnknownJoint", force_with("joint=\"e\" x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: the force acts on the joint e, which the structure does not have"},
        Hostile{"MissingJoint", force_with("x=\"0\" y=\"0\" z=\"0\""),
                ", line 2: <force> has no joint"},
        Hostile{"MissingComponent", force_with("joint=\"a\" x=\"0\" y=\"0\""),
                ", line 2: <force> has no z"},
        Hostile{"ForceNan", force_with("joint=\"a\" x=\"0\" y=\"nan\" z=\"0\""),
                ", line 2: <force> has y=\"nan\", which is not a finite number"},
        Hostile{"ToleranceZero", forces_with("tolerance=\"0\""),
                ", line 1: <forces> has tolerance=\"0\", which is not positive"},
        Hostile{"ToleranceInfinite", forces_with("tolerance=\"inf\""),
                ", line 1: <forces> has tolerance=\"inf\", which is not a finite number"},
        Hostile{"TimestepNegative", forces_with("timestep=\"-1\""),
                ", line 1: <forces> has timestep=\"-1\", which is not positive"},
        Hostile{"IterationsZero", forces_with("max-iterations=\"0\""),
                ", line 1: <forces> has max-iterations=\"0\", which is not positive"},
        Hostile{
            "IterationsNegative", forces_with("max-iterations=\"-5\""),
            ", line 1: <forces> has max-iterations=\"-5\", which is not a whole number from 0 up"},
        Hostile{
            "IterationsBroken", forces_with("max-iterations=\"10.5\""),
            ", line 1: <forces> has max-iterations=\"10.5\", which is not a whole number from 0 "
            "up"},
        Hostile{
            "IterationsTooMany", forces_with("max-iterations=\"10000000000000000000\""),
            ", line 1: <forces> has max-iterations=\"10000000000000000000\", which is too large"},
        Hostile{"UnknownElement", "<forces version=\"1\"><push/></forces>",
                ", line 1: <push> is unknown in <forces>; it may hold force"},
        Hostile{"WrongVersion", "<forces version=\"0\"/>",
                ", line 1: <forces> has version=\"0\", but only version 1 is known"},
        Hostile{"AStructure", square_text(),
                ", line 1: the file holds <structure> instead of <forces>"}),
    name_of);

// === Orders

class OrderRefusal : public testing::TestWithParam<Hostile> {};

TEST_P(OrderRefusal, NamesTheLineAndTheReason) {
  expect_refusal(GetParam(), [](const std::string& path) { read_order(path, square()); });
}

std::string order_with(const std::string& attributes) {
  return "<order version=\"1\">\n<bar " + attributes + "/></order>";
}

INSTANTIATE_TEST_SUITE_P(
    Files, OrderRefusal,
    testing::Values(
        Hostile{"NoSuchBar", order_with("joints=\"a c\""),
                ", line 2: the structure has no bar that joins a and c"},
        Hostile{"BarToItself", order_with("joints=\"a a\""),
                ", line 2: the structure has no bar that joins a and a"},
        Hostile{"UnknownJoint", order_with("joints=\"a e\""),
                ", line 2: the order names the joint e, which the structure does not have"},
        Hostile{"UnknownRoot", "<order version=\"1\" root=\"e\"/>",
                ", line 1: the order names the joint e, which the structure does not have"},
        Hostile{"ProblemMaybe", order_with("joints=\"a b\" problem=\"maybe\""),
                ", line 2: <bar> has problem=\"maybe\", which is neither true nor false"},
        Hostile{"MissingJoints", order_with(""), ", line 2: <bar> has no joints"},
        Hostile{"UnknownElement", "<order version=\"1\"><joint/></order>",
                ", line 1: <joint> is unknown in <order>; it may hold bar"},
        Hostile{"MissingVersion", "<order/>", ", line 1: <order> has no version"}),
    name_of);

// === Results

class ResultsRefusal : public testing::TestWithParam<Hostile> {};

TEST_P(ResultsRefusal, NamesTheLineAndTheReason) {
  expect_refusal(GetParam(), [](const std::string& path) { read_results(path); });
}

std::string results_with(const std::string& lines) {
  return "<results version=\"1\" seed=\"1\">\n" + lines + "\n</results>";
}

INSTANTIATE_TEST_SUITE_P(
    Files, ResultsRefusal,
    testing::Values(
        Hostile{"MissingSeed", "<results version=\"1\"/>", ", line 1: <results> has no seed"},
        Hostile{"SeedNegative", "<results version=\"1\" seed=\"-1\"/>",
                ", line 1: <results> has seed=\"-1\", which is not a whole number from 0 up"},
        Hostile{"AbsolutePath", results_with("<structure class=\"tree\" path=\"/etc/passwd\"/>"),
                ", line 2: <structure> has path=\"/etc/passwd\", which is not a relative path"},
        Hostile{"PathOutOfTheSet", results_with("<structure class=\"tree\" path=\"a/../../b\"/>"),
                ", line 2: <structure> has path=\"a/../../b\", which leads out of the set"},
        Hostile{"EmptyPath", results_with("<structure class=\"tree\" path=\"\"/>"),
                ", line 2: <structure> has path=\"\", which is empty"},
        Hostile{"OneStructureTwice",
                results_with("<structure class=\"tree\" path=\"s\"/>\n"
                             "<structure class=\"tree\" path=\"s\"/>"),
                ", line 3: <structure> has path=\"s\", which is in the set already"},
        Hostile{"TwoOrders",
                results_with("<structure class=\"tree\" path=\"s\">\n<order path=\"o\"/>\n"
                             "<order path=\"p\"/></structure>"),
                ", line 4: a second <order> of one structure"},
        Hostile{"MissingFolder",
                results_with("<structure class=\"tree\" path=\"s\">\n<technique/></structure>"),
                ", line 3: <technique> has no folder"},
        Hostile{"UnknownElement",
                results_with("<structure class=\"tree\" path=\"s\">\n<frames/></structure>"),
                ", line 3: <frames> is unknown in <structure>; it may hold order, forces and "
                "technique"}),
    name_of);

}  // namespace
}  // namespace ragdoll
