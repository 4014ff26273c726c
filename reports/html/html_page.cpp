// SPDX-License-Identifier: MIT

#include "reports/html/html_page.hpp"

#include <algorithm>
#include <cctype>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "html_templates.hpp"
#include "report_assets.hpp"

#include "reports/html/html_template.hpp"
#include "reports/plot/figure_svg.hpp"

namespace palpate {
namespace {

/// Renders parts in order. The drawings are used in the order of the figures.
class Renderer {
 public:
  explicit Renderer(const std::vector<PagePart>& parts) {
    std::vector<const Figure*> figures;
    collect(parts, figures);
    drawings_ = draw_figures(figures);
  }

  std::string all(const std::vector<PagePart>& parts) {
    std::string html;
    for (const PagePart& part : parts) {
      html += std::visit([this](const auto& each) { return this->html(each); }, part);
    }
    return html;
  }

  std::string html(const std::vector<Fact>& facts) {
    if (facts.empty()) { return {}; }
    const auto item = [](const Fact& fact) {
      return record("label", fact.label, "value", fact.value, "lines",
                    fact.value.find('\n') != std::string::npos, "explanation",
                    text_or_nothing(fact.explanation));
    };
    return fill(templates::parts, record("facts", record("items", data_of(facts, item))));
  }

 private:
  static void collect(const std::vector<PagePart>& parts, std::vector<const Figure*>& figures) {
    for (const PagePart& part : parts) {
      if (const auto* figure = std::get_if<Figure>(&part)) { figures.push_back(figure); }
      if (const auto* section = std::get_if<Section>(&part)) { collect(section->parts, figures); }
    }
  }

  static std::string html(const Paragraph& paragraph) {
    return fill(templates::parts,
                record("paragraph", record("style", paragraph.style, "text", paragraph.text)));
  }
  static std::string html(const Notes& notes) {
    if (notes.items.empty()) { return {}; }
    return fill(templates::parts,
                record("notes", record("items", data_of(notes.items, std::identity()))));
  }
  static std::string html(const Markup& markup) { return markup.html; }

  static std::string html(const Table& table) {
    constexpr std::size_t long_table = 24;
    constexpr std::size_t wide_table = 6;
    const bool folded = table.rows.size() > long_table;
    Data columns(Data::type::list);
    for (std::size_t n = 0; n < table.columns.size(); ++n) {
      const bool number = !table.rows.empty() && n < table.rows.front().size() &&
                          std::holds_alternative<double>(table.rows.front()[n]);
      columns.push_back(record("text", without_unit_one(table.columns[n]), "number", number));
    }
    const auto row = [](const std::vector<Cell>& cells) {
      return record("cells", data_of(cells, cell_of));
    };
    return fill(templates::table, record("title", table.title, "caption", table.caption, "count",
                                         std::to_string(table.rows.size()), "folded", folded,
                                         "wide", folded || table.columns.size() >= wide_table,
                                         "columns", columns, "rows", data_of(table.rows, row)));
  }

  static Data cell_of(const Cell& cell) {
    if (const auto* text = std::get_if<std::string>(&cell)) {
      return record("text", *text, "exact", false);
    }
    const double number = std::get<double>(cell);
    return record("text", short_number(number), "exact", exact_number(number));
  }

  static std::string html(const LabelledTable& table) {
    const std::size_t last = table.columns.size() - 1;
    const auto is_number = [&](std::size_t n) { return n < last && n + table.numbers >= last; };
    Data columns(Data::type::list);
    for (std::size_t n = 0; n <= last; ++n) {
      columns.push_back(record("head", table.columns[n], "number", is_number(n)));
    }
    Data rows(Data::type::list);
    for (const auto& row : table.rows) {
      Data cells(Data::type::list);
      for (std::size_t n = 1; n < row.size(); ++n) {
        const auto* badge = std::get_if<Badge>(&row[n]);
        cells.push_back(record("label", table.columns[n], "style",
                               is_number(n) ? Data("number")
                               : n == last  ? Data("why")
                                            : Data(false),
                               "badge", badge == nullptr ? "" : html_badge(*badge), "text",
                               badge == nullptr ? std::get<std::string>(row[n]) : ""));
      }
      rows.push_back(record("name", std::get<std::string>(row.front()), "cells", cells));
    }
    return fill(templates::labelled, record("columns", columns, "rows", rows));
  }

  std::string html(const Figure& figure) {
    return fill(templates::parts,
                record("figure", record("title", figure.title, "legend", html_legend(figure), "svg",
                                        drawings_.at(next_++), "caption", figure.caption)));
  }

  std::string html(const Section& section) {
    using Kind = Section::Kind;
    const std::string content = all(section.parts);
    if (section.kind == Kind::exhibits && content.empty()) { return {}; }
    const bool with_heading = section.kind == Kind::plain || section.kind == Kind::section;
    return fill(
        templates::section,
        record("content", content, "heading", section.heading, "h2",
               with_heading ? text_or_nothing(section.heading) : Data(false), "section",
               section.kind == Kind::section, "article", section.kind == Kind::article, "folded",
               section.kind == Kind::folded, "exhibits", section.kind == Kind::exhibits, "id",
               text_or_nothing(section.id), "badge", html_badge(section.badge), "aside",
               text_or_nothing(section.aside), "style", text_or_nothing(section.style)));
  }

  std::vector<std::string> drawings_{};
  std::size_t next_ = 0;
};

}  // namespace

std::string escape_markup(std::string_view text) {
  using Json = nlohmann::json;  // replaces invalid UTF-8
  const Json valid = Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
  std::string shown = valid.get_ref<const std::string&>();
  // XML 1.0 has no U+FFFE and U+FFFF.
  for (const std::string_view none : {"\xef\xbf\xbe", "\xef\xbf\xbf"}) {
    for (std::size_t at = 0; (at = shown.find(none, at)) != shown.npos;) {
      shown.replace(at, none.size(), "\xef\xbf\xbd");
    }
  }
  std::string out;
  for (const char c : shown) {
    const auto byte = static_cast<unsigned char>(c);
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += byte < 32 && c != '\n' && c != '\t' ? '?' : c;
    }
  }
  return out;
}

std::string capitalised(std::string text) {
  if (!text.empty()) {
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  }
  return text;
}

std::string fill(std::string_view text, const Data& values) {
  kainjow::mustache::mustache page{std::string(text)};
  page.set_custom_escape([](const std::string& each) { return escape_markup(each); });
  return page.render(values);
}

Data text_or_nothing(const std::string& text) { return text.empty() ? Data(false) : Data(text); }

std::string html_badge(const Badge& badge) {
  const std::string name(name_of(badge.status));
  return fill(templates::parts, record("badge", record("colour", name, "text",
                                                       badge.text.empty() ? name : badge.text)));
}

PagePart folded_if(bool folded, const std::string& heading, PagePart part) {
  if (!folded) { return part; }
  return Section{.kind = Section::Kind::folded, .heading = heading, .parts = {std::move(part)}};
}

Section exhibits_of(const std::vector<Figure>& figures) {
  return {.kind = Section::Kind::exhibits, .parts = {figures.begin(), figures.end()}};
}

std::string render(const Page& page) {
  const Banner& banner = page.banner;
  Renderer renderer(page.parts);
  std::vector<std::string> print = banner.small_print;
  std::erase(print, "");
  return fill(templates::page,
              record("title", banner.title, "style", std::string(assets::report_css), "print",
                     data_of(print, std::identity()), "colour",
                     banner.status == Status::pass           ? "pass"
                     : banner.status == Status::inconclusive ? "open"
                                                             : "fail",
                     "verdict", banner.verdict, "detail", text_or_nothing(banner.detail), "content",
                     renderer.all(page.parts), "provenance", renderer.html(page.provenance),
                     "command", page.command, "scripts", data_of(page.scripts, std::identity())));
}

}  // namespace palpate
