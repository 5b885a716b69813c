#include "worker/engine/shading/texture_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "worker/engine/shading/texture_lookup.h"
#include "worker/engine/shading/texture_sampler.h"

namespace shutterline::engine {
namespace {

TextureImage RandomImage(int width, int height, int bits, std::mt19937& random) {
  TextureImage image;
  image.width = width;
  image.height = height;
  for (int i = 0; i < 4 * width * height; ++i) {
    if (bits == 16) {
      image.rgba16.push_back(uint16_t(random()));
    } else {
      image.rgba.push_back(uint8_t(random()));
    }
  }
  return image;
}

/// The definition, texel by texel in double.
class Plain {
 public:
  Plain(const MipPyramid& pyramid, const Texture& texture) : pyramid_(pyramid), texture_(texture) {}

  V4d Sample(const V2d& uv, const V2d& duv_dx, const V2d& duv_dy, int most_probes) const {
    const double along_x = Length(duv_dx), along_y = Length(duv_dy);
    const double longest = std::max(along_x, along_y);
    if (longest <= 1) return texture_.nearest ? Nearest(uv) : Bilinear(0, uv);
    const double area =
        std::abs(duv_dx.x * duv_dy.y - duv_dx.y * duv_dy.x) * pyramid_.Width(0) * pyramid_.Height(0);
    const double ratio = longest / std::max(area / longest, 1.0);
    const int probes = int(std::clamp<double>(std::ceil(ratio - 1e-6), 1, most_probes));
    const V2d& axis = along_x >= along_y ? duv_dx : duv_dy;
    V4d sum(0);
    for (int i = 0; i < probes; ++i) {
      sum += Trilinear(uv + ((i + 0.5) / probes - 0.5) * axis, std::max(longest / probes, 1.0));
    }
    return sum / probes;
  }

 private:
  double Length(const V2d& duv) const {
    return std::hypot(duv.x * pyramid_.Width(0), duv.y * pyramid_.Height(0));
  }

  static int Wrap(double texel, int size, WrapMode mode) {
    if (mode == WrapMode::kClampToEdge) return int(std::clamp<double>(texel, 0, size - 1));
    const int period = mode == WrapMode::kRepeat ? size : 2 * size;
    const int i = int(texel - period * std::floor(texel / period));
    return i < size ? i : 2 * size - 1 - i;
  }

  V4d Texel(int level, double x, double y) const {
    return V4d(pyramid_.Texel(level, Wrap(x, pyramid_.Width(level), texture_.wrap_s),
                              Wrap(y, pyramid_.Height(level), texture_.wrap_t)));
  }

  V4d Nearest(const V2d& uv) const {
    return Texel(0, std::floor(uv.x * pyramid_.Width(0)), std::floor(uv.y * pyramid_.Height(0)));
  }

  V4d Bilinear(int level, const V2d& uv) const {
    const double x = uv.x * pyramid_.Width(level) - 0.5, y = uv.y * pyramid_.Height(level) - 0.5;
    const double x0 = std::floor(x), y0 = std::floor(y), fx = x - x0, fy = y - y0;
    return (1 - fx) * (1 - fy) * Texel(level, x0, y0) + fx * (1 - fy) * Texel(level, x0 + 1, y0) +
           (1 - fx) * fy * Texel(level, x0, y0 + 1) + fx * fy * Texel(level, x0 + 1, y0 + 1);
  }

  V4d Trilinear(const V2d& uv, double texels) const {
    const int last = pyramid_.level_count() - 1;
    const double lod = std::min<double>(std::log2(texels), last);
    const int level = int(lod);
    if (level == last) return Bilinear(last, uv);
    return (1 - (lod - level)) * Bilinear(level, uv) + (lod - level) * Bilinear(level + 1, uv);
  }

  const MipPyramid& pyramid_;
  const Texture& texture_;
};

WrapMode RandomWrap(std::mt19937& random) {
  constexpr WrapMode kModes[] = {WrapMode::kRepeat, WrapMode::kClampToEdge, WrapMode::kMirroredRepeat};
  return kModes[random() % 3];
}

/// From a hundredth of a texel of a large image to some images.
V2d RandomSide(std::mt19937& random) {
  std::uniform_real_distribution<double> exponent(-12, 2), angle(0, 2 * M_PI);
  const double length = std::exp2(exponent(random)), turn = angle(random);
  return {length * std::cos(turn), length * std::sin(turn)};
}

void ExpectNear(const V4f& found, const V4d& expected) {
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(double(found[c]), expected[c], 2e-6) << "channel " << c;
}

TEST(TextureWalk, SeesWhatItsDefinitionSays) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> coordinate(-5, 5);
  constexpr std::array<int, 12> kSizes = {1, 2, 3, 5, 8, 16, 33, 64, 100, 128, 31, 256};
  for (int i = 0; i < 300; ++i) {
    const int bits = random() % 2 == 0 ? 8 : 16;
    const TextureImage image =
        RandomImage(kSizes[random() % kSizes.size()], kSizes[random() % kSizes.size()], bits, random);
    const auto encoding = random() % 2 == 0 ? TextureEncoding::kSrgb : TextureEncoding::kLinear;
    const MipPyramid pyramid(image, encoding);
    Texture texture;
    texture.wrap_s = RandomWrap(random);
    texture.wrap_t = RandomWrap(random);
    texture.nearest = random() % 2 == 0;
    for (int k = 0; k < 50; ++k) {
      SCOPED_TRACE(testing::Message() << "seed 4, image " << i << " of " << image.width << " x "
                                      << image.height << " and " << bits << " bits, point " << k);
      const V2d uv(coordinate(random), coordinate(random));
      const V2d duv_dx = RandomSide(random), duv_dy = RandomSide(random);
      const int most_probes = random() % 4 == 0 ? 1 : kMostProbes;
      ExpectNear(SampleTexture(pyramid, texture, uv, duv_dx, duv_dy, most_probes),
                 Plain(pyramid, texture).Sample(uv, duv_dx, duv_dy, most_probes));
    }
  }
}

TEST(TextureWalk, OneWalkServesAllImagesOfASize) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  const TextureImage bytes = RandomImage(48, 32, 8, random), shorts = RandomImage(48, 32, 16, random);
  const MipPyramid a(bytes, TextureEncoding::kSrgb), b(shorts, TextureEncoding::kLinear);
  for (int i = 0; i < 100; ++i) {
    const V2d uv(coordinate(random), coordinate(random));
    const V2d duv_dx = RandomSide(random), duv_dy = RandomSide(random);
    TextureWalk walk;
    walk.Make(WalkedImage(a, {}), uv, duv_dx, duv_dy, kMostProbes);
    walk.Prefetch(a);
    EXPECT_EQ(walk.Sample(a), SampleTexture(a, {}, uv, duv_dx, duv_dy));
    EXPECT_EQ(walk.Sample(b), SampleTexture(b, {}, uv, duv_dx, duv_dy));
  }
}

/// A frame of a scene of some images, each one texture, and a mesh of one triangle.
struct OneTriangle {
  OneTriangle() {
    std::mt19937 random(6);
    auto made = std::make_shared<Scene>();
    for (const int width : {64, 64, 32, 64}) made->images.push_back(RandomImage(width, 64, 8, random));
    for (int i = 0; i < 4; ++i) {
      Texture texture;
      texture.image = i;
      if (i == 3) texture.wrap_s = WrapMode::kMirroredRepeat;
      made->textures.push_back(texture);
    }
    frame.scene = made;
    for (const TextureImage& image : frame.scene->images) {
      frame.pyramids[size_t(TextureEncoding::kLinear)].push_back(
          std::make_shared<const MipPyramid>(image, TextureEncoding::kLinear));
    }
    source.texcoords[0] = {V2f(0.1f, 0.2f), V2f(1.7f, 0.3f), V2f(0.4f, 2.9f)};
    source.texcoords[1] = {V2f(3, 1), V2f(2, 0), V2f(0, 0)};
  }

  FrameScene frame;
  MeshPrimitive source;
};

TEST(TextureLookup, DoesNotDependOnWhatWasLookedAtBefore) {
  const OneTriangle one;
  std::mt19937 random(7);
  const std::array<size_t, 3> corners = {0, 1, 2};
  const Barycentric at{0.5, 0.3};
  const Footprint footprint{.db1_dx = 0.03, .db1_dy = 0.01, .db2_dx = -0.02, .db2_dy = 0.05};
  PreparedMaterial material;
  std::vector<PreparedTexture> linear, srgb;
  for (int i = 0; i < 200; ++i) {
    TextureRef reference{.texture = int(random() % 4), .texcoord = int(random() % 2), .transform = {}};
    if (random() % 2 == 0) reference.transform.offset.x = 0.25;
    if (random() % 3 == 0) reference.transform.rotation = 0.5;
    if (random() % 3 == 0) reference.transform.scale.y = 2;
    linear.push_back(material.Prepare(one.frame, one.source, reference, TextureEncoding::kLinear));
    srgb.push_back(material.Prepare(one.frame, one.source, reference, TextureEncoding::kSrgb));
  }
  const TexturedTriangle triangle(material, corners);
  TextureLookup shared(material, triangle, at, footprint);
  for (size_t i = 0; i < 200; ++i) {
    TextureLookup fresh(material, triangle, at, footprint);
    if (random() % 2 == 0) shared.Prefetch(linear[i]);
    EXPECT_EQ(shared.Color(linear[i]), fresh.Color(linear[i])) << "seed 7, look " << i;
    // Nobody has made this one.
    EXPECT_EQ(shared.Color(srgb[i]), V4d(1));
  }
}

}  // namespace
}  // namespace shutterline::engine
