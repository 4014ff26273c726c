// SPDX-License-Identifier: MIT

#include <nlohmann/json.hpp>
#include <string>

#include "reports/results/results_json.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using palpate::parse_json;

TEST("JSON that is nested without end is refused, and texts hide no brackets") {
  for (const std::string_view open : {"[", "{\"a\":", "[\"]]]\",", "{\"\\\"]}\":"}) {
    std::string text = "{\"schema\":";
    for (int n = 0; n < 100'000; ++n) { text += open; }
    CHECK_THROWS_AS(nlohmann::json::exception, parse_json(text), "more than 32 brackets");
  }
  const std::string brackets(1000, '[');
  CHECK(parse_json("{\"a\\\\\":\"" + brackets + "\"}").at("a\\") == brackets);
}

TEST("a key that is twice in one object is refused, and one text is sealed as a whole") {
  CHECK_THROWS_AS(nlohmann::json::exception, parse_json(R"({"a": [{"b": 1, "c": 2, "b": 3}]})"),
                  "key \"b\" is twice in one object");
  CHECK(parse_json(R"([{"b": 1}, {"b": {"b": 2}}])").size() == 2);
  const std::string text = palpate::sealed_text({{"a", 1}});
  CHECK(palpate::parse_sealed(text).at("a") == 1);
  CHECK_THROWS(palpate::parse_sealed("{\"a\": 1}"), "has no seal");
  std::string edited = text;
  edited.replace(edited.find('1'), 1, "2");
  CHECK_THROWS(palpate::parse_sealed(edited), "was changed since it was written");
}

TEST("results that are nested without end are refused with their file") {
  const std::string deep = "{\"schema\":" + std::string(100'000, '[') + std::string(100'000, ']');
  CHECK_THROWS_AS(palpate::InputError, palpate::results_from_json(deep + "}", "results.json"),
                  "results.json: more than 32 brackets within each other");
}

}  // namespace PALPATE_FILE
