#pragma once

#include <random>
#include <string>
#include <vector>

#include "common/image/image.h"

namespace shutterline {

/// An image of uniform random values in [low, high).
inline Image RandomImage(int width, int height, uint32_t seed, float low = 0, float high = 1,
                         std::vector<std::string> channels = {"R", "G", "B", "A"}) {
  Image image(width, height, std::move(channels));
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(low, high);
  for (float& value : image.values()) value = uniform(random);
  return image;
}

}  // namespace shutterline
