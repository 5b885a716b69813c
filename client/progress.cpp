#include "client/progress.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

#include "client/human.h"

namespace shutterline::client {
namespace {

constexpr int kBarCells = 28;
constexpr absl::Duration kRedrawEvery = absl::Milliseconds(100);
constexpr absl::Duration kLineEvery = absl::Seconds(1);

double Fraction(const ProgressFacts& facts) {
  if (facts.total <= 0) return 0;
  return std::clamp(double(facts.done) / double(facts.total), 0.0, 1.0);
}

bool Complete(const ProgressFacts& facts) {
  return facts.total > 0 && facts.done >= facts.total;
}

/// Floor, so that 100 % is said only when everything is done.
int Percent(const ProgressFacts& facts) {
  return Complete(facts) ? 100 : std::min(99, int(Fraction(facts) * 100));
}

std::string Counts(const ProgressFacts& facts) {
  std::string text = absl::StrCat(facts.done, "/", facts.total, " ", facts.unit);
  if (facts.frames_total > 1) {
    absl::StrAppend(&text, ", ", facts.frames_done, "/", facts.frames_total, " frames");
  }
  return text;
}

}  // namespace

Progress::Progress(ProgressStyle style, std::ostream& out, const Clock& clock)
    : style_(style), out_(out), clock_(clock), start_(clock.Monotonic()) {}

Progress::~Progress() {
  if (bar_drawn_) out_ << "\n" << std::flush;
}

std::string Progress::BarText(const ProgressFacts& facts, absl::Duration elapsed) const {
  const int full = int(Fraction(facts) * kBarCells);
  std::string text =
      absl::StrCat("[", std::string(size_t(full), '#'), std::string(size_t(kBarCells - full), '.'), "] ");
  absl::StrAppendFormat(&text, "%3d%% ", Percent(facts));
  absl::StrAppend(&text, facts.state, " ", Counts(facts), " ", ShortDuration(elapsed));
  // Until a twentieth is done, a guess of what remains would jump about.
  if (!Complete(facts) && Fraction(facts) >= 0.05) {
    absl::StrAppend(&text, ", ", ShortDuration(elapsed * (1 / Fraction(facts) - 1)), " left");
  }
  if (!facts.note.empty()) absl::StrAppend(&text, " (", facts.note, ")");
  return text;
}

std::string Progress::LineText(const ProgressFacts& facts, absl::Duration elapsed) const {
  std::string text =
      absl::StrCat(facts.state, ": ", Percent(facts), "% ", Counts(facts), " after ", ShortDuration(elapsed));
  if (!facts.note.empty()) absl::StrAppend(&text, " (", facts.note, ")");
  return text;
}

void Progress::Update(const ProgressFacts& facts) {
  facts_ = facts;
  has_facts_ = true;
  if (style_ == ProgressStyle::kQuiet) return;
  const absl::Duration now = clock_.Monotonic();
  if (style_ == ProgressStyle::kBar) {
    if (bar_drawn_ && now - last_draw_ < kRedrawEvery && !Complete(facts)) return;
    Draw();
    return;
  }
  const int64_t tenth = Percent(facts) / 10;
  const std::string words = absl::StrCat(facts.state, "\n", facts.note);
  const bool news = words != last_words_;
  const bool step = tenth != last_tenth_ && (now - last_draw_ >= kLineEvery || Complete(facts));
  if (!news && !step) return;
  last_tenth_ = tenth;
  last_words_ = words;
  Draw();
}

void Progress::Draw() {
  const absl::Duration now = clock_.Monotonic();
  last_draw_ = now;
  if (style_ == ProgressStyle::kBar) {
    Erase();
    // Row by row, each over the one that is there: nothing flickers.
    for (const std::string& row : picture_) out_ << row << "\x1b[K\n";
    picture_rows_drawn_ = picture_.size();
    // A bar that wrapped would take a row more than we go up again.
    out_ << "\x1b[?7l" << BarText(facts_, now - start_) << "\x1b[?7h\x1b[K" << std::flush;
    bar_drawn_ = true;
  } else if (style_ == ProgressStyle::kLines) {
    out_ << LineText(facts_, now - start_) << "\n" << std::flush;
  }
}

void Progress::Erase() {
  if (bar_drawn_) out_ << "\r";
  if (bar_drawn_ && picture_rows_drawn_ > 0) out_ << "\x1b[" << picture_rows_drawn_ << "A";
  bar_drawn_ = false;
}

void Progress::SetPicture(std::vector<std::string> rows) {
  if (style_ != ProgressStyle::kBar || !has_facts_) return;
  picture_ = std::move(rows);
  Draw();
}

void Progress::Note(absl::string_view text) {
  if (style_ == ProgressStyle::kQuiet) return;
  const bool redraw = bar_drawn_;
  Erase();
  // What the text does not cover goes.
  out_ << text << (redraw ? "\x1b[J" : "") << "\n" << std::flush;
  if (redraw) Draw();
}

void Progress::Finish() {
  if (style_ != ProgressStyle::kBar || !has_facts_) return;
  Draw();
  out_ << "\n" << std::flush;
  bar_drawn_ = false;
}

}  // namespace shutterline::client
