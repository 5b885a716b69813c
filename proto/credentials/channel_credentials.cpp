#include "proto/credentials/channel_credentials.h"

#include <absl/strings/str_cat.h>
#include <grpc/grpc_security_constants.h>

#include <map>
#include <utility>

#include "common/base/host_port.h"
#include "common/base/status_macros.h"
#include "proto/credentials/key_pair.h"
#include "proto/credentials/token.h"

namespace shutterline::credentials {
namespace {

/// Adds the token to every call. gRPC's own credentials of this kind insist on encryption, also on loopback.
class TokenPlugin final : public grpc::MetadataCredentialsPlugin {
 public:
  explicit TokenPlugin(const std::string& token) : header_(absl::StrCat("Bearer ", token)) {}
  bool IsBlocking() const override { return false; }
  const char* GetType() const override { return "shutterline-token"; }
  grpc::Status GetMetadata(grpc::string_ref, grpc::string_ref, const grpc::AuthContext&,
                           std::multimap<grpc::string, grpc::string>* metadata) override {
    metadata->emplace("authorization", header_);
    return grpc::Status::OK;
  }
  std::string DebugString() override { return "a token"; }

 private:
  const std::string header_;
};

absl::Status Check(const DialSecurity& security, const std::string& host_port) {
  if (security.tls_cert.empty() != security.tls_key.empty()) {
    return absl::InvalidArgumentError("--tls-cert and --tls-key go together");
  }
  if (!security.tls_cert.empty() && security.tls_ca.empty()) {
    return absl::InvalidArgumentError(
        "--tls-cert needs --tls-ca: the authority that the coordinator is checked by");
  }
  if (!security.token_file.empty() && security.tls_ca.empty() && !IsLoopback(HostOf(host_port))) {
    return absl::FailedPreconditionError(
        absl::StrCat("--token-file needs --tls-ca: the token would travel unencrypted to ", host_port));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const DialSecurity& security, const std::string& host_port) {
  SL_RETURN_IF_ERROR(Check(security, host_port));
  std::shared_ptr<grpc::ChannelCredentials> channel;
  if (!security.tls_ca.empty()) {
    grpc::SslCredentialsOptions options;
    SL_ASSIGN_OR_RETURN(options.pem_root_certs, LoadAuthorities(security.tls_ca));
    if (!security.tls_cert.empty()) {
      SL_ASSIGN_OR_RETURN(KeyPair pair, LoadKeyPair(security.tls_cert, security.tls_key));
      options.pem_cert_chain = std::move(pair.certificate);
      options.pem_private_key = std::move(pair.key);
    }
    channel = grpc::SslCredentials(options);
  }
  if (security.token_file.empty()) return channel != nullptr ? channel : grpc::InsecureChannelCredentials();

  SL_ASSIGN_OR_RETURN(const std::string token, LoadToken(security.token_file));
  // Of loopback TCP alone: a connection that turns out to leave the machine is refused.
  if (channel == nullptr) channel = grpc::experimental::LocalCredentials(LOCAL_TCP);
  // The level is the least that gRPC demands of the connection; that it is encrypted or local is seen to
  // above.
  return grpc::CompositeChannelCredentials(
      channel, grpc::experimental::MetadataCredentialsFromPlugin(std::make_unique<TokenPlugin>(token),
                                                                 GRPC_SECURITY_NONE));
}

}  // namespace shutterline::credentials
