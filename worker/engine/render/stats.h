#pragma once

#include <cstdint>

namespace shutterline::engine {

/// Counts and stage times of the tiles rendered so far; plain sums, added up by the caller.
struct RenderStats {
  int64_t tiles = 0;
  int64_t candidate_triangles = 0;  ///< Triangles that reached a tile after culling.
  int64_t lines = 0;                ///< Line samples resolved.
  int64_t instants = 0;             ///< (line, instant) pairs resolved; rays for the reference.
  int64_t segments = 0;             ///< Triangle segments made on lines.
  int64_t spans = 0;                ///< Visible spans.
  int64_t pairs = 0;                ///< (triangle, pixel) pairs shaded.
  // Seconds of thread time.
  double cull_seconds = 0;
  double setup_seconds = 0;
  double resolve_seconds = 0;
  double shade_seconds = 0;

  RenderStats& operator+=(const RenderStats& other);
};

}  // namespace shutterline::engine
