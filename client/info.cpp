#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include "client/commands.h"
#include "client/frame_range.h"
#include "client/human.h"
#include "client/json_output.h"
#include "client/options.h"
#include "common/base/status_macros.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/scene_info.h"

namespace shutterline::client {
namespace {

using engine::SceneInfo;

Json BoundsJson(const Box3d& bounds) {
  if (bounds.isEmpty()) return nullptr;
  return {{"min", {bounds.min.x, bounds.min.y, bounds.min.z}},
          {"max", {bounds.max.x, bounds.max.y, bounds.max.z}}};
}

Json InfoJson(const SceneInfo& info) {
  Json json;
  json["name"] = info.name;
  json["nodes"] = info.nodes;
  json["scene_nodes"] = info.scene_nodes;
  json["mesh_nodes"] = info.mesh_nodes;
  json["mirrored_nodes"] = info.mirrored_nodes;
  json["meshes"] = info.meshes;
  json["mesh_primitives"] = info.mesh_primitives;
  json["vertices"] = info.vertices;
  json["stored_triangles"] = info.stored_triangles;
  json["drawn_triangles"] = info.drawn_triangles;
  json["drawn_primitives"] = info.drawn_primitives;
  json["materials"] = info.materials;
  json["textures"] = info.textures;
  json["texture_pixels"] = info.texture_pixels;
  json["morph_targets"] = info.morph_targets;
  json["bounds_metres"] = BoundsJson(info.bounds);
  json["materials_with"] = Json::object();
  for (const auto& [use, count] : info.materials_with) json["materials_with"][use] = count;
  json["cameras"] = json["animations"] = json["skins"] = json["images"] = json["lights"] = Json::array();
  for (const auto& light : info.lights) {
    json["lights"].push_back(
        {{"name", light.name}, {"type", engine::KindName(light.kind)}, {"nodes", light.nodes}});
  }
  for (const auto& camera : info.cameras) {
    json["cameras"].push_back({{"name", camera.name},
                               {"projection", camera.perspective ? "perspective" : "orthographic"},
                               {"node", camera.node < 0 ? Json(nullptr) : Json(camera.node)}});
  }
  for (const auto& animation : info.animations) {
    json["animations"].push_back(
        {{"name", animation.name},
         {"channels", animation.channels},
         {"keys", animation.keys},
         {"first_key_seconds", animation.first_key_seconds},
         {"last_key_seconds", animation.last_key_seconds},
         {"interpolation",
          {{"step", animation.step}, {"linear", animation.linear}, {"cubic_spline", animation.cubic_spline}}},
         {"animates",
          {{"translation", animation.translation},
           {"rotation", animation.rotation},
           {"scale", animation.scale},
           {"morph_weights", animation.morph_weights}}}});
  }
  for (const auto& skin : info.skins) {
    json["skins"].push_back({{"name", skin.name}, {"joints", skin.joints}});
  }
  for (const auto& image : info.images) {
    json["images"].push_back(
        {{"name", image.name}, {"width", image.width}, {"height", image.height}, {"bits", image.bits}});
  }
  json["skipped_points"] = info.import.skipped_points;
  json["skipped_lines"] = info.import.skipped_lines;
  json["dropped_triangles"] = info.import.dropped_triangles;
  json["warnings"] = info.import.warnings;
  return json;
}

/// A name for a list: quoted, or "unnamed".
std::string Named(const std::string& name) {
  return name.empty() ? "unnamed" : absl::StrCat("\"", Printable(name), "\"");
}

void PrintInfo(const SceneInfo& info, std::ostream& out) {
  const auto row = [&out](absl::string_view key, const std::string& value) {
    out << absl::StreamFormat("%-12s%s\n", key, value);
  };
  row("scene", Printable(info.name));
  row("nodes", absl::StrCat(info.nodes, ", in the default scene ", info.scene_nodes, ", with a mesh ",
                            info.mesh_nodes, ", mirrored ", info.mirrored_nodes));
  row("meshes", absl::StrCat(info.meshes, " of ", info.mesh_primitives, " primitives, ", info.vertices,
                             " vertices, ", info.morph_targets, " morph targets"));
  row("triangles", absl::StrCat(info.stored_triangles, " stored, ", info.drawn_triangles, " drawn"));
  row("materials", absl::StrCat(info.materials, ", ", info.textures, " textures, ", info.texture_pixels,
                                " texture pixels"));
  if (!info.materials_with.empty()) {
    row("", absl::StrCat("with ",
                         absl::StrJoin(info.materials_with, ", ", [](std::string* text, const auto& use) {
                           absl::StrAppend(text, use.first, " ", use.second);
                         })));
  }
  if (!info.bounds.isEmpty()) {
    const auto& low = info.bounds.min;
    const auto& high = info.bounds.max;
    row("bounds", absl::StrFormat("(%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) metres", low.x, low.y, low.z,
                                  high.x, high.y, high.z));
  }
  if (info.cameras.empty()) row("cameras", "none: the scene is framed automatically");
  for (size_t i = 0; i < info.cameras.size(); ++i) {
    const auto& camera = info.cameras[i];
    row("camera",
        absl::StrCat(i, " ", Named(camera.name), camera.perspective ? ", perspective" : ", orthographic",
                     camera.node < 0 ? ", not in the default scene" : ""));
  }
  for (size_t i = 0; i < info.lights.size(); ++i) {
    const auto& light = info.lights[i];
    const std::string places = light.nodes == 0   ? ", not in the default scene"
                               : light.nodes == 1 ? ""
                                                  : absl::StrCat(", at ", light.nodes, " nodes");
    row("light", absl::StrCat(i, " ", Named(light.name), ", ", engine::KindName(light.kind), places));
  }
  if (info.animations.empty()) row("animations", "none");
  for (size_t i = 0; i < info.animations.size(); ++i) {
    const auto& a = info.animations[i];
    row("animation", absl::StrFormat("%d %s, %.6g to %.6g s, %d channels, %d keys", i, Named(a.name),
                                     a.first_key_seconds, a.last_key_seconds, a.channels, a.keys));
  }
  for (size_t i = 0; i < info.skins.size(); ++i) {
    row("skin", absl::StrCat(i, " ", Named(info.skins[i].name), ", ", info.skins[i].joints, " joints"));
  }
  for (size_t i = 0; i < info.images.size(); ++i) {
    const auto& image = info.images[i];
    row("image", absl::StrCat(i, " ", Named(image.name), ", ", image.width, "x", image.height,
                              image.bits == 16 ? ", 16 bits" : ""));
  }
  const auto& report = info.import;
  if (report.skipped_points + report.skipped_lines + report.dropped_triangles > 0) {
    row("left out", absl::StrCat(report.skipped_points, " points, ", report.skipped_lines, " lines, ",
                                 report.dropped_triangles, " triangles that are not finite"));
  }
  for (const std::string& warning : report.warnings) row("warning", Printable(warning));
}

Json MotionJson(const engine::FrameInfo& frame, int number) {
  Json json;
  json["frame"] = number;
  json["primitives_by_degree"] = frame.primitives_by_degree;
  json["triangles_by_degree"] = frame.triangles_by_degree;
  json["moving_primitives_by_pieces"] = Json::object();
  for (const auto& [pieces, count] : frame.moving_by_pieces) {
    json["moving_primitives_by_pieces"][absl::StrCat(pieces)] = count;
  }
  json["largest_motion_pixels"] = frame.largest_motion_pixels;
  json["warnings"] = frame.warnings;
  return json;
}

class InfoCommand : public Command {
 public:
  void Declare(CLI::App& app) override {
    AddSceneArgument(app, scene_);
    AddValue(app, "--frame", "N", "none",
             "Also tell how things move in this frame, as rendered with\nthe defaults",
             [this](const std::string& t) -> absl::Status {
               SL_ASSIGN_OR_RETURN(const FrameRange frames, ParseFrame(t));
               frame_ = frames.first;
               return absl::OkStatus();
             });
    AddJsonOption(app, json_);
    AddExamples(app, {"shutterline info fox.glb", "shutterline info fox.glb --json"},
                "Names and indices of cameras and animations are what --camera and --animation take.");
  }

  absl::StatusOr<ExitCode> Run(Console& console) override {
    const auto source = engine::DirectoryAssetSource::Open(scene_);
    if (!source.ok()) return Annotate(source.status(), absl::StrCat("load scene ", scene_));
    SL_ASSIGN_OR_RETURN(const auto scene, engine::ImportGltf(**source));
    const SceneInfo info = engine::DescribeScene(*scene);
    std::optional<engine::FrameInfo> motion;
    if (frame_) {
      SL_ASSIGN_OR_RETURN(const auto frame, engine::BuildFrameScene(scene, *frame_, RenderSettings()));
      motion = engine::DescribeFrame(*frame);
    }
    if (json_) {
      Json json = InfoJson(info);
      if (motion) json["motion"] = MotionJson(*motion, *frame_);
      Print(json, console.out);
    } else {
      PrintInfo(info, console.out);
      if (motion) {
        console.out << absl::StreamFormat("%-12sframe %d: %s\n", "motion", *frame_, MotionSummary(*motion));
        for (const std::string& warning : motion->warnings) {
          console.out << absl::StreamFormat("%-12s%s\n", "warning", Printable(warning));
        }
      }
    }
    return ExitCode::kSuccess;
  }

 private:
  std::string scene_;
  std::optional<int> frame_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeInfoCommand() {
  return std::make_unique<InfoCommand>();
}

}  // namespace shutterline::client
