// SPDX-License-Identifier: MIT

#include "reports/view/view_page.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "view_assets.hpp"

#include "reports/plot/shown_units.hpp"
#include "reports/plot/trace_figures.hpp"
#include "reports/view/view_encoding.hpp"

namespace palpate {

namespace {

/// Nodes in a thin slab around the nodes that are nearest to the plane of the cut.
std::vector<Eigen::Index> section_of(const View& view) {
  const auto y = view.rest.row(1);
  Eigen::Index nearest = 0;
  (y.array() - view.cut).abs().minCoeff(&nearest);
  const double half_thickness = std::max(0.02 * (y.maxCoeff() - y.minCoeff()), 1e-9);
  std::vector<Eigen::Index> nodes;
  for (Eigen::Index n = 0; n < y.size(); ++n) {
    if (std::abs(y(n) - y(nearest)) <= half_thickness) { nodes.push_back(n); }
  }
  return nodes;
}

/// Figure of the x-z plane with the skin above.
Figure section_figure(const std::string& id, const std::string& title, const std::string& caption,
                      const Eigen::Matrix2Xd& points) {
  const double low = points.row(1).minCoeff();
  const double high = points.row(1).maxCoeff();
  const double rim =
      0.08 * std::max(high - low, points.row(0).maxCoeff() - points.row(0).minCoeff());
  return {.id = id,
          .title = title,
          .caption = caption,
          .x = {.label = "x (mm)"},
          .y = {.label = "z (mm)", .minimum = high + rim, .maximum = low - rim},
          .square = true};
}

/// Places of the section's nodes in the x-z plane, with displacements times `enlarged` [mm].
Eigen::Matrix2Xd places_of(const View& view, const std::vector<Eigen::Index>& nodes,
                           const ViewFrame& frame, double enlarged) {
  const NodeVectors position = view.rest + enlarged * frame.displacement;
  return mm * position(std::array{0, 2}, nodes);
}

/// Value of the nearest point at every pixel; none beyond the largest distance of neighbours.
HeatMap nearest_values(const Eigen::Matrix2Xd& points, const Eigen::VectorXd& values) {
  constexpr double pixels = 96.0;
  const Eigen::Vector2d low = points.rowwise().minCoeff();
  const Eigen::Vector2d high = points.rowwise().maxCoeff();
  const double size = std::max((high - low).maxCoeff(), 1e-9) / pixels;
  double reach = 0.0;
  for (const auto& point : points.colwise()) {
    const auto distance = (points.colwise() - point).colwise().squaredNorm();
    reach = std::max(reach, (distance.array() > 0.0).select(distance.array(), 1e300).minCoeff());
  }
  HeatMap map{.label = "displacement (mm)"};
  for (double x = low.x(); x <= high.x() + 0.5 * size; x += size) { map.x.push_back(x); }
  for (double z = low.y(); z <= high.y() + 0.5 * size; z += size) { map.y.push_back(z); }
  for (const double z : map.y) {
    for (const double x : map.x) {
      Eigen::Index nearest = 0;
      const double distance =
          (points.colwise() - Eigen::Vector2d(x, z)).colwise().squaredNorm().minCoeff(&nearest);
      map.z.push_back(distance <= reach ? values(nearest)
                                        : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return map;
}

double enlargement_of(const View& view, const ViewFrame& frame) {
  const double moved = frame.displacement.colwise().norm().maxCoeff();
  const Eigen::Vector3d extent = view.rest.rowwise().maxCoeff() - view.rest.rowwise().minCoeff();
  return view.tool || !(moved > 0.0) ? 1.0 : enlargement(moved, extent.maxCoeff());
}

}  // namespace

std::vector<Figure> still_figures(const View& view) {
  const std::vector<Eigen::Index> nodes = section_of(view);
  const ViewFrame& peak = view.frames[view.peak];
  const double enlarged = enlargement_of(view, peak);
  const Eigen::Matrix2Xd rest = places_of(view, nodes, peak, 0.0);
  const Eigen::Matrix2Xd moved = places_of(view, nodes, peak, enlarged);
  const std::string cut =
      "Nodes of the section y = " + quantity(mm * view.rest(1, nodes.front()), "mm");
  Figure tissue = section_figure("section", "Undeformed", cut + " by tissue.", rest);
  for (std::size_t label = 0; label < view.labels.size(); ++label) {
    Series series{.label = view.labels[label], .style = Series::Style::points};
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (view.label[static_cast<std::size_t>(nodes[n])] != label) { continue; }
      series.x.push_back(rest(0, static_cast<Eigen::Index>(n)));
      series.y.push_back(rest(1, static_cast<Eigen::Index>(n)));
    }
    if (!series.x.empty()) { tissue.series.push_back(std::move(series)); }
  }
  Figure displaced = section_figure(
      "displaced-section", "Largest reaction, at " + quantity(peak.time, "s"),
      cut + " where they are then, in the colour of their displacement" +
          (enlarged == 1.0 ? "" : ", which is drawn " + short_number(enlarged) + " times larger") +
          ". Applied " + quantity(peak.applied, "N") + ", reaction " +
          quantity(peak.reaction, "N") + ".",
      moved);
  const Eigen::VectorXd distance =
      mm * peak.displacement(Eigen::all, nodes).colwise().norm().transpose();
  displaced.heat_map = nearest_values(moved, distance);
  if (view.tool) {
    const Eigen::Vector3d tip = view.tool->origin + peak.place * view.tool->direction;
    displaced.series.push_back({.label = "tool",
                                .x = {mm * view.tool->origin.x(), mm * tip.x()},
                                .y = {mm * view.tool->origin.z(), mm * tip.z()}});
  }
  return {std::move(tissue), std::move(displaced)};
}

namespace {

std::string inert_script(const std::string& id, const std::string& type, const std::string& text) {
  return "<script type=\"" + type + "\" id=\"" + id + "\">" + text + "</script>\n";
}

}  // namespace

Section view_section(const View& view) {
  const EncodedView encoded = encode(view);
  std::vector<std::string> notes = view.notes;
  notes.insert(notes.end(), encoded.notes.begin(), encoded.notes.end());
  Section stills = exhibits_of(still_figures(view));
  stills.style = "stills";
  return {.parts = {
              Markup{"<style>\n" + std::string(assets::view_css) + "</style>\n" +
                     std::string(assets::view_html)},
              Notes{notes}, std::move(stills),
              Markup{inert_script("view-header", "application/json", encoded.header) +
                     inert_script("view-numbers", "text/plain", encoded.numbers) +
                     inert_script("view-three", "text/plain", base64(deflate(assets::three_js)))}}};
}

std::string view_script() {
  std::string script = "(function () {\n'use strict';\n";
  for (const std::string_view part :
       {assets::view_bytes_js, assets::view_tissue_js, assets::view_shaders_js,
        assets::view_tool_js, assets::view_drawing_js, assets::view_camera_js,
        assets::view_words_js, assets::view_controls_js, assets::view_start_js}) {
    script += part;
  }
  return script + "})();\n";
}

}  // namespace palpate
