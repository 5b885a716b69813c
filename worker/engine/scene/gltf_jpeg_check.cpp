#include "worker/engine/scene/gltf_jpeg_check.h"

#include <absl/strings/str_cat.h>

#include <cstdint>

namespace shutterline::engine {
namespace {

constexpr uint8_t kHuffmanTables = 0xC4, kStartOfScan = 0xDA;
constexpr int kMostCodes = 256;

class Checker {
 public:
  explicit Checker(absl::string_view bytes) : bytes_(bytes) {}

  absl::Status Run() const {
    // Up to the first scan, segments follow one another by their lengths; a decoder skips what stands
    // between them. Metadata may hold any bytes and must be passed over.
    size_t at = 2;
    while (at < bytes_.size()) {
      const uint8_t marker = At(at + 1);
      if (At(at) != 0xFF || marker == 0xFF || marker == 0) {
        ++at;
        continue;
      }
      at += 2;
      if (marker == kStartOfScan) break;
      if (marker == kHuffmanTables) {
        if (absl::Status status = CheckSegment(at); !status.ok()) return status;
      }
      if (marker < 0xD0 || marker > 0xD9) at += Length(at);
    }
    // Where in the scans a decoder looks for markers depends on the decoder. In coded data FF is never
    // followed by C4 unless a table begins, so every such place is checked.
    for (; at + 1 < bytes_.size(); ++at) {
      if (At(at) != 0xFF || At(at + 1) != kHuffmanTables) continue;
      if (absl::Status status = CheckSegment(at + 2); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

 private:
  /// Past the end there are zeros, as the decoder reads them.
  uint8_t At(size_t i) const { return i < bytes_.size() ? uint8_t(bytes_[i]) : 0; }
  size_t Length(size_t at) const { return size_t{At(at)} << 8 | At(at + 1); }

  /// `at`: the segment's length, which is followed by tables of 1 + 16 bytes and their codes.
  absl::Status CheckSegment(size_t at) const {
    int64_t left = int64_t(Length(at)) - 2;
    for (size_t table = at + 2; left > 0;) {
      int codes = 0;
      for (size_t i = 1; i <= 16; ++i) codes += At(table + i);
      if (codes > kMostCodes) {
        return absl::InvalidArgumentError(absl::StrCat("its Huffman table at byte ", table, " has ", codes,
                                                       " codes, more than ", kMostCodes));
      }
      table += 17 + size_t(codes);
      left -= 17 + codes;
    }
    return absl::OkStatus();
  }

  const absl::string_view bytes_;
};

}  // namespace

absl::Status CheckJpegHuffmanTables(absl::string_view bytes) {
  return Checker(bytes).Run();
}

}  // namespace shutterline::engine
