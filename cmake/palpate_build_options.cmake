# One interface target carries every flag; nothing is set globally.
if(NOT CMAKE_BUILD_TYPE)
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
  ${contraction} -fno-math-errno)
if(PALPATE_STRICT)
  target_compile_options(palpate_build_options INTERFACE -Werror)
endif()
if(PALPATE_SANITIZE)
  target_compile_options(palpate_build_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
    # Checks that others make already: a null pointer ends in the address sanitizer's report, and Eigen
    # asserts its alignment.
    -fno-sanitize=null,alignment
    # g++ 12 sees uninitialised members inside std::regex under sanitizers (its bug 105562).
    -Wno-maybe-uninitialized
    # Files compiled together shadow each other's local names; the optimised build looks at those of the
    # model and the device alone.
    -Wno-shadow)
  target_link_options(palpate_build_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(palpate_build_options INTERFACE PALPATE_SANITIZED)
endif()

# Libraries that a simulator links are compiled without it in the optimised build, and so see the header that a
# file forgot to include; all the rest reads common headers precompiled.
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/precompiled.cpp" CONTENT "// headers only\n")
add_library(palpate_precompiled OBJECT "${PROJECT_BINARY_DIR}/precompiled.cpp")
target_link_libraries(palpate_precompiled PRIVATE palpate_build_options Eigen3::Eigen)
target_precompile_headers(palpate_precompiled PRIVATE
  <algorithm> <array> <charconv> <chrono> <cmath> <complex> <cstdio> <filesystem> <fstream>
  <functional> <limits> <map> <memory> <numbers> <numeric> <optional> <random> <set> <span> <sstream>
  <stdexcept> <string> <string_view> <variant> <vector>
  <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <Eigen/SparseCore>)
function(palpate_use_precompiled target)
  target_precompile_headers(${target} REUSE_FROM palpate_precompiled)
  # g++ 12 reports impossible sizes and places inside std::string from precompiled headers (its bug 105651 again).
  target_compile_options(${target} PRIVATE -Wno-stringop-overflow -Wno-array-bounds)
endfunction()

# palpate_add_library(<name> [TOGETHER] SOURCES ... [ALONE ...] [PUBLIC ...] [PRIVATE ...]): one box of the
# architecture, usable as palpate::<name>. The sanitized build compiles about eight sources at a time to take
# less of it; TOGETHER does so in every build, for libraries that no simulator links. Sources are dealt out
# like cards, so that neighbours in the list, which have local names in common, do not meet; those ALONE
# have flags or names that nobody can share.
function(palpate_compile_together target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;ALONE")
  list(REMOVE_ITEM arg_SOURCES ${arg_ALONE})
  list(LENGTH arg_SOURCES count)
  math(EXPR units "(${count} + 7) / 8")
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  set(unit 0)
  foreach(source IN LISTS arg_SOURCES)
    set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "unit${unit}")
    math(EXPR unit "(${unit} + 1) % ${units}")
  endforeach()
endfunction()

function(palpate_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "TOGETHER" "" "SOURCES;ALONE;PUBLIC;PRIVATE")
  add_library(palpate_${name} STATIC ${arg_SOURCES})
  add_library(palpate::${name} ALIAS palpate_${name})
  target_link_libraries(palpate_${name}
    PUBLIC palpate_build_options ${arg_PUBLIC}
    PRIVATE ${arg_PRIVATE})
  if(PALPATE_SANITIZE OR arg_TOGETHER)
    palpate_use_precompiled(palpate_${name})
    palpate_compile_together(palpate_${name} SOURCES ${arg_SOURCES} ALONE ${arg_ALONE})
  else()  # a simulator may be a shared library; precompiled headers are shared with programs, which are not
    set_target_properties(palpate_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
endfunction()
