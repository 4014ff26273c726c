// SPDX-License-Identifier: MIT

#include "reports/html/html_page.hpp"

#include <algorithm>
#include <utility>

#include "html_templates.hpp"
#include "report_assets.hpp"

#include "reports/html/html_template.hpp"
#include "reports/plot/figure_look.hpp"
#include "reports/plot/figure_svg.hpp"

namespace palpate {

namespace {

/// Length of the UTF-8 character at the start of the text [bytes]; 0 if it is invalid.
std::size_t character_length(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length > text.size()) { return 0; }
  for (std::size_t n = 1; n < length; ++n) {
    if ((static_cast<unsigned char>(text[n]) & 0xC0U) != 0x80U) { return 0; }
  }
  return length;
}

}  // namespace

std::string escape_markup(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text.substr(at));
    const char c = text[at];
    const bool control = static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t';
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += length == 0 ? "\ufffd" : control ? "?" : text.substr(at, length);
    }
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::string fill(std::string_view text, const Data& values) {
  kainjow::mustache::mustache page{std::string(text)};
  page.set_custom_escape([](const std::string& each) { return escape_markup(each); });
  return page.render(values);
}

Data text_or_nothing(const std::string& text) { return text.empty() ? Data(false) : Data(text); }

std::string html_badge(const Badge& badge) {
  const std::string name(name_of(badge.status));
  Data values;
  values.set("colour", name);
  values.set("text", badge.text.empty() ? name : badge.text);
  return fill(templates::parts, {"badge", values});
}

std::string html_notes(const std::vector<std::string>& notes) {
  if (notes.empty()) { return {}; }
  return fill(templates::parts, {"notes", Data("items", list_of(notes))});
}

Section exhibits_of(const std::vector<Figure>& figures) {
  return {.kind = Section::Kind::exhibits, .parts = {figures.begin(), figures.end()}};
}

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
    Data items(Data::type::list);
    for (const Fact& fact : facts) {
      Data item;
      item.set("label", fact.label);
      item.set("value", fact.value);
      item.set("lines", fact.value.find('\n') != std::string::npos);
      item.set("explanation", text_or_nothing(fact.explanation));
      items.push_back(item);
    }
    return fill(templates::parts, {"facts", Data("items", items)});
  }

 private:
  static void collect(const std::vector<PagePart>& parts, std::vector<const Figure*>& figures) {
    for (const PagePart& part : parts) {
      if (const auto* figure = std::get_if<Figure>(&part)) { figures.push_back(figure); }
      if (const auto* section = std::get_if<Section>(&part)) { collect(section->parts, figures); }
    }
  }

  static std::string html(const Paragraph& paragraph) {
    Data values;
    values.set("style", paragraph.style);
    values.set("text", paragraph.text);
    return fill(templates::parts, {"paragraph", values});
  }

  static std::string html(const Notes& notes) { return html_notes(notes.items); }
  static std::string html(const Markup& markup) { return markup.html; }

  static std::string html(const Table& table) {
    constexpr std::size_t long_table = 24;
    constexpr std::size_t wide_table = 6;
    const bool folded = table.rows.size() > long_table;
    Data values;
    values.set("title", table.title);
    values.set("caption", table.caption);
    values.set("count", std::to_string(table.rows.size()));
    values.set("folded", folded);
    values.set("wide", folded || table.columns.size() >= wide_table);
    Data columns(Data::type::list);
    for (std::size_t n = 0; n < table.columns.size(); ++n) {
      const bool number = !table.rows.empty() && n < table.rows.front().size() &&
                          std::holds_alternative<double>(table.rows.front()[n]);
      Data column("text", without_unit_one(table.columns[n]));
      column.set("number", number);
      columns.push_back(column);
    }
    Data rows(Data::type::list);
    for (const auto& row : table.rows) {
      Data cells(Data::type::list);
      for (const Cell& cell : row) { cells.push_back(cell_of(cell)); }
      rows.push_back(Data("cells", cells));
    }
    values.set("columns", columns);
    values.set("rows", rows);
    return fill(templates::table, values);
  }

  static Data cell_of(const Cell& cell) {
    const auto* number = std::get_if<double>(&cell);
    Data values("text", number == nullptr ? std::get<std::string>(cell) : short_number(*number));
    values.set("exact", number == nullptr ? Data(false) : Data(exact_number(*number)));
    return values;
  }

  static std::string html(const LabelledTable& table) {
    using Kind = LabelledTable::Kind;
    Data columns(Data::type::list);
    for (const auto& column : table.columns) {
      Data values("head", column.head);
      values.set("number", column.kind == Kind::number);
      columns.push_back(values);
    }
    Data rows(Data::type::list);
    for (const auto& row : table.rows) {
      Data cells(Data::type::list);
      for (std::size_t n = 1; n < row.size(); ++n) {
        const LabelledTable::Column& column = table.columns[n];
        const auto* badge = std::get_if<Badge>(&row[n]);
        Data values("label", column.label.empty() ? column.head : column.label);
        values.set("style", column.kind == Kind::number ? Data("number")
                            : column.kind == Kind::why  ? Data("why")
                                                        : Data(false));
        values.set("badge", badge == nullptr ? "" : html_badge(*badge));
        values.set("text", badge == nullptr ? std::get<std::string>(row[n]) : "");
        cells.push_back(values);
      }
      Data values("name", std::get<std::string>(row.front()));
      values.set("cells", cells);
      rows.push_back(values);
    }
    Data values("columns", columns);
    values.set("rows", rows);
    return fill(templates::labelled, values);
  }

  std::string html(const Figure& figure) {
    Data values("title", figure.title);
    values.set("legend", html_legend(figure));
    values.set("svg", drawings_.at(next_++));
    values.set("caption", figure.caption);
    return fill(templates::parts, {"figure", values});
  }

  std::string html(const Section& section) {
    using Kind = Section::Kind;
    const std::string content = all(section.parts);
    if (section.kind == Kind::exhibits && content.empty()) { return {}; }
    const bool with_heading = section.kind == Kind::plain || section.kind == Kind::section;
    Data values("content", content);
    values.set("heading", section.heading);
    values.set("h2", with_heading ? text_or_nothing(section.heading) : Data(false));
    values.set("section", section.kind == Kind::section);
    values.set("article", section.kind == Kind::article);
    values.set("folded", section.kind == Kind::folded);
    values.set("exhibits", section.kind == Kind::exhibits);
    values.set("id", text_or_nothing(section.id));
    values.set("badge", html_badge(section.badge));
    values.set("aside", text_or_nothing(section.aside));
    values.set("style", text_or_nothing(section.style));
    return fill(templates::section, values);
  }

  std::vector<std::string> drawings_{};
  std::size_t next_ = 0;
};

std::string colour_of(Status status) {
  return status == Status::pass ? "pass" : status == Status::inconclusive ? "open" : "fail";
}

}  // namespace

std::string render(const Page& page) {
  const Banner& banner = page.banner;
  Renderer renderer(page.parts);
  Data values("title", banner.title);
  std::vector<std::string> print = banner.small_print;
  std::erase(print, "");
  values.set("style", std::string(assets::report_css));
  values.set("print", list_of(print));
  values.set("colour", colour_of(banner.status));
  values.set("verdict", banner.verdict);
  values.set("detail", text_or_nothing(banner.detail));
  values.set("content", renderer.all(page.parts));
  values.set("provenance", renderer.html(page.provenance));
  values.set("command", page.command);
  values.set("scripts", list_of(page.scripts));
  return fill(templates::page, values);
}

}  // namespace palpate
