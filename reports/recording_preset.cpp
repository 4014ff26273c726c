// SPDX-License-Identifier: MIT

#include "reports/recording_preset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "recording_presets.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "model/problem/input_error.hpp"
#include "reports/results/results_json.hpp"
#include "validation/number_text.hpp"
#include "validation/statistics.hpp"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

struct BuiltIn {
  std::string_view name;
  std::string_view json;
};
constexpr std::array built_in{BuiltIn{"needle-insertion-app", presets::needle_insertion_app}};

/// Reader of the keys of one JSON object. Unknown keys are refused.
class Keys {
 public:
  Keys(const Json& json, std::string place) : json_(json), place_(std::move(place)) {
    if (!json.is_object()) { refuse("must be an object"); }
  }

  [[noreturn]] void refuse(const std::string& text) const {
    throw InputError(place_ + ": " + text);
  }

  /// Returns the value of a key; null if it is absent.
  const Json* find(const char* key) {
    known_.emplace_back(key);
    const auto found = json_.find(key);
    return found == json_.end() ? nullptr : &*found;
  }
  void text(const char* key, std::string& value) {
    const Json* found = find(key);
    if (found == nullptr) { return; }
    if (!found->is_string()) { refuse(std::string(key) + " must be a text"); }
    value = *found;
  }
  void number(const char* key, double& value, double least, double most = 1e12) {
    const Json* found = find(key);
    if (found == nullptr) { return; }
    const bool fits = found->is_number() && std::isfinite(found->get<double>());
    if (!fits || found->get<double>() < least || found->get<double>() > most) {
      refuse(std::string(key) + " = " + found->dump() + "; must be a number from " +
             short_number(least) + " to " + short_number(most));
    }
    value = *found;
  }
  void count(const char* key, std::size_t& value, std::size_t least) {
    const Json* found = find(key);
    if (found == nullptr) { return; }
    constexpr std::size_t most = 1'000'000;
    if (!found->is_number_unsigned() || *found < least || *found > most) {
      refuse(std::string(key) + " = " + found->dump() + "; must be a whole number from " +
             std::to_string(least) + " to " + std::to_string(most));
    }
    value = *found;
  }
  void no_others() const {
    for (const auto& [key, value] : json_.items()) {
      if (std::ranges::find(known_, key) != known_.end()) { continue; }
      const std::string_view nearest = io::nearest_word(key, known_);
      refuse("unknown key \"" + io::printable(key) + "\"" +
             (nearest.empty() ? "" : "; did you mean " + std::string(nearest)));
    }
  }

 private:
  const Json& json_;
  std::string place_;
  std::vector<std::string_view> known_{};
};

Recording::Kind kind_named(const std::string& name, const Keys& keys) {
  std::string allowed;
  for (const auto& [word, kind] : io::kinds) {
    if (word == name) { return kind; }
    allowed.append(allowed.empty() ? "" : ", ").append(word);
  }
  keys.refuse("kind = \"" + io::printable(name) + "\"; must be one of " + allowed);
}

ContactRule contact_from(const Json& json, const std::string& place, std::size_t& mean_samples) {
  ContactRule rule;
  Keys keys(json, place + ": contact");
  keys.number("force_n", rule.force, 0.0);
  keys.number("deviations", rule.deviations, 0.0);
  double distance = 1e3 * rule.distance;
  keys.number("distance_mm", distance, 0.0);
  rule.distance = 1e-3 * distance;
  keys.count("mean_samples", mean_samples, 1);
  keys.no_others();
  return rule;
}

/// Names of the fields {NAME} of a text. Throws InputError that begins with the key.
std::vector<std::string> field_names(const std::string& text, const char* key, const Keys& keys) {
  std::vector<std::string> names;
  for (std::size_t at = 0; (at = text.find_first_of("{}", at)) != text.npos;) {
    const std::size_t end = text.find_first_of("{}", at + 1);
    if (text[at] == '}' || end == text.npos || text[end] == '{' || end == at + 1) {
      keys.refuse(std::string(key) + " = \"" + io::printable(text) +
                  "\"; every field must be {NAME}");
    }
    names.push_back(text.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return names;
}

/// Fields of a file name by the names in the pattern; empty if the name does not match. A field
/// ends where the text after it in the pattern first occurs.
std::map<std::string, std::string> fields_of(std::string_view pattern, std::string_view name) {
  std::map<std::string, std::string> fields;
  while (!pattern.empty()) {
    const std::size_t open = std::min(pattern.find('{'), pattern.size());
    if (!name.starts_with(pattern.substr(0, open))) { return {}; }
    name.remove_prefix(open);
    pattern.remove_prefix(open);
    if (pattern.empty()) { break; }
    const std::size_t close = pattern.find('}');
    if (close == pattern.npos) { return {}; }
    const std::string field(pattern.substr(1, close - 1));
    pattern.remove_prefix(close + 1);
    const std::string_view after = pattern.substr(0, pattern.find('{'));
    const std::size_t end = after.empty() ? name.size() : name.find(after);
    if (end == name.npos || end == 0) { return {}; }
    fields[field] = name.substr(0, end);
    name.remove_prefix(end);
  }
  return name.empty() ? fields : std::map<std::string, std::string>{};
}

/// Replaces the fields in a text.
std::string filled(std::string text, const std::map<std::string, std::string>& fields) {
  for (const auto& [name, value] : fields) {
    const std::string field = "{" + name + "}";
    for (std::size_t at = 0; (at = text.find(field, at)) != text.npos; at += value.size()) {
      text.replace(at, field.size(), value);
    }
  }
  return text;
}

/// Running mean over an odd number of samples, fewer at the ends; NaN is left out.
std::vector<double> running_mean(std::span<const double> value, std::size_t samples) {
  const std::size_t half = samples / 2;
  std::vector<double> mean(value.size());
  for (std::size_t n = 0; n < value.size(); ++n) {
    const std::size_t first = n - std::min(n, half);
    const std::size_t last = std::min(n + half, value.size() - 1);
    mean[n] = comparison::mean_of(comparison::finite_only(value.subspan(first, last - first + 1)));
  }
  return mean;
}

void add_note(Recording& recording, const std::string& text) {
  recording.note += (recording.note.empty() ? "" : "; ") + text;
}

}  // namespace

RecordingPreset preset_named(const std::string& name_or_file) {
  std::string known;
  for (const BuiltIn& one : built_in) {
    if (one.name == name_or_file) {
      return preset_from(std::string(one.json), "preset " + name_or_file);
    }
    known.append(known.empty() ? "" : ", ").append(one.name);
  }
  constexpr std::size_t most_bytes = std::size_t{1} << 20U;
  if (!name_or_file.ends_with(".json")) {
    throw InputError("--preset " + name_or_file + "; must be " + known +
                     " or a file NAME.json (docs/recordings.md)");
  }
  return preset_from(io::read_text(name_or_file, most_bytes), name_or_file);
}

RecordingPreset preset_from(const std::string& json, const std::string& place) {
  Json parsed;
  try {
    parsed = parse_json(json);
  } catch (const std::exception& problem) {
    throw json_trouble(place, json, problem, "a preset as docs/recordings.md describes it");
  }
  RecordingPreset preset;
  Keys keys(parsed, place);
  keys.text("name", preset.name);
  keys.text("source", preset.source);
  std::string kind(io::word_of(preset.kind));
  keys.text("kind", kind);
  preset.kind = kind_named(kind, keys);
  if (const Json* columns = keys.find("columns")) {
    if (!columns->is_object()) { keys.refuse("columns must be an object of texts, NAME: ROLE"); }
    for (const auto& [name, role] : columns->items()) {
      if (!role.is_string()) { keys.refuse("columns: the role of " + name + " must be a text"); }
      preset.read.columns.push_back(name + "=" + role.get<std::string>());
    }
  }
  double rate = 0.0;
  keys.number("rate_hz", rate, 0.0);
  if (rate > 0.0) { preset.read.sample_rate = rate; }
  keys.number("force_factor", preset.force_factor, -1e6, 1e6);
  if (preset.force_factor == 0.0) { keys.refuse("force_factor = 0; must not be 0"); }
  keys.count("tare_samples", preset.tare_samples, 0);
  if (const Json* contact = keys.find("contact")) {
    preset.contact = contact_from(*contact, place, preset.mean_samples);
  }
  keys.text("file_name", preset.file_name);
  keys.text("group", preset.group);
  keys.text("subject", preset.subject);
  const std::vector<std::string> known = field_names(preset.file_name, "file_name", keys);
  for (const std::string& name : known) {
    if (std::ranges::count(known, name) == 1) { continue; }
    keys.refuse("file_name = \"" + io::printable(preset.file_name) + "\": {" + io::printable(name) +
                "} is given twice; every field must have a name of its own");
  }
  for (const auto& [key, text] :
       {std::pair("group", preset.group), std::pair("subject", preset.subject)}) {
    for (const std::string& name : field_names(text, key, keys)) {
      if (std::ranges::find(known, name) != known.end()) { continue; }
      keys.refuse(std::string(key) + ": {" + io::printable(name) + "} is no field of file_name");
    }
  }
  keys.no_others();
  return preset;
}

void apply(const RecordingPreset& preset, const std::filesystem::path& file,
           io::ReadRecording& read) {
  Recording& recording = read.recording;
  if (recording.kind == Recording::Kind::measured) { recording.kind = preset.kind; }
  if (!preset.source.empty()) { recording.source = preset.source; }
  if (!preset.name.empty()) { add_note(recording, "preset " + preset.name); }
  for (double& force : recording.force) { force *= preset.force_factor; }
  double deviation = 0.0;
  const std::size_t count = preset.tare_samples;
  if (count > 0 && !recording.force.empty() && count >= recording.force.size()) {
    throw InputError(
        formatted("%s: %zu samples of the force; tare_samples of the preset is %zu, "
                  "and must leave samples of the insertion",
                  io::printable(file.string()).c_str(), recording.force.size(), count));
  }
  const auto rest = comparison::finite_only(
      std::span<const double>(recording.force).first(recording.force.empty() ? 0 : count));
  if (!rest.empty()) {
    const double tare = comparison::mean_of(rest);
    deviation = rest.size() > 1 ? comparison::deviation_of(rest) : 0.0;
    const std::vector<double> smooth = running_mean(rest, preset.mean_samples);
    const auto [least, most] = std::ranges::minmax(smooth);
    if (preset.contact && most - least > preset.contact->threshold(0.0)) {
      read.warnings.push_back(
          formatted("the force changes by %.3g N within the %zu samples whose mean is taken away "
                    "(tare_samples): the tissue may have been touched",
                    most - least, rest.size()));
    }
    for (double& force : recording.force) { force -= tare; }
    add_note(recording,
             formatted("force less %.4g N, the mean of the first %zu samples (SD %.3g N)", tare,
                       rest.size(), deviation));
  }
  if (preset.contact && !recording.depth.empty()) {
    const double threshold = preset.contact->threshold(deviation);
    const auto contact = find_contact(running_mean(recording.force, preset.mean_samples),
                                      recording.depth, threshold, preset.contact->distance);
    if (contact) {
      const double start = recording.depth[*contact];
      for (double& depth : recording.depth) { depth -= start; }
      add_note(recording,
               formatted("depth from the contact (%.3g N, after %.2f mm)", threshold, 1e3 * start));
    } else {
      read.warnings.push_back(formatted(
          "no contact: the force never stays above %.3g N over %.3g mm; the depth counts from the "
          "first sample",
          threshold, 1e3 * preset.contact->distance));
    }
  }
  if (preset.file_name.empty()) { return; }
  const auto fields = fields_of(preset.file_name, file.stem().string());
  if (fields.empty()) {
    read.warnings.push_back("the name of the file is not like " + preset.file_name +
                            "; it gives no group and no subject");
    return;
  }
  recording.group = filled(preset.group, fields);
  recording.subject = filled(preset.subject, fields);
}

}  // namespace palpate
