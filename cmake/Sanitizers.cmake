# -DSHUTTERLINE_SANITIZE=address,undefined or thread; the presets `asan` and `tsan` set it.
if(SHUTTERLINE_SANITIZE)
  add_compile_options(-fsanitize=${SHUTTERLINE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SHUTTERLINE_SANITIZE})
  add_compile_definitions(SHUTTERLINE_SANITIZED)  # Tests run fewer rounds.
  if(SHUTTERLINE_SANITIZE MATCHES "undefined")
    # A fifth of the time to compile, for what a fault at address 0 and the address sanitizer find as well.
    add_compile_options(-fno-sanitize=null,vptr,object-size)
  endif()
endif()

# Under sanitizers the optimizer doubles the time to compile, and only the engine is slow without it: the groups of
# precompiled headers that hold tests, services and clients do without. The client, whose options are the most code
# that there is and run once, is never worth more than a little of it.
function(choose_optimization target group)
  if(group STREQUAL "base")
    return()
  endif()
  if(SHUTTERLINE_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  elseif(group STREQUAL "client")
    target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O1>)
  endif()
endfunction()
