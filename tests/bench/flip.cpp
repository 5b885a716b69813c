#include "tests/bench/flip.h"

#include <absl/status/status.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/math/spaces.h"

namespace shutterline::bench {
namespace {

/// A plane of one or three values a pixel, row by row.
using Plane = std::vector<double>;
using Colors = std::vector<V3d>;

struct Size {
  int width, height;
};

// --- Colour spaces ---------------------------------------------------------------------------------

V3d XyzFromRgb(const V3d& c) {
  return {0.4123907993 * c.x + 0.3575843394 * c.y + 0.1804807884 * c.z,
          0.2126390059 * c.x + 0.7151686788 * c.y + 0.0721923154 * c.z,
          0.0193308187 * c.x + 0.1191947798 * c.y + 0.9505321522 * c.z};
}

V3d RgbFromXyz(const V3d& c) {
  return {3.2409699419 * c.x - 1.5373831776 * c.y - 0.4986107603 * c.z,
          -0.9692436363 * c.x + 1.8759675015 * c.y + 0.0415550574 * c.z,
          0.0556300797 * c.x - 0.2039769589 * c.y + 1.0569715142 * c.z};
}

const V3d kWhite = XyzFromRgb(V3d(1));

V3d YccFromRgb(const V3d& rgb) {
  const V3d n = XyzFromRgb(rgb) / kWhite;
  return {116 * n.y - 16, 500 * (n.x - n.y), 200 * (n.y - n.z)};
}

V3d RgbFromYcc(const V3d& c) {
  const double y = (c.x + 16) / 116;
  return RgbFromXyz(V3d(y + c.y / 500, y, y - c.z / 200) * kWhite);
}

/// CIELAB, its chroma scaled by lightness (Hunt's effect).
V3d HuntLabFromRgb(const V3d& rgb) {
  constexpr double kDelta = 6.0 / 29;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const V3d n = XyzFromRgb(rgb) / kWhite;
  const double lightness = 116 * f(n.y) - 16;
  return V3d(lightness, 0.01 * lightness * 500 * (f(n.x) - f(n.y)),
             0.01 * lightness * 200 * (f(n.y) - f(n.z)));
}

double HyAb(const V3d& a, const V3d& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// --- Filters ---------------------------------------------------------------------------------------

/// `kernel`, of odd length, along x or y of one channel; beyond the border lie the border's pixels.
Plane Filter(const Plane& in, Size size, const std::vector<double>& kernel, bool along_x) {
  const int radius = int(kernel.size()) / 2;
  Plane out(in.size());
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (int k = -radius; k <= radius; ++k) {
        const int column = along_x ? std::clamp(x + k, 0, size.width - 1) : x;
        const int row = along_x ? y : std::clamp(y + k, 0, size.height - 1);
        sum += kernel[size_t(k + radius)] * in[size_t(row) * size_t(size.width) + size_t(column)];
      }
      out[size_t(y) * size_t(size.width) + size_t(x)] = sum;
    }
  }
  return out;
}

std::vector<double> Kernel(int radius, const std::function<double(double)>& value) {
  std::vector<double> kernel;
  for (int k = -radius; k <= radius; ++k) kernel.push_back(value(k));
  return kernel;
}

double Sum(const std::vector<double>& kernel) {
  double sum = 0;
  for (const double value : kernel) sum += value;
  return sum;
}

/// A channel's contrast sensitivity: a mixture of two Gaussians (weights a, widths b in degrees²).
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity kAchromatic = {1, 0.0047, 0, 1e-5}, kRedGreen = {1, 0.0053, 0, 1e-5},
                      kBlueYellow = {34.1, 0.04, 13.5, 0.025};

/// The sum of the Gaussians over the plane is not separable, each of them is.
Plane Perceive(const Plane& in, Size size, const Sensitivity& s, double ppd) {
  const int radius = int(std::ceil(3 * std::sqrt(kBlueYellow.b1 / (2 * M_PI * M_PI)) * ppd));
  Plane out(in.size());
  double total = 0;
  for (const auto& [a, b] : {std::pair(s.a1, s.b1), std::pair(s.a2, s.b2)}) {
    if (a == 0) continue;
    const auto kernel =
        Kernel(radius, [&](double k) { return std::exp(-M_PI * M_PI * k * k / (ppd * ppd * b)); });
    const double factor = a * std::sqrt(M_PI / b);
    const Plane blurred = Filter(Filter(in, size, kernel, true), size, kernel, false);
    for (size_t i = 0; i < out.size(); ++i) out[i] += factor * blurred[i];
    total += factor * Sum(kernel) * Sum(kernel);
  }
  for (double& value : out) value /= total;
  return out;
}

/// Strengths of edges (first derivative) or points (second) of the achromatic channel.
Plane Features(const Plane& in, Size size, bool points, double ppd) {
  const double sigma = 0.5 * 0.082 * ppd;
  const int radius = int(std::ceil(3 * sigma));
  const auto gauss = Kernel(radius, [&](double k) { return std::exp(-k * k / (2 * sigma * sigma)); });
  auto derivative = Kernel(radius, [&](double k) {
    const double g = std::exp(-k * k / (2 * sigma * sigma));
    return points ? (k * k / (sigma * sigma) - 1) * g : -k * g;
  });
  // Positive weights of the plane's kernel sum to 1, negative ones to −1.
  double positive = 0, negative = 0;
  for (const double value : derivative) (value > 0 ? positive : negative) += std::abs(value);
  for (double& value : derivative) value /= (value > 0 ? positive : negative) * Sum(gauss);
  const Plane dx = Filter(Filter(in, size, derivative, true), size, gauss, false);
  const Plane dy = Filter(Filter(in, size, derivative, false), size, gauss, true);
  Plane out(in.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(dx[i], dy[i]);
  return out;
}

// --- Differences -----------------------------------------------------------------------------------

/// Differences of colour above this part of the largest one count little more.
constexpr double kColorExponent = 0.7, kKnee = 0.4, kKneeValue = 0.95;

double ColorDifference(const V3d& a, const V3d& b) {
  static const double largest =
      std::pow(HyAb(HuntLabFromRgb(V3d(0, 1, 0)), HuntLabFromRgb(V3d(0, 0, 1))), kColorExponent);
  const double difference = std::pow(HyAb(a, b), kColorExponent), knee = kKnee * largest;
  if (difference < knee) return kKneeValue / knee * difference;
  return kKneeValue + (difference - knee) / (largest - knee) * (1 - kKneeValue);
}

/// What of a picture is compared.
struct Percept {
  Colors lab;
  Plane edges, points;
};

Percept PerceiveImage(const Colors& rgb, Size size, double ppd) {
  Plane channels[3];
  for (Plane& channel : channels) channel.resize(rgb.size());
  for (size_t i = 0; i < rgb.size(); ++i) {
    const V3d ycc = YccFromRgb(rgb[i]);
    for (int c = 0; c < 3; ++c) channels[c][i] = ycc[c];
  }
  Percept result;
  Plane lightness = channels[0];
  for (double& value : lightness) value = (value + 16) / 116;
  result.edges = Features(lightness, size, false, ppd);
  result.points = Features(lightness, size, true, ppd);
  const Sensitivity* sensitivities[3] = {&kAchromatic, &kRedGreen, &kBlueYellow};
  for (int c = 0; c < 3; ++c) channels[c] = Perceive(channels[c], size, *sensitivities[c], ppd);
  result.lab.resize(rgb.size());
  for (size_t i = 0; i < rgb.size(); ++i) {
    V3d seen = RgbFromYcc(V3d(channels[0][i], channels[1][i], channels[2][i]));
    for (int c = 0; c < 3; ++c) seen[c] = std::clamp(seen[c], 0.0, 1.0);
    result.lab[i] = HuntLabFromRgb(seen);
  }
  return result;
}

Plane FlipOf(const Colors& test, const Colors& reference, Size size, double ppd) {
  const Percept a = PerceiveImage(test, size, ppd), b = PerceiveImage(reference, size, ppd);
  Plane out(test.size());
  for (size_t i = 0; i < out.size(); ++i) {
    const double color = ColorDifference(a.lab[i], b.lab[i]);
    const double feature = std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
    out[i] = std::pow(color, 1 - std::sqrt(std::min(1.0, feature / std::sqrt(2.0))));
  }
  return out;
}

// --- Pictures --------------------------------------------------------------------------------------

absl::Status CheckPair(const Image& test, const Image& reference) {
  const bool rgb = test.channel_count() >= 3 && test.channels()[0] == "R" && test.channels()[1] == "G" &&
                   test.channels()[2] == "B";
  if (!rgb || test.width() < 1 || test.height() < 1 || test.width() != reference.width() ||
      test.height() != reference.height() || test.channels() != reference.channels()) {
    return absl::InvalidArgumentError(
        "flip: needs two pictures of one size whose channels begin with R, G, B");
  }
  return absl::OkStatus();
}

Colors ColorsOf(const Image& image, const std::function<double(double)>& map) {
  Colors colors;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const float* p = image.At(x, y);
      colors.emplace_back(std::clamp(map(double(p[0])), 0.0, 1.0), std::clamp(map(double(p[1])), 0.0, 1.0),
                          std::clamp(map(double(p[2])), 0.0, 1.0));
    }
  }
  return colors;
}

// The ACES fit's coefficients, input scaled by 0.6.
constexpr double kAces[6] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};

double Aces(double x) {
  return (kAces[0] * x * x + kAces[1] * x + kAces[2]) / (kAces[3] * x * x + kAces[4] * x + kAces[5]);
}

}  // namespace

absl::StatusOr<Plane> FlipLdr(const Image& test, const Image& reference, double pixels_per_degree) {
  const absl::Status status = CheckPair(test, reference);
  if (!status.ok()) return status;
  const auto same = [](double value) { return value; };
  return FlipOf(ColorsOf(test, same), ColorsOf(reference, same), {test.width(), test.height()},
                pixels_per_degree);
}

ExposureRange FlipExposures(const Image& reference) {
  std::vector<double> luminances;
  for (int y = 0; y < reference.height(); ++y) {
    for (int x = 0; x < reference.width(); ++x) {
      const float* p = reference.At(x, y);
      luminances.push_back(XyzFromRgb(V3d(double(p[0]), double(p[1]), double(p[2]))).y);
    }
  }
  std::sort(luminances.begin(), luminances.end());
  if (luminances.empty() || luminances.back() <= 0) return {};
  double median = luminances[luminances.size() / 2];
  if (median <= 0) {
    const auto light = std::upper_bound(luminances.begin(), luminances.end(), 0.0);
    median = *(light + (luminances.end() - light) / 2);
  }
  // The exposure that maps x to `kTone` solves a quadratic.
  constexpr double kTone = 0.85;
  const double a = kAces[0] - kTone * kAces[3], b = kAces[1] - kTone * kAces[4],
               c = kAces[2] - kTone * kAces[5];
  const double x = -b / (2 * a) + std::sqrt(b * b / (4 * a * a) - c / a);
  ExposureRange range{std::log2(x / luminances.back()), std::log2(x / median), 2};
  range.count = std::max(2, int(std::ceil(range.stop - range.start)));
  return range;
}

absl::StatusOr<Plane> FlipHdr(const Image& test, const Image& reference, const ExposureRange& exposures,
                              double pixels_per_degree) {
  const absl::Status status = CheckPair(test, reference);
  if (!status.ok()) return status;
  Plane most(size_t(test.width()) * size_t(test.height()));
  for (int i = 0; i < exposures.count; ++i) {
    const double stops = exposures.start + (exposures.stop - exposures.start) * i / (exposures.count - 1);
    const auto expose = [&](double value) { return Aces(std::max(0.0, value) * std::exp2(stops)); };
    const Plane flip = FlipOf(ColorsOf(test, expose), ColorsOf(reference, expose),
                              {test.width(), test.height()}, pixels_per_degree);
    for (size_t k = 0; k < most.size(); ++k) most[k] = std::max(most[k], flip[k]);
  }
  return most;
}

}  // namespace shutterline::bench
