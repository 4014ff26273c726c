// SPDX-License-Identifier: MIT
// Readers of commands: scripts of an emulated Falcon, and merged campaigns.

#include "tests/fuzz_readers.hpp"

#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_script.hpp"

const char* palpate::build::code_hash() { return ""; }

namespace {

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{
      {"script",
       [](std::string_view bytes) {
         (void)cli::read_falcon_script(file_with(bytes, "script.toml"), {});
       }},
      {"findings", [](std::string_view bytes) {
         campaign::Domain domain;
         (void)cli::campaign_findings(std::string(bytes), "merged.jsonl", domain);
       }}};
  return all;
}

}  // namespace
