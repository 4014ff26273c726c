// SPDX-License-Identifier: MIT

#include "reports/html/html_page.hpp"

#include <algorithm>

#include "report_assets.hpp"

#include "reports/plot/figure_look.hpp"
#include "reports/plot/figure_svg.hpp"

namespace palpate {

namespace {

/// Length of the UTF-8 character at the beginning; 0 when it is broken.
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

namespace {

std::string cell_markup(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    return "<td>" + escape_markup(*text) + "</td>";
  }
  const double value = std::get<double>(cell);
  return "<td class=\"number\" title=\"" + exact_number(value) + "\">" + short_number(value) +
         "</td>";
}

/// A column is one of numbers when its first cell is.
std::string column_head(const Table& table, std::size_t column) {
  const bool number = !table.rows.empty() && column < table.rows.front().size() &&
                      std::holds_alternative<double>(table.rows.front()[column]);
  return std::string(number ? "<th scope=\"col\" class=\"number\">" : "<th scope=\"col\">") +
         escape_markup(without_unit_one(table.columns[column])) + "</th>";
}

}  // namespace

std::string html_page(const std::string& title, const std::string& body,
                      const std::vector<std::string_view>& scripts) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n"
      "<title>" +
      escape_markup(title) + "</title>\n<style>\n" + std::string(assets::report_css) +
      "</style>\n</head>\n<body>\n" + body;
  for (const std::string_view script : scripts) {
    page += "<script>\n" + std::string(script) + "</script>\n";
  }
  return page + "</body>\n</html>\n";
}

std::string html_banner(const Banner& banner) {
  std::string print;
  for (const std::string& each : banner.small_print) {
    if (!each.empty()) { print += "<span>" + escape_markup(each) + "</span> "; }
  }
  return "<header class=\"top\">\n<h1>" + escape_markup(banner.title) +
         "</h1>\n<p class=\"print\">" + print + "</p>\n<div class=\"verdict " +
         (banner.open   ? "open"
          : banner.held ? "pass"
                        : "fail") +
         "\" role=\"status\"><strong>" + escape_markup(banner.verdict) + "</strong>" +
         (banner.detail.empty() ? "" : "<span>" + escape_markup(banner.detail) + "</span>") +
         "</div>\n</header>\n";
}

std::string html_facts(const std::vector<Fact>& facts) {
  if (facts.empty()) { return {}; }
  std::string html = "<dl class=\"facts\">\n";
  for (const Fact& fact : facts) {
    const bool lines = fact.value.find('\n') != std::string::npos;
    html += "<div><dt>" + escape_markup(fact.label) + "</dt><dd>" +
            (lines ? "<details><summary>show</summary><pre>" : "") + escape_markup(fact.value) +
            (lines ? "</pre></details>" : "");
    if (!fact.explanation.empty()) {
      html += " <span class=\"soft\">" + escape_markup(fact.explanation) + "</span>";
    }
    html += "</dd></div>\n";
  }
  return html + "</dl>\n";
}

std::string html_table(const Table& table) {
  constexpr std::size_t long_table = 24;
  constexpr std::size_t wide_table = 6;
  const bool folded = table.rows.size() > long_table;
  std::string html = "<div class=\"exhibit" +
                     std::string(table.columns.size() >= wide_table || folded ? " wide" : "") +
                     "\">";
  if (folded) {
    html += "<details><summary>" + escape_markup(table.title) + " (" +
            std::to_string(table.rows.size()) + " rows)</summary>\n";
  }
  html += "<div class=\"scroll\"><table class=\"data\">\n<caption><span>";
  if (!folded) { html += "<b>" + escape_markup(table.title) + "</b> "; }
  html += escape_markup(table.caption) + "</span></caption>\n<thead><tr>";
  for (std::size_t n = 0; n < table.columns.size(); ++n) { html += column_head(table, n); }
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const Cell& cell : row) { html += cell_markup(cell); }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>" + (folded ? "</details>" : "") + "</div>\n";
}

std::string html_figure(const Figure& figure, const std::string& svg) {
  return "<figure class=\"exhibit\"><b>" + escape_markup(figure.title) + "</b>\n" +
         html_legend(figure) + svg + "\n<figcaption>" + escape_markup(figure.caption) +
         "</figcaption></figure>\n";
}

std::string html_badge(Status status) {
  const std::string name(name_of(status));
  return "<span class=\"badge " + name + "\">" + name + "</span>";
}

std::string html_notes(const std::vector<std::string>& notes) {
  if (notes.empty()) { return {}; }
  std::string html = "<ul class=\"notes\">";
  for (const std::string& note : notes) { html += "<li>" + escape_markup(note) + "</li>"; }
  return html + "</ul>\n";
}

std::string html_provenance(const std::vector<Fact>& facts, const std::string& command) {
  return "<footer>\n<h2 id=\"provenance\">Where this comes from</h2>\n" + html_facts(facts) +
         "<h3>To see it again</h3>\n<pre>" + escape_markup(command) + "</pre>\n</footer>\n";
}

}  // namespace palpate
