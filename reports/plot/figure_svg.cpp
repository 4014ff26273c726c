// SPDX-License-Identifier: MIT

#include "reports/plot/figure_svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <png.h>
#include <span>
#include <stdexcept>
#include <utility>

#include "reports/html/html_page.hpp"
#include "reports/plot/figure_layout.hpp"
#include "reports/view/view_encoding.hpp"

namespace palpate {
namespace {

// All lengths are user units of the picture, which are pixels at its nominal width.
constexpr double picture_width = 480.0;
constexpr double bottom_margin = 52.0;
constexpr double axis_font = 13.5;  ///< as in report.css
constexpr double marker_radius = 2.8;
constexpr std::size_t most_markers = 60;  ///< on a line, where they only identify the series
constexpr double mark_row = 9.0;          ///< height of a row of mark signs above the plot
constexpr int most_mark_rows = 3;
constexpr double tallest_label = 104.0;
constexpr double label_pad = 4.0;  ///< above a zone label, and between it and the curves
constexpr int colour_levels = 64;  ///< of a heat map

/// Distinct labels of marks in order. The sign of a mark is shape_of_mark() of its index here.
std::vector<std::string> mark_labels(const Figure& figure) {
  std::vector<std::string> labels;
  for (const Mark& mark : figure.marks) {
    if (std::ranges::find(labels, mark.label) == labels.end()) { labels.push_back(mark.label); }
  }
  return labels;
}

std::string path_markup(const std::string& attributes, const SvgPath& path) {
  return path.empty() ? "" : "<path " + attributes + " d=\"" + path.data() + "\"/>";
}

std::string line_attributes(const std::string& colour_class, double width,
                            const char* dashes = "") {
  return "class=\"l " + colour_class + "\" stroke-width=\"" + svg_number(width) + "\"" +
         (*dashes == '\0' ? "" : std::string(" stroke-dasharray=\"") + dashes + "\"");
}

std::string text_markup(double x, double y, const char* anchor, const std::string& attributes,
                        const std::string& content) {
  return "<text x=\"" + svg_number(x) + "\" y=\"" + svg_number(y) + "\" text-anchor=\"" + anchor +
         "\"" + attributes + ">" + content + "</text>";
}

/// Text that reads from below, centred on (x, y).
std::string upright_text(double x, double y, const std::string& attributes,
                         const std::string& content) {
  return "<text transform=\"translate(" + svg_number(x) + " " + svg_number(y) +
         ")rotate(-90)\" text-anchor=\"middle\"" + attributes + ">" + content + "</text>";
}

std::string tick_text(const Tick& tick) {
  return escape_markup(tick.label) +
         (tick.exponent.empty() ? ""
                                : "<tspan class=\"up\" dy=\"-5\">" + tick.exponent + "</tspan>");
}

double tick_width(const Tick& tick) {
  return text_width(tick.label, axis_font) + 0.8 * text_width(tick.exponent, axis_font);
}

double widest(const std::vector<Tick>& ticks) {
  double width = 0.0;
  for (const Tick& tick : ticks) { width = std::max(width, tick_width(tick)); }
  return width;
}

/// Smaller type for an axis label that is longer than its axis.
std::string fitted(const std::string& label, double room) {
  const double width = text_width(label, axis_font);
  return width <= room
             ? ""
             : " style=\"font-size:" + svg_number(std::max(9.0, axis_font * room / width)) + "px\"";
}

// Heat maps: a PNG with 64 colours, transparent where there is no value.

using Rgba8 = std::array<std::uint8_t, 4>;
/// Colours of the levels; the last one is transparent.
using Palette = std::array<Rgba8, colour_levels + 1>;

struct ColourScale {
  Range range{};
  Palette colours{};

  /// Index of the colour of a value; colour_levels if it is not finite.
  [[nodiscard]] std::uint8_t level(double value) const {
    if (!std::isfinite(value)) { return colour_levels; }
    const double share = (value - range.low) / (range.high - range.low);
    return static_cast<std::uint8_t>(
        std::clamp(std::floor(colour_levels * share), 0.0, colour_levels - 1.0));
  }
};

Palette interpolated(std::span<const unsigned> codes) {
  Palette colours{};
  for (std::size_t n = 0; n < colour_levels; ++n) {
    const Rgb colour = interpolated_colour(codes, static_cast<double>(n) / (colour_levels - 1));
    for (std::size_t part = 0; part < 3; ++part) {
      colours[n][part] = static_cast<std::uint8_t>(std::lround(255.0 * colour[part]));
    }
    colours[n][3] = 255;
  }
  return colours;
}

/// Blue to pale to orange, symmetric about zero, if the values have both signs; else viridis.
ColourScale colour_scale(const HeatMap& map) {
  static constexpr std::array<unsigned, 6> viridis{0x440154, 0x414487, 0x2a788e,
                                                   0x22a884, 0x7ad151, 0xfde725};
  static constexpr std::array<unsigned, 7> two_signs{0x17406d, 0x3f7fb8, 0xa9cbe3, 0xf4f1ea,
                                                     0xf3bd8f, 0xd9722e, 0x7f2d0c};
  Range range;
  for (const double z : map.z) {
    if (!std::isfinite(z)) { continue; }
    range.low = range.empty ? z : std::min(range.low, z);
    range.high = range.empty ? z : std::max(range.high, z);
    range.empty = false;
  }
  if (range.low < 0.0 && range.high > 0.0) {
    range.high = std::max(-range.low, range.high);
    range.low = -range.high;
    return {range, interpolated(two_signs)};
  }
  return {with_extent(range), interpolated(viridis)};
}

/// Image element of a heat map that fills the rectangle. `levels` is row by row from the top.
std::string image_markup(double x, double y, double width, double height, std::size_t columns,
                         std::span<const std::uint8_t> levels, const ColourScale& scale) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(columns);
  image.height = static_cast<png_uint_32>(levels.size() / columns);
  image.format = PNG_FORMAT_RGBA_COLORMAP;
  image.colormap_entries = colour_levels + 1;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image) + 4 * scale.colours.size();
  std::string png(size, '\0');
  if (png_image_write_to_memory(&image, png.data(), &size, 0, levels.data(), 0,
                                scale.colours.data()) == 0) {
    throw std::runtime_error(std::string("libpng: ") + image.message);
  }
  png.resize(size);
  return "<image x=\"" + svg_number(x) + "\" y=\"" + svg_number(y) + "\" width=\"" +
         svg_number(width) + "\" height=\"" + svg_number(height) +
         "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," + base64(png) + "\"/>";
}

std::string colour_class(const Look& look) {
  return look.colour == ink_colour ? "k" : "s" + std::to_string(look.colour);
}

/// Mark with its position on the axis.
struct Sign {
  double x = 0.0;  ///< from the left edge of the plot
  int row = 0;     ///< above the plot, from 0
  Shape shape = Shape::disc;
};

class Drawing {
 public:
  explicit Drawing(const Figure& in_si)
      : figure_(in_field_units(in_si)), looks_(looks_of(figure_)) {
    lay_out();
  }

  [[nodiscard]] std::string markup() const {
    const std::string label = figure_.title + ". " + figure_.caption;
    std::string svg = "<svg role=\"img\" viewBox=\"0 0 480 " +
                      svg_number(top_ + height_ + bottom_margin) + "\" aria-label=\"" +
                      escape_markup(label) + "\">";
    svg += tints();
    if (has_map_) { svg += heat_map(); }
    svg += has_map_ ? "" : grid();
    svg += frame();  // below the curves, which may run along an axis
    const std::string curves = all_series();
    if (clipped_) {
      // A nested element clips without an id, which would have to be unique in the page.
      svg += "<svg x=\"" + svg_number(left_) + "\" y=\"" + svg_number(top_) + "\" width=\"" +
             svg_number(width_) + "\" height=\"" + svg_number(height_) + "\" viewBox=\"" +
             svg_number(left_) + " " + svg_number(top_) + " " + svg_number(width_) + " " +
             svg_number(height_) + "\">" + curves + "</svg>";
    } else {
      svg += curves;
    }
    return svg + mark_signs() + texts() + "</svg>";
  }

 private:
  void lay_out() {
    x_ = x_range(figure_);
    y_ = y_range(figure_);
    drawable_ =
        !x_.empty && !y_.empty && can_be_drawn(figure_.x, x_) && can_be_drawn(figure_.y, y_);
    if (!drawable_) {  // an empty frame shows that there was nothing to draw
      x_ = y_ = Range{0.0, 1.0, false};
      figure_.x.logarithmic = figure_.y.logarithmic = false;
    }
    figure_.square = figure_.square && !figure_.x.logarithmic && !figure_.y.logarithmic;
    has_map_ = drawable_ && figure_.heat_map && x_.high != x_.low && y_.high != y_.low;
    if (has_map_) { scale_ = colour_scale(*figure_.heat_map); }
    x_ = with_extent(x_);
    y_ = with_extent(y_);
    const bool curves = std::ranges::any_of(
        figure_.series, [](const Series& each) { return each.style != Series::Style::points; });
    annotated_ = drawable_ && !has_map_ && (!figure_.zones.empty() || !figure_.marks.empty());
    // Curves use the full width; isolated points keep a distance from the edges.
    if (!has_map_ && (!curves || figure_.square) && !annotated_) {
      x_ = out_to_ticks(figure_.x, x_);
    }
    const Range y_of_values = y_;
    if (!has_map_) { y_ = out_to_ticks(figure_.y, y_); }
    left_ = std::max(60.0, 34.0 + widest(ticks(figure_.y, y_, 8)));
    double right = 16.0;
    if (has_map_) { right = 74.0 + widest(linear_ticks(scale_.range, 6)); }
    width_ = picture_width - left_ - right;
    place_signs();
    int rows = 0;
    for (const Sign& sign : signs_) { rows = std::max(rows, sign.row + 1); }
    top_ = 8.0 + mark_row * rows;
    height_ = (!annotated_ ? 300.0 : figure_.zones.empty() ? 310.0 : 350.0) - top_ - bottom_margin;
    if (figure_.square && drawable_) { make_square(); }
    if (annotated_) {
      place_zones();
      if (!figure_.zones.empty()) { make_room_for_labels(y_of_values); }
    }
    x_ticks_ = ticks(figure_.x, x_, 7);
    for (int most = 6; most > 1 && !figure_.x.logarithmic; --most) {
      const double room = width_ / static_cast<double>(x_ticks_.size());
      if (widest(x_ticks_) + 10.0 <= room) { break; }
      x_ticks_ = ticks(figure_.x, x_, most);
    }
    y_ticks_ = ticks(figure_.y, y_, 8);
  }

  static bool can_be_drawn(const Axis& axis, const Range& range) {
    return std::isfinite(range.high - range.low) &&
           (!axis.logarithmic || (range.low > 0.0 && range.high > 0.0));
  }

  static std::vector<Tick> ticks(const Axis& axis, const Range& range, int most) {
    return axis.logarithmic ? logarithmic_ticks(range) : linear_ticks(range, most);
  }

  /// Equal scales: the height is adjusted. If the height would be extreme, a range is widened.
  void make_square() {
    const double x_span = std::abs(x_.high - x_.low);
    const double y_span = std::abs(y_.high - y_.low);
    height_ = std::clamp(width_ * y_span / x_span, 160.0, 430.0);
    const double per_unit = std::min(width_ / x_span, height_ / y_span);
    if (has_map_) {  // cells fill the plot
      width_ = per_unit * x_span;
      height_ = per_unit * y_span;
      return;
    }
    const auto grow = [](Range& range, double factor) {
      const double middle = 0.5 * (range.low + range.high);
      range.low = middle + factor * (range.low - middle);
      range.high = middle + factor * (range.high - middle);
    };
    grow(x_, width_ / (per_unit * x_span));
    grow(y_, height_ / (per_unit * y_span));
  }

  void place_signs() {
    if (!annotated_) { return; }
    const std::vector<std::string> labels = mark_labels(figure_);
    std::vector<Mark> marks = figure_.marks;
    std::erase_if(marks, [](const Mark& mark) { return std::isnan(mark.x); });
    std::ranges::stable_sort(marks, {}, &Mark::x);
    std::array<double, most_mark_rows> taken{};
    taken.fill(-unbounded);
    for (const Mark& mark : marks) {
      const double at = across(mark.x);
      if (!(at >= -0.5 && at <= width_ + 0.5)) { continue; }
      const auto* free =
          std::ranges::find_if(taken, [&](double last) { return at - last >= mark_row; });
      const std::size_t row =
          free == taken.end() ? 0 : static_cast<std::size_t>(free - taken.begin());
      taken.at(row) = at;
      const auto kind = std::ranges::find(labels, mark.label) - labels.begin();
      signs_.push_back({at, static_cast<int>(row), shape_of_mark(static_cast<std::size_t>(kind))});
    }
  }

  void place_zones() {
    for (const Zone& zone : figure_.zones) {
      double begin = across(zone.begin);
      double end = across(zone.end);
      if (begin > end) { std::swap(begin, end); }
      begin = std::max(begin, 0.0);
      end = std::min(end, width_);
      // Zones that cannot be seen keep their index, so that tints alternate.
      spans_.push_back(end > begin ? ZoneSpan{zone.label, begin, end} : ZoneSpan{});
    }
    labels_ = place_zone_labels(spans_, width_, tallest_label);
  }

  /// Raises the upper end of the y axis so that labels of zones lie above the curves, which keep
  /// at least 55 % of the height.
  void make_room_for_labels(Range values) {
    if (figure_.y.logarithmic || figure_.y.maximum || figure_.square) { return; }
    if (y_.low > y_.high) { return; }
    Range range = values;
    const double span = range.high - range.low;
    range.low = figure_.y.minimum || range.low >= 0.0 ? range.low : range.low - 0.04 * span;
    range.high += 0.05 * span;
    const double most = range.low + (range.high - range.low) / 0.55;
    double high = range.high;
    for (const ZoneLabel& label : labels_) {
      const double reach = 0.5 * label.width + 2.0;
      const double below = highest(label.middle - reach, label.middle + reach);
      const double share = (label.height + 3.0 * label_pad) / height_;
      if (below > range.low) {
        high = std::max(high, range.low + (below - range.low) / (1.0 - share));
      }
    }
    range.high = std::min(high, most);
    y_ = range;
  }

  /// Largest drawn value between two positions on the x axis; -infinity if there is none.
  [[nodiscard]] double highest(double from, double to) const {
    double most = -unbounded;
    for (const Series& series : figure_.series) {
      for (std::size_t n = 0; n < std::min(series.x.size(), series.y.size()); ++n) {
        const double place = across(series.x[n]);
        if (!(place >= from && place <= to)) { continue; }
        if (std::isfinite(series.y[n])) { most = std::max(most, series.y[n]); }
        if (n < series.y2.size() && std::isfinite(series.y2[n])) {
          most = std::max(most, series.y2[n]);
        }
      }
    }
    return most;
  }

  [[nodiscard]] double across(double x) const { return width_ * axis_share(figure_.x, x_, x); }
  [[nodiscard]] double px(double x) const { return left_ + bounded(across(x)); }
  [[nodiscard]] double py(double y) const {
    return top_ + height_ - bounded(height_ * axis_share(figure_.y, y_, y));
  }
  /// Limits values far outside to the number range of a path, with their direction; NaN is kept.
  static double bounded(double at) { return std::isfinite(at) ? std::clamp(at, -1e5, 1e5) : at; }

  [[nodiscard]] std::string tints() const {
    std::array<SvgPath, 2> paths;
    for (std::size_t n = 0; n < spans_.size(); ++n) {
      const ZoneSpan& span = spans_[n];
      if (!(span.end > span.begin)) { continue; }
      SvgPath& path = paths.at(n % 2);
      path.move(left_ + span.begin, top_);
      path.line(left_ + span.end, top_);
      path.line(left_ + span.end, top_ + height_);
      path.line(left_ + span.begin, top_ + height_);
      path.close();
    }
    return path_markup("class=\"f za\"", paths[0]) + path_markup("class=\"f zb\"", paths[1]);
  }

  [[nodiscard]] std::string grid() const {
    SvgPath path;
    for (const Tick& tick : y_ticks_) {
      if (tick.label.empty()) { continue; }
      path.move(left_, py(tick.value));
      path.line(left_ + width_, py(tick.value));
    }
    for (const Tick& tick : x_ticks_) {
      if (tick.label.empty()) { continue; }
      path.move(px(tick.value), top_);
      path.line(px(tick.value), top_ + height_);
    }
    return path_markup(line_attributes("g", 1.0), path);
  }

  [[nodiscard]] std::string heat_map() const {
    const HeatMap& map = *figure_.heat_map;
    const std::size_t columns = map.x.size();
    const std::size_t rows = map.y.size();
    const bool leftwards = columns > 1 && px(map.x[1]) < px(map.x[0]);
    const bool downwards = rows > 1 && py(map.y[1]) > py(map.y[0]);
    std::vector<std::uint8_t> levels;
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t from = columns * (downwards ? row : rows - 1 - row);
      for (std::size_t n = 0; n < columns; ++n) {
        levels.push_back(scale_.level(map.z.at(from + (leftwards ? columns - 1 - n : n))));
      }
    }
    std::vector<std::uint8_t> bar(colour_levels);
    for (std::size_t n = 0; n < bar.size(); ++n) {
      bar[n] = static_cast<std::uint8_t>(colour_levels - 1 - n);
    }
    return image_markup(left_, top_, width_, height_, columns, levels, scale_) +
           image_markup(bar_left(), top_, bar_width, height_, 1, bar, scale_);
  }

  [[nodiscard]] std::string all_series() const {
    clipped_ = false;
    std::string markup;
    for (const bool filled : {true, false}) {  // filled series lie behind the others
      for (std::size_t n = 0; drawable_ && n < figure_.series.size(); ++n) {
        if ((looks_[n].opacity > 0.0) == filled) { markup += series(n); }
      }
    }
    return markup;
  }

  [[nodiscard]] std::string series(std::size_t index) const {
    const Series& series = figure_.series[index];
    const Look& look = looks_[index];
    const Projection project = [this](double x, double y) { return Pixel{px(x), py(y)}; };
    std::vector<Pixel> run;
    std::vector<Pixel> upper;
    std::vector<Pixel> points;
    SvgPath path;
    const auto end_run = [&] {
      for (std::size_t n = 0; n < run.size(); ++n) {
        n == 0 ? path.move(run[n].x, run[n].y) : path.line(run[n].x, run[n].y);
      }
      for (std::size_t n = upper.size(); n-- > 0;) { path.line(upper[n].x, upper[n].y); }
      if (!upper.empty()) { path.close(); }
      run.clear();
      upper.clear();
    };
    for (const std::size_t n : thinned(series, project)) {
      const Pixel at = project(series.x[n], series.y[n]);
      const Pixel above = series.filled() ? project(series.x[n], series.y2[n]) : at;
      if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(above.y)) {
        end_run();
        continue;
      }
      const bool inside = is_inside(at) && is_inside(above);
      if (inside) { points.push_back(at); }
      if (!look.line && !series.filled()) { continue; }
      clipped_ = clipped_ || !inside;
      run.push_back(at);
      if (series.filled()) { upper.push_back(above); }
    }
    end_run();
    const std::string colour = colour_class(look);
    if (series.filled()) {
      return path_markup("class=\"f " + colour + "\" opacity=\"" + svg_number(look.opacity) + "\"",
                         path);
    }
    SvgPath markers;
    SvgPath halos;
    const std::size_t stride = look.line ? points.size() / most_markers + 1 : 1;
    for (std::size_t n = 0; look.points && n < points.size(); n += stride) {
      markers.marker(look.shape, points[n].x, points[n].y, marker_radius);
      halos.marker(look.shape, points[n].x, points[n].y, 1.5 * marker_radius);
    }
    std::string halo;
    if (has_map_) {  // rim in the page colour: the map contains every brightness
      halo = path_markup(line_attributes("p", 4.2), path) +
             path_markup(marker_attributes(look.shape, "p", 1.5 * marker_radius), halos);
    }
    constexpr std::array dashes{"", "8.5 5", "8.5 4 1.7 4"};
    return halo +
           path_markup(
               line_attributes(colour, look.width, dashes.at(static_cast<std::size_t>(look.dash))),
               path) +
           path_markup(marker_attributes(look.shape, colour, marker_radius), markers);
  }

  [[nodiscard]] bool is_inside(const Pixel& at) const {
    return at.x >= left_ - 0.5 && at.x <= left_ + width_ + 0.5 && at.y >= top_ - 0.5 &&
           at.y <= top_ + height_ + 0.5;
  }

  [[nodiscard]] std::string frame() const {
    const double right = left_ + width_;
    const double low = top_ + height_;
    SvgPath path;
    path.move(left_, top_);
    path.line(left_, low);
    path.line(right, low);
    if (has_map_) {
      path.line(right, top_);
      path.close();
    }
    for (const Tick& tick : x_ticks_) {
      path.move(px(tick.value), low);
      path.line(px(tick.value), low + (tick.label.empty() ? 2.5 : 5.0));
    }
    for (const Tick& tick : y_ticks_) {
      path.move(left_, py(tick.value));
      path.line(left_ - (tick.label.empty() ? 2.5 : 5.0), py(tick.value));
    }
    return path_markup(line_attributes("k", 1.0), path);
  }

  [[nodiscard]] std::string mark_signs() const {
    SvgPath stems;
    std::array<SvgPath, shape_count> shapes;
    constexpr double radius = 2.8;
    for (const Sign& sign : signs_) {
      const double y = top_ - mark_row * (0.5 + sign.row);
      stems.move(left_ + sign.x, top_ + height_);
      stems.line(left_ + sign.x, y);
      shapes.at(static_cast<std::size_t>(sign.shape)).marker(sign.shape, left_ + sign.x, y, radius);
    }
    std::string markup = path_markup(line_attributes("n", 0.9, "1.5 2.5"), stems);
    for (std::size_t n = 0; n < shapes.size(); ++n) {
      markup += path_markup(marker_attributes(static_cast<Shape>(n), "n", radius), shapes.at(n));
    }
    return markup;
  }

  [[nodiscard]] std::string texts() const {
    constexpr double half_capital = 4.6;  // distance from the centre of a text line to its baseline
    const double low = top_ + height_;
    std::string markup;
    for (const Tick& tick : y_ticks_) {
      if (tick.label.empty()) { continue; }
      markup += text_markup(left_ - 8.0, py(tick.value) + half_capital, "end", "", tick_text(tick));
    }
    for (const Tick& tick : x_ticks_) {
      if (tick.label.empty()) { continue; }
      markup += text_markup(px(tick.value), low + 19.0, "middle", "", tick_text(tick));
    }
    const std::string x = without_unit_one(figure_.x.label);
    const std::string y = without_unit_one(figure_.y.label);
    const double middle = top_ + 0.5 * height_;
    if (!x.empty()) {
      markup += text_markup(left_ + 0.5 * width_, low + 42.0, "middle", fitted(x, picture_width),
                            escape_markup(x));
    }
    const double column = left_ - 20.0 - widest(y_ticks_);
    if (!y.empty()) {
      markup += upright_text(column, middle, fitted(y, low + 20.0), escape_markup(y));
    }
    if (has_map_) { markup += colour_bar_texts(); }
    for (const ZoneLabel& label : labels_) { markup += zone_label(label); }
    return markup;
  }

  [[nodiscard]] std::string colour_bar_texts() const {
    const Range& range = scale_.range;
    const std::vector<Tick> ticks = linear_ticks(range, 6);
    SvgPath path;
    std::string markup;
    const double right = bar_left() + bar_width;
    for (const Tick& tick : ticks) {
      const double y = top_ + height_ * (range.high - tick.value) / (range.high - range.low);
      path.move(right, y);
      path.line(right + 4.0, y);
      markup += text_markup(right + 8.0, y + 4.6, "start", "", tick_text(tick));
    }
    const std::string label = without_unit_one(figure_.heat_map->label);
    return path_markup(line_attributes("k", 1.0), path) + markup +
           upright_text(right + widest(ticks) + 24.0, top_ + 0.5 * height_,
                        fitted(label, top_ + height_ + 20.0), escape_markup(label));
  }

  [[nodiscard]] std::string zone_label(const ZoneLabel& label) const {
    constexpr double base = 3.8;  // distance from the centre of a text line to its baseline
    const double x = left_ + label.middle;
    const double y = top_ + label_pad;
    const std::string text = escape_markup(label.text);
    if (!label.upright) {
      return text_markup(x, y + 0.5 * zone_line + base, "middle", " class=\"note\"", text);
    }
    return upright_text(x + base, y + 0.5 * label.height,
                        " class=\"note\" style=\"font-size:" + svg_number(label.font) + "px\"",
                        text);
  }

  static constexpr double bar_width = 14.0;
  [[nodiscard]] double bar_left() const { return left_ + width_ + 12.0; }

  Figure figure_;
  std::vector<Look> looks_;
  Range x_{}, y_{};
  bool drawable_ = true;  ///< both axes have a range
  bool has_map_ = false;
  bool annotated_ = false;         ///< zones or marks are drawn
  mutable bool clipped_ = false;   ///< a line leaves the plot
  double left_ = 0.0, top_ = 0.0;  ///< corner of the plot
  double width_ = 0.0, height_ = 0.0;
  ColourScale scale_{};
  std::vector<Tick> x_ticks_{}, y_ticks_{};
  std::vector<Sign> signs_{};
  std::vector<ZoneSpan> spans_{};
  std::vector<ZoneLabel> labels_{};
};

/// Key of a series: a stroke, its marker, or a filled box.
std::string sample(const Look& look) {
  const std::string colour = colour_class(look);
  std::string svg = "<svg class=\"sample\" viewBox=\"0 0 28 12\" aria-hidden=\"true\">";
  if (look.opacity > 0.0) {
    svg += "<path class=\"f " + colour + "\" opacity=\"" + svg_number(look.opacity + 0.08) +
           "\" d=\"M1 1h26v10h-26z\"/>";
  }
  if (look.line) {
    constexpr std::array dashes{"", "6 3.5", "7 3 1.5 3"};
    svg +=
        "<path " +
        line_attributes(colour, look.width + 0.3, dashes.at(static_cast<std::size_t>(look.dash))) +
        " d=\"M1 6h26\"/>";
  }
  if (look.points) {
    constexpr double r = 3.0;
    SvgPath path;
    path.marker(look.shape, 14.0, 6.0, r);
    svg += path_markup(marker_attributes(look.shape, colour, r), path);
  }
  return svg + "</svg>";
}

/// Key of a kind of mark: line and sign.
std::string sample(Shape shape) {
  constexpr double r = 3.0;
  SvgPath path;
  path.marker(shape, 14.0, 3.5, r);
  return "<svg class=\"sample\" viewBox=\"0 0 28 12\" aria-hidden=\"true\"><path " +
         line_attributes("n", 0.9, "1.5 1.5") + " d=\"M14 6v6\"/>" +
         path_markup(marker_attributes(shape, "n", r), path) + "</svg>";
}

using Style = Series::Style;

bool is_marked(Style style) { return style == Style::points || style == Style::line_and_points; }

/// Returns true if points and dashed lines alternate in the whole figure.
bool comes_in_pairs(const std::deque<Series>& series) {
  if (series.size() < 2 || series.size() % 2 != 0) { return false; }
  for (std::size_t n = 0; n < series.size(); n += 2) {
    if (!is_marked(series[n].style) || series[n + 1].style != Style::dashed) { return false; }
  }
  return true;
}

std::string tenths_text(long tenths) {
  std::string text = tenths < 0 ? "-" : "";
  const long size = std::labs(tenths);
  if (size >= 10 || size == 0) { text += std::to_string(size / 10); }
  if (size % 10 != 0) { text += "." + std::to_string(size % 10); }
  return text;
}

long tenths_of(double value) { return std::lround(10.0 * value); }

/// Writes a number after another; a minus sign replaces the separating space.
std::string pair_text(long x, long y) {
  const std::string second = tenths_text(y);
  return tenths_text(x) + (second[0] == '-' ? "" : " ") + second;
}

}  // namespace

std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures) {
  std::vector<std::string> drawings;
  for (const Figure* figure : figures) { drawings.push_back(Drawing(*figure).markup()); }
  return drawings;
}

std::string html_legend(const Figure& figure) {
  const std::vector<Look> looks = looks_of(figure);
  std::string items;
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    if (figure.series[n].label.empty()) { continue; }
    items += "<li>" + sample(looks[n]) + escape_markup(figure.series[n].label) + "</li>";
  }
  const std::vector<std::string> kinds = mark_labels(figure);
  for (std::size_t n = 0; n < kinds.size(); ++n) {
    items += "<li>" + sample(shape_of_mark(n)) + escape_markup(kinds[n]) + "</li>";
  }
  return items.empty() ? items : "<ul class=\"legend\">" + items + "</ul>";
}

std::vector<Look> looks_of(const Figure& figure) {
  const bool pairs = comes_in_pairs(figure.series);
  const bool stacked = std::ranges::any_of(
      figure.series, [](const Series& series) { return series.style == Style::area; });
  std::vector<Look> looks;
  std::size_t coloured = 0;  // series before this one that have a colour of their own
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Style style = figure.series[n].style;
    const bool shares = style == Style::thin && n > 0;
    const auto turn = static_cast<int>(shares ? 0 : pairs ? n / 2 : coloured);
    coloured += shares ? 0 : 1;
    Look look{.colour = turn % series_colours, .shape = static_cast<Shape>(turn % shape_count)};
    // Text colour first, then the colours that neither palette contains.
    if (figure.heat_map) { look.colour = turn == 0 ? ink_colour : (turn + 2) % series_colours; }
    look.line = style != Style::points && !figure.series[n].filled();
    if (stacked && !figure.series[n].filled()) { look.colour = ink_colour; }
    look.points = is_marked(style);
    look.opacity = style == Style::band ? 0.22 : style == Style::area ? 0.5 : 0.0;
    look.dash = style == Style::dashed ? 1 : turn >= series_colours ? 2 : 0;
    if (style == Style::thin) { look.width = 0.7; }
    looks.push_back(look);
  }
  return looks;
}

Shape shape_of_mark(std::size_t kind) { return static_cast<Shape>(kind % shape_count); }

std::string without_unit_one(const std::string& label) {
  constexpr std::string_view one = " (1)";
  return label.ends_with(one) ? label.substr(0, label.size() - one.size()) : label;
}

std::string svg_number(double value) { return tenths_text(tenths_of(value)); }

std::string marker_attributes(Shape shape, const std::string& colour_class, double r) {
  const std::string width = "\" stroke-width=\"" + svg_number(2.0 * r) + "\"";
  switch (shape) {
    case Shape::disc: return "class=\"l c " + colour_class + width;
    case Shape::square: return "class=\"l q " + colour_class + width;
    case Shape::triangle:
    case Shape::diamond: return "class=\"f " + colour_class + "\"";
    case Shape::open_disc:
    case Shape::open_square: break;
  }
  return "class=\"l " + colour_class + "\"";
}

void SvgPath::move(double x, double y) {
  x_ = tenths_of(x);
  y_ = tenths_of(y);
  data_ += "M" + pair_text(x_, y_);
}

void SvgPath::line(double x, double y) { step(tenths_of(x), tenths_of(y)); }

void SvgPath::step(long x, long y) {
  if (x == x_ && y == y_) { return; }
  if (y == y_) {
    data_ += "h" + tenths_text(x - x_);
  } else if (x == x_) {
    data_ += "v" + tenths_text(y - y_);
  } else {
    data_ += "l" + pair_text(x - x_, y - y_);
  }
  x_ = x;
  y_ = y;
}

void SvgPath::marker(Shape shape, double x, double y, double r) {
  const std::string at = "M" + pair_text(tenths_of(x), tenths_of(y));
  const std::string d = svg_number(2.0 * r);
  const auto from = [&](double dx, double dy) {
    return "M" + pair_text(tenths_of(x + dx), tenths_of(y + dy));
  };
  const auto by = [](double dx, double dy) { return pair_text(tenths_of(dx), tenths_of(dy)); };
  switch (shape) {
    case Shape::disc:
    case Shape::square: data_ += at + "h0"; return;
    case Shape::triangle:
      data_ += from(0.0, -1.3 * r) + "l" + by(-1.3 * r, 2.1 * r) + "h" + svg_number(2.6 * r) + "z";
      return;
    case Shape::diamond: {
      const double c = 1.4 * r;
      data_ += from(0.0, -c) + "l" + by(c, c) + "l" + by(-c, c) + "l" + by(-c, -c) + "z";
      return;
    }
    case Shape::open_disc: {
      const std::string radius = svg_number(r);
      data_ += from(-r, 0.0) + "a" + radius + " " + radius + " 0 1 0 " + d + " 0a" + radius + " " +
               radius + " 0 1 0-" + d + " 0";
      return;
    }
    case Shape::open_square: data_ += from(-r, -r) + "h" + d + "v" + d + "h-" + d + "z"; return;
  }
}

}  // namespace palpate
