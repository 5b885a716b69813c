#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "common/image/image.h"
#include "common/job/render_settings.h"
#include "common/math/spaces.h"

namespace shutterline {

/// A frame rate as EXR stores it: numerator / denominator frames a second.
struct FrameRate {
  int numerator = 24;
  unsigned denominator = 1;

  friend bool operator==(const FrameRate&, const FrameRate&) = default;
};

/// The exact rate meant by a decimal one: 23.976 is 24000/1001, 24 is 24/1. `fps` is finite and > 0.
FrameRate FrameRateOf(double fps);

/// Where a picture's camera was, as OpenEXR has it, for row vectors.
struct CameraMatrices {
  M44d world_to_camera;  ///< Left-handed: x to the right, y up, z the way that the camera looks.
  /// Divided by w: x and y are 0 at the picture's upper left corner and 1 at the lower right one.
  M44d world_to_ndc;
};

/// What an EXR's header says of the frame besides its pixels. Absent values are not written; nothing else
/// is, so equal pixels and equal metadata give equal bytes.
struct ExrMetadata {
  float pixel_aspect_ratio = 1;
  std::optional<FrameRate> frames_per_second;
  std::string capture_date;             ///< capDate, local time "YYYY:MM:DD hh:mm:ss"; empty: not written.
  std::optional<M44d> world_to_camera;  ///< Of CameraMatrices; stored as floats.
  std::optional<M44d> world_to_ndc;     ///< Likewise.
  /// Our own attributes by name ("shutterline:settings", "shutterline:build", "shutterline:scene"). Names
  /// are 1 to 255 bytes without NUL and none of those that the format reserves. When read: every string
  /// attribute of the file, capDate apart.
  std::map<std::string, std::string> strings;
};

/// Bounds on what a file may make us allocate, checked against its header.
struct ExrLimits {
  uint64_t max_file_bytes = uint64_t{4} << 30;
  int max_side = kMaxFrameSide;             ///< Pixels, of data window, display window and tiles.
  int max_channels = 256;                   ///< In the file.
  uint64_t max_values = uint64_t{1} << 29;  ///< Pixels × channels (of 4 bytes each).
};

/// The first part of an EXR, scanlines or tiles (of a pyramid its largest level), every channel converted
/// from half, float or uint to float. Channels R, G, B, A come first and in this order, where the file has
/// them, then the others in the file's (alphabetical) order.
///
/// The image covers the display window: pixels outside the data window are 0, and pixels of the data
/// window outside the display window are left out.
///
/// INVALID_ARGUMENT where the bytes are no whole and sound EXR, or hold deep data or subsampled channels;
/// RESOURCE_EXHAUSTED where a limit is exceeded. `name` is for messages. `metadata`, where not null, gets
/// the header's. Thread-safe.
absl::StatusOr<Image> DecodeExr(absl::string_view bytes, const std::string& name,
                                ExrMetadata* metadata = nullptr, const ExrLimits& limits = {});

/// DecodeExr of a file; NOT_FOUND and the like where it cannot be read.
absl::StatusOr<Image> ReadExr(const std::string& path, ExrMetadata* metadata = nullptr,
                              const ExrLimits& limits = {});

/// Lets `threads` threads compress what EncodeExr writes: one pool that the whole process shares. Without it,
/// or with 0, the caller alone does. For a program's start: not thread-safe, and no encoding may be going on.
void SetExrThreads(int threads);

/// A tiled EXR of kTileSize × kTileSize tiles, one level, all the image's channels in one pixel type, but
/// those that `exact` names, which are 32-bit floats in any case.
///
/// Deterministic: equal arguments give equal bytes on machines of one instruction set (DWAA rounds as the
/// machine's vector unit does). Half: finite values beyond ±65504 become ±65504, so that no finite picture
/// turns infinite. INVALID_ARGUMENT where the image is empty, has no channel or twice the same, or where
/// metadata breaks its rules. Takes memory of the file's size beside the image. Thread-safe.
absl::StatusOr<std::string> EncodeExr(const Image& image, const OutputSettings& output,
                                      const ExrMetadata& metadata, std::span<const std::string> exact = {});

/// EncodeExr into a file, atomically (see WriteFileAtomically).
absl::Status WriteExr(const std::string& path, const Image& image, const OutputSettings& output,
                      const ExrMetadata& metadata);

}  // namespace shutterline
