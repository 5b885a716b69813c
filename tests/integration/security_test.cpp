// A farm over TLS: with certificates of deploy/certs, and with tokens. Real processes, real files.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "proto/credentials/channel_credentials.h"
#include "tests/integration/certificates.h"
#include "tests/integration/farm.h"
#include "tests/integration/raw_call.h"

namespace shutterline {
namespace {

using testing::HasSubstr;

/// Small: 4 × 3 tiles.
const std::vector<std::string> kPicture = {"--size", "100x80", "--float", "--frame", "3"};

std::vector<std::string> With(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class SecurityTest : public testing::Test {
 protected:
  SecurityTest() : certs_(farm_.folder() / "certs-of-farm"), other_(farm_.folder() / "certs-of-others") {
    MakeCertificates(certs_, {"ca"});
    MakeCertificates(certs_, {"server", "localhost", "127.0.0.1"});
    MakeCertificates(certs_, {"client", "alice"});
    MakeCertificates(certs_, {"worker", "node1"});
  }

  void StartTls() {
    farm_.server_flags = {"--tls-cert",          certs_ / "server.pem", "--tls-key",
                          certs_ / "server.key", "--tls-client-ca",     certs_ / "ca.pem"};
    farm_.StartServer();
  }
  void StartTlsWithTokens() {
    MakeCertificates(certs_, {"token", "client", "bob"});
    MakeCertificates(certs_, {"token", "worker", "node2"});
    farm_.server_flags = {"--tls-cert",          certs_ / "server.pem", "--tls-key",
                          certs_ / "server.key", "--token-file",        certs_ / "tokens"};
    farm_.StartServer();
  }

  grpc::Status Call(const std::shared_ptr<grpc::ChannelCredentials>& credentials, const std::string& path,
                    const std::string& message = "") {
    return RawCall(OwnChannel(farm_.Address(), credentials), path, message);
  }
  std::shared_ptr<grpc::ChannelCredentials> As(const std::string& stem) {
    const auto made =
        credentials::MakeChannelCredentials({certs_ / "ca.pem", stem.empty() ? "" : certs_ / (stem + ".pem"),
                                             stem.empty() ? "" : certs_ / (stem + ".key"), ""},
                                            farm_.Address());
    EXPECT_TRUE(made.ok()) << made.status();
    return *made;
  }

  /// The job runs on this user's account.
  void ExpectUser(const std::string& job, const std::string& user) {
    const Farm::Ended status = farm_.Client({"status", job, "--json", "--server", farm_.Address()});
    EXPECT_THAT(status.output, HasSubstr("\"" + user + "\"")) << status.errors;
    EXPECT_THAT(status.output, testing::Not(HasSubstr("mallory")));
  }

  Farm farm_;
  const std::filesystem::path certs_, other_;
};

TEST_F(SecurityTest, AFarmWithCertificatesRendersTheSamePicture) {
  const std::string scene = farm_.Scene("fan");
  const std::string alone = farm_.folder() / "alone.exr";
  ASSERT_EQ(farm_.Client(With({"render", scene, "-o", alone}, kPicture)).status, 0);
  StartTls();
  farm_.worker_flags = CertificateFlags(certs_, "worker-node1");
  farm_.client_flags = CertificateFlags(certs_, "client-alice");
  farm_.StartWorker("w", 2);
  const std::string file = farm_.folder() / "farm.exr";
  // Whatever a caller says of himself: it is his certificate or token that counts.
  const std::string job = farm_.Submit(With({scene, "--user", "mallory"}, kPicture));
  farm_.Fetch(job, file);
  const std::vector<uint32_t> truth = PixelBits(alone);
  ASSERT_EQ(truth.size(), 100u * 80u * 4u);
  EXPECT_EQ(PixelBits(file), truth);
  ExpectUser(job, "alice");
}

TEST_F(SecurityTest, AFarmWithTokensRendersTheSamePicture) {
  const std::string scene = farm_.Scene("fan");
  const std::string alone = farm_.folder() / "alone.exr";
  ASSERT_EQ(farm_.Client(With({"render", scene, "-o", alone}, kPicture)).status, 0);
  StartTlsWithTokens();
  farm_.worker_flags = TokenFlags(certs_, "worker-node2");
  farm_.client_flags = TokenFlags(certs_, "client-bob");
  farm_.StartWorker("w", 2);
  const std::string file = farm_.folder() / "farm.exr";
  // Whatever a caller says of himself: it is his certificate or token that counts.
  const std::string job = farm_.Submit(With({scene, "--user", "mallory"}, kPicture));
  farm_.Fetch(job, file);
  EXPECT_EQ(PixelBits(file), PixelBits(alone));
  ExpectUser(job, "bob");
}

TEST_F(SecurityTest, RolesAreKeptApartForEveryServiceOfThePort) {
  StartTls();
  MakeCertificates(certs_, {"admin", "carol"});
  const std::string list("\x3a\x00", 2);  // ServerReflectionRequest: list_services.
  const std::string reflection = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";
  const struct {
    const char* who;
    std::string path, message;
    grpc::StatusCode code;
  } cases[] = {
      {"", "/grpc.health.v1.Health/Check", "", grpc::StatusCode::OK},
      {"worker-node1", "/grpc.health.v1.Health/Check", "", grpc::StatusCode::OK},
      {"", "/shutterline.v1.Jobs/List", "", grpc::StatusCode::UNAUTHENTICATED},
      {"", reflection, list, grpc::StatusCode::UNAUTHENTICATED},
      {"client-alice", "/shutterline.v1.Jobs/List", "", grpc::StatusCode::OK},
      {"admin-carol", "/shutterline.v1.Jobs/List", "", grpc::StatusCode::OK},
      {"worker-node1", "/shutterline.v1.Jobs/List", "", grpc::StatusCode::PERMISSION_DENIED},
      {"worker-node1", "/shutterline.v1.Jobs/GetCapabilities", "", grpc::StatusCode::OK},
      {"client-alice", reflection, list, grpc::StatusCode::OK},
      {"worker-node1", reflection, list, grpc::StatusCode::PERMISSION_DENIED},
      {"client-alice", "/shutterline.v1.Workers/Register", "", grpc::StatusCode::PERMISSION_DENIED},
      {"client-alice", "/shutterline.v1.Workers/Session", "", grpc::StatusCode::PERMISSION_DENIED},
      {"admin-carol", "/shutterline.v1.Workers/PushResults", "", grpc::StatusCode::PERMISSION_DENIED},
      {"worker-node1", "/shutterline.v1.Blobs/Write", "", grpc::StatusCode::PERMISSION_DENIED},
      {"client-alice", "/shutterline.v1.Blobs/Read", "", grpc::StatusCode::PERMISSION_DENIED},
      {"client-alice", "/shutterline.v1.Jobs/NoSuch", "", grpc::StatusCode::UNIMPLEMENTED},
  };
  for (const auto& c : cases) {
    const grpc::Status status = Call(As(c.who), c.path, c.message);
    EXPECT_EQ(status.error_code(), c.code) << c.who << " " << c.path << ": " << status.error_message();
    if (status.ok() || c.code == grpc::StatusCode::UNIMPLEMENTED) continue;
    EXPECT_THAT(status.error_message(), HasSubstr(c.path));
    EXPECT_THAT(status.error_message(), HasSubstr("for the role"));
  }
}

TEST_F(SecurityTest, AnotherAuthoritysCertificatesOpenNothing) {
  StartTls();
  MakeCertificates(other_, {"ca"});
  MakeCertificates(other_, {"client", "mallory"});
  // Theirs for us, ours for them.
  std::vector<std::string> flags = CertificateFlags(other_, "client-mallory");
  flags[1] = certs_ / "ca.pem";
  const auto theirs =
      credentials::MakeChannelCredentials({flags[1], flags[3], flags[5], ""}, farm_.Address());
  ASSERT_TRUE(theirs.ok());
  EXPECT_EQ(Call(*theirs, "/shutterline.v1.Jobs/List").error_code(), grpc::StatusCode::UNAVAILABLE);
  const auto suspicious =
      credentials::MakeChannelCredentials({other_ / "ca.pem", "", "", ""}, farm_.Address());
  EXPECT_EQ(Call(*suspicious, "/grpc.health.v1.Health/Check").error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(Call(grpc::InsecureChannelCredentials(), "/grpc.health.v1.Health/Check").error_code(),
            grpc::StatusCode::UNAVAILABLE);
  // A worker's certificate does not make a coordinator: it may not be shown by one who is dialled.
  EXPECT_EQ(Call(As("client-alice"), "/shutterline.v1.Jobs/List").error_code(), grpc::StatusCode::OK);
}

TEST_F(SecurityTest, ProgramsSayWhatIsWrong) {
  StartTls();
  const std::string list = "list";
  // A worker that may not work leaves, instead of asking for ever.
  farm_.worker_flags = CertificateFlags(certs_, "client-alice");
  farm_.StartWorker("wrong-role", 1);
  EXPECT_EQ(farm_.worker("wrong-role").Wait(), 1);
  EXPECT_THAT(farm_.worker("wrong-role").Errors(), HasSubstr("'alice' has client"));
  farm_.client_flags = CertificateFlags(certs_, "worker-node1");
  Farm::Ended ended = farm_.Client({list, "--server", farm_.Address()});
  EXPECT_EQ(ended.status, 1);
  EXPECT_THAT(ended.errors, HasSubstr("/shutterline.v1.Jobs/List is for the role client or admin"));
  farm_.client_flags = {"--tls-ca", certs_ / "ca.pem"};
  ended = farm_.Client({list, "--server", farm_.Address()});
  EXPECT_EQ(ended.status, 1);
  EXPECT_THAT(ended.errors, HasSubstr("no certificate"));
  farm_.client_flags = {"--tls-ca",  certs_ / "ca.pem",          "--tls-cert", certs_ / "client-alice.pem",
                        "--tls-key", certs_ / "worker-node1.key"};
  ended = farm_.Client({list, "--server", farm_.Address()});
  EXPECT_NE(ended.status, 0);
  EXPECT_THAT(ended.errors, HasSubstr("is not the key of the certificate"));
}

TEST_F(SecurityTest, TokensOverLoopbackNeedNoTls) {
  MakeCertificates(certs_, {"token", "client", "bob"});
  farm_.server_flags = {"--token-file", certs_ / "tokens"};
  farm_.StartServer();
  Farm::Ended ended = farm_.Client({"list", "--server", farm_.Address()});
  EXPECT_EQ(ended.status, 1);
  EXPECT_THAT(ended.errors, HasSubstr("neither a certificate nor a token"));
  farm_.client_flags = {"--token-file", certs_ / "client-bob.token"};
  ended = farm_.Client({"list", "--server", farm_.Address()});
  EXPECT_EQ(ended.status, 0) << ended.errors;
  EXPECT_EQ(farm_.Client({"workers", "--server", "farm.example.org:7400"}).status, 1);
}

TEST_F(SecurityTest, TheScriptMakesKeysForTheirOwnerAloneAndOverwritesNothing) {
  using std::filesystem::perms;
  for (const char* name : {"ca.key", "server.key", "client-alice.key", "worker-node1.key"}) {
    const perms mode = std::filesystem::status(certs_ / name).permissions();
    EXPECT_EQ(mode & (perms::group_all | perms::others_all), perms::none) << name;
  }
  const std::string before = ReadWholeFile(certs_ / "client-alice.key");
  const auto again = Process::Start({SHUTTERLINE_SOURCE_DIR "/deploy/certs", certs_, "client", "alice"},
                                    farm_.folder() / "again");
  EXPECT_EQ(again->Wait(), 1);
  EXPECT_EQ(ReadWholeFile(certs_ / "client-alice.key"), before);
  for (const std::string bad : {"../x", "a b", ""}) {
    const auto refused = Process::Start({SHUTTERLINE_SOURCE_DIR "/deploy/certs", certs_, "client", bad},
                                        farm_.folder() / "bad");
    EXPECT_EQ(refused->Wait(), 2) << bad;
  }
  const auto help =
      Process::Start({SHUTTERLINE_SOURCE_DIR "/deploy/certs", "--help"}, farm_.folder() / "help");
  EXPECT_EQ(help->Wait(), 0);
  EXPECT_THAT(help->Output(), HasSubstr("shutterline://role/ROLE"));
}

}  // namespace
}  // namespace shutterline
