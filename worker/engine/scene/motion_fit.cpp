#include "worker/engine/scene/motion_fit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

/// The path is checked at so many keys inside the shutter at most, taken evenly from all.
constexpr size_t kCheckedKeys = 32;
/// Representations are tried on about so many vertices of a primitive before all are looked at.
constexpr size_t kTriedVertices = 256;
/// Where nothing is within tolerance, a lower degree is taken if its error is within this factor of the best:
/// a curve of higher degree swings about a jump.
constexpr double kGoodEnough = 2;
/// In no simple proportion to keys, so that nothing periodic hides from all check times.
constexpr double kOddTime = 0.41421356;

}  // namespace

struct MotionFitter::Search {
  const PlacedMesh* placed = nullptr;
  FittedMesh* fitted = nullptr;
  bool decided = false;
  bool failed = false;  ///< The representation being tried is.
  std::vector<std::vector<uint8_t>> used;
  std::vector<std::vector<uint32_t>> tried;  ///< By primitive: vertices to try; empty: all.
  std::vector<std::vector<RasterPoint>> points;
  PathError error;
  double worst_excess = 0, error_time = 0;
  std::vector<std::pair<Candidate, double>> misses;  ///< What was measured fully, and its excess.

  const MeshPrimitive& Primitive(size_t k) const { return placed->mesh->primitives[k]; }
  bool TriesAll() const {
    return std::all_of(tried.begin(), tried.end(), [](const auto& v) { return v.empty(); });
  }
};

MotionFitter::MotionFitter(const Scene& scene, const FrameView& view, const ShutterPoses& shutter,
                           const RenderSettings& settings, std::span<const PlacedMesh> placed)
    : scene_(scene), view_(view), shutter_(shutter), settings_(settings), placed_(placed) {
  double before = 0;
  for (const double key : shutter.KeyTimes(kCheckedKeys)) {
    key_times_.push_back((before + key) / 2);
    key_times_.push_back(key);
    before = key;
  }
  if (before > 0) key_times_.push_back((before + 1) / 2);
}

std::vector<MotionFitter::Candidate> MotionFitter::Candidates() const {
  std::vector<Candidate> candidates;
  for (int pieces = 1; pieces <= kMaxMotionPieces; pieces *= 2) {
    if (settings_.motion_pieces && *settings_.motion_pieces != pieces) continue;
    for (int degree = 1; degree <= kMaxMotionDegree; ++degree) {
      if (settings_.motion_degree && *settings_.motion_degree != degree) continue;
      candidates.push_back({degree, pieces});
    }
  }
  return candidates;
}

std::vector<double> MotionFitter::CheckTimes(const Candidate& candidate) const {
  // Worst first: a curve that does not fit is then soon given up.
  static constexpr double kInPiece[] = {1.0 / 2, 1.0 / 6, 5.0 / 6, 1.0 / 4, 3.0 / 4, 1.0 / 3, 2.0 / 3};
  const size_t in_piece = candidate.pieces < 16 ? std::size(kInPiece) : 3;
  std::vector<double> times;
  for (size_t i = 0; i < in_piece; ++i) {
    const double node = kInPiece[i] * candidate.degree;
    if (std::abs(node - std::round(node)) < 1e-9) continue;  // The curve was made to pass there.
    for (int piece = 0; piece < candidate.pieces; ++piece) {
      times.push_back((piece + kInPiece[i]) / candidate.pieces);
    }
  }
  times.insert(times.end(), key_times_.begin(), key_times_.end());
  times.push_back(kOddTime);
  return times;
}

absl::StatusOr<Moment> MotionFitter::MomentAt(double t) {
  absl::StatusOr<Moment> moment = shutter_.At(t);
  if (!moment.ok()) unposed_.emplace_back(moment.status().message());
  return moment;
}

std::vector<FittedMesh> MotionFitter::Fit(const Moment& open, std::vector<std::string>& warnings) {
  std::vector<FittedMesh> fitted(placed_.size());
  std::vector<Search> searches;
  for (size_t i = 0; i < placed_.size(); ++i) {
    const size_t count = placed_[i].mesh->primitives.size();
    fitted[i].control_points.resize(count);
    fitted[i].moves.assign(count, 0);
    if (!placed_[i].moves) continue;
    Search& search = searches.emplace_back();
    search.placed = &placed_[i];
    search.fitted = &fitted[i];
    search.used.resize(count);
    search.tried.resize(count);
    search.points.resize(count);
  }

  // Everything at shutter open: what never moves is done with that.
  tbb::parallel_for(size_t{0}, placed_.size(), [&](size_t i) {
    const MeshPose pose(scene_, placed_[i].node, open.pose, open.camera);
    for (size_t k = 0; k < fitted[i].control_points.size(); ++k) {
      const MeshPrimitive& primitive = placed_[i].mesh->primitives[k];
      fitted[i].control_points[k].resize(primitive.positions.size());
      WritePlaces(view_, primitive, pose, {}, 0, 1, fitted[i].control_points[k]);
    }
  });
  if (searches.empty()) return fitted;
  FindWhatMoves(searches);
  for (const Candidate& candidate : Candidates()) Try(candidate, searches);
  ChooseBest(searches);

  // The same time may have been asked for often.
  std::sort(unposed_.begin(), unposed_.end());
  unposed_.erase(std::unique(unposed_.begin(), unposed_.end()), unposed_.end());
  warnings.insert(warnings.end(), unposed_.begin(), unposed_.end());
  return fitted;
}

void MotionFitter::FindWhatMoves(std::span<Search> searches) {
  std::vector<double> times = CheckTimes({1, 1});
  times.insert(times.begin(), 1.0);
  for (const double t : times) {
    const absl::StatusOr<Moment> moment = MomentAt(t);
    if (!moment.ok()) continue;
    tbb::parallel_for(size_t{0}, searches.size(), [&](size_t i) {
      FittedMesh& fitted = *searches[i].fitted;
      if (std::all_of(fitted.moves.begin(), fitted.moves.end(), [](char m) { return m != 0; })) return;
      const MeshPose pose(scene_, searches[i].placed->node, moment->pose, moment->camera);
      for (size_t k = 0; k < fitted.moves.size(); ++k) {
        if (fitted.moves[k]) continue;
        fitted.moves[k] = AnyVertexMoves(view_, searches[i].Primitive(k), pose, fitted.control_points[k]);
      }
    });
  }
  tbb::parallel_for(size_t{0}, searches.size(), [&](size_t i) {
    Search& search = searches[i];
    search.decided = true;
    for (size_t k = 0; k < search.fitted->moves.size(); ++k) {
      if (!search.fitted->moves[k]) continue;
      search.decided = false;
      search.used[k] = UsedVertices(search.Primitive(k));
      const size_t used = size_t(std::count(search.used[k].begin(), search.used[k].end(), 1));
      const size_t stride = used / kTriedVertices;
      if (stride < 2) continue;
      size_t number = 0;
      for (uint32_t v = 0; v < search.used[k].size(); ++v) {
        if (search.used[k][v] && number++ % stride == 0) search.tried[k].push_back(v);
      }
    }
  });
}

void MotionFitter::Try(const Candidate& candidate, std::span<Search> searches) {
  std::vector<Search*> left;
  for (Search& search : searches) {
    if (!search.decided) left.push_back(&search);
  }
  // In the last place to look, every representation is measured in full: one of them must do.
  const bool last = candidate.pieces == Candidates().back().pieces;
  for (const bool all_vertices : {false, true}) {
    if (left.empty() || !MakeCurves(candidate, all_vertices, left)) return;
    Measure(candidate, all_vertices, !last, left);
    std::vector<Search*> good;
    for (Search* search : left) {
      if (search->failed) {
        if (last) search->misses.push_back({candidate, search->worst_excess});
      } else if (all_vertices || search->TriesAll()) {
        search->decided = true;
        search->fitted->degree = candidate.degree;
        search->fitted->pieces = candidate.pieces;
        for (size_t k = 0; k < search->points.size(); ++k) {
          if (search->fitted->moves[k]) search->fitted->control_points[k] = std::move(search->points[k]);
        }
      } else {
        good.push_back(search);
      }
    }
    left = std::move(good);
  }
}

/// False if the scene cannot be posed at one of the times.
bool MotionFitter::MakeCurves(const Candidate& candidate, bool all_vertices, std::span<Search*> searches) {
  const size_t per_vertex = size_t(candidate.degree * candidate.pieces) + 1;
  for (size_t index = 0; index < per_vertex; ++index) {
    const absl::StatusOr<Moment> moment = MomentAt(double(index) / double(per_vertex - 1));
    if (!moment.ok()) return false;
    tbb::parallel_for(size_t{0}, searches.size(), [&](size_t i) {
      Search& search = *searches[i];
      const MeshPose pose(scene_, search.placed->node, moment->pose, moment->camera);
      for (size_t k = 0; k < search.points.size(); ++k) {
        if (!search.fitted->moves[k]) continue;
        const auto& tried = all_vertices ? std::vector<uint32_t>() : search.tried[k];
        const size_t count = tried.empty() ? search.Primitive(k).positions.size() : tried.size();
        search.points[k].resize(count * per_vertex);
        WritePlaces(view_, search.Primitive(k), pose, tried, index, per_vertex, search.points[k]);
        if (index + 1 == per_vertex) InterpolateAll(candidate.degree, candidate.pieces, search.points[k]);
      }
    });
  }
  return true;
}

void MotionFitter::Measure(const Candidate& candidate, bool all_vertices, bool stop_early,
                           std::span<Search*> searches) {
  for (Search* search : searches) {
    search->failed = false;
    search->error = {};
    search->worst_excess = search->error_time = 0;
  }
  for (const double t : CheckTimes(candidate)) {
    if (stop_early && std::all_of(searches.begin(), searches.end(), [](Search* s) { return s->failed; })) {
      return;
    }
    const absl::StatusOr<Moment> moment = MomentAt(t);
    if (!moment.ok()) continue;
    tbb::parallel_for(size_t{0}, searches.size(), [&](size_t i) {
      Search& search = *searches[i];
      if (stop_early && search.failed) return;
      const MeshPose pose(scene_, search.placed->node, moment->pose, moment->camera);
      for (size_t k = 0; k < search.points.size(); ++k) {
        if (!search.fitted->moves[k]) continue;
        const auto& tried = all_vertices ? std::vector<uint32_t>() : search.tried[k];
        const PathError error = LargestPathError(view_, search.Primitive(k), pose, t, candidate.degree,
                                                 candidate.pieces, search.used[k], tried, search.points[k]);
        search.error.Extend(error);
        search.failed = search.failed || !error.IsWithinTolerance();
        if (error.Excess() > search.worst_excess) {
          search.worst_excess = error.Excess();
          search.error_time = t;
        }
      }
    });
  }
}

void MotionFitter::ChooseBest(std::span<Search> searches) {
  for (Search& search : searches) {
    if (search.decided) continue;
    // Where the camera cannot be posed at the times that the candidates need, open and close remain.
    Candidate chosen{1, 1};
    double best = std::numeric_limits<double>::infinity();
    for (const auto& [candidate, excess] : search.misses) best = std::min(best, excess);
    for (const auto& [candidate, excess] : search.misses) {
      if (excess > kGoodEnough * best) continue;
      chosen = candidate;
      break;
    }
    Search* const one[] = {&search};
    std::vector<Search*> only(one, one + 1);
    if (!MakeCurves(chosen, true, only)) continue;  // Open and close have been posed before.
    Measure(chosen, true, false, only);
    search.decided = true;
    FittedMesh& fitted = *search.fitted;
    fitted.degree = chosen.degree;
    fitted.pieces = chosen.pieces;
    fitted.error = search.error;
    fitted.error_time = search.error_time;
    for (size_t k = 0; k < search.points.size(); ++k) {
      if (fitted.moves[k]) fitted.control_points[k] = std::move(search.points[k]);
    }
  }
}

}  // namespace shutterline::engine
