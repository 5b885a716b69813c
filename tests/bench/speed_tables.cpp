#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

#include "tests/bench/html_page.h"
#include "tests/bench/speed_vs_error.h"
#include "tests/bench/wilson.h"

namespace shutterline::bench {
namespace {

std::string RmseOf(const UnbiasedError& e) {
  if (e.pixels == 0) return "–";
  if (e.BelowFloor()) return "below floor";
  return absl::StrFormat("%.4f", e.Rmse());
}

}  // namespace

void AddDefaultsTable(HtmlPage& page, const std::vector<SceneResult>& results, const ReportOptions& options) {
  std::vector<std::vector<std::string>> rows;
  for (const SceneResult& result : results) {
    const RunRow* row = result.DefaultOf(kOurs);
    if (row == nullptr) continue;
    const ErrorFigures& e = row->errors;
    rows.push_back({result.scene.name, absl::StrFormat("%.3g", row->Seconds(options)), RmseOf(e.whole),
                    absl::StrFormat("%.1g", 2 * e.whole.standard_error), RmseOf(e.moving),
                    RmseOf(e.static_edges), RmseOf(e.disocclusions), absl::StrFormat("%.1f", e.psnr),
                    absl::StrFormat("%.2g", e.relative_mse), absl::StrFormat("%.4f", e.flip_ldr),
                    absl::StrFormat("%.4f", e.flip_hdr),
                    absl::StrFormat("%.4f / %.4f", result.flip_floor.ldr, result.flip_floor.hdr)});
  }
  page.Heading("What a user gets who sets nothing");
  page.Table({"scene", "seconds", "RMSE", "D ± 2 SE", "moving", "static edges", "disocclusions", "PSNR, dB",
              "rel. MSE", "FLIP", "FLIP HDR", "FLIP floor"},
             rows,
             "The default setting of line/slice. RMSE is the root of the unbiased mean squared error D. "
             "Moving: pixels that "
             "see a surface which moves by a pixel or more. Static edges: pixels that see none, and "
             "different colours. "
             "Disocclusions: moving pixels that also see background or another motion. PSNR, relative MSE "
             "and FLIP are "
             "against the mean of the reference's halves and contain its noise; the floor is FLIP of one "
             "half against the "
             "other.");
}

void AddSplitTable(HtmlPage& page, const std::vector<SceneResult>& results) {
  std::vector<std::vector<std::string>> rows;
  for (const SceneResult& result : results) {
    if (!result.split) continue;
    const ErrorSplit& s = *result.split;
    const Interval interval =
        result.truth ? WilsonInterval(result.truth->same, result.truth->samples) : Interval{};
    rows.push_back(
        {result.scene.name, RmseOf(s.total), RmseOf(s.space), RmseOf(s.shade), RmseOf(s.rest),
         result.truth
             ? absl::StrFormat("%.4f %%", 100.0 * double(result.truth->same) / double(result.truth->samples))
             : "–",
         result.truth ? absl::StrFormat("%.4f – %.4f", 100 * interval.low, 100 * interval.high) : "–",
         result.truth ? absl::StrFormat("%.4f %%", 100.0 * double(result.truth->same_or_tied) /
                                                       double(result.truth->samples))
                      : "–",
         result.truth ? absl::StrCat(result.truth->samples) : "–"});
  }
  if (rows.empty()) return;
  page.Heading("Where the error comes from");
  page.Table(
      {"scene", "total", "E space", "E shade", "E rest", "same triangle", "95 % interval", "or tied",
       "samples"},
      rows,
      "Root mean squares, for the default setting. E space: a reference whose points lie on the same "
      "lines, against the "
      "free one: what so few lines cannot see. E shade: from the same points, every pair of triangle "
      "and pixel shaded once. E rest: our picture against that: instants and resolver. Then samples on "
      "the lines at their instants: how often a slice sees the triangle "
      "that a ray sees (strictly; or one as near within 1e-6 of the range of depth), with Wilson's "
      "interval.");
}

void AddCullingTable(HtmlPage& page, const std::vector<SceneResult>& results) {
  std::vector<std::vector<std::string>> rows;
  for (const SceneResult& result : results) {
    const RunRow* row = result.DefaultOf(kOurs);
    if (row == nullptr) continue;
    const engine::RenderStats& s = row->measurement.stats;
    const double tiles = double(std::max<int64_t>(1, s.tiles));
    const auto each = [](int64_t a, int64_t b) {
      return b > 0 ? absl::StrFormat("%.3g", double(a) / double(b)) : "–";
    };
    rows.push_back({result.scene.name, absl::StrCat(result.triangles),
                    absl::StrFormat("%.0f", double(s.candidate_triangles) / tiles),
                    absl::StrFormat("%.3f %%", 100 * double(s.candidate_triangles) / tiles /
                                                   double(std::max<int64_t>(1, result.triangles))),
                    each(s.instants, s.lines), each(s.segments, s.instants), each(s.spans, s.segments),
                    absl::StrFormat("%.2f", double(s.pairs) / (tiles * kTileSize * kTileSize))});
  }
  page.Heading("Culling and sample test efficiency");
  page.Table({"scene", "triangles", "in a tile", "of all", "instants a line", "segments an instant", "STE",
              "pairs a pixel"},
             rows,
             "The default setting. STE, sample test efficiency: visible spans over segments made. “–”: the "
             "method does not "
             "count it.");
}

}  // namespace shutterline::bench
