# -DSHUTTERLINE_SANITIZE=address,undefined or thread; the presets `asan` and `tsan` set it.
if(SHUTTERLINE_SANITIZE)
  add_compile_options(-fsanitize=${SHUTTERLINE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SHUTTERLINE_SANITIZE})
endif()
