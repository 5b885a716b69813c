#include "worker/engine/render/stats.h"

namespace shutterline::engine {

RenderStats& RenderStats::operator+=(const RenderStats& other) {
  tiles += other.tiles;
  candidate_triangles += other.candidate_triangles;
  lines += other.lines;
  instants += other.instants;
  segments += other.segments;
  spans += other.spans;
  pairs += other.pairs;
  cull_seconds += other.cull_seconds;
  setup_seconds += other.setup_seconds;
  resolve_seconds += other.resolve_seconds;
  shade_seconds += other.shade_seconds;
  return *this;
}

}  // namespace shutterline::engine
