// SPDX-License-Identifier: MIT

#include "reports/evidence.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <vector>
#include <zlib.h>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/results/results_json.hpp"
#include "reports/view/view_encoding.hpp"

namespace palpate::evidence {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_zip_bytes = std::size_t{1} << 30U;
constexpr std::size_t most_files = 65'000;
constexpr std::uint32_t local_mark = 0x04034b50;
constexpr std::uint32_t central_mark = 0x02014b50;
constexpr std::uint32_t end_mark = 0x06054b50;
constexpr std::size_t local_size = 30;

/// Appends a number in little-endian order.
template <class Number> void put(std::string& text, Number number) {
  for (std::size_t n = 0; n < sizeof(Number); ++n) {
    text += static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * n) & 0xffU);
  }
}

std::uint32_t number_at(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t n = 0; n < size; ++n) {
    number |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + n])) << (8 * n);
  }
  return number;
}

/// Fields that the local header and the central directory share, from the version to the lengths.
std::string shared_header(const std::string& name, const std::string& content) {
  std::string text;
  put<std::uint16_t>(text, 10);      // version needed: stored files
  put<std::uint16_t>(text, 0x0800);  // names in UTF-8
  put<std::uint16_t>(text, 0);       // not compressed
  put<std::uint16_t>(text, 0);       // 00:00
  put<std::uint16_t>(text, 0x0021);  // 1 January 1980, the earliest date
  const auto* data = reinterpret_cast<const Bytef*>(content.data());
  put(text, static_cast<std::uint32_t>(crc32_z(crc32(0, nullptr, 0), data, content.size())));
  put(text, static_cast<std::uint32_t>(content.size()));
  put(text, static_cast<std::uint32_t>(content.size()));
  put(text, static_cast<std::uint16_t>(name.size()));
  put<std::uint16_t>(text, 0);  // no extra field
  return text;
}

}  // namespace

std::string to_zip(const Files& files) {
  constexpr std::size_t most_name = 4096;
  std::string zip;
  std::string central;
  std::size_t total = 0;
  for (const auto& [name, content] : files) { total += content.size() + 2 * name.size() + 100; }
  const bool names_fit =
      std::ranges::all_of(files, [](const auto& file) { return file.first.size() <= most_name; });
  if (total > most_zip_bytes || files.size() > most_files || !names_fit) {
    throw InputError("the archive would have " + std::to_string(files.size()) + " files and " +
                     std::to_string(total) + " bytes; at most " + std::to_string(most_files) +
                     " and " + std::to_string(most_zip_bytes));
  }
  for (const auto& [name, content] : files) {
    const std::string shared = shared_header(name, content);
    put(central, central_mark);
    put<std::uint16_t>(central, 10);  // made by: DOS attributes
    central += shared;
    central.append(10, '\0');  // no comment, first disk, no attributes
    put(central, static_cast<std::uint32_t>(zip.size()));
    central += name;
    put(zip, local_mark);
    zip += shared + name + content;
  }
  const std::size_t at = zip.size();
  zip += central;
  put(zip, end_mark);
  put<std::uint32_t>(zip, 0);  // first disk
  put(zip, static_cast<std::uint16_t>(files.size()));
  put(zip, static_cast<std::uint16_t>(files.size()));
  put(zip, static_cast<std::uint32_t>(central.size()));
  put(zip, static_cast<std::uint32_t>(at));
  put<std::uint16_t>(zip, 0);  // no comment
  return zip;
}

Files from_zip(std::string_view bytes, const std::string& name) {
  constexpr const char* allowed = "; an archive as palpate evidence wrote it";
  Files files;
  std::size_t at = 0;
  while (bytes.size() - at >= local_size && number_at(bytes, at, 4) == local_mark) {
    const std::size_t size = number_at(bytes, at + 18, 4);
    const std::size_t name_size = number_at(bytes, at + 26, 2);
    const std::size_t left = bytes.size() - at - local_size;
    if (name_size > left || size > left - name_size || files.size() > most_files) {
      throw InputError(name + ": byte " + std::to_string(at) + ": a file that is longer than the " +
                       "archive" + allowed);
    }
    files[std::string(bytes.substr(at + local_size, name_size))] =
        bytes.substr(at + local_size + name_size, size);
    at += local_size + name_size + size;
  }
  const std::string again = to_zip(files);
  if (again == bytes) { return files; }
  const std::size_t common = std::min(again.size(), bytes.size());
  const auto change = static_cast<std::size_t>(
      std::mismatch(again.begin(), again.begin() + static_cast<std::ptrdiff_t>(common),
                    bytes.begin())
          .first -
      again.begin());
  throw InputError(
      name + (files.empty() ? ": is no archive, or was changed: byte " : ": was changed: byte ") +
      std::to_string(change) + allowed);
}

namespace {

using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using Context = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

constexpr const char* payload_type = "application/vnd.in-toto+json";

/// Refuses encrypted keys, for which OpenSSL would ask on the terminal.
int no_password(char*, int, int, void*) { return -1; }

Key read_key(const std::filesystem::path& file, bool secret) {
  constexpr std::size_t most_bytes = 1U << 16U;
  const std::string text = io::read_text(file, most_bytes);
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(
      BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free);
  Key key(secret ? PEM_read_bio_PrivateKey(bio.get(), nullptr, no_password, nullptr)
                 : PEM_read_bio_PUBKEY(bio.get(), nullptr, no_password, nullptr),
          EVP_PKEY_free);
  if (key == nullptr || EVP_PKEY_id(key.get()) != EVP_PKEY_ED25519) {
    io::refuse_file(file, secret ? "is no Ed25519 private key in PEM without password; "
                                   "`openssl genpkey -algorithm ed25519 -out FILE` makes one"
                                 : "is no Ed25519 public key in PEM; "
                                   "`openssl pkey -in KEY -pubout -out FILE` makes it");
  }
  return key;
}

/// SHA-256 of the public key in DER.
std::string id_of(EVP_PKEY* key) {
  unsigned char* der = nullptr;
  const int size = i2d_PUBKEY(key, &der);
  const std::string id =
      io::sha256({reinterpret_cast<const char*>(der), static_cast<std::size_t>(std::max(size, 0))});
  OPENSSL_free(der);
  return id;
}

/// Pre-authentication encoding of DSSE: the bytes that are signed.
std::string encoded(const std::string& payload) {
  const std::string type = payload_type;
  return "DSSEv1 " + std::to_string(type.size()) + " " + type + " " +
         std::to_string(payload.size()) + " " + payload;
}

const unsigned char* bytes_of(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

std::string sign(const std::string& text, EVP_PKEY* key) {
  std::array<unsigned char, 64> signature{};
  std::size_t size = signature.size();
  const Context context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  if (EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key) != 1 ||
      EVP_DigestSign(context.get(), signature.data(), &size, bytes_of(text), text.size()) != 1) {
    throw std::runtime_error("OpenSSL cannot sign with this key");
  }
  return {reinterpret_cast<const char*>(signature.data()), size};
}

bool is_signed(const std::string& text, const std::string& signature, EVP_PKEY* key) {
  const Context context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  return EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key) == 1 &&
         EVP_DigestVerify(context.get(), bytes_of(signature), signature.size(), bytes_of(text),
                          text.size()) == 1;
}

/// Decodes base64. Throws std::runtime_error unless it is what base64() writes.
std::string decoded(const std::string& text) {
  std::string bytes(text.size(), '\0');
  const int size = EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()), bytes_of(text),
                                   static_cast<int>(text.size()));
  const auto padding = static_cast<std::size_t>(std::count(text.begin(), text.end(), '='));
  bytes.resize(size > static_cast<int>(padding) ? static_cast<std::size_t>(size) - padding : 0);
  if (base64(bytes) != text) { throw std::runtime_error("is not base64"); }
  return bytes;
}

Json subjects_of(const Files& files) {
  return list_of(files, [](const auto& file) {
    return object("name", file.first, "digest", object("sha256", io::sha256(file.second)));
  });
}

}  // namespace

std::string statement_over(const Files& files, const std::string& kind,
                           const std::string& predicate, const std::filesystem::path& key) {
  const std::string statement =
      object("_type", "https://in-toto.io/Statement/v1", "subject", subjects_of(files),
             "predicateType", kind, "predicate", parse_json(predicate))
          .dump();
  Json signatures = Json::array();
  if (!key.empty()) {
    const Key secret = read_key(key, true);
    signatures.push_back(object("keyid", id_of(secret.get()), "sig",
                                base64(sign(encoded(statement), secret.get()))));
  }
  return json_text(
      object("payloadType", payload_type, "payload", base64(statement), "signatures", signatures));
}

CheckedStatement check_statement(const std::string& envelope, const std::string& kind,
                                 const Files& files, const std::filesystem::path& key,
                                 const std::string& name) {
  CheckedStatement checked;
  std::string payload;
  std::string signature;
  try {
    const Json json = parse_json(envelope);
    if (json_text(json) != envelope || json.at("payloadType") != payload_type) {
      throw std::runtime_error("was changed");
    }
    payload = decoded(json.at("payload"));
    const Json& signatures = json.at("signatures");
    if (signatures.size() > 1) { throw std::runtime_error("has several signatures"); }
    if (!signatures.empty()) {
      checked.key_id = signatures.at(0).at("keyid");
      signature = decoded(signatures.at(0).at("sig"));
    }
    const Json statement = parse_json(payload);
    if (statement.at("predicateType") != kind) {
      throw std::runtime_error("is of the kind " + statement.at("predicateType").dump());
    }
    checked.predicate = statement.at("predicate").dump();
    const Json found = subjects_of(files);
    if (statement.at("subject") != found) {
      std::string which;
      for (const Json& each : found) {
        const Json& subjects = statement.at("subject");
        if (std::ranges::find(subjects, each) == subjects.end()) { which = each.at("name"); }
      }
      throw std::runtime_error(which.empty() ? "a file that it names is not there"
                                             : which + " is not the file that it names");
    }
  } catch (const std::exception& problem) {
    throw json_trouble(name, envelope, problem, "a statement as palpate wrote it");
  }
  if (key.empty()) { return checked; }
  const Key open = read_key(key, false);
  if (signature.empty()) {
    throw InputError(name + ": is not signed; a statement signed with " + key.string());
  }
  if (checked.key_id != id_of(open.get()) || !is_signed(encoded(payload), signature, open.get())) {
    throw InputError(name + ": the signature is not of " + key.string() +
                     "; a statement signed with its private key");
  }
  checked.signature_checked = true;
  return checked;
}

}  // namespace palpate::evidence
