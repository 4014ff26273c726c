# One interface target carries every flag; nothing is set globally.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

add_library(palpate_build_options INTERFACE)
target_compile_features(palpate_build_options INTERFACE cxx_std_20)
target_include_directories(palpate_build_options INTERFACE "${PROJECT_SOURCE_DIR}" "${PROJECT_BINARY_DIR}")
target_compile_options(palpate_build_options INTERFACE
  -Wall -Wextra -Wconversion -Wshadow
  # g++ 12 reports impossible overlaps inside std::string (its bug 105651).
  -Wno-restrict
  # Same bits on every machine; square roots vectorise. Neither changes a value.
  -ffp-contract=off -fno-math-errno)
if(PALPATE_STRICT)
  target_compile_options(palpate_build_options INTERFACE -Werror)
endif()
if(PALPATE_SANITIZE)
  target_compile_options(palpate_build_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
    # g++ 12 sees uninitialised members inside std::regex under sanitizers (its bug 105562).
    -Wno-maybe-uninitialized)
  target_link_options(palpate_build_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(palpate_build_options INTERFACE PALPATE_SANITIZED)
endif()

# palpate_add_library(<name> SOURCES ... [PUBLIC ...] [PRIVATE ...]): one box of the architecture,
# usable as palpate::<name>.
function(palpate_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  add_library(palpate_${name} STATIC ${arg_SOURCES})
  add_library(palpate::${name} ALIAS palpate_${name})
  target_link_libraries(palpate_${name}
    PUBLIC palpate_build_options ${arg_PUBLIC}
    PRIVATE ${arg_PRIVATE})
  set_target_properties(palpate_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
endfunction()
