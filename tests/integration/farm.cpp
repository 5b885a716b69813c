#include "tests/integration/farm.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <system_error>

#include "common/image/exr.h"
#include "common/image/image.h"

namespace shutterline {
namespace {

namespace fs = std::filesystem;

std::string Program(const std::string& name) {
  return (fs::path(SHUTTERLINE_BINARY_DIR) / "bin" / name).string();
}

}  // namespace

Farm::Farm() {
  std::string folder = (fs::temp_directory_path() / "shutterline-farm.XXXXXX").string();
  EXPECT_NE(mkdtemp(folder.data()), nullptr);
  folder_ = folder;
  data_ = folder_ / "data";
}

Farm::~Farm() {
  if (testing::Test::HasFailure()) {
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (entry.path().extension() != ".err") continue;
      std::string text = ReadWholeFile(entry.path());
      if (text.size() > 8000) text = "[...]" + text.substr(text.size() - 8000);
      std::fprintf(stderr, "--- %s\n%s", entry.path().filename().c_str(), text.c_str());
    }
  }
  workers_.clear();
  server_.reset();
  std::error_code error;
  fs::remove_all(folder_, error);
}

std::string Farm::Scene(const std::string& name) {
  const std::string file = (folder_ / (name + ".glb")).string();
  if (fs::exists(file)) return file;
  const auto made =
      Process::Start({Program("shutterline-scenes"), name, "-o", file}, folder_ / ("scene-" + name));
  EXPECT_EQ(made->Wait(), 0) << made->Errors();
  return file;
}

void Farm::StartServer() {
  const fs::path port_file = folder_ / "port";
  fs::remove(port_file);
  std::vector<std::string> all = {Program("shutterline-server"),
                                  "--listen",
                                  absl::StrCat("127.0.0.1:", port_),
                                  "--data",
                                  data_.string(),
                                  "--port-file",
                                  port_file.string()};
  all.insert(all.end(), server_flags.begin(), server_flags.end());
  server_ = Process::Start(all, folder_ / absl::StrCat("server-", ++runs_));
  ASSERT_NE(server_, nullptr);
  ASSERT_TRUE(WaitUntil([&] { return fs::exists(port_file) || !server_->Running(); }));
  ASSERT_TRUE(fs::exists(port_file)) << server_->Errors();
  std::string text = ReadWholeFile(port_file);
  absl::StripTrailingAsciiWhitespace(&text);
  ASSERT_TRUE(absl::SimpleAtoi(text, &port_)) << text;
}

void Farm::StartWorker(const std::string& name, int threads, const std::string& address) {
  std::vector<std::string> all = {Program("shutterline-worker"),
                                  "--coordinator",
                                  address.empty() ? Address() : address,
                                  "--name",
                                  name,
                                  "--threads",
                                  absl::StrCat(threads),
                                  "--cache-dir",
                                  (folder_ / "cache").string()};
  all.insert(all.end(), worker_flags.begin(), worker_flags.end());
  workers_[name] = Process::Start(all, folder_ / absl::StrCat("worker-", name, "-", ++runs_));
  ASSERT_NE(workers_[name], nullptr);
}

void Farm::KillWorker(const std::string& name) {
  workers_.at(name)->Signal(SIGKILL);
  EXPECT_EQ(workers_.at(name)->Wait(), 128 + SIGKILL);
  workers_.erase(name);
}

std::string Farm::Address() const {
  return absl::StrCat("127.0.0.1:", port_);
}

Farm::Ended Farm::Client(const std::vector<std::string>& arguments) {
  std::vector<std::string> all = {Program("shutterline")};
  all.insert(all.end(), arguments.begin(), arguments.end());
  if (std::find(all.begin(), all.end(), "--server") != all.end()) {
    all.insert(all.end(), client_flags.begin(), client_flags.end());
  }
  const auto client = Process::Start(all, folder_ / absl::StrCat("client-", ++runs_));
  EXPECT_NE(client, nullptr);
  const std::optional<int> status = client->Wait();
  EXPECT_TRUE(status.has_value()) << "the client hangs: " << arguments[0];
  return {status.value_or(-1), client->Output(), client->Errors()};
}

std::string Farm::Submit(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "submit");
  arguments.insert(arguments.end(), {"--server", Address()});
  Ended submit = Client(arguments);
  EXPECT_EQ(submit.status, 0) << submit.errors;
  absl::StripTrailingAsciiWhitespace(&submit.output);
  return submit.output;
}

void Farm::Fetch(const std::string& job, const std::string& file) {
  const Ended watch = Client({"watch", job, "--server", Address()});
  ASSERT_EQ(watch.status, 0) << watch.output << watch.errors;
  const Ended fetch = Client({"fetch", job, "-o", file, "--server", Address()});
  ASSERT_EQ(fetch.status, 0) << fetch.errors;
}

std::unique_ptr<v1::Jobs::Stub> Farm::Stub() const {
  // A channel of its own each time: no memory of a coordinator that was down a moment ago.
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return v1::Jobs::NewStub(
      grpc::CreateCustomChannel(Address(), grpc::InsecureChannelCredentials(), arguments));
}

v1::Job Farm::WatchUntil(const std::string& job, const std::function<bool(const v1::Job&)>& done) {
  v1::Job latest;
  bool reached = false;
  const auto watch = [&] {
    grpc::ClientContext context;
    context.set_wait_for_ready(true);
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(2));
    v1::WatchRequest request;
    request.set_job_id(job);
    const auto stub = Stub();
    const auto stream = stub->Watch(&context, request);
    v1::JobEvent event;
    while (!reached && stream->Read(&event)) {
      if (!event.has_job()) continue;
      latest = event.job();
      reached = done(latest);
    }
    context.TryCancel();
    return reached || stream->Finish().ok();
  };
  EXPECT_TRUE(WaitUntil(watch)) << "job " << job << ": " << latest.ShortDebugString();
  EXPECT_TRUE(reached) << "the job ended before: " << latest.ShortDebugString();
  return latest;
}

void Farm::WaitForWorkers(int count) {
  const auto stub = Stub();
  EXPECT_TRUE(WaitUntil([&] {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    v1::ListWorkersResponse response;
    return stub->ListWorkers(&context, {}, &response).ok() && response.workers_size() == count;
  })) << "not "
      << count << " workers";
}

std::vector<uint32_t> PixelBits(const fs::path& file) {
  const absl::StatusOr<Image> image = ReadExr(file.string());
  EXPECT_TRUE(image.ok()) << image.status();
  if (!image.ok()) return {};
  std::vector<uint32_t> bits(image->values().size());
  std::memcpy(bits.data(), image->values().data(), bits.size() * sizeof(uint32_t));
  return bits;
}

}  // namespace shutterline
