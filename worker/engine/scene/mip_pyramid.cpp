#include "worker/engine/scene/mip_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine {
namespace {

float LinearFromSrgb(double s) {
  return float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

std::array<float, 256> MakeSrgbTable() {
  std::array<float, 256> table{};
  for (int code = 0; code < 256; ++code) table[size_t(code)] = LinearFromSrgb(code / 255.0);
  return table;
}

const std::array<float, 256> kSrgbTable = MakeSrgbTable();

/// 256 KiB, made when the first picture of 16 bits is read.
const std::vector<float>& Srgb16Table() {
  static const auto& table = *new std::vector<float>([] {
    std::vector<float> made(65536);
    for (size_t code = 0; code < made.size(); ++code) made[code] = LinearFromSrgb(double(code) / 65535.0);
    return made;
  }());
  return table;
}

/// Which texels of the larger level one texel covers along an axis, and how much of each: at most three.
struct Cover {
  int first = 0, count = 0;
  std::array<float, 4> weights{};
};

Cover CoverOf(int i, int small, int large) {
  const double scale = double(large) / small;
  const double begin = i * scale, end = (i + 1) * scale;
  Cover cover;
  cover.first = int(begin);
  for (int texel = cover.first; texel < large && cover.count < 4; ++texel) {
    const double part = std::min<double>(end, texel + 1) - std::max<double>(begin, texel);
    if (part <= 1e-9) break;
    cover.weights[size_t(cover.count++)] = float(part / scale);
  }
  return cover;
}

}  // namespace

float LinearFromSrgb8(uint8_t code) {
  return kSrgbTable[code];
}

float LinearFromSrgb16(uint16_t code) {
  return Srgb16Table()[code];
}

MipPyramid::MipPyramid(const TextureImage& image, TextureEncoding encoding)
    : image_(image), encoding_(encoding) {
  for (int level = 0; Width(level) > 1 || Height(level) > 1; ++level) {
    Level next;
    next.width = std::max(1, Width(level) / 2);
    next.height = std::max(1, Height(level) / 2);
    next.rgba.resize(size_t(next.width) * size_t(next.height) * 4);
    std::vector<Cover> columns_of(size_t(next.width));
    for (int x = 0; x < next.width; ++x) columns_of[size_t(x)] = CoverOf(x, next.width, Width(level));
    for (int y = 0; y < next.height; ++y) {
      const Cover rows = CoverOf(y, next.height, Height(level));
      for (int x = 0; x < next.width; ++x) {
        const Cover& columns = columns_of[size_t(x)];
        V4f sum(0);
        for (int j = 0; j < rows.count; ++j) {
          for (int i = 0; i < columns.count; ++i) {
            sum += rows.weights[size_t(j)] * columns.weights[size_t(i)] *
                   Texel(level, columns.first + i, rows.first + j);
          }
        }
        uint16_t* texel = &next.rgba[(size_t(y) * size_t(next.width) + size_t(x)) * 4];
        for (int c = 0; c < 4; ++c) {
          texel[c] = uint16_t(std::lround(std::clamp(sum[c], 0.f, 1.f) * 65535.f));
        }
      }
    }
    levels_.push_back(std::move(next));
  }
}

int MipPyramid::Width(int level) const {
  return level == 0 ? image_.width : levels_[size_t(level) - 1].width;
}

int MipPyramid::Height(int level) const {
  return level == 0 ? image_.height : levels_[size_t(level) - 1].height;
}

std::array<V4f, 4> MipPyramid::Texels(int level, int left, int right, int top, int bottom) const {
  if (level == 0) {
    return {Texel(0, left, top), Texel(0, right, top), Texel(0, left, bottom), Texel(0, right, bottom)};
  }
  const Level& l = levels_[size_t(level) - 1];
  const auto at = [&](int x, int y) {
    const uint16_t* t = &l.rgba[(size_t(y) * size_t(l.width) + size_t(x)) * 4];
    return V4f(t[0], t[1], t[2], t[3]) / 65535.f;
  };
  return {at(left, top), at(right, top), at(left, bottom), at(right, bottom)};
}

V4f MipPyramid::Texel(int level, int x, int y) const {
  if (level > 0) {
    const Level& l = levels_[size_t(level) - 1];
    const uint16_t* t = &l.rgba[(size_t(y) * size_t(l.width) + size_t(x)) * 4];
    return V4f(t[0], t[1], t[2], t[3]) / 65535.f;
  }
  const size_t at = (size_t(y) * size_t(image_.width) + size_t(x)) * 4;
  if (!image_.rgba16.empty()) {
    const uint16_t* t = &image_.rgba16[at];
    if (encoding_ == TextureEncoding::kLinear) return V4f(t[0], t[1], t[2], t[3]) / 65535.f;
    return {LinearFromSrgb16(t[0]), LinearFromSrgb16(t[1]), LinearFromSrgb16(t[2]), t[3] / 65535.f};
  }
  const uint8_t* t = &image_.rgba[at];
  if (encoding_ == TextureEncoding::kLinear) return V4f(t[0], t[1], t[2], t[3]) / 255.f;
  return {kSrgbTable[t[0]], kSrgbTable[t[1]], kSrgbTable[t[2]], t[3] / 255.f};
}

MipPyramidCache& MipPyramidCache::operator=(const MipPyramidCache& other) {
  if (this != &other) {
    const std::lock_guard lock(mutex_);
    pyramids_ = {};
  }
  return *this;
}

std::shared_ptr<const MipPyramid> MipPyramidCache::Get(const std::vector<TextureImage>& images, int image,
                                                       TextureEncoding encoding) const {
  auto& of_encoding = pyramids_[size_t(encoding)];
  {
    const std::lock_guard lock(mutex_);
    if (of_encoding.size() != images.size()) of_encoding.assign(images.size(), nullptr);
    if (const auto& made = of_encoding[size_t(image)]) return made;
  }
  // Made without the lock, so that several images are made at a time; if two threads make the same one,
  // the first to finish wins and both are equal.
  auto made = std::make_shared<const MipPyramid>(images[size_t(image)], encoding);
  const std::lock_guard lock(mutex_);
  auto& slot = of_encoding[size_t(image)];
  if (!slot) slot = std::move(made);
  return slot;
}

}  // namespace shutterline::engine
