#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/client_context.h>

#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/connection.h"
#include "client/terminal_picture.h"

namespace shutterline::client {

/// Follows the frame that a job is at, in a thread of its own, and draws it. Thread-safe.
///
/// A preview is a courtesy: what goes wrong with it is not told, and ends nothing but the preview.
class FramePreview {
 public:
  struct Size {
    int columns = 0, rows = 0;  ///< Characters that the picture may take.
  };
  /// `on_picture` is called from the preview's thread with each new picture, at most ten a second. Everything
  /// outlives the preview.
  /// `coarse`: what stands alone stands for its neighbourhood, as TerminalPicture has it.
  FramePreview(Connection& connection, std::string job_id, const TileGrid& grid, bool coarse, Size size,
               std::function<void(std::vector<std::string>)> on_picture);
  ~FramePreview();
  FramePreview(const FramePreview&) = delete;
  FramePreview& operator=(const FramePreview&) = delete;

  /// The job is at this frame: it is shown next, once the one that is being shown has been finished; of
  /// several the latest. Nothing new where it is being shown or has been, to its end.
  void Show(int frame);
  /// The last frame shown is shown to its end, and the thread ends; at once where `hurry`.
  void Finish(bool hurry);

 private:
  void Work();
  /// Shows the frame as it fills. True: to its end.
  bool Read(int frame);

  Connection& connection_;
  const std::string job_id_;
  const TileGrid grid_;
  const bool coarse_;
  const Size size_;
  const std::function<void(std::vector<std::string>)> on_picture_;

  absl::Mutex mutex_;
  std::optional<int> wanted_ ABSL_GUARDED_BY(mutex_);   ///< To be shown next.
  std::optional<int> showing_ ABSL_GUARDED_BY(mutex_);  ///< Is being shown, or was shown last, to its end.
  bool finishing_ ABSL_GUARDED_BY(mutex_) = false, hurrying_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::ClientContext* reading_ ABSL_GUARDED_BY(mutex_) = nullptr;
  std::thread thread_;
};

/// Whether a terminal on standard error shows true colour, and has room: its size, less what progress needs.
std::optional<FramePreview::Size> PreviewSize();

}  // namespace shutterline::client
