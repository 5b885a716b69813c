#include "client/chrome_trace.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "proto/convert/status.h"

namespace shutterline::client {
namespace {

constexpr int kCoordinator = 1;          ///< Process number; workers follow.
constexpr int kCommits = 1, kFiles = 2;  ///< Its rows.

double Microseconds(absl::Duration duration) {
  return absl::ToDoubleMicroseconds(duration);
}

Json Complete(const std::string& name, const char* category, int process, int row, absl::Duration begin,
              absl::Duration length, Json arguments) {
  return {{"name", name},
          {"cat", category},
          {"ph", "X"},
          {"pid", process},
          {"tid", row},
          {"ts", Microseconds(begin)},
          {"dur", Microseconds(length)},
          {"args", std::move(arguments)}};
}

Json Name(const char* what, int process, int row, const std::string& name) {
  return {{"name", what}, {"ph", "M"}, {"pid", process}, {"tid", row}, {"args", {{"name", name}}}};
}

}  // namespace

void ChromeTrace::Add(const v1::FrameTrace& message) {
  if (message.workers_size() > 0 || message.frame() != frame_) frame_workers_.clear();
  frame_ = message.frame();
  for (const v1::FrameTrace::Worker& worker : message.workers()) {
    const auto [found, is_new] = workers_.emplace(worker.uuid(), worker_names_.size());
    if (is_new) worker_names_.push_back(worker.name().empty() ? worker.uuid() : worker.name());
    frame_workers_.push_back(found->second);
  }
  for (const v1::FrameTrace::Tile& tile : message.tiles()) {
    if (tile.worker() >= frame_workers_.size()) continue;  // No coordinator of ours says so.
    tiles_.push_back({message.frame(), tile.tile(), frame_workers_[tile.worker()], tile.lease_id(),
                      convert::FromProto(tile.granted()), convert::FromProto(tile.received()),
                      convert::FromProto(tile.durable()), convert::FromProto(tile.render_time()),
                      absl::ZeroDuration()});
  }
  if (message.has_assembly_ended()) {
    assemblies_.push_back({message.frame(), convert::FromProto(message.assembly_began()),
                           convert::FromProto(message.assembly_ended())});
  }
}

Json ChromeTrace::Finish() const {
  std::vector<Tile> tiles = tiles_;
  absl::Duration start = absl::InfiniteDuration();
  for (const Tile& tile : tiles) start = std::min(start, tile.granted);
  if (tiles.empty()) start = absl::ZeroDuration();

  // Rows of each worker: a lease after the other, those at the same time below.
  using LeaseKey = std::pair<size_t, uint64_t>;  // Worker and lease, or, without one, a number of its own.
  std::map<LeaseKey, std::vector<Tile*>> leases;
  uint64_t nameless = uint64_t{1} << 63;
  for (Tile& tile : tiles) leases[{tile.worker, tile.lease != 0 ? tile.lease : ++nameless}].push_back(&tile);
  struct Span {
    absl::Duration begin, end;
    const std::vector<Tile*>* tiles;
    size_t worker;
  };
  std::vector<Span> spans;
  for (auto& [key, own] : leases) {
    absl::Duration next = absl::InfiniteDuration();
    for (auto tile = own.rbegin(); tile != own.rend(); ++tile) {
      (*tile)->begin = std::min((*tile)->received, next) - (*tile)->render_time;
      next = (*tile)->begin;
    }
    spans.push_back({next, own.back()->begin + own.back()->render_time, &own, key.first});
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.begin < b.begin; });

  Json events = Json::array();
  events.push_back(Name("process_name", kCoordinator, 0, "coordinator"));
  events.push_back(Name("thread_name", kCoordinator, kCommits, "commits"));
  events.push_back(Name("thread_name", kCoordinator, kFiles, "files"));
  for (size_t i = 0; i < worker_names_.size(); ++i)
    events.push_back(Name("process_name", kCoordinator + 1 + int(i), 0, "worker " + worker_names_[i]));
  std::map<size_t, std::vector<absl::Duration>> rows;  // By worker: when each row is free.
  for (const Span& span : spans) {
    std::vector<absl::Duration>& own = rows[span.worker];
    auto row = std::find_if(own.begin(), own.end(), [&](absl::Duration free) { return free <= span.begin; });
    if (row == own.end()) row = own.insert(own.end(), span.end);
    *row = span.end;
    for (const Tile* tile : *span.tiles) {
      events.push_back(Complete(absl::StrCat("frame ", tile->frame, " tile ", tile->tile), "tile",
                                kCoordinator + 1 + int(span.worker), int(row - own.begin()) + 1,
                                tile->begin - start, tile->render_time,
                                {{"frame", tile->frame},
                                 {"tile", tile->tile},
                                 {"lease", tile->lease},
                                 {"granted_us", Microseconds(tile->granted - start)},
                                 {"received_us", Microseconds(tile->received - start)},
                                 {"durable_us", Microseconds(tile->durable - start)}}));
    }
  }
  // What became durable at the same moment was one commit.
  std::map<std::pair<absl::Duration, int>, std::pair<absl::Duration, int>> commits;
  for (const Tile& tile : tiles) {
    auto& [oldest, count] =
        commits.emplace(std::make_pair(tile.durable, tile.frame), std::make_pair(tile.received, 0))
            .first->second;
    oldest = std::min(oldest, tile.received);
    ++count;
  }
  for (const auto& [key, commit] : commits) {
    events.push_back(Complete("commit", "commit", kCoordinator, kCommits, commit.first - start,
                              key.first - commit.first, {{"frame", key.second}, {"tiles", commit.second}}));
  }
  for (const Assembly& assembly : assemblies_) {
    events.push_back(Complete(absl::StrCat("write frame ", assembly.frame), "assembly", kCoordinator, kFiles,
                              assembly.began - start, assembly.ended - assembly.began,
                              {{"frame", assembly.frame}}));
  }
  return {{"displayTimeUnit", "ms"}, {"traceEvents", std::move(events)}};
}

}  // namespace shutterline::client
