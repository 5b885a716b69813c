#include "tests/bench/line_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>

#include "common/base/status_macros.h"
#include "tests/scenes/random.h"
#include "tests/support/scalar_resolver.h"
#include "worker/engine/accel/bvh.h"
#include "worker/engine/paper/line_patches.h"
#include "worker/engine/render/make_resolver.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/visibility/envelope.h"
#include "worker/engine/visibility/segment.h"
#include "worker/engine/visibility/tile_triangles.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::bench {
namespace {

using engine::LineSegment;

struct Pair {
  std::optional<uint32_t> ours, ray;
  double our_distance = 0, ray_distance = 0;
};

/// The samples of one tile.
class TileTruth {
 public:
  TileTruth(const PointProbe& probe, const engine::LinePattern& pattern, const TileRect& rect,
            const std::vector<engine::PrimitiveTraits>& traits, const engine::Bvh& bvh)
      : probe_(probe), pattern_(pattern), rect_(rect) {
    std::vector<uint32_t> candidates;
    bvh.CollectVisible(rect, candidates);
    engine::SetUpTile(probe.frame_scene(), traits, pattern, rect, candidates, tile_);
  }

  /// Draws `count` places on `line` at its instant `t`.
  void SampleSlices(const engine::TileLine& line, double t, int count, scenes::Random& random,
                    std::vector<Pair>& pairs) {
    const engine::SegmentLine segment_line = engine::MakeSegmentLine(pattern_, line);
    segments_.clear();
    for (const uint32_t i : Touching(line)) {
      LineSegment segment;
      if (engine::MakeSegment(tile_.triangles[i], i, tile_.far_depth, segment_line, t, &segment, nullptr)) {
        segments_.push_back(segment);
      }
    }
    marcher_.March(segments_, segment_line.begin, segment_line.end, spans_);
    Draw(line, count, random, [&] { return t; });
    AskRays(
        [&](double major, double, Pair& pair) {
          const int64_t at = int64_t(major * kSubpixelsPerPixel);
          for (const engine::VisibleSpan& span : spans_) {
            if (span.begin > at || span.end <= at) continue;
            const LineSegment& segment = segments_[span.segment];
            pair.ours = segment.id;
            pair.our_distance = DistanceOf(segment.DepthAt(major));
          }
        },
        pairs);
  }

  /// Draws `count` places on `line`, each at a time of its own.
  void SamplePatches(const engine::TileLine& line, int count, scenes::Random& random,
                     std::vector<Pair>& pairs) {
    patches_.Gather(line, Touching(line));
    Draw(line, count, random, [&] { return random.Uniform(0, 1); });
    AskRays(
        [&](double major, double t, Pair& pair) {
          const std::optional<engine::paper::PatchSight> seen = patches_.SeeAt(major, t);
          if (!seen) return;
          pair.ours = seen->triangle;
          pair.our_distance = DistanceOf(seen->depth);
        },
        pairs);
  }

 private:
  /// The tile's triangles on a line, nearest first.
  const std::vector<uint32_t>& Touching(const engine::TileLine& line) {
    touching_.clear();
    const auto family = size_t(line.family);
    for (uint32_t i = 0; i < tile_.triangles.size(); ++i) {
      const engine::TileTriangle& triangle = tile_.triangles[i];
      if (triangle.first_line[family] <= line.number && triangle.last_line[family] >= line.number) {
        touching_.push_back(i);
      }
    }
    return touching_;
  }

  template <typename Time>
  void Draw(const engine::TileLine& line, int count, scenes::Random& random, const Time& time) {
    const engine::LineFamily& family = pattern_.families()[size_t(line.family)];
    points_.clear();
    places_.clear();
    for (int i = 0; i < count; ++i) {
      const double major = random.Uniform(line.first_step, line.end_step);
      const double minor = line.intercept + family.slope * major;
      places_.push_back(major);
      points_.push_back({rect_.x + (family.major_is_x ? major : minor),
                         rect_.y + (family.major_is_x ? minor : major), time()});
    }
  }

  /// Appends a pair for each place drawn: ours by see(place, time, pair).
  template <typename See>
  void AskRays(const See& see, std::vector<Pair>& pairs) {
    hits_.resize(points_.size());
    probe_.See(points_, hits_);
    for (size_t i = 0; i < points_.size(); ++i) {
      Pair pair;
      see(places_[i], points_[i].t, pair);
      if (hits_[i].hit) {
        pair.ray = hits_[i].triangle;
        pair.ray_distance = probe_.Distance(hits_[i], points_[i].t);
      }
      pairs.push_back(pair);
    }
  }

  /// Metres, from z/w.
  double DistanceOf(double depth) const {
    const engine::FrameView& view = probe_.frame_scene().view;
    const double w = view.perspective ? view.znear / depth : 1;
    return -view.ViewFromRaster({.x = 0, .y = 0, .z = depth * w, .w = w}).z;
  }

  const PointProbe& probe_;
  const engine::LinePattern& pattern_;
  TileRect rect_;
  engine::TileTriangles tile_;
  std::vector<uint32_t> touching_;
  engine::RenderStats stats_;
  engine::paper::LinePatches patches_{pattern_, tile_, engine::paper::Options{}, stats_};
  std::vector<LineSegment> segments_;
  engine::EnvelopeMarcher marcher_;
  std::vector<engine::VisibleSpan> spans_;
  std::vector<ProbePoint> points_;
  std::vector<double> places_;
  std::vector<ProbeHit> hits_;
};

std::vector<engine::PrimitiveTraits> TraitsOf(const engine::FrameScene& frame_scene) {
  std::vector<engine::PrimitiveTraits> traits;
  for (const engine::FramePrimitive& primitive : frame_scene.primitives) {
    traits.push_back(
        {.cull_back = !primitive.material->double_sided, .needs_position = false, .textured = false});
  }
  return traits;
}

absl::StatusOr<std::unique_ptr<const engine::Bvh>> Hierarchy(const engine::FrameScene& frame_scene,
                                                             int threads) {
  // It wants to share the frame; here it goes before the frame does.
  return engine::Bvh::Build({&frame_scene, [](const engine::FrameScene*) {}}, threads);
}

}  // namespace

absl::StatusOr<LineTruth> MeasureLineTruth(const PointProbe& probe, const RenderSettings& settings,
                                           const TileSubset& subset, int64_t samples, int instants,
                                           int threads, Sight sight) {
  const engine::FrameScene& frame_scene = probe.frame_scene();
  const auto& pattern = engine::LinePattern::Get(settings.pattern);
  SL_ASSIGN_OR_RETURN(const auto bvh, Hierarchy(frame_scene, threads));
  const std::vector<engine::PrimitiveTraits> traits = TraitsOf(frame_scene);
  constexpr int kPlaces = 64;  // On a line at an instant.
  const auto slices = std::max<int64_t>(1, samples / kPlaces / int64_t(subset.tiles.size()));
  std::mutex mutex;
  std::vector<Pair> pairs;
  ParallelFor(int(subset.tiles.size()), threads, [&](int index, int) {
    const TileRect& rect = subset.tiles[size_t(index)];
    TileTruth tile(probe, pattern, rect, traits, *bvh);
    const std::vector<engine::TileLine> lines = pattern.LinesIn(rect);
    // Lines by their lengths, so that places are uniform on all of them.
    std::vector<size_t> line_of_step;
    for (size_t i = 0; i < lines.size(); ++i) {
      line_of_step.insert(line_of_step.end(), size_t(lines[i].end_step - lines[i].first_step), i);
    }
    scenes::Random random(uint64_t(index) + 77);
    std::vector<Pair> own;
    for (int64_t i = 0; i < slices; ++i) {
      const engine::TileLine& line = lines[line_of_step[size_t(random.Index(int(line_of_step.size())))]];
      if (sight == Sight::kPatches) {
        tile.SamplePatches(line, kPlaces, random, own);
        continue;
      }
      const double t = engine::TimeSamples::InstantAt(random.Index(instants), instants, line.instant_offset);
      tile.SampleSlices(line, t, kPlaces, random, own);
    }
    const std::lock_guard lock(mutex);
    pairs.insert(pairs.end(), own.begin(), own.end());
  });

  LineTruth truth;
  truth.near = std::numeric_limits<double>::infinity();
  for (const Pair& pair : pairs) {
    if (!pair.ray) continue;
    truth.near = std::min(truth.near, pair.ray_distance);
    truth.far = std::max(truth.far, pair.ray_distance);
  }
  const double range = std::max(truth.far - truth.near, 1e-12);
  for (const Pair& pair : pairs) {
    ++truth.samples;
    const bool same = pair.ours == pair.ray;
    truth.same += same;
    const bool both = pair.ours && pair.ray;
    const double error = both ? std::abs(pair.our_distance - pair.ray_distance) / range : 1;
    truth.same_or_tied += same || (both && error < 1e-6);
    if (both) truth.depth_errors.push_back(float(error));
  }
  return truth;
}

absl::StatusOr<double> MeasureVectorDifference(const engine::FrameScene& frame_scene, RenderSettings settings,
                                               const TileSubset& subset, int threads) {
  SL_ASSIGN_OR_RETURN(const auto bvh, Hierarchy(frame_scene, threads));
  const std::vector<engine::PrimitiveTraits> traits = TraitsOf(frame_scene);
  settings.resolver = ResolverKind::kSlice;
  settings.time_samples = 1;
  const std::unique_ptr<const engine::Resolver> vectors = engine::MakeResolver(settings);
  const engine::ScalarResolver plain(settings);
  std::vector<double> apart(subset.tiles.size());  // Pixels of each tile; their order decides the sum's bits.
  ParallelFor(int(subset.tiles.size()), threads, [&](int index, int) {
    const TileRect& rect = subset.tiles[size_t(index)];
    std::vector<uint32_t> candidates;
    bvh->CollectVisible(rect, candidates);
    engine::PairWeights seen[2];
    engine::RenderStats stats;
    const engine::TileInput input{frame_scene, traits, rect, candidates};
    vectors->Resolve(input, seen[0], nullptr, stats);
    plain.Resolve(input, seen[1], nullptr, stats);
    for (int64_t pixel = 0; pixel < rect.Area(); ++pixel) {
      // What is missing to the total is the background's.
      std::map<std::optional<uint32_t>, double> differences;
      for (const int i : {0, 1}) {
        const double unit = (i == 0 ? 1 : -1) / double(seen[i].total());
        seen[i].ForEach(pixel, [&](const engine::PixelPair& pair) {
          differences[pair.triangle] += unit * double(pair.weight);
          differences[std::nullopt] -= unit * double(pair.weight);
        });
      }
      for (const auto& [triangle, difference] : differences) {
        apart[size_t(index)] += 0.5 * std::abs(difference);
      }
    }
  });
  int64_t pixels = 0;
  for (const TileRect& rect : subset.tiles) pixels += rect.Area();
  return std::accumulate(apart.begin(), apart.end(), 0.0) / double(std::max<int64_t>(1, pixels));
}

}  // namespace shutterline::bench
