#pragma once

#include <absl/time/time.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "shutterline/v1/jobs.grpc.pb.h"
#include "tests/support/process.h"

namespace shutterline {

/// A coordinator, workers and clients as real processes over loopback, below one temporary folder. What
/// goes wrong fails the test that runs. Everything is killed and removed with it.
class Farm {
 public:
  Farm();
  ~Farm();
  Farm(const Farm&) = delete;
  Farm& operator=(const Farm&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

  /// More arguments for programs that are started from now on; a client's go to commands with --server.
  std::vector<std::string> server_flags, worker_flags, client_flags;

  /// A GLB file made by shutterline-scenes.
  std::string Scene(const std::string& name);

  /// On any free port the first time, and on the same port, with the same data, after that.
  void StartServer();
  /// In place of one below `folder()`.
  void SetDataFolder(const std::filesystem::path& data) { data_ = data; }
  Process& server() { return *server_; }
  /// It dials `address`; the server's where that is empty.
  void StartWorker(const std::string& name, int threads, const std::string& address = "");
  /// Kills the worker at once and waits for its end.
  void KillWorker(const std::string& name);
  Process& worker(const std::string& name) { return *workers_.at(name); }
  std::string Address() const;
  int port() const { return port_; }

  struct Ended {
    int status = -1;
    std::string output, errors;
  };
  /// Runs `shutterline ARGUMENTS`.
  Ended Client(const std::vector<std::string>& arguments);
  /// Submits a job and returns its id.
  std::string Submit(std::vector<std::string> arguments);
  /// Waits until the job has ended and fetches its one frame: the pixels of `file`.
  void Fetch(const std::string& job, const std::string& file);

  /// Follows the job until `done` holds for it (in its Job message, without specification), over restarts
  /// of the coordinator; returns that. Fails the test where the job ends before.
  v1::Job WatchUntil(const std::string& job, const std::function<bool(const v1::Job&)>& done);
  /// Waits until so many workers are registered.
  void WaitForWorkers(int count);
  /// A stub with a channel of its own.
  std::unique_ptr<v1::Jobs::Stub> Stub() const;

 private:
  std::filesystem::path folder_, data_;
  int port_ = 0;
  std::atomic<int> runs_ = 0;  // Of programs: numbers their logs.
  std::unique_ptr<Process> server_;
  std::map<std::string, std::unique_ptr<Process>> workers_;
};

/// The pixels of an EXR file, bit by bit; empty, with a failure of the test, where it cannot be read.
std::vector<uint32_t> PixelBits(const std::filesystem::path& file);

}  // namespace shutterline
