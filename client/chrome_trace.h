#pragma once

#include <absl/time/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/json_output.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::client {

/// A job's trace in the Chrome trace format, which chrome://tracing and https://ui.perfetto.dev show: a
/// process a worker, a row a lease that is rendered at the same time as others, a complete event a tile; and
/// the coordinator with its commits and the files that it writes. Not thread-safe.
///
/// The coordinator knows when a tile was granted and when it came, the worker how long it took. Tiles of a
/// lease are rendered one after the other, so each is drawn as late as it can have been: it ends when it
/// came, or when the next one of its lease began.
class ChromeTrace {
 public:
  /// The next message of the stream.
  void Add(const v1::FrameTrace& message);
  int64_t tiles() const { return int64_t(tiles_.size()); }
  /// The whole document.
  Json Finish() const;

 private:
  struct Tile {
    int frame = 0;
    uint32_t tile = 0;
    size_t worker = 0;
    uint64_t lease = 0;
    absl::Duration granted, received, durable, render_time;
    absl::Duration begin;  ///< As drawn.
  };
  struct Assembly {
    int frame = 0;
    absl::Duration began, ended;
  };

  std::vector<std::string> worker_names_;
  std::map<std::string, size_t> workers_;  ///< By UUID.
  int frame_ = 0;
  std::vector<size_t> frame_workers_;  ///< Of the frame that is being told.
  std::vector<Tile> tiles_;
  std::vector<Assembly> assemblies_;
};

}  // namespace shutterline::client
