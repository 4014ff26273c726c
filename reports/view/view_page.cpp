// SPDX-License-Identifier: MIT
/// Still pictures of a view: cell faces behind the cut.

#include "reports/view/view_page.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

#include "view_assets.hpp"

#include "reports/html/html_page.hpp"
#include "reports/plot/figure_look.hpp"
#include "reports/plot/shown_units.hpp"
#include "reports/plot/trace_figures.hpp"
#include "reports/view/view.hpp"
#include "reports/view/view_encoding.hpp"

namespace palpate {

struct ViewSide {
  std::array<int, 4> nodes{};
  int cell = 0;  ///< lowest corner of the cell
};

/// Faces towards +x, +y or -z. Squares of small faces are merged to at most about `most` faces.
std::vector<ViewSide> seen_sides(const View& view, std::size_t most);

namespace {

/// Visible face of `span` x `span` cells towards +x, +y or -z.
struct GridSide {
  std::size_t axis = 0;
  std::array<int, 3> place{};  ///< grid indices of the first cell
  int span = 1;
};

/// Faces of the cells behind the cut, by grid indices.
class SeenSides {
 public:
  explicit SeenSides(const View& view) : view_(view) {
    for (std::size_t n = 0; n < view.place.size(); ++n) {
      node_at_[view.place[n]] = static_cast<int>(n);
    }
    for (const auto& place : view.place) {
      for (std::size_t axis = 0; kept(place) && axis < 3; ++axis) {
        std::array<int, 3> next = place;
        next[axis] += axis == 2 ? -1 : 1;
        if (!kept(next)) { sides_.push_back({axis, place}); }
      }
    }
  }
  [[nodiscard]] std::vector<ViewSide> nodes(std::size_t most) const {
    const auto n = static_cast<int>(
        std::ceil(std::sqrt(static_cast<double>(sides_.size()) / static_cast<double>(most))));
    std::map<std::array<int, 4>, std::vector<GridSide>> squares;
    for (const GridSide& side : sides_) {
      std::array<int, 4> square{static_cast<int>(side.axis), 0, 0, 0};
      for (std::size_t c = 0; c < 3; ++c) {
        square[c + 1] = c == side.axis ? side.place[c] : side.place[c] / n * n;
      }
      squares[square].push_back(side);
    }
    std::vector<ViewSide> nodes;
    for (const auto& [square, sides] : squares) {
      if (sides.size() == static_cast<std::size_t>(n * n)) {
        nodes.push_back(corners({sides[0].axis, {square[1], square[2], square[3]}, n}));
      } else {
        for (const GridSide& side : sides) { nodes.push_back(corners(side)); }
      }
    }
    return nodes;
  }

 private:
  [[nodiscard]] bool kept(const std::array<int, 3>& place) const {
    const auto found = node_at_.find(place);
    if (found == node_at_.end() || view_.cell[static_cast<std::size_t>(found->second)] == 0) {
      return false;
    }
    const int opposite = node_at_.at({place[0] + 1, place[1] + 1, place[2] + 1});
    return 0.5 * (view_.rest(1, found->second) + view_.rest(1, opposite)) <= view_.cut;
  }
  [[nodiscard]] ViewSide corners(const GridSide& side) const {
    static constexpr std::array<std::array<int, 4>, 3> of_cell{
        {{1, 3, 7, 5}, {2, 6, 7, 3}, {0, 2, 3, 1}}};
    ViewSide result{.cell = node_at_.at(side.place)};
    for (std::size_t n = 0; n < 4; ++n) {
      std::array<int, 3> place = side.place;
      for (std::size_t c = 0; c < 3; ++c) {
        place[c] += (of_cell[side.axis][n] >> c & 1) * (c == side.axis ? 1 : side.span);
      }
      result.nodes[n] = node_at_.at(place);
    }
    return result;
  }

  const View& view_;
  std::map<std::array<int, 3>, int> node_at_;
  std::vector<GridSide> sides_;
};

}  // namespace

std::vector<ViewSide> seen_sides(const View& view, std::size_t most) {
  return SeenSides(view).nodes(most);
}

namespace {

constexpr double width = 640.0;  // width of a picture in user units
constexpr double height = 470.0;
constexpr double key_height = 58.0;
constexpr std::size_t most_sides = 4500;
constexpr std::size_t most_strokes = 6000;
constexpr std::size_t most_faces =
    12'000;  // faces of a surface inside the tissue; a larger surface is omitted

/// Parallel projection from +y and above the skin, the initial direction of the interactive view.
struct Projection3 {
  Eigen::Vector3d right, up, nearer;
  Eigen::Vector2d middle{0.0, 0.0};
  double scale = 1.0;

  [[nodiscard]] Eigen::Vector2d flat(const Eigen::Vector3d& p) const {
    return {p.dot(right), -p.dot(up)};
  }
  [[nodiscard]] Eigen::Vector2d pixel(const Eigen::Vector3d& p) const {
    return scale * (flat(p) - middle) + Eigen::Vector2d(0.5 * width, 0.5 * (height - key_height));
  }
};

Projection3 direction_of_sight() {
  constexpr double azimuth = 0.45;
  constexpr double elevation = 0.42;
  Projection3 view;
  view.nearer << std::cos(elevation) * std::sin(azimuth), std::cos(elevation) * std::cos(azimuth),
      -std::sin(elevation);
  view.right = Eigen::Vector3d(0.0, 0.0, -1.0).cross(view.nearer).normalized();
  view.up = view.nearer.cross(view.right);
  return view;
}

/// Visible segment of the tool, from its tip to outside the body.
std::array<Eigen::Vector3d, 2> shaft_of(const View& view, std::size_t frame) {
  const double reach =
      0.3 * (view.rest.rowwise().maxCoeff() - view.rest.rowwise().minCoeff()).norm();
  const Eigen::Vector3d tip = view.tool->origin + view.frames[frame].place * view.tool->direction;
  const Eigen::Vector3d skin = view.tool->origin - reach * view.tool->direction;
  return {tip, skin};
}

Projection3 projection_of(const View& view) {
  Projection3 projection = direction_of_sight();
  Eigen::Vector2d low = projection.flat(view.rest.col(0));
  Eigen::Vector2d high = low;
  const auto reach = [&](const Eigen::Vector3d& point) {
    low = low.cwiseMin(projection.flat(point));
    high = high.cwiseMax(projection.flat(point));
  };
  for (const auto& point : view.rest.colwise()) { reach(point); }
  if (view.tool) { reach(shaft_of(view, 0)[1]); }
  for (const ViewSurface& surface : view.surfaces) {
    for (const auto& point : surface.rest.colwise()) { reach(point); }
  }
  const Eigen::Vector2d extent = (high - low).cwiseMax(1e-9);
  projection.middle = 0.5 * (low + high);
  projection.scale = 0.94 * std::min(width / extent.x(), (height - key_height) / extent.y());
  return projection;
}

/// Item to paint, with its distance to the front.
struct Piece {
  double nearness = 0.0;
  std::string markup{};
};

struct Picture {
  const View& view;
  Projection3 projection;
  NodeVectors position;
  std::vector<Rgb> colours;  ///< node colours
  bool by_cell = false;  ///< true: the face has the colour of the lowest corner of its cell, not
                         ///< the mean of its corners
};

std::string stroke(const std::string& colour, double across, const SvgPath& path) {
  return "<path fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"" + svg_number(across) +
         "\" d=\"" + path.data() + "\"/>";
}

/// Shaded colour of a face. `normal` need not be a unit vector.
Rgb lit(const Picture& picture, Rgb colour, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d light =
      (picture.projection.nearer + 0.7 * picture.projection.up + 0.3 * picture.projection.right)
          .normalized();
  const double brightness = 0.76 + 0.24 * std::abs(normal.normalized().dot(light));
  for (double& part : colour) { part *= brightness; }
  return colour;
}

Piece painted_side(const Picture& picture, const ViewSide& side) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  SvgPath path;
  for (std::size_t n = 0; n < 4; ++n) {
    const Eigen::Vector3d point = picture.position.col(side.nodes[n]);
    const Eigen::Vector2d at = picture.projection.pixel(point);
    n == 0 ? path.move(at.x(), at.y()) : path.line(at.x(), at.y());
    middle += 0.25 * point;
  }
  path.close();
  const Eigen::Vector3d normal =
      (picture.position.col(side.nodes[2]) - picture.position.col(side.nodes[0]))
          .cross(picture.position.col(side.nodes[3]) - picture.position.col(side.nodes[1]));
  Rgb colour{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (const int node : side.nodes) {
      const int of = picture.by_cell ? side.cell : node;
      colour[c] += 0.25 * picture.colours[static_cast<std::size_t>(of)][c];
    }
  }
  return {middle.dot(picture.projection.nearer), "<path fill=\"" +
                                                     hex_colour(lit(picture, colour, normal)) +
                                                     "\" d=\"" + path.data() + "\"/>"};
}

/// Faces behind the cut that belong to surfaces inside the tissue.
std::vector<Piece> painted_surface(const Picture& picture, const ViewSurface& surface) {
  const Rgb skin{0xe0 / 255.0, 0xac / 255.0, 0x90 / 255.0};
  NodeVectors place = surface.rest;
  for (std::size_t vertex = 0; vertex < surface.vertices.size(); ++vertex) {
    for (const ViewSurface::Support& support : surface.vertices[vertex]) {
      place.col(static_cast<Eigen::Index>(vertex)) +=
          support.weight *
          (picture.position.col(support.node) - picture.view.rest.col(support.node));
    }
  }
  std::vector<Piece> pieces;
  for (const auto& face : surface.triangles) {
    const Eigen::Vector3d middle = place(Eigen::all, face).rowwise().mean();
    if (middle.y() > picture.view.cut) { continue; }
    SvgPath path;
    for (std::size_t n = 0; n < 3; ++n) {
      const Eigen::Vector2d at = picture.projection.pixel(place.col(face[n]));
      n == 0 ? path.move(at.x(), at.y()) : path.line(at.x(), at.y());
    }
    path.close();
    const Eigen::Vector3d normal =
        (place.col(face[1]) - place.col(face[0])).cross(place.col(face[2]) - place.col(face[0]));
    pieces.push_back({middle.dot(picture.projection.nearer),
                      "<path fill=\"" + hex_colour(lit(picture, skin, normal)) + "\" d=\"" +
                          path.data() + "\"/>"});
  }
  return pieces;
}

/// Springs of a network without cells, thinned to at most about `most_strokes`.
std::vector<Piece> painted_springs(const Picture& picture) {
  std::vector<Piece> pieces;
  const auto& springs = picture.view.springs;
  const std::size_t stride = springs.size() / most_strokes + 1;
  for (std::size_t n = 0; n < springs.size(); n += stride) {
    const Eigen::Vector3d a = picture.position.col(springs[n].a);
    const Eigen::Vector3d b = picture.position.col(springs[n].b);
    SvgPath path;
    path.move(picture.projection.pixel(a).x(), picture.projection.pixel(a).y());
    path.line(picture.projection.pixel(b).x(), picture.projection.pixel(b).y());
    Rgb colour{};
    for (std::size_t c = 0; c < 3; ++c) {
      for (const int end : {springs[n].a, springs[n].b}) {
        colour[c] += 0.5 * picture.colours[static_cast<std::size_t>(end)][c];
      }
    }
    pieces.push_back(
        {0.5 * (a + b).dot(picture.projection.nearer), stroke(hex_colour(colour), 2.0, path)});
  }
  return pieces;
}

std::string painted_tool(const Picture& picture, std::size_t frame) {
  if (!picture.view.tool) { return {}; }
  const auto [tip, end] = shaft_of(picture.view, frame);
  const bool needle = picture.view.tool->shape == ViewTool::Shape::needle;
  const Eigen::Vector2d a = picture.projection.pixel(tip);
  const Eigen::Vector2d b =
      picture.projection.pixel(needle ? end : Eigen::Vector3d(0.5 * (tip + end)));
  SvgPath path;
  path.move(a.x(), a.y());
  path.line(b.x(), b.y());
  const double across = std::max(2.0, picture.projection.scale * picture.view.tool->size.x());
  return stroke("#4a5661", across + 1.0, path) +
         stroke(needle ? "#cfd7de" : "#d9a58a", std::max(1.0, across - 1.0), path);
}

std::string text_at(double x, double y, const std::string& anchor, const std::string& text) {
  return "<text x=\"" + svg_number(x) + "\" y=\"" + svg_number(y) + "\" text-anchor=\"" + anchor +
         "\">" + escape_markup(text) + "</text>";
}

std::string painted(const Picture& picture, std::size_t frame, const std::string& key,
                    const std::string& what) {
  std::vector<Piece> pieces;
  const std::vector<ViewSide> sides = seen_sides(picture.view, most_sides);
  for (const ViewSide& side : sides) { pieces.push_back(painted_side(picture, side)); }
  if (sides.empty()) { pieces = painted_springs(picture); }
  for (const ViewSurface& surface : picture.view.surfaces) {
    if (!surface.of_cells && surface.triangles.size() <= most_faces) {
      std::ranges::move(painted_surface(picture, surface), std::back_inserter(pieces));
    }
  }
  std::ranges::stable_sort(pieces, {}, &Piece::nearness);
  std::string svg = "<svg role=\"img\" aria-label=\"" + escape_markup(what) + "\" viewBox=\"0 0 " +
                    svg_number(width) + " " + svg_number(height) + "\"><g class=\"edge\">";
  for (const Piece& piece : pieces) { svg += piece.markup; }
  return svg + "</g>" + painted_tool(picture, frame) + key + "</svg>";
}

/// Legend of coloured squares with labels, wrapped into lines.
std::string tissue_key(const View& view, const std::vector<Rgb>& colours) {
  std::string key;
  double x = 8.0;
  double y = height - key_height + 20.0;
  for (std::size_t n = 0; n < view.labels.size(); ++n) {
    const double room = 34.0 + 9.0 * static_cast<double>(view.labels[n].size());
    if (x + room > width && x > 8.0) {
      x = 8.0;
      y += 22.0;
    }
    key += "<path fill=\"" + hex_colour(colours[n]) + "\" d=\"M" + svg_number(x) + " " +
           svg_number(y - 9.0) + "h11v11h-11z\"/>" + text_at(x + 19.0, y, "start", view.labels[n]);
    x += room;
  }
  return key;
}

std::string scale_key(double largest) {
  constexpr int steps = 40;
  constexpr double left = 8.0;
  constexpr double long_side = 380.0;
  std::string key;
  for (int n = 0; n < steps; ++n) {
    key += "<path fill=\"" + hex_colour(scale_colour((n + 0.5) / steps)) + "\" d=\"M" +
           svg_number(left + n * long_side / steps) + " " + svg_number(height - key_height + 6.0) +
           "h" + svg_number(long_side / steps + 0.3) + "v10h-" +
           svg_number(long_side / steps + 0.3) + "z\"/>";
  }
  const double y = height - key_height + 36.0;
  return key + text_at(left, y, "start", "0") +
         text_at(left + 0.5 * long_side, y, "middle",
                 short_number(0.5 * mm * largest, 3) + "\u00a0mm") +
         text_at(left + long_side, y, "end", short_number(mm * largest, 3) + "\u00a0mm") +
         text_at(left + long_side + 12.0, y - 14.0, "start", "displacement");
}

}  // namespace

std::string still_at_rest(const View& view) {
  const std::vector<Rgb> tissue = tissue_colours(view.labels);
  Picture picture{view, projection_of(view), view.rest, {}, true};
  for (const std::uint8_t label : view.label) { picture.colours.push_back(tissue[label]); }
  return painted(picture, 0, tissue_key(view, tissue), "the undeformed tissue");
}

std::string still_at(const View& view, std::size_t frame, double enlarged) {
  const NodeVectors& moved = view.frames[frame].displacement;
  Picture picture{view, projection_of(view), view.rest + enlarged * moved, {}, false};
  const double largest = moved.colwise().norm().maxCoeff();
  for (const auto& u : moved.colwise()) {
    picture.colours.push_back(scale_colour(largest > 0.0 ? u.norm() / largest : 0.0));
  }
  return painted(picture, frame, scale_key(largest),
                 "the tissue at " + quantity(view.frames[frame].time, "s"));
}

namespace {

std::string inert_script(const std::string& id, const std::string& type, const std::string& text) {
  return "<script type=\"" + type + "\" id=\"" + id + "\">" + text + "</script>\n";
}

std::string still(const std::string& title, const std::string& svg, const std::string& caption) {
  return "<figure class=\"exhibit still\"><b>" + escape_markup(title) + "</b>\n" + svg +
         "\n<figcaption>" + escape_markup(caption) + "</figcaption></figure>\n";
}

double enlarged_in_stills(const View& view) {
  if (view.tool) { return 1.0; }
  const double moved = view.frames[view.peak].displacement.colwise().norm().maxCoeff();
  const double extent =
      (view.rest.rowwise().maxCoeff() - view.rest.rowwise().minCoeff()).maxCoeff();
  return moved > 0.0 ? enlargement(moved, extent) : 1.0;
}

std::string stills(const View& view) {
  const ViewFrame& peak = view.frames[view.peak];
  const double enlarged = enlarged_in_stills(view);
  const std::string cut =
      view.place.empty() ? "" : "Cut at y = " + quantity(mm * view.cut, "mm") + ". ";
  const std::string movement =
      enlarged == 1.0 ? "Movement is drawn to scale. "
                      : "Movement is drawn " + short_number(enlarged) + " times larger. ";
  return "<div class=\"exhibits stills\">\n" +
         still("Undeformed", still_at_rest(view), cut + "The skin is above, x to the right.") +
         still("Largest reaction, at " + quantity(peak.time, "s"),
               still_at(view, view.peak, enlarged),
               cut + movement + "Applied " + quantity(peak.applied, "N") + ", reaction " +
                   quantity(peak.reaction, "N") + ".") +
         "</div>\n";
}

}  // namespace

std::string html_view(const View& view) {
  const EncodedView encoded = encode(view);
  std::vector<std::string> notes = view.notes;
  notes.insert(notes.end(), encoded.notes.begin(), encoded.notes.end());
  return "<style>\n" + std::string(assets::view_css) + "</style>\n" +
         std::string(assets::view_html) + html_notes(notes) + stills(view) +
         inert_script("view-header", "application/json", encoded.header) +
         inert_script("view-numbers", "text/plain", encoded.numbers) +
         inert_script("view-three", "text/plain", base64(deflate(assets::three_js)));
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
