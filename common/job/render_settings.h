#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/job/occlusion_settings.h"

namespace shutterline {

enum class IntegratorKind { kLine, kReference, kStochastic };
enum class ReferenceLayout { kMotionBvh, kSharedInstants };
/// kAuto: horizontal and vertical lines, as many as the place needs for the error that is aimed at; `rgls`
/// where none is.
enum class PatternKind { kAuto, k1h1v, k2h2v, k4h4v, k8h8v, k16h16v, kRgls };
enum class ResolverKind { kSlice, kPaper };
/// How much of the light near it a pixel takes: see docs/math/line_samples.md, section 8.
enum class FilterKind { kBox, kTriangle, kGaussian, kBlackmanHarris };
/// kAuto: the scene's own lights, or, where it has none, the studio.
enum class LightingKind { kAuto, kScene, kStudio, kHeadlight };
/// What a frame may hold beside its colour: see docs/formats.md for the channels and what they mean.
enum class Aov {
  kDepth,
  kPosition,
  kNormal,
  kMotion,
  kAlbedo,
  kAmbientOcclusion,
  kSamples,
  kObjectId,
  kMaterialId,
};
/// What Cryptomatte makes mattes of.
enum class Matte { kObject, kMaterial };
enum class PixelType { kHalf, kFloat };
enum class ExrCompression { kNone, kZip, kPiz, kDwaa };

/// 52 dB below white: what is left of noise cannot be seen. See docs/performance.md.
inline constexpr double kDefaultTargetError = 0.0025;
/// Pixels of motion between two instants below which nothing is gained.
inline constexpr double kFinestTimeStep = 0.5;

/// How far open the shutter is at a time of it; between two points it changes linearly.
struct ShutterPoint {
  double time = 0;  ///< 0: shutter open, 1: shutter close.
  double opening = 1;

  friend bool operator==(const ShutterPoint&, const ShutterPoint&) = default;
};

/// What decides a frame's pixels. Part of every tile's identity: two renders with equal settings, scene,
/// frame and engine build are equal to the last bit.
struct RenderSettings {
  // --- Camera and time ---------------------------------------------------------------------------
  int width = 1024;  ///< Pixels, 1 to kMaxFrameSide.
  int height = 768;  ///< Pixels, 1 to kMaxFrameSide.
  double fps = 24;   ///< Frames a second of animation; frame f's time is f / fps seconds.
  /// Shutter open and close in frames relative to the frame, as in USD. Open <= close; equal means a still.
  double shutter_open = 0;
  double shutter_close = 0.5;
  /// Weighs the times of the shutter: points at ascending times, the first at 0, the last at 1, whose
  /// openings (0 to kMaxShutterOpening, in any unit) are not all 0; at most kMaxShutterPoints. Empty: open
  /// all the time.
  std::vector<ShutterPoint> shutter_curve;
  /// A camera's name or index in the file. Empty: the file's first camera, or, where there is none, an
  /// automatic one that frames the scene.
  std::string camera;
  /// An animation's name or index, "all" or "none". Empty: the file's first animation.
  std::string animation;
  /// For experiments: if set, everything that moves has motion of exactly this degree, 1 to
  /// kMaxMotionDegree, or exactly so many pieces a shutter, a power of two up to kMaxMotionPieces. Unset:
  /// the least of both that follows the true path.
  std::optional<int> motion_degree;
  std::optional<int> motion_pieces;

  // --- Light -------------------------------------------------------------------------------------
  LightingKind lighting = LightingKind::kAuto;
  /// Radiance that comes from everywhere, beside `lighting`: red, green and blue, 0 to kMaxAmbient. A head
  /// light is alone all the same.
  std::array<double, 3> ambient{0, 0, 0};
  /// Dims `ambient` and what the surroundings give by how much of them a point sees. Unset: it sees all.
  std::optional<OcclusionSettings> occlusion;

  // --- Method ------------------------------------------------------------------------------------
  IntegratorKind integrator = IntegratorKind::kLine;
  PatternKind pattern = PatternKind::kAuto;      ///< Line integrator: which line samples.
  ResolverKind resolver = ResolverKind::kSlice;  ///< Line integrator: how visibility is resolved.
  FilterKind filter = FilterKind::kBox;          ///< Not with resolver `paper` or stochastic: box alone.
  /// How far from its middle a pixel's filter reaches, pixels, kMinFilterRadius to kMaxFilterRadius. Unset:
  /// DefaultFilterRadius.
  std::optional<double> filter_radius;
  /// Line integrator: pixels of motion between two instants of a line; smaller is slower and more exact.
  double time_step = 2.0;
  /// Line integrator: if set, exactly this many instants on every line on which something moves, 1 to
  /// kMaxTimeSamples; `time_step` is then ignored.
  std::optional<int> time_samples;
  /// Resolver `slice`: the error that is aimed at within each tile: the RMS over its pixels and channels,
  /// linear values, kMinTargetError to kMaxTargetError. Instants, and with `auto` lines, are as many as
  /// the difference of half sets asks for (docs/math/effort.md); at most one every kFinestTimeStep pixels, or
  /// every `time_step` pixels where that is less. Unset: as many instants as `time_step` asks for. Ignored
  /// where `time_samples` is set.
  std::optional<double> target_error = kDefaultTargetError;
  /// Resolver `paper`: equal spans of the shutter, 1 to kMaxTimeCells, into which a line's cells are cut.
  int time_cells = 4;
  int spp = 64;       ///< Reference and stochastic integrators: points (x, y, t) a pixel, 1 to kMaxSpp.
  uint64_t seed = 0;  ///< The same two: frames of different seeds are independent estimates.

  /// Reference integrator: whether each ray has a time of its own, or all pixels share `spp` instants, which
  /// is faster, but couples the errors of neighbours.
  ReferenceLayout reference_layout = ReferenceLayout::kMotionBvh;

  // --- Shading -----------------------------------------------------------------------------------
  /// If set, everything is shaded at the centres of texels of its triangles, each once: so many texels a
  /// pixel, along a side, kMinShadingRate to kMaxShadingRate (docs/math/shading_cache.md). Unset: what moves
  /// at a rate of 1, the rest where it is seen; with the reference everything where it is seen, unless it
  /// has ambient occlusion.
  std::optional<double> shading_rate;
  /// For experiments: a texel takes over the first shading that came anywhere within it, as in [gribel2011,
  /// appendix B]. Cheaper; but then pictures depend on which thread comes first.
  bool cache_propagate = false;

  // --- Outputs -----------------------------------------------------------------------------------
  std::vector<Aov> aovs;      ///< Ascending, each at most once.
  std::vector<Matte> mattes;  ///< Likewise: a Cryptomatte of each.
  /// Cryptomatte: the most objects (or materials) that a pixel names, 1 to kMaxMatteRanks. What is more is
  /// left out and counted by RenderStats::matte_overflows.
  int matte_ranks = 6;

  friend bool operator==(const RenderSettings&, const RenderSettings&) = default;
};

/// How a finished frame is written. Does not change what tiles hold (32-bit floats, always).
struct OutputSettings {
  PixelType pixel_type = PixelType::kHalf;
  ExrCompression compression = ExrCompression::kZip;

  friend bool operator==(const OutputSettings&, const OutputSettings&) = default;
};

inline constexpr int kMaxFrameSide = 32768;
inline constexpr int kMaxTimeSamples = 1 << 16;
/// Below the least, instants and lines without end would be asked for; above the greatest, anything will do.
inline constexpr double kMinTargetError = 1e-5;
inline constexpr double kMaxTargetError = 0.5;
/// Of the Bezier curves on which vertices move.
inline constexpr int kMaxMotionDegree = 3;
/// More pieces would hardly be seen: where a path needs them, a warning says by how much it is missed.
inline constexpr int kMaxMotionPieces = 64;
/// A filter that reaches less far would leave light between pixels.
inline constexpr double kMinFilterRadius = 0.5;
/// Tiles are rendered with so much of their neighbours around them.
inline constexpr double kMaxFilterRadius = 4;
inline constexpr int kMaxTimeCells = 64;
inline constexpr double kMaxAmbient = 1e6;
inline constexpr double kMaxShutterOpening = 1e6;
inline constexpr size_t kMaxShutterPoints = 64;
inline constexpr int kMaxSpp = 1 << 20;
inline constexpr double kMinShadingRate = 1.0 / 64;
inline constexpr double kMaxShadingRate = 16;
inline constexpr int kMaxMatteRanks = 32;

/// INVALID_ARGUMENT naming the field, its value and its range, unless every field is within its range and no
/// two are set that exclude each other. Settings of a method that is not used may have any value of their
/// range. Names of cameras and animations are checked against the scene elsewhere.
absl::Status Validate(const RenderSettings& settings);

/// Pixels: box ½, triangle 1, gaussian 1.5, blackman-harris 2.
double DefaultFilterRadius(FilterKind kind);
/// The radius that is set, or the filter's own.
double FilterRadius(const RenderSettings& settings);
/// Is a pixel the mean of just what lies within it? So it is by default.
bool HasPixelBox(const RenderSettings& settings);
/// INVALID_ARGUMENT unless the radius is within its range and the method that is used knows the filter. Part
/// of Validate.
absl::Status ValidateFilter(const RenderSettings& settings);

/// The words of the command line and of EXR headers ("rgls", "slice", "half", ...). Each Parse accepts
/// exactly what ToString returns and otherwise returns nullopt.
absl::string_view ToString(IntegratorKind kind);
absl::string_view ToString(ReferenceLayout layout);
absl::string_view ToString(PatternKind kind);
absl::string_view ToString(ResolverKind kind);
absl::string_view ToString(FilterKind kind);
absl::string_view ToString(LightingKind kind);
absl::string_view ToString(OcclusionFalloff falloff);
absl::string_view ToString(OcclusionPattern pattern);
absl::string_view ToString(Aov aov);
absl::string_view ToString(Matte matte);
absl::string_view ToString(PixelType type);
absl::string_view ToString(ExrCompression compression);
std::optional<IntegratorKind> ParseIntegrator(absl::string_view word);
std::optional<ReferenceLayout> ParseReferenceLayout(absl::string_view word);
std::optional<PatternKind> ParsePattern(absl::string_view word);
std::optional<ResolverKind> ParseResolver(absl::string_view word);
std::optional<FilterKind> ParseFilter(absl::string_view word);
std::optional<LightingKind> ParseLighting(absl::string_view word);
std::optional<OcclusionFalloff> ParseOcclusionFalloff(absl::string_view word);
std::optional<OcclusionPattern> ParseOcclusionPattern(absl::string_view word);
std::optional<Aov> ParseAov(absl::string_view word);
std::optional<Matte> ParseMatte(absl::string_view word);
std::optional<PixelType> ParsePixelType(absl::string_view word);
std::optional<ExrCompression> ParseExrCompression(absl::string_view word);

}  // namespace shutterline
