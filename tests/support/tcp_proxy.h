#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <cstddef>
#include <deque>
#include <list>
#include <string>
#include <thread>

namespace shutterline {

/// A TCP proxy over loopback that a test makes worse than any network: connections through it are cut, held
/// up and half-closed while they run. One thread; the calls may come from any.
class TcpProxy {
 public:
  /// Listens on a free port of 127.0.0.1. Where nobody listens at `target_port`, connections are closed at
  /// once.
  explicit TcpProxy(int target_port);
  ~TcpProxy();  ///< Cuts all.
  TcpProxy(const TcpProxy&) = delete;
  TcpProxy& operator=(const TcpProxy&) = delete;

  int port() const { return port_; }
  /// Bytes that come from now on are passed on so much later; in their order all the same.
  void SetDelay(absl::Duration delay);
  /// Passes nothing on until it is told to go on; nothing is lost by that.
  void SetHeld(bool held);
  /// Resets every connection: both ends see it broken, and what was under way is gone.
  void CutAll();
  /// Ends one direction of every connection as if the sender had closed it, and drops what it still sends.
  void HalfCloseAll(bool towards_target);

  /// Connections that were passed on so far.
  int connections() const;

 private:
  struct Piece {
    absl::Time due;
    std::string bytes;
  };
  /// One direction of a connection.
  struct Flow {
    int from = -1, to = -1;
    std::deque<Piece> pieces;
    size_t held_bytes = 0;
    bool ended = false;   ///< `from` sends no more, or is not listened to any more.
    bool closed = false;  ///< And `to` has been told.
  };
  struct Link {
    int client = -1, target = -1;
    Flow up, down;
  };

  void Work();
  void Accept() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// False: the link is broken.
  bool Receive(Flow& flow) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool Forward(Flow& flow, absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static void Reset(Link& link);
  void Wake() const;

  const int target_port_;
  int listener_ = -1, wake_ = -1, port_ = 0;
  mutable absl::Mutex mutex_;
  std::list<Link> links_ ABSL_GUARDED_BY(mutex_);
  absl::Duration delay_ ABSL_GUARDED_BY(mutex_);
  bool held_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  int connections_ ABSL_GUARDED_BY(mutex_) = 0;
  std::thread thread_;
};

}  // namespace shutterline
