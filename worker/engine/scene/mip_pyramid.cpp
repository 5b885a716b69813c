#include "worker/engine/scene/mip_pyramid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/work_limit.h"
#include "worker/engine/scene/float4.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {
namespace {

float LinearFromSrgb(double s) {
  return float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

/// Of bytes: linear values, and what they stand for as codes of sRGB.
struct ByteTables {
  std::array<float, 256> linear, srgb;

  ByteTables() {
    for (int code = 0; code < 256; ++code) {
      linear[size_t(code)] = float(code) / 255.f;
      srgb[size_t(code)] = LinearFromSrgb(code / 255.0);
    }
  }
};
const ByteTables kByteTables;

/// 256 KiB, made when the first picture of 16 bits is read.
const std::vector<float>& Srgb16Table() {
  static const auto& table = *new std::vector<float>([] {
    std::vector<float> made(65536);
    for (size_t code = 0; code < made.size(); ++code) made[code] = LinearFromSrgb(double(code) / 65535.0);
    return made;
  }());
  return table;
}

Float4 DecodedBytes(const std::array<float, 256>& color, const uint8_t* codes) {
  return Float4{color[codes[0]], color[codes[1]], color[codes[2]], kByteTables.linear[codes[3]]};
}

Float4 DecodedSrgbShorts(const float* color, const uint16_t* codes) {
  return Float4{color[codes[0]], color[codes[1]], color[codes[2]], float(codes[3]) / 65535.f};
}

TexelCodes CodesOfImage(const TextureImage& image, TextureEncoding encoding) {
  using Kind = TexelCodes::Kind;
  const bool is_srgb = encoding == TextureEncoding::kSrgb;
  if (image.rgba16.empty()) {
    return {.kind = is_srgb ? Kind::kSrgbBytes : Kind::kBytes,
            .bytes = image.rgba.data(),
            .color = is_srgb ? kByteTables.srgb.data() : nullptr};
  }
  return {.kind = is_srgb ? Kind::kSrgbShorts : Kind::kShorts,
          .shorts = image.rgba16.data(),
          .color = is_srgb ? Srgb16Table().data() : nullptr};
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
  return kByteTables.srgb[code];
}

float LinearFromSrgb16(uint16_t code) {
  return Srgb16Table()[code];
}

template <typename Use>
auto MipPyramid::WithTexels(int level, const Use& use) const {
  const TexelCodes codes = CodesOf(level);
  const auto use_bytes = [&](const std::array<float, 256>& color) {
    return use([&](size_t number) { return DecodedBytes(color, codes.bytes + 4 * number); }, 1.f);
  };
  // What is decoded by a table has its scale in there.
  switch (codes.kind) {
    case TexelCodes::Kind::kBytes:
      return use_bytes(kByteTables.linear);
    case TexelCodes::Kind::kSrgbBytes:
      return use_bytes(kByteTables.srgb);
    case TexelCodes::Kind::kSrgbShorts:
      return use([&](size_t number) { return DecodedSrgbShorts(codes.color, codes.shorts + 4 * number); },
                 1.f);
    case TexelCodes::Kind::kShorts:
      break;
  }
  return use([shorts = codes.shorts](size_t number) { return Float4Of(shorts + 4 * number); }, 65535.f);
}

MipPyramid::MipPyramid(const TextureImage& image, TextureEncoding encoding)
    : image_(image), first_(CodesOfImage(image, encoding)) {
  for (int level = 0; Width(level) > 1 || Height(level) > 1; ++level) levels_.push_back(Half(level));
}

MipPyramid::Level MipPyramid::Half(int level) const {
  Level half;
  half.width = std::max(1, Width(level) / 2);
  half.height = std::max(1, Height(level) / 2);
  half.rgba.resize(size_t(half.width) * size_t(half.height) * 4);
  std::vector<Cover> columns(size_t(half.width));
  for (int x = 0; x < half.width; ++x) columns[size_t(x)] = CoverOf(x, half.width, Width(level));
  const auto stride = size_t(Width(level));
  WithTexels(level, [&](const auto& texel, float scale) {
    const auto make_row = [&](int y) {
      const Cover rows = CoverOf(y, half.height, Height(level));
      uint16_t* codes = &half.rgba[size_t(y) * size_t(half.width) * 4];
      for (const Cover& across : columns) {
        Float4 sum{};
        for (int j = 0; j < rows.count; ++j) {
          const size_t row = size_t(rows.first + j) * stride + size_t(across.first);
          for (int i = 0; i < across.count; ++i) {
            const float weight = rows.weights[size_t(j)] * across.weights[size_t(i)];
            sum += weight * (texel(row + size_t(i)) / scale);
          }
        }
        // Round in double, where adding a half is exact.
        for (int c = 0; c < 4; ++c) {
          *codes++ = uint16_t(double(std::clamp(sum[c], 0.f, 1.f) * 65535.f) + 0.5);
        }
      }
    };
    constexpr int kTexelsATask = 4096;
    const WorkLimit* const limit = WorkLimit::Current();
    tbb::parallel_for(tbb::blocked_range<int>(0, half.height, size_t(1 + kTexelsATask / half.width)),
                      [&](const tbb::blocked_range<int>& range) {
                        CheckWork(limit);
                        for (int y = range.begin(); y < range.end(); ++y) make_row(y);
                      });
  });
  return half;
}

int MipPyramid::Width(int level) const {
  return level == 0 ? image_.width : levels_[size_t(level) - 1].width;
}

int MipPyramid::Height(int level) const {
  return level == 0 ? image_.height : levels_[size_t(level) - 1].height;
}

V4f MipPyramid::Sum(int level, std::span<const TexelQuad> quads) const {
  return WithTexels(level, [quads](const auto& texel, float scale) {
    Float4 sum{};
    for (const TexelQuad& quad : quads) {
      const Float4 top = Mix(texel(quad.top_left), texel(quad.top_right), quad.right);
      const Float4 bottom = Mix(texel(quad.bottom_left), texel(quad.bottom_right), quad.right);
      sum += Mix(top, bottom, quad.down);
    }
    return ToV4f(sum / scale);
  });
}

void MipPyramid::Prefetch(int level, std::span<const TexelQuad> quads) const {
  const TexelCodes codes = CodesOf(level);
  // What lies to the right is mostly in the same line of the cache.
  for (const TexelQuad& quad : quads) {
    __builtin_prefetch(codes.AddressOf(quad.top_left));
    __builtin_prefetch(codes.AddressOf(quad.bottom_left));
  }
}

V4f MipPyramid::Texel(int level, int x, int y) const {
  const size_t number = size_t(y) * size_t(Width(level)) + size_t(x);
  return WithTexels(level, [number](const auto& texel, float scale) { return ToV4f(texel(number) / scale); });
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
