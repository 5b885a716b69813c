#include "proto/convert/status.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/any.pb.h>
#include <google/protobuf/duration.pb.h>
#include <google/protobuf/timestamp.pb.h>
#include <grpcpp/support/status.h>

#include <optional>
#include <string>
#include <utility>

#include "common/base/retry_hint.h"
#include "shutterline/v1/status_details.pb.h"

namespace shutterline::convert {
namespace {

constexpr size_t kMaxMessageBytes = 4096;
constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";

/// The trailer's bytes, where there is more to tell than code and message.
std::string Details(const absl::Status& status, const std::string& message) {
  const std::optional<absl::Duration> hint = RetryHint(status);
  if (!hint) return "";
  v1::RetryInfo info;
  *info.mutable_retry_delay() = convert::ToProto(*hint);
  v1::StatusDetails details;
  details.set_code(int(status.code()));
  details.set_message(message);
  google::protobuf::Any& any = *details.add_details();
  any.set_type_url(kRetryInfoUrl);
  any.set_value(info.SerializeAsString());
  return details.SerializeAsString();
}

}  // namespace

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  std::string message(status.message());
  if (message.size() > kMaxMessageBytes) {
    size_t cut = kMaxMessageBytes;
    while (cut > 0 && (static_cast<unsigned char>(message[cut]) & 0xc0) == 0x80)
      --cut;  // A whole UTF-8 character.
    message = absl::StrCat(message.substr(0, cut), " … (", message.size() - cut, " more bytes)");
  }
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), message, Details(status, message));
}

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  absl::Status result(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
  v1::StatusDetails details;
  // A peer's details may be anything; what cannot be read says nothing.
  if (status.error_details().empty() || !details.ParseFromString(status.error_details())) return result;
  for (const google::protobuf::Any& any : details.details()) {
    v1::RetryInfo info;
    if (any.type_url() != kRetryInfoUrl || !info.ParseFromString(any.value())) continue;
    result = WithRetryHint(std::move(result), FromProto(info.retry_delay()));
  }
  return result;
}

google::protobuf::Duration ToProto(absl::Duration duration) {
  google::protobuf::Duration message;
  message.set_seconds(absl::IDivDuration(duration, absl::Seconds(1), &duration));
  message.set_nanos(int32_t(absl::IDivDuration(duration, absl::Nanoseconds(1), &duration)));
  return message;
}

google::protobuf::Timestamp ToProto(absl::Time time) {
  const google::protobuf::Duration since_epoch = ToProto(time - absl::UnixEpoch());
  google::protobuf::Timestamp message;
  message.set_seconds(since_epoch.seconds());
  message.set_nanos(since_epoch.nanos());
  if (message.nanos() < 0) {  // A timestamp's nanoseconds count forward, also before 1970.
    message.set_seconds(message.seconds() - 1);
    message.set_nanos(message.nanos() + 1'000'000'000);
  }
  return message;
}

absl::Duration FromProto(const google::protobuf::Duration& m) {
  constexpr int64_t kMaxSeconds = 315'576'000'000;
  const bool valid = m.seconds() >= -kMaxSeconds && m.seconds() <= kMaxSeconds &&
                     m.nanos() > -1'000'000'000 && m.nanos() < 1'000'000'000 &&
                     (m.seconds() == 0 || m.nanos() == 0 || (m.seconds() < 0) == (m.nanos() < 0));
  return valid ? absl::Seconds(m.seconds()) + absl::Nanoseconds(m.nanos()) : absl::ZeroDuration();
}

}  // namespace shutterline::convert
