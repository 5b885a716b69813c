#include "worker/engine/slice/layer_compositor.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {

void LayerCompositor::Composite(std::span<const Span> layers, std::span<const Span> opaque, double t,
                                int64_t instants, int lane, TileColors& colors, LineSums& sums) {
  colors_ = &colors;
  sums_ = &sums;
  t_ = t;
  instants_ = instants;
  lane_ = lane;
  layers_.assign(layers.begin(), layers.end());
  std::sort(layers_.begin(), layers_.end(), [](const Span& a, const Span& b) { return a.begin < b.begin; });
  int32_t last = 0;
  for (const Span& layer : layers_) last = std::max(last, layer.end);

  // Opaque pieces and the gaps between them, in ascending order, as far as there is anything.
  int32_t at = layers_.front().begin;
  for (const Span& piece : opaque) {
    if (at < piece.begin) CompositeBetween(at, piece.begin, nullptr);
    CompositeBetween(piece.begin, piece.end, &piece);
    at = std::max(at, piece.end);
  }
  if (at < last) CompositeBetween(at, last, nullptr);
}

void LayerCompositor::CompositeBetween(int32_t begin, int32_t end, const Span* behind) {
  // `begin` ascends from call to call, but layers are few and may be long: all are looked at.
  over_.clear();
  cuts_.clear();
  for (const Span& layer : layers_) {
    if (layer.begin >= end) break;
    if (layer.end <= begin) continue;
    over_.push_back(&layer);
    cuts_.push_back(std::max(layer.begin, begin));
    cuts_.push_back(std::min(layer.end, end));
  }
  if (over_.empty()) {
    if (behind != nullptr) AddWhole(begin, end, *behind);
    return;
  }
  // Alpha is looked at once a pixel.
  const auto [least, most] = std::minmax_element(cuts_.begin(), cuts_.end());
  const int32_t first = *least, last = *most;
  for (int32_t border = ((first >> kSubpixelBits) + 1) << kSubpixelBits; border < last;
       border += kSubpixelsPerPixel) {
    cuts_.push_back(border);
  }
  std::sort(cuts_.begin(), cuts_.end());
  cuts_.erase(std::unique(cuts_.begin(), cuts_.end()), cuts_.end());
  if (behind != nullptr && begin < first) AddWhole(begin, first, *behind);
  for (size_t i = 0; i + 1 < cuts_.size(); ++i) CompositeStep(cuts_[i], cuts_[i + 1], behind);
  if (behind != nullptr && last < end) AddWhole(last, end, *behind);
}

void LayerCompositor::CompositeStep(int32_t begin, int32_t end, const Span* behind) {
  order_.clear();
  for (const Span* layer : over_) {
    if (layer->begin <= begin && layer->end >= end) order_.push_back(layer);
  }
  if (order_.empty()) {
    if (behind != nullptr) AddWhole(begin, end, *behind);
    return;
  }
  if (behind != nullptr) order_.push_back(behind);
  CompositeOrdered(begin, end, behind);
}

bool LayerCompositor::IsNearer(const Span& a, const Span& b, int32_t x) const {
  const float depth_a = a.DepthAt(x), depth_b = b.DepthAt(x);
  if (depth_a != depth_b) return depth_a > depth_b;
  return mesh_->triangles()[a.index].id < mesh_->triangles()[b.index].id;
}

void LayerCompositor::CompositeOrdered(int32_t begin, int32_t end, const Span* behind) {
  std::sort(order_.begin(), order_.end(),
            [&](const Span* a, const Span* b) { return IsNearer(*a, *b, begin); });
  // Where neighbours in the order at one end are not in order at the other, they cross in between.
  for (size_t i = 0; i + 1 < order_.size() && end - begin > 1; ++i) {
    const Span& near = *order_[i];
    const Span& far = *order_[i + 1];
    const float at_begin = near.DepthAt(begin) - far.DepthAt(begin);
    const float at_end = near.DepthAt(end) - far.DepthAt(end);
    if (!(at_end < 0)) continue;
    const double part = at_begin > 0 ? double(at_begin) / (double(at_begin) - double(at_end)) : 0;
    const int32_t crossing =
        std::clamp(begin + int32_t(std::lround(part * (end - begin))), begin + 1, end - 1);
    CompositeOrdered(begin, crossing, behind);
    CompositeOrdered(crossing, end, behind);
    return;
  }
  CompositeUncrossed(begin, end, behind);
}

void LayerCompositor::CompositeUncrossed(int32_t begin, int32_t end, const Span* behind) {
  const int32_t length = end - begin;
  int32_t left = length;
  for (const Span* surface : order_) {
    if (surface == behind) {
      AddShare(begin, end, *behind, {length - left, left});
      return;
    }
    const double alpha = AlphaOf(*surface, begin, end);
    if (!(alpha > 0)) continue;
    const auto share = int32_t(std::lround(alpha * double(left)));
    if (share == 0) continue;
    AddShare(begin, end, *surface, {length - left, share});
    left -= share;
    if (left == 0) return;
  }
}

double LayerCompositor::AlphaAt(const Span& layer, double x) const {
  const TileMeshTriangle& triangle = mesh_->triangles()[layer.index];
  if (triangle.layer_alpha >= 0) return double(triangle.layer_alpha);
  if (alpha_ == nullptr) return 1;
  const double l = x / kSubpixelsPerPixel;
  const LinePosition& p = layer.position;
  const double over = 1 / (p.at[2] + p.per_pixel[2] * l);
  const double b1 = ClampedFromZero((p.at[0] + p.per_pixel[0] * l) * over, 1);
  const double b2 = ClampedFromZero((p.at[1] + p.per_pixel[1] * l) * over, 1 - b1);
  return std::clamp(alpha_->AlphaAt(triangle.id, b1, b2, t_), 0.0, 1.0);
}

double LayerCompositor::AlphaOf(const Span& layer, int32_t begin, int32_t end) const {
  const TileMeshTriangle& triangle = mesh_->triangles()[layer.index];
  if (!(triangle.alpha_cutoff > 0)) return AlphaAt(layer, 0.5 * (double(begin) + double(end)));
  // A cut-out: the part of the span, on which alpha is taken as linear in two halves, that is not cut away.
  const double cutoff = double(triangle.alpha_cutoff);
  const double a[3] = {AlphaAt(layer, begin), AlphaAt(layer, 0.5 * (double(begin) + double(end))),
                       AlphaAt(layer, end)};
  double kept = 0;
  for (int half = 0; half < 2; ++half) {
    const double low = std::min(a[half], a[half + 1]), high = std::max(a[half], a[half + 1]);
    if (low >= cutoff) {
      kept += 0.5;
    } else if (high >= cutoff) {
      kept += 0.5 * (high - cutoff) / (high - low);
    }
  }
  return kept;
}

uint16_t LayerCompositor::BinOf(const Span& surface) const {
  return uint16_t(t_ * double(1u << mesh_->triangles()[surface.index].shading_bins_log2));
}

void LayerCompositor::AddWhole(int32_t begin, int32_t end, const Span& piece) {
  const ColorKind kind = colors_->KindOf(piece.index);
  if (kind == ColorKind::kConstant) sums_->AddFlatShare(begin, end, piece.index, double(instants_));
  if (kind == ColorKind::kSmooth) sums_->AddSmooth(begin, end, piece.index, piece.position);
  if (kind == ColorKind::kApart || colors_->keeps_pairs()) {
    sums_->AddApart(lane_, begin, end, piece.index, BinOf(piece), instants_, piece.position);
  }
}

void LayerCompositor::AddShare(int32_t begin, int32_t end, const Span& surface,
                               const LineSums::PieceShare& share) {
  const ColorKind kind = colors_->KindOf(surface.index);
  if (kind == ColorKind::kConstant) {
    sums_->AddColorShare(begin, end, colors_->ColorOf(surface.index), double(instants_), share);
  }
  if (kind == ColorKind::kSmooth) {
    const TileColors::Color color = colors_->MeanColor(surface.index, surface.position, begin, end);
    sums_->AddColorShare(begin, end, color, double(instants_), share);
  }
  if (kind == ColorKind::kApart || colors_->keeps_pairs()) {
    sums_->AddApartShare(lane_, begin, end, surface.index, BinOf(surface), instants_, share,
                         surface.position);
  }
}

}  // namespace shutterline::engine
