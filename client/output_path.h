#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>

namespace shutterline::client {

/// Where a job's frames go: a path that ends in ".exr" and may hold one run of #s in its file name, which
/// stands for the frame's number, padded with zeros to at least the run's width ("out.####.exr" is
/// "out.0007.exr" for frame 7, "out.-003.exr" for frame -3).
///
/// A path without #s names one frame. Where there are several, ".NNNN" goes before the extension, so
/// that "out.exr" writes "out.0001.exr", "out.0002.exr", ...
class OutputPath {
 public:
  /// INVALID_ARGUMENT, saying what is allowed, for a path that is empty, names a folder, starts with a
  /// dash, does not end in ".exr", holds a zero byte, or has more than one run of #s in its file name.
  static absl::StatusOr<OutputPath> Parse(absl::string_view text);

  /// The file of `frame`, one of `frame_count` frames.
  std::string FrameFile(int64_t frame, int64_t frame_count) const;

  /// The path of the 8-bit preview beside an EXR: "x.exr" -> "x.png".
  static std::string PreviewOf(absl::string_view exr_path);

  const std::string& text() const { return text_; }

 private:
  std::string text_;
  size_t hash_begin_ = 0;  ///< Where the run of #s starts in text_.
  size_t hash_count_ = 0;  ///< Its length; 0: there is none.
};

/// The file that a scene's frames go to where -o is not given: "dir/fox.glb" -> "fox.exr", in the working
/// folder.
std::string DefaultOutput(absl::string_view scene_path);

}  // namespace shutterline::client
