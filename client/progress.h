#pragma once

#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "common/base/clock.h"

namespace shutterline::client {

enum class ProgressStyle {
  kBar,    ///< One line that is drawn over and over: for terminals.
  kLines,  ///< A line at each tenth and at most one a second: for logs and pipes.
  kQuiet,  ///< Nothing at all.
};

/// What a job has got done; what `Progress` draws.
struct ProgressFacts {
  std::string state;           ///< "queued", "running", ...
  std::string unit = "tiles";  ///< What is counted.
  int64_t done = 0, total = 0;
  int64_t frames_done = 0, frames_total = 0;
  std::string note;  ///< "no worker is connected", or empty.
};

/// Shows how a job advances: Update* Finish?, with Note at any time. Not thread-safe. What it says is
/// never needed by a program: facts go to standard output, progress to standard error.
class Progress {
 public:
  /// `out` and `clock` must outlive it.
  Progress(ProgressStyle style, std::ostream& out, const Clock& clock = Clock::System());
  /// Leaves the terminal on a fresh line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Update(const ProgressFacts& facts);
  /// Rows of a picture that stand above the bar from now on, in place of those before. Bars alone have one.
  void SetPicture(std::vector<std::string> rows);
  /// A whole line of text above bar and picture.
  void Note(absl::string_view text);
  /// Draws the last facts and leaves the bar standing.
  void Finish();

 private:
  std::string BarText(const ProgressFacts& facts, absl::Duration elapsed) const;
  std::string LineText(const ProgressFacts& facts, absl::Duration elapsed) const;
  void Draw();
  void Erase();

  const ProgressStyle style_;
  std::ostream& out_;
  const Clock& clock_;
  const absl::Duration start_;
  ProgressFacts facts_;
  bool has_facts_ = false;
  bool bar_drawn_ = false;
  std::vector<std::string> picture_;
  size_t picture_rows_drawn_ = 0;
  absl::Duration last_draw_;
  int64_t last_tenth_ = -1;
  std::string last_words_;  ///< State and note of the line printed last.
};

}  // namespace shutterline::client
