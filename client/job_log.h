#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "client/connection.h"

namespace shutterline::client {

/// Reads what the coordinator's log says of a job from `offset` (bytes) on, and moves `offset` to where the
/// log ends now. Pieces go to `on_text` in order, each once, also when the connection breaks in between.
absl::Status ReadJobLog(Connection& connection, const std::string& job_id, uint64_t& offset,
                        const std::function<void(absl::string_view)>& on_text);

/// Of a text that comes in pieces, the whole lines that speak of a tile: Add* Rest?. A line speaks of what
/// its fields name, as in "… frame=3 tile=17 …".
class LogFilter {
 public:
  using OnLine = std::function<void(absl::string_view)>;  ///< Without its newline.

  /// Without `frame` and `tile` (an index into the frame's tiles) every line is wanted.
  LogFilter(std::optional<int> frame, std::optional<int> tile, OnLine on_line);

  void Add(absl::string_view piece);
  /// A last line without an end, if there is one.
  void Rest();

 private:
  void Judge(absl::string_view line) const;

  const std::string frame_field_, tile_field_;  ///< Empty: any.
  const OnLine on_line_;
  std::string unfinished_;
};

}  // namespace shutterline::client
