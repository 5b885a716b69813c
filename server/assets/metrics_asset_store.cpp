#include "server/assets/metrics_asset_store.h"

#include "common/base/status_macros.h"

namespace shutterline::server {
namespace {

class CountingWriter final : public BlobWriter {
 public:
  CountingWriter(std::unique_ptr<BlobWriter> writer, const MetricsAssetStore::Count& count)
      : writer_(std::move(writer)), count_(count) {}

  absl::Status Append(absl::string_view data) override {
    SL_RETURN_IF_ERROR(writer_->Append(data));
    count_(data.size(), 0);
    return absl::OkStatus();
  }
  absl::StatusOr<CommittedBlob> Finish() override { return writer_->Finish(); }

 private:
  const std::unique_ptr<BlobWriter> writer_;
  const MetricsAssetStore::Count& count_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<BlobWriter>> MetricsAssetStore::Write(const Digest& digest, uint64_t size,
                                                                     uint64_t offset) {
  SL_ASSIGN_OR_RETURN(std::unique_ptr<BlobWriter> writer, store_.Write(digest, size, offset));
  return std::make_unique<CountingWriter>(std::move(writer), count_);
}

absl::StatusOr<std::string> MetricsAssetStore::Read(const Digest& digest, uint64_t offset, size_t count) {
  SL_ASSIGN_OR_RETURN(std::string data, store_.Read(digest, offset, count));
  count_(0, data.size());
  return data;
}

}  // namespace shutterline::server
