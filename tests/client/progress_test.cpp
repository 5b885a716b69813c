#include "client/progress.h"

#include <absl/strings/str_split.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace shutterline::client::progress_test {
namespace {

class HandClock : public Clock {
 public:
  absl::Duration Monotonic() const override { return now; }
  absl::Time Wall() const override { return absl::UnixEpoch() + now; }
  absl::Duration now;
};

ProgressFacts Facts(int64_t done, int64_t total) {
  ProgressFacts facts;
  facts.state = "running";
  facts.done = done;
  facts.total = total;
  facts.frames_total = 1;
  return facts;
}

TEST(Progress, LinesAreFewAndEndAtHundredPercent) {
  HandClock clock;
  std::ostringstream out;
  Progress progress(ProgressStyle::kLines, out, clock);
  for (int i = 0; i <= 10000; ++i) {
    clock.now += absl::Milliseconds(2);
    progress.Update(Facts(i, 10000));
  }
  progress.Finish();
  const std::string text = out.str();
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GE(lines, 10);
  EXPECT_LE(lines, 12);
  EXPECT_NE(text.find("running: 100% 10000/10000 tiles after 20s"), std::string::npos) << text;
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_EQ(text.find('\x1b'), std::string::npos) << "no terminal codes in a log";
}

TEST(Progress, APictureStandsAboveTheBarAndIsDrawnOverItself) {
  HandClock clock;
  std::ostringstream out;
  Progress progress(ProgressStyle::kBar, out, clock);
  progress.SetPicture({"too early"});
  progress.Update(Facts(1, 2));
  progress.SetPicture({"aa", "bb"});
  const size_t before = out.str().size();
  progress.SetPicture({"cc", "dd"});
  const std::string second = out.str().substr(before);
  EXPECT_EQ(second.substr(0, 5), "\r\x1b[2A") << "up over two rows";
  EXPECT_NE(second.find("cc\x1b[K\ndd\x1b[K\n"), std::string::npos) << second;
  EXPECT_EQ(out.str().find("too early"), std::string::npos) << "there was no bar yet";
  std::ostringstream lines;
  Progress plain(ProgressStyle::kLines, lines, clock);
  plain.Update(Facts(1, 2));
  plain.SetPicture({"cc"});
  EXPECT_EQ(lines.str().find("cc"), std::string::npos);
}

TEST(Progress, LinesTellAChangeOfStateAtOnce) {
  HandClock clock;
  std::ostringstream out;
  Progress progress(ProgressStyle::kLines, out, clock);
  ProgressFacts facts = Facts(0, 10);
  facts.state = "queued";
  facts.note = "no worker is connected";
  progress.Update(facts);
  progress.Update(facts);
  facts.note = "";
  progress.Update(facts);
  EXPECT_EQ(out.str(),
            "queued: 0% 0/10 tiles after 0s (no worker is connected)\nqueued: 0% 0/10 tiles after 0s\n");
}

TEST(Progress, BarIsOneLineAndRedrawnSparingly) {
  HandClock clock;
  std::ostringstream out;
  {
    Progress progress(ProgressStyle::kBar, out, clock);
    for (int i = 0; i <= 1000; ++i) {
      clock.now += absl::Milliseconds(1);
      progress.Update(Facts(i, 1000));
    }
    progress.Note("a word");
  }
  const std::string text = out.str();
  EXPECT_LE(std::count(text.begin(), text.end(), '\r'), 14);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << "the note's line and the last";
  EXPECT_NE(text.find("\ra word\x1b[J\n\x1b[?7l["), std::string::npos) << text;
  EXPECT_EQ(text.substr(text.size() - 1), "\n");
}

TEST(Progress, HundredPercentMeansEverything) {
  HandClock clock;
  std::ostringstream out;
  Progress progress(ProgressStyle::kLines, out, clock);
  progress.Update(Facts(999'999, 1'000'000));
  EXPECT_NE(out.str().find(" 99% "), std::string::npos) << out.str();
}

TEST(Progress, QuietSaysNothing) {
  std::ostringstream out;
  {
    Progress progress(ProgressStyle::kQuiet, out);
    progress.Update(Facts(1, 2));
    progress.Note("note");
    progress.Finish();
  }
  EXPECT_EQ(out.str(), "");
}

TEST(Progress, SurvivesImpossibleFacts) {
  std::ostringstream out;
  Progress progress(ProgressStyle::kBar, out);
  for (const auto& [done, total] :
       std::vector<std::pair<int64_t, int64_t>>{{5, 0}, {7, 3}, {-1, 4}, {0, 0}}) {
    progress.Update(Facts(done, total));
    progress.Note("n");
  }
  EXPECT_EQ(out.str().find("-1%"), std::string::npos);
}

}  // namespace
}  // namespace shutterline::client::progress_test
