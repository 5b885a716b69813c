#include "worker/engine/render/pair_shader.h"

#include <absl/container/flat_hash_map.h>

#include <memory>

namespace shutterline::engine {

/// Points that wait until there are enough of a primitive to be shaded together.
class PairShader::Waiting {
 public:
  Waiting(const BatchShader& batches, TexelShader::Lately& lately, std::vector<Shaded>& shaded)
      : batches_(batches), lately_(lately), shaded_(shaded) {}

  void Add(uint32_t primitive, const BatchShader::Point& point, uint32_t number) {
    Queue& queue = Of(primitive);
    queue.points[queue.count] = point;
    queue.numbers[queue.count++] = number;
    if (queue.count == SurfaceBatch::kMost) Shade(queue);
  }

  void Finish() {
    for (Queue& queue : queues_) Shade(queue);
    queues_.clear();
    queue_of_.clear();
  }

 private:
  /// More primitives than a tile mostly shows; others may have a million.
  static constexpr size_t kMostQueues = 64;

  struct Queue {
    uint32_t primitive = 0;
    size_t count = 0;
    SurfaceBatch::Array<BatchShader::Point> points;
    SurfaceBatch::Array<uint32_t> numbers;  ///< Of their pairs.
  };

  Queue& Of(uint32_t primitive) {
    // Neighbours mostly see the same one.
    if (last_ < queues_.size() && queues_[last_].primitive == primitive) return queues_[last_];
    if (queues_.size() == kMostQueues && !queue_of_.contains(primitive)) Finish();
    const auto [place, is_new] = queue_of_.try_emplace(primitive, queues_.size());
    if (is_new) queues_.emplace_back().primitive = primitive;
    last_ = place->second;
    return queues_[last_];
  }

  void Shade(Queue& queue) {
    if (queue.count == 0) return;
    if (desk_ == nullptr) desk_ = std::make_unique<BatchShader::Desk>();
    SurfaceBatch::Array<V3f> radiance;
    const size_t count = queue.count;
    batches_.Shade(queue.primitive, {queue.points.data(), count}, lately_, *desk_, {radiance.data(), count});
    for (size_t i = 0; i < count; ++i) shaded_[queue.numbers[i]].radiance = radiance[i];
    queue.count = 0;
  }

  const BatchShader& batches_;
  TexelShader::Lately& lately_;
  std::vector<Shaded>& shaded_;
  std::unique_ptr<BatchShader::Desk> desk_;  // Where something is shaded.
  std::vector<Queue> queues_;
  absl::flat_hash_map<uint32_t, size_t> queue_of_;  // By primitive.
  size_t last_ = 0;
};

std::vector<Shaded> PairShader::ShadeAll(const PairWeights& pairs, RenderStats& stats) const {
  std::vector<Shaded> shaded(size_t{pairs.Count()} + 1);
  TexelShader::Lately lately(shader_);
  Waiting waiting(batches_, lately, shaded);
  for (uint32_t number = 1; number <= pairs.Count(); ++number) {
    const PixelPair& pair = pairs.Pair(number);
    const uint32_t primitive = shader_.frame().triangles[pair.triangle].primitive;
    if (!traits_[primitive].needs_position) {
      shaded[number] = shader_.ShadeFully(pair.triangle, {}, {});
      continue;
    }
    const Barycentric at{pair.b1 / double(pair.weight), pair.b2 / double(pair.weight)};
    if (batches_.Takes(primitive)) {
      waiting.Add(primitive, {pair.triangle, at}, number);
    } else {
      shaded[number] = texels_.Shade(pair.triangle, at, pair.MiddleTime(), lately, stats);
    }
  }
  waiting.Finish();
  stats.pairs += int64_t(pairs.Count());
  return shaded;
}

}  // namespace shutterline::engine
