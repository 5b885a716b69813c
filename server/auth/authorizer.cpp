#include "server/auth/authorizer.h"

#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "proto/convert/status.h"
#include "server/auth/method_table.h"

namespace shutterline::server {
namespace {

/// Of a certificate, as a URI among its alternative names: "shutterline://role/worker".
constexpr absl::string_view kRoleUri = "shutterline://role/";
constexpr size_t kMaxNameBytes = 128;

absl::string_view View(grpc::string_ref text) {
  return {text.data(), text.size()};
}

/// The roles that the caller's certificate names; gRPC has checked the certificate.
RoleSet CertificateRoles(const grpc::AuthContext& peer) {
  RoleSet roles;
  for (const grpc::string_ref& uri : peer.FindPropertyValues("peer_uri")) {
    absl::string_view name = View(uri);
    if (!absl::ConsumePrefix(&name, kRoleUri)) continue;
    if (const std::optional<Role> role = RoleOf(name)) roles.Add(*role);
  }
  return roles;
}

absl::StatusOr<Caller> CertificateCaller(const grpc::AuthContext& peer) {
  const std::vector<grpc::string_ref> names = peer.FindPropertyValues("x509_common_name");
  const std::string name = names.empty() ? "" : std::string(View(names[0]));
  if (name.empty() || name.size() > kMaxNameBytes) {
    return absl::UnauthenticatedError(absl::StrCat(
        "the caller's certificate must have a common name of at most ", kMaxNameBytes, " bytes"));
  }
  return Caller{name, CertificateRoles(peer)};
}

/// The one of gRPC's connections that has neither TLS nor a local check: a channel within this process.
bool IsInProcess(const grpc::AuthContext* peer) {
  if (peer == nullptr) return true;
  const std::vector<grpc::string_ref> types = peer->FindPropertyValues("transport_security_type");
  return types.empty() || (View(types[0]) != "ssl" && View(types[0]) != "local");
}

class AuthorizingProcessor final : public grpc::AuthMetadataProcessor {
 public:
  explicit AuthorizingProcessor(std::shared_ptr<const Authorizer> authorizer)
      : authorizer_(std::move(authorizer)) {}

  bool IsBlocking() const override { return false; }
  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* peer, OutputMetadata*,
                       OutputMetadata*) override {
    const auto path = metadata.find(":path");
    // Two headers: the caller himself does not know who he is. The refused word is none that a token could
    // be.
    std::optional<absl::string_view> authorization;
    const auto [first, last] = metadata.equal_range("authorization");
    if (first != last) authorization = std::next(first) == last ? View(first->second) : "two headers";
    const absl::Status status = authorizer_->Authorize(
        path == metadata.end() ? absl::string_view() : View(path->second), *peer, authorization);
    return convert::ToGrpc(status);
  }

 private:
  const std::shared_ptr<const Authorizer> authorizer_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<const Authorizer>> Authorizer::Make(const ListenSecurity& security) {
  std::optional<TokenTable> tokens;
  if (!security.token_file.empty()) {
    SL_ASSIGN_OR_RETURN(tokens, TokenTable::Load(security.token_file));
  }
  return std::make_shared<const Authorizer>(std::move(tokens));
}

absl::StatusOr<Caller> Authorizer::Identify(const grpc::AuthContext& peer,
                                            std::optional<absl::string_view> authorization) const {
  if (authorization) {
    // Decides alone: a caller with a wrong token is not to become somebody else by his certificate.
    absl::string_view token = *authorization;
    if (!absl::StartsWithIgnoreCase(token, "Bearer ")) {
      return absl::UnauthenticatedError("the authorization header must be 'Bearer TOKEN'");
    }
    token.remove_prefix(sizeof "Bearer " - 1);
    if (!tokens_) return absl::UnauthenticatedError("this coordinator takes no tokens");
    std::optional<Caller> caller = tokens_->Find(token);
    if (!caller) return absl::UnauthenticatedError("the token is not known here");
    return *std::move(caller);
  }
  if (!peer.FindPropertyValues("x509_pem_cert").empty()) return CertificateCaller(peer);
  return absl::UnauthenticatedError(tokens_ ? "the caller shows neither a certificate nor a token"
                                            : "the caller shows no certificate");
}

absl::Status Authorizer::Authorize(absl::string_view path, const grpc::AuthContext& peer,
                                   std::optional<absl::string_view> authorization) const {
  const MethodRule* rule = FindRule(path);
  if (rule == nullptr) {
    return absl::UnimplementedError(
        absl::StrCat(absl::CHexEscape(path.substr(0, 200)), ": there is no such method"));
  }
  if (rule->open) return absl::OkStatus();
  const absl::StatusOr<Caller> caller = Identify(peer, authorization);
  absl::Status status;
  if (!caller.ok()) {
    status = absl::UnauthenticatedError(
        absl::StrCat(path, " is for the role ", rule->roles.ToString(), ": ", caller.status().message()));
  } else if (!caller->roles.Meets(rule->roles)) {
    status = absl::PermissionDeniedError(absl::StrCat(path, " is for the role ", rule->roles.ToString(),
                                                      ": '", absl::CHexEscape(caller->name), "' has ",
                                                      caller->roles.ToString()));
  }
  if (!status.ok()) spdlog::info("call refused reason={}", LogValue(status.message()));
  return status;
}

Caller Authorizer::CallerOf(const grpc::ServerContextBase& context) const {
  const std::shared_ptr<const grpc::AuthContext> peer = context.auth_context();
  if (!IsInProcess(peer.get())) {
    std::optional<absl::string_view> authorization;
    const auto header = context.client_metadata().find("authorization");
    if (header != context.client_metadata().end()) authorization = View(header->second);
    absl::StatusOr<Caller> caller = Identify(*peer, authorization);
    return caller.ok() ? *std::move(caller) : Caller{};  // The latter by an open method.
  }
  return Caller{"", RoleSet{Role::kClient, Role::kWorker, Role::kAdmin}};
}

std::shared_ptr<grpc::AuthMetadataProcessor> Authorizer::Processor(
    std::shared_ptr<const Authorizer> authorizer) {
  return std::make_shared<AuthorizingProcessor>(std::move(authorizer));
}

}  // namespace shutterline::server
