#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/job/occlusion_settings.h"
#include "worker/engine/occlusion/falloff.h"
#include "worker/engine/occlusion/line_cover.h"
#include "worker/engine/occlusion/line_query.h"

namespace shutterline::engine {

/// What occludes a line sample, section by section in any order. Scratch memory of a thread.
class LineSegments {
 public:
  /// Begins a line. The query must outlive it.
  void Begin(const LineQuery& query, OcclusionFalloff falloff);

  void Add(const LineSection& section);

  /// True without fall-off and radius: a section that lies over face and horizon and does not end at the
  /// point
  /// (`least`) is no more than the positions of its ends, as line_measure.h rounds them.
  bool OnlyCovers() const { return only_covers_; }
  void AddCover(int32_t a, int32_t b) { cover_.Add(std::min(a, b), std::max(a, b)); }
  /// Squared distance up to which an end has no direction.
  double least() const { return least_; }

  /// Without fall-off, what is covered so far; what comes from there adds nothing. Else empty.
  const LineCover& cover() const { return cover_; }

  /// The share of the line that is occluded, of kWholeLine: Eq. 1 with 1 - ρ in place of ρ.
  int64_t Occlusion(OcclusionPattern pattern);

 private:
  const LineQuery* query_ = nullptr;
  OcclusionFalloff falloff_ = OcclusionFalloff::kNone;
  double least_ = 0;
  bool only_covers_ = false;
  LineCover cover_;
  std::vector<DistanceSegment> segments_;
};

}  // namespace shutterline::engine
