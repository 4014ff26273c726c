# One interface target carries every flag; nothing is set globally.
if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

add_library(palpate_build_options INTERFACE)
target_compile_features(palpate_build_options INTERFACE cxx_std_20)
target_include_directories(palpate_build_options INTERFACE "${PROJECT_SOURCE_DIR}" "${PROJECT_BINARY_DIR}")
set(contraction -ffp-contract=off)  # the same bits on every machine
if(PALPATE_FUSED)
  set(contraction -march=x86-64-v3 -ffp-contract=fast)
endif()
target_compile_options(palpate_build_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow
  # g++ 12 reports impossible overlaps inside std::string (its bug 105651).
  -Wno-restrict
  # With the second square roots vectorise; it changes no value.
  ${contraction} -fno-math-errno
  # Simulators and our own step library are shared libraries; programs share the precompiled headers with them.
  -fPIC)
if(PALPATE_STRICT)
  target_compile_options(palpate_build_options INTERFACE -Werror)
endif()
if(PALPATE_SANITIZE)
  target_compile_options(palpate_build_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
    # Checks that others make already: a null pointer, or one moved out of its object, ends in the address
    # sanitizer's report when it is used, and Eigen asserts its alignment.
    -fno-sanitize=null,alignment,pointer-overflow
    # g++ 12 sees uninitialised members inside std::regex under sanitizers (its bug 105562).
    -Wno-maybe-uninitialized
    )
  target_link_options(palpate_build_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(palpate_build_options INTERFACE PALPATE_SANITIZED)
endif()

option(PALPATE_FUZZ "Build fuzzers of the readers (clang and its libFuzzer; tests/CMakeLists.txt)" OFF)
if(PALPATE_FUZZ)
  target_compile_options(palpate_build_options INTERFACE
    -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-sanitize=null,alignment
    -w)  # g++ judges warnings
  target_link_options(palpate_build_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(palpate_build_options INTERFACE PALPATE_SANITIZED)
endif()

# What steps a scene is compiled without it in the optimised build, file by file; all the rest reads common headers
# precompiled. What waits for files, processes or people, and what calls the model and no more, is optimised less:
# a third of its compilation.
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/precompiled.cpp" CONTENT "// headers only\n")
set(palpate_precompiled_headers palpate_precompiled)
set(palpate_precompiled_little palpate_precompiled)
set(palpate_little_optimised "")
if(CMAKE_BUILD_TYPE STREQUAL "Release")  # the other build has one level, and one such file
  set(palpate_little_optimised -O1)
  set(palpate_precompiled_little palpate_precompiled_little_optimised)
  list(APPEND palpate_precompiled_headers ${palpate_precompiled_little})
endif()
foreach(target IN LISTS palpate_precompiled_headers)
  add_library(${target} OBJECT "${PROJECT_BINARY_DIR}/precompiled.cpp")
  target_link_libraries(${target} PRIVATE palpate_build_options Eigen3::Eigen)
  target_precompile_headers(${target} PRIVATE
    <algorithm> <array> <charconv> <chrono> <cmath> <complex> <cstdio> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <numbers> <numeric> <optional> <random> <set> <span> <sstream>
    <stdexcept> <string> <string_view> <variant> <vector>
    <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <Eigen/SparseCore>)
endforeach()
target_compile_options(${palpate_precompiled_little} PRIVATE ${palpate_little_optimised})
function(palpate_use_precompiled target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "LITTLE_OPTIMISED" "" "")
  if(arg_LITTLE_OPTIMISED)
    # At -O1 g++ 12 sees reads beyond short strings and uninitialised sizes inside Eigen that -O3 knows are none.
    target_compile_options(${target} PRIVATE ${palpate_little_optimised}
      -Wno-stringop-overread -Wno-maybe-uninitialized)
    target_precompile_headers(${target} REUSE_FROM ${palpate_precompiled_little})
  else()
    target_precompile_headers(${target} REUSE_FROM palpate_precompiled)
  endif()
  # g++ 12 reports impossible sizes and places inside std::string from precompiled headers (its bug 105651 again).
  target_compile_options(${target} PRIVATE -Wno-stringop-overflow -Wno-array-bounds)
endfunction()

# UNITY: the optimised build compiles several files as one, which reads their headers once. The sanitized build compiles
# every file alone, which also proves that each one includes what it uses.
# palpate_add_library(<name> [UNITY] [PRECOMPILED] [LITTLE_OPTIMISED] SOURCES ... [PUBLIC ...] [PRIVATE ...]): one box of the
# architecture, usable as palpate::<name>. The build options reach those who link it inside this project, and nobody else.
function(palpate_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "UNITY;PRECOMPILED;LITTLE_OPTIMISED" "" "SOURCES;PUBLIC;PRIVATE")
  add_library(palpate_${name} STATIC ${arg_SOURCES})
  add_library(palpate::${name} ALIAS palpate_${name})
  set(options_for PRIVATE)
  if(PROJECT_IS_TOP_LEVEL)
    set(options_for PUBLIC)
  endif()
  target_link_libraries(palpate_${name}
    ${options_for} $<BUILD_INTERFACE:palpate_build_options>
    PUBLIC ${arg_PUBLIC}
    PRIVATE ${arg_PRIVATE})
  if(arg_UNITY AND NOT PALPATE_SANITIZE)
    set_target_properties(palpate_${name} PROPERTIES UNITY_BUILD ${PALPATE_UNITY} UNITY_BUILD_BATCH_SIZE 6)
  endif()
  if(PALPATE_SANITIZE OR arg_PRECOMPILED)
    set(little_optimised "")
    if(arg_LITTLE_OPTIMISED)
      set(little_optimised LITTLE_OPTIMISED)
    endif()
    palpate_use_precompiled(palpate_${name} ${little_optimised})
  endif()
endfunction()
