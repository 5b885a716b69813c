#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <tuple>

#include "tests/engine/scene_import/import_helpers.h"

// KHR_lights_punctual.
namespace shutterline::engine::light_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// A triangle, drawn by node 0, and these lights.
GltfBuilder WithLights(const std::vector<json>& lights) {
  GltfBuilder file;
  file.DrawTriangle();
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = lights;
  file.json["extensionsRequired"] = {"KHR_lights_punctual"};
  return file;
}

void Place(int light, GltfBuilder* file) {
  file->json["nodes"][0]["extensions"]["KHR_lights_punctual"] = {{"light", light}};
}

TEST(GltfLight, ReadsEveryProperty) {
  GltfBuilder file = WithLights(
      {{{"type", "point"}},
       {{"type", "directional"}, {"name", "sun"}, {"color", {1, 0.5, 0}}, {"intensity", 100000}},
       {{"type", "spot"}, {"range", 2.5}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}},
       {{"type", "spot"}, {"spot", json::object()}}});
  Place(2, &file);
  const auto scene = MustImport(file);
  ASSERT_EQ(scene->lights.size(), 4u);
  EXPECT_EQ(scene->nodes[0].light, 2);
  const PunctualLight& plain = scene->lights[0];
  EXPECT_EQ(plain.kind, PunctualLight::Kind::kPoint);
  EXPECT_EQ(plain.color, V3f(1));
  EXPECT_EQ(plain.intensity, 1);
  EXPECT_EQ(plain.range, 0);
  const PunctualLight& sun = scene->lights[1];
  EXPECT_EQ(sun.kind, PunctualLight::Kind::kDirectional);
  EXPECT_EQ(sun.name, "sun");
  EXPECT_EQ(sun.color, V3f(1, 0.5f, 0));
  EXPECT_EQ(sun.intensity, 100000);
  const PunctualLight& spot = scene->lights[2];
  EXPECT_EQ(spot.kind, PunctualLight::Kind::kSpot);
  EXPECT_EQ(spot.range, 2.5f);
  EXPECT_EQ(spot.inner_cone, 0.25f);
  EXPECT_EQ(spot.outer_cone, 0.5f);
  EXPECT_EQ(scene->lights[3].inner_cone, 0);
  EXPECT_EQ(scene->lights[3].outer_cone, float(std::numbers::pi / 4));
}

TEST(GltfLight, NodesWithoutOneHaveNone) {
  EXPECT_EQ(MustImport(WithLights({{{"type", "point"}}}))->nodes[0].light, -1);
}

TEST(GltfLight, ConesMayTouchAndReachTheRightAngle) {
  const auto spot = [](double inner, double outer) {
    return WithLights({{{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}}});
  };
  // A right angle as a double and as the float above it.
  EXPECT_EQ(MustImport(spot(0, std::numbers::pi / 2))->lights[0].outer_cone, float(std::numbers::pi / 2));
  EXPECT_EQ(MustImport(spot(0.5, double(float(std::numbers::pi / 2))))->lights.size(), 1u);
  EXPECT_EQ(MustImport(spot(0.5, 0.5))->lights[0].inner_cone, 0.5f);
  const std::pair<double, double> wrong[] = {{0.6, 0.5}, {-0.1, 0.5}, {0, 1.6}, {0, 0}, {0, -1}};
  for (const auto& [inner, outer] : wrong) {
    const absl::Status status = MustFail(spot(inner, outer));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("light 0: "));
    EXPECT_THAT(status.message(), HasSubstr("ConeAngle"));
  }
}

TEST(GltfLight, WrongPropertiesAreNamed) {
  const std::tuple<json, const char*> cases[] = {
      {{{"name", "lamp"}}, "lights[0]: required property type is missing"},
      {{{"type", "ambient"}}, "lights[0].type: \"ambient\" is none of directional, point, spot"},
      {{{"type", "spot"}, {"name", "lamp"}}, "light 0 (lamp): a spot without the property spot"},
      {{{"type", "point"}, {"color", {1, 1}}}, "lights[0].color: it has 2 numbers instead of 3"},
      {{{"type", "point"}, {"color", {1, -1, 1}}}, "light 0: color -1 is negative"},
      {{{"type", "point"}, {"intensity", -2}}, "light 0: intensity -2 is negative"},
      {{{"type", "point"}, {"intensity", 1e300}}, "lights[0].intensity: 1e+300 does not fit"},
      {{{"type", "point"}, {"range", 0}}, "light 0: range 0 is not above 0"},
      {{{"type", "point"}, {"range", -1}}, "light 0: range -1 is not above 0"},
      {7, "lights[0]: 7 is not an object"}};
  for (const auto& [light, message] : cases) {
    SCOPED_TRACE(light.dump());
    const absl::Status status = MustFail(WithLights({light}));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("load scene test.glb: "));
    EXPECT_THAT(status.message(), HasSubstr(message));
  }
}

TEST(GltfLight, NodesNameLightsThatExist) {
  GltfBuilder file = WithLights({{{"type", "point"}}});
  Place(1, &file);
  EXPECT_THAT(MustFail(file).message(), HasSubstr("node 0: extensions.KHR_lights_punctual.light: 1 does not "
                                                  "exist: the file has 1 lights"));
  file.json.erase("extensions");
  EXPECT_THAT(MustFail(file).message(), HasSubstr("the file has 0 lights"));
  file.json["nodes"][0].erase("extensions");
  file.json["extensions"] = json::array();
  EXPECT_THAT(MustFail(file).message(), HasSubstr("an array is not an object"));
}

}  // namespace
}  // namespace shutterline::engine::light_test
