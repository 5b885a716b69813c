#include "worker/engine/scene/frame_builder.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/limited_parallel.h"
#include "worker/engine/scene/material_textures.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

/// Warnings name this many meshes whose motion misses their path, the worst first, and count the rest.
constexpr size_t kNamedMeshes = 16;
constexpr uint32_t kTaskSize = 1024;

/// Calls `f(begin, end)`, in parallel, with parts of what is below `count`, within the limit of who calls.
template <typename F>
void ForParts(uint32_t count, F f) {
  const WorkLimit* const limit = WorkLimit::Current();
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, count, kTaskSize),
                    [&](const tbb::blocked_range<uint32_t>& range) {
                      CheckWork(limit);
                      f(range.begin(), range.end());
                    });
}

bool AreEqual(const std::vector<V4f>& colors) {
  return !colors.empty() &&
         std::all_of(colors.begin(), colors.end(), [&](const V4f& color) { return color == colors[0]; });
}

}  // namespace

FrameBuilder::FrameBuilder(std::shared_ptr<const Scene> scene, std::vector<const AnimationChannel*> channels,
                           CameraChoice choice, int frame, const RenderSettings& settings)
    : scene_(*scene),
      choice_(choice),
      settings_(settings),
      shutter_(*scene, PoseSampler(*scene, std::move(channels)), choice.node,
               (frame + settings.shutter_open) / settings.fps,
               (frame + settings.shutter_close) / settings.fps),
      frame_(std::make_shared<FrameScene>()) {
  frame_->scene = std::move(scene);
}

absl::Status FrameBuilder::Build() {
  SL_RETURN_IF_ERROR(MakeView());
  SL_RETURN_IF_ERROR(PlaceMeshes());
  SL_ASSIGN_OR_RETURN(const Moment open, shutter_.At(0));
  // What shades is taken at mid-shutter: a node that grows from nothing has no sides at shutter open.
  std::optional<Moment> middle;
  if (anything_moves_) {
    SL_ASSIGN_OR_RETURN(middle, shutter_.At(0.5));
    SL_RETURN_IF_ERROR(shutter_.At(1).status());
  }
  const Moment& shading = middle ? *middle : open;
  FitMotion(open);
  SL_RETURN_IF_ERROR(LayOutVertices(open));
  EvaluateNormals(shading);
  MakeTriangles();
  EvaluateTangents(shading);
  frame_->view.world_axes = shading.camera.WorldAxes();
  frame_->view.world_position = shading.camera.position;
  frame_->lights = PlaceLights(scene_, shading, frame_->warnings);
  NameMisses();
  MakeTextures();
  return absl::OkStatus();
}

absl::Status FrameBuilder::MakeView() {
  if (choice_.IsAutomatic()) {
    auto_camera_ =
        MakeAutoCamera(scene_.facts.BoundsOf(shutter_.sampler()), settings_.width, settings_.height);
    shutter_.SetFixedCamera(auto_camera_->pose);
  }
  const Camera& camera = auto_camera_ ? auto_camera_->camera : scene_.cameras[size_t(choice_.camera)];
  SL_ASSIGN_OR_RETURN(frame_->view, MakeFrameView(camera, settings_.width, settings_.height));
  return absl::OkStatus();
}

absl::Status FrameBuilder::PlaceMeshes() {
  uint64_t triangles = 0, vertices = 0;
  for (const int node : NodesInDefaultScene(scene_)) {
    CheckWork();
    const bool is_light = scene_.nodes[size_t(node)].light >= 0;
    if (is_light && !shutter_.IsStill() && shutter_.sampler().Moves(node)) anything_moves_ = true;
    const int mesh_index = scene_.nodes[size_t(node)].mesh;
    if (mesh_index < 0) continue;
    const Mesh& mesh = scene_.meshes[size_t(mesh_index)];
    PlacedMesh placed{node, &mesh, frame_->primitives.size(), false};
    placed.moves = !shutter_.IsStill() && (shutter_.CameraMoves() || shutter_.sampler().MeshMoves(node));
    anything_moves_ = anything_moves_ || placed.moves;
    for (const MeshPrimitive& source : mesh.primitives) {
      FramePrimitive primitive;
      primitive.source = &source;
      primitive.material = &scene_.materials[size_t(source.material)];
      primitive.node = node;
      primitive.has_normals = !primitive.material->unlit && !source.normals.empty();
      primitive.has_tangents = ShowsNormalTexture(*primitive.material, source) &&
                               source.tangents.size() == 3 * source.triangles.size();
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

void FrameBuilder::FitMotion(const Moment& open) {
  std::vector<size_t> moving;
  for (const PlacedMesh& placed : placed_) {
    const size_t mesh = size_t(placed.mesh - scene_.meshes.data());
    if (placed.moves && vertex_sets_.try_emplace(placed.mesh).second) moving.push_back(mesh);
  }
  ForEach(moving.size(), [&](size_t i) {
    vertex_sets_.at(&scene_.meshes[moving[i]]) = scene_.facts.VertexSetsOf(scene_.meshes, moving[i]);
  });
  MotionFitter fitter(scene_, frame_->view, shutter_, settings_, placed_, vertex_sets_);
  fitted_ = fitter.Fit(open, frame_->warnings);
  for (size_t i = 0; i < placed_.size(); ++i) {
    for (size_t k = 0; k < fitted_[i].moves.size(); ++k) {
      if (!fitted_[i].moves[k]) continue;
      FramePrimitive& primitive = frame_->primitives[placed_[i].first_primitive + k];
      primitive.degree = fitted_[i].degree;
      primitive.pieces = fitted_[i].pieces;
    }
  }
}

absl::Status FrameBuilder::LayOutVertices(const Moment& still) {
  uint64_t control_points = 0, normals = 0;
  for (FramePrimitive& primitive : frame_->primitives) {
    primitive.first_control_point = control_points;
    control_points += uint64_t{primitive.vertex_count} * uint64_t(primitive.PointsPerVertex());
    primitive.first_normal = normals;
    if (primitive.has_normals) normals += primitive.vertex_count;
  }
  frame_->control_points.resize(control_points);
  frame_->normals.resize(normals);
  usable_.assign(frame_->primitives.size(), 0);

  // What moves passes through places at these times.
  std::map<double, Moment> moments;
  for (const FittedMesh& fitted : fitted_) {
    const int last = fitted.degree * fitted.pieces;
    for (int i = 0; i <= last && last > 0; ++i) {
      const double t = double(i) / last;
      if (moments.count(t) != 0) continue;
      SL_ASSIGN_OR_RETURN(Moment moment, shutter_.At(t));
      moments.emplace(t, std::move(moment));
    }
  }
  ForEach(placed_.size(), [&](size_t i) {
    const PlacedMesh& placed = placed_[i];
    const FittedMesh& fitted = fitted_[i];
    const MeshPose rest(scene_, placed.node, still.pose, still.camera);
    const int last = fitted.degree * fitted.pieces;
    std::vector<MeshPose> knots;
    for (int k = 0; k <= last && last > 0; ++k) {
      const Moment& moment = moments.at(double(k) / last);
      knots.emplace_back(scene_, placed.node, moment.pose, moment.camera);
    }
    std::vector<const MeshPose*> poses;
    for (const MeshPose& knot : knots) poses.push_back(&knot);
    const MeshPose* const at_rest = &rest;
    for (size_t k = 0; k < placed.mesh->primitives.size(); ++k) {
      FramePrimitive& primitive = frame_->primitives[placed.first_primitive + k];
      const bool moves = primitive.degree > 0;
      const ControlPointFacts facts =
          WriteCurves(frame_->view, *primitive.source,
                      moves ? std::span<const uint8_t>((*vertex_sets_.at(placed.mesh))[k].used)
                            : std::span<const uint8_t>(),
                      moves ? std::span(poses) : std::span(&at_rest, 1), primitive.degree, primitive.pieces,
                      std::span(frame_->control_points)
                          .subspan(primitive.first_control_point,
                                   size_t{primitive.vertex_count} * size_t(primitive.PointsPerVertex())));
      usable_[placed.first_primitive + k] = facts.all_usable;
      primitive.motion_pixels = facts.motion_pixels;
      primitive.linear_pieces = LinearPiecesFor(primitive.degree, primitive.pieces, facts.chord_pixels);
    }
  });
  return absl::OkStatus();
}

void FrameBuilder::EvaluateNormals(const Moment& moment) {
  ForEach(placed_.size(), [&](size_t i) {
    const PlacedMesh& placed = placed_[i];
    const MeshPose pose(scene_, placed.node, moment.pose, moment.camera);
    for (size_t k = 0; k < placed.mesh->primitives.size(); ++k) {
      const MeshPrimitive& source = placed.mesh->primitives[k];
      FramePrimitive& primitive = frame_->primitives[placed.first_primitive + k];
      primitive.mirrored = pose.Mirrors(source);
      if (!primitive.has_normals) continue;
      ForParts(primitive.vertex_count, [&](uint32_t begin, uint32_t end) {
        pose.WriteNormals(source, begin,
                          std::span(frame_->normals).subspan(primitive.first_normal + begin, end - begin));
      });
    }
  });
}

bool FrameBuilder::IsDrawn(const FramePrimitive& primitive, const std::array<uint32_t, 3>& triangle) const {
  for (const uint32_t corner : triangle) {
    for (int i = 0; i < primitive.PointsPerVertex(); ++i) {
      if (!IsUsable(frame_->ControlPoint(primitive, primitive.first_vertex + corner, i))) return false;
    }
  }
  return true;
}

void FrameBuilder::MakeTriangles() {
  std::vector<FramePrimitive>& primitives = frame_->primitives;

  // Count the triangles that can be drawn.
  ForEach(primitives.size(), [&](size_t i) {
    FramePrimitive& primitive = primitives[i];
    const auto& triangles = primitive.source->triangles;
    primitive.triangle_count = uint32_t(
        usable_[i] ? triangles.size() : std::count_if(triangles.begin(), triangles.end(), [&](const auto& t) {
          return IsDrawn(primitive, t);
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
  ForEach(primitives.size(), [&](size_t i) {
    const FramePrimitive& primitive = primitives[i];
    FrameTriangle* out = frame_->triangles.data() + primitive.first_triangle;
    for (const std::array<uint32_t, 3>& triangle : primitive.source->triangles) {
      if (!usable_[i] && !IsDrawn(primitive, triangle)) continue;
      FrameTriangle made{{}, uint32_t(i)};
      for (size_t k = 0; k < 3; ++k) made.vertices[k] = primitive.first_vertex + triangle[k];
      if (primitive.mirrored) std::swap(made.vertices[1], made.vertices[2]);
      *out++ = made;
    }
  });
}

void FrameBuilder::EvaluateTangents(const Moment& moment) {
  uint64_t total = 0;
  for (FramePrimitive& primitive : frame_->primitives) {
    primitive.first_tangent = total;
    if (primitive.has_tangents) total += 3 * uint64_t{primitive.triangle_count};
  }
  if (total == 0) return;
  frame_->tangents.resize(total);
  ForEach(placed_.size(), [&](size_t i) {
    const PlacedMesh& placed = placed_[i];
    const MeshPose pose(scene_, placed.node, moment.pose, moment.camera);
    for (size_t k = 0; k < placed.mesh->primitives.size(); ++k) {
      const FramePrimitive& primitive = frame_->primitives[placed.first_primitive + k];
      if (primitive.has_tangents) WriteTangents(pose, placed.first_primitive + k);
    }
  });
}

void FrameBuilder::WriteTangents(const MeshPose& pose, size_t number) {
  const FramePrimitive& primitive = frame_->primitives[number];
  const MeshPrimitive& source = *primitive.source;
  // Where all triangles are drawn, they have the numbers that they have in the mesh.
  std::vector<uint32_t> drawn;
  for (uint32_t t = 0; !usable_[number] && t < source.triangles.size(); ++t) {
    if (IsDrawn(primitive, source.triangles[t])) drawn.push_back(t);
  }
  ForParts(primitive.triangle_count, [&](uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i) {
      const size_t t = usable_[number] ? i : drawn[i];
      V4f* const out = &frame_->tangents[primitive.first_tangent + 3 * uint64_t{i}];
      for (size_t corner = 0; corner < 3; ++corner) {
        const V4f& tangent = source.tangents[3 * t + corner];
        const V3d direction =
            pose.Direction(source, source.triangles[t][corner], V3d(tangent.x, tangent.y, tangent.z));
        out[corner] = V4f(float(direction.x), float(direction.y), float(direction.z),
                          primitive.mirrored ? -tangent.w : tangent.w);
      }
      if (primitive.mirrored) std::swap(out[1], out[2]);
    }
  });
}

void FrameBuilder::NameMisses() {
  std::vector<size_t> missed;
  for (size_t i = 0; i < fitted_.size(); ++i) {
    if (!fitted_[i].error.IsWithinTolerance()) missed.push_back(i);
  }
  std::stable_sort(missed.begin(), missed.end(),
                   [&](size_t a, size_t b) { return fitted_[a].error.Excess() > fitted_[b].error.Excess(); });
  for (size_t i = 0; i < std::min(missed.size(), kNamedMeshes); ++i) {
    const FittedMesh& fitted = fitted_[missed[i]];
    frame_->warnings.push_back(absl::StrFormat(
        "%s: its path is bent more than motion of degree %d in %d %s can follow, which lies up to %.2f px "
        "and "
        "%.2g of the distance beside it (at shutter time %.2f)",
        NameOf(placed_[missed[i]]), fitted.degree, fitted.pieces, fitted.pieces == 1 ? "piece" : "pieces",
        fitted.error.pixels, fitted.error.depth, fitted.error_time));
  }
  if (missed.size() > kNamedMeshes) {
    frame_->warnings.push_back(absl::StrFormat(
        "%d more meshes have paths that their motion cannot follow, and lie up to %.2f px beside them",
        missed.size() - kNamedMeshes, fitted_[missed[kNamedMeshes]].error.pixels));
  }
}

void FrameBuilder::MakeTextures() {
  std::set<std::pair<int, TextureEncoding>> used;
  std::set<const Material*> looked_at;
  for (const FramePrimitive& primitive : frame_->primitives) {
    if (!looked_at.insert(primitive.material).second) continue;
    for (const MaterialTexture& texture : TexturesOf(*primitive.material)) {
      const int image = scene_.textures[size_t(texture.reference->texture)].image;
      if (image >= 0) used.emplace(image, texture.encoding);
    }
  }
  const std::vector<std::pair<int, TextureEncoding>> wanted(used.begin(), used.end());
  for (auto& of_encoding : frame_->pyramids) of_encoding.resize(scene_.images.size());
  ForEach(wanted.size(), [&](size_t i) {
    const auto [image, encoding] = wanted[i];
    frame_->pyramids[size_t(encoding)][size_t(image)] =
        scene_.mip_pyramids.Get(scene_.images, image, encoding);
  });
}

std::string FrameBuilder::NameOf(const PlacedMesh& placed) const {
  const Node& node = scene_.nodes[size_t(placed.node)];
  return absl::StrCat("node ", placed.node, " \"", node.name, "\", mesh ", node.mesh, " \"",
                      placed.mesh->name, "\"");
}

std::string FrameBuilder::NameOf(const FramePrimitive& primitive) const {
  const Node& node = scene_.nodes[size_t(primitive.node)];
  const Mesh& mesh = scene_.meshes[size_t(node.mesh)];
  return absl::StrCat("node ", primitive.node, " \"", node.name, "\", mesh ", node.mesh, " \"", mesh.name,
                      "\", primitive ", primitive.source - mesh.primitives.data());
}

}  // namespace shutterline::engine
