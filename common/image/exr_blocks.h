#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>
#include <vector>

#include "common/image/exr.h"

namespace shutterline {

/// An EXR made tile by tile: what EncodeExr does at once, byte for byte, for whoever gets tiles one by one,
/// in whatever order, and does not want to hold the picture.
///
///     Encode (each tile once, in any order and by any thread)   Join
///
/// A block depends on nothing but its tile's pixels and the constructor's arguments. Thread-safe.
class ExrBlockEncoder {
 public:
  /// The arguments have the meaning that they have for EncodeExr.
  ExrBlockEncoder(std::vector<std::string> channels, const OutputSettings& output,
                  std::vector<std::string> exact = {});

  /// What the file will hold of a tile of width × height pixels, at most kTileSize each. `pixels`: 32-bit
  /// floats as they lie in memory, pixel-interleaved, rows from the top. INVALID_ARGUMENT where their number
  /// is another, or the channels are none that an image can have.
  absl::StatusOr<std::string> Encode(int width, int height, absl::string_view pixels) const;

  /// The file of a picture, from the blocks of all of its tiles, in TileGrid's order. Errors as of EncodeExr.
  /// Takes memory of the file's size beside the blocks, which are freed as they are put in.
  absl::StatusOr<std::string> Join(int width, int height, std::vector<std::string> blocks,
                                   const ExrMetadata& metadata) const;

 private:
  const std::vector<std::string> channels_, exact_;
  const OutputSettings output_;
  const absl::Status names_;  ///< Whether channels can be called so.
};

}  // namespace shutterline
