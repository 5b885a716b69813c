# Every library that Shutterline uses, in one place. Debian package names are in deploy/packages.txt.
find_package(Threads REQUIRED)
find_package(absl REQUIRED)
find_package(Protobuf REQUIRED)
find_package(gRPC CONFIG REQUIRED)
find_package(Imath CONFIG REQUIRED)
find_package(OpenEXR CONFIG REQUIRED)
find_package(PNG REQUIRED)
find_package(spdlog CONFIG REQUIRED)
find_package(TBB CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(hwy CONFIG REQUIRED)  # Highway: vectors with dispatch at run time.
# Each instruction set is one more copy of the vector code to compile: AVX-512, AVX2, and one that runs anywhere, as what lies
# between is rare today; under sanitizers, where the copies have nothing new to show, AVX2 and that.
if(SHUTTERLINE_SANITIZE)
  add_compile_definitions("HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3|HWY_AVX3_DL)")
else()
  add_compile_definitions("HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4)")
endif()

# Embree 4 where it is installed, else Embree 3: `worker/engine/accel/embree.h` hides the difference.
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 CONFIG REQUIRED)
endif()
add_library(shutterline_embree INTERFACE)
target_link_libraries(shutterline_embree INTERFACE embree)
target_compile_definitions(shutterline_embree INTERFACE SHUTTERLINE_EMBREE_MAJOR=${embree_VERSION_MAJOR})

# The HTTP library as Debian builds it: the definitions that its own sources were compiled with.
find_path(SHUTTERLINE_HTTPLIB_INCLUDE httplib.h REQUIRED)
find_library(SHUTTERLINE_HTTPLIB cpp-httplib REQUIRED)
add_library(shutterline_httplib INTERFACE)
target_include_directories(shutterline_httplib SYSTEM INTERFACE "${SHUTTERLINE_HTTPLIB_INCLUDE}")
target_link_libraries(shutterline_httplib INTERFACE "${SHUTTERLINE_HTTPLIB}" OpenSSL::SSL Threads::Threads)
target_compile_definitions(shutterline_httplib INTERFACE
  CPPHTTPLIB_OPENSSL_SUPPORT CPPHTTPLIB_ZLIB_SUPPORT CPPHTTPLIB_BROTLI_SUPPORT)

# Metrics and their text format alone: the library's CMake package asks for its HTTP server's libraries, too.
find_path(SHUTTERLINE_PROMETHEUS_INCLUDE prometheus/registry.h REQUIRED)
find_library(SHUTTERLINE_PROMETHEUS prometheus-cpp-core REQUIRED)
add_library(shutterline_prometheus INTERFACE)
target_include_directories(shutterline_prometheus SYSTEM INTERFACE "${SHUTTERLINE_PROMETHEUS_INCLUDE}")
target_link_libraries(shutterline_prometheus INTERFACE "${SHUTTERLINE_PROMETHEUS}")
