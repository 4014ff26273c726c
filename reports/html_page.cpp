// SPDX-License-Identifier: MIT
#include "reports/html_page.hpp"

#include "reports/markup.hpp"
#include "report_assets.hpp"

namespace palpate {

namespace {

std::string cell_markup(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    return "<td>" + escape_markup(*text) + "</td>";
  }
  const double value = std::get<double>(cell);
  return "<td class=\"number\" title=\"" + exact_number(value) + "\">" + short_number(value) + "</td>";
}

}  // namespace

std::string html_page(const std::string& title, const std::string& body,
                      const std::vector<std::string_view>& scripts) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>" +
      escape_markup(title) + "</title>\n<style>\n" + std::string(assets::report_css) +
      "</style>\n</head>\n<body>\n" + body;
  for (const std::string_view script : scripts) {
    page += "<script>\n" + std::string(script) + "</script>\n";
  }
  return page + "</body>\n</html>\n";
}

std::string html_facts(const std::vector<Fact>& facts) {
  std::string html = "<dl class=\"facts\">\n";
  for (const Fact& fact : facts) {
    const bool lines = fact.value.find('\n') != std::string::npos;
    html += "<dt>" + escape_markup(fact.label) + "</dt><dd>" +
            (lines ? "<details><summary>show</summary><pre>" : "") + escape_markup(fact.value) +
            (lines ? "</pre></details>" : "");
    if (!fact.explanation.empty()) {
      html += " <span class=\"soft\">" + escape_markup(fact.explanation) + "</span>";
    }
    html += "</dd>\n";
  }
  return html + "</dl>\n";
}

std::string html_table(const Table& table) {
  std::string html = "<div class=\"scroll\"><table class=\"data\">\n<caption><b>" +
                     escape_markup(table.title) + "</b>" + escape_markup(table.caption) +
                     "</caption>\n<thead><tr>";
  for (std::size_t n = 0; n < table.columns.size(); ++n) {
    const bool number = !table.rows.empty() && n < table.rows.front().size() &&
                        std::holds_alternative<double>(table.rows.front()[n]);
    html += std::string(number ? "<th class=\"number\">" : "<th>") + escape_markup(table.columns[n]) + "</th>";
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const Cell& cell : row) { html += cell_markup(cell); }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string html_figure(const Figure& figure, const std::string& svg) {
  return "<figure><b>" + escape_markup(figure.title) + "</b>\n" + svg + "\n<figcaption>" +
         escape_markup(figure.caption) + "</figcaption></figure>\n";
}

std::string html_badge(Status status) {
  const std::string name(name_of(status));
  return "<span class=\"badge " + name + "\">" + name + "</span>";
}

std::string html_provenance(const std::vector<Fact>& facts, const std::string& command) {
  return "<footer>\n<h2 id=\"provenance\">Where this comes from</h2>\n" + html_facts(facts) +
         "<p class=\"soft\">To see it again:</p>\n<pre>" + escape_markup(command) +
         "</pre>\n</footer>\n";
}

}  // namespace palpate
