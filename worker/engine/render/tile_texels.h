#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "common/job/render_stats.h"
#include "worker/engine/shading/texel_batch.h"
#include "worker/engine/shading/texel_shader.h"
#include "worker/engine/visibility/point_colors.h"

namespace shutterline::engine {

/// What looking texels up needs of memory: for one thread at a time, tile after tile of one frame.
struct TexelDesk {
  static constexpr uint64_t kNothing = ~uint64_t{0};  ///< Low part of a key of a triangle that no frame has.
  /// A texel that was seen lately: the whole cache is larger than a processor's.
  struct Near {
    TexelKey key{.low = kNothing};
    V3f radiance;
  };
  static constexpr int kNearLog2 = 13;  ///< 256 KiB.

  std::vector<Near> near;  ///< See TileTexels::NearOf; empty where there is no cache.

  // Of a tile.
  absl::flat_hash_map<uint32_t, uint32_t> number_of;  ///< By triangle of the frame.
  std::vector<TexelShader::Triangle> triangles;
  /// Of those whose levels are the same all over: what their texels' keys and places near have in common.
  struct Even {
    bool is_even = false;
    int level2 = 0;
    uint64_t key_low = 0;
    uint32_t corner = 0;
  };
  std::vector<Even> even;  ///< By number of the triangle.

  // Points that are wanted.
  struct Wanted {
    uint32_t prepared;
    double weight;
    PointColors::Color* sum;
  };
  TexelBatch batch;
  TexelBatch::Array<Wanted> wanted;
  TexelBatch::Array<V3f> radiance;
  TexelBatch::Array<TexelKey> keys;
  TexelBatch::Array<uint32_t> missed;  ///< Numbers of those that are not near.
  /// Under a filter, what the columns around take of each; `weight` is not used then.
  std::vector<LineSpread::Weights> spreads;
};

/// Desks of a frame that nobody uses at the moment. Thread-safe.
class TexelDesks {
 public:
  std::unique_ptr<TexelDesk> Take();
  void Give(std::unique_ptr<TexelDesk> desk);

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<TexelDesk>> free_;
};

/// The texels that a tile sees, with what their triangles have in common. One a tile and thread.
class TileTexels final : public PointColors {
 public:
  /// All must outlive it.
  TileTexels(const TexelShader& shader, TexelDesks& desks, RenderStats& stats);
  ~TileTexels() override { desks_.Give(std::move(desk_)); }
  TileTexels(const TileTexels&) = delete;

  bool Has(uint32_t triangle) const override { return shader_.HasTexels(triangle); }
  std::optional<V3f> ColorOfAll(uint32_t triangle) override;
  uint32_t Prepare(uint32_t triangle) override;
  V3f At(uint32_t prepared, double b1, double b2) override;
  void AddAlong(uint32_t prepared, const LinePosition& position, const Piece& piece, double weight,
                Color* sums_of_line) override;
  void SpreadAlong(uint32_t prepared, const LinePosition& position, const Piece& piece, double weight,
                   const LineSpread& spread, Color* sums_of_line) override;
  void Finish() override;

 private:
  const TexelShader::Triangle& Known(uint32_t triangle);
  V3f RadianceOf(const TexelShader::Triangle& triangle, const Texel& texel, const TexelKey& key);
  TexelDesk::Near& NearOf(uint32_t triangle, const Texel& texel);
  /// The radiance of wanted points that are near; the others are missed.
  void LookNear();
  void LookNear(size_t k, const TexelKey& key, uint32_t place);
  Texel TexelOf(size_t k) const;
  /// Without a cache.
  V3f ShadeWanted(size_t k);
  void AddWanted();

  const TexelShader& shader_;
  TexelDesks& desks_;
  RenderStats& stats_;
  std::unique_ptr<TexelDesk> desk_;
  TexelShader::Triangle last_;  ///< That was asked for.
  bool knows_last_ = false;
  size_t missed_ = 0;
  size_t taps_ = 0;  ///< Of those that are wanted under a filter; 0: there is none.
};

}  // namespace shutterline::engine
