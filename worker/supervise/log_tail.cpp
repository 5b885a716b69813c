#include "worker/supervise/log_tail.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdint>

#include "common/base/utf8.h"

namespace shutterline::worker {

void LogTail::Add(absl::string_view bytes) {
  while (!bytes.empty()) {
    const size_t end = std::min(bytes.find('\n'), bytes.size());
    if (!open_) {
      if (lines_.size() == kLines) lines_.pop_front();
      lines_.emplace_back();
    }
    std::string& line = lines_.back();
    absl::StrAppend(&line, bytes.substr(0, std::min(end, kLineBytes - std::min(kLineBytes, line.size()))));
    open_ = end == bytes.size();
    bytes.remove_prefix(open_ ? end : end + 1);
  }
}

void LogTail::Clear() {
  lines_.clear();
  open_ = false;
}

std::string LogTail::Text() const {
  std::string text;
  for (const std::string& line : lines_) {
    text += WithoutControls(ValidUtf8(line)) + '\n';
  }
  return text;
}

}  // namespace shutterline::worker
