#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "server/schedule/lease.h"

namespace shutterline::server {

/// Whose turn it is: jobs of the highest priority first; among those the job of the user who has had least,
/// and of a user's jobs the one that has had least. What somebody has had is thread time, leased as well as
/// spent. Who comes (back) after having wanted nothing starts level with whoever has had least: shares are of
/// the present, nobody saves up and nobody pays for nights when he was alone. Not thread-safe.
class FairShare {
 public:
  void Add(JobKey job, int priority, const std::string& user);
  void Remove(JobKey job);
  void SetPriority(JobKey job, int priority);

  /// Notes that the job has had `seconds` more; below 0: less than it was charged for before.
  void Charge(JobKey job, double seconds);

  /// The jobs of `wanting` (those that have tiles to give out, in any order), whose turn it is first.
  /// `current` stays in front for as long as nobody of its priority lags behind it by more than `slack`
  /// seconds, so that workers need not change jobs, and set up frames, at every turn.
  std::vector<JobKey> Rank(const std::vector<JobKey>& wanting, JobKey current, double slack);

  /// What it has had, as Rank sees it; for tests and views.
  double UserSeconds(const std::string& user) const;
  double JobSeconds(JobKey job) const;

 private:
  struct Job {
    int priority = 0;
    std::string user;
    double seconds = 0;
  };
  struct User {
    double seconds = 0;
    int jobs = 0;
  };

  std::map<JobKey, Job> jobs_;
  std::map<std::string, User> users_;
  std::set<JobKey> wanting_;  ///< At the last Rank.
};

}  // namespace shutterline::server
