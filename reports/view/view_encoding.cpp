// SPDX-License-Identifier: MIT

#include "reports/view/view_encoding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <zlib.h>

#include "view_assets.hpp"

#include "reports/plot/trace_figures.hpp"
#include "reports/results/results_json.hpp"

namespace palpate {
namespace {

void add_planes(std::vector<std::uint8_t>& bytes, std::span<const std::uint64_t> values, int bits) {
  for (int shift = 0; shift < bits; shift += 8) {
    for (const std::uint64_t value : values) {
      bytes.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  }
}

constexpr Rgb rgb(unsigned code) {
  return {static_cast<double>(code >> 16U & 255U) / 255.0,
          static_cast<double>(code >> 8U & 255U) / 255.0, static_cast<double>(code & 255U) / 255.0};
}

/// Colour map magma of matplotlib, reversed, without the darkest eighth and with a greyer light
/// end, so that zero is pale and neutral.
constexpr std::array<unsigned, 8> magma{0xf4ede4, 0xfdc697, 0xfb8861, 0xe75263,
                                        0xb73779, 0x822681, 0x51127c, 0x1d1147};

/// Colours by keyword; the first keyword contained in the label determines the colour.
using Coloured = std::pair<std::string_view, unsigned>;
constexpr std::array by_word{Coloured{"skin", 0xe3b196},         Coloured{"fat", 0xf1d58a},
                             Coloured{"epidural", 0x9cc7dd},     Coloured{"dura", 0x8793c0},
                             Coloured{"flavum", 0xd9a441},       Coloured{"supraspinous", 0xc9b8a8},
                             Coloured{"interspinous", 0xb9938a}, Coloured{"ligament", 0xc7ad94},
                             Coloured{"muscle", 0xb5645a},       Coloured{"bone", 0xeee7d3},
                             Coloured{"nodule", 0x8e6bb0},       Coloured{"disc", 0x86b39a}};
constexpr std::array<unsigned, 6> others{0xe0b79c, 0x8fb8a8, 0xb7a3cf,
                                         0xd69a7c, 0x93b5d6, 0xc3bf7d};

/// Colours of the labels. Labels without a keyword use a palette.
std::vector<Rgb> tissue_colours(const std::vector<std::string>& labels) {
  std::vector<Rgb> colours;
  std::size_t other = 0;
  for (const std::string& label : labels) {
    const auto found = std::ranges::find_if(
        by_word, [&](const auto& each) { return label.find(each.first) != std::string::npos; });
    colours.push_back(
        rgb(found != by_word.end() ? found->second : others[other++ % others.size()]));
  }
  return colours;
}

/// Colour in hexadecimal notation: "#1f968b".
std::string hex_colour(const Rgb& colour) {
  std::string text = "#";
  for (const double part : colour) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x",
                  static_cast<unsigned>(std::lround(255.0 * std::clamp(part, 0.0, 1.0))) & 255U);
    text += digits.data();
  }
  return text;
}

using Json = nlohmann::ordered_json;
using Integers = std::vector<std::int64_t>;

/// Scales of the quantised numbers.
struct Scales {
  Eigen::Vector3d low{0.0, 0.0, 0.0};     ///< [m]
  Eigen::Vector3d extent{0.0, 0.0, 0.0};  ///< [m]
  double displacement = 0.0;              ///< largest displacement [m]
  double step = 0.0;                      ///< quantisation step of displacements [m]
  double force = 0.0;                     ///< largest principal force [N]
  double softest = 0.0;                   ///< smallest stiffness [N/m]
  double stiffest = 0.0;                  ///< largest stiffness [N/m]
};

Scales scales_of(const View& view) {
  Scales scales;
  scales.low = view.rest.rowwise().minCoeff();
  scales.extent = view.rest.rowwise().maxCoeff() - scales.low;
  double largest = 0.0;
  for (const ViewFrame& frame : view.frames) {
    scales.displacement =
        std::max(scales.displacement, frame.displacement.colwise().norm().maxCoeff());
    largest = std::max(largest, frame.displacement.cwiseAbs().maxCoeff());
    scales.force =
        std::max(scales.force, static_cast<double>(frame.line.row(3).cwiseAbs().maxCoeff()));
  }
  scales.step = largest / std::numeric_limits<std::int16_t>::max();
  scales.softest = std::numeric_limits<double>::infinity();  // minimum over nodes with stiffness
  const auto reach = [&scales](double stiffness) {
    if (stiffness > 0.0) { scales.softest = std::min(scales.softest, stiffness); }
    scales.stiffest = std::max(scales.stiffest, stiffness);
  };
  for (const double stiffness : view.stiffness) { reach(stiffness); }
  for (const ViewSpring& spring : view.springs) { reach(spring.stiffness); }
  scales.softest = std::min(scales.softest, scales.stiffest);
  return scales;
}

/// Logarithmic stiffness scale from 0 to 255.
std::uint8_t stiffness_byte(double stiffness, const Scales& scales) {
  if (!(scales.stiffest > scales.softest)) { return 128; }
  const double share = std::log(std::max(stiffness, scales.softest) / scales.softest) /
                       std::log(scales.stiffest / scales.softest);
  return static_cast<std::uint8_t>(std::lround(255.0 * share));
}

/// Quantises one coordinate of positions between `low` and `low` + `extent` [m].
void pack_places(PackedBytes& packed, const Eigen::RowVectorXd& places, double low, double extent) {
  Integers values;
  const double scale = extent > 0.0 ? 65535.0 / extent : 0.0;
  for (const double x : places) { values.push_back(std::llround((x - low) * scale)); }
  packed.add_differences(values, 16);
}

void pack_nodes(PackedBytes& packed, const View& view, const Scales& scales) {
  for (int axis = 0; axis < 3; ++axis) {
    pack_places(packed, view.rest.row(axis), scales.low(axis), scales.extent(axis));
  }
  packed.add_bytes(view.label);
  packed.add_bytes(view.fixed);
  std::vector<std::uint8_t> stiffness;
  for (const double k : view.stiffness) { stiffness.push_back(stiffness_byte(k, scales)); }
  packed.add_bytes(stiffness);
  if (view.place.empty()) { return; }
  packed.add_bytes(view.cell);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Integers values;
    for (const auto& place : view.place) { values.push_back(place[axis]); }
    packed.add_differences(values, 16);
  }
}

/// Bounding box of a surface; a single point if it has no vertices.
Eigen::AlignedBox3d bounds_of(const ViewSurface& surface) {
  Eigen::AlignedBox3d box(Eigen::Vector3d(0.0, 0.0, 0.0));
  if (surface.rest.cols() > 0) {
    box = {surface.rest.rowwise().minCoeff(), surface.rest.rowwise().maxCoeff()};
  }
  return box;
}

void pack_surface(PackedBytes& packed, const ViewSurface& surface) {
  const Eigen::AlignedBox3d box = bounds_of(surface);
  for (int axis = 0; axis < 3; ++axis) {
    pack_places(packed, surface.rest.row(axis), box.min()(axis), box.sizes()(axis));
  }
  std::vector<std::uint8_t> counts;
  Integers nodes, weights, corners;
  for (const auto& vertex : surface.vertices) {
    counts.push_back(static_cast<std::uint8_t>(vertex.size()));
    for (const ViewSurface::Support& support : vertex) {
      nodes.push_back(support.node);
      weights.push_back(std::llround(32767.0 * support.weight));
    }
  }
  for (const auto& triangle : surface.triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  packed.add_bytes(counts);
  packed.add_differences(nodes, 32);
  packed.add_differences(weights, 16);
  packed.add_differences(corners, 32);
}

/// Encodes a direction and the square root of a force in three bytes. Tension is stored in the half
/// space of +z, compression in that of -z.
void add_line(std::vector<std::uint8_t>& bytes, const Eigen::Vector4f& line, double largest) {
  const double root =
      largest > 0.0 ? 127.0 * std::sqrt(std::abs(static_cast<double>(line(3))) / largest) : 0.0;
  std::array<long, 3> parts{};
  for (int axis = 0; axis < 3; ++axis) {
    parts[static_cast<std::size_t>(axis)] = std::lround(root * static_cast<double>(line(axis)));
  }
  const long first = parts[2] != 0 ? parts[2] : parts[1] != 0 ? parts[1] : parts[0];
  const bool turn = (first > 0) != (line(3) > 0.0F);
  for (const long part : parts) { bytes.push_back(static_cast<std::uint8_t>(turn ? -part : part)); }
}

void pack_frames(PackedBytes& packed, const View& view, const Scales& scales) {
  std::vector<std::int16_t> before(static_cast<std::size_t>(view.rest.size()), 0);
  for (const ViewFrame& frame : view.frames) {
    std::vector<std::int16_t> values;
    for (const double u : frame.displacement.reshaped()) {
      values.push_back(
          static_cast<std::int16_t>(scales.step > 0.0 ? std::lround(u / scales.step) : 0));
    }
    packed.add_changes(values, before);
    before = std::move(values);
    std::vector<std::uint8_t> lines;
    for (Eigen::Index n = 0; n < frame.line.cols(); ++n) {
      add_line(lines, frame.line.col(n), scales.force);
    }
    packed.add_bytes(lines);
  }
}

Json frame_json(const View& view, const ViewFrame& frame) {
  Json json = object("time", frame.time, "applied", frame.applied, "reaction", frame.reaction);
  if (view.tool) {
    add_keys(json, "place", frame.place, "depth", frame.depth, "layer", frame.layer);
  }
  if (!frame.event.empty()) { json["event"] = frame.event; }
  return json;
}

Json numbers_of(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return std::vector<double>(values.begin(), values.end());
}

Json tool_json(const ViewTool& tool) {
  const char* shape = tool.shape == ViewTool::Shape::needle      ? "needle"
                      : tool.shape == ViewTool::Shape::fingertip ? "fingertip"
                                                                 : "ultrasound";
  return object("shape", shape, "origin", numbers_of(tool.origin), "direction",
                numbers_of(tool.direction), "size", numbers_of(tool.size));
}

Json colours_json(const std::vector<std::string>& labels) {
  constexpr int stops = 33;
  Json scale = Json::array();
  for (int n = 0; n < stops; ++n) {
    scale.push_back(hex_colour(interpolated_colour(magma, n / (stops - 1.0))));
  }
  return object("tissue", list_of(tissue_colours(labels), hex_colour), "scale", scale);
}

Json surface_json(const ViewSurface& surface) {
  std::size_t supports = 0;
  for (const auto& vertex : surface.vertices) { supports += vertex.size(); }
  const Eigen::AlignedBox3d box = bounds_of(surface);
  return object("label", surface.label, "vertices", surface.vertices.size(), "supports", supports,
                "low", numbers_of(box.min()), "extent", numbers_of(box.sizes()), "triangles",
                surface.triangles.size());
}

std::string header_of(const View& view, const Scales& scales) {
  const auto frame = [&view](const ViewFrame& each) { return frame_json(view, each); };
  const double extent = scales.extent.maxCoeff();
  Json header =
      object("nodes", view.rest.cols(), "springs", view.springs.size(), "grid", !view.place.empty(),
             "labels", view.labels, "colours", colours_json(view.labels), "surfaces",
             list_of(view.surfaces, surface_json), "low", numbers_of(scales.low), "extent",
             numbers_of(scales.extent), "step", scales.step, "displacement", scales.displacement,
             "force", scales.force, "stiffness", std::array{scales.softest, scales.stiffest}, "cut",
             view.cut, "peak", view.peak, "enlargement",
             view.tool ? 1.0 : enlargement(std::max(scales.displacement, 1e-300), extent), "frames",
             list_of(view.frames, frame));
  if (view.tool) { header["tool"] = tool_json(*view.tool); }
  return script_text(header);
}

EncodedView encoded_whole(const View& view) {
  const Scales scales = scales_of(view);
  PackedBytes packed;
  pack_nodes(packed, view, scales);
  Integers a, way;
  std::vector<std::uint8_t> stiffness;
  for (const ViewSpring& spring : view.springs) {
    a.push_back(spring.a);
    way.push_back(spring.b - spring.a);
    stiffness.push_back(stiffness_byte(spring.stiffness, scales));
  }
  packed.add_differences(a, 32);
  packed.add_differences(way, 32);
  packed.add_bytes(stiffness);
  for (const ViewSurface& surface : view.surfaces) { pack_surface(packed, surface); }
  pack_frames(packed, view, scales);
  return {.header = header_of(view, scales), .numbers = base64(packed.deflated())};
}

/// Removes every second frame except event frames, the frame of the largest reaction and the last.
void halve_frames(View& view) {
  std::vector<ViewFrame> kept;
  for (std::size_t n = 0; n < view.frames.size(); ++n) {
    const bool wanted = n % 2 == 0 || n == view.peak || n + 1 == view.frames.size() ||
                        !view.frames[n].event.empty();
    if (n == view.peak) { view.peak = kept.size(); }
    if (wanted) { kept.push_back(std::move(view.frames[n])); }
  }
  view.frames = std::move(kept);
}

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
  const auto places = [size](double from, double to) {
    std::vector<double> all;
    const int last = static_cast<int>(std::lround((to - from) / size));
    for (int n = 0; n <= last; ++n) { all.push_back(from + n * size); }
    return all;
  };
  double reach = 0.0;
  for (const auto& point : points.colwise()) {
    const auto distance = (points.colwise() - point).colwise().squaredNorm();
    reach = std::max(reach, (distance.array() > 0.0).select(distance.array(), 1e300).minCoeff());
  }
  HeatMap map{.label = "displacement (mm)"};
  map.x = places(low.x(), high.x());
  map.y = places(low.y(), high.y());
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

}  // namespace

void PackedBytes::add_bytes(std::span<const std::uint8_t> values) {
  bytes_.insert(bytes_.end(), values.begin(), values.end());
}

void PackedBytes::add_differences(std::span<const std::int64_t> values, int bits) {
  std::vector<std::uint64_t> differences;
  std::int64_t before = 0;
  for (const std::int64_t value : values) {
    differences.push_back(static_cast<std::uint64_t>(value - before));
    before = value;
  }
  add_planes(bytes_, differences, bits);
}

void PackedBytes::add_changes(std::span<const std::int16_t> values,
                              std::span<const std::int16_t> before) {
  std::vector<std::uint64_t> differences;
  for (std::size_t n = 0; n < values.size(); ++n) {
    differences.push_back(
        static_cast<std::uint64_t>(std::int64_t{values[n]} - std::int64_t{before[n]}));
  }
  add_planes(bytes_, differences, 16);
}

std::string PackedBytes::deflated() const {
  return deflate({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()});
}

std::string deflate(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  const int code =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_DEFAULT_COMPRESSION);
  if (code != Z_OK) {
    throw std::runtime_error("zlib could not deflate: code " + std::to_string(code));
  }
  packed.resize(size);
  return packed;
}

std::string base64(std::string_view bytes) {
  using namespace boost::archive::iterators;
  using Digits = base64_from_binary<transform_width<const char*, 6, 8>>;
  std::string text(Digits(bytes.data()), Digits(bytes.data() + bytes.size()));
  text.append((4 - text.size() % 4) % 4, '=');
  return text;
}

Rgb interpolated_colour(std::span<const unsigned> codes, double share) {
  const double along = std::clamp(share, 0.0, 1.0) * static_cast<double>(codes.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(along), codes.size() - 2);
  const double rest = along - static_cast<double>(below);
  const Rgb low = rgb(codes[below]);
  const Rgb high = rgb(codes[below + 1]);
  Rgb colour{};
  for (std::size_t n = 0; n < 3; ++n) { colour[n] = (1.0 - rest) * low[n] + rest * high[n]; }
  return colour;
}

EncodedView encode(View view, std::size_t most) {
  const std::size_t all = view.frames.size();
  EncodedView encoded = encoded_whole(view);
  for (std::size_t before = all + 1;
       encoded.numbers.size() > most && view.frames.size() < before;) {
    before = view.frames.size();
    halve_frames(view);
    encoded = encoded_whole(view);
  }
  if (view.frames.size() < all) {
    encoded.notes.push_back(std::to_string(view.frames.size()) + " of " + std::to_string(all) +
                            " instants are shown, to keep the page small");
  }
  return encoded;
}

std::vector<Figure> still_figures(const View& view) {
  const std::vector<Eigen::Index> nodes = section_of(view);
  const ViewFrame& peak = view.frames[view.peak];
  const double furthest = peak.displacement.colwise().norm().maxCoeff();
  const Eigen::Vector3d extent = view.rest.rowwise().maxCoeff() - view.rest.rowwise().minCoeff();
  const bool to_scale = view.tool || !(furthest > 0.0);
  const double enlarged = to_scale ? 1.0 : enlargement(furthest, extent.maxCoeff());
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
  return "(function () {\n'use strict';\n" + view_parts() + std::string(assets::view_start_js) +
         "})();\n";
}

std::string view_parts() {
  std::string script;
  for (const std::string_view part :
       {assets::view_bytes_js, assets::view_tissue_js, assets::view_shaders_js,
        assets::view_tool_js, assets::view_drawing_js, assets::view_camera_js,
        assets::view_words_js, assets::view_controls_js}) {
    script += part;
  }
  return script;
}

std::string inert_script(const std::string& id, const std::string& type, const std::string& text) {
  return "<script type=\"" + type + "\" id=\"" + id + "\">" + text + "</script>\n";
}

}  // namespace palpate
