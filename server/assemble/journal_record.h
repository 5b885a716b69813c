#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>

#include "common/asset/digest.h"
#include "common/job/output_channels.h"
#include "common/job/tile.h"

namespace shutterline::server {

/// A tile of a frame of a job, by the job's number in the store and the frame's index in the job.
struct TileAddress {
  uint64_t job = 0;
  int frame = 0;
  uint32_t tile = 0;
};

/// A journal record, as a segment's file holds it after its 8-byte head, all numbers little-endian:
///
///     record := length:u32 crc:u32 body        length = bytes of body, crc = CRC-32C of body
///     body   := job:u64 frame:u32 tile:u32 sha256[32] pixels...
inline constexpr char kJournalHead[] = "SLTILES1";
inline constexpr size_t kJournalHeadBytes = 8;
inline constexpr size_t kRecordHeadBytes = 8;
inline constexpr size_t kBodyHeadBytes = 8 + 4 + 4 + 32;
inline constexpr size_t kMaxPixelBytes = sizeof(float) * kMaxOutputChannels * kTileSize * kTileSize;

/// Appends a record to `out`; `pixels` starts at the returned position in it.
size_t AppendRecord(const TileAddress& address, const Digest& digest, absl::string_view pixels,
                    std::string& out);

struct ParsedRecord {
  enum class State { kWhole, kDamaged, kTorn };
  /// kDamaged: its length can be believed, its body not; kTorn: nothing after it can be found.
  State state = State::kTorn;
  size_t bytes = 0;  ///< Of the whole record, unless it is torn.
  TileAddress address;
  Digest digest;
  absl::string_view pixels;  ///< Into the parsed text.
};

/// The record at the start of `text`, which is what the file holds from there on.
ParsedRecord ParseRecord(absl::string_view text);

}  // namespace shutterline::server
