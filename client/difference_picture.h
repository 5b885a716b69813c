#pragma once

#include "common/image/image.h"

namespace shutterline::client {

/// |a - b| of the channels R, G and B, scaled so that the largest becomes 1; black where the pictures are
/// equal. Both have the same size and channels, and no value that is not finite.
Image DifferencePicture(const Image& a, const Image& b);

}  // namespace shutterline::client
