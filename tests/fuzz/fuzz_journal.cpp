#include "tests/fuzz/fuzz_journal.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "server/assemble/tile_journal.h"

namespace shutterline::server {
namespace {

using Random = std::mt19937_64;
using Key = std::tuple<uint64_t, int, uint32_t>;

Key KeyOf(const TileAddress& at) {
  return {at.job, at.frame, at.tile};
}

/// CRC-32C bit by bit, from its polynomial: slow, and sharing nothing with the journal's.
uint32_t SlowCrc(absl::string_view data) {
  uint32_t crc = ~0u;
  for (const char byte : data) {
    for (int bit = 0; bit < 8; ++bit) {
      const bool one = ((crc ^ (static_cast<unsigned char>(byte) >> bit)) & 1) != 0;
      crc = (crc >> 1) ^ (one ? 0x82f63b78u : 0u);
    }
  }
  return ~crc;
}

std::string LittleEndian(uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text.push_back(char(value >> (8 * i) & 0xff));
  return text;
}

struct Written {
  TileAddress at;
  Digest digest;
  std::string pixels;
  size_t end = 0;  ///< Of its record in the file.
};

struct Segment {
  std::string bytes;  ///< As it lies there.
  size_t whole = 0;   ///< So many bytes from the beginning are as they were written.
  std::vector<Written> records;
};

std::string RandomBytes(Random& random, size_t count) {
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = char(random());
  return bytes;
}

Segment Write(Random& random) {
  Segment segment;
  segment.bytes = kJournalHead;
  const size_t count = random() % 8;
  for (size_t i = 0; i < count; ++i) {
    Written record;
    // Few addresses, so that some come twice; now and then ones that no job has.
    record.at = {1 + random() % 2, int(random() % 3), uint32_t(random() % 6)};
    if (random() % 16 == 0) record.at = {random(), int(random()), uint32_t(random())};
    const size_t sizes[] = {0, 1, random() % 64, random() % 4096, size_t{16} << 10};
    record.pixels = RandomBytes(random, sizes[random() % std::size(sizes)]);
    record.digest = Sha256(record.pixels);
    if (random() % 16 == 0) record.digest.bytes[random() % 32] ^= 1;  // Sound on the disk, but untrue.
    AppendRecord(record.at, record.digest, record.pixels, segment.bytes);
    record.end = segment.bytes.size();
    segment.records.push_back(std::move(record));
  }
  segment.whole = segment.bytes.size();
  return segment;
}

void Mutate(Random& random, Segment& segment) {
  std::string& bytes = segment.bytes;
  const size_t at = bytes.empty() ? 0 : random() % bytes.size();
  const size_t length = std::min(bytes.size() - at, size_t(1 + random() % 200));
  segment.whole = std::min(segment.whole, at);
  switch (random() % 9) {
    case 0:
      if (!bytes.empty()) bytes[at] = char(bytes[at] ^ (1 << random() % 8));
      break;
    case 1:
      bytes.resize(at);
      break;
    case 2:
      bytes.erase(at, length);
      break;
    case 3:
      bytes.insert(at, RandomBytes(random, length));
      break;
    case 4:  // As after a loss of power: the file's length is on the disk, what was in it is not.
      std::fill(bytes.begin() + std::ptrdiff_t(at), bytes.end(), '\0');
      break;
    case 5:
      bytes.insert(at, bytes.substr(random() % (bytes.size() + 1), random() % 3000));
      break;
    case 6: {  // A length, if it hits one, that means anything.
      const uint32_t lengths[] = {0, 48, 47, 0xffffffffu, uint32_t(bytes.size()), uint32_t(random())};
      bytes.replace(at, std::min<size_t>(4, bytes.size() - at),
                    LittleEndian(lengths[random() % std::size(lengths)], 4));
      break;
    }
    case 7:
      bytes += RandomBytes(random, random() % 300);
      segment.whole = std::min(segment.whole, bytes.size());
      break;
    default:
      bytes = RandomBytes(random, random() % 5000);
      segment.whole = 0;
  }
}

/// Whether some file holds this tile in a record whose checksum is right.
bool StandsInAFile(const std::vector<Segment>& segments, const Key& key, const Digest& digest,
                   const std::string& pixels) {
  const auto& [job, frame, tile] = key;
  std::string body = LittleEndian(job, 8) + LittleEndian(uint32_t(frame), 4) + LittleEndian(tile, 4);
  body.append(reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size());
  body += pixels;
  const std::string record = LittleEndian(body.size(), 4) + LittleEndian(SlowCrc(body), 4) + body;
  return std::any_of(segments.begin(), segments.end(),
                     [&](const Segment& segment) { return segment.bytes.find(record) != std::string::npos; });
}

std::string Check(TileJournal& journal, const std::vector<Segment>& segments, std::set<Key>& found) {
  for (const TileJournal::FrameKey& frame : journal.Frames()) {
    for (const uint32_t tile : journal.Tiles(frame)) {
      const TileAddress at{frame.first, frame.second, tile};
      const auto pixels = journal.Read(at);
      found.insert(KeyOf(at));
      // A digest that never was that of the pixels is found out here, and the tile rendered again.
      if (absl::IsDataLoss(pixels.status())) continue;
      if (!pixels.ok())
        return absl::StrCat("a tile that is listed cannot be read: ", pixels.status().ToString());
      if (!StandsInAFile(segments, KeyOf(at), *journal.Find(at), *pixels))
        return absl::StrCat("tile ", tile, " was found, but stands in no record with a right checksum");
    }
  }
  for (size_t i = 0; i < segments.size(); ++i) {
    for (const Written& record : segments[i].records) {
      if (record.end <= segments[i].whole && !found.contains(KeyOf(record.at)))
        return absl::StrCat("tile ", record.at.tile, " lies before the damage of segment ", i + 1,
                            " and was not found");
    }
  }
  return "";
}

}  // namespace

std::string FuzzJournal(uint64_t seed, const std::string& folder) {
  Random random(seed);
  std::vector<Segment> segments(1 + random() % 3);
  for (size_t i = 0; i < segments.size(); ++i) {
    segments[i] = Write(random);
    for (uint64_t mutations = random() % 4; mutations > 0; --mutations) Mutate(random, segments[i]);
    std::ofstream(absl::StrCat(folder, "/", absl::Dec(i + 1, absl::kZeroPad12), ".tiles"), std::ios::binary)
        .write(segments[i].bytes.data(), std::streamsize(segments[i].bytes.size()));
  }
  const TileJournal::Options options{.max_segment_bytes = 1 << 20, .durability = Durability::kProcess};
  std::set<Key> found;
  const TileAddress added{77, 0, 1};
  const std::string pixels = RandomBytes(random, 100);
  {
    const auto journal = TileJournal::Open(folder, options);
    if (!journal.ok()) return absl::StrCat("it cannot be opened: ", journal.status().ToString());
    std::string broken = Check(**journal, segments, found);
    if (!broken.empty()) return broken;
    if ((*journal)->Stage(added, Sha256(pixels), pixels) != TileJournal::Outcome::kStaged)
      return "a new tile is taken for an old one";
    const absl::Status committed = (*journal)->Commit();
    if (!committed.ok()) return absl::StrCat("it does not go on: ", committed.ToString());
  }
  // What was found once is found again, beside what is new.
  const auto journal = TileJournal::Open(folder, options);
  if (!journal.ok()) return absl::StrCat("it cannot be opened again: ", journal.status().ToString());
  for (const Key& key : found) {
    const auto& [job, frame, tile] = key;
    if (!(*journal)->Find({job, frame, tile})) return "a tile was found the first time only";
  }
  if ((*journal)->Read(added).value_or("") != pixels) return "the new tile is lost";
  return "";
}

}  // namespace shutterline::server
