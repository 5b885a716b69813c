#include "common/cryptomatte/murmur_hash.h"

#include <bit>

namespace shutterline {
namespace {

uint32_t Scramble(uint32_t block) {
  return std::rotl(block * 0xcc9e2d51u, 15) * 0x1b873593u;
}

/// Up to four bytes, the first one lowest.
uint32_t Gather(absl::string_view bytes) {
  uint32_t block = 0;
  for (size_t i = 0; i < bytes.size(); ++i) block |= uint32_t{static_cast<unsigned char>(bytes[i])} << 8 * i;
  return block;
}

}  // namespace

uint32_t MurmurHash3(absl::string_view bytes) {
  uint32_t hash = 0;
  size_t at = 0;
  for (; at + 4 <= bytes.size(); at += 4) {
    hash = std::rotl(hash ^ Scramble(Gather(bytes.substr(at, 4))), 13) * 5 + 0xe6546b64u;
  }
  if (at < bytes.size()) hash ^= Scramble(Gather(bytes.substr(at)));
  hash ^= uint32_t(bytes.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

}  // namespace shutterline
