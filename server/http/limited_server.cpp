#include "server/http/limited_server.h"

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/clock.h>
#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <thread>
#include <vector>

namespace shutterline::server {
namespace {

/// A fixed number of threads. Whoever brings more work than they can take at once waits: in our case the one
/// thread that accepts connections.
class BoundedTasks final : public httplib::TaskQueue {
 public:
  explicit BoundedTasks(size_t threads) : idle_(threads) {
    for (size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
  }
  ~BoundedTasks() override { shutdown(); }

  void enqueue(std::function<void()> task) override {
    const auto room = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return tasks_.size() < idle_; };
    absl::MutexLock lock(&mutex_, absl::Condition(&room));
    tasks_.push_back(std::move(task));
  }

  void shutdown() override {
    {
      absl::MutexLock lock(&mutex_);
      stopping_ = true;
    }
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

 private:
  void Work() {
    while (true) {
      std::function<void()> task;
      {
        const auto any = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopping_ || !tasks_.empty(); };
        absl::MutexLock lock(&mutex_, absl::Condition(&any));
        if (tasks_.empty()) return;
        task = std::move(tasks_.front());
        tasks_.pop_front();
        --idle_;
      }
      task();
      absl::MutexLock lock(&mutex_);
      ++idle_;
    }
  }

  absl::Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  size_t idle_ ABSL_GUARDED_BY(mutex_);  ///< Threads that wait for a task.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

/// A connection of one request.
class LimitedStream final : public httplib::Stream {
 public:
  LimitedStream(socket_t socket, const LimitedServer::Limits& limits)
      : socket_(socket),
        write_time_(limits.write_time),
        left_(limits.request_bytes),
        deadline_(absl::Now() + limits.request_time) {}

  bool is_readable() const override { return at_ < end_ || Wait(POLLIN, deadline_ - absl::Now()); }
  bool is_writable() const override { return Wait(POLLOUT, write_time_); }

  ssize_t read(char* data, size_t size) override {
    if (at_ == end_ && !Fill()) return -1;
    const size_t count = std::min(size, end_ - at_);
    std::copy_n(buffer_.data() + at_, count, data);
    at_ += count;
    return ssize_t(count);
  }

  ssize_t write(const char* data, size_t size) override {
    if (!is_writable()) return -1;
    ssize_t sent = 0;
    do {
      sent = ::send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    } while (sent < 0 && errno == EINTR);
    if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return 0;
    return sent;
  }

  void get_remote_ip_and_port(std::string& address, int& port) const override {
    Name(::getpeername, address, port);
  }
  void get_local_ip_and_port(std::string& address, int& port) const override {
    Name(::getsockname, address, port);
  }
  socket_t socket() const override { return socket_; }

 private:
  /// False where the time is over, or the other side has gone.
  bool Wait(short what, absl::Duration time) const {
    pollfd entry{socket_, short(what | POLLRDHUP), 0};
    int ready = 0;
    do {
      ready = ::poll(&entry, 1, int(std::clamp<int64_t>(absl::ToInt64Milliseconds(time), 0, 60'000)));
    } while (ready < 0 && errno == EINTR);
    if (ready <= 0) return false;
    if ((entry.revents & (POLLERR | POLLHUP)) != 0) return false;
    // Half closed: what it said can be read, but nobody reads an endless answer.
    if (what == POLLOUT && (entry.revents & POLLRDHUP) != 0) return false;
    return (entry.revents & what) != 0;
  }

  bool Fill() {
    if (left_ == 0 || !Wait(POLLIN, deadline_ - absl::Now())) return false;
    const ssize_t got = ::recv(socket_, buffer_.data(), std::min(left_, buffer_.size()), 0);
    if (got <= 0) return false;
    at_ = 0;
    end_ = size_t(got);
    left_ -= end_;
    return true;
  }

  template <typename Call>
  void Name(Call call, std::string& address, int& port) const {
    sockaddr_storage storage{};
    socklen_t length = sizeof storage;
    if (call(socket_, reinterpret_cast<sockaddr*>(&storage), &length) != 0) return;
    char text[INET6_ADDRSTRLEN] = "";
    if (storage.ss_family == AF_INET) {
      const auto* v4 = reinterpret_cast<const sockaddr_in*>(&storage);
      inet_ntop(AF_INET, &v4->sin_addr, text, sizeof text);
      port = ntohs(v4->sin_port);
    } else if (storage.ss_family == AF_INET6) {
      const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&storage);
      inet_ntop(AF_INET6, &v6->sin6_addr, text, sizeof text);
      port = ntohs(v6->sin6_port);
    }
    address = text;
  }

  const socket_t socket_;
  const absl::Duration write_time_;
  size_t left_;
  const absl::Time deadline_;
  std::array<char, 4096> buffer_{};
  size_t at_ = 0, end_ = 0;
};

}  // namespace

LimitedServer::LimitedServer(const Limits& limits) : limits_(limits) {
  const size_t threads = limits.threads;
  new_task_queue = [threads]() -> httplib::TaskQueue* { return new BoundedTasks(threads); };
  // Not the library's SO_REUSEPORT: a port that somebody else serves is taken.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  set_keep_alive_max_count(1);
  set_payload_max_length(limits.request_bytes);
}

LimitedServer::~LimitedServer() = default;

bool LimitedServer::process_and_close_socket(socket_t socket) {
  LimitedStream stream(socket, limits_);
  bool closed = false;
  const bool ok = process_request(stream, /*close_connection=*/true, closed, nullptr);
  // Unread bytes would turn the close into a reset, which may overtake the answer.
  ::shutdown(socket, SHUT_WR);
  char rest[4096];
  for (int i = 0; i < 16 && ::recv(socket, rest, sizeof rest, MSG_DONTWAIT) > 0; ++i) {
  }
  ::close(socket);
  return ok;
}

}  // namespace shutterline::server
