// SPDX-License-Identifier: MIT
#include "reports/timing/callgrind_output.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

#include "fixtures/io/file_bytes.hpp"
#include "model/dynamics/scene_check.hpp"

namespace palpate::timing {

namespace {

constexpr std::size_t most_bytes = 1U << 26U;
constexpr std::string_view request = "desc: Trigger: Client Request: ";

/// What stands behind a key at the start of a line.
std::optional<std::string> after(const std::string& line, std::string_view key) {
  if (!line.starts_with(key)) { return std::nullopt; }
  return line.substr(key.size());
}

template <class Integer>
Integer number_from(const std::string& text, const std::string& file) {
  Integer number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc() || rest != end) {
    throw InputError(file + ": \"" + text + "\" where a count should be; a whole number");
  }
  return number;
}

}  // namespace

CallgrindPart part_from(const std::string& text, const std::string& file) {
  CallgrindPart part;
  bool counted = false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (const auto creator = after(line, "creator: ")) { part.creator = *creator; }
    if (const auto label = after(line, request)) { part.label = *label; }
    if (const auto number = after(line, "part: ")) { part.number = number_from<int>(*number, file); }
    if (const auto events = after(line, "events: "); events && *events != "Ir") {
      throw InputError(file + ": counts " + *events + "; Ir alone");
    }
    if (const auto totals = after(line, "totals: ")) {
      part.instructions = number_from<std::int64_t>(*totals, file);
      counted = true;
    }
  }
  if (!counted) { throw InputError(file + ": ends without totals; a whole file of callgrind"); }
  return part;
}

std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder) {
  std::vector<CallgrindPart> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    parts.push_back(part_from(io::read_text(entry.path(), most_bytes), entry.path().string()));
  }
  std::erase_if(parts, [](const CallgrindPart& part) { return part.label.empty(); });
  std::ranges::sort(parts, {}, &CallgrindPart::number);
  return parts;
}

}  // namespace palpate::timing
