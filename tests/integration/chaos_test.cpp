// Everything that can die dies, and every connection is disturbed, at random: the frames do not show it.
//
//     SHUTTERLINE_CHAOS_ROUNDS=200 SHUTTERLINE_CHAOS_SEED=7 chaos_test
//
// runs so many rounds (10 unless told), the first of which has this seed (by default one that is drawn and
// printed).
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/clock.h>
#include <gtest/gtest.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <thread>

#include "tests/integration/farm.h"
#include "tests/support/tcp_proxy.h"

namespace shutterline {
namespace {

/// Frames of 6 × 5 tiles, two borders cut, by the integrator whose tiles take longest for their size: what is
/// killed is killed in mid-frame.
std::vector<std::string> Picture(int frame) {
  return {"--size",       "186x140",   "--float", "--frame", absl::StrCat(frame),
          "--integrator", "reference", "--spp",   "32"};
}
constexpr int kFrames = 3;
constexpr int kDisturbedSubmits = 2;

int FromEnvironment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  int value = 0;
  return text != nullptr && absl::SimpleAtoi(text, &value) ? value : otherwise;
}

class ChaosTest : public testing::Test {
 protected:
  /// The frame as `render` makes it in one process.
  const std::vector<uint32_t>& Truth(int frame) {
    std::vector<uint32_t>& truth = truths_[frame];
    if (!truth.empty()) return truth;
    const std::string file = (farm_.folder() / absl::StrCat("truth-", frame, ".exr")).string();
    std::vector<std::string> arguments = {"render", scene_, "--threads", "2", "-o", file};
    for (const std::string& argument : Picture(frame)) arguments.push_back(argument);
    const Farm::Ended render = farm_.Client(arguments);
    EXPECT_EQ(render.status, 0) << render.errors;
    return truth = PixelBits(file);
  }

  /// Submits through the disturbed network. What was not acknowledged in time is nobody's.
  void SubmitJobs(uint32_t seed, std::map<std::string, int>& acknowledged) {
    std::mt19937 random(seed);
    for (int i = 0; i < kDisturbedSubmits; ++i) {
      const int frame = int(random() % kFrames);
      std::vector<std::string> arguments = {"submit", scene_, "--server", Disturbed()};
      for (const std::string& argument : Picture(frame)) arguments.push_back(argument);
      const Farm::Ended submit = farm_.Client(arguments);
      if (submit.status != 0) continue;
      acknowledged[submit.output.substr(0, submit.output.find('\n'))] = frame;
      absl::SleepFor(absl::Milliseconds(random() % 200));
    }
  }

  std::string Disturbed() const { return absl::StrCat("127.0.0.1:", proxy_->port()); }

  void KillServer() {
    farm_.server().Signal(SIGKILL);
    ASSERT_EQ(farm_.server().Wait(), 128 + SIGKILL);
    farm_.StartServer();
  }

  void ReplaceWorker(std::mt19937& random) {
    const size_t i = random() % workers_.size();
    farm_.KillWorker(workers_[i]);
    workers_[i] = absl::StrCat("worker-", ++names_);
    farm_.StartWorker(workers_[i], 1, Disturbed());
  }

  /// One thing goes wrong.
  void Disturb(std::mt19937& random, int& worker_kills) {
    switch (random() % 8) {
      case 0:
      case 1:
        ++counts_["coordinator killed"];
        return KillServer();
      case 2:
        // Three workers that die at one tile would end its job, and rightly.
        if (++worker_kills > 2) return;
        ++counts_["worker killed"];
        return ReplaceWorker(random);
      case 3:
      case 4:
        ++counts_["cut"];
        return proxy_->CutAll();
      case 5:
        ++counts_["half-closed"];
        return proxy_->HalfCloseAll(random() % 2 == 0);
      case 6:
        ++counts_["delayed"];
        return proxy_->SetDelay(absl::Milliseconds(random() % 300));
      default:
        // Held up, then cut: what was under way is sent again, though it had been sent.
        ++counts_["held and cut"];
        proxy_->SetHeld(true);
        absl::SleepFor(absl::Milliseconds(random() % 300));
        proxy_->CutAll();
        return proxy_->SetHeld(false);
    }
  }

  void Round(uint32_t seed) {
    std::mt19937 random(seed);
    int worker_kills = 0;
    std::map<std::string, int> acknowledged;
    // One job is there from the beginning, so that there is something to disturb.
    const int first = int(random() % kFrames);
    std::vector<std::string> arguments = {scene_};
    for (const std::string& argument : Picture(first)) arguments.push_back(argument);
    acknowledged[farm_.Submit(arguments)] = first;
    const auto submitter_seed = uint32_t(random());
    std::map<std::string, int> disturbed;
    std::thread submitter([&] { SubmitJobs(submitter_seed, disturbed); });
    const int disturbances = 5 + int(random() % 4);
    for (int i = 0; i < disturbances && !HasFatalFailure(); ++i) {
      absl::SleepFor(absl::Milliseconds(30 + random() % 300));
      Disturb(random, worker_kills);
    }
    proxy_->SetDelay(absl::ZeroDuration());
    submitter.join();
    acknowledged.merge(disturbed);
    if (HasFatalFailure()) return;
    // Those that were cut off often may wait for seconds by now before they dial again.
    farm_.StartWorker("heir", 2, Disturbed());
    for (const auto& [job, frame] : acknowledged) {
      SCOPED_TRACE(testing::Message() << "job " << job << " of frame " << frame);
      const v1::Job ended =
          farm_.WatchUntil(job, [](const v1::Job& j) { return j.state() == v1::JOB_STATE_SUCCEEDED; });
      EXPECT_EQ(ended.tiles_done(), ended.tiles_total());
      EXPECT_EQ(ended.mismatched_tiles(), 0u);
      const std::string file = (farm_.folder() / (job + ".exr")).string();
      farm_.Fetch(job, file);
      EXPECT_TRUE(PixelBits(file) == Truth(frame)) << "the pixels differ";
      std::filesystem::remove(file);
    }
    acknowledged_ += acknowledged.size();
    farm_.KillWorker("heir");
  }

  Farm farm_;
  std::string scene_;
  std::unique_ptr<TcpProxy> proxy_;
  std::array<std::string, 2> workers_;
  int names_ = 0;
  std::map<int, std::vector<uint32_t>> truths_;
  std::map<std::string, int> counts_;
  size_t acknowledged_ = 0;
};

TEST_F(ChaosTest, KillsCutsAndDelaysChangeNoPixelAndLoseNoJob) {
  const int rounds = FromEnvironment("SHUTTERLINE_CHAOS_ROUNDS", 10);
  const auto first = uint32_t(FromEnvironment("SHUTTERLINE_CHAOS_SEED", int(std::random_device()() >> 1)));
  scene_ = farm_.Scene("debris");
  farm_.StartServer();
  ASSERT_FALSE(HasFatalFailure());
  proxy_ = std::make_unique<TcpProxy>(farm_.port());
  for (std::string& worker : workers_) {
    worker = absl::StrCat("worker-", ++names_);
    farm_.StartWorker(worker, 1, Disturbed());
  }
  for (int round = 0; round < rounds; ++round) {
    const absl::Time start = absl::Now();
    SCOPED_TRACE(testing::Message() << "SHUTTERLINE_CHAOS_SEED=" << first + uint32_t(round));
    std::printf("round %d, seed %u\n", round, first + uint32_t(round));
    std::fflush(stdout);
    Round(first + uint32_t(round));
    std::printf("  %.1f s\n", absl::ToDoubleSeconds(absl::Now() - start));
    ASSERT_FALSE(HasFailure());
  }
  for (const auto& [what, count] : counts_) std::printf("%s: %d\n", what.c_str(), count);
  std::printf("jobs acknowledged and fetched: %zu, connections: %d\n", acknowledged_, proxy_->connections());
  // The disturbances do not keep everybody from working.
  EXPECT_GE(acknowledged_, size_t(rounds));
}

}  // namespace
}  // namespace shutterline
