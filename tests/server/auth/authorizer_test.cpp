#include "server/auth/authorizer.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace shutterline::server {
namespace {

using testing::HasSubstr;

/// Nobody asks for all properties.
struct NoProperties : grpc::AuthPropertyIterator {
  NoProperties() = default;
};

/// What gRPC says of a connection.
class Peer final : public grpc::AuthContext {
 public:
  explicit Peer(std::multimap<std::string, std::string> properties) : properties_(std::move(properties)) {}
  bool IsPeerAuthenticated() const override { return true; }
  std::vector<grpc::string_ref> GetPeerIdentity() const override { return {}; }
  std::string GetPeerIdentityPropertyName() const override { return ""; }
  std::vector<grpc::string_ref> FindPropertyValues(const std::string& name) const override {
    std::vector<grpc::string_ref> values;
    const auto [first, last] = properties_.equal_range(name);
    for (auto i = first; i != last; ++i) values.emplace_back(i->second);
    return values;
  }
  grpc::AuthPropertyIterator begin() const override { return NoProperties(); }
  grpc::AuthPropertyIterator end() const override { return NoProperties(); }
  void AddProperty(const std::string&, const grpc::string_ref&) override {}
  bool SetPeerIdentityPropertyName(const std::string&) override { return false; }

 private:
  const std::multimap<std::string, std::string> properties_;
};

Peer Certificate(const std::string& name, const std::vector<std::string>& uris) {
  std::multimap<std::string, std::string> properties = {
      {"transport_security_type", "ssl"}, {"x509_pem_cert", "pem"}, {"x509_common_name", name}};
  for (const std::string& uri : uris) properties.emplace("peer_uri", uri);
  return Peer(properties);
}

const Peer kNobody(std::multimap<std::string, std::string>{{"transport_security_type", "ssl"}});
constexpr char kSubmit[] = "/shutterline.v1.Jobs/Submit";
constexpr char kSession[] = "/shutterline.v1.Workers/Session";
constexpr char kHealth[] = "/grpc.health.v1.Health/Check";

class AuthorizerTest : public testing::Test {
 protected:
  AuthorizerTest()
      : with_tokens_(*TokenTable::Parse(absl::StrCat("client alice ", Sha256("alices-token").ToHex(), "\n",
                                                     "worker node1 ", Sha256("nodes-token").ToHex()))) {}
  Authorizer with_tokens_;
  Authorizer without_tokens_{std::nullopt};
};

TEST_F(AuthorizerTest, ACertificatesRoleDecides) {
  const Peer client = Certificate("alice", {"shutterline://role/client"});
  const Peer worker = Certificate("node1", {"spiffe://x", "shutterline://role/worker"});
  EXPECT_TRUE(without_tokens_.Authorize(kSubmit, client, {}).ok());
  EXPECT_TRUE(without_tokens_.Authorize(kSession, worker, {}).ok());
  const absl::Status denied = without_tokens_.Authorize(kSession, client, {});
  EXPECT_TRUE(absl::IsPermissionDenied(denied));
  EXPECT_EQ(denied.message(), "/shutterline.v1.Workers/Session is for the role worker: 'alice' has client");
  EXPECT_EQ(without_tokens_.Authorize(kSubmit, worker, {}).message(),
            "/shutterline.v1.Jobs/Submit is for the role client or admin: 'node1' has worker");
  const Peer both = Certificate("b", {"shutterline://role/worker", "shutterline://role/client"});
  EXPECT_TRUE(without_tokens_.Authorize(kSubmit, both, {}).ok());
  EXPECT_TRUE(without_tokens_.Authorize(kSession, both, {}).ok());
}

TEST_F(AuthorizerTest, ACertificateWithoutARoleMayNothing) {
  for (const char* uri : {"shutterline://role/", "shutterline://role/Client", "shutterline://role/client/x",
                          "http://role/client", "shutterline://role/root"}) {
    EXPECT_TRUE(absl::IsPermissionDenied(without_tokens_.Authorize(kSubmit, Certificate("a", {uri}), {})))
        << uri;
  }
  EXPECT_TRUE(absl::IsUnauthenticated(
      without_tokens_.Authorize(kSubmit, Certificate("", {"shutterline://role/client"}), {})));
}

TEST_F(AuthorizerTest, HealthIsForAllAndAllElseForThoseWhoSayWhoTheyAre) {
  EXPECT_TRUE(with_tokens_.Authorize(kHealth, kNobody, {}).ok());
  const absl::Status status = with_tokens_.Authorize(kSubmit, kNobody, {});
  EXPECT_TRUE(absl::IsUnauthenticated(status));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("/shutterline.v1.Jobs/Submit is for the role client or admin"));
  EXPECT_THAT(std::string(without_tokens_.Authorize(kSubmit, kNobody, {}).message()),
              HasSubstr("no certificate"));
  EXPECT_EQ(with_tokens_.Authorize("/shutterline.v1.Jobs/Nuke", kNobody, {}).code(),
            absl::StatusCode::kUnimplemented);
}

TEST_F(AuthorizerTest, ATokenDecidesWhereOneComes) {
  EXPECT_TRUE(with_tokens_.Authorize(kSubmit, kNobody, "Bearer alices-token").ok());
  EXPECT_TRUE(with_tokens_.Authorize(kSubmit, kNobody, "bearer alices-token").ok());
  EXPECT_TRUE(absl::IsPermissionDenied(with_tokens_.Authorize(kSubmit, kNobody, "Bearer nodes-token")));
  const Peer client = Certificate("alice", {"shutterline://role/client"});
  for (const char* header : {"Bearer wrong", "Bearer ", "alices-token", "Basic alices-token", ""}) {
    // Also beside a certificate that would do.
    const absl::Status status = with_tokens_.Authorize(kSubmit, client, header);
    EXPECT_TRUE(absl::IsUnauthenticated(status)) << header;
    EXPECT_THAT(std::string(status.message()), testing::Not(HasSubstr("wrong"))) << "echoes the token";
  }
  EXPECT_TRUE(absl::IsUnauthenticated(without_tokens_.Authorize(kSubmit, client, "Bearer alices-token")));
}

}  // namespace
}  // namespace shutterline::server
