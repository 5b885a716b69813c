#include "common/job/render_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace shutterline {
namespace {

using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(RenderSettings, DefaultsAreValid) {
  EXPECT_TRUE(Validate(RenderSettings()).ok());
}

struct Range {
  const char* field;
  std::function<void(RenderSettings&, double)> set;
  std::vector<double> good, bad;
};

TEST(RenderSettings, EveryRangeIsHeldAndNamed) {
  const std::vector<Range> ranges = {
      {"width", [](auto& s, double v) { s.width = int(v); }, {1, 32768}, {0, -1, 32769, -2147483648.0}},
      {"height", [](auto& s, double v) { s.height = int(v); }, {1, 32768}, {0, -1, 32769, 2147483647.0}},
      {"fps", [](auto& s, double v) { s.fps = v; }, {1e-3, 24, 1e6}, {0, -24, 1.1e6, kNaN, kInfinity}},
      {"shutter_open",
       [](auto& s, double v) { s.shutter_open = v; },
       {-1e6, 0, 0.5},
       {-1.1e6, kNaN, kInfinity, -kInfinity}},
      {"shutter_close",
       [](auto& s, double v) { s.shutter_close = v; },
       {0, 1, 1e6},
       {-0.001, 1.1e6, kNaN, kInfinity}},
      {"time_step",
       [](auto& s, double v) { s.time_step = v; },
       {1e-3, 1, 1e6},
       {0, -1, 0.99e-3, 1.1e6, kNaN, kInfinity}},
      {"time_cells", [](auto& s, double v) { s.time_cells = int(v); }, {1, 64}, {0, -1, 65}},
      {"time_samples", [](auto& s, double v) { s.time_samples = int(v); }, {1, 65536}, {0, -1, 65537}},
      {"target_error",
       [](auto& s, double v) { s.target_error = v; },
       {1e-5, 0.004, 0.5},
       {0, -1e-3, 0.99e-5, 0.51, kNaN, kInfinity}},
      {"motion_degree", [](auto& s, double v) { s.motion_degree = int(v); }, {1, 2, 3}, {0, -1, 4}},
      {"motion_pieces", [](auto& s, double v) { s.motion_pieces = int(v); }, {1, 2, 64}, {0, -2, 3, 65, 128}},
      {"ambient", [](auto& s, double v) { s.ambient[1] = v; }, {0, 1e6}, {-1e-3, 1.1e6, kNaN, kInfinity}},
      {"shutter_curve",
       [](auto& s, double v) {
         s.shutter_curve = {{0, v}, {1, 1}};
       },
       {0, 1, 1e6},
       {-0.1, 1.1e6, kNaN, kInfinity}},
      {"occlusion.lines",
       [](auto& s, double v) { s.occlusion.emplace().lines = int(v); },
       {1, 1024},
       {0, -1, 1025}},
      {"occlusion.radius",
       [](auto& s, double v) { s.occlusion.emplace().radius = v; },
       {1e-12, 1, 1e12},
       {0, -1, 1.1e12, kNaN, kInfinity}},
      {"shading_rate", [](auto& s, double v) { s.shading_rate = v; }, {1.0 / 64, 1, 16}, {0, -1, 17, kNaN}},
      {"filter_radius",
       [](auto& s, double v) { s.filter_radius = v; },
       {0.5, 1.3, 4},
       {0, -1, 0.49, 4.01, kNaN, kInfinity}},
      {"matte_ranks", [](auto& s, double v) { s.matte_ranks = int(v); }, {1, 32}, {0, -1, 33}},
      {"aovs[1]",
       [](auto& s, double v) {
         s.aovs = {Aov::kPosition, Aov(int(v))};
       },
       {2, 3, 8},
       {0, 1, 9, -1}},
      {"mattes[1]",
       [](auto& s, double v) {
         s.mattes = {Matte::kObject, Matte(int(v))};
       },
       {1},
       {0, 2, -1}},
      {"spp", [](auto& s, double v) { s.spp = int(v); }, {1, 1048576}, {0, -1, 1048577}},
  };
  for (const Range& range : ranges) {
    for (const double value : range.good) {
      RenderSettings settings;
      range.set(settings, value);
      EXPECT_TRUE(Validate(settings).ok()) << range.field << " " << value;
    }
    for (const double value : range.bad) {
      RenderSettings settings;
      range.set(settings, value);
      const absl::Status status = Validate(settings);
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << range.field << " " << value;
      EXPECT_THAT(std::string(status.message()), HasSubstr(range.field));
    }
  }
}

TEST(RenderSettings, ShutterCurvesGoFromZeroToOne) {
  const std::vector<std::vector<ShutterPoint>> wrong = {{{0, 1}},
                                                        {{0, 1}, {0.5, 1}},
                                                        {{0.1, 1}, {1, 1}},
                                                        {{0, 1}, {0.5, 1}, {0.5, 0}, {1, 1}},
                                                        {{0, 1}, {kNaN, 1}, {1, 1}},
                                                        {{0, 0}, {1, 0}},
                                                        std::vector<ShutterPoint>(65, ShutterPoint{})};
  for (const std::vector<ShutterPoint>& curve : wrong) {
    RenderSettings settings;
    settings.shutter_curve = curve;
    EXPECT_THAT(std::string(Validate(settings).message()), HasSubstr("shutter_curve")) << curve.size();
  }
}

TEST(RenderSettings, WhatNeedsOcclusionSaysSo) {
  RenderSettings settings;
  settings.aovs = {Aov::kAmbientOcclusion};
  EXPECT_THAT(std::string(Validate(settings).message()), HasSubstr("ao needs occlusion"));
  settings.occlusion = OcclusionSettings();
  EXPECT_TRUE(Validate(settings).ok());
  settings.occlusion->falloff = OcclusionFalloff::kLinear;
  EXPECT_THAT(std::string(Validate(settings).message()), HasSubstr("occlusion.radius"));
}

TEST(RenderSettings, MethodsWithoutFiltersSaySo) {
  const auto message = [](const RenderSettings& settings) {
    return std::string(Validate(settings).message());
  };
  RenderSettings paper;
  paper.resolver = ResolverKind::kPaper;
  RenderSettings stochastic;
  stochastic.integrator = IntegratorKind::kStochastic;
  for (RenderSettings settings : {paper, stochastic}) {
    // A box of half a pixel is the default, whoever names it.
    settings.filter_radius = 0.5;
    EXPECT_EQ(message(settings), "");
    settings.filter_radius = 0.75;
    EXPECT_THAT(message(settings), HasSubstr("filter box of radius 0.75"));
    settings.filter = FilterKind::kGaussian;
    settings.filter_radius = std::nullopt;
    EXPECT_THAT(message(settings), HasSubstr("filter gaussian of radius 1.5"));
    EXPECT_THAT(message(settings),
                HasSubstr(settings.integrator == IntegratorKind::kStochastic ? "integrator stochastic"
                                                                             : "resolver paper"));
    // What is not used does not matter.
    settings.integrator = IntegratorKind::kReference;
    EXPECT_EQ(message(settings), "");
  }
}

TEST(RenderSettings, AStillIsValid) {
  RenderSettings settings;
  settings.shutter_open = settings.shutter_close = 0.25;
  EXPECT_TRUE(Validate(settings).ok());
}

/// What ToString writes, Parse reads, and nothing else.
template <typename Enum, typename Parse>
void ExpectWords(std::vector<Enum> values, Parse parse) {
  for (const Enum value : values) {
    const std::string word(ToString(value));
    EXPECT_NE(word, "unknown");
    EXPECT_EQ(parse(word), value);
    EXPECT_EQ(parse(word + " "), std::nullopt);
    EXPECT_EQ(parse(word.substr(1)), std::nullopt);
  }
  EXPECT_EQ(parse(""), std::nullopt);
  EXPECT_EQ(parse("unknown"), std::nullopt);
}

TEST(RenderSettings, WordRoundTrips) {
  ExpectWords<IntegratorKind>(
      {IntegratorKind::kLine, IntegratorKind::kReference, IntegratorKind::kStochastic}, ParseIntegrator);
  ExpectWords<ReferenceLayout>({ReferenceLayout::kMotionBvh, ReferenceLayout::kSharedInstants},
                               ParseReferenceLayout);
  ExpectWords<PatternKind>({PatternKind::kAuto, PatternKind::k1h1v, PatternKind::k2h2v, PatternKind::k4h4v,
                            PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls},
                           ParsePattern);
  ExpectWords<ResolverKind>({ResolverKind::kSlice, ResolverKind::kPaper}, ParseResolver);
  ExpectWords<LightingKind>(
      {LightingKind::kAuto, LightingKind::kScene, LightingKind::kStudio, LightingKind::kHeadlight},
      ParseLighting);
  ExpectWords<OcclusionFalloff>(
      {OcclusionFalloff::kNone, OcclusionFalloff::kLinear, OcclusionFalloff::kQuadratic},
      ParseOcclusionFalloff);
  ExpectWords<OcclusionPattern>({OcclusionPattern::kPole, OcclusionPattern::kTilted}, ParseOcclusionPattern);
  ExpectWords<Aov>({Aov::kDepth, Aov::kPosition, Aov::kNormal, Aov::kMotion, Aov::kAlbedo,
                    Aov::kAmbientOcclusion, Aov::kSamples, Aov::kObjectId, Aov::kMaterialId},
                   ParseAov);
  ExpectWords<Matte>({Matte::kObject, Matte::kMaterial}, ParseMatte);
  ExpectWords<PixelType>({PixelType::kHalf, PixelType::kFloat}, ParsePixelType);
  ExpectWords<ExrCompression>(
      {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kPiz, ExrCompression::kDwaa},
      ParseExrCompression);
}

}  // namespace
}  // namespace shutterline
