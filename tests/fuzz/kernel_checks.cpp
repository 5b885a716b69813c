#include "tests/fuzz/kernel_checks.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/fuzz/hostile_segments.h"
#include "tests/fuzz/hostile_values.h"
#include "tests/support/only_target.h"
#include "worker/engine/slice/kernels.h"
#include "worker/engine/visibility/envelope.h"

namespace shutterline::engine {
namespace {

constexpr int32_t kLength = kMaxLinePixels * kSubpixelsPerPixel;

/// A visible piece of a line; `segment` is a number in the list that was given.
struct Piece {
  int32_t begin, end;
  size_t segment;
  friend bool operator==(const Piece&, const Piece&) = default;
};

struct Lists {
  std::array<std::vector<HostileSegment>, kLanes> lanes;
  SegmentLists lists;
  LineGroup group;
  std::vector<uint32_t> ids;
  uint32_t active = 0;
};

/// Fills what March is given from `lanes`; every segment is a triangle of its own.
void Fill(Lists& input) {
  input.lists.Clear();
  input.ids.clear();
  for (int lane = 0; lane < kLanes; ++lane) {
    for (const HostileSegment& s : input.lanes[size_t(lane)]) {
      input.lists.Append(lane, s.begin, s.end, s.depth, s.slope, uint32_t(input.ids.size()));
      input.ids.push_back(s.id);
    }
  }
  input.ids.resize(input.ids.size() + 16);
}

Lists MakeLists(HostileValues& values) {
  Lists input;
  input.group.lanes = values.Int(1, kLanes);
  const int stretch = values.Int(0, 3);  // Of four, or all of them.
  input.lists.stretch_begin = values.Chance(0.5) ? 0 : stretch * (kLength / 4);
  input.lists.stretch_end =
      input.lists.stretch_begin == 0 ? kLength : input.lists.stretch_begin + kLength / 4;
  for (int lane = 0; lane < input.group.lanes; ++lane) {
    const auto i = size_t(lane);
    input.group.begin[i] = values.Chance(0.5) ? 0 : values.Int(0, 63) * kSubpixelsPerPixel;
    input.group.end[i] = values.Chance(0.5) ? kLength : values.Int(0, 64) * kSubpixelsPerPixel;
    input.lanes[i] = MakeHostileSegments(values, kLength, values.Int(0, values.Chance(0.1) ? 80 : 20));
    // As MakeSegments does: within the line, and reaching into the stretch.
    std::erase_if(input.lanes[i], [&](HostileSegment& s) {
      const int32_t begin =
          std::clamp(s.begin, input.group.begin[i], std::max(input.group.begin[i], input.group.end[i]));
      s.depth = std::clamp(s.depth + s.slope * float(begin - s.begin), 0.0f, 1.0f);
      s.begin = begin;
      s.end = std::min(s.end, input.group.end[i]);
      return s.begin > s.end || s.begin >= input.lists.stretch_end || s.end <= input.lists.stretch_begin;
    });
    if (values.Chance(0.9)) input.active |= uint32_t{1} << lane;
  }
  Fill(input);
  return input;
}

std::vector<Piece> PiecesOf(const VisiblePieces& pieces, int lane) {
  std::vector<Piece> result;
  for (int32_t r = 0; r < pieces.rows; ++r) {
    const size_t at = size_t(r) * kLanes + size_t(lane);
    if (pieces.begin[at] >= pieces.end[at]) continue;
    result.push_back({pieces.begin[at], pieces.end[at], size_t(pieces.entry[at])});
  }
  return result;
}

double DepthAt(const HostileSegment& s, int32_t x) {
  return double(s.depth) + double(s.slope) * double(int64_t{x} - s.begin);
}

/// What rounding may do to a depth at x: of the depth, of the slope's product with a distance that is itself
/// rounded, and of the place where another comes in front, which is a whole subpixel. The place where a third
/// one falls behind both is rounded too: by 2^-24 of how far it falls, 1 at most.
double Rounding(const HostileSegment& s, int32_t x) {
  const double distance = double(int64_t{x} - s.begin);
  return 0x1p-22 * (std::abs(double(s.depth)) + std::abs(double(s.slope)) * distance) +
         std::abs(double(s.slope)) + 0x1p-22;
}

/// Holds pieces of the segments within [begin, end) against all segments. `rounding` multiplies what is
/// forgiven.
std::string BrokenPieces(const std::vector<HostileSegment>& segments, const std::vector<Piece>& pieces,
                         int32_t begin, int32_t end, std::vector<int32_t> places) {
  int32_t last = begin;
  for (const Piece& piece : pieces) {
    if (piece.segment >= segments.size()) return "piece of nothing";
    const HostileSegment& s = segments[piece.segment];
    if (piece.begin < last || piece.begin < s.begin || piece.end > std::min(s.end, end)) {
      return absl::StrCat("piece [", piece.begin, ", ", piece.end, ") of [", s.begin, ", ", s.end, ") after ",
                          last);
    }
    last = piece.end;
    places.insert(places.end(), {piece.begin, piece.begin + (piece.end - piece.begin) / 2, piece.end - 1});
  }
  for (const HostileSegment& s : segments)
    places.insert(places.end(), {s.begin - 1, s.begin, s.end - 1, s.end});
  for (const int32_t x : places) {
    if (x < begin || x >= end) continue;
    const auto piece =
        std::find_if(pieces.begin(), pieces.end(), [&](const Piece& p) { return p.begin <= x && x < p.end; });
    // Next to where something changes, rounding of the place may show what another segment has just hidden.
    int32_t width = 2;
    if (piece != pieces.end()) {
      for (const HostileSegment& s : segments) {
        if (s.begin <= x && x < s.end) width = std::max(width, 2 + ((s.end - s.begin) >> 22));
      }
      if (x < piece->begin + width || x >= piece->end - width) continue;
    }
    for (const HostileSegment& s : segments) {
      if (x < s.begin || x >= s.end) continue;
      if (piece == pieces.end()) return absl::StrCat("gap at ", x);
      const HostileSegment& shown = segments[piece->segment];
      const double lead = DepthAt(s, x) - DepthAt(shown, x);
      if (lead > Rounding(s, x) + Rounding(shown, x)) {
        return absl::StrCat("at ", x, " a segment is nearer by ", lead, " than the one that shows, rounding ",
                            Rounding(s, x) + Rounding(shown, x));
      }
    }
  }
  return "";
}

std::vector<int32_t> SomePlaces(HostileValues& values, int32_t begin, int32_t end) {
  std::vector<int32_t> places;
  for (int i = 0; begin < end && i < 16; ++i)
    places.push_back(begin + int32_t(values.Unit() * double(end - begin)));
  return places;
}

std::string BrokenMarchOf(HostileValues& values, const Lists& input, const VisiblePieces& pieces) {
  size_t longest = 0;
  for (const auto& lane : input.lanes) longest = std::max(longest, lane.size());
  // The envelope of n segments has little more than 2n pieces; gaps, empty segments and rounding add some.
  if (size_t(pieces.rows) > 6 * longest + 4) {
    return absl::StrCat(pieces.rows, " pieces of ", longest, " segments");
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = size_t(lane);
    const std::vector<Piece> visible = PiecesOf(pieces, lane);
    const int32_t begin = std::max(input.group.begin[i], input.lists.stretch_begin);
    const int32_t end = std::min(input.group.end[i], input.lists.stretch_end);
    if ((input.active >> lane & 1) == 0) {
      if (!visible.empty()) return absl::StrCat("pieces on lane ", lane, ", which is not wanted");
      continue;
    }
    const std::string broken =
        BrokenPieces(input.lanes[i], visible, begin, end, SomePlaces(values, begin, end));
    if (!broken.empty()) return absl::StrCat("lane ", lane, ": ", broken);
  }
  return "";
}

/// Pieces by id of what they show, joined where they go on: what a picture is made of.
std::vector<Piece> Seen(const std::vector<HostileSegment>& segments, const std::vector<Piece>& pieces) {
  std::vector<Piece> seen;
  for (const Piece& piece : pieces) {
    const size_t id = segments[piece.segment].id;
    if (!seen.empty() && seen.back().end == piece.begin && seen.back().segment == id) {
      seen.back().end = piece.end;
    } else {
      seen.push_back({piece.begin, piece.end, id});
    }
  }
  return seen;
}

}  // namespace

std::string BrokenMarch(uint64_t seed) {
  HostileValues values(seed);
  Lists input = MakeLists(values);
  VisiblePieces best;
  March(input.lists, input.ids.data(), input.group, input.active, best);
  std::string broken = BrokenMarchOf(values, input, best);
  if (!broken.empty()) return "march: " + broken;
  std::array<std::vector<Piece>, kLanes> seen;
  for (int lane = 0; lane < kLanes; ++lane) {
    seen[size_t(lane)] = Seen(input.lanes[size_t(lane)], PiecesOf(best, lane));
  }

  ForEachTarget([&] {
    VisiblePieces pieces;
    March(input.lists, input.ids.data(), input.group, input.active, pieces);
    for (int lane = 0; lane < kLanes; ++lane) {
      if (PiecesOf(pieces, lane) != PiecesOf(best, lane))
        broken = absl::StrCat("march: bits of ", KernelTarget());
    }
  });
  if (!broken.empty()) return broken;

  for (auto& lane : input.lanes) std::shuffle(lane.begin(), lane.end(), values.random());
  Fill(input);
  VisiblePieces shuffled;
  March(input.lists, input.ids.data(), input.group, input.active, shuffled);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (Seen(input.lanes[size_t(lane)], PiecesOf(shuffled, lane)) != seen[size_t(lane)]) {
      return absl::StrCat("march: the order of segments shows on lane ", lane);
    }
  }
  return "";
}

std::string BrokenEnvelope(uint64_t seed) {
  HostileValues values(seed);
  const std::vector<HostileSegment> source = MakeHostileSegments(values, kLength, values.Int(0, 60));
  std::vector<HostileSegment> kept;
  std::vector<LineSegment> segments;
  for (const HostileSegment& s : source) {
    if (s.begin >= s.end) continue;  // MakeSegment makes none.
    LineSegment segment{.begin = s.begin, .end = s.end, .id = s.id, .index = uint32_t(kept.size())};
    segment.l0 = double(s.begin) / kSubpixelsPerPixel;
    segment.l1 = double(s.end) / kSubpixelsPerPixel;
    segment.d0 = double(s.depth);
    segment.d1 = double(s.depth) + double(s.slope) * (s.end - s.begin);
    segment.slope = (segment.d1 - segment.d0) / (segment.l1 - segment.l0);
    segments.push_back(segment);
    kept.push_back(s);
  }
  const int32_t begin = values.Chance(0.5) ? 0 : values.Int(0, 20) * kSubpixelsPerPixel;
  const int32_t end = values.Chance(0.5) ? kLength : values.Int(20, 64) * kSubpixelsPerPixel;
  EnvelopeMarcher marcher;
  std::vector<VisibleSpan> spans;
  marcher.March(segments, begin, end, spans);
  if (spans.size() > 6 * segments.size() + 4) {
    return absl::StrCat("envelope: ", spans.size(), " spans of ", segments.size(), " segments");
  }
  std::vector<Piece> pieces;
  for (const VisibleSpan& span : spans) pieces.push_back({span.begin, span.end, span.segment});
  const std::string broken = BrokenPieces(kept, pieces, begin, end, SomePlaces(values, begin, end));
  return broken.empty() ? "" : "envelope: " + broken;
}

std::string BrokenPlacedSegments(uint64_t seed) {
  HostileValues values(seed);
  const size_t corners = size_t(values.Int(3, 30));
  PlacedVertices vertices;
  vertices.Grow(Padded(corners));
  for (size_t i = 0; i < corners; ++i) {
    // Positions of the first few lanes, so that some are met.
    vertices.row[i] = values.Chance(0.02) ? std::nan("") : values.Position(kLanes);
    vertices.position[i] = values.Position(kMaxLinePixels) * kSubpixelsPerPixel;
    vertices.depth[i] = values.Chance(0.3) ? 0.5 : std::min(1.0, std::abs(values.AnyMagnitude()));
    if (values.Chance(0.5)) vertices.depth[i] = values.Unit();
  }
  GroupTriangles triangles;
  const int count = values.Int(1, 40);
  triangles.Reserve(size_t(count));
  for (int i = 0; i < count; ++i) {
    GroupTriangle triangle{
        .index = uint32_t(i), .t_in = 0, .t_out = 1, .one_sided = double(values.Int(0, 1))};
    for (int32_t& v : triangle.vertices) v = int32_t(values.Index(corners));
    triangles.Add(triangle);
  }
  triangles.Pad();

  // Some group of a class; vertices lie about its first rows.
  const int32_t pixels = values.Int(1, kMaxLinePixels);
  LineGroup group;
  group.first_row = values.Chance(0.7) ? 0 : kLanes;
  group.lanes = values.Int(1, kLanes);
  LineClass lines;
  lines.axes.major_is_x = values.Chance(0.5);
  lines.length = pixels;
  lines.lines.resize(size_t(group.first_row + group.lanes + values.Int(0, kLanes)));
  for (int lane = 0; lane < group.lanes; ++lane) {
    group.begin[size_t(lane)] = values.Chance(0.5) ? 0 : values.Int(0, pixels - 1) * kSubpixelsPerPixel;
    group.end[size_t(lane)] = pixels * kSubpixelsPerPixel;
  }
  const auto placed = std::make_unique<PlacedTriangles>();
  PlaceTriangles(triangles, 0, triangles.count, vertices, 0.5, lines, *placed);

  SegmentLists lists;
  lists.stretch_end = kLength;
  lists.compact_at = 1 << 20;
  HiddenBelow hidden;
  hidden.lanes.fill(-1);
  hidden.UpdateAll();
  Stretches stretches{.lists = {&lists, 1}, .shift = 30, .hidden_below = {&hidden, 1}};
  int64_t made = 0;
  if (MakeSegments(*placed, 0, group, stretches, made) != placed->met_count) return "segments: stopped";
  for (int lane = 0; lane < kLanes; ++lane) {
    for (int32_t r = 0; r < lists.count[size_t(lane)]; ++r) {
      const size_t at = size_t(r) * kLanes + size_t(lane);
      const std::string where = absl::StrCat(" of triangle ", lists.index[at], " on lane ", lane);
      const int32_t begin = lists.begin[at];
      const int32_t end = lists.end[at];
      if (lane >= group.lanes || begin >= end || begin < group.begin[size_t(lane)] ||
          end > group.end[size_t(lane)]) {
        return absl::StrCat("segments: ends ", begin, " ", end, where);
      }
      const size_t j = lists.index[at];
      double nearest = 0;
      double farthest = 1;
      double low = 1e300;
      double high = -1e300;
      for (const auto& corner : triangles.vertex) {
        const auto v = size_t(corner[j]);
        nearest = std::max(nearest, vertices.depth[v]);
        farthest = std::min(farthest, vertices.depth[v]);
        low = std::min(low, vertices.position[v]);
        high = std::max(high, vertices.position[v]);
      }
      // Of positions: what rounding does to differences of large ones.
      const double slack = 1 + 1e-14 * (std::abs(low) + std::abs(high));
      if (begin < low - slack || end > high + slack)
        return absl::StrCat("segments: beyond the corners", where);
      for (const int32_t x : {begin, end}) {
        const double depth = double(lists.depth[at]) + double(lists.slope[at]) * (x - begin);
        // Rounding of an end moves it by a subpixel at most.
        if (!(depth >= farthest - 1e-5 - std::abs(double(lists.slope[at])) &&
              depth <= nearest + 1e-5 + std::abs(double(lists.slope[at])))) {
          return absl::StrCat("segments: depth ", depth, " beyond [", farthest, ", ", nearest, "]", where);
        }
      }
    }
  }
  return "";
}

}  // namespace shutterline::engine
