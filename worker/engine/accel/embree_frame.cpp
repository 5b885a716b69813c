#include "worker/engine/accel/embree_frame.h"

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/accel/view_scale.h"

namespace shutterline::engine {

NearestHits::NearestHits() {
  InitCoherentQuery(context);
  std::fill_n(distance, 16, std::numeric_limits<float>::infinity());
  std::fill_n(triangle, 16, std::numeric_limits<uint32_t>::max());
}

/// Rejects hits from behind on single-sided surfaces, and all but the lowest of equally near triangles.
/// Embree offers hits in no particular order, but every one that is not farther than the nearest so far.
void EmbreeFrame::FilterHits(const RTCFilterFunctionNArguments* arguments) {
  static_assert(offsetof(NearestHits, context) == 0);
  auto& nearest = *reinterpret_cast<NearestHits*>(arguments->context);
  const auto& info = *static_cast<const GeometryInfo*>(arguments->geometryUserPtr);
  RTCRayN* const ray = arguments->ray;
  RTCHitN* const hit = arguments->hit;
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    if (!info.double_sided) {
      // The normal is that of the ray's own time; it points to where the corners run counter-clockwise.
      const float facing = RTCRayN_dir_x(ray, n, i) * RTCHitN_Ng_x(hit, n, i) +
                           RTCRayN_dir_y(ray, n, i) * RTCHitN_Ng_y(hit, n, i) +
                           RTCRayN_dir_z(ray, n, i) * RTCHitN_Ng_z(hit, n, i);
      if (!(facing < 0)) {
        arguments->valid[i] = 0;
        continue;
      }
    }
    const unsigned lane = RTCRayN_id(ray, n, i);
    const float distance = RTCRayN_tfar(ray, n, i);  // The hit's, while the filter runs.
    const uint32_t triangle = info.first_triangle + RTCHitN_primID(hit, n, i);
    if (distance == nearest.distance[lane] && triangle > nearest.triangle[lane]) {
      arguments->valid[i] = 0;
      continue;
    }
    nearest.distance[lane] = distance;
    nearest.triangle[lane] = triangle;
  }
}

void EmbreeFrame::LetPass(const RTCFilterFunctionNArguments* arguments) {
  std::fill_n(arguments->valid, arguments->N, 0);
}

absl::StatusOr<EmbreeFrame> EmbreeFrame::Build(const FrameScene& frame, int threads) {
  // More threads than processors would only make TBB complain.
  tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
  return arena.execute([&]() -> absl::StatusOr<EmbreeFrame> {
    SL_ASSIGN_OR_RETURN(EmbreeDevice device, MakeEmbreeDevice());
    return BuildScene(frame, std::nullopt, RTC_BUILD_QUALITY_MEDIUM, std::move(device));
  });
}

absl::StatusOr<EmbreeFrame> EmbreeFrame::BuildAt(const FrameScene& frame, double instant, bool quickly,
                                                 const EmbreeDevice& device) {
  return BuildScene(frame, instant, quickly ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM,
                    Share(device));
}

absl::StatusOr<EmbreeFrame> EmbreeFrame::BuildScene(const FrameScene& frame, std::optional<double> instant,
                                                    RTCBuildQuality quality, EmbreeDevice owned) {
  EmbreeFrame result;
  result.device_ = std::move(owned);
  const RTCDevice device = result.device_.get();
  if (!rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED)) {
    return absl::InternalError("build the scene for rays: this Embree was built without filter functions");
  }
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) {
    result.packet_width_ = 16;
  } else if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) {
    result.packet_width_ = 8;
  }
  result.scale_ = ViewScale(frame);
  result.scene_ = EmbreeScene(rtcNewScene(device));
  rtcSetSceneFlags(result.scene(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(result.scene(), quality);
  for (const FramePrimitive& primitive : frame.primitives) {
    result.infos_.push_back({primitive.first_triangle, primitive.material->double_sided});
  }
  for (unsigned p = 0; p < frame.primitives.size(); ++p) {
    SL_RETURN_IF_ERROR(Annotate(result.AddPrimitive(frame, p, instant), "build the scene for rays"));
  }
  rtcCommitScene(result.scene());
  SL_RETURN_IF_ERROR(EmbreeStatus(device, "build the scene for rays"));
  return result;
}

absl::Status EmbreeFrame::AddPrimitive(const FrameScene& frame, unsigned number,
                                       std::optional<double> instant) {
  const FramePrimitive& primitive = frame.primitives[number];
  if (primitive.triangle_count == 0) return absl::OkStatus();
  const EmbreeGeometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  const int steps = primitive.degree == 0 || instant ? 0 : primitive.linear_pieces;
  static_assert(kMaxLinearPieces < RTC_MAX_TIME_STEP_COUNT);
  rtcSetGeometryTimeStepCount(geometry.get(), unsigned(steps) + 1);

  for (int step = 0; step <= steps; ++step) {
    const double t = instant ? *instant : steps == 0 ? 0 : double(step) / steps;
    auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX,
                                                                  unsigned(step), RTC_FORMAT_FLOAT3,
                                                                  3 * sizeof(float), primitive.vertex_count));
    if (positions == nullptr) return EmbreeStatus(device_.get(), "vertices");
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const RasterPoint place = frame.VertexAt(primitive, primitive.first_vertex + v, t);
      const V3d p = frame.view.ViewFromRaster(place) / scale_;
      for (int axis = 0; axis < 3; ++axis) *positions++ = float(p[axis]);
    }
  }

  auto* corners = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0,
                                                                 RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                                                 primitive.triangle_count));
  if (corners == nullptr) return EmbreeStatus(device_.get(), "triangles");
  for (uint32_t i = 0; i < primitive.triangle_count; ++i) {
    for (const uint32_t vertex : frame.triangles[primitive.first_triangle + i].vertices) {
      *corners++ = vertex - primitive.first_vertex;
    }
  }

  rtcSetGeometryUserData(geometry.get(), &infos_[number]);
  rtcSetGeometryIntersectFilterFunction(geometry.get(), &EmbreeFrame::FilterHits);
  if (primitive.material->alpha_mode != AlphaMode::kOpaque) {
    rtcSetGeometryOccludedFilterFunction(geometry.get(), &EmbreeFrame::LetPass);
  }
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene_.get(), geometry.get(), number);
  return EmbreeStatus(device_.get(), "geometry");
}

}  // namespace shutterline::engine
