// SPDX-License-Identifier: MIT

#include "reports/run_report.hpp"

#include <algorithm>
#include <array>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "html_templates.hpp"
#include "report_assets.hpp"

#include "model/tissue/image_tissue.hpp"
#include "model/tissue/voxel_tissue.hpp"
#include "reports/html/html_template.hpp"
#include "reports/plot/figure_layout.hpp"
#include "reports/plot/figure_svg.hpp"
#include "reports/plot/trace_figures.hpp"
#include "reports/results/results_json.hpp"
#include "reports/view/view_encoding.hpp"

namespace palpate {
namespace {

Series circle(const std::string& label, double radius, Series::Style style) {
  Series series{.label = label, .style = style};
  constexpr int corners = 120;
  for (int n = 0; n <= corners; ++n) {
    const double angle = 2.0 * std::numbers::pi * n / corners;
    series.x.push_back(radius * std::cos(angle));
    series.y.push_back(radius * std::sin(angle));
  }
  return series;
}

/// The paper's figure for its device, Vaughan et al. [N].
constexpr double stated_by_the_paper = 15.0;

constexpr double cm3 = 1e6;

std::string by(const Eigen::Vector3d& v, double scale, std::string_view unit) {
  return short_number(scale * v.x(), 3) + " x " + short_number(scale * v.y(), 3) + " x " +
         short_number(scale * v.z(), 3) + std::string(unit);
}

void add_image_facts(const ImageFacts& image, const NodeGrid& nodes, std::vector<Fact>& facts) {
  facts.push_back({"image", image.format,
                   std::to_string(image.pixels[0]) + " x " + std::to_string(image.pixels[1]) +
                       " x " + std::to_string(image.pixels[2]) + " pixels of " +
                       by(image.spacing, mm, " mm")});
  facts.push_back(
      {"nodes apart", by(nodes.spacing, mm, " mm"),
       "across, across and along z; " + std::to_string(image.labelled_nodes) + " nodes by label"});
  facts.push_back({"lookup", image.weighting,
                   "intensities from " + short_number(image.range.x(), 4) + " (0) to " +
                       short_number(image.range.y(), 4) + " (1)"});
  const bool isotropic = (image.youngs_moduli.array() - 1.0).abs().maxCoeff() < 1e-6;
  if (!isotropic) {
    facts.push_back(
        {"moduli of the grid", by(image.youngs_moduli, 1.0, " of E"),
         "along x, y and z: springs that pull cannot make boxes of this shape isotropic"});
  }
}

void add_body_facts(const BodyFacts& body, std::vector<Fact>& facts) {
  facts.push_back({body.name, short_number(cm3 * body.voxel_volume, 4) + " cm3 of voxels",
                   body.material + "; its surface holds " +
                       short_number(cm3 * body.surface_volume, 4) + " cm3; " +
                       std::to_string(body.parts) + (body.parts == 1 ? " part; " : " parts; ") +
                       std::to_string(body.kept_cells) + " voxels kept"});
}

void add_layers(const Scene& scene, std::vector<Fact>& facts) {
  const NeedlePath path(scene, scene.tissue.voxels->network);
  std::string layers;
  for (const PathInterval& interval : path.intervals()) {
    const std::string end =
        std::isfinite(interval.end) ? short_number(mm * interval.end, 4) + " mm" : "the end";
    layers += (layers.empty() ? "" : ", ") + interval.label + " to " + end;
  }
  facts.push_back({"layers on the needle's line", layers, "along it, from the skin"});
}

/// Image of the node plane through the tool, normal to y: x and z of the nodes [mm], brightness in
/// row-major order.
struct Slice {
  std::vector<double> x{};
  std::vector<double> z{};
  std::vector<double> intensity{};
};

Slice slice_through(const VoxelTissue& tissue, double y) {
  const NodeGrid& grid = tissue.nodes;
  const double row = std::round((y - grid.first.y()) / grid.spacing.y());
  const int j = static_cast<int>(std::clamp(row, 0.0, grid.count[1] - 1.0));
  Slice slice;
  for (int i = 0; i < grid.count[0]; ++i) { slice.x.push_back(mm * grid.place(i, j, 0).x()); }
  for (int l = 0; l < grid.count[2]; ++l) {
    slice.z.push_back(mm * grid.place(0, j, l).z());
    for (int i = 0; i < grid.count[0]; ++i) {
      slice.intensity.push_back(static_cast<double>(tissue.intensity[grid.index(i, j, l)]));
    }
  }
  return slice;
}

Figure figure_of(const Slice& slice, const std::string& id, const std::string& title,
                 const std::string& caption, const std::string& label, const auto& value) {
  HeatMap map{.label = label, .x = slice.x, .y = slice.z};
  std::ranges::transform(slice.intensity, std::back_inserter(map.z), value);
  return {.id = id,
          .title = title,
          .caption = caption,
          .x = {.label = "x (mm)"},
          .y = {.label = "z, into the tissue (mm)"},
          .heat_map = std::move(map),
          .square = true};
}

std::set<std::size_t> rows_of(const Figure& figure) {
  constexpr double columns = 2000.0;
  std::set<std::size_t> rows;
  for (const Series& series : figure.series) {
    const double begin = series.x.front();
    const double span = std::max(series.x.back() - begin, 1e-300);
    const Projection project = [&](double x, double y) {
      return Pixel{columns * (x - begin) / span, y};
    };
    for (const std::size_t row : thinned(series, project)) { rows.insert(row); }
  }
  return rows;
}

std::string data_of(const Figure& figure) {
  constexpr int digits = 7;
  std::string text = "[";
  for (const std::size_t row : rows_of(figure)) {
    text += (text.size() == 1 ? "[" : ",[") + plain_number(figure.series.front().x[row], 9);
    for (const Series& series : figure.series) {
      const bool finite = row < series.y.size() && std::isfinite(series.y[row]);
      text += "," + (finite ? plain_number(series.y[row], digits) : "null");
    }
    text += "]";
  }
  return text + "]";
}

std::string plot_of(const Figure& figure) {
  std::string labels = script_text(figure.x.label);
  std::string colours;
  for (const Series& series : figure.series) { labels += "," + script_text(series.label); }
  for (const Look& look : looks_of(figure)) {
    colours += (colours.empty() ? "" : ",") + std::to_string(look.colour);
  }
  return "plot('zoom-" + figure.id + "'," + data_of(figure) + ",[" + labels + "],[" + colours +
         "]," + script_text(figure.y.label) + ");\n";
}

void add_notes(Page& page, const char* heading, const std::vector<std::string>& items) {
  if (items.empty()) { return; }
  page.parts.emplace_back(Section{.heading = heading, .parts = {Notes{items}}});
}

void add_figures(Page& page, const char* heading, const std::vector<Figure>& figures) {
  if (figures.empty()) { return; }
  page.parts.emplace_back(Section{.heading = heading, .parts = {exhibits_of(figures)}});
}

}  // namespace

Figure force_reach_figure(const FalconFacts& facts) {
  using Point = boost::geometry::model::d2::point_xy<double>;
  const double reach = 10.0 * std::ceil(std::max(facts.axial_force, stated_by_the_paper) / 10.0);
  Figure figure{
      .id = "force-reach",
      .title = "What the motors can pull the hand with",
      .caption =
          "Outlines of all forces within the torques of the motors and the power of their supply "
          "at "
          "the grip's place on the skin, seen from two sides: much along the needle, little in the "
          "weakest direction. Up "
          "is out of the tissue, against the insertion.",
      .x = {.label = "force across the needle (N)", .minimum = -reach, .maximum = reach},
      .y = {.label = "force along the needle, outward (N)", .minimum = -reach, .maximum = reach},
      .square = true};
  const char* names[] = {"left and right", "up and down"};
  for (const int axis : {0, 1}) {
    boost::geometry::model::multi_point<Point> corners;
    for (const Eigen::Vector3d& corner : facts.force_reach) {
      corners.emplace_back(corner(axis), corner.z());
    }
    boost::geometry::model::ring<Point, false> outline;
    boost::geometry::convex_hull(corners, outline);
    Series series{.label = names[axis]};
    for (const Point& point : outline) {
      series.x.push_back(point.x());
      series.y.push_back(point.y());
    }
    figure.series.push_back(std::move(series));
  }
  figure.series.push_back(circle("in every direction", facts.weakest_force, Series::Style::line));
  figure.series.push_back(
      circle("stated in the paper", stated_by_the_paper, Series::Style::dashed));
  return figure;
}

std::vector<Figure> falcon_figures(const Trace& trace) {
  if (trace.find("device.requested_n") == nullptr || trace.time.size() < 2) { return {}; }
  Figure force =
      figure_over(trace, Over::time, "device-force", "Force requested of the device, and delivered",
                  "Magnitudes on the hand at every tick: what the rendering requested "
                  "and what the motors delivered.",
                  "force (N)");
  force.zones.clear();
  add_column(force, trace, Over::time, "device.delivered_n", "delivered");
  add_column(force, trace, Over::time, "device.requested_n", "requested", 1.0,
             Series::Style::dashed);
  Figure way = figure_over(trace, Over::time, "hand-and-tip",
                           "Intended position of the hand, and position of the tip",
                           "Along the needle's line; the gap is the extension of the hand's spring "
                           "and of the coupling.",
                           "position (mm)");
  add_column(way, trace, Over::time, "device.intent_m", "intent", mm, Series::Style::dashed);
  add_column(way, trace, Over::time, "tool.insertion_m", "tip", mm);
  Figure energy = figure_over(trace, Over::time, "port-energy", "Energy that the hand put in",
                              "Through the device's port, from the positions that were read and "
                              "the forces that were requested; below zero the rendering feeds "
                              "energy in.",
                              "energy (mJ)");
  energy.zones.clear();
  energy.marks.clear();
  add_column(energy, trace, Over::time, "device.energy_j", "", mj);
  return {std::move(force), std::move(way), std::move(energy)};
}

std::vector<Fact> falcon_fact_list(const FalconFacts& facts) {
  const double share = facts.ticks > 0
                           ? static_cast<double>(facts.saturated) / static_cast<double>(facts.ticks)
                           : 0.0;
  std::vector<Fact> list{
      {"force on the hand", quantity(facts.largest_delivered, "N"),
       "at most; requested " + quantity(facts.largest_requested, "N")},
      {"motors at their limit", quantity(100.0 * share, "%"),
       "of the ticks; in reach at the start " + quantity(facts.axial_force, "N") +
           " against the insertion, " + quantity(facts.weakest_force, "N") + " in every direction"},
      {"energy at the port", quantity(mj * facts.least_energy, "mJ"),
       facts.least_energy < 0.0 ? "at least, at " + quantity(facts.least_energy_at, "s") +
                                      ": the rendering fed in as much"
                                : "at least: the rendering was passive"}};
  if (facts.taken_by_controller > 0.0) {
    list.push_back({"taken by the controller", quantity(mj * facts.taken_by_controller, "mJ"), ""});
  }
  if (facts.lost_resistance_at) {
    list.push_back({"overshoot", quantity(mm * facts.overshoot, "mm"),
                    "of the tip beyond the loss of resistance at " +
                        quantity(*facts.lost_resistance_at, "s") + ", felt " +
                        quantity(1e3 * facts.reaction, "ms") + " later"});
  }
  if (facts.unanswered > 0) {
    list.push_back({"requests without reply", std::to_string(facts.unanswered), ""});
  }
  if (facts.unhomed > 0) {
    list.push_back({"ticks without a place", std::to_string(facts.unhomed),
                    "the device had lost its zero; no force was requested"});
  }
  return list;
}

std::vector<Fact> patient_facts(const Scene& scene) {
  std::vector<Fact> facts;
  if (!scene.tissue.voxels) { return facts; }
  const VoxelTissue& tissue = *scene.tissue.voxels;
  if (tissue.image) { add_image_facts(*tissue.image, tissue.nodes, facts); }
  for (const BodyFacts& body : tissue.bodies) { add_body_facts(body, facts); }
  if (scene.needle) { add_layers(scene, facts); }
  return facts;
}

std::vector<Figure> lookup_figures(const Scene& scene) {
  if (!scene.tissue.voxels || !scene.tissue.voxels->image) { return {}; }
  const Slice slice =
      slice_through(*scene.tissue.voxels, scene.needle ? scene.needle->entry.y() : 0.0);
  std::vector<Figure> figures{figure_of(slice, "slice", "Plane through the image",
                                        "Brightness of the nodes, scaled by the percentiles.",
                                        "brightness (1)",
                                        [](double intensity) { return intensity; })};
  for (const Weighting weighting : {Weighting::t2, Weighting::t1, Weighting::literal}) {
    std::vector<Violation> broken;
    const bool literal = weighting == Weighting::literal;
    const Lookup lookup(lookup_points(weighting), scene.materials, literal, broken);
    if (!broken.empty()) { continue; }  // the scene has no materials with these names
    const std::string name = name_of(weighting);
    figures.push_back(figure_of(
        slice,
        "lookup-" + std::string(literal                      ? "literal"
                                : weighting == Weighting::t1 ? "t1"
                                                             : "t2"),
        "The same plane by the " + name + " lookup",
        literal
            ? "Young's modulus where bright means stiff, as in the paper. Labels do not show here."
            : "Young's modulus where the image is taken for " + name +
                  "-weighted. Labels do not show here.",
        "log10 of E in Pa (1)",
        [&](double intensity) { return std::log10(lookup.youngs_modulus(intensity)); }));
  }
  return figures;
}

/// Collapsed section with an element for each figure; all series of a figure have the same x.
Markup zoom_section(const std::vector<Figure>& figures) {
  if (figures.empty()) { return {}; }
  const auto place = [](const Figure& figure) {
    return record("title", figure.title, "id", figure.id);
  };
  return {fill(templates::zoom, record("figures", data_of(figures, place), "style",
                                       std::string(assets::dygraph_css)))};
}

/// Script that draws the plots by dygraphs when the section is expanded. Series are reduced to the
/// extremes of 2000 columns.
std::string zoom_script(const std::vector<Figure>& figures) {
  if (figures.empty()) { return {}; }
  std::string script(assets::zoom_js);
  script += "zoomPlots(function (plot) {\n";
  for (const Figure& figure : figures) { script += plot_of(in_field_units(figure)); }
  return script + "});\n";
}

std::string to_html(const RunReport& report, const Trace& trace) {
  const std::vector<Figure> over_time = figures_over_time(trace);
  std::vector<Figure> tool = tool_figures(trace);
  tool.insert(tool.end(), report.tool_figures.begin(), report.tool_figures.end());
  std::vector<Figure> zooms = tool_traces(trace);
  zooms.insert(zooms.end(), over_time.begin(), over_time.end());
  Page page{.banner = {.title = report.title,
                       .small_print = {report.command},
                       .status = !report.held              ? Status::fail
                                 : report.warnings.empty() ? Status::pass
                                                           : Status::inconclusive,
                       .verdict = report.verdict,
                       .detail = report.detail},
            .provenance = report.provenance,
            .command = report.command};
  if (report.changes) {
    page.parts.emplace_back(Section{
        .heading = "What changed since the last run",
        .parts = {
            report.changes->empty()
                ? PagePart(Paragraph{"Nothing: verdict, forces, depth and pressure are equal."})
                : PagePart(Notes{*report.changes})}});
  }
  if (!report.trust.empty() || !report.warnings.empty()) {
    page.parts.emplace_back(Section{.heading = "How far to trust this",
                                    .parts = {report.trust, Notes{report.warnings}}});
  }
  page.parts.emplace_back(Section{.heading = "Key facts", .parts = {report.facts}});
  if (report.view) {
    page.parts.emplace_back(report.interactive ? view_section(*report.view)
                                               : exhibits_of(still_figures(*report.view)));
  }
  add_figures(page, "Forces on the tool", tool);
  if (!trace.events.empty()) {
    page.parts.emplace_back(Section{.heading = "Events", .parts = {events_table(trace)}});
  }
  add_figures(page, "Traces", over_time);
  page.parts.emplace_back(zoom_section(zooms));
  add_notes(page, "Skipped, because the scene does not need it", report.skipped);
  if (!zooms.empty()) { page.scripts = {std::string(assets::dygraph_js), zoom_script(zooms)}; }
  if (report.view && report.interactive) { page.scripts.push_back(view_script()); }
  return render(page);
}

}  // namespace palpate
