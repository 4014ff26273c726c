// SPDX-License-Identifier: MIT
#pragma once
/// Mustache templates (https://mustache.github.io/mustache.5.html). Values are escaped by
/// escape_markup(). An empty string is treated as true; use text_or_nothing() for a section.

#include <kainjow/mustache.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

using Data = kainjow::mustache::data;

/// Returns the template with its tags replaced by values.
std::string fill(std::string_view text, const Data& values);

/// Returns the text, or false if the text is empty.
Data text_or_nothing(const std::string& text);

inline Data list_of(const std::vector<std::string>& texts) {
  Data list(Data::type::list);
  for (const std::string& each : texts) { list.push_back(each); }
  return list;
}

}  // namespace palpate
