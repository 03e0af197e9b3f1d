#include "ragdoll/chemistry/molecule_reader.h"

#include <GraphMol/FileParsers/FileParsers.h>
#include <gtest/gtest.h>

#include "ragdoll/error.h"
#include "samples.h"

namespace ragdoll {
namespace {

std::vector<MoleculeRecord> all_of(const std::string& path) {
  MoleculeReader reader(path);
  std::vector<MoleculeRecord> records;
  while (auto record = reader.next()) records.push_back(*record);
  return records;
}

const char* const ethane_mol2 =
    "@<TRIPOS>MOLECULE\nethane\n 2 1 0 0 0\nSMALL\nNO_CHARGES\n\n@<TRIPOS>ATOM\n"
    "1 C1 0.0 0.0 0.0 C.3 1 LIG 0.0\n2 C2 1.5 0.0 0.1 C.3 1 LIG 0.0\n@<TRIPOS>BOND\n1 1 2 1\n";

TEST(MoleculeReader, ReadsSmilesWithTitlesAndSkipsWhatIsNone) {
  const Folder folder;
  const auto records = all_of(folder.file(
      "a.smi", "SMILES name\n# comment\n\nCCO ethanol, dry\r\nC[C@H](N)O |&1:1|  ax\nc1ccccc1\n"));
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records[0].title, "ethanol, dry");
  EXPECT_EQ(records[0].line, 4);
  EXPECT_EQ(records[1].title, "ax");
  EXPECT_EQ(records[2].title, "line 6");
  EXPECT_EQ(records[2].number, 2);
  for (const MoleculeRecord& record : records) EXPECT_TRUE(record.mol) << record.fault;
}

TEST(MoleculeReader, SaysWhyARecordIsNoMolecule) {
  const Folder folder;
  const auto records = all_of(folder.file(
      "a.smi", "C(C)(C)(C)(C)C five\nC[Fe open\nc1cccc1 ring\n\xff\xfe odd\nCC fine\n"));
  ASSERT_EQ(records.size(), 5U);
  EXPECT_NE(records[0].fault.find("alence"), std::string::npos) << records[0].fault;
  for (int k = 0; k < 4; ++k) {
    EXPECT_FALSE(records[std::size_t(k)].mol);
    EXPECT_GT(records[std::size_t(k)].fault.size(), 5U);
    EXPECT_EQ(records[std::size_t(k)].fault.find('\n'), std::string::npos);
  }
  EXPECT_TRUE(records[4].mol);
}

TEST(MoleculeReader, KeepsHydrogensAndDataOfSdRecords) {
  const Folder folder;
  const auto mol = embedded("CCO");
  mol->setProp("_Name", std::string("ethanol"));
  const std::string block = RDKit::MolToMolBlock(*mol);
  const auto records = all_of(folder.file(
      "a.sdf", block + "> <id>\n42\n\n$$$$\nbroken\n\n\nnonsense\n$$$$\n$$$$\n" + block));
  ASSERT_EQ(records.size(), 4U);
  ASSERT_TRUE(records[0].mol);
  EXPECT_EQ(records[0].title, "ethanol");
  EXPECT_EQ(records[0].mol->getNumAtoms(), mol->getNumAtoms());
  EXPECT_EQ(records[0].mol->getProp<std::string>("id"), "42");
  EXPECT_FALSE(records[1].mol);
  EXPECT_EQ(records[2].fault, "the record is empty");
  ASSERT_TRUE(records[3].mol) << records[3].fault;
  EXPECT_TRUE(has_places(*records[3].mol));
}

TEST(MoleculeReader, ReadsMol2) {
  const Folder folder;
  const auto records =
      all_of(folder.file("a.mol2", std::string("# comment\n") + ethane_mol2 + ethane_mol2));
  ASSERT_EQ(records.size(), 2U);
  ASSERT_TRUE(records[1].mol) << records[1].fault;
  EXPECT_EQ(records[0].title, "ethane");
  EXPECT_EQ(records[1].mol->getNumAtoms(), 2U);
}

TEST(MoleculeReader, RefusesWhatIsNoFileOfMolecules) {
  const Folder folder;
  EXPECT_THROW(MoleculeReader(folder.file("a.pdb", "")), Error);
  EXPECT_THROW(MoleculeReader("/nowhere/a.sdf"), Error);
  EXPECT_TRUE(all_of(folder.file("a.smi", "")).empty());
}

}  // namespace
}  // namespace ragdoll
