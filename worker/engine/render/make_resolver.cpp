#include "worker/engine/render/make_resolver.h"

#include "common/base/check.h"
#include "worker/engine/paper/resolver_paper.h"
#include "worker/engine/slice/resolver_slice.h"

namespace shutterline::engine {

std::unique_ptr<const Resolver> MakeResolver(const RenderSettings& settings) {
  switch (settings.resolver) {
    case ResolverKind::kSlice:
      return std::make_unique<ResolverSlice>(settings);
    case ResolverKind::kPaper:
      return std::make_unique<ResolverPaper>(LinePattern::Get(settings.pattern),
                                             paper::Options{.time_cells = settings.time_cells});
  }
  SL_CHECK(false);
  return nullptr;
}

}  // namespace shutterline::engine
