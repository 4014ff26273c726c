// SPDX-License-Identifier: MIT
#include "reports/view_page.hpp"

#include "view_assets.hpp"

#include "reports/html_page.hpp"
#include "reports/markup.hpp"
#include "reports/packed_bytes.hpp"
#include "reports/shown_units.hpp"
#include "reports/trace_figures.hpp"
#include "reports/view_encoding.hpp"
#include "reports/view_still.hpp"

namespace palpate {

namespace {

std::string inert_script(const std::string& id, const std::string& type, const std::string& text) {
  return "<script type=\"" + type + "\" id=\"" + id + "\">" + text + "</script>\n";
}

std::string still(const std::string& title, const std::string& svg, const std::string& caption) {
  return "<figure class=\"exhibit still\"><b>" + escape_markup(title) + "</b>\n" + svg + "\n<figcaption>" +
         escape_markup(caption) + "</figcaption></figure>\n";
}

double enlarged_in_stills(const View& view) {
  if (view.tool) { return 1.0; }
  const double moved = view.frames[view.peak].displacement.colwise().norm().maxCoeff();
  const double extent = (view.rest.rowwise().maxCoeff() - view.rest.rowwise().minCoeff()).maxCoeff();
  return moved > 0.0 ? enlargement(moved, extent) : 1.0;
}

std::string stills(const View& view) {
  const ViewFrame& peak = view.frames[view.peak];
  const double enlarged = enlarged_in_stills(view);
  const std::string cut = view.place.empty() ? "" : "Cut at y = " + quantity(mm * view.cut, "mm") + ". ";
  const std::string movement = enlarged == 1.0 ? "Movement is drawn to scale. "
                                               : "Movement is drawn " + short_number(enlarged) + " times larger. ";
  return "<div class=\"exhibits stills\">\n" +
         still("Undeformed", still_at_rest(view), cut + "The skin is above, x to the right.") +
         still("Largest reaction, at " + quantity(peak.time, "s"), still_at(view, view.peak, enlarged),
               cut + movement + "Applied " + quantity(peak.applied, "N") + ", reaction " +
                   quantity(peak.reaction, "N") + ".") +
         "</div>\n";
}

}  // namespace

std::string html_view(const View& view) {
  const EncodedView encoded = encode(view);
  std::vector<std::string> notes = view.notes;
  notes.insert(notes.end(), encoded.notes.begin(), encoded.notes.end());
  return "<style>\n" + std::string(assets::view_css) + "</style>\n" + std::string(assets::view_html) +
         html_notes(notes) + stills(view) + inert_script("view-header", "application/json", encoded.header) +
         inert_script("view-numbers", "text/plain", encoded.numbers) +
         inert_script("view-three", "text/plain", base64(deflate(assets::three_js)));
}

std::string view_script() {
  std::string script = "(function () {\n'use strict';\n";
  for (const std::string_view part : {assets::view_bytes_js, assets::view_tissue_js, assets::view_shaders_js,
                                      assets::view_tool_js, assets::view_drawing_js, assets::view_camera_js,
                                      assets::view_words_js, assets::view_controls_js, assets::view_start_js}) {
    script += part;
  }
  return script + "})();\n";
}

}  // namespace palpate
