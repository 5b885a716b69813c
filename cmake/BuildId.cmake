# The engine's build id: version and commit. Coordinator and workers compare it at registration.
execute_process(COMMAND git -C "${PROJECT_SOURCE_DIR}" describe --always --dirty --abbrev=12
  OUTPUT_VARIABLE SHUTTERLINE_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT SHUTTERLINE_COMMIT)
  set(SHUTTERLINE_COMMIT "unknown")
endif()
configure_file("${PROJECT_SOURCE_DIR}/common/base/build_id.h.in"
  "${PROJECT_BINARY_DIR}/generated/common/base/build_id.h" @ONLY)
