#include "tests/server/crash_workload.h"

#include <absl/strings/str_cat.h>
#include <absl/synchronization/notification.h>

#include <cstring>
#include <set>

#include "common/base/status_macros.h"
#include "common/image/exr.h"
#include "tests/server/fake_worker.h"

namespace shutterline::test {
namespace {

using server::Farm;
using server::JobState;

constexpr int kSide = 64;
constexpr int kFirstFrame = 7;
constexpr char kBlob[] = "the bytes of a scene";
/// A few tiles a segment, so that segments are begun and removed.
constexpr uint64_t kSegmentBytes = 50'000;

}  // namespace

CrashWorkload::CrashWorkload(std::string folder, server::Durability durability)
    : folder_(std::move(folder)), durability_(durability) {}

CrashWorkload::~CrashWorkload() {
  if (frames_pool_ != nullptr) frames_pool_->Stop();
}

JobSpec CrashWorkload::Spec() {
  JobSpec spec;
  spec.scene.root_name = "scene.glb";
  spec.scene.files = {{"scene.glb", Sha256(kBlob), std::strlen(kBlob)}};
  spec.frames = {kFirstFrame, kFirstFrame + 1, 1};
  spec.render.width = spec.render.height = kSide;
  spec.output.pixel_type = PixelType::kFloat;
  return spec;
}

absl::Status CrashWorkload::Open() {
  // What was open is closed first: one coordinator a folder.
  if (frames_pool_ != nullptr) frames_pool_->Stop();
  farm_.reset();
  frames_pool_.reset();
  blocks_.reset();
  journal_.reset();
  assets_.reset();
  store_.reset();
  SL_RETURN_IF_ERROR(server::MakeFolders(folder_, durability_));
  SL_ASSIGN_OR_RETURN(store_, server::SqliteJobStore::Open(folder_ + "/jobs.sqlite", durability_));
  SL_RETURN_IF_ERROR(server::SyncFolder(folder_, durability_));
  SL_ASSIGN_OR_RETURN(assets_,
                      server::DiskAssetStore::Open(folder_ + "/assets", {.durability = durability_}, clock_));
  SL_ASSIGN_OR_RETURN(journal_,
                      server::TileJournal::Open(folder_ + "/journal", {kSegmentBytes, durability_}));
  SL_RETURN_IF_ERROR(server::MakeFolders(folder_ + "/frames", durability_));
  blocks_ = std::make_unique<server::FrameBlocks>(server::FrameBlocks::Options());
  frames_pool_ = std::make_unique<server::WorkPool>(1);
  Farm::Parts parts;
  parts.config = config_;
  parts.config.data_dir = folder_;
  parts.config.durability = durability_;
  parts.clock = &clock_;
  parts.store = store_.get();
  parts.assets = assets_.get();
  parts.journal = journal_.get();
  parts.blocks = blocks_.get();
  parts.frames_pool = frames_pool_.get();
  parts.frames_folder = folder_ + "/frames";
  parts.identity = {"build", 1, 1};
  SL_ASSIGN_OR_RETURN(parts.epoch, store_->NextEpoch());
  parts.check_scene = [](const JobSpec&, server::AssetStore&) { return absl::OkStatus(); };
  parts.camera = [](const JobSpec&, server::AssetStore&, int) { return CameraMatrices(); };
  farm_ = std::make_unique<Farm>(std::move(parts));
  return farm_->Resume();
}

absl::Status CrashWorkload::UploadBlob() {
  const Digest digest = Sha256(kBlob);
  SL_ASSIGN_OR_RETURN(const server::CommittedBlob before, assets_->Query(digest));
  if (before.complete) return absl::OkStatus();
  SL_ASSIGN_OR_RETURN(const auto writer, assets_->Write(digest, std::strlen(kBlob), before.size));
  const absl::string_view rest = absl::string_view(kBlob).substr(before.size);
  SL_RETURN_IF_ERROR(writer->Append(rest.substr(0, rest.size() / 2)));
  SL_RETURN_IF_ERROR(writer->Append(rest.substr(rest.size() / 2)));
  return writer->Finish().status();
}

absl::Status CrashWorkload::PushTiles(int frame, uint32_t first, uint32_t count, Acknowledged& acknowledged) {
  SL_ASSIGN_OR_RETURN(const server::JobSnapshot job, FindJob());
  std::vector<server::TileReport> reports(count);
  std::vector<const server::TileReport*> pointers;
  for (uint32_t i = 0; i < count; ++i) {
    reports[i].job_id = job.id;
    reports[i].frame = kFirstFrame + frame;
    reports[i].tile = first + i;
    reports[i].pixels = SyntheticTile(kSide, kSide, kFirstFrame + frame, first + i);
    pointers.push_back(&reports[i]);
  }
  // As ResultCommitter does.
  const std::vector<Farm::Destination> destinations = farm_->Locate(pointers);
  std::vector<Farm::Result> results;
  for (uint32_t i = 0; i < count; ++i) {
    const Digest digest = Sha256(reports[i].pixels);
    Farm::Result result{&reports[i], destinations[i], 0, server::TileJournal::Outcome::kStaged, digest};
    if (result.destination.refusal == server::ReportOutcome::kStored) {
      result.stored = journal_->Stage(result.destination.address, digest, reports[i].pixels);
    }
    results.push_back(result);
  }
  SL_RETURN_IF_ERROR(journal_->Commit());
  farm_->Apply(results);
  for (uint32_t i = 0; i < count; ++i) acknowledged.tile[frame][first + i] = true;
  return absl::OkStatus();
}

void CrashWorkload::WaitForFrames() {
  for (int tries = 0; tries < 3; ++tries) {
    absl::Notification done;
    frames_pool_->Run([&] { done.Notify(); });
    done.WaitForNotification();
    // What the disk refused is tried again when its time has come.
    clock_.Advance(absl::Seconds(10));
    farm_->Tick();
  }
}

absl::StatusOr<server::JobSnapshot> CrashWorkload::FindJob() {
  SL_ASSIGN_OR_RETURN(const auto jobs, farm_->List(UINT64_MAX, 2));
  if (jobs.size() == 1) return jobs[0];
  return absl::NotFoundError(absl::StrCat("there are ", jobs.size(), " jobs"));
}

absl::Status CrashWorkload::Submit(Acknowledged& acknowledged) {
  SL_RETURN_IF_ERROR(UploadBlob());
  acknowledged.blob = true;
  SL_RETURN_IF_ERROR(farm_->Submit("request", Spec(), {}).status());
  acknowledged.job = true;
  return absl::OkStatus();
}

absl::Status CrashWorkload::Run(Acknowledged& acknowledged) {
  SL_RETURN_IF_ERROR(Submit(acknowledged));
  for (int frame = 0; frame < 2; ++frame) {
    SL_RETURN_IF_ERROR(PushTiles(frame, 0, 1, acknowledged));
    SL_RETURN_IF_ERROR(PushTiles(frame, 1, 3, acknowledged));
    WaitForFrames();
    SL_ASSIGN_OR_RETURN(const server::JobSnapshot job, FindJob());
    SL_RETURN_IF_ERROR(farm_->FindFrame(job.id, kFirstFrame + frame).status());
    acknowledged.frame_finished[frame] = true;
  }
  WaitForFrames();
  SL_ASSIGN_OR_RETURN(const server::JobSnapshot job, FindJob());
  if (!server::HasEnded(job.state)) return absl::UnavailableError("the job has not ended");
  if (job.state != JobState::kSucceeded) return absl::InternalError(job.error);
  acknowledged.ended = true;
  return absl::OkStatus();
}

absl::Status CrashWorkload::Remove(Acknowledged& acknowledged) {
  const absl::StatusOr<server::JobSnapshot> job = FindJob();
  if (job.ok()) {
    SL_RETURN_IF_ERROR(farm_->Remove(job->id).status());
  } else if (!absl::IsNotFound(job.status())) {
    return job.status();
  }
  acknowledged.removed = true;
  WaitForFrames();
  return absl::OkStatus();
}

std::string CrashWorkload::LeftOver() {
  std::set<std::string> ids;
  std::set<uint64_t> keys;
  const auto jobs = farm_->List(UINT64_MAX, 100);
  if (!jobs.ok()) return jobs.status().ToString();
  for (const server::JobSnapshot& job : *jobs) {
    ids.insert(job.id);
    keys.insert(job.key);
  }
  const auto frames = server::ListFolder(folder_ + "/frames");
  if (!frames.ok()) return frames.status().ToString();
  for (const std::string& name : *frames) {
    if (!ids.contains(name)) return absl::StrCat("frames of ", name);
  }
  for (const server::TileJournal::FrameKey& frame : journal_->Frames()) {
    if (!keys.contains(frame.first)) return absl::StrCat("tiles of job ", frame.first);
  }
  const auto half = store_->HalfRemoved();
  if (!half.ok()) return half.status().ToString();
  return half->empty() ? "" : absl::StrCat("a note of the files of job ", half->front().id);
}

std::string CrashWorkload::MissingFrame(const std::string& job_id, int frame) {
  const auto found = farm_->FindFrame(job_id, kFirstFrame + frame);
  if (!found.ok()) return absl::StrCat("frame: ", found.status().ToString());
  const absl::StatusOr<server::File> file = server::File::OpenToRead(found->second);
  if (!file.ok()) return absl::StrCat("frame's file: ", file.status().ToString());
  const std::string bytes = file->ReadAt(0, size_t(found->first.size) + 1).value();
  if (Sha256(bytes) != found->first.digest) return "frame's file has other bytes";
  const absl::StatusOr<Image> image = DecodeExr(bytes, "frame");
  if (!image.ok()) return image.status().ToString();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      float expected[4];
      SyntheticPixel(kFirstFrame + frame, x, y, expected);
      if (std::memcmp(image->At(x, y), expected, sizeof expected) != 0) return "frame has other pixels";
    }
  }
  return "";
}

std::string CrashWorkload::Missing(const Acknowledged& acknowledged) {
  if (acknowledged.blob && assets_->ReadVerified(Sha256(kBlob), 1000).value_or("") != kBlob) return "blob";
  if (!acknowledged.job) return "";
  const absl::StatusOr<server::JobSnapshot> job = FindJob();
  if (!job.ok()) return absl::StrCat("job: ", job.status().ToString());
  if (*job->spec != Spec()) return "job has another specification";
  WaitForFrames();
  if (acknowledged.ended && !server::HasEnded(FindJob()->state)) return "job's end";
  for (int frame = 0; frame < 2; ++frame) {
    const auto found = farm_->FindFrame(job->id, kFirstFrame + frame);
    if (found.ok() || acknowledged.frame_finished[frame]) {
      const std::string missing = MissingFrame(job->id, frame);
      if (!missing.empty()) return missing;
      continue;
    }
    for (uint32_t tile = 0; tile < 4; ++tile) {
      if (!acknowledged.tile[frame][tile]) continue;
      const auto pixels = journal_->Read({job->key, frame, tile});
      if (!pixels.ok()) return absl::StrCat("tile: ", pixels.status().ToString());
      if (*pixels != SyntheticTile(kSide, kSide, kFirstFrame + frame, tile)) return "tile has other pixels";
    }
  }
  return "";
}

}  // namespace shutterline::test
