#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/atomic_file.h"
#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "tests/bench/commands.h"
#include "tests/bench/csv.h"
#include "tests/bench/html_page.h"
#include "tests/bench/machine.h"
#include "tests/bench/svg_plot.h"
#include "tests/bench/wilson.h"

namespace shutterline::bench {
namespace {

constexpr int kBinsPerDecade = 2, kDecades = 8;  // Down to 1e-8; what is below stands in the last bin.

/// Fractions of the samples by the magnitude of their error, largest first.
std::vector<double> Histogram(const std::vector<float>& errors) {
  std::vector<double> bins(size_t{kBinsPerDecade} * kDecades);
  for (const float error : errors) {
    const double place = -std::log10(std::max(double(error), 1e-30)) * kBinsPerDecade;
    bins[size_t(std::clamp(place, 0.0, double(bins.size()) - 1))] += 1.0 / double(errors.size());
  }
  return bins;
}

}  // namespace

absl::Status DepthError(const ReportOptions& options) {
  const std::vector<std::string> names =
      options.scenes.empty()
          ? (options.quick ? std::vector<std::string>{"chess"}
                           : std::vector<std::string>{"chess", "armadillo", "hall", "trees"})
          : options.scenes;
  SL_ASSIGN_OR_RETURN(const std::vector<BenchScene> scenes, BenchScenesNamed(names));
  CsvTable table({"commit", "machine", "scene", "resolver", "samples", "visible_same", "error_from",
                  "error_to", "fraction"});
  Plot plot{.title = "Errors of depth",
            .x = {"|z − z of the ray| / (far − near)", true},
            .y = {"fraction of the samples", true},
            .width = 720,
            .height = 400};
  std::vector<std::vector<std::string>> rows;
  for (size_t i = 0; i < scenes.size(); ++i) {
    const BenchScene& scene = scenes[i];
    SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
    SL_ASSIGN_OR_RETURN(const auto frame_scene,
                        engine::BuildFrameScene(loaded.scene, scene.frame, scene.settings));
    SL_ASSIGN_OR_RETURN(const auto probe, PointProbe::Create(frame_scene, scene.settings, options.threads));
    const TileSubset subset = StratifiedTiles(scene.settings.width, scene.settings.height, options.Side(), 5);
    SL_ASSIGN_OR_RETURN(const double vector_difference,
                        MeasureVectorDifference(*frame_scene, scene.settings, subset, options.threads));
    for (const Sight sight : {Sight::kSlices, Sight::kPatches}) {
      const bool slices = sight == Sight::kSlices;
      const std::string resolver = slices ? "slice" : "paper";
      SL_ASSIGN_OR_RETURN(const LineTruth truth,
                          MeasureLineTruth(*probe, scene.settings, subset, options.quick ? 250000 : 1100000,
                                           64, options.threads, sight));
      const double below = double(std::count_if(truth.depth_errors.begin(), truth.depth_errors.end(),
                                                [](float error) { return error < 1e-3f; }));
      const Interval same = WilsonInterval(truth.same, truth.samples);
      const double fraction = below / double(std::max<size_t>(1, truth.depth_errors.size()));
      const std::string vectors = slices ? absl::StrFormat("%.3g %%", 100 * vector_difference) : "";
      std::printf(
          "%-12s %s %lld samples, %.5f %% of depths within 0.1 %% of the range; the same triangle in %.5f %% "
          "(%.5f to %.5f)%s\n",
          scene.name.c_str(), resolver.c_str(), static_cast<long long>(truth.samples), 100 * fraction,
          100 * double(truth.same) / double(truth.samples), 100 * same.low, 100 * same.high,
          slices ? absl::StrCat("; vectors differ in ", vectors).c_str() : "");
      std::fflush(stdout);
      const std::vector<double> bins = Histogram(truth.depth_errors);
      PlotSeries series{.label = absl::StrCat(scene.name, ", ", resolver),
                        .color = PlotColors()[(2 * i + (slices ? 0 : 1)) % PlotColors().size()]};
      for (size_t k = 0; k < bins.size(); ++k) {
        const double to = std::pow(10, -double(k) / kBinsPerDecade),
                     from = std::pow(10, -double(k + 1) / kBinsPerDecade);
        table.AddRow({kBuildId, MachineName(), scene.name, resolver, Cell(truth.samples), Cell(truth.same),
                      Cell(from), Cell(to), Cell(bins[k])});
        if (bins[k] > 0) series.points.push_back({std::sqrt(from * to), bins[k]});
      }
      series.line = series.points;
      plot.series.push_back(std::move(series));
      rows.push_back({scene.name, resolver, absl::StrCat(truth.samples),
                      absl::StrFormat("%.4f %%", 100 * fraction),
                      absl::StrFormat("%.4f %%", 100 * double(truth.same) / double(truth.samples)),
                      absl::StrFormat("%.4f – %.4f", 100 * same.low, 100 * same.high), vectors});
    }
  }
  HtmlPage page("Errors of depth");
  page.Paragraph(
      "Samples on the line samples, for slices at their instants, for patches at any time: the depth that is "
      "seen against that of a ray, over the range of depths that rays meet. After figure 15 of Gribel et al. "
      "2011, where 99.82 % were within 0.1 "
      "% "
      "of the range, 99.95 % with three subdivisions.");
  const std::string svg = RenderPlot(plot);
  SL_ASSIGN_OR_RETURN(const std::string path, OutputPath(options, "depth_error.svg"));
  SL_RETURN_IF_ERROR(WriteFileAtomically(path, svg));
  page.Figures({svg}, "Histogram with two bins a decade; what is below 1e-8 stands in the last.");
  page.Table(
      {"scene", "resolver", "samples", "within 0.1 %", "same triangle", "95 % interval", "vectors differ"},
      rows,
      "Slices by the plain kernels (segment, envelope); how much of the picture the vector resolver gives "
      "to other triangles than they do stands in the last column. Patches of the resolver paper at its "
      "defaults. Depths are compared where both see a surface; errors of about 1e-7 are the ray's own, "
      "which is traced in single precision.");
  page.Heading("How this was measured");
  page.Paragraph(Provenance(options));
  SL_ASSIGN_OR_RETURN(const std::string csv, OutputPath(options, "depth_error.csv"));
  SL_RETURN_IF_ERROR(table.Write(csv));
  SL_ASSIGN_OR_RETURN(const std::string html, OutputPath(options, "depth_error.html"));
  return page.Write(html);
}

}  // namespace shutterline::bench
