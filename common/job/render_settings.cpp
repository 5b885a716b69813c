#include "common/job/render_settings.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "common/base/status_macros.h"

namespace shutterline {
namespace {

template <typename Enum, size_t N>
using Words = std::array<std::pair<Enum, absl::string_view>, N>;

constexpr Words<IntegratorKind, 3> kIntegrators{{{IntegratorKind::kLine, "line"},
                                                 {IntegratorKind::kReference, "reference"},
                                                 {IntegratorKind::kStochastic, "stochastic"}}};
constexpr Words<ReferenceLayout, 2> kReferenceLayouts{
    {{ReferenceLayout::kMotionBvh, "motion-bvh"}, {ReferenceLayout::kSharedInstants, "shared-instants"}}};
constexpr Words<PatternKind, 7> kPatterns{{{PatternKind::kAuto, "auto"},
                                           {PatternKind::k1h1v, "1h1v"},
                                           {PatternKind::k2h2v, "2h2v"},
                                           {PatternKind::k4h4v, "4h4v"},
                                           {PatternKind::k8h8v, "8h8v"},
                                           {PatternKind::k16h16v, "16h16v"},
                                           {PatternKind::kRgls, "rgls"}}};
constexpr Words<ResolverKind, 2> kResolvers{
    {{ResolverKind::kSlice, "slice"}, {ResolverKind::kPaper, "paper"}}};
constexpr Words<FilterKind, 4> kFilters{{{FilterKind::kBox, "box"},
                                         {FilterKind::kTriangle, "triangle"},
                                         {FilterKind::kGaussian, "gaussian"},
                                         {FilterKind::kBlackmanHarris, "blackman-harris"}}};
constexpr Words<LightingKind, 4> kLightings{{{LightingKind::kAuto, "auto"},
                                             {LightingKind::kScene, "scene"},
                                             {LightingKind::kStudio, "studio"},
                                             {LightingKind::kHeadlight, "headlight"}}};
constexpr Words<OcclusionFalloff, 3> kFalloffs{{{OcclusionFalloff::kNone, "none"},
                                                {OcclusionFalloff::kLinear, "linear"},
                                                {OcclusionFalloff::kQuadratic, "quadratic"}}};
constexpr Words<OcclusionPattern, 2> kOcclusionPatterns{
    {{OcclusionPattern::kPole, "pole"}, {OcclusionPattern::kTilted, "tilted"}}};
constexpr Words<Aov, 9> kAovs{{{Aov::kDepth, "depth"},
                               {Aov::kPosition, "position"},
                               {Aov::kNormal, "normal"},
                               {Aov::kMotion, "motion"},
                               {Aov::kAlbedo, "albedo"},
                               {Aov::kAmbientOcclusion, "ao"},
                               {Aov::kSamples, "samples"},
                               {Aov::kObjectId, "object-id"},
                               {Aov::kMaterialId, "material-id"}}};
constexpr Words<Matte, 2> kMattes{{{Matte::kObject, "object"}, {Matte::kMaterial, "material"}}};
constexpr Words<PixelType, 2> kPixelTypes{{{PixelType::kHalf, "half"}, {PixelType::kFloat, "float"}}};
constexpr Words<ExrCompression, 4> kCompressions{{{ExrCompression::kNone, "none"},
                                                  {ExrCompression::kZip, "zip"},
                                                  {ExrCompression::kPiz, "piz"},
                                                  {ExrCompression::kDwaa, "dwaa"}}};

template <typename Enum, size_t N>
absl::string_view WordOf(const Words<Enum, N>& words, Enum value) {
  for (const auto& [candidate, word] : words) {
    if (candidate == value) return word;
  }
  return "unknown";
}

template <typename Enum, size_t N>
std::optional<Enum> ValueOf(const Words<Enum, N>& words, absl::string_view word) {
  for (const auto& [value, candidate] : words) {
    if (candidate == word) return value;
  }
  return std::nullopt;
}

absl::Status OutOfRange(absl::string_view field, double value, absl::string_view range) {
  return absl::InvalidArgumentError(
      absl::StrCat("render settings: ", field, " is ", value, ", but must be ", range));
}

absl::Status ValidateShutterCurve(const std::vector<ShutterPoint>& curve) {
  if (curve.empty()) return absl::OkStatus();
  const auto wrong = [](size_t i, absl::string_view why) {
    return absl::InvalidArgumentError(absl::StrCat("render settings: shutter_curve[", i, "]: ", why));
  };
  if (curve.size() < 2 || curve.size() > kMaxShutterPoints) {
    return absl::InvalidArgumentError(absl::StrCat("render settings: shutter_curve has ", curve.size(),
                                                   " points, but must have none or 2 to ",
                                                   kMaxShutterPoints));
  }
  double most = 0;
  for (size_t i = 0; i < curve.size(); ++i) {
    const bool in_order = i == 0 ? curve[i].time == 0 : curve[i].time > curve[i - 1].time;
    if (!in_order) return wrong(i, "times must ascend from 0");
    if (!(curve[i].opening >= 0 && curve[i].opening <= kMaxShutterOpening)) {
      return wrong(
          i, absl::StrCat("the opening is ", curve[i].opening, ", but must be 0 to ", kMaxShutterOpening));
    }
    most = std::max(most, curve[i].opening);
  }
  if (curve.back().time != 1) return wrong(curve.size() - 1, "the last time must be 1");
  // Less would vanish in the products that follow.
  if (most < 1e-6) return wrong(0, "the shutter never opens");
  return absl::OkStatus();
}

absl::Status ValidateOcclusion(const OcclusionSettings& s) {
  if (s.lines < 1 || s.lines > kMaxOcclusionLines) {
    return OutOfRange("occlusion.lines", s.lines, absl::StrCat("1 to ", kMaxOcclusionLines));
  }
  if (s.radius && !(*s.radius >= kMinOcclusionRadius && *s.radius <= kMaxOcclusionRadius)) {
    return OutOfRange("occlusion.radius", *s.radius,
                      absl::StrCat(kMinOcclusionRadius, " to ", kMaxOcclusionRadius, " metres"));
  }
  if (!s.radius && s.falloff != OcclusionFalloff::kNone) {
    return absl::InvalidArgumentError(
        absl::StrCat("render settings: occlusion.falloff ", ToString(s.falloff), " needs occlusion.radius"));
  }
  return absl::OkStatus();
}

template <typename Enum>
absl::Status ValidateSet(absl::string_view field, const std::vector<Enum>& set) {
  for (size_t i = 0; i < set.size(); ++i) {
    if (ToString(set[i]) == "unknown" || (i > 0 && !(set[i - 1] < set[i]))) {
      return absl::InvalidArgumentError(absl::StrCat("render settings: ", field, "[", i,
                                                     "]: must be known, and greater than the one before"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const RenderSettings& s) {
  const std::string side = absl::StrCat("1 to ", kMaxFrameSide);
  if (s.width < 1 || s.width > kMaxFrameSide) return OutOfRange("width", s.width, side);
  if (s.height < 1 || s.height > kMaxFrameSide) return OutOfRange("height", s.height, side);
  if (!std::isfinite(s.fps) || s.fps <= 0 || s.fps > 1e6)
    return OutOfRange("fps", s.fps, "above 0 and at most 1e6");
  if (!std::isfinite(s.shutter_open) || std::abs(s.shutter_open) > 1e6) {
    return OutOfRange("shutter_open", s.shutter_open, "finite and within ±1e6 frames");
  }
  if (!std::isfinite(s.shutter_close) || std::abs(s.shutter_close) > 1e6) {
    return OutOfRange("shutter_close", s.shutter_close, "finite and within ±1e6 frames");
  }
  if (s.shutter_close < s.shutter_open) {
    return OutOfRange("shutter_close", s.shutter_close,
                      absl::StrCat("at least shutter_open (", s.shutter_open, ")"));
  }
  SL_RETURN_IF_ERROR(ValidateShutterCurve(s.shutter_curve));
  if (s.motion_degree && (*s.motion_degree < 1 || *s.motion_degree > kMaxMotionDegree)) {
    return OutOfRange("motion_degree", *s.motion_degree, absl::StrCat("1 to ", kMaxMotionDegree));
  }
  if (s.motion_pieces && (*s.motion_pieces < 1 || *s.motion_pieces > kMaxMotionPieces ||
                          !std::has_single_bit(unsigned(*s.motion_pieces)))) {
    return OutOfRange("motion_pieces", *s.motion_pieces,
                      absl::StrCat("a power of two from 1 to ", kMaxMotionPieces));
  }
  for (const double radiance : s.ambient) {
    if (!(radiance >= 0 && radiance <= kMaxAmbient)) {
      return OutOfRange("ambient", radiance, absl::StrCat("0 to ", kMaxAmbient));
    }
  }
  if (s.occlusion) SL_RETURN_IF_ERROR(ValidateOcclusion(*s.occlusion));
  if (s.shading_rate && !(*s.shading_rate >= kMinShadingRate && *s.shading_rate <= kMaxShadingRate)) {
    return OutOfRange("shading_rate", *s.shading_rate,
                      absl::StrCat(kMinShadingRate, " to ", kMaxShadingRate));
  }
  SL_RETURN_IF_ERROR(ValidateSet("aovs", s.aovs));
  if (!s.occlusion && std::find(s.aovs.begin(), s.aovs.end(), Aov::kAmbientOcclusion) != s.aovs.end()) {
    return absl::InvalidArgumentError("render settings: aovs: ao needs occlusion");
  }
  SL_RETURN_IF_ERROR(ValidateSet("mattes", s.mattes));
  if (s.matte_ranks < 1 || s.matte_ranks > kMaxMatteRanks) {
    return OutOfRange("matte_ranks", s.matte_ranks, absl::StrCat("1 to ", kMaxMatteRanks));
  }
  SL_RETURN_IF_ERROR(ValidateFilter(s));
  if (!std::isfinite(s.time_step) || s.time_step < 1e-3 || s.time_step > 1e6) {
    return OutOfRange("time_step", s.time_step, "0.001 to 1e6 pixels");
  }
  if (s.time_samples && (*s.time_samples < 1 || *s.time_samples > kMaxTimeSamples)) {
    return OutOfRange("time_samples", *s.time_samples, absl::StrCat("1 to ", kMaxTimeSamples));
  }
  if (s.target_error) {
    if (!(*s.target_error >= kMinTargetError && *s.target_error <= kMaxTargetError)) {
      return OutOfRange("target_error", *s.target_error,
                        absl::StrCat(kMinTargetError, " to ", kMaxTargetError));
    }
  }
  if (s.time_cells < 1 || s.time_cells > kMaxTimeCells) {
    return OutOfRange("time_cells", s.time_cells, absl::StrCat("1 to ", kMaxTimeCells));
  }
  if (s.spp < 1 || s.spp > kMaxSpp) return OutOfRange("spp", s.spp, absl::StrCat("1 to ", kMaxSpp));
  return absl::OkStatus();
}

double DefaultFilterRadius(FilterKind kind) {
  switch (kind) {
    case FilterKind::kBox:
      return 0.5;
    case FilterKind::kTriangle:
      return 1;
    case FilterKind::kGaussian:
      return 1.5;
    case FilterKind::kBlackmanHarris:
      return 2;
  }
  return 0.5;
}

double FilterRadius(const RenderSettings& settings) {
  return settings.filter_radius.value_or(DefaultFilterRadius(settings.filter));
}

bool HasPixelBox(const RenderSettings& settings) {
  return settings.filter == FilterKind::kBox && FilterRadius(settings) == 0.5;
}

absl::Status ValidateFilter(const RenderSettings& s) {
  const double radius = FilterRadius(s);
  if (!(radius >= kMinFilterRadius && radius <= kMaxFilterRadius)) {
    return OutOfRange("filter_radius", radius, absl::StrCat(kMinFilterRadius, " to ", kMaxFilterRadius));
  }
  if (HasPixelBox(s)) return absl::OkStatus();
  const auto refuse = [&](absl::string_view method) {
    return absl::InvalidArgumentError(absl::StrCat("render settings: filter ", ToString(s.filter),
                                                   " of radius ", radius, ": ", method,
                                                   " knows none but box of radius 0.5"));
  };
  if (s.integrator == IntegratorKind::kStochastic) return refuse("integrator stochastic");
  if (s.integrator == IntegratorKind::kLine && s.resolver == ResolverKind::kPaper) {
    return refuse("resolver paper");
  }
  return absl::OkStatus();
}

absl::string_view ToString(IntegratorKind kind) {
  return WordOf(kIntegrators, kind);
}
absl::string_view ToString(ReferenceLayout layout) {
  return WordOf(kReferenceLayouts, layout);
}
absl::string_view ToString(PatternKind kind) {
  return WordOf(kPatterns, kind);
}
absl::string_view ToString(ResolverKind kind) {
  return WordOf(kResolvers, kind);
}
absl::string_view ToString(FilterKind kind) {
  return WordOf(kFilters, kind);
}
absl::string_view ToString(LightingKind kind) {
  return WordOf(kLightings, kind);
}
absl::string_view ToString(OcclusionFalloff falloff) {
  return WordOf(kFalloffs, falloff);
}
absl::string_view ToString(OcclusionPattern pattern) {
  return WordOf(kOcclusionPatterns, pattern);
}
absl::string_view ToString(Aov aov) {
  return WordOf(kAovs, aov);
}
absl::string_view ToString(Matte matte) {
  return WordOf(kMattes, matte);
}
absl::string_view ToString(PixelType type) {
  return WordOf(kPixelTypes, type);
}
absl::string_view ToString(ExrCompression compression) {
  return WordOf(kCompressions, compression);
}
std::optional<IntegratorKind> ParseIntegrator(absl::string_view word) {
  return ValueOf(kIntegrators, word);
}
std::optional<ReferenceLayout> ParseReferenceLayout(absl::string_view word) {
  return ValueOf(kReferenceLayouts, word);
}
std::optional<PatternKind> ParsePattern(absl::string_view word) {
  return ValueOf(kPatterns, word);
}
std::optional<ResolverKind> ParseResolver(absl::string_view word) {
  return ValueOf(kResolvers, word);
}
std::optional<FilterKind> ParseFilter(absl::string_view word) {
  return ValueOf(kFilters, word);
}
std::optional<LightingKind> ParseLighting(absl::string_view word) {
  return ValueOf(kLightings, word);
}
std::optional<OcclusionFalloff> ParseOcclusionFalloff(absl::string_view word) {
  return ValueOf(kFalloffs, word);
}
std::optional<OcclusionPattern> ParseOcclusionPattern(absl::string_view word) {
  return ValueOf(kOcclusionPatterns, word);
}
std::optional<Aov> ParseAov(absl::string_view word) {
  return ValueOf(kAovs, word);
}
std::optional<Matte> ParseMatte(absl::string_view word) {
  return ValueOf(kMattes, word);
}
std::optional<PixelType> ParsePixelType(absl::string_view word) {
  return ValueOf(kPixelTypes, word);
}
std::optional<ExrCompression> ParseExrCompression(absl::string_view word) {
  return ValueOf(kCompressions, word);
}

}  // namespace shutterline
