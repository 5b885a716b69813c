#include "client/options.h"

#include <absl/strings/str_cat.h>

#include <bit>
#include <cmath>
#include <utility>

#include "client/frame_range.h"
#include "client/parse.h"
#include "client/parse_outputs.h"
#include "client/template_file.h"
#include "common/base/ids.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

constexpr double kMaxShutterFrames = 1e6;  // As Validate(RenderSettings).
constexpr size_t kMaxNameBytes = 1024;

/// Keeps a parsed value, or hands on why there is none.
template <typename T, typename Target>
absl::Status Store(absl::StatusOr<T> value, Target& target) {
  if (!value.ok()) return value.status();
  target = static_cast<Target>(*std::move(value));
  return absl::OkStatus();
}

template <typename Enum>
absl::Status StoreWord(std::optional<Enum> value, Enum& target, absl::string_view allowed) {
  if (!value) return absl::InvalidArgumentError(absl::StrCat("must be ", allowed));
  target = *value;
  return absl::OkStatus();
}

absl::Status StoreName(const std::string& text, std::string& target, absl::string_view allowed) {
  if (text.empty() || text.size() > kMaxNameBytes || text.find('\0') != std::string::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat("must be ", allowed, ", of 1 to ", kMaxNameBytes, " bytes"));
  }
  target = text;
  return absl::OkStatus();
}

void AddTimeOptions(CLI::App& app, JobOptions& o) {
  auto* frame = AddValue(app, "--frame", "N", "1", "The frame to render; its time is N / fps seconds",
                         [&](const std::string& t) { return Store(ParseFrame(t), o.frames); });
  auto* frames =
      AddValue(app, "--frames", "A-B[xS]", "", "The frames A to B, every S-th of them, as in 1-48 or 1-48x2",
               [&](const std::string& t) { return Store(ParseFrameRange(t), o.frames); });
  auto* fps = AddValue(
      app, "--fps", "FRAMES/S", "24", "Frames a second of animation, above 0", [&](const std::string& t) {
        return Store(ParseReal(t, 1e-6, 1e6, "a number from 0.000001 to 1000000"), o.settings.fps);
      });
  auto* open = AddValue(app, "--shutter-open", "FRAMES", "0",
                        "When the shutter opens, in frames relative to the frame", [&](const std::string& t) {
                          return Store(ParseReal(t, -kMaxShutterFrames, kMaxShutterFrames,
                                                 "a number of frames from -1000000 to 1000000"),
                                       o.settings.shutter_open);
                        });
  auto* close = AddValue(app, "--shutter-close", "FRAMES", "0.5",
                         "When it closes; equal to --shutter-open: a still", [&](const std::string& t) {
                           o.shutter_close_given = true;
                           return Store(ParseReal(t, -kMaxShutterFrames, kMaxShutterFrames,
                                                  "a number of frames from -1000000 to 1000000"),
                                        o.settings.shutter_close);
                         });
  auto* curve =
      AddValue(app, "--shutter-curve", "box|triangle|trapezoid|decay|T:A,...", "box",
               "How far the shutter is open from 0 (open) to 1 (close);\nor points, as in 0:0,0.25:1,1:0",
               [&](const std::string& t) { return Store(ParseShutterCurve(t), o.settings.shutter_curve); });
  auto* animation = AddValue(app, "--animation", "NAME|INDEX|all|none", "the first",
                             "Which of the file's animations moves the scene", [&](const std::string& t) {
                               return StoreName(t, o.settings.animation, "a name, an index, all or none");
                             });
  frame->excludes(frames);
  frames->excludes(frame);
  for (CLI::Option* option : {frame, frames, fps, open, close, curve, animation}) option->group("Time");
}

void AddPictureOptions(CLI::App& app, JobOptions& o) {
  auto* size =
      AddValue(app, "--size", "WxH", "1024x768",
               absl::StrCat("Width and height, pixels, 1 to ", kMaxFrameSide), [&](const std::string& t) {
                 SL_ASSIGN_OR_RETURN(const FrameSize parsed, ParseFrameSize(t));
                 o.settings.width = parsed.width;
                 o.settings.height = parsed.height;
                 return absl::OkStatus();
               });
  auto* camera = AddValue(
      app, "--camera", "NAME|INDEX", "the first",
      "Which of the file's cameras; where a file has none,\nthe scene is framed",
      [&](const std::string& t) { return StoreName(t, o.settings.camera, "a camera's name or index"); });
  for (CLI::Option* option : {size, camera}) option->group("Picture");
}

/// The pattern of so many lines a pixel that serves most pictures best.
std::optional<PatternKind> PatternOfLines(int64_t lines) {
  switch (lines) {
    case 2:
      return PatternKind::k1h1v;
    case 4:
      return PatternKind::kRgls;
    case 8:
      return PatternKind::k4h4v;
    case 16:
      return PatternKind::k8h8v;
    case 32:
      return PatternKind::k16h16v;
  }
  return std::nullopt;
}

CLI::Option* AddLinesOption(CLI::App& app, RenderSettings& s) {
  auto* lines = AddValue(
      app, "--lines", "2|4|8|16|32", "",
      "Lines through each pixel: --pattern 1h1v, rgls, 4h4v,\n8h8v or 16h16v", [&s](const std::string& t) {
        const absl::StatusOr<int64_t> count = ParseWhole(t, 2, 32);
        return StoreWord(count.ok() ? PatternOfLines(*count) : std::nullopt, s.pattern, "2, 4, 8, 16 or 32");
      });
  lines->group("Experiments");
  return lines;
}

void AddLightOptions(CLI::App& app, JobOptions& o) {
  RenderSettings& s = o.settings;
  auto* lighting =
      AddValue(app, "--lighting", "auto|scene|studio|headlight", "auto",
               "auto: the scene's own lights, or a studio where it has\nnone; headlight: one at the camera",
               [&](const std::string& t) {
                 return StoreWord(ParseLighting(t), s.lighting, "auto, scene, studio or headlight");
               });
  auto* ambient =
      AddValue(app, "--ambient", "R,G,B", "0,0,0", "Radiance that comes from everywhere, linear",
               [&](const std::string& t) { return Store(ParseColor(t, kMaxAmbient), s.ambient); });
  auto* environment =
      AddValue(app, "--environment", "FILE.exr", "",
               "A picture of latitude and longitude that lights the scene\n(for --lighting auto and scene)",
               [&](const std::string& t) { return StoreName(t, o.environment, "a file's path"); });
  auto* occlusion =
      AddValue(app, "--ao", "on|KEY=VALUE,...", "off",
               "Ambient occlusion: lines=16 (a point), radius=METRES,\nfalloff=none|linear|quadratic, "
               "pattern=pole|tilted,\nmotion=on|off (over the shutter, or at its middle)",
               [&](const std::string& t) { return Store(ParseOcclusion(t), s.occlusion); });
  for (CLI::Option* option : {lighting, ambient, environment, occlusion}) option->group("Light");
}

void AddShadingOptions(CLI::App& app, JobOptions& o) {
  RenderSettings& s = o.settings;
  auto* rate = AddValue(
      app, "--shading-rate", "R", "1 for what moves",
      "Shadings a pixel, along a side. Unless it is given, what\nstands still is shaded just where "
      "it is seen",
      [&](const std::string& t) {
        return Store(ParseReal(t, kMinShadingRate, kMaxShadingRate,
                               absl::StrCat("a number from ", kMinShadingRate, " to ", kMaxShadingRate)),
                     s.shading_rate);
      });
  rate->group("Method");
  app.add_flag(
         "--cache-propagate", s.cache_propagate,
         "Let coarse shadings take over the first fine one: faster,\nbut pictures then depend on threads")
      ->group("Experiments");
}

void AddOutputOptions(CLI::App& app, JobOptions& o) {
  RenderSettings& s = o.settings;
  auto* aovs = AddValue(app, "--aov", "NAME,...", "",
                        "What else the EXR holds: depth, position, normal, motion,\nalbedo, ao, samples, "
                        "object-id, material-id",
                        [&](const std::string& t) { return Store(ParseAovs(t), s.aovs); });
  auto* mattes = AddValue(app, "--cryptomatte", "object,material", "", "Cryptomattes, with exact coverage",
                          [&](const std::string& t) { return Store(ParseMattes(t), s.mattes); });
  auto* ranks =
      AddValue(app, "--cryptomatte-ranks", "N", absl::StrCat(s.matte_ranks),
               absl::StrCat("Ids that a pixel of a Cryptomatte names at most, 1 to ", kMaxMatteRanks),
               [&](const std::string& t) { return Store(ParseWhole(t, 1, kMaxMatteRanks), s.matte_ranks); });
  for (CLI::Option* option : {aovs, mattes, ranks}) option->group("Output");
}

void AddMethodOptions(CLI::App& app, JobOptions& o) {
  RenderSettings& s = o.settings;
  auto* integrator =
      AddValue(app, "--integrator", "line|reference|stochastic", "line",
               "line: analytic along line samples; reference: rays at\npoints in pixel and time (ground "
               "truth); stochastic:\n"
               "moving triangles rasterized at such points",
               [&](const std::string& t) {
                 return StoreWord(ParseIntegrator(t), s.integrator, "line, reference or stochastic");
               });
  auto* pattern =
      AddValue(app, "--pattern", "auto|1h1v|2h2v|4h4v|8h8v|16h16v|rgls", "auto",
               "Lines through each pixel: horizontal and vertical,\nor a rotated grid; auto: as many of the "
               "former as\nthe place needs",
               [&](const std::string& t) {
                 return StoreWord(ParsePattern(t), s.pattern, "auto, 1h1v, 2h2v, 4h4v, 8h8v, 16h16v or rgls");
               });
  auto* resolver = AddValue(
      app, "--resolver", "slice|paper", "slice",
      "How visibility is resolved on a line: slice is exact along\nthe line at each instant; paper "
      "resolves patches over the\nshutter",
      [&](const std::string& t) { return StoreWord(ParseResolver(t), s.resolver, "slice or paper"); });
  auto* filter =
      AddValue(app, "--filter", "box|triangle|gaussian|blackman-harris", "box",
               "How much of the light near it a pixel takes", [&](const std::string& t) {
                 return StoreWord(ParseFilter(t), s.filter, "box, triangle, gaussian or blackman-harris");
               });
  auto* filter_radius = AddValue(
      app, "--filter-radius", "PIXELS", "by --filter",
      absl::StrCat("How far the filter reaches from a pixel's middle, ", kMinFilterRadius, " to\n",
                   kMaxFilterRadius, "; box 0.5, triangle 1, gaussian 1.5, blackman-harris 2"),
      [&](const std::string& t) {
        return Store(
            ParseReal(t, kMinFilterRadius, kMaxFilterRadius,
                      absl::StrCat("a number of pixels from ", kMinFilterRadius, " to ", kMaxFilterRadius)),
            s.filter_radius);
      });
  auto* time_cells = AddValue(
      app, "--time-cells", "N", "4", absl::StrCat("paper: equal spans of the shutter, 1 to ", kMaxTimeCells),
      [&](const std::string& t) { return Store(ParseWhole(t, 1, kMaxTimeCells), s.time_cells); });
  auto* time_step = AddValue(
      app, "--time-step", "PIXELS", "by --target-error",
      "Motion between two instants of a line; smaller is slower\nand more exact", [&](const std::string& t) {
        o.time_step_given = true;
        return Store(ParseReal(t, 1e-3, 1e6, "a number of pixels from 0.001 to 1000000"), s.time_step);
      });
  auto* time_samples = AddValue(
      app, "--time-samples", "N", "by --target-error",
      absl::StrCat("Exactly N instants on a line where something moves,\n1 to ", kMaxTimeSamples),
      [&](const std::string& t) { return Store(ParseWhole(t, 1, kMaxTimeSamples), s.time_samples); });
  auto* target_error = AddValue(
      app, "--target-error", "E", absl::StrCat(kDefaultTargetError),
      absl::StrCat("Error aimed at in each tile: RMS of linear values, ", kMinTargetError, "\nto ",
                   kMaxTargetError,
                   "; decides how many instants lines have, and how\nmany lines pixels have where "
                   "nothing moves. Resolver\nslice alone"),
      [&](const std::string& t) {
        o.target_error_given = true;
        return Store(ParseReal(t, kMinTargetError, kMaxTargetError,
                               absl::StrCat("a number from ", kMinTargetError, " to ", kMaxTargetError)),
                     s.target_error);
      });
  auto* spp =
      AddValue(app, "--spp", "N", "64", absl::StrCat("reference, stochastic: points a pixel, 1 to ", kMaxSpp),
               [&](const std::string& t) { return Store(ParseWhole(t, 1, kMaxSpp), s.spp); });
  auto* seed =
      AddValue(app, "--seed", "N", "0", "reference, stochastic: pictures of different seeds are\nindependent",
               [&](const std::string& t) { return Store(ParseUnsigned(t), s.seed); });
  auto* layout = AddValue(app, "--reference-layout", "motion-bvh|shared-instants", "motion-bvh",
                          "reference: a time of its own for each ray, or instants\nthat all pixels share: "
                          "faster, few of them show",
                          [&](const std::string& t) {
                            return StoreWord(ParseReferenceLayout(t), s.reference_layout,
                                             "motion-bvh or shared-instants");
                          });
  time_step->excludes(time_samples);
  time_samples->excludes(time_step);
  target_error->excludes(time_samples);
  time_samples->excludes(target_error);
  AddLinesOption(app, s)->excludes(pattern);
  for (CLI::Option* option : {integrator, pattern, resolver, filter, filter_radius, time_cells, time_step,
                              time_samples, target_error, spp, seed, layout}) {
    option->group("Method");
  }
}

void AddExperimentOptions(CLI::App& app, JobOptions& o) {
  RenderSettings& s = o.settings;
  auto* degree = AddValue(
      app, "--motion-degree", "1|2|3", "as needed", "Motion curves of exactly this degree",
      [&](const std::string& t) { return Store(ParseWhole(t, 1, kMaxMotionDegree), s.motion_degree); });
  auto* pieces = AddValue(app, "--motion-pieces", "N", "as needed",
                          absl::StrCat("Motion curves in exactly N pieces of the shutter, a\npower of two "
                                       "from 1 to ",
                                       kMaxMotionPieces),
                          [&](const std::string& t) {
                            int value = 0;
                            SL_RETURN_IF_ERROR(Store(ParseWhole(t, 1, kMaxMotionPieces), value));
                            if (!std::has_single_bit(unsigned(value))) {
                              return absl::InvalidArgumentError("must be a power of two");
                            }
                            s.motion_pieces = value;
                            return absl::OkStatus();
                          });
  for (CLI::Option* option : {degree, pieces}) option->group("Experiments");
}

void AddFileOptions(CLI::App& app, JobOptions& o) {
  auto* half = app.add_flag("--half", o.half_given, "16-bit floats in the EXR (the default)");
  auto* full = app.add_flag("--float", o.float_given, "32-bit floats in the EXR");
  auto* compression = AddValue(
      app, "--compression", "none|zip|piz|dwaa", "zip", "The EXR's compression; dwaa alone loses precision",
      [&](const std::string& t) {
        return StoreWord(ParseExrCompression(t), o.output_settings.compression, "none, zip, piz or dwaa");
      });
  auto* png = app.add_flag("--png", o.png, "Also write an 8-bit sRGB preview, x.png beside x.exr");
  half->excludes(full);
  full->excludes(half);
  for (CLI::Option* option : {half, full, compression, png}) option->group("Output");
}

}  // namespace

void AddSceneArgument(CLI::App& app, std::string& scene) {
  AddValue(app, "SCENE", "", "", "The scene: a glTF 2.0 file, .gltf or .glb",
           [&scene](const std::string& text) {
             if (text.empty() || text.find('\0') != std::string::npos) {
               return absl::InvalidArgumentError("must be the path of a file");
             }
             scene = text;
             return absl::OkStatus();
           })
      ->required();
}

void AddJobOptions(CLI::App& app, JobOptions& options) {
  AddSceneArgument(app, options.scene);
  // RunCommandLine has put the template's options among the arguments by the time they are parsed.
  AddValue(app, kTemplateOption, "FILE", "",
           "Options that many jobs share, one a line, as in size = 1920x1080;\n"
           "those given here overrule it",
           [](const std::string&) { return absl::OkStatus(); });
  AddOutputOption(app, options.output,
                  "Where frames go; #### stands for the frame's number.\nWithout #s, several frames are "
                  "numbered before .exr");
  AddTimeOptions(app, options);
  AddPictureOptions(app, options);
  AddLightOptions(app, options);
  AddMethodOptions(app, options);
  AddShadingOptions(app, options);
  AddExperimentOptions(app, options);
  AddOutputOptions(app, options);
  AddFileOptions(app, options);
}

absl::Status CheckJobOptions(JobOptions& options) {
  RenderSettings& s = options.settings;
  if (s.shutter_close < s.shutter_open) {
    return absl::InvalidArgumentError(
        absl::StrCat("--shutter-close ", s.shutter_close, options.shutter_close_given ? "" : " (the default)",
                     ": must not be less than --shutter-open ", s.shutter_open));
  }
  if (options.target_error_given && s.integrator != IntegratorKind::kLine) {
    return absl::InvalidArgumentError(absl::StrCat("--target-error ", *s.target_error,
                                                   ": means nothing to --integrator ", ToString(s.integrator),
                                                   ", whose error is set by --spp"));
  }
  if (options.target_error_given && s.resolver == ResolverKind::kPaper) {
    return absl::InvalidArgumentError(
        absl::StrCat("--target-error ", *s.target_error,
                     ": means nothing to --resolver paper, whose error is set by "
                     "--pattern and --time-cells"));
  }
  // Who says how instants are placed does not want them placed by an error that nobody asked for.
  if ((options.time_step_given || s.time_samples) && !options.target_error_given) s.target_error.reset();
  if (!s.mattes.empty() && options.output_settings.compression == ExrCompression::kDwaa) {
    return absl::InvalidArgumentError("--compression dwaa: would damage the ids of --cryptomatte");
  }
  options.output_settings.pixel_type = options.float_given ? PixelType::kFloat : PixelType::kHalf;
  return Validate(s);
}

void AddOutputOption(CLI::App& app, std::optional<OutputPath>& output, const std::string& description) {
  AddValue(app, "-o,--output", "PATH.exr", "", description, [&output](const std::string& text) {
    SL_ASSIGN_OR_RETURN(OutputPath path, OutputPath::Parse(text));
    output = std::move(path);
    return absl::OkStatus();
  })->group("Output");
}

void AddJsonOption(CLI::App& app, bool& json) {
  app.add_flag("--json", json, "Print facts as one JSON document");
}

void AddQuietOption(CLI::App& app, bool& quiet) {
  app.add_flag("-q,--quiet", quiet, "No progress, errors alone");
}

void AddStatsOption(CLI::App& app, bool& stats) {
  app.add_flag("--stats", stats, "Also print what rendering took: instants, spans, seconds by\nstage");
}

ProgressStyle ChooseStyle(const Console& console, bool quiet) {
  if (quiet) return ProgressStyle::kQuiet;
  return console.err_is_terminal ? ProgressStyle::kBar : ProgressStyle::kLines;
}

void AddJobArgument(CLI::App& app, std::string& job) {
  AddValue(app, "JOB", "", "", "The job's id, as submit and list print it", [&job](const std::string& text) {
    if (!IsUuid(text)) {
      return absl::InvalidArgumentError("must be a job's whole id, as 'shutterline list' prints it");
    }
    job = text;
    return absl::OkStatus();
  })->required();
}

}  // namespace shutterline::client
