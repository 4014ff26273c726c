# One hash over the object code that decides what cases find, into a source file, written only when it changed.
# cmake -D "FILES=a|b" -D OUTPUT=... -P write_code_hash.cmake
string(REPLACE "|" ";" files "${FILES}")
set(hashes "")
foreach(file IN LISTS files)
  file(SHA256 "${file}" hash)
  string(APPEND hashes "${hash}")
endforeach()
string(SHA256 hash "${hashes}")
set(content "namespace palpate::build {
const char* code_hash();
const char* code_hash() { return \"${hash}\"; }
}  // namespace palpate::build
")
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "${content}" @ONLY)
