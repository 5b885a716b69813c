#include "client/frame_preview.h"

#include <absl/time/clock.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace shutterline::client {
namespace {

constexpr absl::Duration kBetweenPictures = absl::Milliseconds(100);
constexpr int kLinesLeft = 3;  ///< For progress, and what stood above.
constexpr int kMaxColumns = 160;

}  // namespace

std::optional<FramePreview::Size> PreviewSize() {
  const char* const colours = std::getenv("COLORTERM");
  const char* const plain = std::getenv("NO_COLOR");
  const std::string kind = colours == nullptr ? "" : colours;
  if ((kind != "truecolor" && kind != "24bit") || (plain != nullptr && *plain != '\0')) return std::nullopt;
  winsize window{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col < 16 || window.ws_row < 8)
    return std::nullopt;
  return FramePreview::Size{std::min(kMaxColumns, int(window.ws_col) - 1), int(window.ws_row) - kLinesLeft};
}

FramePreview::FramePreview(Connection& connection, std::string job_id, const TileGrid& grid, bool coarse,
                           Size size, std::function<void(std::vector<std::string>)> on_picture)
    : connection_(connection),
      job_id_(std::move(job_id)),
      grid_(grid),
      coarse_(coarse),
      size_(size),
      on_picture_(std::move(on_picture)),
      thread_([this] { Work(); }) {}

FramePreview::~FramePreview() {
  Finish(/*hurry=*/true);
}

void FramePreview::Show(int frame) {
  absl::MutexLock lock(&mutex_);
  if (showing_ != frame) wanted_ = frame;
}

void FramePreview::Finish(bool hurry) {
  {
    absl::MutexLock lock(&mutex_);
    finishing_ = true;
    if (hurry) {
      hurrying_ = true;
      wanted_.reset();
      if (reading_ != nullptr) reading_->TryCancel();
    }
  }
  if (thread_.joinable()) thread_.join();
}

void FramePreview::Work() {
  while (true) {
    int frame = 0;
    {
      absl::MutexLock lock(&mutex_);
      const auto news = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return wanted_ || finishing_; };
      mutex_.Await(absl::Condition(&news));
      if (!wanted_) return;
      frame = *std::exchange(wanted_, std::nullopt);
      showing_ = frame;
    }
    const bool to_its_end = Read(frame);
    absl::MutexLock lock(&mutex_);
    if (!to_its_end) showing_.reset();  // The next word of this frame tries it again.
  }
}

bool FramePreview::Read(int frame) {
  TerminalPicture picture(grid_, size_.columns, size_.rows, coarse_);
  grpc::ClientContext context;
  Interrupt::Guard guard(connection_.options().interrupt, [&context] { context.TryCancel(); });
  {
    absl::MutexLock lock(&mutex_);
    reading_ = &context;
    if (hurrying_) context.TryCancel();
  }
  v1::TilesRequest request;
  request.set_job_id(job_id_);
  request.set_frame(frame);
  request.set_side(uint32_t(picture.tile_side()));
  const auto reader = connection_.jobs().ReadTiles(&context, request);
  absl::Time drawn = absl::InfinitePast();
  v1::TileUpdate update;
  while (reader->Read(&update)) {
    for (const v1::TilePicture& tile : update.tiles()) {
      picture.SetTile(tile.tile(), {tile.rgba().data(), size_t(tile.rgba_size())});
    }
    if (absl::Now() - drawn < kBetweenPictures) continue;
    on_picture_(picture.Lines());
    drawn = absl::Now();
  }
  const bool to_its_end = reader->Finish().ok();
  {
    absl::MutexLock lock(&mutex_);
    reading_ = nullptr;
  }
  on_picture_(picture.Lines());
  return to_its_end;
}

}  // namespace shutterline::client
