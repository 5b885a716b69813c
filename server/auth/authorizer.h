#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/server_context.h>

#include <memory>
#include <optional>

#include "server/auth/caller.h"
#include "server/auth/token_table.h"
#include "server/config/listen_security.h"

namespace shutterline::server {

/// Decides for every call of the network whether its caller may make it. gRPC asks `Processor` before a call
/// reaches its service, be it ours, health or reflection, and refuses the call with what that says:
/// UNAUTHENTICATED where the caller does not prove who he is, PERMISSION_DENIED where he is somebody else
/// than the method's rule wants (server/auth/method_table.h). Thread-safe.
class Authorizer {
 public:
  /// Reads the token table, if there is one.
  static absl::StatusOr<std::shared_ptr<const Authorizer>> Make(const ListenSecurity& security);
  explicit Authorizer(std::optional<TokenTable> tokens) : tokens_(std::move(tokens)) {}

  /// Who makes the call that `context` belongs to; for handlers, whose calls have been let in before. Calls
  /// over channels within the process, and of a coordinator that asks nobody who he is, have no name.
  Caller CallerOf(const grpc::ServerContextBase& context) const;

  /// Whether a call with these properties may be made. `authorization`: the header, if there is one. OK, or
  /// the status that the call ends with.
  absl::Status Authorize(absl::string_view path, const grpc::AuthContext& peer,
                         std::optional<absl::string_view> authorization) const;

  /// What is to be given to server credentials. Keeps the authorizer alive.
  static std::shared_ptr<grpc::AuthMetadataProcessor> Processor(std::shared_ptr<const Authorizer> authorizer);

 private:
  /// The caller, by token or by certificate; UNAUTHENTICATED saying what is missing or wrong.
  absl::StatusOr<Caller> Identify(const grpc::AuthContext& peer,
                                  std::optional<absl::string_view> authorization) const;

  const std::optional<TokenTable> tokens_;
};

}  // namespace shutterline::server
