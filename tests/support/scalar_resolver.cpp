#include "tests/support/scalar_resolver.h"

#include <algorithm>
#include <span>

#include "common/base/check.h"
#include "tests/support/line_weights.h"
#include "worker/engine/visibility/front_to_back.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {
namespace {

/// Neighbouring lines of a family that share one scan over the tile's triangles.
constexpr size_t kLinesPerGroup = 8;

/// Resolves one tile; holds the working memory that its lines share.
class TileResolution {
 public:
  TileResolution(const LinePattern& pattern, const TimeSamples& time_samples, const TileTriangles& tile,
                 PairWeights& weights, RenderStats& stats)
      : pattern_(pattern), time_samples_(time_samples), tile_(tile), weights_(weights), stats_(stats) {
    line_weights_.Reset(tile.triangles.size());
  }

  void ResolveGroup(std::span<const TileLine> lines) {
    GatherGroup(lines);
    if (group_.empty()) return;
    for (const TileLine& line : lines) ResolveLine(line);
  }

 private:
  /// Which triangles may touch any line of the group, nearest first.
  void GatherGroup(std::span<const TileLine> lines) {
    const int family = lines.front().family;
    group_.clear();
    for (uint32_t i = 0; i < tile_.triangles.size(); ++i) {
      const TileTriangle& triangle = tile_.triangles[i];
      if (triangle.first_line[family] <= lines.back().number &&
          triangle.last_line[family] >= lines.front().number) {
        group_.push_back(i);
      }
    }
  }

  void ResolveLine(const TileLine& line) {
    ++stats_.lines;
    line_ = &line;
    segment_line_ = MakeSegmentLine(pattern_, line);
    ResolveStatic();
    GatherMoving();
    if (moving_.empty()) {
      ++stats_.instants;
      Accumulate(static_, 0, uint64_t(time_samples_.WeightPerLine()));
    } else {
      ResolveInstants();
    }
    FlushLine();
  }

  void FlushLine() {
    line_weights_.ForEachAndClear([&](uint32_t index, int step, uint64_t weight) {
      weights_.Add(PixelOf(step), {.triangle = tile_.triangles[index].id, .weight = weight});
    });
  }

  bool Touches(const TileTriangle& triangle) const {
    return triangle.first_line[line_->family] <= line_->number &&
           line_->number <= triangle.last_line[line_->family];
  }

  /// The envelope of what stands still.
  void ResolveStatic() {
    static_.Begin(segment_line_.begin, segment_line_.end);
    for (const uint32_t index : group_) {
      const TileTriangle& triangle = tile_.triangles[index];
      if (!static_.Wants(triangle.nearest_depth)) break;
      if (!triangle.moves && Touches(triangle)) Offer(static_, index, 0);
    }
    static_.Finish();
  }

  /// The moving triangles that what stands still does not hide for good, and how far they move.
  void GatherMoving() {
    moving_.clear();
    motion_pixels_ = 0;
    for (const uint32_t index : group_) {
      const TileTriangle& triangle = tile_.triangles[index];
      if (!static_.Wants(triangle.nearest_depth)) break;
      if (!triangle.moves || !Touches(triangle)) continue;
      moving_.push_back(index);
      motion_pixels_ = std::max(motion_pixels_, triangle.motion_pixels);
    }
  }

  void ResolveInstants() {
    const int64_t instants = time_samples_.InstantsFor(motion_pixels_);
    stats_.instants += instants;
    const auto weight = uint64_t(time_samples_.WeightOf(instants));
    int64_t at_rest = 0;
    for (int64_t i = 0; i < instants; ++i) {
      const double t = TimeSamples::InstantAt(i, instants, line_->instant_offset);
      if (!ResolveInstant(t)) {
        ++at_rest;  // Nothing that moves is on the line now: the static envelope is what is seen.
        continue;
      }
      Accumulate(moment_, t, weight);
    }
    if (at_rest > 0) Accumulate(static_, 0, weight * uint64_t(at_rest));
  }

  /// The envelope at one instant, in moment_. False if nothing that moves takes part.
  bool ResolveInstant(double t) {
    moment_.Begin(segment_line_.begin, segment_line_.end);
    bool any = false;
    for (const uint32_t index : moving_) {
      const TileTriangle& triangle = tile_.triangles[index];
      if (!moment_.Wants(triangle.nearest_depth)) break;
      if (t < triangle.t_in || t > triangle.t_out) continue;
      if (!any && MakeFirst(index, t)) {
        any = true;
      } else if (any) {
        Offer(moment_, index, t);
      }
    }
    if (any) moment_.Finish();
    return any;
  }

  /// Tries to make the first moving segment of an instant; with it, what stands still comes along.
  bool MakeFirst(uint32_t index, double t) {
    const size_t before = moment_.segments().size();
    Offer(moment_, index, t);
    if (moment_.segments().size() == before) return false;
    for (size_t i = 0; i < static_.segments().size(); ++i)
      moment_.Offer(static_.segments()[i], static_.positions()[i]);
    return true;
  }

  void Offer(FrontToBack& envelope, uint32_t index, double t) {
    const TileTriangle& triangle = tile_.triangles[index];
    LineSegment segment;
    SegmentPosition position;
    if (!MakeSegment(triangle, index, tile_.far_depth, segment_line_, t, &segment,
                     triangle.needs_position ? &position : nullptr)) {
      return;
    }
    ++stats_.segments;
    envelope.Offer(segment, position);
  }

  void Accumulate(const FrontToBack& envelope, double t, uint64_t weight) {
    stats_.spans += int64_t(envelope.spans().size());
    for (const VisibleSpan& span : envelope.spans()) {
      const uint32_t index = envelope.segments()[span.segment].index;
      if (tile_.triangles[index].needs_position) {
        AccumulateWithPosition(envelope, span, t, weight);
      } else {
        line_weights_.Add(index, span.begin, span.end, weight);
        if (line_weights_.Full()) FlushLine();
      }
    }
  }

  /// Cuts a visible span at the pixels' borders: each piece has a place of its own on the triangle.
  void AccumulateWithPosition(const FrontToBack& envelope, const VisibleSpan& span, double t,
                              uint64_t weight) {
    const LineSegment& segment = envelope.segments()[span.segment];
    const TileTriangle& triangle = tile_.triangles[segment.index];
    PixelPair piece{.triangle = segment.id,
                    .bin = uint16_t(t * double(1u << triangle.shading_bins_log2)),
                    .bins_log2 = triangle.shading_bins_log2};
    for (int32_t from = span.begin; from < span.end;) {
      const int step = from >> kSubpixelBits;
      const int32_t to = std::min(span.end, (step + 1) << kSubpixelBits);
      const double middle = (double(from) + double(to)) * (0.5 / kSubpixelsPerPixel);
      const SegmentBarycentric at = BarycentricAt(segment, envelope.positions()[span.segment], middle);
      piece.b1 = at.b1;
      piece.b2 = at.b2;
      piece.weight = uint64_t(to - from) * weight;
      weights_.Add(PixelOf(step), piece);
      from = to;
    }
  }

  int64_t PixelOf(int step) const {
    const int minor = pattern_.MinorPixel(*line_, step);
    return segment_line_.major_is_x ? int64_t{minor} * tile_.rect.width + step
                                    : int64_t{step} * tile_.rect.width + minor;
  }

  const LinePattern& pattern_;
  const TimeSamples& time_samples_;
  const TileTriangles& tile_;
  PairWeights& weights_;
  RenderStats& stats_;

  std::vector<uint32_t> group_;
  const TileLine* line_ = nullptr;
  SegmentLine segment_line_;
  FrontToBack static_;
  FrontToBack moment_;
  LineWeights line_weights_;
  std::vector<uint32_t> moving_;
  double motion_pixels_ = 0;
};

}  // namespace

ScalarResolver::ScalarResolver(const RenderSettings& settings)
    : pattern_(LinePattern::Get(settings.pattern)), time_samples_(settings) {}

void ScalarResolver::Resolve(const TileInput& input, PairWeights& weights, ColorFilm* flat,
                             RenderStats& stats) const {
  SL_CHECK(input.rect.width <= kMaxLinePixels && input.rect.height <= kMaxLinePixels);
  if (flat != nullptr) flat->Reset(input.rect.Area());
  const auto line_weight = uint64_t(time_samples_.WeightPerLine()) * uint64_t{kSubpixelsPerPixel};
  weights.Reset(input.rect.Area(), line_weight * uint64_t(pattern_.StepsPerPixel()));

  TileTriangles tile;
  SetUpTile(input.frame, input.traits, pattern_, input.rect, input.candidates, tile);
  const std::vector<TileLine> lines = pattern_.LinesIn(tile.rect);
  TileResolution resolution(pattern_, time_samples_, tile, weights, stats);
  for (size_t i = 0; i < lines.size();) {
    size_t group_end = i + 1;
    while (group_end < lines.size() && group_end - i < kLinesPerGroup &&
           lines[group_end].family == lines[i].family) {
      ++group_end;
    }
    resolution.ResolveGroup({&lines[i], group_end - i});
    i = group_end;
  }
}

}  // namespace shutterline::engine
