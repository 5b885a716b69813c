# Targets for people: `format` rewrites the sources, `tidy` runs clang-tidy over what this build compiles.
add_custom_target(format COMMAND "${PROJECT_SOURCE_DIR}/cmake/format.sh" USES_TERMINAL)
add_custom_target(tidy COMMAND "${PROJECT_SOURCE_DIR}/cmake/tidy.sh" "${PROJECT_BINARY_DIR}" USES_TERMINAL)
