# Warnings for our own code; generated code is exempted by `proto/CMakeLists.txt`.
add_library(shutterline_warnings INTERFACE)
target_compile_options(shutterline_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  -Wimplicit-fallthrough -Wcast-align -Wnull-dereference)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 reports null dereferences inside inlined library code that cannot happen.
  target_compile_options(shutterline_warnings INTERFACE -Wno-null-dereference)
endif()
if(SHUTTERLINE_WERROR)
  target_compile_options(shutterline_warnings INTERFACE -Werror)
endif()
# Contraction would let a compiler fuse a multiplication and an addition where it likes, and two builds
# of one frame would then differ in their last bits (see docs/decisions).
add_compile_options(-ffp-contract=off)
