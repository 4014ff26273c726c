// SPDX-License-Identifier: MIT
#include "reports/junit.hpp"

#include <cstdlib>

#include "fixtures/io/file_bytes.hpp"
#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

namespace {

bool well_formed(const std::string& xml) {
  const scratch::Folder folder;
  io::replace_file(folder.path() / "results.xml", xml);
  const std::string command = "xmllint --noout '" + (folder.path() / "results.xml").string() + "'";
  return std::system(command.c_str()) == 0;
}

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST("JUnit is well formed and counts every case once") {
  const std::string xml = to_junit(sample::results());
  CHECK(well_formed(xml));
  CHECK(contains(xml, "tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"1\""));
  CHECK(contains(
      xml, "<testsuite name=\"stability\" tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\""));
}

TEST("every quantity is a property with its bounds, and a fallen one is the message") {
  const std::string xml = to_junit(sample::results());
  CHECK(contains(xml, "<property name=\"observed_order\" value=\"4.01\"/>"));
  CHECK(contains(xml, "<property name=\"observed_order.upper\" value=\"4.15\"/>"));
  CHECK(!contains(xml, "rungs.upper"));
  CHECK(contains(xml, "message=\"modulus = nan Pa; allowed 1 to 2 (theory)\""));
  CHECK(contains(xml, "<skipped message=\"the folder lumbar_network is absent\"/>"));
}

TEST("hostile text stays text") {
  Results results = sample::results();
  results.outcomes[3].reason = "]]> <a b='\"'> & \x01 \xff end";
  results.outcomes[1].claim = "</failure><x>";
  CHECK(well_formed(to_junit(results)));
}
