# -DSHUTTERLINE_SANITIZE=address,undefined or thread; the presets `asan` and `tsan` set it.
if(SHUTTERLINE_SANITIZE)
  add_compile_options(-fsanitize=${SHUTTERLINE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SHUTTERLINE_SANITIZE})
  if(SHUTTERLINE_SANITIZE MATCHES "undefined")
    # A fifth of the time to compile, for what a fault at address 0 and the address sanitizer find as well.
    add_compile_options(-fno-sanitize=null,vptr,object-size)
  endif()
endif()

# Tests need no optimizer under sanitizers: it doubles the time to compile them, and what they run is the library.
function(compile_test_for_sanitizers target)
  if(SHUTTERLINE_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()
