#include "common/image/metrics.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/status_macros.h"
#include "common/math/compensated_sum.h"

namespace shutterline {
namespace {

std::string Shape(const Image& image) {
  return absl::StrCat(image.width(), " × ", image.height(), " with channels ",
                      absl::StrJoin(image.channels(), ","));
}

absl::Status CheckFinite(const Image& image, absl::string_view name) {
  const std::vector<float>& values = image.values();
  const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad == values.end()) return absl::OkStatus();
  const size_t index = size_t(bad - values.begin());
  const size_t channels = size_t(image.channel_count());
  const size_t pixel = index / channels;
  return absl::InvalidArgumentError(
      absl::StrCat("compare: ", name, " is ", std::isnan(*bad) ? "NaN" : "infinite", " at pixel (",
                   pixel % size_t(image.width()), ", ", pixel / size_t(image.width()), "), channel ",
                   image.channels()[index % channels]));
}

absl::Status CheckSameShape(const Image& a, absl::string_view a_name, const Image& b,
                            absl::string_view b_name) {
  if (a.width() == b.width() && a.height() == b.height() && a.channels() == b.channels()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("compare: ", a_name, " is ", Shape(a), ", but ", b_name, " is ", Shape(b)));
}

absl::StatusOr<std::array<size_t, 3>> PlacesOfColour(const Image& image) {
  if (image.width() < 1 || image.height() < 1) return absl::InvalidArgumentError("compare: empty pictures");
  std::array<size_t, 3> result{};
  const std::array<const char*, 3> wanted = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) {
    const auto found = std::find(image.channels().begin(), image.channels().end(), wanted[c]);
    if (found == image.channels().end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("compare: the pictures have no channel ", wanted[c], " (", Shape(image), ")"));
    }
    result[c] = size_t(found - image.channels().begin());
  }
  return result;
}

}  // namespace

absl::StatusOr<Comparison> Compare(const Image& test, const Image& reference) {
  SL_RETURN_IF_ERROR(CheckSameShape(test, "the picture", reference, "the reference"));
  SL_ASSIGN_OR_RETURN(const auto colours, PlacesOfColour(test));
  SL_RETURN_IF_ERROR(CheckFinite(test, "the picture"));
  SL_RETURN_IF_ERROR(CheckFinite(reference, "the reference"));

  Comparison result;
  result.largest_channel = test.channels().front();
  CompensatedSum squares, relative;
  for (int y = 0; y < test.height(); ++y) {
    for (int x = 0; x < test.width(); ++x) {
      const float *t = test.At(x, y), *r = reference.At(x, y);
      for (size_t c = 0; c < test.channels().size(); ++c) {
        const double difference = std::abs(double(t[c]) - double(r[c]));
        if (difference > result.largest_difference) {
          result.largest_difference = difference;
          result.largest_x = x;
          result.largest_y = y;
          result.largest_channel = test.channels()[c];
        }
      }
      for (const size_t c : colours) {
        const double difference = double(t[c]) - double(r[c]);
        const double scale = double(r[c]) + 0.01;
        squares.Add(difference * difference);
        // 0 / 0 only where a negative reference of exactly −0.01 is met exactly: no error there.
        if (difference != 0) relative.Add(difference / scale * (difference / scale));
      }
    }
  }
  const double count = 3.0 * test.width() * test.height();
  result.rmse = std::sqrt(squares.Total() / count);
  result.psnr = -20 * std::log10(result.rmse);
  result.relative_mse = relative.Total() / count;
  return result;
}

double UnbiasedError::Rmse() const {
  return d > 0 ? std::sqrt(d) : 0;
}

std::string UnbiasedError::ToString() const {
  const std::string figures = absl::StrFormat("(D %.3g ± %.1g)", d, 2 * standard_error);
  if (BelowFloor()) return absl::StrCat("below the reference's floor ", figures);
  return absl::StrCat("RMSE ", absl::StrFormat("%.4g ", Rmse()), figures);
}

absl::StatusOr<UnbiasedError> MeasureUnbiasedError(const Image& test, const Image& half_a,
                                                   const Image& half_b, absl::Span<const uint8_t> mask) {
  SL_RETURN_IF_ERROR(CheckSameShape(test, "the picture", half_a, "reference half A"));
  SL_RETURN_IF_ERROR(CheckSameShape(test, "the picture", half_b, "reference half B"));
  SL_ASSIGN_OR_RETURN(const auto colours, PlacesOfColour(test));
  SL_RETURN_IF_ERROR(CheckFinite(test, "the picture"));
  SL_RETURN_IF_ERROR(CheckFinite(half_a, "reference half A"));
  SL_RETURN_IF_ERROR(CheckFinite(half_b, "reference half B"));
  const size_t pixels = size_t(test.width()) * size_t(test.height());
  if (!mask.empty() && mask.size() != pixels) {
    return absl::InvalidArgumentError(
        absl::StrCat("compare: the mask has ", mask.size(), " pixels, the pictures have ", pixels));
  }

  std::vector<double> products;
  CompensatedSum sum;
  for (size_t i = 0; i < pixels; ++i) {
    if (!mask.empty() && mask[i] == 0) continue;
    const size_t first = i * test.channels().size();
    double product = 0;
    for (const size_t c : colours) {
      const double t = test.values()[first + c];
      product += (t - half_a.values()[first + c]) * (t - half_b.values()[first + c]);
    }
    products.push_back(product / 3);
    sum.Add(product / 3);
  }
  if (products.empty()) return absl::InvalidArgumentError("compare: the mask leaves no pixel");

  UnbiasedError result;
  result.pixels = int64_t(products.size());
  const double count = double(products.size());
  result.d = sum.Total() / count;
  CompensatedSum squares;
  for (const double product : products) squares.Add((product - result.d) * (product - result.d));
  result.standard_error = products.size() < 2 ? std::numeric_limits<double>::infinity()
                                              : std::sqrt(squares.Total() / (count - 1) / count);
  return result;
}

}  // namespace shutterline
