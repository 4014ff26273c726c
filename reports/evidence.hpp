// SPDX-License-Identifier: MIT
#pragma once
/// Archive of files whose every byte is checked, and in-toto statements over files, signed with
/// Ed25519 (docs/evidence.md).

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace palpate::evidence {

/// Content of an archive or subject of a statement: bytes by name.
using Files = std::map<std::string, std::string>;

/// Writes a ZIP archive: files in the order of their names, not compressed, without times. The same
/// files give the same bytes with every version of every library. Throws InputError above 1 GiB or
/// 65,000 files.
std::string to_zip(const Files& files);

/// Reads an archive that to_zip() wrote. Every byte is determined by the files, so each changed
/// byte is found. Allocates no more than the size of the archive. Throws InputError.
Files from_zip(std::string_view bytes, const std::string& name);

/// Kinds of in-toto predicates.
inline constexpr const char* evidence_predicate = "urn:palpate:evidence:v1";
inline constexpr const char* certificate_predicate = "urn:palpate:certificate:v1";

/// Returns a DSSE envelope with an in-toto statement over the files. `predicate` is JSON. `key` is
/// a file with an Ed25519 private key in PEM; if empty, the statement has no signature. Throws
/// InputError.
std::string statement_over(const Files& files, const std::string& kind,
                           const std::string& predicate, const std::filesystem::path& key);

struct CheckedStatement {
  std::string predicate{};  ///< JSON
  std::string key_id{};     ///< SHA-256 of the public key that the envelope names; empty: unsigned
  bool signature_checked = false;
};

/// Checks that a statement is over exactly these files. `key` is a file with an Ed25519 public key
/// in PEM that must have signed it; if empty, a signature is not checked. `name` is used in
/// messages. Throws InputError.
CheckedStatement check_statement(const std::string& envelope, const std::string& kind,
                                 const Files& files, const std::filesystem::path& key,
                                 const std::string& name);

}  // namespace palpate::evidence
