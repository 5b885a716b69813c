#include "worker/engine/occlusion/ambient_occlusion.h"

#include <absl/strings/str_cat.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <vector>

#include "common/math/bezier.h"
#include "worker/engine/occlusion/kernels.h"
#include "worker/engine/occlusion/line_measure.h"
#include "worker/engine/occlusion/line_segments.h"

namespace shutterline::engine {
namespace {

absl::Status Validate(const OcclusionSettings& settings) {
  if (settings.lines < 1 || settings.lines > kMaxOcclusionLines) {
    return absl::InvalidArgumentError(absl::StrCat("ambient occlusion: ", settings.lines,
                                                   " lines; there may be 1 to ", kMaxOcclusionLines));
  }
  if (settings.radius && !(*settings.radius > 0 && std::isfinite(*settings.radius))) {
    return absl::InvalidArgumentError("ambient occlusion: the radius is not finite and positive");
  }
  if (!settings.radius && settings.falloff != OcclusionFalloff::kNone) {
    return absl::InvalidArgumentError("ambient occlusion: fall-off needs a radius");
  }
  return absl::OkStatus();
}

/// The weights of a class of motion at shutter time t.
MotionWeights WeightsAt(const MotionClass& motion, double t) {
  if (motion.degree == 0) return {};
  const CurvePosition at = CurvePositionAt(motion.pieces, t);
  const double u = at.u, v = 1 - u;
  const int first = at.piece * motion.degree;
  switch (motion.degree) {
    case 1:
      return {first, 2, {v, u}};
    case 2:
      return {first, 3, {v * v, 2 * (u * v), u * u}};
    default:
      return {first, 4, {v * v * v, 3 * (v * v * u), 3 * (u * u * v), u * u * u}};
  }
}

void PlaceLine(const ReceiverFrame& frame, const HemisphereLine& line, LineQuery& query) {
  const auto [c, s] = line.heading;
  const double rise = std::sqrt((1 - line.lean) * (1 + line.lean));
  query.point = frame.position;
  query.along = c * frame.x + s * frame.y;
  query.up = line.lean * (c * frame.y - s * frame.x) + rise * frame.pole;
  query.plane = query.along.cross(query.up);
  query.face = frame.face;
  query.face_along = frame.face.dot(query.along);
  query.face_up = frame.face.dot(query.up);
  query.size = frame.size;
  query.inverse_height = 1 / frame.least_height;
}

}  // namespace

absl::StatusOr<AmbientOcclusion> AmbientOcclusion::Create(std::shared_ptr<const FrameScene> frame,
                                                          const OcclusionSettings& settings, int threads) {
  if (absl::Status status = Validate(settings); !status.ok()) return status;
  try {
    // More threads than processors would only make TBB complain.
    tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
    OccluderTree tree = arena.execute([&] { return OccluderTree::Build(*frame, settings.motion); });
    return AmbientOcclusion(std::move(frame), settings, std::move(tree));
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("build ambient occlusion: out of memory");
  } catch (const std::length_error&) {
    return absl::ResourceExhaustedError("build ambient occlusion: out of memory");
  }
}

double AmbientOcclusion::At(uint32_t triangle, double b1, double b2) const {
  const auto receiver = Receiver::Create(*frame_, triangle, b1, b2, tree_.scale);
  return receiver ? Evaluate(*receiver, triangle, receiver->shifts()) : 1;
}

double AmbientOcclusion::At(uint32_t triangle, double b1, double b2, const LineShifts& shifts) const {
  const auto receiver = Receiver::Create(*frame_, triangle, b1, b2, tree_.scale);
  return receiver ? Evaluate(*receiver, triangle, shifts) : 1;
}

double AmbientOcclusion::Evaluate(const Receiver& receiver, uint32_t triangle,
                                  const LineShifts& shifts) const {
  if (tree_.node_count == 0) return 1;
  thread_local LineSegments segments;
  thread_local std::vector<MotionWeights> motions;
  motions.resize(tree_.classes.size());
  LineQuery query;
  query.own = tree_.places[triangle];
  query.radius = settings_.radius ? *settings_.radius / tree_.scale : std::numeric_limits<double>::infinity();

  int64_t occlusion = 0;
  for (int i = 0; i < settings_.lines; ++i) {
    const HemisphereLine line = LineAt(settings_, i, shifts);
    PlaceLine(receiver.At(line.instant), line, query);
    for (size_t c = 0; c < motions.size(); ++c) motions[c] = WeightsAt(tree_.classes[c], line.instant);
    query.motions = motions;
    const double place = line.instant * tree_.spans;
    query.span = std::min(int(place), tree_.spans - 1);
    query.in_span = float(place - query.span);
    segments.Begin(query, settings_.falloff);
    WalkLine(tree_, query, segments);
    occlusion += segments.Occlusion(settings_.pattern);
  }
  const double whole = double(kWholeLine) * settings_.lines;
  return (whole - double(occlusion)) / whole;
}

}  // namespace shutterline::engine
