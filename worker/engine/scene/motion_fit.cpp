#include "worker/engine/scene/motion_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/work_limit.h"
#include "worker/engine/scene/curve_check.h"
#include "worker/engine/scene/limited_parallel.h"

namespace shutterline::engine {
namespace {

/// The path is checked at so many keys inside the shutter at most, taken evenly from all.
constexpr size_t kCheckedKeys = 32;
/// Where nothing is within tolerance, a lower degree is taken if its error is within this factor of the best:
/// a curve of higher degree swings about a jump.
constexpr double kGoodEnough = 2;
/// In no simple proportion to keys, so that nothing periodic hides from all check times.
constexpr double kOddTime = 0.41421356;

}  // namespace

struct MotionFitter::Search {
  const PlacedMesh* placed = nullptr;
  const std::vector<VertexSets>* sets = nullptr;
  FittedMesh* fitted = nullptr;
  bool decided = false;
  bool failed = false;          ///< The representation being tried is.
  std::vector<MeshPose> knots;  ///< Where it passes through the path.
  PathError error;
  double worst_excess = 0, error_time = 0;
  std::vector<std::pair<Candidate, double>> misses;  ///< What was measured fully, and its excess.

  const MeshPrimitive& Primitive(size_t k) const { return placed->mesh->primitives[k]; }
  bool TriesAll() const {
    for (size_t k = 0; k < sets->size(); ++k) {
      if (fitted->moves[k] && !(*sets)[k].tried.empty()) return false;
    }
    return true;
  }
  /// Checks of primitive k at shutter time t.
  CurveCheck CheckAt(size_t k, const FrameView& view, const Candidate& candidate, double t) const {
    const CurvePosition at = CurvePositionAt(candidate.pieces, t);
    return {view, Primitive(k), (*sets)[k],
            std::span(knots).subspan(size_t(at.piece * candidate.degree), size_t(candidate.degree) + 1),
            at.u};
  }
  std::span<const uint32_t> Vertices(size_t k, bool all) const {
    return all ? std::span<const uint32_t>() : (*sets)[k].tried;
  }
};

MotionFitter::MotionFitter(const Scene& scene, const FrameView& view, const ShutterPoses& shutter,
                           const RenderSettings& settings, std::span<const PlacedMesh> placed,
                           const MeshVertexSets& sets)
    : scene_(scene), view_(view), shutter_(shutter), settings_(settings), placed_(placed), sets_(sets) {
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
    fitted[i].moves.assign(placed_[i].mesh->primitives.size(), 0);
    if (!placed_[i].moves) continue;
    Search& search = searches.emplace_back();
    search.placed = &placed_[i];
    search.sets = sets_.at(placed_[i].mesh).get();
    search.fitted = &fitted[i];
  }
  if (searches.empty()) return fitted;
  FindWhatMoves(open, searches);
  for (const Candidate& candidate : Candidates()) Try(candidate, searches);
  ChooseBest(searches);

  // The same time may have been asked for often.
  std::sort(unposed_.begin(), unposed_.end());
  unposed_.erase(std::unique(unposed_.begin(), unposed_.end()), unposed_.end());
  warnings.insert(warnings.end(), unposed_.begin(), unposed_.end());
  return fitted;
}

void MotionFitter::FindWhatMoves(const Moment& open, std::span<Search> searches) {
  std::vector<double> times = CheckTimes({1, 1});
  times.insert(times.begin(), 1.0);
  for (const double t : times) {
    const absl::StatusOr<Moment> moment = MomentAt(t);
    if (!moment.ok()) continue;
    ForEach(searches.size(), [&](size_t i) {
      const Search& search = searches[i];
      std::vector<char>& moves = search.fitted->moves;
      if (std::all_of(moves.begin(), moves.end(), [](char m) { return m != 0; })) return;
      const MeshPose at_open(scene_, search.placed->node, open.pose, open.camera);
      const MeshPose pose(scene_, search.placed->node, moment->pose, moment->camera);
      for (size_t k = 0; k < moves.size(); ++k) {
        if (!moves[k]) moves[k] = AnyVertexMoves(view_, search.Primitive(k), at_open, pose);
      }
    });
  }
  for (Search& search : searches) {
    const std::vector<char>& moves = search.fitted->moves;
    search.decided = std::none_of(moves.begin(), moves.end(), [](char m) { return m != 0; });
  }
}

void MotionFitter::Try(const Candidate& candidate, std::span<Search> searches) {
  std::vector<Search*> left;
  for (Search& search : searches) {
    if (!search.decided) left.push_back(&search);
  }
  if (left.empty() || !PoseKnots(candidate, left)) return;
  // In the last place to look, every representation is measured: one of them must do.
  const bool last = candidate.pieces == Candidates().back().pieces;
  for (const bool all_vertices : {false, true}) {
    Check(candidate, all_vertices, !last, left);
    std::vector<Search*> good, bad;
    for (Search* search : left) {
      if (search->failed) {
        bad.push_back(search);
      } else if (all_vertices || search->TriesAll()) {
        search->decided = true;
        search->fitted->degree = candidate.degree;
        search->fitted->pieces = candidate.pieces;
      } else {
        good.push_back(search);
      }
    }
    if (last && !bad.empty()) {
      Measure(candidate, all_vertices, bad);
      for (Search* search : bad) search->misses.push_back({candidate, search->worst_excess});
    }
    left = std::move(good);
    if (left.empty()) return;
  }
}

/// False if the scene cannot be posed at one of the times.
bool MotionFitter::PoseKnots(const Candidate& candidate, std::span<Search*> searches) {
  for (Search* search : searches) search->knots.clear();
  const int last = candidate.degree * candidate.pieces;
  for (int index = 0; index <= last; ++index) {
    const absl::StatusOr<Moment> moment = MomentAt(double(index) / last);
    if (!moment.ok()) return false;
    ForEach(searches.size(), [&](size_t i) {
      searches[i]->knots.emplace_back(scene_, searches[i]->placed->node, moment->pose, moment->camera);
    });
  }
  return true;
}

/// Finds out which searches' curves are within tolerance at all times. `stop_early`: no more moments are
/// looked at once all have failed.
void MotionFitter::Check(const Candidate& candidate, bool all_vertices, bool stop_early,
                         std::span<Search*> searches) {
  for (Search* search : searches) search->failed = false;
  for (const double t : CheckTimes(candidate)) {
    const bool all_failed =
        std::all_of(searches.begin(), searches.end(), [](const Search* s) { return s->failed; });
    if (all_failed && stop_early) return;
    const absl::StatusOr<Moment> moment = MomentAt(t);
    if (!moment.ok() || all_failed) continue;
    ForEach(searches.size(), [&](size_t i) {
      Search& search = *searches[i];
      if (search.failed) return;
      const MeshPose pose(scene_, search.placed->node, moment->pose, moment->camera);
      for (size_t k = 0; k < search.fitted->moves.size() && !search.failed; ++k) {
        if (!search.fitted->moves[k]) continue;
        search.failed =
            !search.CheckAt(k, view_, candidate, t).IsWithinTolerance(pose, search.Vertices(k, all_vertices));
      }
    });
  }
}

void MotionFitter::Measure(const Candidate& candidate, bool all_vertices, std::span<Search*> searches) {
  for (Search* search : searches) {
    search->error = {};
    search->worst_excess = search->error_time = 0;
  }
  for (const double t : CheckTimes(candidate)) {
    const absl::StatusOr<Moment> moment = MomentAt(t);
    if (!moment.ok()) continue;
    ForEach(searches.size(), [&](size_t i) {
      Search& search = *searches[i];
      const MeshPose pose(scene_, search.placed->node, moment->pose, moment->camera);
      for (size_t k = 0; k < search.fitted->moves.size(); ++k) {
        if (!search.fitted->moves[k]) continue;
        const PathError error =
            search.CheckAt(k, view_, candidate, t).LargestError(pose, search.Vertices(k, all_vertices));
        search.error.Extend(error);
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
    if (!PoseKnots(chosen, only)) continue;  // Open and close have been posed before.
    Measure(chosen, true, only);
    search.decided = true;
    FittedMesh& fitted = *search.fitted;
    fitted.degree = chosen.degree;
    fitted.pieces = chosen.pieces;
    fitted.error = search.error;
    fitted.error_time = search.error_time;
  }
}

}  // namespace shutterline::engine
