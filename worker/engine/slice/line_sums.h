#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/tolerance.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/tile_colors.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// What a group's lines see, gathered over the instants before it goes to the pixels.
///
/// What has one colour is noted at the boundaries between visible pieces, as a change of colour: a price that
/// does not depend on a piece's length or on the number of triangles that a pixel sees; a sum along the line
/// gives the pixels' shares at the end. Smooth colours are
/// integrated pixel by pixel. Coverage goes the same
/// way, in integers. Other pieces are kept until the group is done, then gathered by triangle.
class LineSums {
 public:
  using Color = TileColors::Color;

  /// Begins a group of a class of a tile.
  void Begin(const TileMesh& mesh, const LineClass& lines, const LineGroup& group, TileColors& colors);

  /// Adds pieces of one lane in ascending order, which do not overlap: Begin, then pieces, then End.
  /// `weight` counts instants.
  void BeginLane(int lane, double weight) {
    sums_ = lane_sums_[size_t(lane)].data();
    shares_of_lane_ = lane_shares_[size_t(lane)].data();
    points_of_lane_ = lane_points_[size_t(lane)].data();
    weight_ = weight;
    color_ = nullptr;
    end_ = 0;
  }
  void AddFlat(int32_t begin, int32_t end, uint32_t index) {
    const Color& color = colors_->ColorOf(index);
    if (color_ == &color && begin == end_) {
      end_ = end;
      return;
    }
    if (color_ != nullptr && begin == end_) {
      Color change;
      for (size_t c = 0; c < 4; ++c) change[c] = weight_ * (color[c] - (*color_)[c]);
      Change(begin, change);
    } else {
      EndLane();
      Color change;
      for (size_t c = 0; c < 4; ++c) change[c] = weight_ * color[c];
      Change(begin, change);
    }
    color_ = &color;
    end_ = end;
  }
  void AddSmooth(int32_t begin, int32_t end, uint32_t index, const LinePosition& position) {
    AddSmooth(begin, end, index, position, weight_);
  }
  /// The same with a weight of their own: pieces seen through others. They may overlap.
  void AddSmooth(int32_t begin, int32_t end, uint32_t index, const LinePosition& position, double weight);
  void AddFlatShare(int32_t begin, int32_t end, uint32_t index, double weight) {
    const Color& color = colors_->ColorOf(index);
    Color change;
    for (size_t c = 0; c < 4; ++c) change[c] = weight * color[c];
    Change(begin, change);
    for (size_t c = 0; c < 4; ++c) change[c] = -change[c];
    Change(end, change);
  }
  void EndLane() {
    if (color_ == nullptr) return;
    Color change;
    for (size_t c = 0; c < 4; ++c) change[c] = -weight_ * (*color_)[c];
    Change(end_, change);
    color_ = nullptr;
  }

  /// Of a piece within one step, a share of `share` subpixels times `weight`: it is seen through others, or
  /// lets others be seen.
  void AddColorShare(int32_t begin, const Color& color, double weight, int64_t share) {
    Color& sum = shares_of_lane_[begin >> kSubpixelBits];
    for (size_t c = 0; c < 4; ++c) sum[c] += weight * double(share) * color[c];
  }

  /// Adds a piece of a triangle that is kept apart, or, beside its colour, of one that goes to the film where
  /// that keeps pairs. `bin`: its part of the shutter.
  void AddApart(int lane, int32_t begin, int32_t end, uint32_t index, uint16_t bin, int64_t weight,
                const LinePosition& position) {
    apart_[size_t(lane)].push_back({begin, end, index, bin, weight, kWhole, position});
  }
  /// The same of a share of it, within one step.
  void AddApartShare(int lane, int32_t begin, int32_t end, uint32_t index, uint16_t bin, int64_t weight,
                     int64_t share, const LinePosition& position) {
    apart_[size_t(lane)].push_back({begin, end, index, bin, weight, share, position});
  }

  /// Hands everything on, in instants times subpixels.
  void End(PairWeights& weights);

 private:
  static constexpr int64_t kWhole = -1;
  struct Piece {
    int32_t begin, end;
    uint32_t index;
    uint16_t bin;
    int64_t weight;
    int64_t share;  ///< Subpixels, or kWhole.
    LinePosition position;
  };
  /// Of one triangle (and bin) in a step of a line.
  struct Share {
    uint64_t weight = 0;
    std::array<double, 3> position{};
  };

  /// From subpixel x on the line's colour is another.
  void Change(int32_t x, const Color& change) {
    const int step = x >> kSubpixelBits;
    const double in_next = x & (kSubpixelsPerPixel - 1);
    const double in_this = kSubpixelsPerPixel - in_next;
    Color* const sums = sums_ + step;
    for (size_t c = 0; c < 4; ++c) sums[0][c] += change[c] * in_this;
    for (size_t c = 0; c < 4; ++c) sums[1][c] += change[c] * in_next;
  }

  void BeginPoints();
  void FlushColors(int lane);
  void FlushApart(int lane, PairWeights& weights);
  void FlushTriangle(int lane, uint32_t index, uint16_t bin, PairWeights& weights);

  const TileMesh* mesh_ = nullptr;
  const LineClass* lines_ = nullptr;
  const LineGroup* group_ = nullptr;
  TileColors* colors_ = nullptr;

  /// By lane and step: differences along the line, and what is added to single steps, here and by the film's
  /// PointColors.
  std::array<std::array<Color, kMaxLinePixels + 2>, kLanes> lane_sums_;
  std::array<std::array<Color, kMaxLinePixels>, kLanes> lane_shares_, lane_points_;
  bool has_points_ = false;  ///< lane_points_ means something.
  std::array<std::vector<Piece>, kLanes> apart_;

  // The lane in hand.
  Color* sums_ = nullptr;
  Color* shares_of_lane_ = nullptr;
  Color* points_of_lane_ = nullptr;
  const Color* color_ = nullptr;
  double weight_ = 0;
  int32_t end_ = 0;

  // Of FlushApart.
  std::vector<uint32_t> order_;
  std::array<Share, kMaxLinePixels> shares_;
  int first_step_ = 0, last_step_ = -1;
};

}  // namespace shutterline::engine
