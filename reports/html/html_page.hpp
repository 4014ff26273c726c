// SPDX-License-Identifier: MIT
#pragma once
/// A report page as data, and its rendering to one HTML file that makes no request.

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "validation/number_text.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Text for HTML, SVG and XML: & < > " ' are escaped, control characters, which XML forbids, become
/// a question mark, and broken UTF-8 becomes the replacement character.
std::string escape_markup(std::string_view text);

/// One line of a list of facts.
struct Fact {
  std::string label{};
  std::string value{};
  std::string explanation{};  ///< may be empty
};

/// A status as a coloured word.
struct Badge {
  Status status = Status::pass;
  std::string text{};  ///< empty: the name of the status
};

/// Head of a page: title, small print, and the verdict with a sentence.
struct Banner {
  std::string title{};
  std::vector<std::string> small_print{};  ///< empty texts are left out
  Status status = Status::pass;            ///< colour of the verdict
  std::string verdict{};
  std::string detail{};
};

struct Paragraph {
  std::string text{};
  std::string style = "soft";  ///< class of report.css: soft, claim, reason
};

struct Notes {
  std::vector<std::string> items{};
};

/// A table whose first column names the row. On a narrow page its cells are listed with labels.
struct LabelledTable {
  enum class Kind { text, number, why };
  struct Column {
    std::string head{};
    Kind kind = Kind::text;
    std::string label{};  ///< on a narrow page; empty: the head
  };
  using Cell = std::variant<std::string, Badge>;

  std::vector<Column> columns{};
  std::vector<std::vector<Cell>> rows{};
};

/// HTML of a template, or of the 3-D view.
struct Markup {
  std::string html{};
};

struct PagePart;

/// Parts with a heading, or grouped in another way.
struct Section {
  enum class Kind {
    plain,     ///< heading, if any, and parts
    section,   ///< the same as an element of its own
    article,   ///< a case, group or recording, with a badge before its heading
    folded,    ///< parts that are hidden until the heading is clicked
    exhibits,  ///< figures and tables side by side
  };
  Kind kind = Kind::plain;
  std::string heading{};
  std::vector<PagePart> parts{};
  std::string id{};
  Badge badge{};
  std::string aside{};  ///< after the heading of an article
  std::string style{};  ///< further class of report.css
};

/// Empty facts, notes and exhibits leave no trace on the page. Tables of more than 24 rows are
/// folded behind their title.
struct PagePart : std::variant<Paragraph, Notes, std::vector<Fact>, LabelledTable, Table, Figure,
                               Markup, Section> {
  using variant::variant;
};

struct Page {
  Banner banner{};
  std::vector<PagePart> parts{};
  std::vector<Fact> provenance{};
  std::string command{};  ///< that makes the page again
  std::vector<std::string> scripts{};
};

/// Draws all figures at once and fills the templates of reports/html/templates. Same page, same
/// bytes. Throws DrawingError.
std::string render(const Page& page);

/// HTML of a badge, and of a list of notes; for use in templates and views.
std::string html_badge(const Badge& badge);
std::string html_notes(const std::vector<std::string>& notes);

/// Facts without explanation, one for each entry.
template <class Map> std::vector<Fact> facts_of_map(const Map& entries) {
  std::vector<Fact> facts;
  for (const auto& [name, value] : entries) { facts.push_back({name, value, {}}); }
  return facts;
}

/// Exhibits of several figures.
Section exhibits_of(const std::vector<Figure>& figures);

}  // namespace palpate
