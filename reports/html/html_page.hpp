// SPDX-License-Identifier: MIT
#pragma once
/// Report page as data, and its rendering to a self-contained HTML file.

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "validation/number_text.hpp"
#include "validation/outcome.hpp"

namespace palpate {

// Factors from SI units to displayed units.
inline constexpr double mm = 1e3;  ///< [mm/m]
inline constexpr double mj = 1e3;  ///< [mJ/J]
inline constexpr double us = 1e6;  ///< [us/s]

/// Escapes text for HTML, SVG and XML: & < > " ' are escaped, control characters that XML forbids
/// become a question mark, and invalid UTF-8 becomes the replacement character.
std::string escape_markup(std::string_view text);

/// Number with its noun: "1 case", "2 cases".
template <class Count>
std::string counted(Count count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string capitalised(std::string text);  ///< with a capital as its first letter

struct Fact {
  std::string label{};
  std::string value{};
  std::string explanation{};  ///< may be empty
};

struct Badge {
  Status status = Status::pass;
  std::string text{};  ///< displayed text; if empty, the name of the status
};

/// Header of a page: title, small print, verdict and one sentence of detail.
struct Banner {
  std::string title{};
  std::vector<std::string> small_print{};  ///< empty strings are omitted
  Status status = Status::pass;            ///< colour of the verdict
  std::string verdict{};
  std::string detail{};
};

struct Paragraph {
  std::string text{};
  std::string style = "soft";  ///< CSS class in report.css: soft, claim or reason
};

struct Notes {
  std::vector<std::string> items{};
};

/// Table with a row name in the first column. The last column holds an explanation, the `numbers`
/// columns before it are aligned to the right. On a narrow page each cell is listed with its head.
struct LabelledTable {
  using Cell = std::variant<std::string, Badge>;

  std::vector<std::string> columns{};
  std::size_t numbers = 0;
  std::vector<std::vector<Cell>> rows{};
};

/// HTML from a template or from the 3-D view.
struct Markup {
  std::string html{};
};

/// Group of page parts, with an optional heading. A template, because a part may be a group: its
/// members are initialised where the type of a part is complete.
template <class Part> struct SectionOf {
  enum class Kind {
    plain,     ///< heading, if any, and parts
    section,   ///< same, in a <section> element
    article,   ///< case, group or recording, with a badge before the heading
    folded,    ///< parts that are hidden until the heading is clicked
    exhibits,  ///< figures and tables side by side
  };
  Kind kind = Kind::plain;
  std::string heading{};
  std::vector<Part> parts{};
  std::string id{};
  Badge badge{};
  std::string aside{};  ///< text after the heading of an article
  std::string style{};  ///< additional CSS class in report.css
};

struct PagePart;
using Section = SectionOf<PagePart>;

/// One part of a page. Empty facts, notes and exhibits produce no HTML. Tables of more than 24 rows
/// are collapsed below their title.
struct PagePart : std::variant<Paragraph, Notes, std::vector<Fact>, LabelledTable, Table, Figure,
                               Markup, Section> {
  using variant::variant;
};

struct Page {
  Banner banner{};
  std::vector<PagePart> parts{};
  std::vector<Fact> provenance{};
  std::string command{};  ///< command line that reproduces the page
  std::vector<std::string> scripts{};
};

/// Renders the page from the templates in reports/html/templates. All figures are drawn in one
/// call. Output is deterministic. Throws DrawingError.
std::string render(const Page& page);

std::string html_badge(const Badge& badge);

template <class Map> std::vector<Fact> facts_of_map(const Map& entries) {
  std::vector<Fact> facts;
  for (const auto& [name, value] : entries) { facts.push_back({name, value, {}}); }
  return facts;
}

/// Returns the part, below a heading that unfolds it if `folded` is true.
PagePart folded_if(bool folded, const std::string& heading, PagePart part);

Section exhibits_of(const std::vector<Figure>& figures);

}  // namespace palpate
