#pragma once

#include <optional>
#include <string>
#include <vector>

/// Curves of error against time, and what is read off them.
namespace shutterline::bench {

/// One run: both positive.
struct TimeError {
  double seconds = 0;
  double error = 0;
};

/// A figure that was read off a curve, or the bound that is all that the runs allow to say.
struct Reading {
  enum class Kind {
    kExact,    ///< Between two runs, or at one.
    kAtMost,   ///< The cheapest (or the longest) run is already better than what was asked for.
    kAtLeast,  ///< No run reached it: more than the last one.
    kNone,     ///< There are no runs.
  };
  Kind kind = Kind::kNone;
  double value = 0;

  /// "1.23", "≤ 1.23", "> 1.23" or "–".
  std::string ToString() const;
};

/// The Pareto envelope of a method's runs: seconds ascend, errors fall. Between two runs of the envelope
/// the curve is a straight line in log time and log error; beyond the first and the last there is none.
class TimeErrorCurve {
 public:
  /// Runs in any order; those that another beats in both are dropped.
  explicit TimeErrorCurve(std::vector<TimeError> runs);

  const std::vector<TimeError>& envelope() const { return envelope_; }

  /// How long the method takes for an error of `error` or less. kAtMost where its cheapest run does it,
  /// kAtLeast, with the longest time tried (on or off the envelope), where none does.
  Reading SecondsFor(double error) const;
  /// The error that it reaches within `seconds`. kAtMost beyond its longest run (time would remain),
  /// kNone before its shortest.
  Reading ErrorWithin(double seconds) const;

 private:
  std::vector<TimeError> envelope_;
  double longest_ = 0;
};

/// How many times longer the rival takes: rival / ours, with what is known of it where either is a bound.
/// kNone where the bounds allow anything.
Reading Ratio(const Reading& rival, const Reading& ours);

/// Of positive values; nullopt for none.
std::optional<double> GeometricMean(const std::vector<double>& values);

}  // namespace shutterline::bench
