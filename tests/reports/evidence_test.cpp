// SPDX-License-Identifier: MIT

#include "reports/evidence.hpp"

#include <openssl/evp.h>
#include <openssl/pem.h>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "tests/check.hpp"
#include "validation/random.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::evidence;

Files sample_files() {
  return {{"claims.json", "[{\"requirement\": \"R1\"}]\n"},
          {"empty", ""},
          {"results/1/traces/a.h5", std::string("\x89HDF\0\1\2", 7)}};
}

/// Message of the refusal; empty if there is none.
template <class Work> std::string refusal(const Work& work) {
  try {
    work();
  } catch (const InputError& error) { return error.what(); }
  return {};
}

void write_keys(const io::ScratchFolder& folder, const std::string& name) {
  EVP_PKEY* key = EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519");
  BIO* secret = BIO_new_file((folder / (name + ".pem")).c_str(), "w");
  PEM_write_bio_PrivateKey(secret, key, nullptr, nullptr, 0, nullptr, nullptr);
  BIO_free(secret);
  BIO* open = BIO_new_file((folder / (name + ".pub")).c_str(), "w");
  PEM_write_bio_PUBKEY(open, key);
  BIO_free(open);
  EVP_PKEY_free(key);
}

TEST("an archive gives back its files") {
  CHECK(from_zip(to_zip(sample_files()), "a.zip") == sample_files());
  CHECK(from_zip(to_zip({}), "a.zip").empty());
}

TEST("every changed bit, every cut and every added byte of an archive is found") {
  const std::string zip = to_zip(sample_files());
  for (std::size_t at = 0; at < zip.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string changed = zip;
      changed[at] = static_cast<char>(changed[at] ^ (1 << bit));
      CHECK(!refusal([&] { (void)from_zip(changed, "a.zip"); }).empty());
    }
    CHECK(!refusal([&] { (void)from_zip(zip.substr(0, at), "a.zip"); }).empty());
  }
  CHECK(!refusal([&] { (void)from_zip(zip + '\0', "a.zip"); }).empty());
}

TEST("an archive that claims sizes beyond its end is refused without allocating them") {
  std::string zip = to_zip(sample_files());
  for (const std::size_t at : {18U, 22U, 26U}) {
    std::string changed = zip;
    for (std::size_t n = 0; n < (at == 26U ? 2U : 4U); ++n) { changed[at + n] = '\xff'; }
    CHECK(!refusal([&] { (void)from_zip(changed, "a.zip"); }).empty());
  }
}

TEST("random bytes are no archive") {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    std::string bytes = "PK\3\4";
    for (int n = 0; n < 200; ++n) { bytes += static_cast<char>(random(0.0, 256.0)); }
    CHECK(!refusal([&] { (void)from_zip(bytes, "a.zip"); }).empty());
  }
}

TEST("a signed statement is accepted with its key and refused with another") {
  const io::ScratchFolder folder;
  write_keys(folder, "a");
  write_keys(folder, "b");
  const Files files = sample_files();
  const std::string text = statement_over(files, evidence_predicate, "{\"x\":1}", folder / "a.pem");
  const auto check = [&](const std::string& statement, const Files& over, const char* key) {
    return refusal([&] {
      (void)check_statement(statement, evidence_predicate, over, key == nullptr ? "" : folder / key,
                            "s.json");
    });
  };
  CHECK(check(text, files, "a.pub").empty());
  CHECK(check(text, files, nullptr).empty());
  CHECK(!check(text, files, "b.pub").empty());
  CHECK(!check(text, files, "a.pem").empty());
  CHECK(!check(statement_over(files, evidence_predicate, "{}", ""), files, "a.pub").empty());
  CHECK(!check(statement_over(files, certificate_predicate, "{}", folder / "a.pem"), files, "a.pub")
             .empty());
  Files other = files;
  other["empty"] = "no longer";
  CHECK(check(text, other, "a.pub").find("empty is not the file") != std::string::npos);
  other = files;
  other.erase("empty");
  CHECK(!check(text, other, "a.pub").empty());
  other = files;
  other["more"] = "";
  CHECK(!check(text, other, "a.pub").empty());
}

TEST("every changed byte of a signed statement is found") {
  const io::ScratchFolder folder;
  write_keys(folder, "a");
  const Files files = sample_files();
  const std::string text = statement_over(files, evidence_predicate, "{}", folder / "a.pem");
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string changed = text;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    const std::string refused = refusal([&] {
      (void)check_statement(changed, evidence_predicate, files, folder / "a.pub", "s.json");
    });
    CHECK(!refused.empty());
  }
}

}  // namespace PALPATE_FILE
