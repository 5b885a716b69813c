#include "worker/engine/scene/frame_builder.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/scene/motion.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

/// A primitive whose true path leaves its control points' by more than this is named in the warnings.
constexpr double kDeviationPixels = 0.5;
/// Warnings name this many primitives, the worst first, and count the rest.
constexpr size_t kNamedPrimitives = 16;
/// Besides 1/4, 1/2 and 3/4, the path is checked at so many keys inside the shutter.
constexpr size_t kCheckedKeys = 13;

bool AreEqual(const std::vector<V4f>& colors) {
  return !colors.empty() &&
         std::all_of(colors.begin(), colors.end(), [&](const V4f& color) { return color == colors[0]; });
}

}  // namespace

FrameBuilder::FrameBuilder(std::shared_ptr<const Scene> scene, std::vector<const AnimationChannel*> channels,
                           CameraChoice choice, int frame, const RenderSettings& settings)
    : scene_(*scene),
      choice_(choice),
      open_seconds_((frame + settings.shutter_open) / settings.fps),
      close_seconds_((frame + settings.shutter_close) / settings.fps),
      settings_(settings),
      sampler_(*scene, std::move(channels)),
      frame_(std::make_shared<FrameScene>()) {
  frame_->scene = std::move(scene);
}

absl::Status FrameBuilder::Build() {
  SL_RETURN_IF_ERROR(MakeView());
  SL_RETURN_IF_ERROR(PlaceMeshes());
  SL_ASSIGN_OR_RETURN(const Moment open, MomentAt(0));
  if (!anything_moves_) {
    LayOutVertices();
    EvaluateVertices(open, open, open);
  } else {
    SL_ASSIGN_OR_RETURN(const Moment middle, MomentAt(0.5));
    SL_ASSIGN_OR_RETURN(const Moment close, MomentAt(1));
    FindDegrees(open, close);
    LayOutVertices();
    EvaluateVertices(open, close, middle);
  }
  MakeTriangles();
  CheckPaths();
  MakeTextures();
  return absl::OkStatus();
}

absl::StatusOr<FrameBuilder::Moment> FrameBuilder::MomentAt(double t) const {
  const double seconds = t == 0   ? open_seconds_
                         : t == 1 ? close_seconds_
                                  : (1 - t) * open_seconds_ + t * close_seconds_;
  Moment moment{sampler_.At(seconds), CameraPose()};
  if (auto_camera_) {
    moment.camera = auto_camera_->pose;
    return moment;
  }
  const std::optional<CameraPose> camera = CameraPoseFrom(moment.pose.world_from_node[size_t(choice_.node)]);
  if (!camera) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scene ", scene_.name, ": camera node ", choice_.node, " \"", scene_.nodes[size_t(choice_.node)].name,
        "\" has no orientation at ", seconds, " s: its axes are zero, parallel or not finite"));
  }
  moment.camera = *camera;
  return moment;
}

MeshPose FrameBuilder::PoseOf(const PlacedMesh& placed, const Moment& moment) const {
  return MeshPose(scene_, placed.node, moment.pose, moment.camera);
}

absl::Status FrameBuilder::MakeView() {
  if (choice_.IsAutomatic()) {
    auto_camera_ = MakeAutoCamera(AnimationBounds(sampler_), settings_.width, settings_.height);
  } else {
    camera_moves_ = sampler_.Moves(choice_.node);
  }
  const Camera& camera = auto_camera_ ? auto_camera_->camera : scene_.cameras[size_t(choice_.camera)];
  SL_ASSIGN_OR_RETURN(frame_->view, MakeFrameView(camera, settings_.width, settings_.height));
  return absl::OkStatus();
}

absl::Status FrameBuilder::PlaceMeshes() {
  const bool still = open_seconds_ == close_seconds_;
  uint64_t triangles = 0, vertices = 0;
  for (const int node : NodesInDefaultScene(scene_)) {
    const int mesh_index = scene_.nodes[size_t(node)].mesh;
    if (mesh_index < 0) continue;
    const Mesh& mesh = scene_.meshes[size_t(mesh_index)];
    PlacedMesh placed{node, &mesh, frame_->primitives.size(), false};
    placed.moves = !still && (camera_moves_ || sampler_.MeshMoves(node));
    anything_moves_ = anything_moves_ || placed.moves;
    for (const MeshPrimitive& source : mesh.primitives) {
      FramePrimitive primitive;
      primitive.source = &source;
      primitive.material = &scene_.materials[size_t(source.material)];
      primitive.node = node;
      primitive.has_normals = !primitive.material->unlit && !source.normals.empty();
      primitive.uniform_colors = primitive.material->unlit && AreEqual(source.colors);
      primitive.first_vertex = uint32_t(vertices);
      primitive.vertex_count = uint32_t(source.positions.size());
      triangles += source.triangles.size();
      vertices += source.positions.size();
      frame_->primitives.push_back(primitive);
      // The top numbers are kept free for marks such as "none".
      constexpr uint64_t kMost = std::numeric_limits<uint32_t>::max() - 1;
      if (triangles > kMost || vertices > kMost) {
        return absl::ResourceExhaustedError(
            absl::StrCat("scene ", scene_.name, ": node ", node, " \"", scene_.nodes[size_t(node)].name,
                         "\" brings the frame to ", triangles, " triangles and ", vertices,
                         " vertices, but at most ", kMost, " of each are possible"));
      }
    }
    placed_.push_back(placed);
  }
  return absl::OkStatus();
}

void FrameBuilder::FindDegrees(const Moment& open, const Moment& close) {
  tbb::parallel_for(size_t{0}, placed_.size(), [&](size_t i) {
    const PlacedMesh& placed = placed_[i];
    if (!placed.moves) return;
    const MeshPose at_open = PoseOf(placed, open), at_close = PoseOf(placed, close);
    for (size_t k = 0; k < placed.mesh->primitives.size(); ++k) {
      frame_->primitives[placed.first_primitive + k].degree =
          AnyVertexMoves(frame_->view, placed.mesh->primitives[k], at_open, at_close) ? 1 : 0;
    }
  });
}

void FrameBuilder::LayOutVertices() {
  uint64_t control_points = 0, normals = 0;
  for (FramePrimitive& primitive : frame_->primitives) {
    primitive.first_control_point = control_points;
    control_points += uint64_t{primitive.vertex_count} * uint64_t(primitive.degree + 1);
    primitive.first_normal = normals;
    if (primitive.has_normals) normals += primitive.vertex_count;
  }
  frame_->control_points.resize(control_points);
  frame_->normals.resize(normals);
}

void FrameBuilder::EvaluateVertices(const Moment& open, const Moment& close, const Moment& middle) {
  usable_.assign(frame_->primitives.size(), 0);
  tbb::parallel_for(size_t{0}, placed_.size(), [&](size_t i) {
    const PlacedMesh& placed = placed_[i];
    const MeshPose at_open = PoseOf(placed, open);
    const std::optional<MeshPose> at_close =
        placed.moves ? std::optional(PoseOf(placed, close)) : std::nullopt;
    const std::optional<MeshPose> at_middle =
        placed.moves ? std::optional(PoseOf(placed, middle)) : std::nullopt;
    for (size_t k = 0; k < placed.mesh->primitives.size(); ++k) {
      const MeshPrimitive& source = placed.mesh->primitives[k];
      FramePrimitive& primitive = frame_->primitives[placed.first_primitive + k];
      const std::span<RasterPoint> points(frame_->control_points.data() + primitive.first_control_point,
                                          primitive.vertex_count * size_t(primitive.degree + 1));
      const ControlPointFacts facts = WriteControlPoints(frame_->view, source, primitive.degree, at_open,
                                                         at_close ? *at_close : at_open, points);
      usable_[placed.first_primitive + k] = facts.all_usable;
      primitive.motion_pixels = facts.motion_pixels;
      // At mid-shutter, as the normals: a node that grows from nothing has no sides at shutter open.
      primitive.mirrored = (at_middle ? *at_middle : at_open).Mirrors(source);
      if (!primitive.has_normals) continue;
      const MeshPose& normal_pose = at_middle ? *at_middle : at_open;
      tbb::parallel_for(uint32_t{0}, primitive.vertex_count, [&](uint32_t v) {
        frame_->normals[primitive.first_normal + v] = V3f(normal_pose.Normal(source, v));
      });
    }
  });
}

void FrameBuilder::MakeTriangles() {
  std::vector<FramePrimitive>& primitives = frame_->primitives;
  const auto is_usable = [&](const FramePrimitive& primitive, const std::array<uint32_t, 3>& triangle) {
    for (const uint32_t corner : triangle) {
      for (int i = 0; i < primitive.PointsPerVertex(); ++i) {
        if (!IsUsable(frame_->ControlPoint(primitive, primitive.first_vertex + corner, i))) return false;
      }
    }
    return true;
  };

  // Count the triangles that can be drawn.
  tbb::parallel_for(size_t{0}, primitives.size(), [&](size_t i) {
    FramePrimitive& primitive = primitives[i];
    const auto& triangles = primitive.source->triangles;
    primitive.triangle_count = uint32_t(
        usable_[i] ? triangles.size() : std::count_if(triangles.begin(), triangles.end(), [&](const auto& t) {
          return is_usable(primitive, t);
        }));
  });
  uint32_t total = 0;
  for (FramePrimitive& primitive : primitives) {
    primitive.first_triangle = total;
    total += primitive.triangle_count;
    const int64_t dropped = int64_t(primitive.source->triangles.size()) - primitive.triangle_count;
    if (dropped == 0) continue;
    frame_->dropped_triangles += dropped;
    frame_->warnings.push_back(absl::StrCat(NameOf(primitive), ": ", dropped,
                                            " triangles are left out: a corner is not a finite number"));
  }

  // Write them, mirrored ones with two corners swapped.
  frame_->triangles.resize(total);
  tbb::parallel_for(size_t{0}, primitives.size(), [&](size_t i) {
    const FramePrimitive& primitive = primitives[i];
    FrameTriangle* out = frame_->triangles.data() + primitive.first_triangle;
    for (const std::array<uint32_t, 3>& triangle : primitive.source->triangles) {
      if (!usable_[i] && !is_usable(primitive, triangle)) continue;
      FrameTriangle made{{}, uint32_t(i)};
      for (size_t k = 0; k < 3; ++k) made.vertices[k] = primitive.first_vertex + triangle[k];
      if (primitive.mirrored) std::swap(made.vertices[1], made.vertices[2]);
      *out++ = made;
    }
  });
}

void FrameBuilder::CheckPaths() {
  if (!anything_moves_) return;
  std::vector<double> times{0.25, 0.5, 0.75};
  for (const double key : sampler_.KeyTimes(open_seconds_, close_seconds_, kCheckedKeys)) {
    times.push_back((key - open_seconds_) / (close_seconds_ - open_seconds_));
  }
  struct Worst {
    double pixels = 0, t = 0;
  };
  std::vector<Worst> worst(frame_->primitives.size());
  for (const double t : times) {
    const absl::StatusOr<Moment> moment = MomentAt(t);
    if (!moment.ok()) {
      frame_->warnings.push_back(std::string(moment.status().message()));
      continue;
    }
    tbb::parallel_for(size_t{0}, placed_.size(), [&](size_t i) {
      const PlacedMesh& placed = placed_[i];
      if (!placed.moves) return;
      const MeshPose pose = PoseOf(placed, *moment);
      for (size_t k = placed.first_primitive; k < placed.first_primitive + placed.mesh->primitives.size();
           ++k) {
        const double pixels = PathDeviation(*frame_, frame_->primitives[k], pose, t);
        if (pixels > worst[k].pixels) worst[k] = {pixels, t};
      }
    });
  }

  // Name the worst.
  std::vector<size_t> bent;
  for (size_t i = 0; i < worst.size(); ++i) {
    if (worst[i].pixels > kDeviationPixels) bent.push_back(i);
  }
  std::stable_sort(bent.begin(), bent.end(),
                   [&](size_t a, size_t b) { return worst[a].pixels > worst[b].pixels; });
  for (size_t i = 0; i < std::min(bent.size(), kNamedPrimitives); ++i) {
    frame_->warnings.push_back(absl::StrFormat(
        "%s: its path is bent, but is rendered as a straight one that lies up to %.2f px beside it (at "
        "shutter time %.2f)",
        NameOf(frame_->primitives[bent[i]]), worst[bent[i]].pixels, worst[bent[i]].t));
  }
  if (bent.size() > kNamedPrimitives) {
    frame_->warnings.push_back(
        absl::StrFormat("%d more primitives have bent paths, up to %.2f px beside the straight ones",
                        bent.size() - kNamedPrimitives, worst[bent[kNamedPrimitives]].pixels));
  }
}

void FrameBuilder::MakeTextures() {
  std::vector<int> images;
  const auto use = [&](const TextureRef& reference) {
    if (reference.texture < 0) return;
    const int image = scene_.textures[size_t(reference.texture)].image;
    if (image >= 0) images.push_back(image);
  };
  for (const FramePrimitive& primitive : frame_->primitives) {
    use(primitive.material->base_color_texture);
    if (!primitive.material->unlit) use(primitive.material->emissive_texture);
  }
  std::sort(images.begin(), images.end());
  images.erase(std::unique(images.begin(), images.end()), images.end());
  frame_->textures.resize(scene_.images.size());
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    frame_->textures[size_t(images[i])] = scene_.mip_pyramids.Get(scene_.images, images[i]);
  });
}

std::string FrameBuilder::NameOf(const FramePrimitive& primitive) const {
  const Node& node = scene_.nodes[size_t(primitive.node)];
  const Mesh& mesh = scene_.meshes[size_t(node.mesh)];
  return absl::StrCat("node ", primitive.node, " \"", node.name, "\", mesh ", node.mesh, " \"", mesh.name,
                      "\", primitive ", primitive.source - mesh.primitives.data());
}

}  // namespace shutterline::engine
