#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/server_context.h>

#include <optional>

#include "proto/convert/status.h"
#include "server/api/stream_limits.h"
#include "server/control/work_pool.h"

namespace shutterline::server {

/// One call that reads something out: a message is made on the pool and written, then the next. Frees itself.
template <typename Message>
class DownloadReactor : public grpc::ServerWriteReactor<Message> {
 public:
  void OnWriteDone(bool ok) final {
    if (!ok) return Close(absl::CancelledError("the reader went away"));
    if (const std::optional<absl::Status> end = End()) return Close(*end);
    if (!pool_.Run([this] { Write(); })) Stop();
  }

  void OnDone() final { delete this; }

 protected:
  explicit DownloadReactor(WorkPool& pool) : pool_(pool) {}

  /// Last in the constructor of the class that is derived: from then on the functions below may be called.
  void Start(StreamLimits& limits) {
    if (const absl::Status taken = slot_.Take(limits.downloads); !taken.ok()) {
      Close(taken);
      return;
    }
    const bool accepted = pool_.Run([this] {
      const absl::Status status = Open();
      if (!status.ok()) return Close(status);
      Write();
    });
    if (!accepted) Stop();
  }

  /// Once, on the pool, first of all. An error ends the call.
  virtual absl::Status Open() = 0;
  /// Fills in the next message, which is empty; false: there is none, and the call ends with OK. On the pool.
  virtual absl::StatusOr<bool> Next(Message& message) = 0;
  /// After each message, not on the pool: how the call ends where that was the last.
  virtual std::optional<absl::Status> End() { return std::nullopt; }

 private:
  void Write() {
    message_.Clear();
    const absl::StatusOr<bool> more = Next(message_);
    if (!more.ok()) return Close(more.status());
    if (!*more) return Close(absl::OkStatus());
    this->StartWrite(&message_);
  }

  void Stop() { Close(absl::UnavailableError("the coordinator is stopping")); }

  void Close(const absl::Status& status) {
    slot_.Release();
    this->Finish(convert::ToGrpc(status));  // Last: OnDone may free this object at once.
  }

  WorkPool& pool_;
  StreamBudget::Slot slot_;
  Message message_;
};

}  // namespace shutterline::server
