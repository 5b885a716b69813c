#pragma once

#include <absl/strings/string_view.h>

#include <optional>

namespace shutterline {

/// In which order the tiles of a frame are given out to be rendered. No pixel depends on it: it decides what
/// of an unfinished frame can be seen, and what rendering it takes.
enum class TileOrder {
  kHilbert,  ///< Along a curve on which neighbours stay together: the least work.
  kCenter,   ///< From the middle of the frame outwards.
  kCoarse,   ///< Tiles far apart first, all over the frame, then those between them.
};

/// The words of the command line. Parse accepts exactly what ToString returns and otherwise returns nullopt.
absl::string_view ToString(TileOrder order);
std::optional<TileOrder> ParseTileOrder(absl::string_view word);

}  // namespace shutterline
