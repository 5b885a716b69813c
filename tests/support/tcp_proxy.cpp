#include "tests/support/tcp_proxy.h"

#include <absl/time/clock.h>
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

namespace shutterline {
namespace {

/// Of one direction: beyond it the sender is made to wait, as by any network.
constexpr size_t kMostHeldBytes = size_t{4} << 20;

[[noreturn]] void Die(const char* what) {
  std::perror(what);
  std::abort();
}

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(uint16_t(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A connection to the port, or -1. Over loopback that answers at once.
int Connect(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket < 0) Die("socket");
  const sockaddr_in address = Loopback(port);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return socket;
  ::close(socket);
  return -1;
}

void NoDelay(int socket) {
  const int on = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

/// Closes with a reset instead of an orderly end.
void Break(int socket) {
  const linger now{1, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &now, sizeof now);
  ::close(socket);
}

bool WouldBlock() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

TcpProxy::TcpProxy(int target_port) : target_port_(target_port) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (listener_ < 0 || wake_ < 0) Die("proxy");
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 128) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    Die("proxy: listen");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { Work(); });
}

TcpProxy::~TcpProxy() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  Wake();
  thread_.join();
  for (Link& link : links_) Reset(link);
  ::close(listener_);
  ::close(wake_);
}

void TcpProxy::Wake() const {
  const uint64_t one = 1;
  (void)!::write(wake_, &one, sizeof one);
}

void TcpProxy::SetDelay(absl::Duration delay) {
  absl::MutexLock lock(&mutex_);
  delay_ = delay;
}

void TcpProxy::SetHeld(bool held) {
  {
    absl::MutexLock lock(&mutex_);
    held_ = held;
  }
  Wake();
}

void TcpProxy::CutAll() {
  {
    absl::MutexLock lock(&mutex_);
    for (Link& link : links_) Reset(link);
    links_.clear();
  }
  Wake();
}

void TcpProxy::HalfCloseAll(bool towards_target) {
  {
    absl::MutexLock lock(&mutex_);
    for (Link& link : links_) {
      Flow& flow = towards_target ? link.up : link.down;
      flow.ended = true;
      flow.pieces.clear();
      flow.held_bytes = 0;
    }
  }
  Wake();
}

int TcpProxy::connections() const {
  absl::MutexLock lock(&mutex_);
  return connections_;
}

void TcpProxy::Reset(Link& link) {
  Break(link.client);
  Break(link.target);
}

void TcpProxy::Accept() {
  const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  const int target = Connect(target_port_);
  if (target < 0) return Break(client);
  NoDelay(client);
  NoDelay(target);
  Link link;
  link.client = client;
  link.target = target;
  link.up.from = link.down.to = client;
  link.up.to = link.down.from = target;
  links_.push_back(std::move(link));
  ++connections_;
}

bool TcpProxy::Receive(Flow& flow) {
  char buffer[size_t{64} << 10];
  const ssize_t got = ::recv(flow.from, buffer, sizeof buffer, MSG_DONTWAIT);
  if (got < 0) return WouldBlock();
  if (flow.ended) return got > 0;  // What comes after the end that we pretended is dropped.
  if (got == 0) {
    flow.ended = true;
    return true;
  }
  flow.pieces.push_back({absl::Now() + delay_, std::string(buffer, size_t(got))});
  flow.held_bytes += size_t(got);
  return true;
}

bool TcpProxy::Forward(Flow& flow, absl::Time now) {
  while (!held_ && !flow.pieces.empty() && flow.pieces.front().due <= now) {
    Piece& piece = flow.pieces.front();
    const ssize_t put = ::send(flow.to, piece.bytes.data(), piece.bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (put < 0) return WouldBlock();
    flow.held_bytes -= size_t(put);
    piece.bytes.erase(0, size_t(put));
    if (!piece.bytes.empty()) return true;
    flow.pieces.pop_front();
  }
  if (flow.ended && flow.pieces.empty() && !flow.closed) {
    flow.closed = true;
    ::shutdown(flow.to, SHUT_WR);
  }
  return true;
}

void TcpProxy::Work() {
  while (true) {
    std::vector<pollfd> polled = {{listener_, POLLIN, 0}, {wake_, POLLIN, 0}};
    absl::Time due = absl::InfiniteFuture();
    const absl::Time before = absl::Now();
    {
      absl::MutexLock lock(&mutex_);
      if (stopping_) return;
      for (const Link& link : links_) {
        for (const Flow* flow : {&link.up, &link.down}) {
          // A socket that nothing is wanted of would still report that its other end is gone, all the time.
          const bool wanted = !flow->closed && flow->held_bytes < kMostHeldBytes;
          polled.push_back({wanted ? flow->from : -1, POLLIN, 0});
          if (held_ || flow->pieces.empty()) continue;
          due = std::min(due, flow->pieces.front().due);
        }
      }
    }
    // Who does not take what is due is tried again after a moment.
    const absl::Duration wait = std::max(due - before, absl::Milliseconds(1));
    const int timeout = due == absl::InfiniteFuture() ? -1 : int(absl::ToInt64Milliseconds(wait)) + 1;
    if (::poll(polled.data(), nfds_t(polled.size()), timeout) < 0 && errno != EINTR) Die("poll");
    uint64_t wakes = 0;
    (void)!::read(wake_, &wakes, sizeof wakes);

    absl::MutexLock lock(&mutex_);
    if (stopping_) return;
    if ((polled[0].revents & POLLIN) != 0) Accept();
    const absl::Time now = absl::Now();
    for (auto link = links_.begin(); link != links_.end();) {
      bool alive = true;
      for (Flow* flow : {&link->up, &link->down}) {
        if (!flow->closed && flow->held_bytes < kMostHeldBytes) alive = alive && Receive(*flow);
        alive = alive && Forward(*flow, now);
      }
      if (alive && !(link->up.closed && link->down.closed)) {
        ++link;
        continue;
      }
      Reset(*link);
      link = links_.erase(link);
    }
  }
}

}  // namespace shutterline
