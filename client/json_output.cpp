#include "client/json_output.h"

#include <absl/time/time.h>

#include "client/delivery.h"

namespace shutterline::client {
namespace {

Json OrNull(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

std::string HexOf(const v1::Digest& digest) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const char c : digest.sha256()) {
    const auto byte = static_cast<unsigned char>(c);
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 15];
  }
  return hex;
}

const char* WordOf(v1::FrameState state) {
  switch (state) {
    case v1::FRAME_STATE_QUEUED:
      return "queued";
    case v1::FRAME_STATE_RUNNING:
      return "running";
    case v1::FRAME_STATE_FINISHED:
      return "finished";
    default:
      return "unknown";
  }
}

Json Texts(const google::protobuf::RepeatedPtrField<std::string>& texts) {
  Json list = Json::array();
  for (const std::string& text : texts) list.push_back(text);
  return list;
}

Json QuarantinedJson(const v1::Job& job) {
  Json tiles = Json::array();
  for (const v1::QuarantinedTile& tile : job.quarantined()) {
    Json evidence = Json::array();
    for (const v1::TileTrouble& trouble : tile.evidence()) {
      evidence.push_back({{"worker_uuid", trouble.worker_uuid()},
                          {"worker_name", trouble.worker_name()},
                          {"worker_ended", trouble.worker_ended()},
                          {"reason", trouble.reason()},
                          {"signal", OrNull(trouble.signal())},
                          {"log_tail", OrNull(trouble.log_tail())},
                          {"time", OrNull(client::TimeText(trouble.time()))}});
    }
    tiles.push_back({{"frame", tile.frame()}, {"tile", tile.tile()}, {"evidence", evidence}});
  }
  return tiles;
}

}  // namespace

std::string WordOf(v1::TileOrder order) {
  switch (order) {
    case v1::TILE_ORDER_UNSPECIFIED:
    case v1::TILE_ORDER_HILBERT:
      return "hilbert";
    case v1::TILE_ORDER_CENTER:
      return "center";
    case v1::TILE_ORDER_COARSE:
      return "coarse";
    default:
      return "unknown";
  }
}

std::string TimeText(const google::protobuf::Timestamp& time) {
  if (time.seconds() == 0 && time.nanos() == 0) return "";
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromUnixSeconds(time.seconds()), absl::UTCTimeZone());
}

Json ToJson(const v1::Job& job) {
  Json json;
  json["id"] = job.id();
  json["state"] = client::WordOf(job.state());
  json["error"] = OrNull(job.error());
  json["frames_total"] = job.frames_total();
  json["frames_finished"] = job.frames_finished();
  json["tiles_total"] = job.tiles_total();
  json["tiles_done"] = job.tiles_done();
  json["workers"] = job.workers();
  json["mismatched_tiles"] = job.mismatched_tiles();
  json["priority"] = job.priority();
  json["user"] = job.user();
  json["paused"] = job.paused();
  json["after"] = Texts(job.after());
  json["waits_for"] = Texts(job.waits_for());
  json["tiles_quarantined"] = job.tiles_quarantined();
  if (job.quarantined_size() > 0) json["quarantined"] = QuarantinedJson(job);
  json["submitted"] = OrNull(TimeText(job.submitted()));
  json["ended"] = OrNull(TimeText(job.ended()));
  if (job.has_spec()) {
    const v1::JobSpec& spec = job.spec();
    json["name"] = spec.name();
    json["scene"] = spec.scene().root_name();
    json["frames"] = {
        {"first", spec.frames().first()}, {"last", spec.frames().last()}, {"step", spec.frames().step()}};
    json["width"] = spec.render().width();
    json["height"] = spec.render().height();
    json["order"] = WordOf(spec.order());
  }
  return json;
}

Json ToJson(const v1::FrameStatus& frame) {
  Json json;
  json["frame"] = frame.frame();
  json["state"] = WordOf(frame.state());
  json["tiles_total"] = frame.tiles_total();
  json["tiles_done"] = frame.tiles_done();
  json["tiles_missing"] = frame.tiles_missing();
  json["digest"] = OrNull(HexOf(frame.digest()));
  json["size_bytes"] = frame.state() == v1::FRAME_STATE_FINISHED ? Json(frame.size_bytes()) : Json(nullptr);
  return json;
}

Json ToJson(const v1::Worker& worker) {
  Json json;
  json["uuid"] = worker.uuid();
  json["name"] = worker.name();
  json["build_id"] = worker.build_id();
  json["isa"] = worker.isa();
  json["slots"] = worker.slots();
  json["draining"] = worker.draining();
  json["leased_tiles"] = worker.leased_tiles();
  json["tiles_done"] = worker.tiles_done();
  json["tile_seconds"] = worker.tile_seconds() > 0 ? Json(worker.tile_seconds()) : Json(nullptr);
  json["silent_seconds"] = worker.silent_seconds();
  return json;
}

Json ToJson(const FetchedFrame& frame) {
  Json json;
  json["frame"] = frame.frame;
  json["file"] = frame.path;
  json["preview"] = OrNull(frame.preview);
  json["size_bytes"] = frame.bytes;
  json["digest"] = frame.digest.ToHex();
  return json;
}

Json ToJson(const UploadReport& upload) {
  Json json;
  json["files"] = upload.files;
  json["bytes"] = upload.bytes;
  json["files_uploaded"] = upload.files_uploaded;
  json["bytes_uploaded"] = upload.bytes_uploaded;
  return json;
}

void Print(const Json& json, std::ostream& out, bool one_line) {
  out << json.dump(one_line ? -1 : 2, ' ', false, Json::error_handler_t::replace) << "\n" << std::flush;
}

}  // namespace shutterline::client
