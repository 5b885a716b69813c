#include "worker/engine/scene/environment.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/status_macros.h"
#include "common/image/exr.h"

namespace shutterline::engine {
namespace {

/// Where the channel is, or -1.
int Find(const Image& image, absl::string_view name) {
  const auto& names = image.channels();
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? -1 : int(at - names.begin());
}

absl::StatusOr<std::shared_ptr<const Environment>> Decode(absl::string_view bytes) {
  ExrLimits limits;
  limits.max_side = kMaxEnvironmentWidth;
  limits.max_values = uint64_t{4} * kMaxEnvironmentWidth * kMaxEnvironmentWidth / 2;
  SL_ASSIGN_OR_RETURN(const Image image, DecodeExr(bytes, std::string(kEnvironmentFile), nullptr, limits));
  if (image.width() != 2 * image.height()) {
    return absl::InvalidArgumentError(
        absl::StrCat(image.width(), " x ", image.height(),
                     " pixels: a picture of latitude and longitude is twice as wide as high"));
  }
  int channels[3] = {Find(image, "R"), Find(image, "G"), Find(image, "B")};
  if (const int gray = Find(image, "Y"); gray >= 0 && channels[0] < 0) std::fill_n(channels, 3, gray);
  if (*std::min_element(channels, channels + 3) < 0) {
    return absl::InvalidArgumentError("it has neither channels R, G and B nor Y");
  }
  auto environment = std::make_shared<Environment>();
  environment->width = image.width();
  environment->height = image.height();
  environment->texels.reserve(size_t(image.width()) * size_t(image.height()));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      V3f& texel = environment->texels.emplace_back();
      for (int c = 0; c < 3; ++c) {
        const float value = image.At(x, y)[channels[c]];
        if (!std::isfinite(value)) {
          return absl::InvalidArgumentError(absl::StrCat("pixel (", x, ", ", y, "), channel ",
                                                         image.channels()[size_t(channels[c])], ": ", value,
                                                         " is not finite"));
        }
        texel[c] = std::max(value, 0.0f);
      }
    }
  }
  return std::shared_ptr<const Environment>(std::move(environment));
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Environment>> DecodeEnvironment(absl::string_view bytes) {
  auto environment = Decode(bytes);
  if (!environment.ok()) return Annotate(environment.status(), "environment");
  return environment;
}

absl::StatusOr<std::shared_ptr<const Environment>> ReadEnvironment(const AssetSource& source,
                                                                   uint64_t max_file_bytes) {
  const absl::StatusOr<std::string> bytes = source.Read(kEnvironmentFile, max_file_bytes);
  if (absl::IsNotFound(bytes.status())) return std::shared_ptr<const Environment>();
  if (!bytes.ok()) return bytes.status();
  return DecodeEnvironment(*bytes);
}

}  // namespace shutterline::engine
