# One hash over the object code that decides what cases find, into a header, only when it changed.
# cmake -D "FILES=a|b" -D OUTPUT=... -P write_code_hash.cmake
string(REPLACE "|" ";" files "${FILES}")
set(hashes "")
foreach(file IN LISTS files)
  file(SHA256 "${file}" hash)
  string(APPEND hashes "${hash}")
endforeach()
string(SHA256 hash "${hashes}")
set(content "#pragma once\nnamespace palpate::build {\ninline constexpr char code_hash[] = \"${hash}\";\n}  // namespace palpate::build\n")
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "${content}" @ONLY)
