#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <google/protobuf/duration.pb.h>
#include <grpcpp/support/status.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/base/retry_hint.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/status.h"

namespace shutterline::convert {
namespace {

using testing::HasSubstr;

JobSpec RandomSpec(std::mt19937& random) {
  const auto below = [&](int n) { return int(random() % uint32_t(n)); };
  JobSpec spec;
  spec.name = absl::StrCat("job ", below(1000));
  for (int i = 0; i <= below(4); ++i) {
    spec.scene.files.push_back(
        {absl::StrCat("dir/file", i, ".bin"), Sha256(absl::StrCat(random())), random()});
  }
  spec.scene.root_name = spec.scene.files[0].name;
  spec.frames = {-below(10), below(10), 1 + below(3)};
  RenderSettings& r = spec.render;
  r.width = 1 + below(kMaxFrameSide);
  r.height = 1 + below(1000);
  r.fps = 1 + below(100) / 7.0;
  r.shutter_open = -below(100) / 3.0;
  r.shutter_close = below(100) / 3.0;
  r.camera = absl::StrCat("kamera é", below(3));
  r.animation = below(2) ? "all" : "";
  if (below(2)) r.motion_degree = 1 + below(kMaxMotionDegree);
  if (below(2)) r.motion_pieces = 1 << below(7);
  r.integrator = IntegratorKind(below(3));
  r.reference_layout = ReferenceLayout(below(2));
  if (below(2))
    r.shutter_curve = {{0, below(9) / 4.0}, {0.25 + below(9) / 20.0, 1 + below(9) / 2.0}, {1, 0.5}};
  r.lighting = LightingKind(below(4));
  r.ambient = {below(10) / 3.0, below(10) / 3.0, below(10) / 3.0};
  r.pattern = PatternKind(below(6));
  if (r.integrator != IntegratorKind::kStochastic) {
    r.filter = FilterKind(below(4));
    if (below(2)) r.filter_radius = 0.5 + below(8) / 2.0;
  }
  if (below(2)) {
    r.occlusion = OcclusionSettings{.lines = 1 + below(100),
                                    .radius = below(2) ? std::optional(1 + below(9) / 3.0) : std::nullopt,
                                    .falloff = OcclusionFalloff::kNone,
                                    .pattern = OcclusionPattern(below(2)),
                                    .motion = below(2) == 1};
    if (r.occlusion->radius) r.occlusion->falloff = OcclusionFalloff(below(3));
  }
  if (below(2)) r.shading_rate = 0.25 + below(9) / 3.0;
  r.cache_propagate = below(2) == 1;
  for (int i = 0; i <= int(Aov::kMaterialId); ++i) {
    if (below(2) && (r.occlusion || Aov(i) != Aov::kAmbientOcclusion)) r.aovs.push_back(Aov(i));
  }
  for (const Matte matte : {Matte::kObject, Matte::kMaterial}) {
    if (below(2)) r.mattes.push_back(matte);
  }
  r.matte_ranks = 1 + below(kMaxMatteRanks);
  r.time_step = 0.001 + below(1000) / 9.0;
  r.time_cells = 1 + below(kMaxTimeCells);
  if (below(2)) {
    r.time_samples = 1 + below(kMaxTimeSamples);
  } else if (below(2)) {
    r.target_error = kMinTargetError * (1 + below(1000));
  }
  r.spp = 1 + below(kMaxSpp);
  r.seed = (uint64_t{random()} << 32) | random();
  spec.output.pixel_type = PixelType(below(2));
  spec.output.compression = ExrCompression(below(r.mattes.empty() ? 4 : 3));
  spec.order = TileOrder(below(3));
  return spec;
}

TEST(ConvertJobSpecTest, RoundTripThroughBytesKeepsEveryField) {
  for (uint32_t seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    const JobSpec spec = RandomSpec(random);
    v1::JobSpec message;
    ASSERT_TRUE(message.ParseFromString(ToProto(spec).SerializeAsString()));
    JobLimits limits;
    limits.max_tiles = std::numeric_limits<int64_t>::max();
    const absl::StatusOr<JobSpec> back = FromProto(message, limits);
    ASSERT_TRUE(back.ok()) << "seed " << seed << ": " << back.status();
    EXPECT_EQ(*back, spec) << "seed " << seed;
  }
}

TEST(ConvertJobSpecTest, AJobOfBeforeThereWereOrdersFollowsTheCurve) {
  std::mt19937 random(1);
  v1::JobSpec message = ToProto(RandomSpec(random));
  message.set_order(v1::TILE_ORDER_COARSE);
  EXPECT_EQ(FromProto(message)->order, TileOrder::kCoarse);
  message.clear_order();
  EXPECT_EQ(FromProto(message)->order, TileOrder::kHilbert);
}

TEST(ConvertJobSpecTest, HostileMessagesAreRefusedByFieldName) {
  std::mt19937 random(1);
  JobSpec base = RandomSpec(random);
  base.render.width = base.render.height = 64;
  const v1::JobSpec good = ToProto(base);
  ASSERT_TRUE(FromProto(good).ok());
  const auto expect = [&](const char* field, const std::function<void(v1::JobSpec&)>& change) {
    v1::JobSpec message = good;
    change(message);
    const absl::StatusOr<JobSpec> spec = FromProto(message);
    EXPECT_TRUE(absl::IsInvalidArgument(spec.status())) << field << ": " << spec.status();
    EXPECT_THAT(std::string(spec.status().message()), HasSubstr(field));
  };
  const double nan = std::nan("");
  expect("render.integrator: is not specified",
         [](v1::JobSpec& s) { s.mutable_render()->clear_integrator(); });
  expect("render.resolver: value 9",
         [](v1::JobSpec& s) { s.mutable_render()->set_resolver(v1::Resolver(9)); });
  expect("render.pattern: value -1",
         [](v1::JobSpec& s) { s.mutable_render()->set_pattern(v1::Pattern(-1)); });
  expect("render.filter: value 9", [](v1::JobSpec& s) { s.mutable_render()->set_filter(v1::Filter(9)); });
  expect("filter_radius", [&](v1::JobSpec& s) { s.mutable_render()->set_filter_radius(nan); });
  expect("output.pixel_type", [](v1::JobSpec& s) { s.clear_output(); });
  expect("output.compression: value 5",
         [](v1::JobSpec& s) { s.mutable_output()->set_compression(v1::Compression(5)); });
  expect("order: value 4", [](v1::JobSpec& s) { s.set_order(v1::TileOrder(4)); });
  expect("order: value -1", [](v1::JobSpec& s) { s.set_order(v1::TileOrder(-1)); });
  expect("width", [](v1::JobSpec& s) { s.mutable_render()->set_width(kMaxFrameSide + 1); });
  expect("fps", [&](v1::JobSpec& s) { s.mutable_render()->set_fps(nan); });
  expect("shutter_close", [&](v1::JobSpec& s) { s.mutable_render()->set_shutter_close(nan); });
  expect("time_samples", [](v1::JobSpec& s) { s.mutable_render()->set_time_samples(0); });
  expect("target_error", [&](v1::JobSpec& s) {
    s.mutable_render()->clear_time_samples();
    s.mutable_render()->set_target_error(nan);
  });
  expect("motion_degree", [](v1::JobSpec& s) { s.mutable_render()->set_motion_degree(4); });
  expect("motion_pieces", [](v1::JobSpec& s) { s.mutable_render()->set_motion_pieces(3); });
  expect("render.aovs[1]: value 77", [](v1::JobSpec& s) {
    s.mutable_render()->clear_aovs();
    s.mutable_render()->add_aovs(v1::AOV_DEPTH);
    s.mutable_render()->add_aovs(v1::Aov(77));
  });
  expect("aovs: has 100", [](v1::JobSpec& s) {
    s.mutable_render()->clear_aovs();
    for (int i = 0; i < 100; ++i) s.mutable_render()->add_aovs(v1::AOV_DEPTH);
  });
  expect("mattes[1]", [](v1::JobSpec& s) {
    s.mutable_render()->clear_mattes();
    for (int i = 0; i < 2; ++i) s.mutable_render()->add_mattes(v1::MATTE_OBJECT);
  });
  expect("render.occlusion.falloff: is not specified", [](v1::JobSpec& s) {
    s.mutable_render()->mutable_occlusion()->Clear();
    s.mutable_render()->mutable_occlusion()->set_lines(3);
  });
  expect("shading_rate", [&](v1::JobSpec& s) { s.mutable_render()->set_shading_rate(nan); });
  expect("output.compression: dwaa", [](v1::JobSpec& s) {
    s.mutable_render()->clear_mattes();
    s.mutable_render()->add_mattes(v1::MATTE_OBJECT);
    s.mutable_output()->set_compression(v1::COMPRESSION_DWAA);
  });
  expect("spp", [](v1::JobSpec& s) { s.mutable_render()->set_spp(-1); });
  expect("render.camera", [](v1::JobSpec& s) { s.mutable_render()->set_camera(std::string(1025, 'x')); });
  expect("name", [](v1::JobSpec& s) { s.set_name(std::string(1025, 'x')); });
  expect("scene.files", [](v1::JobSpec& s) { s.mutable_scene()->clear_files(); });
  expect("scene.files[0].digest.sha256: has 31 bytes", [](v1::JobSpec& s) {
    s.mutable_scene()->mutable_files(0)->mutable_digest()->mutable_sha256()->pop_back();
  });
  expect("occurs twice", [](v1::JobSpec& s) { *s.mutable_scene()->add_files() = s.scene().files(0); });
  expect("frames.last", [](v1::JobSpec& s) { s.mutable_frames()->set_last(s.frames().first() - 1); });
  expect("scene.files: has 10001", [](v1::JobSpec& s) {
    for (int i = s.scene().files_size(); i < 10'001; ++i) s.mutable_scene()->add_files();
  });
  for (const char* name : {"/abs", "a/../b", "..", ".", "a//b", "a/", "a\\b", "a\nb", ""}) {
    expect("scene.files[0].name",
           [&](v1::JobSpec& s) { s.mutable_scene()->mutable_files(0)->set_name(name); });
  }
}

TEST(PictureKeyTest, DependsOnWhatChangesPixelsAndOnNothingElse) {
  std::mt19937 random(5);
  JobSpec spec = RandomSpec(random);
  spec.scene.files = {{"a", Sha256("a"), 1}, {"b", Sha256("b"), 2}};
  spec.scene.root_name = "a";
  const Digest key = PictureKey(spec.scene, spec.render);
  SceneManifest reordered = spec.scene;
  std::swap(reordered.files[0], reordered.files[1]);
  EXPECT_EQ(PictureKey(reordered, spec.render), key);
  SceneManifest renamed = spec.scene;
  std::swap(renamed.files[0].name, renamed.files[1].name);
  EXPECT_NE(PictureKey(renamed, spec.render), key);
  RenderSettings seed = spec.render, camera = spec.render;
  ++seed.seed;
  camera.camera += camera.animation.empty() ? "x" : "";
  camera.animation = "moved";
  EXPECT_NE(PictureKey(spec.scene, seed), key);
  EXPECT_NE(PictureKey(spec.scene, camera), key);
  RenderSettings named = spec.render, ranked = spec.render, open = spec.render;
  named.aovs = named.aovs.empty() ? std::vector{Aov::kDepth} : std::vector<Aov>();
  ranked.matte_ranks = ranked.matte_ranks % kMaxMatteRanks + 1;
  open.occlusion = open.occlusion ? std::nullopt : std::optional(OcclusionSettings());
  EXPECT_NE(PictureKey(spec.scene, named), key);
  EXPECT_NE(PictureKey(spec.scene, ranked), key);
  EXPECT_NE(PictureKey(spec.scene, open), key);
  RenderSettings filtered = spec.render, wider = spec.render, named_radius = spec.render;
  filtered.filter = filtered.filter == FilterKind::kBox ? FilterKind::kTriangle : FilterKind::kBox;
  wider.filter_radius = FilterRadius(wider) + 0.25;
  named_radius.filter_radius = FilterRadius(named_radius);
  EXPECT_NE(PictureKey(spec.scene, filtered), key);
  EXPECT_NE(PictureKey(spec.scene, wider), key);
  EXPECT_EQ(PictureKey(spec.scene, named_radius), key) << "the same picture";
  RenderSettings target = spec.render, finer = spec.render;
  target.target_error = 0.01;
  finer.target_error = 0.001;
  EXPECT_NE(PictureKey(spec.scene, target), key);
  EXPECT_NE(PictureKey(spec.scene, target), PictureKey(spec.scene, finer));
}

TEST(FrameRangeTest, IndexOfInvertsFrame) {
  const FrameRange range{-7, 20, 3};
  EXPECT_EQ(range.Count(), 10);
  for (int64_t i = 0; i < range.Count(); ++i) EXPECT_EQ(range.IndexOf(range.Frame(i)), i);
  EXPECT_EQ(range.IndexOf(-6), std::nullopt);
  EXPECT_EQ(range.IndexOf(23), std::nullopt);
}

TEST(ConvertStatusTest, CodesAndMessagesSurviveAndLongOnesAreCutInWholeCharacters) {
  for (int code = 0; code <= 16; ++code) {
    const absl::Status status(absl::StatusCode(code), code == 0 ? "" : "why");
    EXPECT_EQ(FromGrpc(ToGrpc(status)), status);
  }
  std::string text = "x";
  while (text.size() < 6000) text += "é";
  const std::string cut = ToGrpc(absl::InternalError(text)).error_message();
  EXPECT_LT(cut.size(), 4200u);
  EXPECT_THAT(cut, HasSubstr("more bytes"));
  EXPECT_EQ(cut.substr(0, 4095), text.substr(0, 4095));
  EXPECT_EQ(cut[4095], ' ');
}

TEST(ConvertStatusTest, RetryHintsTravelAsRetryInfoAndHostileDetailsSayNothing) {
  const absl::Status full =
      WithRetryHint(absl::ResourceExhaustedError("disk full"), absl::Milliseconds(1500));
  const grpc::Status sent = ToGrpc(full);
  // As google.rpc.Status with a google.rpc.RetryInfo of 1 s and 500,000,000 ns would be serialized.
  const std::string any = std::string("\x0a\x28") + "type.googleapis.com/google.rpc.RetryInfo" +
                          "\x12\x0a\x0a\x08\x08\x01\x10\x80\xca\xb5\xee\x01";
  EXPECT_EQ(sent.error_details(),
            std::string("\x08\x08\x12\x09") + "disk full" + "\x1a" + char(any.size()) + any);
  EXPECT_EQ(RetryHint(FromGrpc(sent)), absl::Milliseconds(1500));
  EXPECT_EQ(FromGrpc(sent).message(), "disk full");
  EXPECT_EQ(ToGrpc(absl::ResourceExhaustedError("too large")).error_details(), "");
  for (const std::string& hostile :
       {std::string("\xff\xff"), std::string(1000, '\x1a'), std::string("\x1a\x02\x12\x00", 4)}) {
    EXPECT_EQ(RetryHint(FromGrpc(grpc::Status(grpc::StatusCode::UNAVAILABLE, "x", hostile))), std::nullopt);
  }
  EXPECT_TRUE(WithRetryHint(absl::OkStatus(), absl::Seconds(1)).ok());
}

TEST(ConvertStatusTest, DurationsRoundTripAndMalformedOnesAreZero) {
  for (const absl::Duration duration :
       {absl::Nanoseconds(1), absl::Seconds(-1.5), absl::Hours(9), absl::ZeroDuration()}) {
    EXPECT_EQ(FromProto(ToProto(duration)), duration);
  }
  google::protobuf::Duration malformed;
  malformed.set_seconds(std::numeric_limits<int64_t>::max());
  EXPECT_EQ(FromProto(malformed), absl::ZeroDuration());
  malformed.set_seconds(1);
  malformed.set_nanos(-1);
  EXPECT_EQ(FromProto(malformed), absl::ZeroDuration());
}

}  // namespace
}  // namespace shutterline::convert
