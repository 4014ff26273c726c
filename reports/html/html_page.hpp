// SPDX-License-Identifier: MIT
#pragma once
/// Text inside HTML, SVG and XML; numbers are told in the words of number_words.hpp.

#include <string>
#include <string_view>
#include <vector>

#include "validation/number_text.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// & < > " ' escaped; control characters, which XML forbids, become a question mark, and
/// broken UTF-8 the sign that Unicode has for it.
std::string escape_markup(std::string_view text);

// The parts that every report page shares. Everything is inline: a page makes no request.

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
