#pragma once

#include <string>
#include <vector>

#include "common/job/render_settings.h"

namespace shutterline {

/// A channel of a frame: what each tile holds of it, in this order, and what the EXR calls it.
struct OutputChannel {
  std::string name;
  bool exact = false;  ///< Written as 32-bit floats whatever the file's pixel type: ids, lengths.

  friend bool operator==(const OutputChannel&, const OutputChannel&) = default;
};

/// Channels of the frames that `settings` ask for: R, G, B, A, then those of the AOVs in the order of the
/// enumeration, then those of the mattes. docs/formats.md says what each holds.
std::vector<OutputChannel> OutputChannelsOf(const RenderSettings& settings);

/// The number of these, at most kMaxOutputChannels: floats a pixel of a tile.
int OutputChannelCount(const RenderSettings& settings);

inline constexpr int kMaxOutputChannels = 22 + 2 * 4 * (kMaxMatteRanks / 2);

/// Channels of an AOV.
int ChannelCount(Aov aov);
/// Channels of a matte of so many ranks: four for each two.
int MatteChannelCount(int ranks);
/// The name of a Cryptomatte, which its channels' names and its metadata begin with: "CryptoObject".
std::string MatteName(Matte matte);

}  // namespace shutterline
