#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace shutterline::server {

/// How long a job's latest tiles took. Not thread-safe.
class TileTimes {
 public:
  void Add(double seconds);
  /// The time that 95 of 100 tiles stayed within; none before kLeast tiles: too few to tell.
  std::optional<double> NinetyFifth() const;

  static constexpr size_t kLeast = 4;

 private:
  static constexpr size_t kKept = 256;
  std::array<float, kKept> seconds_{};
  size_t count_ = 0;  ///< Of all that were added.
};

}  // namespace shutterline::server
