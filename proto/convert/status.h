#pragma once

#include <absl/status/status.h>
#include <absl/time/time.h>

namespace grpc {
class Status;
}
namespace google::protobuf {
class Duration;
class Timestamp;
}  // namespace google::protobuf

namespace shutterline::convert {

/// The codes are the same numbers. A message beyond 4 KiB, which would not fit into HTTP/2 trailers, is cut
/// and says so at its end. A retry hint travels as google.rpc.RetryInfo in the status's details.
grpc::Status ToGrpc(const absl::Status& status);
absl::Status FromGrpc(const grpc::Status& status);

google::protobuf::Duration ToProto(absl::Duration duration);
google::protobuf::Timestamp ToProto(absl::Time time);
/// What a peer sent, if it is a duration: within ±10,000 years and of a valid form; otherwise zero.
absl::Duration FromProto(const google::protobuf::Duration& message);

}  // namespace shutterline::convert
