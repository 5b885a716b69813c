#include "common/base/utf8.h"

#include <gtest/gtest.h>

namespace shutterline {
namespace {

TEST(Utf8, PrefixesCutNoCharacter) {
  const std::string text = "a\xC3\xA4\xE2\x82\xAC";  // Of 1, 2 and 3 bytes.
  const size_t expected[] = {0, 1, 1, 3, 3, 3, 6, 6};
  for (size_t bytes = 0; bytes < std::size(expected); ++bytes) {
    EXPECT_EQ(Utf8Prefix(text, bytes).size(), expected[bytes]) << bytes;
  }
}

TEST(Utf8, WhatIsNoCharacterIsReplaced) {
  EXPECT_EQ(ValidUtf8(""), "");
  const std::string good = "a\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80";
  EXPECT_EQ(ValidUtf8(good), good);
  EXPECT_EQ(ValidUtf8("a\xC3"), "a?");
  EXPECT_EQ(ValidUtf8("\xC3(x"), "?(x");
  EXPECT_EQ(ValidUtf8("\x80\xFF"), "??");
  EXPECT_EQ(ValidUtf8("\xC0\x80"), "??");            // Overlong.
  EXPECT_EQ(ValidUtf8("\xE0\x80\x80"), "???");       // Overlong.
  EXPECT_EQ(ValidUtf8("\xED\xA0\x80"), "???");       // A surrogate.
  EXPECT_EQ(ValidUtf8("\xF4\x90\x80\x80"), "????");  // Beyond U+10FFFF.
  EXPECT_EQ(ValidUtf8(std::string("a\0b", 3)), std::string("a\0b", 3));
}

TEST(Utf8, WithoutControlsNothingSteersATerminal) {
  EXPECT_EQ(WithoutControls("a\x1b[31mb\n\x7f"), "a?[31mb\n?");
  EXPECT_EQ(WithoutControls("\xc2\x9b"
                            "31m, \xc2\x80, \xc2\x9f"),
            "??31m, ??, ??");
  EXPECT_EQ(WithoutControls("\xc2\xa0\xc3\x82\xe2\x82\xac"), "\xc2\xa0\xc3\x82\xe2\x82\xac")
      << "what is printed stays";
}

}  // namespace
}  // namespace shutterline
