// Clients that mean harm, against a real coordinator over TLS, while an honest job is rendered.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

#include "common/asset/digest.h"
#include "proto/convert/job_spec.h"
#include "proto/credentials/channel_credentials.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "shutterline/v1/jobs.grpc.pb.h"
#include "shutterline/v1/workers.grpc.pb.h"
#include "tests/integration/certificates.h"
#include "tests/integration/farm.h"
#include "tests/integration/raw_call.h"

namespace shutterline {
namespace {

using testing::HasSubstr;
using Code = grpc::StatusCode;

constexpr int kMebibyte = 1 << 20;

/// A line of /proc/PID/status in MiB: VmRSS, or VmHWM, the most it ever was.
int64_t MemoryOf(const Process& process, const std::string& line) {
  const std::string status = ReadWholeFile(absl::StrCat("/proc/", process.pid(), "/status"));
  for (const absl::string_view text : absl::StrSplit(status, '\n')) {
    const std::vector<std::string> words = absl::StrSplit(text, absl::ByAnyChar(": \t"), absl::SkipEmpty());
    int64_t kib = 0;
    if (words.size() >= 2 && words[0] == line && absl::SimpleAtoi(words[1], &kib)) return kib / 1024;
  }
  ADD_FAILURE() << "no " << line << " in " << status;
  return 0;
}

class HostileClientTest : public testing::Test {
 protected:
  HostileClientTest() : certs_(farm_.folder() / "certs-of-farm") {
    MakeCertificates(certs_, {"ca"});
    MakeCertificates(certs_, {"server", "localhost", "127.0.0.1"});
    MakeCertificates(certs_, {"client", "mallory"});
    MakeCertificates(certs_, {"worker", "eve"});
    farm_.server_flags = {"--tls-cert",          certs_ / "server.pem", "--tls-key",
                          certs_ / "server.key", "--tls-client-ca",     certs_ / "ca.pem"};
    farm_.StartServer();
    farm_.client_flags = CertificateFlags(certs_, "client-mallory");
    farm_.worker_flags = CertificateFlags(certs_, "worker-eve");
  }

  std::shared_ptr<grpc::Channel> ChannelAs(const std::string& stem) {
    const auto made = credentials::MakeChannelCredentials(
        {certs_ / "ca.pem", certs_ / (stem + ".pem"), certs_ / (stem + ".key"), ""}, farm_.Address());
    EXPECT_TRUE(made.ok()) << made.status();
    return OwnChannel(farm_.Address(), *made);
  }

  /// A Write stream of these chunks to its end.
  grpc::Status WriteBlob(v1::Blobs::Stub& stub, const std::vector<v1::BlobChunk>& chunks) {
    grpc::ClientContext context;
    v1::Committed committed;
    const auto writer = stub.Write(&context, &committed);
    for (const v1::BlobChunk& chunk : chunks) {
      if (!writer->Write(chunk)) break;
    }
    writer->WritesDone();
    return writer->Finish();
  }
  static v1::BlobChunk Chunk(const Digest& digest, uint64_t size, uint64_t offset, const std::string& data) {
    v1::BlobChunk chunk;
    *chunk.mutable_digest() = convert::ToProto(digest);
    chunk.set_size_bytes(size);
    chunk.set_offset(offset);
    chunk.set_data(data);
    return chunk;
  }

  Farm farm_;
  const std::filesystem::path certs_;
};

/// Streams of which nothing but the beginning ever comes.
template <typename Stream>
struct HalfOpen {
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<Stream>> streams;

  template <typename Open>
  void Add(int count, const Open& open) {
    for (int i = 0; i < count; ++i) {
      contexts.push_back(std::make_unique<grpc::ClientContext>());
      streams.push_back(open(contexts.back().get()));
    }
  }
  ~HalfOpen() {
    for (const auto& context : contexts) context->TryCancel();
  }
};

TEST_F(HostileClientTest, AJobIsRenderedWhileTheCoordinatorIsUnderAttack) {
  const std::vector<std::string> picture = {"--size", "160x120", "--float", "--frame", "3"};
  const std::string scene = farm_.Scene("fan");
  const std::string alone = farm_.folder() / "alone.exr";
  std::vector<std::string> render = {"render", scene, "-o", alone};
  render.insert(render.end(), picture.begin(), picture.end());
  ASSERT_EQ(farm_.Client(render).status, 0);
  std::vector<std::string> submit = {scene};
  submit.insert(submit.end(), picture.begin(), picture.end());
  const std::string job = farm_.Submit(submit);
  const int64_t before = MemoryOf(farm_.server(), "VmHWM");

  // Half-open streams: 250 of each kind, over three connections each.
  HalfOpen<grpc::ClientReaderWriter<v1::WorkerMessage, v1::CoordinatorMessage>> sessions;
  HalfOpen<grpc::ClientReaderWriter<v1::ResultBatch, v1::ResultAck>> results;
  HalfOpen<grpc::ClientReader<v1::JobEvent>> watches;
  HalfOpen<grpc::ClientWriter<v1::BlobChunk>> writes;
  std::vector<std::unique_ptr<v1::Committed>> committed;
  v1::WatchRequest watch;
  watch.set_job_id(job);
  for (int connection = 0; connection < 5; ++connection) {
    const auto workers = v1::Workers::NewStub(ChannelAs("worker-eve"));
    sessions.Add(50, [&](grpc::ClientContext* context) { return workers->Session(context); });
    results.Add(50, [&](grpc::ClientContext* context) { return workers->PushResults(context); });
    const auto channel = ChannelAs("client-mallory");
    const auto jobs = v1::Jobs::NewStub(channel);
    const auto blobs = v1::Blobs::NewStub(channel);
    watches.Add(50, [&](grpc::ClientContext* context) { return jobs->Watch(context, watch); });
    writes.Add(50, [&](grpc::ClientContext* context) {
      committed.push_back(std::make_unique<v1::Committed>());
      return blobs->Write(context, committed.back().get());
    });
  }

  // The honest worker comes while they are open.
  farm_.StartWorker("honest", 1);

  // Huge lists, several at a time.
  std::string list;
  for (int i = 0; i < 400'000; ++i) {
    list += "\x0a\x22\x0a\x20";
    list.append(32, char(i));
  }
  ASSERT_LT(list.size(), size_t{16 * kMebibyte});
  std::vector<std::thread> flood;
  for (int t = 0; t < 3; ++t) {
    flood.emplace_back([&] {
      const auto channel = ChannelAs("client-mallory");
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(RawCall(channel, "/shutterline.v1.Blobs/FindMissing", list).error_code(),
                  Code::INVALID_ARGUMENT);
      }
    });
  }
  // What two bytes would unfold into a hundred: eight million empty results, as many files.
  const auto worker = ChannelAs("worker-eve"), client = ChannelAs("client-mallory");
  std::string tiles;
  for (int i = 0; i < 4 * kMebibyte; ++i) tiles += std::string("\x22\x00", 2);
  EXPECT_EQ(RawCall(worker, "/shutterline.v1.Workers/PushResults", tiles).error_code(),
            Code::INVALID_ARGUMENT);
  EXPECT_EQ(RawCall(client, "/shutterline.v1.Jobs/Submit", tiles).error_code(), Code::INVALID_ARGUMENT);
  // Beyond any message.
  EXPECT_EQ(RawCall(client, "/shutterline.v1.Jobs/Submit", std::string(17 * kMebibyte, '\0')).error_code(),
            Code::RESOURCE_EXHAUSTED);
  for (std::thread& thread : flood) thread.join();

  const std::string file = farm_.folder() / "farm.exr";
  farm_.Fetch(job, file);
  EXPECT_EQ(PixelBits(file), PixelBits(alone));
  const int64_t most = MemoryOf(farm_.server(), "VmHWM");
  std::printf("memory of the coordinator, MiB: %lld before, %lld at most\n", (long long)before,
              (long long)most);
  EXPECT_LT(most - before, 700);
  EXPECT_TRUE(farm_.server().Running());
}

TEST_F(HostileClientTest, BytesThatAreNoMessageAreRefusedByEveryMethod) {
  constexpr uint64_t kSeed = 6;
  std::mt19937_64 random(kSeed);
  const auto client = ChannelAs("client-mallory"), worker = ChannelAs("worker-eve");
  const struct {
    const char* method;
    bool of_worker;
  } methods[] = {
      {"/shutterline.v1.Jobs/Submit", false},        {"/shutterline.v1.Jobs/Get", false},
      {"/shutterline.v1.Jobs/List", false},          {"/shutterline.v1.Jobs/Watch", false},
      {"/shutterline.v1.Jobs/Control", false},       {"/shutterline.v1.Jobs/FetchFrame", false},
      {"/shutterline.v1.Blobs/FindMissing", false},  {"/shutterline.v1.Blobs/Write", false},
      {"/shutterline.v1.Blobs/QueryWrite", false},   {"/shutterline.v1.Blobs/Read", true},
      {"/shutterline.v1.Workers/Register", true},    {"/shutterline.v1.Workers/Session", true},
      {"/shutterline.v1.Workers/PushResults", true},
  };
  for (const auto& m : methods) {
    const auto& channel = m.of_worker ? worker : client;
    for (const std::string& bytes : {std::string("\x0a\xff\xff\xff\xff\x0f", 6), std::string("\x07"),
                                     std::string(11, '\xff'), std::string(100'000, '\x0a')}) {
      const grpc::Status status = RawCall(channel, m.method, bytes);
      EXPECT_FALSE(status.ok()) << m.method;
      EXPECT_NE(status.error_code(), Code::UNAVAILABLE) << m.method << ": " << status.error_message();
      EXPECT_NE(status.error_code(), Code::DEADLINE_EXCEEDED) << m.method;
    }
    for (int i = 0; i < 20; ++i) {
      std::string noise(random() % 300, '\0');
      for (char& c : noise) c = char(random());
      EXPECT_NE(RawCall(channel, m.method, noise).error_code(), Code::UNAVAILABLE)
          << m.method << " seed " << kSeed << " case " << i;
    }
  }
  EXPECT_TRUE(farm_.server().Running());
  EXPECT_TRUE(RawCall(client, "/shutterline.v1.Jobs/List").ok());
}

TEST_F(HostileClientTest, BlobsAreTakenByTheRulesAlone) {
  const auto stub = v1::Blobs::NewStub(ChannelAs("client-mallory"));
  const std::string content(1000, 'c');
  const Digest digest = Sha256(content);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(digest, uint64_t{3} << 30, 0, "x")}).error_code(),
            Code::RESOURCE_EXHAUSTED);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(digest, UINT64_MAX, 0, "x")}).error_code(), Code::RESOURCE_EXHAUSTED);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(digest, 1000, 5, content.substr(5))}).error_code(), Code::OUT_OF_RANGE);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(digest, 1000, UINT64_MAX, content)}).error_code(), Code::OUT_OF_RANGE);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(digest, 1000, 0, content + "more")}).error_code(),
            Code::INVALID_ARGUMENT);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(Sha256("other"), 1000, 0, content)}).error_code(),
            Code::INVALID_ARGUMENT);
  EXPECT_EQ(WriteBlob(*stub, {}).error_code(), Code::INVALID_ARGUMENT);
  v1::BlobChunk crooked = Chunk(digest, 1000, 0, content);
  crooked.mutable_digest()->set_sha256("short");
  EXPECT_EQ(WriteBlob(*stub, {crooked}).error_code(), Code::INVALID_ARGUMENT);
  EXPECT_EQ(WriteBlob(*stub, {Chunk(digest, 1000, 0, content.substr(0, 10)), Chunk(digest, 1000, 11, "x")})
                .error_code(),
            Code::OUT_OF_RANGE);
  // And after all that the honest way still works, from where the last one stopped.
  EXPECT_TRUE(WriteBlob(*stub, {Chunk(digest, 1000, 10, content.substr(10))}).ok());
}

}  // namespace
}  // namespace shutterline
