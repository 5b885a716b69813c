#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "tests/bench/commands.h"
#include "tests/bench/csv.h"
#include "tests/bench/machine.h"
#include "tests/bench/point_probe.h"
#include "tests/bench/stopwatch.h"
#include "tests/support/occlusion_rays.h"
#include "worker/engine/occlusion/ambient_occlusion.h"

namespace shutterline::bench {
namespace {

constexpr int kLadderLines[] = {8, 16, 32, 64};
constexpr int kLadderRays[] = {16, 64, 256, 1024};

/// Points that a frame shows, and two independent estimates of their truth.
struct OcclusionPoints {
  std::vector<ProbeHit> hits;
  std::vector<double> truth_a, truth_b;
};

struct OcclusionRun {
  double rmse = 0;          ///< Free of the truth's noise.
  double microseconds = 0;  ///< A point, on one thread.
};

/// The square of the error against two truths with independent errors is, on average, that against the truth.
OcclusionRun MeasurePoints(const OcclusionPoints& points, const std::function<double(size_t)>& open) {
  // The fastest of a few passes; time goes by the CPU, as machines are shared.
  OcclusionRun run;
  run.microseconds = 1e30;
  for (int pass = 0; pass < 3; ++pass) {
    double sum = 0;
    const Stopwatch watch;
    for (size_t i = 0; i < points.hits.size(); ++i) {
      const double value = open(i);
      sum += (value - points.truth_a[i]) * (value - points.truth_b[i]);
    }
    run.microseconds = std::min(run.microseconds, watch.Cpu() * 1e6 / double(points.hits.size()));
    run.rmse = std::sqrt(std::max(sum, 0.0) / double(points.hits.size()));
  }
  return run;
}

/// The time at which rays have an error, by a straight line in logarithms through the rungs about it.
double RayTimeAt(const std::vector<OcclusionRun>& rays, double rmse) {
  if (!(rmse > 0) || !(rays.back().rmse > 0)) return 0;
  size_t k = 1;
  while (k + 1 < rays.size() && rays[k].rmse > rmse) ++k;
  const double slope =
      std::log(rays[k].microseconds / rays[k - 1].microseconds) / std::log(rays[k].rmse / rays[k - 1].rmse);
  return rays[k].microseconds * std::exp(slope * std::log(rmse / rays[k].rmse));
}

/// Points in groups of 3 × 3 pixels, as neighbours are shaded one after the other.
std::vector<ProbeHit> PointsOf(const PointProbe& probe, const RenderSettings& settings, int across) {
  constexpr int kGroup = 3;
  const int down = across * 3 / 4;
  std::vector<ProbePoint> places;
  for (int y = 0; y < down; ++y) {
    for (int x = 0; x < across; ++x) {
      const int left = (x * settings.width + settings.width / 2) / across;
      const int top = (y * settings.height + settings.height / 2) / down;
      for (int i = 0; i < kGroup * kGroup; ++i) {
        places.push_back({left + i % kGroup + 0.5, top + i / kGroup + 0.5, 0.5});
      }
    }
  }
  std::vector<ProbeHit> hits(places.size());
  probe.See(places, hits);
  std::erase_if(hits, [](const ProbeHit& hit) { return !hit.hit; });
  return hits;
}

}  // namespace

absl::Status Occlusion(const ReportOptions& options) {
  SL_ASSIGN_OR_RETURN(
      const std::vector<BenchScene> scenes,
      BenchScenesNamed(options.scenes.empty() ? std::vector<std::string>{"chess", "armadillo", "hall"}
                                              : options.scenes));
  CsvTable table({"commit", "machine", "scene", "points", "motion", "method", "count", "rmse", "us_a_point",
                  "rays_us_at_this_error"});
  const int truth_rays = options.spp > 0 ? options.spp : options.quick ? 2048 : 8192;
  for (const BenchScene& scene : scenes) {
    SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
    SL_ASSIGN_OR_RETURN(const auto frame, engine::BuildFrameScene(loaded.scene, scene.frame, scene.settings));
    SL_ASSIGN_OR_RETURN(const auto probe, PointProbe::Create(frame, scene.settings, options.threads));
    OcclusionPoints points;
    points.hits = PointsOf(*probe, scene.settings, options.quick ? 4 : 9);
    std::vector<double> still_times;
    for (const bool motion : {false, true}) {
      OcclusionSettings settings;
      settings.motion = motion;
      SL_ASSIGN_OR_RETURN(const auto rays, engine::OcclusionRays::Create(frame, settings, options.threads));
      points.truth_a.resize(points.hits.size());
      points.truth_b.resize(points.hits.size());
      for (size_t i = 0; i < points.hits.size(); ++i) {
        const ProbeHit& hit = points.hits[i];
        points.truth_a[i] = rays.At(hit.triangle, hit.b1, hit.b2, truth_rays, 2 * i + 1'000'001);
        points.truth_b[i] = rays.At(hit.triangle, hit.b1, hit.b2, truth_rays, 2 * i + 1'000'002);
      }
      const auto report = [&](const std::string& method, int count, const OcclusionRun& run, double ray_time,
                              const std::string& more) {
        std::printf(
            "%-10s %-6s %-12s %5d  rmse %.5f  %8.1f us  %s%s\n", scene.name.c_str(),
            motion ? "moving" : "still", method.c_str(), count, run.rmse, run.microseconds,
            ray_time > 0
                ? absl::StrFormat("rays: %.0f us, %.1fx", ray_time, ray_time / run.microseconds).c_str()
                : "",
            more.c_str());
        std::fflush(stdout);
        table.AddRow({kBuildId, MachineName(), scene.name, Cell(int64_t(points.hits.size())),
                      motion ? "1" : "0", method, Cell(int64_t{count}), Cell(run.rmse),
                      Cell(run.microseconds), ray_time > 0 ? Cell(ray_time) : ""});
      };

      std::vector<OcclusionRun> ladder;
      for (const int count : kLadderRays) {
        ladder.push_back(MeasurePoints(points, [&](size_t i) {
          const ProbeHit& hit = points.hits[i];
          return rays.At(hit.triangle, hit.b1, hit.b2, count, i);
        }));
        report("rays", count, ladder.back(), 0, "");
      }
      size_t rung = 0;
      for (const OcclusionPattern pattern : {OcclusionPattern::kPole, OcclusionPattern::kTilted}) {
        for (const bool turned : {true, false}) {
          for (const int lines : kLadderLines) {
            settings.pattern = pattern;
            settings.lines = lines;
            SL_ASSIGN_OR_RETURN(const auto occlusion,
                                engine::AmbientOcclusion::Create(frame, settings, options.threads));
            const OcclusionRun run = MeasurePoints(points, [&](size_t i) {
              const ProbeHit& hit = points.hits[i];
              return turned ? occlusion.At(hit.triangle, hit.b1, hit.b2)
                            : occlusion.At(hit.triangle, hit.b1, hit.b2, engine::LineShifts());
            });
            if (!motion) still_times.push_back(run.microseconds);
            report(
                absl::StrCat(pattern == OcclusionPattern::kPole ? "pole" : "tilted", turned ? "" : ",fixed"),
                lines, run, RayTimeAt(ladder, run.rmse),
                motion ? absl::StrFormat(", %.2f x still", run.microseconds / still_times[rung]) : "");
            ++rung;
          }
        }
      }
    }
  }
  SL_ASSIGN_OR_RETURN(const std::string csv, OutputPath(options, "occlusion.csv"));
  return table.Write(csv);
}

}  // namespace shutterline::bench
