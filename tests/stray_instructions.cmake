# Fails when a function that was compiled for more than the architecture's baseline also stands elsewhere: the
# linker would keep either, and the program could stop on a processor that lacks the instructions.
#   cmake -D NM=nm -D OBJECTS=a.o,b.o -P tests/stray_instructions.cmake
cmake_policy(VERSION 3.25)
string(REPLACE "," ";" OBJECTS "${OBJECTS}")
set(special "")
set(common "")
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND "${NM}" --format=posix --defined-only --extern-only "${object}"
                  OUTPUT_VARIABLE names COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^ \n]+ [TW] " names "${names}")  # functions: data holds no instructions
  list(TRANSFORM names REPLACE " . $" "")
  if(object MATCHES "_avx2\\.")
    list(APPEND special ${names})
  else()
    list(APPEND common ${names})
  endif()
endforeach()
if(special STREQUAL "")
  message(FATAL_ERROR "no object for a larger instruction set: nothing was checked")
endif()
foreach(name IN LISTS special)
  if(name IN_LIST common)
    message(SEND_ERROR "${name} is compiled for AVX2 and for the baseline under one name")
  endif()
endforeach()
