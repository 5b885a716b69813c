#include "client/scene_reading.h"

#include <absl/strings/str_cat.h>

#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "client/scene_source.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

absl::StatusOr<SceneFiles> ReadAll(const std::string& scene, const std::string& environment,
                                   const std::atomic<bool>& stop) {
  try {
    SL_ASSIGN_OR_RETURN(std::unique_ptr<engine::AssetSource> source, OpenSceneSource(scene, environment));
    return SceneFiles::Read(std::move(source), SceneFiles::Limits(), &stop);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat("load scene ", scene, ": out of memory"));
  }
}

}  // namespace

SceneReading::SceneReading(const JobOptions& options, Interrupt* interrupt)
    : guard_(interrupt, [this] { stop_ = true; }) {
  const auto read = [this, scene = options.scene, environment = options.environment] {
    return ReadAll(scene, environment, stop_);
  };
  try {
    scene_ = std::async(std::launch::async, read);
  } catch (const std::system_error&) {  // No more threads: whoever wants it reads it.
    scene_ = std::async(std::launch::deferred, read);
  }
}

}  // namespace shutterline::client
