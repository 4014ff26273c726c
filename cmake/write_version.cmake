# Writes the commit into a header at build time, only when it changed.
# cmake -D SOURCE=... -D OUTPUT=... -D VERSION=... -P write_version.cmake
set(commit "unknown")
find_program(git git)
if(git)
  execute_process(COMMAND "${git}" -C "${SOURCE}" describe --always --dirty --abbrev=12
                  OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0)
    set(commit "${described}")
  endif()
endif()
set(content "#pragma once\nnamespace palpate::build {\ninline constexpr char version[] = \"${VERSION}\";\ninline constexpr char commit[] = \"${commit}\";\n}  // namespace palpate::build\n")
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "${content}" @ONLY)
