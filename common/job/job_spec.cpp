#include "common/job/job_spec.h"

#include <absl/container/flat_hash_set.h>
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <bit>

#include "common/base/status_macros.h"
#include "common/job/tile.h"

namespace shutterline {
namespace {

absl::Status Invalid(absl::string_view field, absl::string_view reason) {
  return absl::InvalidArgumentError(absl::StrCat(field, ": ", reason));
}

absl::Status CheckName(absl::string_view field, absl::string_view value, const JobLimits& limits) {
  if (int64_t(value.size()) <= limits.max_name_bytes) return absl::OkStatus();
  return Invalid(
      field, absl::StrCat("has ", value.size(), " bytes, but at most ", limits.max_name_bytes, " may be"));
}

absl::Status ValidateScene(const SceneManifest& scene, const JobLimits& limits) {
  if (scene.files.empty()) return Invalid("scene.files", "is empty");
  if (int64_t(scene.files.size()) > limits.max_manifest_files) {
    return Invalid("scene.files", absl::StrCat("has ", scene.files.size(), " entries, but at most ",
                                               limits.max_manifest_files, " may be"));
  }
  absl::flat_hash_set<absl::string_view> names;
  for (size_t i = 0; i < scene.files.size(); ++i) {
    const std::string field = absl::StrCat("scene.files[", i, "].name");
    SL_RETURN_IF_ERROR(CheckName(field, scene.files[i].name, limits));
    SL_RETURN_IF_ERROR(Annotate(ValidateRelativeName(scene.files[i].name), field));
    if (!names.insert(scene.files[i].name).second) {
      return Invalid(field, absl::StrCat("'", absl::CHexEscape(scene.files[i].name), "' occurs twice"));
    }
  }
  if (!names.contains(scene.root_name)) {
    return Invalid("scene.root_name", absl::StrCat("'", absl::CHexEscape(scene.root_name.substr(0, 200)),
                                                   "' is not among scene.files"));
  }
  return absl::OkStatus();
}

absl::Status ValidateFrames(const JobSpec& spec, const JobLimits& limits) {
  const FrameRange& frames = spec.frames;
  if (frames.step < 1)
    return Invalid("frames.step", absl::StrCat("is ", frames.step, ", but must be at least 1"));
  if (frames.last < frames.first) {
    return Invalid("frames.last", absl::StrCat("is ", frames.last, ", but must be at least frames.first (",
                                               frames.first, ")"));
  }
  if (frames.Count() > limits.max_frames) {
    return Invalid("frames", absl::StrCat("are ", frames.Count(), " frames, but a job may have at most ",
                                          limits.max_frames));
  }
  const int64_t tiles = frames.Count() * TileGrid{spec.render.width, spec.render.height}.Count();
  if (tiles > limits.max_tiles) {
    return Invalid("frames", absl::StrCat(frames.Count(), " frames of ", spec.render.width, "×",
                                          spec.render.height, " pixels are ", tiles,
                                          " tiles, but a job may have at most ", limits.max_tiles));
  }
  return absl::OkStatus();
}

/// Appends values so that no two different sequences of values give the same bytes.
class CanonicalWriter {
 public:
  void Number(uint64_t value) {
    for (int shift = 0; shift < 64; shift += 8) stream_.push_back(char(value >> shift & 0xff));
  }
  void Signed(int64_t value) { Number(uint64_t(value)); }
  /// -0 counts as 0: they give equal pictures.
  void Real(double value) { Number(std::bit_cast<uint64_t>(value == 0 ? 0.0 : value)); }
  void Text(absl::string_view text) {
    Number(text.size());
    stream_.append(text.data(), text.size());
  }
  void Bytes(const Digest& digest) {
    stream_.append(reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size());
  }
  Digest Finish() const { return Sha256(stream_); }

 private:
  std::string stream_;
};

}  // namespace

const SceneFile* SceneManifest::Find(absl::string_view name) const {
  const auto found =
      std::find_if(files.begin(), files.end(), [&](const SceneFile& f) { return f.name == name; });
  return found == files.end() ? nullptr : &*found;
}

std::optional<int64_t> FrameRange::IndexOf(int frame) const {
  if (frame < first || frame > last || (int64_t{frame} - first) % step != 0) return std::nullopt;
  return (int64_t{frame} - first) / step;
}

absl::Status ValidateRelativeName(absl::string_view name) {
  const auto refuse = [&](absl::string_view reason) {
    return absl::InvalidArgumentError(
        absl::StrCat("file name '", absl::CHexEscape(name.substr(0, 200)), "' ", reason));
  };
  if (name.empty()) return refuse("is empty");
  if (name.front() == '/') return refuse("is absolute");
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return refuse("has a control character");
    if (c == '\\') return refuse("has a backslash");
  }
  for (const absl::string_view part : absl::StrSplit(name, '/')) {
    if (part.empty()) return refuse("has an empty part");
    if (part == "." || part == "..") return refuse("has a part '.' or '..'");
  }
  return absl::OkStatus();
}

absl::Status Validate(const JobSpec& spec, const JobLimits& limits) {
  SL_RETURN_IF_ERROR(CheckName("name", spec.name, limits));
  SL_RETURN_IF_ERROR(CheckName("render.camera", spec.render.camera, limits));
  SL_RETURN_IF_ERROR(CheckName("render.animation", spec.render.animation, limits));
  SL_RETURN_IF_ERROR(Validate(spec.render));
  if (!spec.render.mattes.empty() && spec.output.compression == ExrCompression::kDwaa) {
    return Invalid("output.compression", "dwaa would damage the ids of render.mattes: choose another");
  }
  SL_RETURN_IF_ERROR(ValidateFrames(spec, limits));
  return ValidateScene(spec.scene, limits);
}

Digest PictureKey(const SceneManifest& scene, const RenderSettings& render) {
  CanonicalWriter writer;
  writer.Text("shutterline picture 5");  // Changes with this encoding.
  writer.Text(scene.root_name);
  std::vector<SceneFile> files = scene.files;
  std::sort(files.begin(), files.end(),
            [](const SceneFile& a, const SceneFile& b) { return a.name < b.name; });
  writer.Number(files.size());
  for (const SceneFile& file : files) {
    writer.Text(file.name);
    writer.Bytes(file.digest);
    writer.Number(file.size);
  }
  writer.Signed(render.width);
  writer.Signed(render.height);
  writer.Real(render.fps);
  writer.Real(render.shutter_open);
  writer.Real(render.shutter_close);
  writer.Number(render.shutter_curve.size());
  for (const ShutterPoint& point : render.shutter_curve) {
    writer.Real(point.time);
    writer.Real(point.opening);
  }
  writer.Text(render.camera);
  writer.Text(render.animation);
  writer.Signed(render.motion_degree ? int64_t{*render.motion_degree} : -1);
  writer.Signed(render.motion_pieces ? int64_t{*render.motion_pieces} : -1);
  writer.Text(ToString(render.lighting));
  for (const double radiance : render.ambient) writer.Real(radiance);
  writer.Number(render.occlusion ? 1 : 0);
  if (render.occlusion) {
    writer.Signed(render.occlusion->lines);
    writer.Real(render.occlusion->radius.value_or(-1));
    writer.Text(ToString(render.occlusion->falloff));
    writer.Text(ToString(render.occlusion->pattern));
    writer.Number(render.occlusion->motion ? 1 : 0);
  }
  writer.Text(ToString(render.integrator));
  writer.Text(ToString(render.pattern));
  writer.Text(ToString(render.resolver));
  writer.Real(render.time_step);
  writer.Signed(render.time_samples ? int64_t{*render.time_samples} : -1);
  writer.Real(render.target_error.value_or(-1));
  writer.Signed(render.time_cells);
  writer.Signed(render.spp);
  writer.Number(render.seed);
  writer.Text(ToString(render.reference_layout));
  writer.Real(render.shading_rate.value_or(-1));
  writer.Number(render.cache_propagate ? 1 : 0);
  writer.Number(render.aovs.size());
  for (const Aov aov : render.aovs) writer.Text(ToString(aov));
  writer.Number(render.mattes.size());
  for (const Matte matte : render.mattes) writer.Text(ToString(matte));
  writer.Signed(render.matte_ranks);
  // What is the same picture has the same name: a radius that is left out is the filter's own.
  writer.Text(ToString(render.filter));
  writer.Real(FilterRadius(render));
  return writer.Finish();
}

}  // namespace shutterline
