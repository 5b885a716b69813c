#include "worker/supervise/log_tail.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <gtest/gtest.h>

#include <random>

#include "common/base/utf8.h"

namespace shutterline::worker {
namespace {

TEST(LogTail, KeepsTheLastLinesAndCutsLongOnes) {
  LogTail tail;
  for (size_t i = 0; i < 3 * LogTail::kLines; ++i) tail.Add(absl::StrCat("line ", i, "\n"));
  const std::string long_line(10'000, 'x');
  tail.Add(long_line);
  tail.Add("\nend");
  std::string expected;
  for (size_t i = 2 * LogTail::kLines + 2; i < 3 * LogTail::kLines; ++i)
    absl::StrAppend(&expected, "line ", i, "\n");
  EXPECT_EQ(tail.Text(), absl::StrCat(expected, std::string(LogTail::kLineBytes, 'x'), "\nend\n"));
  tail.Clear();
  EXPECT_EQ(tail.Text(), "");
  tail.Add("new\n");
  EXPECT_EQ(tail.Text(), "new\n");
}

TEST(LogTail, HostileBytesInHostilePartsAreBoundedPrintableTextAndPartsDoNotMatter) {
  for (uint32_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::string bytes(random() % 40'000, '\0');
    const unsigned newline_every = 1 + random() % 1000;
    for (char& c : bytes) c = random() % newline_every == 0 ? '\n' : char(random());
    LogTail whole, parts;
    whole.Add(bytes);
    for (absl::string_view rest = bytes; !rest.empty();) {
      const size_t count = std::min<size_t>(rest.size(), 1 + random() % 700);
      parts.Add(rest.substr(0, count));
      rest.remove_prefix(count);
    }
    const std::string text = whole.Text();
    EXPECT_EQ(text, parts.Text());
    EXPECT_LE(text.size(), size_t{16} << 10);
    EXPECT_EQ(text, ValidUtf8(text));
    EXPECT_EQ(text, WithoutControls(text));
  }
}

}  // namespace
}  // namespace shutterline::worker
