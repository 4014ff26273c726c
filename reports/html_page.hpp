// SPDX-License-Identifier: MIT
#pragma once
/// The parts that every report page shares. Everything is inline: a page makes no request.

#include <string>
#include <string_view>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// One line of a list of facts: label, value, and why it is so (may be empty).
struct Fact {
  std::string label{};
  std::string value{};
  std::string explanation{};
};

/// A whole document around `body`; `scripts` are inlined at its end.
std::string html_page(const std::string& title, const std::string& body,
                      const std::vector<std::string_view>& scripts);

/// The first thing on a page: what it is, a line of small print, and the verdict with a sentence.
struct Banner {
  std::string title{};
  std::vector<std::string> small_print{};
  bool held = true;
  bool open = false;  ///< nothing could be told, so neither good nor bad
  std::string verdict{};
  std::string detail{};
};
std::string html_banner(const Banner& banner);

std::string html_facts(const std::vector<Fact>& facts);
/// Long tables are folded away behind their title.
std::string html_table(const Table& table);
/// A figure element around an SVG of draw_figures.
std::string html_figure(const Figure& figure, const std::string& svg);
std::string html_badge(Status status);
std::string html_notes(const std::vector<std::string>& notes);
std::string html_provenance(const std::vector<Fact>& facts, const std::string& command);

}  // namespace palpate
