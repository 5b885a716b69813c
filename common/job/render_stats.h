#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <iterator>

namespace shutterline {

/// What the rendering of tiles took: counts, and seconds of thread time by stage. Plain sums, added up by the
/// caller. A field that is added here also gets a row in one of the tables below and a line, of the row's
/// `name`, in the message RenderStats of types.proto; sums, wire, JSON and printed tables follow the rows.
struct RenderStats {
  int64_t tiles = 0;
  int64_t candidate_triangles = 0;  ///< Triangles that reached a tile after culling.
  int64_t lines = 0;                ///< Line samples resolved.
  int64_t instants = 0;             ///< (line, instant) pairs resolved; points for reference and stochastic.
  int64_t segments = 0;             ///< Triangle segments made on lines.
  int64_t spans = 0;                ///< Visible spans.
  int64_t pairs = 0;                ///< (triangle, pixel) pairs shaded.
  int64_t shading_requests = 0;     ///< Of texels' colours.
  int64_t shading_hits = 0;         ///< Requests that the cache held the answer to.
  int64_t duplicate_shadings = 0;   ///< Texels shaded twice, by two threads at once.
  int64_t cache_overflows = 0;      ///< Texels for which the cache had no room.
  int64_t matte_overflows = 0;      ///< Pixels with more ids than a matte has ranks.
  double cull_seconds = 0;
  double setup_seconds = 0;
  double resolve_seconds = 0;
  double shade_seconds = 0;

  /// Stays within what a message may hold: counts end at the largest int64, seconds at kMaxStatsSeconds.
  RenderStats& operator+=(const RenderStats& other);
  /// Thread time of all stages.
  double TotalSeconds() const;

  friend bool operator==(const RenderStats&, const RenderStats&) = default;
};

/// Some 30,000 years: no real sum comes near, and sums of such numbers stay finite.
inline constexpr double kMaxStatsSeconds = 1e12;

/// A field of RenderStats.
template <typename Number>
struct RenderStatsField {
  Number RenderStats::*member;
  absl::string_view name;   ///< In messages and in JSON; never renamed.
  absl::string_view words;  ///< For people.
};

inline constexpr RenderStatsField<int64_t> kRenderCounts[] = {
    {&RenderStats::tiles, "tiles", "tiles"},
    {&RenderStats::candidate_triangles, "candidate_triangles", "candidate triangles"},
    {&RenderStats::lines, "lines", "lines"},
    {&RenderStats::instants, "instants", "instants"},
    {&RenderStats::segments, "segments", "segments"},
    {&RenderStats::spans, "spans", "visible spans"},
    {&RenderStats::pairs, "pairs", "shaded pairs"},
    {&RenderStats::shading_requests, "shading_requests", "texels asked for"},
    {&RenderStats::shading_hits, "shading_hits", "texels found"},
    {&RenderStats::duplicate_shadings, "duplicate_shadings", "texels shaded twice"},
    {&RenderStats::cache_overflows, "cache_overflows", "texels not kept"},
    {&RenderStats::matte_overflows, "matte_overflows", "mattes cut off"},
};
inline constexpr RenderStatsField<double> kRenderSeconds[] = {
    {&RenderStats::cull_seconds, "cull_seconds", "cull"},
    {&RenderStats::setup_seconds, "setup_seconds", "set up"},
    {&RenderStats::resolve_seconds, "resolve_seconds", "resolve"},
    {&RenderStats::shade_seconds, "shade_seconds", "shade"},
};
static_assert(sizeof(RenderStats) ==
                  sizeof(int64_t) * std::size(kRenderCounts) + sizeof(double) * std::size(kRenderSeconds),
              "every field has a row");

}  // namespace shutterline
