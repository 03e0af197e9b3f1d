// Tests for core/src/weighting.cpp.

#include "ragdoll/weighting.h"

#include <gtest/gtest.h>

#include "examples.h"

namespace ragdoll {
namespace {

using examples::refusal_of;

TEST(Weighting, TextNamesTheFarShareFirstAsTheThesisDoes) {
  EXPECT_EQ(weighting_of(".5/.5").near, 0.5);
  EXPECT_EQ(weighting_of(".5/.5").far, 0.5);
  EXPECT_EQ(weighting_of(".75/.25").near, 0.25);
  EXPECT_EQ(weighting_of(".75/.25").far, 0.75);
  EXPECT_EQ(weighting_of("1/0").near, 0);
  EXPECT_EQ(weighting_of("1/0").far, 1);
  EXPECT_EQ(weighting_of("0/1").near, 1);
}

TEST(Weighting, EveryPairThatAddsToOneIsRead) {
  EXPECT_EQ(weighting_of("0.75/0.25").far, 0.75);
  EXPECT_EQ(weighting_of("0.6/0.4").near, 0.4);
  EXPECT_EQ(weighting_of(".9/.1").far, 0.9);
}

TEST(Weighting, DefaultIsEven) {
  EXPECT_EQ(Weighting{}.near, 0.5);
  EXPECT_EQ(Weighting{}.far, 0.5);
}

TEST(Weighting, NameIsTheTextThatIsReadBack) {
  for (const char* text : {".5/.5", ".75/.25", "1/0", "0/1", ".9/.1", ".125/.875"})
    EXPECT_EQ(name_of(weighting_of(text)), text);
  const Weighting thirds = {1.0 / 3, 1 - 1.0 / 3};
  EXPECT_EQ(weighting_of(name_of(thirds)).near, thirds.near);
  EXPECT_EQ(weighting_of(name_of(thirds)).far, thirds.far);
}

TEST(Weighting, WhatIsNoPairOfSharesIsRefused) {
  for (const char* text : {"",       "/",      "1",     ".5",       ".5/",   "/.5",      ".5/.6",
                           "1/1",    "0/0",    "2/-1",  "-.5/1.5",  "a/b",   ".5/.5/.0", " .5/.5",
                           ".5/.5 ", ".5 /.5", "nan/1", "inf/-inf", ".5,.5", "1/0x0"}) {
    const std::string refusal = refusal_of([&] { weighting_of(text); });
    EXPECT_NE(refusal.find(std::string("'").append(text) + "'"), std::string::npos) << text;
    EXPECT_NE(refusal.find(".75/.25"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace ragdoll
