// SPDX-License-Identifier: MIT
#pragma once
/// Mustache templates (https://mustache.github.io/mustache.5.html). Values are escaped by
/// escape_markup(). An empty string is treated as true; use text_or_nothing() for a section.

#include <kainjow/mustache.hpp>
#include <string>
#include <string_view>

namespace palpate {

using Data = kainjow::mustache::data;

/// Returns the template with its tags replaced by values.
std::string fill(std::string_view text, const Data& values);

/// Returns the text, or false if the text is empty.
Data text_or_nothing(const std::string& text);

/// Adds names, each followed by its value.
inline void add_names(Data&) {}
template <class... Rest>
void add_names(Data& data, const char* name, const Data& value, const Rest&... rest) {
  data.set(name, value);
  add_names(data, rest...);
}

/// Returns an object: record("text", "tip", "number", false).
template <class... NamesAndValues> Data record(const NamesAndValues&... names_and_values) {
  Data data;
  add_names(data, names_and_values...);
  return data;
}

/// Returns a list of the converted items.
template <class Items, class Convert> Data data_of(const Items& items, const Convert& convert) {
  Data list(Data::type::list);
  for (const auto& item : items) { list.push_back(convert(item)); }
  return list;
}

}  // namespace palpate
