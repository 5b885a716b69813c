#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <string>

#include "shutterline/v1/workers.pb.h"

namespace shutterline {

/// What TakeReport makes of the tiles of a v1::ResultBatch: nothing but pixels or a failure, of bounded
/// length, text that goes back into messages, statistics that add up. Returns what is broken, or nothing.
std::string CheckResultBytes(const std::string& bytes);

/// CheckResultBytes of a mutant that `seed` makes of a valid batch.
std::string FuzzTileResult(uint64_t seed);

/// A batch of a few tiles of the job, that nothing is wrong with.
v1::ResultBatch ValidBatch(const std::string& job_id, std::mt19937_64& random);

/// A coordinator with a job of many frames that takes mutants over a real PushResults stream. Every outcome
/// is compared with what the rules of workers.proto say about that tile, and the coordinator must live on.
class ResultStreamFuzzer {
 public:
  ResultStreamFuzzer();
  ~ResultStreamFuzzer();

  /// Not a function of the seed alone: tiles that came before count.
  std::string Fuzz(uint64_t seed);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace shutterline
