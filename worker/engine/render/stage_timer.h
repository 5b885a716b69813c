#pragma once

#include <chrono>

namespace shutterline::engine {

/// Adds the time since the last lap, or since it was made, to one of the stages of RenderStats.
class StageTimer {
 public:
  void Lap(double& seconds) {
    const auto now = std::chrono::steady_clock::now();
    seconds += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace shutterline::engine
