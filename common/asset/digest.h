#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <string>

namespace shutterline {

/// A SHA-256: the address of a blob. Ordered and hashable; written as 64 lower-case hex digits.
struct Digest {
  std::array<uint8_t, 32> bytes{};

  std::string ToHex() const;
  /// INVALID_ARGUMENT unless `hex` is 64 hex digits.
  static absl::StatusOr<Digest> FromHex(absl::string_view hex);

  friend auto operator<=>(const Digest&, const Digest&) = default;
  template <typename H>
  friend H AbslHashValue(H state, const Digest& digest) {
    return H::combine(std::move(state), digest.bytes);
  }
};

/// SHA-256 of `data`.
Digest Sha256(absl::string_view data);

/// SHA-256 of data that comes in pieces: Update* Finish. Not thread-safe; Finish may be called once.
class Sha256Stream {
 public:
  Sha256Stream();
  ~Sha256Stream();
  Sha256Stream(const Sha256Stream&) = delete;
  Sha256Stream& operator=(const Sha256Stream&) = delete;

  void Update(absl::string_view piece);
  Digest Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace shutterline
