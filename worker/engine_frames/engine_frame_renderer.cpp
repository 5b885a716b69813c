#include "worker/engine_frames/engine_frame_renderer.h"

#include <absl/strings/str_cat.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/gltf_import.h"

namespace shutterline::worker {
namespace {

/// Calls `f`, whose result is a Status or a StatusOr, and turns what it throws into a status.
template <typename F>
auto WithoutExceptions(absl::string_view doing, F&& f) -> decltype(f()) {
  try {
    return f();
  } catch (const WorkLimit::Exceeded& exceeded) {
    return TookTooLong(doing, exceeded);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat(doing, ": out of memory"));
  } catch (const std::exception& e) {
    return absl::InternalError(absl::StrCat(doing, ": ", e.what()));
  } catch (...) {
    return absl::InternalError(absl::StrCat(doing, ": unknown exception"));
  }
}

class EngineFrameRenderer final : public FrameRenderer {
 public:
  explicit EngineFrameRenderer(std::unique_ptr<engine::TileIntegrator> integrator)
      : integrator_(std::move(integrator)) {}

  absl::Status Render(const TileRect& rect, std::span<float> pixels,
                      engine::RenderStats& stats) const override {
    return WithoutExceptions("render tile", [&] {
      integrator_->Render(rect, pixels, stats);
      return absl::OkStatus();
    });
  }

 private:
  const std::unique_ptr<engine::TileIntegrator> integrator_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<const engine::Scene>> EngineFrameRendererFactory::Import(
    const engine::AssetSource& source) {
  const WorkLimit limit(clock_, time_);
  const WorkLimitScope scope(&limit);
  return WithoutExceptions(absl::StrCat("load scene ", source.RootName()),
                           [&] { return engine::ImportGltf(source); });
}

absl::StatusOr<std::shared_ptr<const FrameRenderer>> EngineFrameRendererFactory::MakeFrame(
    std::shared_ptr<const engine::Scene> scene, int frame, const RenderSettings& settings, int threads) {
  using Result = absl::StatusOr<std::shared_ptr<const FrameRenderer>>;
  const WorkLimit limit(clock_, time_);
  const auto make = [&]() -> Result {
    const WorkLimitScope scope(&limit);
    SL_ASSIGN_OR_RETURN(auto frame_scene, engine::BuildFrameScene(std::move(scene), frame, settings));
    SL_ASSIGN_OR_RETURN(auto integrator,
                        engine::MakeTileIntegrator(std::move(frame_scene), frame, settings, threads, cache_));
    return std::make_shared<const EngineFrameRenderer>(std::move(integrator));
  };
  // Tasks of the steps stay on so many threads; more than processors would only make TBB complain.
  return WithoutExceptions("make frame ready", [&] {
    tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
    return arena.execute(make);
  });
}

}  // namespace shutterline::worker
