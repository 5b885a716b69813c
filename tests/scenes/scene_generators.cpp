#include "tests/scenes/scene_generators.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>

#include "common/base/status_macros.h"
#include "tests/scenes/glb_writer.h"
#include "tests/scenes/scene_functions.h"

namespace shutterline::scenes {
namespace {

struct Entry {
  SceneInfo info;
  GlbScene (*make)(const SceneOptions&);
};

const std::vector<Entry>& Entries() {
  static const std::vector<Entry> entries = {
      {{"plane", "a plane of checkered cells (--tessellation 16) that pans (--motion 60)", 1, 0, 1, 1024,
        1000},
       MakePlane},
      {{"fan", "blades that turn 30 degrees (--motion: pixels at their tips) behind a still guard", 1, 0, 1,
        0, 1000},
       MakeFan},
      {{"debris", "triangles (--triangles 5000), each on a line of its own (--motion 60 for the fastest)", 1,
        2000000, 1, 0, 1000},
       MakeDebris},
      {{"trees", "a forest (--triangles 270000) that the camera passes (--motion 64 for the nearest leaf)",
        60000, 5000000, 1, 0, 1000},
       MakeTrees},
      {{"static", "a relief of subpixel triangles (--triangles 100000) that stands still (--motion 0)", 24,
        5000000, 1, 0, 1000},
       MakeStatic},
      {{"chess", "a game over which taken pieces tumble, lit (--motion 40: about, for the fastest)", 1, 0, 1,
        0, 80, true},
       MakeChess},
      {{"armadillo",
        "a clay armadillo (--triangles 88120) that bursts into pieces (--motion 50: about, for the fastest)",
        20000, 2000000, 1, 0, 200, true},
       MakeArmadillo},
      {{"clothball",
        "a cloth (--tessellation 196) over a ball, turning by 45 degrees (--motion: pixels at the rim)", 1, 0,
        1, 1000, 1000, true},
       MakeClothBall},
      {{"hall", "a lit hall of columns, seen by a camera that turns (--motion 32 in the middle)", 1, 0, 1, 0,
        400, true},
       MakeHall},
      {{"demo", "a toy windmill among tumbling solids, lit", 1, 0, 1, 0, -1}, MakeDemo},
  };
  return entries;
}

template <typename T>
absl::Status CheckOption(const SceneInfo& info, absl::string_view option, const std::optional<T>& value,
                         T min, T max) {
  if (!value) return absl::OkStatus();
  if (min > max) {
    return absl::InvalidArgumentError(absl::StrCat("scene ", info.name, " does not take ", option));
  }
  if (!(*value >= min && *value <= max)) {
    return absl::InvalidArgumentError(
        absl::StrCat("scene ", info.name, ": ", option, " is ", *value, ", must be ", min, " to ", max));
  }
  return absl::OkStatus();
}

}  // namespace

const std::vector<SceneInfo>& AllScenes() {
  static const std::vector<SceneInfo> infos = [] {
    std::vector<SceneInfo> result;
    for (const Entry& entry : Entries()) result.push_back(entry.info);
    return result;
  }();
  return infos;
}

absl::StatusOr<GlbScene> GenerateScene(absl::string_view name, const SceneOptions& options) {
  const auto entry = std::find_if(Entries().begin(), Entries().end(),
                                  [&](const Entry& candidate) { return candidate.info.name == name; });
  if (entry == Entries().end()) {
    return absl::NotFoundError(
        absl::StrCat("no scene is named '", name, "'; there are ",
                     absl::StrJoin(AllScenes(), ", ",
                                   [](std::string* out, const SceneInfo& info) { *out += info.name; })));
  }
  const SceneInfo& info = entry->info;
  SL_RETURN_IF_ERROR(
      CheckOption(info, "--triangles", options.triangles, info.min_triangles, info.max_triangles));
  SL_RETURN_IF_ERROR(CheckOption(info, "--tessellation", options.tessellation, info.min_tessellation,
                                 info.max_tessellation));
  SL_RETURN_IF_ERROR(CheckOption(info, "--motion", options.motion_pixels, 0.0, info.max_motion));
  GlbScene scene = entry->make(options);
  scene.name = info.name;
  return scene;
}

absl::StatusOr<std::string> GenerateGlb(absl::string_view name, const SceneOptions& options) {
  SL_ASSIGN_OR_RETURN(const GlbScene scene, GenerateScene(name, options));
  return EncodeGlb(scene);
}

}  // namespace shutterline::scenes
