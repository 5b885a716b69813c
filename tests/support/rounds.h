#pragma once

namespace shutterline {

/// How many rounds of a random test to run: an eighth, and one at least, under a sanitizer, which looks at
/// memory and needs no statistics, and takes ten times as long.
constexpr int Rounds(int rounds) {
#ifdef SHUTTERLINE_SANITIZED
  return rounds < 8 ? 1 : rounds / 8;
#else
  return rounds;
#endif
}

}  // namespace shutterline
