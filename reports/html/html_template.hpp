// SPDX-License-Identifier: MIT
#pragma once
/// Mustache templates: https://mustache.github.io/mustache.5.html. Texts are escaped by
/// escape_markup(). An empty text counts as true: use text_or_nothing() for a section.

#include <kainjow/mustache.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

using Data = kainjow::mustache::data;

/// The template with its tags replaced.
std::string fill(std::string_view text, const Data& values);

/// The text, or false if it is empty.
Data text_or_nothing(const std::string& text);

inline Data list_of(const std::vector<std::string>& texts) {
  Data list(Data::type::list);
  for (const std::string& each : texts) { list.push_back(each); }
  return list;
}

}  // namespace palpate
