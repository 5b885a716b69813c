#include "tests/bench/pareto.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::bench {
namespace {

/// On the straight line through two points in log-log, at x.
double LogLog(double x0, double y0, double x1, double y1, double x) {
  const double s = (std::log(x) - std::log(x0)) / (std::log(x1) - std::log(x0));
  return std::exp(std::log(y0) + s * (std::log(y1) - std::log(y0)));
}

}  // namespace

std::string Reading::ToString() const {
  if (kind == Kind::kNone) return "–";
  const char* sign = kind == Kind::kAtMost ? "≤ " : kind == Kind::kAtLeast ? "> " : "";
  return absl::StrCat(sign, absl::StrFormat("%.3g", value));
}

TimeErrorCurve::TimeErrorCurve(std::vector<TimeError> runs) {
  std::sort(runs.begin(), runs.end(), [](const TimeError& a, const TimeError& b) {
    return a.seconds != b.seconds ? a.seconds < b.seconds : a.error < b.error;
  });
  for (const TimeError& run : runs) {
    SL_CHECK(run.seconds > 0 && run.error > 0);
    longest_ = run.seconds;
    if (envelope_.empty() || run.error < envelope_.back().error) envelope_.push_back(run);
  }
}

Reading TimeErrorCurve::SecondsFor(double error) const {
  if (envelope_.empty()) return {};
  if (error > envelope_.front().error) return {Reading::Kind::kAtMost, envelope_.front().seconds};
  for (size_t i = 0; i < envelope_.size(); ++i) {
    if (envelope_[i].error > error) continue;
    if (i == 0) return {Reading::Kind::kExact, envelope_[0].seconds};
    const TimeError &a = envelope_[i - 1], &b = envelope_[i];
    return {Reading::Kind::kExact, LogLog(a.error, a.seconds, b.error, b.seconds, error)};
  }
  return {Reading::Kind::kAtLeast, longest_};
}

Reading TimeErrorCurve::ErrorWithin(double seconds) const {
  if (envelope_.empty() || seconds < envelope_.front().seconds) return {};
  for (size_t i = 1; i < envelope_.size(); ++i) {
    if (envelope_[i].seconds < seconds) continue;
    const TimeError &a = envelope_[i - 1], &b = envelope_[i];
    return {Reading::Kind::kExact, LogLog(a.seconds, a.error, b.seconds, b.error, seconds)};
  }
  const bool at_last = seconds == envelope_.back().seconds;
  return {at_last ? Reading::Kind::kExact : Reading::Kind::kAtMost, envelope_.back().error};
}

Reading Ratio(const Reading& rival, const Reading& ours) {
  using Kind = Reading::Kind;
  if (rival.kind == Kind::kNone || ours.kind == Kind::kNone) return {};
  const double value = rival.value / ours.value;
  // Dividing by what is at most x gives at least, and the other way round.
  const bool up = rival.kind == Kind::kAtLeast || ours.kind == Kind::kAtMost;
  const bool down = rival.kind == Kind::kAtMost || ours.kind == Kind::kAtLeast;
  if (up && down) return {};
  return {up ? Kind::kAtLeast : down ? Kind::kAtMost : Kind::kExact, value};
}

std::optional<double> GeometricMean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  double sum = 0;
  for (const double value : values) {
    SL_CHECK(value > 0);
    sum += std::log(value);
  }
  return std::exp(sum / double(values.size()));
}

}  // namespace shutterline::bench
