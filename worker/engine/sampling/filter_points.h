#pragma once

#include <optional>

#include "common/job/render_settings.h"
#include "worker/engine/sampling/pixel_filter.h"
#include "worker/engine/sampling/point_pattern.h"

namespace shutterline::engine {

/// Places a pixel's points as densely as its filter takes light: each then weighs the same. Immutable.
class FilterPoints {
 public:
  explicit FilterPoints(const RenderSettings& settings) {
    if (!HasPixelBox(settings)) filter_.emplace(settings.filter, FilterRadius(settings));
  }

  /// `point` is uniform in the pixel; what comes of it may lie in one around it.
  PixelPoint Place(const PixelPoint& point) const {
    if (!filter_) return point;
    return {filter_->PlaceOf(point.x), filter_->PlaceOf(point.y), point.t};
  }

 private:
  std::optional<PixelFilter> filter_;
};

}  // namespace shutterline::engine
