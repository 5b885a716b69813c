#include "client/difference_picture.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::client {

Image DifferencePicture(const Image& a, const Image& b) {
  SL_CHECK(a.width() == b.width() && a.height() == b.height() && a.channel_count() == b.channel_count());
  SL_CHECK(a.channel_count() >= 3);
  Image difference(a.width(), a.height(), {"R", "G", "B"});
  double largest = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        largest = std::max(largest, std::abs(double(a.At(x, y)[c]) - double(b.At(x, y)[c])));
      }
    }
  }
  if (largest == 0) return difference;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        difference.At(x, y)[c] =
            static_cast<float>(std::abs(double(a.At(x, y)[c]) - double(b.At(x, y)[c])) / largest);
      }
    }
  }
  return difference;
}

}  // namespace shutterline::client
