// SPDX-License-Identifier: MIT

#include "reports/live/live_server.hpp"

#include <set>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::live;

const RequestCheck gate{.token = "00112233445566778899aabbccddeeff", .port = 8080};

TEST("only the names of this machine with the port of the server pass as a host") {
  CHECK(gate.allows_host("127.0.0.1:8080"));
  CHECK(gate.allows_host("localhost:8080"));
  for (const char* other :
       {"", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:80801", "example.org:8080", "localhost",
        "127.0.0.1:8080.example.org", "[::1]:8080", "127.0.0.2:8080", "LOCALHOST:8080 "}) {
    CHECK(!gate.allows_host(other));
  }
}

TEST("only the page of the server passes as an origin") {
  CHECK(gate.allows_origin("http://127.0.0.1:8080"));
  CHECK(gate.allows_origin("http://localhost:8080"));
  for (const char* other : {"", "null", "https://127.0.0.1:8080", "http://example.org",
                            "http://127.0.0.1:8081", "http://127.0.0.1:8080/", "127.0.0.1:8080"}) {
    CHECK(!gate.allows_origin(other));
  }
}

TEST("a target passes with the whole token alone") {
  const std::string right = "/?token=" + gate.token;
  CHECK(gate.allows_target(right, "/"));
  CHECK(gate.allows_target("/socket?token=" + gate.token, "/socket"));
  for (const std::string& other :
       {std::string("/"), std::string("/?token="), right.substr(0, right.size() - 1), right + "0",
        right + "&x=1", "/socket?token=" + gate.token, "/../etc/passwd?token=" + gate.token}) {
    CHECK(!gate.allows_target(other, "/"));
  }
  const RequestCheck open{.token = "", .port = 8080};
  CHECK(!open.allows_target("/?token=", "/"));
}

TEST("tokens have 128 bits and differ") {
  std::set<std::string> tokens;
  for (int n = 0; n < 1000; ++n) {
    const std::string token = random_token();
    CHECK(token.size() == 32);
    CHECK(token.find_first_not_of("0123456789abcdef") == token.npos);
    tokens.insert(token);
  }
  CHECK(tokens.size() == 1000);
}

TEST("a rate limit lets a burst through, then the rate, and never more than the burst") {
  RateLimit limit(10.0, 5.0);
  int passed = 0;
  for (int n = 0; n < 100; ++n) { passed += limit.allows(1.0) ? 1 : 0; }
  CHECK(passed == 5);
  CHECK(!limit.allows(1.05));
  CHECK(limit.allows(1.16));
  passed = 0;
  for (int n = 0; n < 100; ++n) { passed += limit.allows(1000.0) ? 1 : 0; }
  CHECK(passed == 5);
}

TEST("commands are read, and everything else is no command") {
  const auto drive = command_of(R"({"do":"drive","value":0.03})");
  REQUIRE(drive.has_value());
  CHECK(drive->kind == Command::Kind::drive);
  CHECK(drive->value == 0.03);
  const auto stiffness = command_of(R"({"do":"stiffness","value":2,"index":3})");
  REQUIRE(stiffness.has_value());
  CHECK(stiffness->index == 3);
  CHECK(command_of(R"({"do":"reset"})").has_value());
  for (const char* other :
       {"", "{", "[]", "null", R"({"do":7})", R"({"do":"shutdown"})", R"({"do":"drive"})",
        R"({"do":"drive","value":"1"})", R"({"do":"drive","value":1e999})",
        R"({"do":"stiffness","value":1})", R"({"do":"stiffness","value":1,"index":-1})",
        R"({"do":"reset","x":{"y":[[[[[[]]]]]]}})"}) {
    CHECK(!command_of(other).has_value());
  }
  CHECK(!command_of(R"({"do":"reset","x":")" + std::string(600, 'x') + "\"}").has_value());
}

}  // namespace PALPATE_FILE
