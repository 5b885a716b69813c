#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/tolerance.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/spread_sums.h"
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
///
/// Under a filter that is wider than a pixel SpreadSums has the sums. What is called for every visible piece
/// is a template of that, so that it costs nothing where there is none.
class LineSums {
 public:
  using Color = TileColors::Color;
  static constexpr int32_t kWhole = -1;

  /// Begins a group of a class of a tile. `spread`: null without a filter.
  void Begin(const TileMesh& mesh, const LineClass& lines, const LineGroup& group, TileColors& colors,
             const LineSpread* spread);

  /// Adds pieces of one lane in ascending order, which do not overlap: Begin, then pieces, then End.
  /// `weight` counts instants.
  template <bool kSpread>
  void BeginLane(int lane, double weight) {
    if constexpr (kSpread) spread_sums_.BeginLane(lane);
    sums_ = lane_sums_[size_t(lane)].data();
    shares_of_lane_ = lane_shares_[size_t(lane)].data();
    points_of_lane_ = lane_points_[size_t(lane)].data();
    weight_ = weight;
    color_ = nullptr;
    end_ = 0;
  }
  template <bool kSpread>
  void AddFlat(int32_t begin, int32_t end, uint32_t index) {
    const Color& color = colors_->ColorOf(index);
    if (color_ == &color && begin == end_) {
      end_ = end;
      return;
    }
    if (color_ != nullptr && begin == end_) {
      Color change;
      for (size_t c = 0; c < 4; ++c) change[c] = weight_ * (color[c] - (*color_)[c]);
      Change<kSpread>(begin, change);
    } else {
      EndLane<kSpread>();
      Color change;
      for (size_t c = 0; c < 4; ++c) change[c] = weight_ * color[c];
      Change<kSpread>(begin, change);
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
    ChangeEither(begin, change);
    for (size_t c = 0; c < 4; ++c) change[c] = -change[c];
    ChangeEither(end, change);
  }
  template <bool kSpread>
  void EndLane() {
    if (color_ == nullptr) return;
    Color change;
    for (size_t c = 0; c < 4; ++c) change[c] = -weight_ * (*color_)[c];
    Change<kSpread>(end_, change);
    color_ = nullptr;
  }

  /// What is seen of a piece within one step, through others, or letting others be seen: so many of its
  /// subpixels, counted in any order, from number `before` on. All shares of a piece take different ones.
  struct PieceShare {
    int32_t before = 0;
    int32_t subpixels = kWhole;
  };
  /// Adds a share of a piece within one step, times `weight`.
  void AddColorShare(int32_t begin, int32_t end, const Color& color, double weight, const PieceShare& part) {
    if (spreads_) {
      spread_sums_.AddShare(begin, end, part.before, part.before + part.subpixels, color, weight);
      return;
    }
    const double share = part.subpixels;
    Color& sum = shares_of_lane_[begin >> kSubpixelBits];
    for (size_t c = 0; c < 4; ++c) sum[c] += weight * share * color[c];
  }

  /// Adds a piece of a triangle that is kept apart, or, beside its colour, of one that goes to the film where
  /// that keeps pairs. `bin`: its part of the shutter.
  void AddApart(int lane, int32_t begin, int32_t end, uint32_t index, uint16_t bin, int64_t weight,
                const LinePosition& position) {
    apart_[size_t(lane)].push_back({begin, end, index, bin, weight, {}, position});
  }
  /// The same of a share of it, within one step.
  void AddApartShare(int lane, int32_t begin, int32_t end, uint32_t index, uint16_t bin, int64_t weight,
                     const PieceShare& share, const LinePosition& position) {
    apart_[size_t(lane)].push_back({begin, end, index, bin, weight, share, position});
  }

  /// Hands everything on, in instants times subpixels.
  void End(PairWeights& weights);

 private:
  struct Piece {
    int32_t begin, end;
    uint32_t index;
    uint16_t bin;
    int64_t weight;
    PieceShare share;
    LinePosition position;
  };
  /// Of one triangle (and bin) in a step of a line.
  struct Share {
    uint64_t weight = 0;
    std::array<double, 3> position{};
  };

  /// From subpixel x on the line's colour is another.
  template <bool kSpread>
  void Change(int32_t x, const Color& change) {
    if constexpr (kSpread) {
      spread_sums_.Change(x, change);
    } else {
      ChangeSteps(x, change);
    }
  }
  void ChangeEither(int32_t x, const Color& change) {
    if (spreads_) {
      spread_sums_.Change(x, change);
    } else {
      ChangeSteps(x, change);
    }
  }
  /// For every visible piece: a call, and a change that goes through memory, are a fifth of what adding one
  /// costs.
  [[gnu::always_inline]] void ChangeSteps(int32_t x, const Color& change) {
    const int step = x >> kSubpixelBits;
    const double in_next = x & (kSubpixelsPerPixel - 1);
    const double in_this = kSubpixelsPerPixel - in_next;
    Color* const sums = sums_ + step;
    for (size_t c = 0; c < 4; ++c) sums[0][c] += change[c] * in_this;
    for (size_t c = 0; c < 4; ++c) sums[1][c] += change[c] * in_next;
  }

  void BeginPoints();
  void FlushColors(int lane);
  template <bool kSpread>
  void FlushApart(int lane, PairWeights& weights);
  template <bool kSpread>
  void FlushTriangle(int lane, uint32_t index, uint16_t bin, PairWeights& weights);
  /// Adds what columns take of a part of a piece within a step.
  void SpreadPart(const Piece& piece, int step, int32_t from, int32_t to);
  /// Shares out a step's part of a pair among the pixels around it.
  void SpreadPair(int row, int step, std::span<uint64_t> spread);

  const TileMesh* mesh_ = nullptr;
  const LineClass* lines_ = nullptr;
  const LineGroup* group_ = nullptr;
  TileColors* colors_ = nullptr;

  /// By lane and step: differences along the line, and what is added to single steps, here and by the film's
  /// PointColors.
  std::array<std::array<Color, kMaxLinePixels + 2>, kLanes> lane_sums_;
  std::array<std::array<Color, kMaxLinePixels>, kLanes> lane_shares_, lane_points_;
  bool spreads_ = false;  ///< There is a filter: spread_sums_ has the sums.
  SpreadSums spread_sums_;
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
  std::array<std::array<uint64_t, PixelFilter::kMostTaps>, kMaxLinePixels> taps_{};
  int first_step_ = 0, last_step_ = -1;
};

}  // namespace shutterline::engine
