#pragma once

#include <cstdio>
#include <cstdlib>

/// Invariants of our own: a failed SL_CHECK is a defect in this program, never bad input. Prints the
/// condition with its place and aborts, in every build type.
#define SL_CHECK(condition)                                                              \
  do {                                                                                   \
    if (!(condition)) {                                                                  \
      std::fprintf(stderr, "%s:%d: check failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                      \
    }                                                                                    \
  } while (false)
