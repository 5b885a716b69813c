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

# Embree 4 where it is installed, else Embree 3: `worker/engine/accel/embree.h` hides the difference.
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 CONFIG REQUIRED)
endif()
add_library(shutterline_embree INTERFACE)
target_link_libraries(shutterline_embree INTERFACE embree)
target_compile_definitions(shutterline_embree INTERFACE SHUTTERLINE_EMBREE_MAJOR=${embree_VERSION_MAJOR})
