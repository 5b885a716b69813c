#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>
#include <vector>

#include "tests/bench/bench_scene.h"
#include "tests/bench/contenders.h"
#include "tests/bench/errors.h"
#include "tests/bench/line_truth.h"
#include "tests/bench/measure.h"
#include "tests/bench/pareto.h"

namespace shutterline::bench {

/// What all parts of the report share.
struct ReportOptions {
  bool quick = false;
  std::string output = "bench-report";  ///< Folder.
  std::string cache = "bench-cache";    ///< Folder of references.
  int threads = 1;
  bool cpu_clock = false;               ///< Curves and tables by CPU time / threads instead of wall time.
  std::vector<std::string> scenes;      ///< By name; empty: all of the part.
  std::vector<std::string> contenders;  ///< By name; empty: all.
  int side = 0;  ///< One tile of every square of so many a side is measured; 0: the part's own.
  int spp = 0;   ///< Of references, both halves together; 0: the part's own.

  int Side() const { return side > 0 ? side : quick ? 8 : 5; }
  int Spp() const { return spp > 0 ? spp : quick ? 1024 : 4096; }
  /// Of a setting; fewer where one takes long.
  int MostRuns() const { return quick ? 3 : 5; }
  /// A ladder is climbed no further once a run over the subset has taken this many seconds.
  double LongestRun() const { return quick ? 1.0 : 3.0; }
};

/// One setting of one method on one scene.
struct RunRow {
  std::string contender, rung;
  RenderSettings settings;
  Measurement measurement;  ///< Its pictures have been dropped.
  ErrorFigures errors;
  bool is_default = false;

  /// Seconds of a whole frame by the chosen clock.
  double Seconds(const ReportOptions& options) const;
  /// What curves are drawn through: the RMSE, or, where the reference cannot tell it from none, the largest
  /// that it allows, the root of D + 2 standard errors (of these alone where D is below 0).
  double ErrorBound() const;
  bool AtFloor() const { return errors.whole.d < 2 * errors.whole.standard_error; }
};

/// Where the error of our default setting comes from, as mean squares: lines that are few; one shade a
/// (triangle, pixel) pair; and all the rest, which is the instants and the resolver.
struct ErrorSplit {
  UnbiasedError total, space, shade, rest;
};

struct SceneResult {
  BenchScene scene = {};
  int64_t triangles = 0;
  double import_seconds = 0;
  int tiles = 0, tiles_in_frame = 0;
  ReferenceHalves reference = {};  ///< Its pictures have been dropped.
  double reference_seconds = 0;
  FlipFigures flip_floor = {};                             ///< FLIP of one half against the other.
  double moving = 0, static_edges = 0, disocclusions = 0;  ///< Shares of the pixels.
  std::vector<RunRow> runs = {};
  std::optional<ErrorSplit> split = {};
  std::optional<LineTruth> truth = {};

  TimeErrorCurve Curve(const std::string& contender, const ReportOptions& options) const;
  const RunRow* DefaultOf(const std::string& contender) const;
};

/// Climbs every ladder on one scene. Fails where a picture holds a NaN or an infinity.
absl::StatusOr<SceneResult> RunScene(const BenchScene& scene, const std::vector<Contender>& contenders,
                                     const ReportOptions& options);

/// The contenders that `options` names.
absl::StatusOr<std::vector<Contender>> ChosenContenders(const ReportOptions& options);

/// "time.csv" of the output folder; the folder is made.
absl::StatusOr<std::string> OutputPath(const ReportOptions& options, const std::string& name);

/// A sentence on commit, machine, threads, load and how times were taken.
std::string Provenance(const ReportOptions& options);

}  // namespace shutterline::bench
