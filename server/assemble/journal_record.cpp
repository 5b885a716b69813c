#include "server/assemble/journal_record.h"

#include <algorithm>

#include "server/assemble/crc32c.h"

namespace shutterline::server {
namespace {

template <typename T>
void Put(T value, std::string& out) {
  for (size_t i = 0; i < sizeof(T); ++i) out.push_back(char(value >> (8 * i) & 0xff));
}

template <typename T>
T Get(absl::string_view text, size_t at) {
  T value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) value |= T{static_cast<unsigned char>(text[at + i])} << (8 * i);
  return value;
}

}  // namespace

size_t AppendRecord(const TileAddress& address, const Digest& digest, absl::string_view pixels,
                    std::string& out) {
  std::string head;
  Put(address.job, head);
  Put(uint32_t(address.frame), head);
  Put(address.tile, head);
  head.append(reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size());
  const size_t start = out.size();
  Put(uint32_t(head.size() + pixels.size()), out);
  Put(uint32_t{0}, out);  // The checksum, once the body stands in one piece.
  out.append(head);
  const size_t position = out.size();
  out.append(pixels.data(), pixels.size());
  std::string crc;
  Put(Crc32c(absl::string_view(out).substr(start + kRecordHeadBytes)), crc);
  std::copy(crc.begin(), crc.end(), out.begin() + std::ptrdiff_t(start) + 4);
  return position;
}

ParsedRecord ParseRecord(absl::string_view text) {
  ParsedRecord record;
  if (text.size() < kRecordHeadBytes + kBodyHeadBytes) return record;
  const size_t length = Get<uint32_t>(text, 0);
  if (length < kBodyHeadBytes || length > kBodyHeadBytes + kMaxPixelBytes) return record;
  if (text.size() < kRecordHeadBytes + length) return record;
  record.bytes = kRecordHeadBytes + length;
  const absl::string_view body = text.substr(kRecordHeadBytes, length);
  if (Crc32c(body) != Get<uint32_t>(text, 4)) {
    record.state = ParsedRecord::State::kDamaged;
    return record;
  }
  record.state = ParsedRecord::State::kWhole;
  record.address = {Get<uint64_t>(body, 0), int(Get<uint32_t>(body, 8)), Get<uint32_t>(body, 12)};
  std::copy_n(body.begin() + 16, 32, reinterpret_cast<char*>(record.digest.bytes.data()));
  record.pixels = body.substr(kBodyHeadBytes);
  return record;
}

}  // namespace shutterline::server
