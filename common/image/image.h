#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/job/tile.h"

namespace shutterline {

/// A picture of named 32-bit float channels, pixel-interleaved, rows from the top, linear light.
/// Frames have the channels R, G, B, A in this order, colours premultiplied with A.
class Image {
 public:
  Image() = default;
  Image(int width, int height, std::vector<std::string> channels = {"R", "G", "B", "A"})
      : width_(width), height_(height), channels_(std::move(channels)) {
    values_.resize(size_t(width) * size_t(height) * channels_.size());
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int channel_count() const { return int(channels_.size()); }
  const std::vector<std::string>& channels() const { return channels_; }

  float* At(int x, int y) { return &values_[(size_t(y) * size_t(width_) + size_t(x)) * channels_.size()]; }
  const float* At(int x, int y) const {
    return &values_[(size_t(y) * size_t(width_) + size_t(x)) * channels_.size()];
  }
  std::vector<float>& values() { return values_; }
  const std::vector<float>& values() const { return values_; }

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::string> channels_;
  std::vector<float> values_;
};

}  // namespace shutterline
