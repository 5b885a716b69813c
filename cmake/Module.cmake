# add_module(NAME n [APART] SRCS a.cpp ... HDRS a.h ... DEPS modules ... LIBS third parties ...)
#
# DEPS name modules of ours, LIBS libraries of others; a module may include only its own headers and
# those of its DEPS (not of their DEPS), which the `layers` test checks against the manifest written by
# write_module_manifest(). A module usually is a folder; several may share one, because the manifest says
# which file belongs to which module. Every source and header of ours belongs to exactly one.
define_property(GLOBAL PROPERTY SHUTTERLINE_MODULES)

# With SHUTTERLINE_UNITY several sources of a module are compiled at once, which halves the time of a whole build:
# names in their unnamed namespaces must then differ, or the module says APART. It makes small changes slower to
# build; off for those.
option(SHUTTERLINE_UNITY "Compile several sources of a module at once" OFF)
function(compile_together target)
  if(SHUTTERLINE_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
  endif()
endfunction()

function(add_module)
  cmake_parse_arguments(M "APART" "NAME" "SRCS;HDRS;DEPS;LIBS" ${ARGN})
  if(M_SRCS)
    add_library(${M_NAME} STATIC ${M_SRCS} ${M_HDRS})
    target_include_directories(${M_NAME} PUBLIC "${PROJECT_SOURCE_DIR}")
    target_link_libraries(${M_NAME} PUBLIC ${M_DEPS} ${M_LIBS} PRIVATE shutterline_warnings)
    use_precompiled(${M_NAME})
    if(NOT M_APART)
      compile_together(${M_NAME})
    endif()
  else()
    add_library(${M_NAME} INTERFACE ${M_HDRS})
    target_include_directories(${M_NAME} INTERFACE "${PROJECT_SOURCE_DIR}")
    target_link_libraries(${M_NAME} INTERFACE ${M_DEPS} ${M_LIBS})
  endif()
  record_module(${M_NAME} "${M_DEPS}" ${M_SRCS} ${M_HDRS})
endfunction()

# add_program(NAME n OUTPUT file-name SRCS ... DEPS ... LIBS ...). The target `programs` builds them all.
add_custom_target(programs)
function(add_program)
  cmake_parse_arguments(M "" "NAME;OUTPUT" "SRCS;DEPS;LIBS" ${ARGN})
  add_executable(${M_NAME} ${M_SRCS})
  target_include_directories(${M_NAME} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${M_NAME} PRIVATE ${M_DEPS} ${M_LIBS} shutterline_warnings)
  use_precompiled(${M_NAME})
  compile_together(${M_NAME})
  if(M_OUTPUT)
    set_target_properties(${M_NAME} PROPERTIES OUTPUT_NAME ${M_OUTPUT})
  endif()
  add_dependencies(programs ${M_NAME})
  record_module(${M_NAME} "${M_DEPS}" ${M_SRCS})
endfunction()

# record_module(name "deps" [files...]): one block of the manifest, four lines, each a key and the words that
# it holds (perhaps none). Paths are relative to the project's root; generated files are left out.
function(record_module name deps)
  file(RELATIVE_PATH folder "${PROJECT_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  set(paths)
  foreach(file ${ARGN})
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE)
    cmake_path(IS_PREFIX PROJECT_BINARY_DIR "${file}" generated)
    if(NOT generated)
      cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
      list(APPEND paths "${file}")
    endif()
  endforeach()
  list(JOIN deps " " deps)
  list(JOIN paths " " paths)
  set_property(GLOBAL APPEND PROPERTY SHUTTERLINE_MODULES
    "module ${name}\nfolder ${folder}\ndeps ${deps}\nfiles ${paths}\n")
endfunction()

function(write_module_manifest file)
  get_property(modules GLOBAL PROPERTY SHUTTERLINE_MODULES)
  list(JOIN modules "\n" text)
  file(WRITE "${file}" "${text}")
endfunction()
