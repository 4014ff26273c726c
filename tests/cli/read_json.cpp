// SPDX-License-Identifier: MIT
/// Prints one value of a JSON file: read_json FILE KEY/KEY. Text comes without quotes.

#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

int main(int argc, char** argv) {
  try {
    std::ifstream file(argc > 1 ? argv[1] : "");
    const auto value =
        nlohmann::json::parse(file).at(nlohmann::json::json_pointer("/" + std::string(argv[2])));
    std::printf("%s\n",
                value.is_string() ? value.get<std::string>().c_str() : value.dump().c_str());
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 2;
  }
  return 0;
}
