#include "proto/convert/job_spec.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/check.h"
#include "common/base/status_macros.h"

namespace shutterline::convert {
namespace {

template <typename Ours, typename Theirs, size_t N>
using Pairs = std::array<std::pair<Ours, Theirs>, N>;

constexpr Pairs<IntegratorKind, v1::Integrator, 3> kIntegrators{
    {{IntegratorKind::kLine, v1::INTEGRATOR_LINE},
     {IntegratorKind::kReference, v1::INTEGRATOR_REFERENCE},
     {IntegratorKind::kStochastic, v1::INTEGRATOR_STOCHASTIC}}};
constexpr Pairs<ReferenceLayout, v1::ReferenceLayout, 2> kReferenceLayouts{
    {{ReferenceLayout::kMotionBvh, v1::REFERENCE_LAYOUT_MOTION_BVH},
     {ReferenceLayout::kSharedInstants, v1::REFERENCE_LAYOUT_SHARED_INSTANTS}}};
constexpr Pairs<PatternKind, v1::Pattern, 7> kPatterns{{{PatternKind::kAuto, v1::PATTERN_AUTO},
                                                        {PatternKind::k1h1v, v1::PATTERN_1H1V},
                                                        {PatternKind::k2h2v, v1::PATTERN_2H2V},
                                                        {PatternKind::k4h4v, v1::PATTERN_4H4V},
                                                        {PatternKind::k8h8v, v1::PATTERN_8H8V},
                                                        {PatternKind::k16h16v, v1::PATTERN_16H16V},
                                                        {PatternKind::kRgls, v1::PATTERN_RGLS}}};
constexpr Pairs<ResolverKind, v1::Resolver, 2> kResolvers{
    {{ResolverKind::kSlice, v1::RESOLVER_SLICE}, {ResolverKind::kPaper, v1::RESOLVER_PAPER}}};
constexpr Pairs<FilterKind, v1::Filter, 4> kFilters{
    {{FilterKind::kBox, v1::FILTER_BOX},
     {FilterKind::kTriangle, v1::FILTER_TRIANGLE},
     {FilterKind::kGaussian, v1::FILTER_GAUSSIAN},
     {FilterKind::kBlackmanHarris, v1::FILTER_BLACKMAN_HARRIS}}};
constexpr Pairs<LightingKind, v1::Lighting, 4> kLightings{
    {{LightingKind::kAuto, v1::LIGHTING_AUTO},
     {LightingKind::kScene, v1::LIGHTING_SCENE},
     {LightingKind::kStudio, v1::LIGHTING_STUDIO},
     {LightingKind::kHeadlight, v1::LIGHTING_HEADLIGHT}}};
constexpr Pairs<OcclusionFalloff, v1::OcclusionFalloff, 3> kFalloffs{
    {{OcclusionFalloff::kNone, v1::OCCLUSION_FALLOFF_NONE},
     {OcclusionFalloff::kLinear, v1::OCCLUSION_FALLOFF_LINEAR},
     {OcclusionFalloff::kQuadratic, v1::OCCLUSION_FALLOFF_QUADRATIC}}};
constexpr Pairs<OcclusionPattern, v1::OcclusionPattern, 2> kOcclusionPatterns{
    {{OcclusionPattern::kPole, v1::OCCLUSION_PATTERN_POLE},
     {OcclusionPattern::kTilted, v1::OCCLUSION_PATTERN_TILTED}}};
constexpr Pairs<Aov, v1::Aov, 9> kAovs{{{Aov::kDepth, v1::AOV_DEPTH},
                                        {Aov::kPosition, v1::AOV_POSITION},
                                        {Aov::kNormal, v1::AOV_NORMAL},
                                        {Aov::kMotion, v1::AOV_MOTION},
                                        {Aov::kAlbedo, v1::AOV_ALBEDO},
                                        {Aov::kAmbientOcclusion, v1::AOV_AMBIENT_OCCLUSION},
                                        {Aov::kSamples, v1::AOV_SAMPLES},
                                        {Aov::kObjectId, v1::AOV_OBJECT_ID},
                                        {Aov::kMaterialId, v1::AOV_MATERIAL_ID}}};
constexpr Pairs<Matte, v1::Matte, 2> kMattes{
    {{Matte::kObject, v1::MATTE_OBJECT}, {Matte::kMaterial, v1::MATTE_MATERIAL}}};
constexpr Pairs<PixelType, v1::PixelType, 2> kPixelTypes{
    {{PixelType::kHalf, v1::PIXEL_TYPE_HALF}, {PixelType::kFloat, v1::PIXEL_TYPE_FLOAT}}};
constexpr Pairs<ExrCompression, v1::Compression, 4> kCompressions{
    {{ExrCompression::kNone, v1::COMPRESSION_NONE},
     {ExrCompression::kZip, v1::COMPRESSION_ZIP},
     {ExrCompression::kPiz, v1::COMPRESSION_PIZ},
     {ExrCompression::kDwaa, v1::COMPRESSION_DWAA}}};

constexpr Pairs<TileOrder, v1::TileOrder, 3> kTileOrders{{{TileOrder::kHilbert, v1::TILE_ORDER_HILBERT},
                                                          {TileOrder::kCenter, v1::TILE_ORDER_CENTER},
                                                          {TileOrder::kCoarse, v1::TILE_ORDER_COARSE}}};

template <typename Ours, typename Theirs, size_t N>
Theirs Out(const Pairs<Ours, Theirs, N>& pairs, Ours value) {
  for (const auto& [ours, theirs] : pairs) {
    if (ours == value) return theirs;
  }
  SL_CHECK(false && "an enumerator without a place on the wire");
  return pairs.front().second;
}

std::string Join(absl::string_view parent, absl::string_view field) {
  return parent.empty() ? std::string(field) : absl::StrCat(parent, ".", field);
}

template <typename Ours, typename Theirs, size_t N>
absl::StatusOr<Ours> In(const Pairs<Ours, Theirs, N>& pairs, Theirs value, absl::string_view parent,
                        absl::string_view field) {
  for (const auto& [ours, theirs] : pairs) {
    if (theirs == value) return ours;
  }
  const int number = static_cast<int>(value);
  return absl::InvalidArgumentError(absl::StrCat(
      Join(parent, field), ": ",
      number == 0 ? std::string("is not specified") : absl::StrCat("value ", number, " is not known")));
}

/// A set of enumerators. More than there are kinds are refused before they are copied.
template <typename Ours, typename Theirs, size_t N>
absl::StatusOr<std::vector<Ours>> In(const Pairs<Ours, Theirs, N>& pairs,
                                     const google::protobuf::RepeatedField<int>& values,
                                     absl::string_view parent, absl::string_view field) {
  if (size_t(values.size()) > N) {
    return absl::InvalidArgumentError(
        absl::StrCat(Join(parent, field), ": has ", values.size(), " entries, but there are ", N, " kinds"));
  }
  std::vector<Ours> set;
  for (int i = 0; i < values.size(); ++i) {
    SL_ASSIGN_OR_RETURN(const Ours value,
                        In(pairs, static_cast<Theirs>(values[i]), parent, absl::StrCat(field, "[", i, "]")));
    set.push_back(value);
  }
  return set;
}

v1::OcclusionSettings ToProto(const OcclusionSettings& s) {
  v1::OcclusionSettings m;
  m.set_lines(s.lines);
  if (s.radius) m.set_radius(*s.radius);
  m.set_falloff(Out(kFalloffs, s.falloff));
  m.set_pattern(Out(kOcclusionPatterns, s.pattern));
  m.set_motion(s.motion);
  return m;
}

absl::StatusOr<OcclusionSettings> FromProto(const v1::OcclusionSettings& m, absl::string_view field) {
  OcclusionSettings s;
  s.lines = m.lines();
  if (m.has_radius()) s.radius = m.radius();
  SL_ASSIGN_OR_RETURN(s.falloff, In(kFalloffs, m.falloff(), field, "falloff"));
  SL_ASSIGN_OR_RETURN(s.pattern, In(kOcclusionPatterns, m.pattern(), field, "pattern"));
  s.motion = m.motion();
  return s;
}

}  // namespace

v1::Digest ToProto(const Digest& digest) {
  v1::Digest message;
  message.set_sha256(digest.bytes.data(), digest.bytes.size());
  return message;
}

v1::RenderSettings ToProto(const RenderSettings& s) {
  v1::RenderSettings m;
  m.set_width(s.width);
  m.set_height(s.height);
  m.set_fps(s.fps);
  m.set_shutter_open(s.shutter_open);
  m.set_shutter_close(s.shutter_close);
  for (const ShutterPoint& point : s.shutter_curve) {
    v1::ShutterPoint& p = *m.add_shutter_curve();
    p.set_time(point.time);
    p.set_opening(point.opening);
  }
  m.set_camera(s.camera);
  m.set_animation(s.animation);
  if (s.motion_degree) m.set_motion_degree(*s.motion_degree);
  if (s.motion_pieces) m.set_motion_pieces(*s.motion_pieces);
  m.set_integrator(Out(kIntegrators, s.integrator));
  m.set_pattern(Out(kPatterns, s.pattern));
  m.set_resolver(Out(kResolvers, s.resolver));
  m.set_filter(Out(kFilters, s.filter));
  if (s.filter_radius) m.set_filter_radius(*s.filter_radius);
  m.set_lighting(Out(kLightings, s.lighting));
  m.set_ambient_red(s.ambient[0]);
  m.set_ambient_green(s.ambient[1]);
  m.set_ambient_blue(s.ambient[2]);
  if (s.occlusion) *m.mutable_occlusion() = ToProto(*s.occlusion);
  if (s.shading_rate) m.set_shading_rate(*s.shading_rate);
  m.set_cache_propagate(s.cache_propagate);
  for (const Aov aov : s.aovs) m.add_aovs(Out(kAovs, aov));
  for (const Matte matte : s.mattes) m.add_mattes(Out(kMattes, matte));
  m.set_matte_ranks(s.matte_ranks);
  m.set_time_step(s.time_step);
  if (s.time_samples) m.set_time_samples(*s.time_samples);
  if (s.target_error) m.set_target_error(*s.target_error);
  m.set_time_cells(s.time_cells);
  m.set_spp(s.spp);
  m.set_seed(s.seed);
  m.set_reference_layout(Out(kReferenceLayouts, s.reference_layout));
  return m;
}

v1::OutputSettings ToProto(const OutputSettings& s) {
  v1::OutputSettings m;
  m.set_pixel_type(Out(kPixelTypes, s.pixel_type));
  m.set_compression(Out(kCompressions, s.compression));
  return m;
}

v1::SceneManifest ToProto(const SceneManifest& scene) {
  v1::SceneManifest m;
  m.set_root_name(scene.root_name);
  for (const SceneFile& file : scene.files) {
    v1::SceneFile& f = *m.add_files();
    f.set_name(file.name);
    *f.mutable_digest() = ToProto(file.digest);
    f.set_size_bytes(file.size);
  }
  return m;
}

v1::JobSpec ToProto(const JobSpec& spec) {
  v1::JobSpec m;
  m.set_name(spec.name);
  *m.mutable_scene() = ToProto(spec.scene);
  m.mutable_frames()->set_first(spec.frames.first);
  m.mutable_frames()->set_last(spec.frames.last);
  m.mutable_frames()->set_step(spec.frames.step);
  *m.mutable_render() = ToProto(spec.render);
  *m.mutable_output() = ToProto(spec.output);
  m.set_order(Out(kTileOrders, spec.order));
  return m;
}

absl::StatusOr<Digest> FromProto(const v1::Digest& message, absl::string_view field) {
  Digest digest;
  const std::string& bytes = message.sha256();
  if (bytes.size() != digest.bytes.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat(Join(field, "sha256"), ": has ", bytes.size(), " bytes, but must have 32"));
  }
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(digest.bytes.data()));
  return digest;
}

absl::StatusOr<RenderSettings> FromProto(const v1::RenderSettings& m, absl::string_view field) {
  RenderSettings s;
  s.width = m.width();
  s.height = m.height();
  s.fps = m.fps();
  s.shutter_open = m.shutter_open();
  s.shutter_close = m.shutter_close();
  // More than are allowed are not copied: Validate sees that there are too many.
  for (int i = 0; i < m.shutter_curve_size() && s.shutter_curve.size() <= kMaxShutterPoints; ++i) {
    s.shutter_curve.push_back({m.shutter_curve(i).time(), m.shutter_curve(i).opening()});
  }
  s.camera = m.camera();
  s.animation = m.animation();
  if (m.has_motion_degree()) s.motion_degree = m.motion_degree();
  if (m.has_motion_pieces()) s.motion_pieces = m.motion_pieces();
  SL_ASSIGN_OR_RETURN(s.integrator, In(kIntegrators, m.integrator(), field, "integrator"));
  SL_ASSIGN_OR_RETURN(s.pattern, In(kPatterns, m.pattern(), field, "pattern"));
  SL_ASSIGN_OR_RETURN(s.resolver, In(kResolvers, m.resolver(), field, "resolver"));
  if (m.filter() != v1::FILTER_UNSPECIFIED) {  // As clients leave it that know of none.
    SL_ASSIGN_OR_RETURN(s.filter, In(kFilters, m.filter(), field, "filter"));
  }
  if (m.has_filter_radius()) s.filter_radius = m.filter_radius();
  SL_ASSIGN_OR_RETURN(s.lighting, In(kLightings, m.lighting(), field, "lighting"));
  s.ambient = {m.ambient_red(), m.ambient_green(), m.ambient_blue()};
  if (m.has_occlusion()) {
    SL_ASSIGN_OR_RETURN(s.occlusion, FromProto(m.occlusion(), Join(field, "occlusion")));
  }
  if (m.has_shading_rate()) s.shading_rate = m.shading_rate();
  s.cache_propagate = m.cache_propagate();
  SL_ASSIGN_OR_RETURN(s.aovs, In(kAovs, m.aovs(), field, "aovs"));
  SL_ASSIGN_OR_RETURN(s.mattes, In(kMattes, m.mattes(), field, "mattes"));
  s.matte_ranks = m.matte_ranks();
  s.time_step = m.time_step();
  if (m.has_time_samples()) s.time_samples = m.time_samples();
  s.target_error = m.has_target_error() ? std::optional(m.target_error()) : std::nullopt;
  s.time_cells = m.time_cells();
  s.spp = m.spp();
  s.seed = m.seed();
  SL_ASSIGN_OR_RETURN(s.reference_layout,
                      In(kReferenceLayouts, m.reference_layout(), field, "reference_layout"));
  SL_RETURN_IF_ERROR(Validate(s));
  return s;
}

absl::StatusOr<OutputSettings> FromProto(const v1::OutputSettings& m, absl::string_view field) {
  OutputSettings s;
  SL_ASSIGN_OR_RETURN(s.pixel_type, In(kPixelTypes, m.pixel_type(), field, "pixel_type"));
  SL_ASSIGN_OR_RETURN(s.compression, In(kCompressions, m.compression(), field, "compression"));
  return s;
}

absl::StatusOr<SceneManifest> FromProto(const v1::SceneManifest& m, absl::string_view field) {
  SceneManifest scene;
  scene.root_name = m.root_name();
  scene.files.reserve(size_t(m.files_size()));
  for (int i = 0; i < m.files_size(); ++i) {
    const v1::SceneFile& f = m.files(i);
    SceneFile file;
    file.name = f.name();
    SL_ASSIGN_OR_RETURN(file.digest,
                        FromProto(f.digest(), absl::StrCat(Join(field, "files"), "[", i, "].digest")));
    file.size = f.size_bytes();
    scene.files.push_back(std::move(file));
  }
  return scene;
}

absl::StatusOr<JobSpec> FromProto(const v1::JobSpec& m, const JobLimits& limits) {
  JobSpec spec;
  spec.name = m.name();
  // Before the manifest is translated, so that its length bounds the work.
  if (m.scene().files_size() > limits.max_manifest_files) {
    return absl::InvalidArgumentError(absl::StrCat("scene.files: has ", m.scene().files_size(),
                                                   " entries, but at most ", limits.max_manifest_files,
                                                   " may be"));
  }
  SL_ASSIGN_OR_RETURN(spec.scene, FromProto(m.scene(), "scene"));
  spec.frames = {m.frames().first(), m.frames().last(), m.frames().step()};
  SL_ASSIGN_OR_RETURN(spec.render, FromProto(m.render(), "render"));
  SL_ASSIGN_OR_RETURN(spec.output, FromProto(m.output(), "output"));
  if (m.order() != v1::TILE_ORDER_UNSPECIFIED) {
    SL_ASSIGN_OR_RETURN(spec.order, In(kTileOrders, m.order(), "", "order"));
  }
  SL_RETURN_IF_ERROR(Validate(spec, limits));
  return spec;
}

}  // namespace shutterline::convert
