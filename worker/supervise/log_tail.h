#pragma once

#include <absl/strings/string_view.h>

#include <deque>
#include <string>

namespace shutterline::worker {

/// The last lines of a stream of bytes, long ones cut. Not thread-safe.
class LogTail {
 public:
  static constexpr size_t kLines = 32, kLineBytes = 480;

  /// What has come; lines may be cut anywhere between two calls.
  void Add(absl::string_view bytes);
  void Clear();

  /// At most 16 KiB of valid UTF-8, a newline after each line; control characters have become '?'.
  std::string Text() const;

 private:
  std::deque<std::string> lines_;  ///< The last one may have more to come.
  bool open_ = false;              ///< It has.
};

}  // namespace shutterline::worker
