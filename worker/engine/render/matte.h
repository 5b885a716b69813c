#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace shutterline::engine {

/// Makes a Cryptomatte's values of a pixel: who is visible in it, each with the part of it that is his, most
/// first. Parts are the resolver's exact weights, so with enough ranks they add up to alpha. Immutable.
class MatteMaker {
 public:
  /// `names`: by index of what mattes are made of, see MatteNames. At most `ranks` of a pixel are told.
  MatteMaker(const std::vector<std::string>& names, int ranks);

  /// Floats a pixel: id and part by turns, two for each rank, the number of ranks rounded up to even.
  int channels() const { return channels_; }

  /// `weights`: indices with their weights, of `total`; in any order, an index may come several times. False
  /// if there were more ids than ranks.
  bool Write(std::span<const std::pair<int, uint64_t>> weights, uint64_t total, std::span<float> out) const;

 private:
  std::vector<uint32_t> ids_;  // By index.
  int ranks_ = 0;
  int channels_ = 0;
};

}  // namespace shutterline::engine
