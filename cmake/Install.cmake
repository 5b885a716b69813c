# `cmake --install`: programs, systemd units, shell completions and documents, where a distribution would put
# them. Honours --prefix and DESTDIR.
include(GNUInstallDirs)

install(TARGETS shutterline_program server_program shutterline_worker shutterline_scenes
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# Written by the program itself, and so never stale.
set(bash_completion "${PROJECT_BINARY_DIR}/completions/bash/shutterline")
set(zsh_completion "${PROJECT_BINARY_DIR}/completions/zsh/_shutterline")
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/completions/bash" "${PROJECT_BINARY_DIR}/completions/zsh")
add_custom_command(OUTPUT "${bash_completion}" "${zsh_completion}"
  COMMAND shutterline_program completion bash > "${bash_completion}"
  COMMAND shutterline_program completion zsh > "${zsh_completion}"
  DEPENDS shutterline_program
  COMMENT "Writing shell completions" VERBATIM)
add_custom_target(completions ALL DEPENDS "${bash_completion}" "${zsh_completion}")
add_dependencies(programs completions)
install(FILES "${bash_completion}" DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES "${zsh_completion}" DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)

# Units name the programs by full path, and the prefix may be given as late as at installation.
install(CODE "
  set(BINDIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
  set(DOCDIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR}\")
  foreach(unit shutterline-server.service shutterline-worker@.service)
    configure_file(\"${PROJECT_SOURCE_DIR}/deploy/systemd/\${unit}.in\" \"${PROJECT_BINARY_DIR}/units/\${unit}\" @ONLY)
    file(INSTALL \"${PROJECT_BINARY_DIR}/units/\${unit}\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib/systemd/system\")
  endforeach()")
install(FILES deploy/systemd/shutterline.sysusers DESTINATION lib/sysusers.d RENAME shutterline.conf)
install(FILES deploy/systemd/shutterline.tmpfiles DESTINATION lib/tmpfiles.d RENAME shutterline.conf)

# As in the source tree, so that documents find each other.
install(FILES README.md CHANGELOG.md LICENSE NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY deploy/docker deploy/kubernetes deploy/openjd deploy/slurm deploy/systemd
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/deploy USE_SOURCE_PERMISSIONS
  PATTERN "*.in" EXCLUDE PATTERN "test" EXCLUDE PATTERN "*.sysusers" EXCLUDE PATTERN "*.tmpfiles" EXCLUDE)
