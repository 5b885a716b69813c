#include "tests/fuzz/fuzz_tile_result.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <cmath>
#include <random>

#include "proto/convert/bounded_parse.h"
#include "server/api/limits.h"
#include "server/api/messages.h"
#include "tests/fuzz/message_mutator.h"

namespace shutterline {
namespace {

constexpr size_t kMaxBatchFields = 10'000;

bool AddsUp(const RenderStats& stats) {
  v1::RenderStats message;
  return std::isfinite(stats.cull_seconds) && stats.cull_seconds >= 0 && std::isfinite(stats.setup_seconds) &&
         stats.setup_seconds >= 0 && std::isfinite(stats.resolve_seconds) && stats.resolve_seconds >= 0 &&
         std::isfinite(stats.shade_seconds) && stats.shade_seconds >= 0 && stats.lines >= 0 &&
         stats.spans >= 0;
}

/// Whether a message may carry the text.
bool IsUtf8(const std::string& text) {
  v1::TileFailure message;
  message.set_message(text);
  return v1::TileFailure().ParseFromString(message.SerializePartialAsString());
}

std::string CheckTile(v1::TileResult& result) {
  const v1::TileResult before = result;
  const absl::StatusOr<server::TileReport> report = server::TakeReport(result);
  if (!report.ok()) {
    return absl::IsInvalidArgument(report.status()) ? ""
                                                    : absl::StrCat("refused as ", report.status().ToString());
  }
  if (report->failed != before.has_failure()) return "a failure is none, or the other way round";
  if (report->failed == report->failure.empty())
    return "a failure without a reason, or a reason without failure";
  if (!report->failed && report->pixels != before.pixels()) return "other pixels";
  if (report->failed && !report->pixels.empty()) return "a failure with pixels";
  if (report->failure.size() > server::kMaxFailureBytes + 100) return "a failure's text without bound";
  if (!IsUtf8(report->failure)) return "a failure's text that no message can carry";
  if (!AddsUp(report->stats)) return "statistics that do not add up";
  if (report->render_time == absl::InfiniteDuration() || report->render_time == -absl::InfiniteDuration()) {
    return "a time without end";
  }
  if (report->job_id != before.job_id() || report->frame != before.frame() || report->tile != before.tile()) {
    return "another tile";
  }
  return "";
}

}  // namespace

std::string CheckResultBytes(const std::string& bytes) {
  v1::ResultBatch batch;
  if (const absl::Status parsed = convert::ParseBounded(bytes, kMaxBatchFields, batch); !parsed.ok()) {
    return absl::IsInvalidArgument(parsed) ? "" : absl::StrCat("parse: ", parsed.ToString());
  }
  for (v1::TileResult& result : *batch.mutable_tiles()) {
    if (std::string broken = CheckTile(result); !broken.empty()) return broken;
  }
  return "";
}

v1::ResultBatch ValidBatch(const std::string& job_id, std::mt19937_64& random) {
  v1::ResultBatch batch;
  batch.set_batch_id(1);
  for (uint64_t i = 1 + random() % 3; i > 0; --i) {
    v1::TileResult& tile = *batch.add_tiles();
    tile.set_job_id(job_id);
    tile.set_frame(int(random() % 2));
    tile.set_tile(uint32_t(random() % 4));
    if (random() % 4 == 0) {
      tile.mutable_failure()->set_code(int(random() % 20));
      std::string reason(random() % 2 == 0 ? 10 : 4095, 'r');
      if (random() % 2 == 0) reason += "\xE2\x82\xAC\xE2\x82\xAC";  // Where the text is cut.
      tile.mutable_failure()->set_message(reason);
    } else {
      tile.set_pixels(std::string(size_t{32 * 32 * 16}, char(random() % 3)));
    }
    tile.mutable_render_time()->set_nanos(1'000'000);
    if (random() % 2 == 0) tile.mutable_stats()->set_tiles(1);
  }
  return batch;
}

std::string FuzzTileResult(uint64_t seed) {
  std::mt19937_64 random(seed);
  v1::ResultBatch batch = ValidBatch("job", random);
  if (random() % 8 != 0) MutateFields(batch, random);
  std::string bytes = batch.SerializeAsString();
  if (random() % 3 == 0) MutateBytes(bytes, random);
  const std::string broken = CheckResultBytes(bytes);
  return broken.empty() ? "" : absl::StrCat("tile result: ", broken);
}

}  // namespace shutterline
