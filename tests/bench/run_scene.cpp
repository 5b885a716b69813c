#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/status_macros.h"
#include "tests/bench/report.h"
#include "tests/bench/stopwatch.h"

namespace shutterline::bench {
namespace {

constexpr uint64_t kTileSeed = 20110801;

absl::StatusOr<RunRow> RunRung(const LoadedScene& loaded, const BenchScene& scene, const Contender& contender,
                               const Rung& rung, const TileSubset& subset, const SceneResult& result,
                               const BenchMasks& masks, const ReportOptions& options) {
  RunRow row{.contender = contender.name,
             .rung = rung.label,
             .settings = scene.settings,
             .measurement = {},
             .errors = {}};
  rung.apply(row.settings);
  SL_ASSIGN_OR_RETURN(
      row.measurement,
      Measure(loaded.scene, scene.frame, row.settings, subset,
              {.threads = options.threads, .most_runs = options.MostRuns(), .new_seeds = contender.random}));
  SL_ASSIGN_OR_RETURN(row.errors,
                      MeasureErrors(row.measurement.pictures, result.reference, masks, options.threads));
  return row;
}

/// mean (X − R)(X' − R'), of halves X, X' and R, R': the mean square of what tells X from R, without noise.
absl::StatusOr<UnbiasedError> ProductOf(const ReferenceHalves& x, const ReferenceHalves& r) {
  // MeasureUnbiasedError subtracts from one picture: X' − R' is told as X − (R' + X − X').
  Image shifted = r.b;
  for (size_t i = 0; i < shifted.values().size(); ++i) {
    shifted.values()[i] += x.a.values()[i] - x.b.values()[i];
  }
  return MeasureUnbiasedError(x.a, r.a, shifted);
}

/// The total error of our default setting, split with a reference whose points lie on the same lines:
/// (L − A)(L' − B) has the expectation of what lines cannot see. With C that reference shaded by pairs,
/// (C − L)(C' − L') has that of shading once, and (T − C)(T − C') that of all the rest.
absl::StatusOr<ErrorSplit> Split(const RunRow& row, const Image& picture, const PointProbe& probe,
                                 const BenchScene& scene, const TileSubset& subset,
                                 const ReferenceHalves& reference, const ReportOptions& options) {
  SL_ASSIGN_OR_RETURN(const LineReference lines,
                      RenderLineReference(probe, scene.frame, row.settings, subset, options.Spp() / 4,
                                          options.threads, {options.cache}));
  ErrorSplit split{.total = row.errors.whole, .space = {}, .shade = {}, .rest = {}};
  SL_ASSIGN_OR_RETURN(split.rest, MeasureUnbiasedError(picture, lines.cached.a, lines.cached.b));
  SL_ASSIGN_OR_RETURN(split.space, ProductOf(lines.traced, reference));
  SL_ASSIGN_OR_RETURN(split.shade, ProductOf(lines.cached, lines.traced));
  return split;
}

void Print(const SceneResult& result, const RunRow& row, const ReportOptions& options) {
  const UnbiasedError& e = row.errors.whole;
  std::printf("%-16s %-12s %-22s frame %8.3f s (cpu %8.3f; build %.3f)  %s%s\n", result.scene.name.c_str(),
              row.contender.c_str(), row.rung.c_str(), row.Seconds(options), row.measurement.FrameCpu(),
              row.measurement.build_wall, e.ToString().c_str(), row.is_default ? "  *" : "");
  std::fflush(stdout);
}

}  // namespace

absl::StatusOr<SceneResult> RunScene(const BenchScene& scene, const std::vector<Contender>& contenders,
                                     const ReportOptions& options) {
  SceneResult result{.scene = scene};
  SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
  result.import_seconds = loaded.import_seconds;
  SL_ASSIGN_OR_RETURN(const auto frame_scene,
                      engine::BuildFrameScene(loaded.scene, scene.frame, scene.settings));
  result.triangles = int64_t(frame_scene->triangles.size());
  const TileSubset subset =
      StratifiedTiles(scene.settings.width, scene.settings.height, options.Side(), kTileSeed);
  result.tiles = int(subset.tiles.size());
  result.tiles_in_frame = subset.tiles_in_frame;

  // The truth, and what pixels are.
  const Stopwatch watch;
  SL_ASSIGN_OR_RETURN(result.reference, RenderReference(frame_scene, scene.frame, scene.settings, subset,
                                                        options.Spp(), options.threads, {options.cache}));
  result.reference_seconds = watch.Wall();
  SL_ASSIGN_OR_RETURN(result.flip_floor,
                      MeasureFlip(result.reference.a, result.reference.b, options.threads));
  SL_ASSIGN_OR_RETURN(const auto probe, PointProbe::Create(frame_scene, scene.settings, options.threads));
  const BenchMasks masks = MakeMasks(*probe, scene.frame, subset, options.threads);
  result.moving = MaskShare(masks.moving);
  result.static_edges = MaskShare(masks.static_edges);
  result.disocclusions = MaskShare(masks.disocclusions);
  std::printf("%-16s %lld triangles, reference of %d points a pixel in %.1f s, noise %.5f\n",
              scene.name.c_str(), static_cast<long long>(result.triangles), result.reference.spp,
              result.reference_seconds, result.reference.noise);
  std::fflush(stdout);

  for (const Contender& contender : contenders) {
    for (int i = 0; i < int(contender.ladder.size()); ++i) {
      absl::StatusOr<RunRow> row =
          RunRung(loaded, scene, contender, contender.ladder[size_t(i)], subset, result, masks, options);
      if (!row.ok()) {
        return absl::Status(row.status().code(), absl::StrCat(scene.name, ", ", contender.name, ", ",
                                                              contender.ladder[size_t(i)].label, ": ",
                                                              std::string(row.status().message())));
      }
      row->is_default = i == contender.default_rung;
      Print(result, *row, options);
      if (row->is_default && contender.ours && !result.split) {
        SL_ASSIGN_OR_RETURN(const ErrorSplit split, Split(*row, row->measurement.pictures.front(), *probe,
                                                          scene, subset, result.reference, options));
        result.split = split;
        SL_ASSIGN_OR_RETURN(LineTruth truth,
                            MeasureLineTruth(*probe, row->settings, subset, options.quick ? 200000 : 1100000,
                                             64, options.threads));
        truth.depth_errors.clear();
        result.truth = std::move(truth);
      }
      row->measurement.pictures.clear();
      result.runs.push_back(*std::move(row));
      const double took = result.runs.back().measurement.tiles_wall;
      if (took > options.LongestRun() && i >= contender.default_rung) break;
    }
  }
  result.reference.a = result.reference.b = Image();
  return result;
}

double RunRow::Seconds(const ReportOptions& options) const {
  return options.cpu_clock ? measurement.FrameCpu() / options.threads : measurement.FrameWall();
}

double RunRow::ErrorBound() const {
  const UnbiasedError& e = errors.whole;
  if (!AtFloor()) return e.Rmse();
  return std::sqrt(std::max(std::max(e.d, 0.0) + 2 * e.standard_error, 1e-18));
}

TimeErrorCurve SceneResult::Curve(const std::string& contender, const ReportOptions& options) const {
  std::vector<TimeError> points;
  for (const RunRow& row : runs) {
    if (row.contender == contender) points.push_back({row.Seconds(options), row.ErrorBound()});
  }
  return TimeErrorCurve(std::move(points));
}

const RunRow* SceneResult::DefaultOf(const std::string& contender) const {
  for (const RunRow& row : runs) {
    if (row.contender == contender && row.is_default) return &row;
  }
  return nullptr;
}

}  // namespace shutterline::bench
