# palpate_embed(<header> NAMESPACE <ns> FILES <name>=<path> ...): texts as constants of a header that
# is made when CMake runs and again when one of them changes.
function(palpate_embed header)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "NAMESPACE" "FILES")
  set(content "#pragma once\n#include <string_view>\nnamespace ${arg_NAMESPACE} {\n")
  foreach(entry IN LISTS arg_FILES)
    string(REGEX MATCH "^([^=]+)=(.*)$" ignored "${entry}")
    set(name "${CMAKE_MATCH_1}")
    set(path "${CMAKE_MATCH_2}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${path}")
    file(READ "${path}" text)
    # A page that names a source map makes the browser ask for it.
    string(REGEX REPLACE "(//|/\\*)# sourceMappingURL=[^\n]*" "" text "${text}")
    # The length is stated: g++ counts no more than 262144 characters in a constant expression.
    string(APPEND content "inline constexpr char ${name}_text[] = R\"palpate~(${text})palpate~\";\n"
                          "inline constexpr std::string_view ${name}(${name}_text, sizeof(${name}_text) - 1);\n")
  endforeach()
  string(APPEND content "}  // namespace ${arg_NAMESPACE}\n")
  set(old "")
  if(EXISTS "${header}")
    file(READ "${header}" old)
  endif()
  if(NOT old STREQUAL content)
    file(WRITE "${header}" "${content}")
  endif()
endfunction()
