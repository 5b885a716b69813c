#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cstdio>

#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "common/image/png.h"
#include "tests/bench/commands.h"
#include "tests/bench/csv.h"
#include "tests/bench/html_page.h"
#include "tests/bench/machine.h"

namespace shutterline::bench {
namespace {

constexpr TileRect kCloseUp{480, 64, 96, 96};  // The head of the armadillo; whole tiles.

/// Some tiles of a stack that holds the whole frame.
Image CloseUp(const Image& stack, const TileSubset& whole) {
  Image picture(kCloseUp.width, kCloseUp.height);
  for (size_t i = 0; i < whole.tiles.size(); ++i) {
    const TileRect& tile = whole.tiles[i];
    const int x = tile.x - kCloseUp.x, y = tile.y - kCloseUp.y;
    if (x < 0 || y < 0 || x >= kCloseUp.width || y >= kCloseUp.height) continue;
    for (int row = 0; row < kTileSize; ++row) {
      std::copy_n(stack.At(0, int(i) * kTileSize + row), 4 * kTileSize, picture.At(x, y + row));
    }
  }
  return picture;
}

absl::StatusOr<HtmlPage::Picture> PictureOf(const Image& stack, const TileSubset& whole, std::string label) {
  SL_ASSIGN_OR_RETURN(std::string png, EncodePng(CloseUp(stack, whole)));
  return HtmlPage::Picture{std::move(png), std::move(label), kCloseUp.width, kCloseUp.height};
}

}  // namespace

absl::Status Patterns(const ReportOptions& options) {
  SL_ASSIGN_OR_RETURN(
      std::vector<BenchScene> scenes,
      BenchScenesNamed(options.scenes.empty() ? std::vector<std::string>{"armadillo"} : options.scenes));
  CsvTable table({"commit", "machine", "threads", "scene", "pattern", "runs", "frame_s", "frame_cpu_s", "d",
                  "d_se", "rmse", "rmse_static_edges", "psnr", "flip_ldr"});
  HtmlPage page("Patterns of lines on a still frame");
  page.Paragraph(
      "The shutter is closed, so that the error is that of lines in space alone. After figure 10 of Gribel "
      "et al. 2011.");
  for (BenchScene& scene : scenes) {
    scene.settings.shutter_close = scene.settings.shutter_open;
    SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
    SL_ASSIGN_OR_RETURN(const auto frame_scene,
                        engine::BuildFrameScene(loaded.scene, scene.frame, scene.settings));
    const TileSubset whole = StratifiedTiles(scene.settings.width, scene.settings.height, 1, 1);
    const int spp = options.spp > 0 ? options.spp : options.quick ? 64 : 256;
    SL_ASSIGN_OR_RETURN(const ReferenceHalves reference,
                        RenderReference(frame_scene, scene.frame, scene.settings, whole, spp, options.threads,
                                        {options.cache}));
    SL_ASSIGN_OR_RETURN(const auto probe, PointProbe::Create(frame_scene, scene.settings, options.threads));
    const BenchMasks masks = MakeMasks(*probe, scene.frame, whole, options.threads);
    std::vector<HtmlPage::Picture> pictures;
    std::vector<std::vector<std::string>> rows;
    for (const PatternKind pattern : {PatternKind::k1h1v, PatternKind::k2h2v, PatternKind::kRgls,
                                      PatternKind::k4h4v, PatternKind::k8h8v, PatternKind::k16h16v}) {
      RenderSettings settings = scene.settings;
      settings.pattern = pattern;
      SL_ASSIGN_OR_RETURN(const Measurement m, Measure(loaded.scene, scene.frame, settings, whole,
                                                       {.threads = options.threads, .most_runs = 5}));
      SL_ASSIGN_OR_RETURN(const ErrorFigures e, MeasureErrors(m.pictures, reference, masks, options.threads));
      const std::string name(ToString(pattern));
      const double seconds = options.cpu_clock ? m.FrameCpu() / options.threads : m.FrameWall();
      std::printf("%-12s %-6s %8.3f s  %s  static edges %.5f\n", scene.name.c_str(), name.c_str(), seconds,
                  e.whole.ToString().c_str(), e.static_edges.Rmse());
      table.AddRow({kBuildId, MachineName(), Cell(int64_t{options.threads}), scene.name, name,
                    Cell(int64_t{m.runs}), Cell(m.FrameWall()), Cell(m.FrameCpu()), Cell(e.whole.d),
                    Cell(e.whole.standard_error), Cell(e.whole.Rmse()), Cell(e.static_edges.Rmse()),
                    Cell(e.psnr), Cell(e.flip_ldr)});
      rows.push_back({name, absl::StrFormat("%.3g", seconds), absl::StrFormat("%.5f", e.whole.Rmse()),
                      absl::StrFormat("%.5f", e.static_edges.Rmse()), absl::StrFormat("%.1f", e.psnr),
                      absl::StrFormat("%.5f", e.flip_ldr)});
      SL_ASSIGN_OR_RETURN(HtmlPage::Picture picture, PictureOf(m.pictures.front(), whole, name));
      pictures.push_back(std::move(picture));
    }
    SL_ASSIGN_OR_RETURN(
        HtmlPage::Picture truth,
        PictureOf(reference.Mean(), whole, absl::StrCat("reference, ", spp, " points a pixel")));
    pictures.push_back(std::move(truth));
    page.Heading(scene.name);
    page.Pictures(pictures, 3, "A close-up, three times enlarged.");
    page.Table({"pattern", "seconds", "RMSE", "on edges", "PSNR, dB", "FLIP"}, rows,
               "The whole frame. On edges: pixels that see different colours.");
  }
  page.Heading("How this was measured");
  page.Paragraph(absl::StrCat("Build ", kBuildId, " on ", MachineName(), ", ", options.threads,
                              " threads. All tiles of a frame of 1024 × 768."));
  SL_ASSIGN_OR_RETURN(const std::string csv, OutputPath(options, "patterns.csv"));
  SL_RETURN_IF_ERROR(table.Write(csv));
  SL_ASSIGN_OR_RETURN(const std::string html, OutputPath(options, "patterns.html"));
  return page.Write(html);
}

}  // namespace shutterline::bench
