// One frame by the line integrator, stage by stage, beside the reference integrator: times are printed
// against the error of the very picture that took them, as docs/performance.md asks.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "common/image/exr.h"
#include "common/image/metrics.h"
#include "common/image/png.h"
#include "tests/bench/or_exit.h"
#include "tests/support/engine_frame.h"

namespace shutterline::engine {
namespace {

struct Options {
  std::string scene = "trees";
  std::string camera, animation;
  std::string pattern = "rgls", filter = "box";
  std::string save;
  int width = 1024, height = 768;
  int frame = 0;
  int threads = 1;
  int repeats = 1;
  int half_spp = 0;
  int only_reference = 0;
  double shutter_close = 0.5, fps = 24, time_step = 2;
  int time_samples = 0;
  double target_error = 0, filter_radius = 0;
  std::vector<int> ladder, shared, stochastic;
  std::vector<int> window;
  bool flat = false;
};

void PrintStages(const char* name, const RenderedFrame& f) {
  const RenderStats& s = f.stats;
  std::printf(
      "%-24s scene %.3f s  build %.3f s  render %.3f s  (thread time: cull %.3f  setup %.3f  resolve %.3f  "
      "shade "
      "%.3f)\n",
      name, f.times.scene_seconds, f.times.build_seconds, f.times.render_seconds, s.cull_seconds,
      s.setup_seconds, s.resolve_seconds, s.shade_seconds);
  std::printf(
      "%-24s tiles %lld  candidates %lld  lines %lld  instants %lld  segments %lld  spans %lld  pairs %lld\n",
      "", (long long)s.tiles, (long long)s.candidate_triangles, (long long)s.lines, (long long)s.instants,
      (long long)s.segments, (long long)s.spans, (long long)s.pairs);
}

void PrintError(const char* name, const Image& image, const Image& a, const Image& b,
                const MovingMasks& moving) {
  const UnbiasedError whole = bench::OrExit(MeasureUnbiasedError(image, a, b));
  std::printf("%-24s whole frame: %s\n", name, whole.ToString().c_str());
  for (const auto& [mask, what] :
       {std::pair(&moving.region, "moving region"), {&moving.changed, "changed by motion"}}) {
    const auto error = MeasureUnbiasedError(image, a, b, *mask);
    if (!error.ok()) continue;  // Nothing moves.
    std::printf("%-24s %s (%lld pixels): %s\n", name, what, (long long)error->pixels,
                error->ToString().c_str());
  }
}

FrameOptions HowToRender(const Options& options) {
  FrameOptions how{.threads = options.threads};
  if (options.window.size() == 4) {
    how.window = TileRect{options.window[0], options.window[1], options.window[2], options.window[3]};
  }
  return how;
}

int Run(const Options& options) {
  const FrameOptions how = HowToRender(options);
  std::shared_ptr<const Scene> scene = bench::OrExit(LoadTestScene(options.scene));
  if (options.flat) scene = WithFlatColors(*scene);
  RenderSettings settings;
  settings.width = options.width;
  settings.height = options.height;
  settings.fps = options.fps;
  settings.shutter_close = options.shutter_close;
  settings.camera = options.camera;
  settings.animation = options.animation;
  settings.time_step = options.time_step;
  if (options.time_samples > 0) settings.time_samples = options.time_samples;
  if (options.target_error > 0) settings.target_error = options.target_error;
  const auto pattern = ParsePattern(options.pattern);
  if (!pattern) {
    std::fprintf(stderr, "frame_bench: unknown pattern\n");
    return 2;
  }
  settings.pattern = *pattern;
  const auto filter = ParseFilter(options.filter);
  if (!filter) {
    std::fprintf(stderr, "frame_bench: unknown filter\n");
    return 2;
  }
  settings.filter = *filter;
  if (options.filter_radius > 0) settings.filter_radius = options.filter_radius;

  if (options.only_reference > 0) {
    settings.integrator = IntegratorKind::kReference;
    settings.spp = options.only_reference;
    const RenderedFrame f = bench::OrExit(RenderFrame(scene, options.frame, settings, how));
    PrintStages("reference", f);
    if (!options.save.empty()) (void)WritePng(options.save + ".png", f.image);
    return 0;
  }
  RenderedFrame line;
  for (int i = 0; i < options.repeats; ++i) {
    line = bench::OrExit(RenderFrame(scene, options.frame, settings, how));
    PrintStages("line", line);
  }
  for (const std::string& warning : line.warnings) std::printf("warning: %s\n", warning.c_str());
  if (!options.save.empty()) {
    (void)WritePng(options.save + "_line.png", line.image);
    (void)WriteExr(options.save + "_line.exr", line.image, OutputSettings{.pixel_type = PixelType::kFloat},
                   {});
  }
  if (options.half_spp == 0) return 0;

  RenderSettings reference = settings;
  reference.integrator = IntegratorKind::kReference;
  reference.spp = options.half_spp;
  reference.seed = 101;
  const RenderedFrame a = bench::OrExit(RenderFrame(scene, options.frame, reference, how));
  reference.seed = 202;
  const RenderedFrame b = bench::OrExit(RenderFrame(scene, options.frame, reference, how));
  PrintStages("reference, one half", a);
  const auto moving = bench::OrExit(MaskMotion(scene, options.frame, settings, how));
  PrintError("line", line.image, a.image, b.image, moving);
  if (!options.save.empty()) (void)WritePng(options.save + "_reference.png", a.image);
  struct Rival {
    const char* name;
    IntegratorKind integrator;
    ReferenceLayout layout;
    const std::vector<int>& ladder;
  };
  for (const auto& [what, integrator, layout, ladder] :
       {Rival{"reference", IntegratorKind::kReference, ReferenceLayout::kMotionBvh, options.ladder},
        Rival{"shared instants", IntegratorKind::kReference, ReferenceLayout::kSharedInstants,
              options.shared},
        Rival{"stochastic", IntegratorKind::kStochastic, ReferenceLayout::kMotionBvh, options.stochastic}}) {
    RenderSettings rival = reference;
    rival.integrator = integrator;
    rival.reference_layout = layout;
    rival.seed = 303;
    for (const int spp : ladder) {
      rival.spp = spp;
      const std::clock_t start = std::clock();
      const RenderedFrame frame = bench::OrExit(RenderFrame(scene, options.frame, rival, how));
      const double cpu_seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
      const std::string name = std::string(what) + ", " + std::to_string(spp) + " spp";
      PrintStages(name.c_str(), frame);
      std::printf("%-24s processor time of all stages %.3f s, %.1f ns a sample\n", name.c_str(), cpu_seconds,
                  1e9 * cpu_seconds / (double(frame.image.width()) * frame.image.height() * spp));
      PrintError(name.c_str(), frame.image, a.image, b.image, moving);
    }
  }
  return 0;
}

}  // namespace
}  // namespace shutterline::engine

int main(int argc, char** argv) {
  shutterline::engine::Options o;
  CLI::App app("Time and error of one frame by the line integrator and the reference.");
  app.add_option("scene", o.scene, "A file, or the name of a generated scene");
  app.add_option("--width", o.width, "Pixels");
  app.add_option("--height", o.height, "Pixels");
  app.add_option("--frame", o.frame, "Frame");
  app.add_option("--fps", o.fps, "Frames a second");
  app.add_option("--shutter-close", o.shutter_close, "Frames");
  app.add_option("--camera", o.camera, "Name or index");
  app.add_option("--animation", o.animation, "Name, index, all or none");
  app.add_option("--window", o.window, "Only this part of the frame: x, y, width, height")->expected(4);
  app.add_option("--pattern", o.pattern, "1h1v, 2h2v, 4h4v, 8h8v, 16h16v or rgls");
  app.add_option("--filter", o.filter, "box, triangle, gaussian or blackman-harris");
  app.add_option("--filter-radius", o.filter_radius, "Pixels; 0: the filter's own");
  app.add_option("--time-step", o.time_step, "Pixels of motion an instant");
  app.add_option("--time-samples", o.time_samples, "Instants on every moving line; 0: by motion");
  app.add_option("--target-error", o.target_error, "RMS error aimed at within a tile; 0: by motion");
  app.add_option("--threads", o.threads, "Threads");
  app.add_option("--repeats", o.repeats, "How often the line integrator renders");
  app.add_option("--half-spp", o.half_spp, "Points a pixel of each half of the reference; 0: no reference");
  app.add_option("--only-reference", o.only_reference, "Nothing but the reference, at these points a pixel");
  app.add_option("--ladder", o.ladder, "Also time the reference at these points a pixel");
  app.add_option("--shared", o.shared, "The same with instants that all pixels share");
  app.add_option("--stochastic", o.stochastic, "Also time the stochastic integrator at these points a pixel");
  app.add_flag("--flat", o.flat, "Unlit flat colours instead of the scene's materials");
  app.add_option("--save", o.save, "Prefix of pictures to write");
  CLI11_PARSE(app, argc, argv);
  return shutterline::engine::Run(o);
}
