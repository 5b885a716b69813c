#include "server/schedule/fair_share.h"

#include <algorithm>
#include <limits>

#include "common/base/check.h"

namespace shutterline::server {

void FairShare::Add(JobKey job, int priority, const std::string& user) {
  SL_CHECK(jobs_.try_emplace(job, Job{priority, user, 0}).second);
  ++users_[user].jobs;
}

void FairShare::Remove(JobKey job) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) return;
  const auto user = users_.find(found->second.user);
  if (--user->second.jobs == 0) users_.erase(user);
  jobs_.erase(found);
  wanting_.erase(job);
}

void FairShare::SetPriority(JobKey job, int priority) {
  jobs_.at(job).priority = priority;
}

void FairShare::Charge(JobKey job, double seconds) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) return;
  found->second.seconds += seconds;
  users_.at(found->second.user).seconds += seconds;
}

std::vector<JobKey> FairShare::Rank(const std::vector<JobKey>& wanting, JobKey current, double slack) {
  // Who had least among those that wanted something before, per user for jobs.
  constexpr double kNobody = std::numeric_limits<double>::infinity();
  double least_user = kNobody;
  std::map<std::string, double> least_job;
  std::set<std::string> wanting_users;
  for (const JobKey key : wanting_) {
    const Job& job = jobs_.at(key);
    wanting_users.insert(job.user);
    least_user = std::min(least_user, users_.at(job.user).seconds);
    const auto [least, is_first] = least_job.try_emplace(job.user, job.seconds);
    if (!is_first) least->second = std::min(least->second, job.seconds);
  }
  for (const JobKey key : wanting) {
    if (wanting_.contains(key)) continue;
    Job& job = jobs_.at(key);
    double& user_seconds = users_.at(job.user).seconds;
    if (!wanting_users.contains(job.user) && least_user < kNobody) {
      user_seconds = std::max(user_seconds, least_user);
    }
    const auto least = least_job.find(job.user);
    if (least != least_job.end()) job.seconds = std::max(job.seconds, least->second);
  }
  wanting_ = std::set<JobKey>(wanting.begin(), wanting.end());

  std::vector<JobKey> ranked = wanting;
  std::sort(ranked.begin(), ranked.end(), [this](JobKey a, JobKey b) {
    const Job &left = jobs_.at(a), &right = jobs_.at(b);
    if (left.priority != right.priority) return left.priority > right.priority;
    const double left_user = users_.at(left.user).seconds, right_user = users_.at(right.user).seconds;
    if (left_user != right_user) return left_user < right_user;
    if (left.user != right.user) return left.user < right.user;
    if (left.seconds != right.seconds) return left.seconds < right.seconds;
    return a < b;
  });
  const auto stays = std::find(ranked.begin(), ranked.end(), current);
  if (stays == ranked.end() || stays == ranked.begin()) return ranked;
  const Job &kept = jobs_.at(current), &first = jobs_.at(ranked.front());
  // The first of its user among those of its priority has had least of that user's.
  const auto of_user = std::find_if(ranked.begin(), ranked.end(), [&](JobKey key) {
    return jobs_.at(key).user == kept.user && jobs_.at(key).priority == kept.priority;
  });
  if (kept.priority == first.priority &&
      users_.at(kept.user).seconds - users_.at(first.user).seconds <= slack &&
      kept.seconds - jobs_.at(*of_user).seconds <= slack) {
    std::rotate(ranked.begin(), stays, stays + 1);
  }
  return ranked;
}

double FairShare::UserSeconds(const std::string& user) const {
  const auto found = users_.find(user);
  return found == users_.end() ? 0 : found->second.seconds;
}

double FairShare::JobSeconds(JobKey job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? 0 : found->second.seconds;
}

}  // namespace shutterline::server
