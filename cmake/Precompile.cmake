# Precompiled headers: most of a source's compile time goes into reading the same libraries again. Sources still
# include what they use; -DSHUTTERLINE_PRECOMPILE=OFF builds without, to prove it.
option(SHUTTERLINE_PRECOMPILE "Precompile the headers of libraries" ON)

# ccache wants CCACHE_SLOPPINESS=pch_defines,time_macros beside this.
if(SHUTTERLINE_PRECOMPILE AND CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache")
  add_compile_options(
    "$<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>" "$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>")
endif()

# Some libraries ask for it, and all sources of a group must agree.
add_compile_options(-pthread)

# precompile(name HEADERS ... LIBS ...): a group of sources that share a precompiled header. LIBS must not define
# macros that some of the group's sources do without.
function(precompile name)
  cmake_parse_arguments(G "" "" "HEADERS;LIBS" ${ARGN})
  if(NOT SHUTTERLINE_PRECOMPILE)
    return()
  endif()
  set(source "${PROJECT_BINARY_DIR}/generated/precompiled_${name}.cpp")
  file(CONFIGURE OUTPUT "${source}" CONTENT "// Holds the precompiled header of a group of sources.\n")
  add_library(precompiled_${name} OBJECT "${source}")
  target_link_libraries(precompiled_${name} PRIVATE ${G_LIBS} shutterline_warnings)
  target_precompile_headers(precompiled_${name} PRIVATE ${G_HEADERS})
  choose_optimization(precompiled_${name} ${name})  # As those who use it.
endfunction()

set(base_headers
  <algorithm> <array> <cmath> <cstdint> <functional> <limits> <map> <memory> <numeric> <optional> <span> <string>
  <utility> <vector> <absl/status/statusor.h> <absl/strings/str_cat.h>)
set(base_libraries absl::status absl::statusor absl::strings)
set(remote_headers <grpcpp/grpcpp.h> "<shutterline/v1/jobs.grpc.pb.h>" "<shutterline/v1/blobs.grpc.pb.h>"
  "<shutterline/v1/workers.grpc.pb.h>")
set(test_headers <gmock/gmock.h> <gtest/gtest.h> <random> <set> <sstream>)

function(precompile_base_headers)
  precompile(base HEADERS ${base_headers} LIBS ${base_libraries})
endfunction()
function(precompile_remote_headers)
  precompile(remote HEADERS ${base_headers} ${remote_headers} LIBS ${base_libraries} proto_v1)
  precompile(client HEADERS ${base_headers} ${remote_headers} <CLI/CLI.hpp> <nlohmann/json.hpp>
    LIBS ${base_libraries} proto_v1 CLI11::CLI11 nlohmann_json::nlohmann_json)
endfunction()
function(precompile_test_headers)
  precompile(test HEADERS ${base_headers} ${test_headers} LIBS ${base_libraries} GTest::gtest GTest::gmock)
  precompile(remote_test HEADERS ${base_headers} ${remote_headers} ${test_headers}
    LIBS ${base_libraries} proto_v1 GTest::gtest GTest::gmock)
endfunction()

# use_precompiled(target): the header of the group that the folder belongs to.
function(use_precompiled target)
  file(RELATIVE_PATH folder "${PROJECT_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  if(folder MATCHES "^tests/(client|integration|proto|server|worker)")
    set(group remote_test)
  elseif(folder MATCHES "^tests/" AND NOT folder MATCHES "^tests/scenes")
    set(group test)
  elseif(folder MATCHES "^client")
    set(group client)
  elseif(folder MATCHES "^(proto|server|worker)" AND NOT folder MATCHES "^worker/engine")
    set(group remote)
  else()
    set(group base)
  endif()
  choose_optimization(${target} ${group})
  if(TARGET precompiled_${group})
    target_precompile_headers(${target} REUSE_FROM precompiled_${group})
    if(group MATCHES "test")
      target_compile_definitions(${target} PRIVATE GTEST_HAS_PTHREAD=1)  # As who links GoogleTest has it.
    endif()
  endif()
endfunction()
