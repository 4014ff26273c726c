// SPDX-License-Identifier: MIT
/// The commands `keys` and `schema`: keys of scene files, as text and as JSON Schema.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "fixtures/io/problems.hpp"
#include "fixtures/io/scene_keys.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace palpate::io {
namespace {

using Json = nlohmann::ordered_json;

// JSON Schema of the value of a key, by the type of its member. Ranges apply to its numbers.

void add_range(Json& schema, const Range& range) {
  if (!range.only.empty()) {
    schema["enum"] = std::vector<int>(range.only.begin(), range.only.end());
    return;
  }
  if (std::isfinite(range.low)) {
    schema[range.above_low ? "exclusiveMinimum" : "minimum"] = range.low;
  }
  if (std::isfinite(range.high)) {
    schema[range.below_high ? "exclusiveMaximum" : "maximum"] = range.high;
  }
}

Json number_schema(const char* type, const Range& range) {
  Json schema{{"type", type}};
  add_range(schema, range);
  return schema;
}

template <Enum E> Json words_schema() {
  Json list = Json::array();
  for (const auto& [word, value] : words(E{})) { list.push_back(word); }
  return {{"enum", list}};
}

Json list_schema(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

Json coordinates_schema(Json items, std::size_t count) {
  Json schema = list_schema(std::move(items));
  schema["minItems"] = count;
  schema["maxItems"] = count;
  return schema;
}

Json schema_of(double, const Range& range) { return number_schema("number", range); }
Json schema_of(int, const Range& range) { return number_schema("integer", range); }
Json schema_of(bool, const Range&) { return {{"type", "boolean"}}; }
Json schema_of(const std::string&, const Range&) { return {{"type", "string"}}; }
template <Enum E> Json schema_of(E, const Range&) { return words_schema<E>(); }
template <Coordinates T> Json schema_of(const T& values, const Range& range) {
  const bool whole = std::is_same_v<std::remove_cvref_t<decltype(values[0])>, int>;
  return coordinates_schema(number_schema(whole ? "integer" : "number", range),
                            static_cast<std::size_t>(values.size()));
}
template <class T> Json schema_of(const std::vector<T>&, const Range& range) {
  Json schema = list_schema(schema_of(T{}, range));
  if constexpr (Enum<T>) { schema["uniqueItems"] = true; }
  return schema;
}
template <class T> Json schema_of(const std::optional<T>&, const Range& range) {
  return schema_of(T{}, range);
}
template <class T> Json schema_of(const AutoOr<T>&, const Range& range) {
  return {{"anyOf", Json::array({{{"const", "auto"}}, schema_of(T{}, range)})}};
}
template <class T> Json schema_of(const Preset<T>& preset, const Range&) {
  return {{"enum", Json::array({preset.words[0].first, preset.words[1].first})}};
}
template <class T> Json schema_of(const FixedFaces<T>&, const Range&) {
  Json faces = words_schema<Face>();
  Json list = list_schema(faces);
  list["uniqueItems"] = true;
  return {{"anyOf", Json::array({{{"const", "none"}}, faces, list})}};
}
template <class T> Json schema_of(const NodeOf<T>&, const Range& range) {
  return number_schema("integer", range);
}
template <class T> Json schema_of(const PointOf<T>&, const Range& range) {
  return schema_of(Eigen::Vector3d(0.0, 0.0, 0.0), range);
}
template <class T> Json schema_of(const Edges<T>& edges, const Range& range) {
  return {{"anyOf", Json::array({schema_of(0.0, range), schema_of(edges.size, range)})}};
}
template <class T> Json schema_of(const ProbeShape<T>&, const Range&) {
  return words_schema<Probe::Shape>();
}
template <class T> Json schema_of(const GaugeOf<T>&, const Range&) {
  Json gauges = Json::array();
  for (int gauge = 1; gauge < 100; ++gauge) {
    if (diameter_of_gauge(gauge)) { gauges.push_back(gauge); }
  }
  return {{"enum", gauges}};
}
template <class T> Json schema_of(const Label<T>&, const Range&) {
  return {{"type", "string"}, {"pattern", "^[^,\"/\\\\\\u0000-\\u001f]+$"}};
}
Json schema_of(const FileName&, const Range&) { return {{"type", "string"}, {"minLength", 1}}; }
Json schema_of(const LabelMaterials&, const Range&) {
  return {{"type", "object"},
          {"patternProperties", {{"^-?[0-9]+$", {{"type", "string"}}}}},
          {"additionalProperties", false}};
}

/// Visitor of scene_keys.hpp that writes the schema of a table.
class SchemaWriter {
 public:
  template <class T> void value(std::string_view name, T&& member, const Key& key) {
    Json schema = schema_of(member, key.range);
    const std::string unit =
        key.unit.empty() || key.unit == "1" ? "" : " [" + std::string(key.unit) + "]";
    schema["description"] = std::string(key.doc) + unit;
    // Defaults that depend on other keys are sentences, not values.
    const Json otherwise =
        key.required || key.endless ? Json() : Json::parse(value_text(member), nullptr, false);
    if (!otherwise.is_null() && !otherwise.is_discarded()) { schema["default"] = otherwise; }
    properties_[std::string(name)] = std::move(schema);
    if (key.required) { required_.push_back(name); }
  }
  template <class T> void table(std::string_view name, T& member) {
    properties_[std::string(name)] = inside(member);
  }
  template <class T> void optional_table(std::string_view name, std::optional<T>&) {
    T member{};
    properties_[std::string(name)] = inside(member);
  }
  template <class T> void list(std::string_view name, std::vector<T>&) {
    T member{};
    properties_[std::string(name)] = list_schema(inside(member));
  }
  void exactly_one(std::string_view a, std::string_view b) {
    rules_.push_back({{"oneOf", Json::array({requires_all({a}), requires_all({b})})}});
  }
  void at_most_one(std::string_view a, std::string_view b) {
    rules_.push_back({{"not", requires_all({a, b})}});
  }

  [[nodiscard]] Json schema() const {
    Json schema{{"type", "object"}, {"properties", properties_}, {"additionalProperties", false}};
    if (!required_.empty()) { schema["required"] = required_; }
    if (!rules_.empty()) { schema["allOf"] = rules_; }
    return schema;
  }

 private:
  static Json requires_all(const std::vector<std::string_view>& names) {
    return {{"required", names}};
  }
  template <class T> static Json inside(T& member) {
    SchemaWriter writer;
    fields(writer, member);
    return writer.schema();
  }

  Json properties_ = Json::object();
  Json required_ = Json::array();
  Json rules_ = Json::array();
};

}  // namespace

/// Returns the JSON Schema of a scene file.
Json scene_schema() {
  SchemaWriter writer;
  SceneDraft draft;
  fields(writer, draft);
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"title", "Palpate scene"}};
  schema.update(writer.schema());
  return schema;
}

}  // namespace palpate::io

namespace palpate::cli {
namespace {

using Json = nlohmann::ordered_json;

struct KeysOptions : CommonOptions {
  std::string table{};
};

/// Returns the name of a table without the marks of lists.
std::string plain_table(std::string table) {
  for (auto at = table.find("[]"); at != table.npos; at = table.find("[]")) { table.erase(at, 2); }
  return table;
}

std::string dotted_key(const io::ManualRow& row) {
  const std::string table = plain_table(row.table);
  return table.empty() ? row.key : table + "." + row.key;
}

/// Returns the keys of a table and of its inner tables, or one key. Throws InputError.
std::vector<io::ManualRow> rows_of(const std::string& name) {
  std::vector<io::ManualRow> rows = io::scene_manual();
  if (name.empty()) { return rows; }
  std::set<std::string> names;
  for (const io::ManualRow& row : rows) {
    names.insert({plain_table(row.table), dotted_key(row), row.key});
  }
  names.erase("");
  std::erase_if(rows, [&name](const io::ManualRow& row) {
    const std::string table = plain_table(row.table);
    return table != name && !table.starts_with(name + ".") && dotted_key(row) != name &&
           row.key != name;
  });
  if (!rows.empty()) { return rows; }
  const std::string_view nearest = io::nearest_word(name, {names.begin(), names.end()});
  throw InputError("keys " + name + ": no table or key of a scene" +
                   (nearest.empty() ? "; `palpate keys` lists all"
                                    : "; did you mean " + std::string(nearest) + "?"));
}

void print_row(const io::ManualRow& row) {
  const std::string unit = row.unit.empty() || row.unit == "1" ? "" : " [" + row.unit + "]";
  const std::string allowed = row.range.text().empty() ? "" : ", " + row.range.text();
  const std::string otherwise = row.otherwise == "required" ? "; required"
                                : row.otherwise.empty()     ? ""
                                                            : "; default " + row.otherwise;
  std::printf("  %-20s %s%s%s%s\n  %-20s %s\n", row.key.c_str(), row.kind.c_str(), unit.c_str(),
              allowed.c_str(), otherwise.c_str(), "", row.doc.c_str());
}

int run_keys(const KeysOptions& options) {
  const std::vector<io::ManualRow> rows = rows_of(options.table);
  if (options.json) {
    Json list = Json::array();
    for (const io::ManualRow& row : rows) {
      list.push_back({{"key", dotted_key(row)},
                      {"kind", row.kind},
                      {"unit", row.unit},
                      {"allowed", row.range.text()},
                      {"default", row.otherwise},
                      {"meaning", row.doc}});
    }
    std::printf("%s\n", list.dump(2).c_str());
    return done;
  }
  std::string table = "none yet";
  for (const io::ManualRow& row : rows) {
    if (row.table != table) {
      const bool first = table == "none yet";
      table = row.table;
      const std::string name = plain_table(table);
      std::printf("%s%s\n", first ? "" : "\n",
                  table.empty()           ? "top of the file"
                  : table.ends_with("[]") ? ("[[" + name + "]], any number").c_str()
                                          : ("[" + name + "]").c_str());
    }
    print_row(row);
  }
  return done;
}

int run_schema(const CommonOptions&) {
  std::printf("%s\n", io::scene_schema().dump(2).c_str());
  return done;
}

}  // namespace

void add_scene_keys(Program& program) {
  const auto [command, options] = add_command(
      program, "keys", "list the keys of a scene: unit, range, default, meaning", run_keys);
  add_value(command, "table", options.table, "TABLE",
            "table such as needle or tissue.mesh, or one key [all]");
  add_json(command, options);
  writes_nothing(command);
}

void add_schema(Program& program) {
  const auto [command, options] =
      add_command(program, "schema", "print the JSON Schema of a scene, for editors", run_schema);
  writes_nothing(command);
  command.footer("docs/scenes.md shows how an editor uses it.");
}

}  // namespace palpate::cli
