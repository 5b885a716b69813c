#include "worker/engine/render/matte.h"

#include <algorithm>
#include <bit>

#include "common/cryptomatte/cryptomatte.h"
#include "common/job/output_channels.h"

namespace shutterline::engine {

MatteMaker::MatteMaker(const std::vector<std::string>& names, int ranks)
    : ranks_(ranks), channels_(MatteChannelCount(ranks)) {
  ids_.reserve(names.size());
  for (const std::string& name : names) ids_.push_back(MatteIdBits(name));
}

bool MatteMaker::Write(std::span<const std::pair<int, uint64_t>> weights, uint64_t total,
                       std::span<float> out) const {
  struct Entry {
    uint32_t id;
    uint64_t weight;
  };
  std::vector<Entry> entries;
  entries.reserve(weights.size());
  for (const auto& [index, weight] : weights) entries.push_back({ids_[size_t(index)], weight});
  // Names may be shared: what counts is the id.
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.id < b.id; });
  size_t count = 0;
  for (const Entry& entry : entries) {
    if (count > 0 && entries[count - 1].id == entry.id) {
      entries[count - 1].weight += entry.weight;
    } else {
      entries[count++] = entry;
    }
  }
  entries.resize(count);
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.id < b.id;
  });
  std::fill(out.begin(), out.end(), 0.0f);
  for (size_t rank = 0; rank < std::min(count, size_t(ranks_)); ++rank) {
    out[2 * rank] = std::bit_cast<float>(entries[rank].id);
    out[2 * rank + 1] = float(double(entries[rank].weight) / double(total));
  }
  return count <= size_t(ranks_);
}

}  // namespace shutterline::engine
