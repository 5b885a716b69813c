#include "worker/engine/reference/instant_tracer.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <utility>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "worker/engine/reference/ray_packet.h"
#include "worker/engine/reference/ray_walk.h"
#include "worker/engine/sampling/shutter_curve.h"

namespace shutterline::engine {
namespace {

/// Of a tree without motion and its copy of the vertices, bytes a triangle.
constexpr double kBytesPerTriangle = 200;
/// Packets cover blocks of 4 pixels' width at multiples of 4, and so many rows.
constexpr int kBlockWidth = 4;

bool AnythingMoves(const FrameScene& frame) {
  return std::any_of(frame.primitives.begin(), frame.primitives.end(),
                     [](const FramePrimitive& p) { return p.degree > 0; });
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

bool InstantTracer::Fits(const FrameScene& frame, int spp) {
  const double trees = AnythingMoves(frame) ? spp : 1;
  return trees * double(frame.triangles.size() + 1000) * kBytesPerTriangle <= kMostBytes;
}

absl::StatusOr<std::unique_ptr<TileIntegrator>> InstantTracer::Create(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads,
    std::shared_ptr<ShadingCache> cache) {
  SL_ASSIGN_OR_RETURN(Shader shader, Shader::Create(frame_scene, settings, threads));
  std::unique_ptr<InstantTracer> tracer(
      new InstantTracer(frame_scene, std::move(shader), std::move(cache), frame, settings));
  const size_t trees = AnythingMoves(*frame_scene) ? tracer->instants_.size() : 1;
  // A tree serves one ray a pixel: where triangles are many, building it well would take longer than it
  // saves.
  const bool quickly =
      trees > 1 && 4 * frame_scene->triangles.size() > size_t(settings.width) * size_t(settings.height);
  SL_ASSIGN_OR_RETURN(const EmbreeDevice device, MakeEmbreeDevice());
  std::vector<std::optional<absl::StatusOr<EmbreeFrame>>> built(trees);
  tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
  arena.execute([&] {
    tbb::parallel_for(size_t{0}, trees, [&](size_t i) {
      built[i].emplace(EmbreeFrame::BuildAt(*frame_scene, tracer->instants_[i], quickly, device));
    });
  });
  for (auto& scene : built) {
    if (!scene->ok()) return scene->status();
    tracer->scenes_.push_back(*std::move(*scene));
  }
  return std::unique_ptr<TileIntegrator>(std::move(tracer));
}

InstantTracer::InstantTracer(std::shared_ptr<const FrameScene> frame_scene, Shader shader,
                             std::shared_ptr<ShadingCache> cache, int frame, const RenderSettings& settings)
    : frame_scene_(std::move(frame_scene)),
      shader_(std::move(shader), settings, std::move(cache)),
      pattern_(settings.seed, frame),
      filter_(settings),
      spp_(settings.spp) {
  SL_CHECK(spp_ >= 1);
  const ShutterCurve shutter(settings.shutter_curve);
  for (int s = 0; s < spp_; ++s) {
    // Pixels left of the frame serve as sources of random numbers.
    instants_.push_back(shutter.TimeOf((s + pattern_.Pixel(-1, s).At(0).t) / spp_));
  }
}

template <int kWidth>
void InstantTracer::RenderTile(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const {
  constexpr int kRows = kWidth / kBlockWidth;
  // Whole blocks, whatever the rectangle: a ray has the same company in every tile.
  const int x0 = rect.x / kBlockWidth * kBlockWidth, y0 = rect.y / kRows * kRows;
  const int columns = (rect.x + rect.width - x0 + kBlockWidth - 1) / kBlockWidth;
  const int rows = (rect.y + rect.height - y0 + kRows - 1) / kRows;
  const auto lane_x = [&](int block, int lane) {
    return x0 + block % columns * kBlockWidth + lane % kBlockWidth;
  };
  const auto lane_y = [&](int block, int lane) { return y0 + block / columns * kRows + lane / kBlockWidth; };

  const int blocks = columns * rows;
  std::vector<PixelPoints> points;
  points.reserve(size_t(blocks) * kWidth);
  for (int i = 0; i < blocks * kWidth; ++i) {
    points.push_back(pattern_.Pixel(lane_x(i / kWidth, i % kWidth), lane_y(i / kWidth, i % kWidth)));
  }
  std::vector<std::array<double, 4>> sums(points.size());
  const CameraRays camera(frame_scene_->view, scenes_[0].scale());
  alignas(64) int valid[kWidth];
  std::fill_n(valid, kWidth, -1);
  const auto start = std::chrono::steady_clock::now();
  for (int s = 0; s < spp_; ++s) {
    const EmbreeFrame& scene = scenes_[scenes_.size() == 1 ? 0 : size_t(s)];
    const PixelPoints::Digits digits = PixelPoints::DigitsOf(uint32_t(s));
    for (int block = 0; block < blocks; ++block) {
      typename EmbreePacket<kWidth>::RayHit packet;
      for (int lane = 0; lane < kWidth; ++lane) {
        const PixelPoint p = filter_.Place(points[size_t(block * kWidth + lane)].At(digits));
        camera.Set(packet, lane, lane_x(block, lane) + p.x, lane_y(block, lane) + p.y, 0);
      }
      std::array<double, kWidth> times;
      times.fill(instants_[size_t(s)]);
      std::array<std::array<double, 4>, kWidth> seen{};
      WalkRays<kWidth>(shader_, scene.scene(), valid, times, packet, seen, stats);
      for (size_t lane = 0; lane < kWidth; ++lane) {
        std::array<double, 4>& sum = sums[size_t(block) * kWidth + lane];
        for (size_t c = 0; c < 4; ++c) sum[c] += seen[lane][c];
      }
    }
  }
  for (int i = 0; i < blocks * kWidth; ++i) {
    const int x = lane_x(i / kWidth, i % kWidth) - rect.x, y = lane_y(i / kWidth, i % kWidth) - rect.y;
    if (x < 0 || y < 0 || x >= rect.width || y >= rect.height) continue;
    for (size_t channel = 0; channel < 4; ++channel) {
      rgba[4 * size_t(y * rect.width + x) + channel] = float(sums[size_t(i)][channel] / spp_);
    }
  }
  stats.resolve_seconds += SecondsSince(start);
  stats.instants += rect.Area() * spp_;
}

void InstantTracer::Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const {
  SL_CHECK(rgba.size() == 4 * size_t(rect.Area()));
  switch (scenes_[0].packet_width()) {
    case 16:
      RenderTile<16>(rect, rgba, stats);
      break;
    case 8:
      RenderTile<8>(rect, rgba, stats);
      break;
    default:
      RenderTile<4>(rect, rgba, stats);
  }
  ++stats.tiles;
}

}  // namespace shutterline::engine
