#include "client/output_path.h"

#include <absl/status/status.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <filesystem>

namespace shutterline::client {
namespace {

constexpr absl::string_view kExtension = ".exr";
constexpr size_t kInsertedDigits = 4;

std::string Padded(int64_t frame, size_t width) {
  const bool negative = frame < 0;
  std::string digits = absl::StrCat(negative ? -frame : frame);
  const size_t sign = negative ? 1 : 0;
  if (digits.size() + sign < width) digits.insert(0, width - sign - digits.size(), '0');
  return negative ? absl::StrCat("-", digits) : digits;
}

}  // namespace

absl::StatusOr<OutputPath> OutputPath::Parse(absl::string_view text) {
  if (text.empty()) return absl::InvalidArgumentError("must name a file");
  if (text.find('\0') != absl::string_view::npos) {
    return absl::InvalidArgumentError("must not hold a zero byte");
  }
  if (text.front() == '-') {
    return absl::InvalidArgumentError("must not start with a dash; write ./- for such a file");
  }
  const size_t slash = text.rfind('/');
  const size_t name_begin = slash == absl::string_view::npos ? 0 : slash + 1;
  const absl::string_view name = text.substr(name_begin);
  if (name.size() <= kExtension.size() || !absl::EndsWithIgnoreCase(name, kExtension)) {
    return absl::InvalidArgumentError("must name a file that ends in .exr, as in out.exr or out.####.exr");
  }
  OutputPath path;
  path.text_ = std::string(text);
  const size_t first = name.find('#');
  if (first != absl::string_view::npos) {
    size_t end = first;
    while (end < name.size() && name[end] == '#') ++end;
    if (name.find('#', end) != absl::string_view::npos) {
      return absl::InvalidArgumentError("must have its #s in one place, as in out.####.exr");
    }
    path.hash_begin_ = name_begin + first;
    path.hash_count_ = end - first;
  }
  return path;
}

std::string OutputPath::FrameFile(int64_t frame, int64_t frame_count) const {
  std::string file = text_;
  if (hash_count_ > 0) return file.replace(hash_begin_, hash_count_, Padded(frame, hash_count_));
  if (frame_count <= 1) return file;
  return file.insert(file.size() - kExtension.size(), absl::StrCat(".", Padded(frame, kInsertedDigits)));
}

std::string OutputPath::PreviewOf(absl::string_view exr_path) {
  return absl::StrCat(exr_path.substr(0, exr_path.size() - kExtension.size()), ".png");
}

std::string DefaultOutput(absl::string_view scene_path) {
  std::string stem = std::filesystem::path(std::string(scene_path)).stem().string();
  // A scene called "-x.glb" or "#.glb" must still give a path that Parse takes.
  for (char& c : stem) {
    if (c == '#') c = '_';
  }
  const bool plain = !stem.empty() && stem.front() != '-';
  return absl::StrCat(plain ? "" : "_", stem, kExtension);
}

}  // namespace shutterline::client
