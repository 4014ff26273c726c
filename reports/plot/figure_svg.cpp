// SPDX-License-Identifier: MIT

#include "reports/plot/figure_svg.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <sys/wait.h>
#include <utility>
#include <vector>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/html/html_page.hpp"
#include "reports/plot/figure_look.hpp"
#include "reports/plot/gnuplot.hpp"

namespace palpate {

namespace {

/// Name and attributes of one tag; the name of an end tag starts with '/'.
struct Tag {
  std::string name;
  std::map<std::string, std::string> attributes;

  [[nodiscard]] std::string get(const std::string& key, const std::string& otherwise = "") const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? otherwise : found->second;
  }
};

/// gnuplot quotes with ' or ", and sometimes puts spaces around '='.
Tag parse_tag(std::string_view text) {
  Tag tag;
  const std::size_t name_end = std::min(text.find_first_of(" \n\t/>", 1), text.size());
  tag.name = text.substr(0, name_end);
  std::size_t at = name_end;
  while (true) {
    const std::size_t equals = text.find('=', at);
    if (equals == std::string_view::npos) { return tag; }
    const std::size_t key_end = text.find_last_not_of(" \n\t", equals - 1) + 1;
    const std::size_t key = text.find_last_of(" \n\t", key_end - 1) + 1;
    const std::size_t open = text.find_first_of("'\"", equals);
    const std::size_t close = text.find(text[open], open + 1);
    tag.attributes[std::string(text.substr(key, key_end - key))] =
        text.substr(open + 1, close - open - 1);
    at = close + 1;
  }
}

/// Class of a stand-in colour ("rgb(  1,   2,  16)" is "s0"), or the colour itself as a value.
struct Colour {
  std::string css_class{};
  std::string value{};
};

Colour colour_of(const std::string& text) {
  int red = 0;
  int green = 0;
  int blue = 0;
  if (std::sscanf(text.c_str(), "rgb(%d,%d,%d)", &red, &green, &blue) != 3) { return {"k", {}}; }
  if (red == StandIn::red && green == StandIn::green) {
    if (blue >= StandIn::first_series) {
      return {"s" + std::to_string(blue - StandIn::first_series), {}};
    }
    static const std::map<int, std::string> classes{{StandIn::grid, "g"},
                                                    {StandIn::paper, "p"},
                                                    {StandIn::zone_a, "za"},
                                                    {StandIn::zone_b, "zb"},
                                                    {StandIn::note, "n"}};
    const auto found = classes.find(blue);
    return {found == classes.end() ? "k" : found->second, {}};
  }
  std::array<char, 8> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "#%02x%02x%02x", red & 255, green & 255, blue & 255);
  return {{}, buffer.data()};
}

/// gnuplot's marker numbers for the shapes of a Look.
Shape shape_of(const std::string& reference) {
  static const std::map<std::string, Shape> shapes{
      {"#gpPt6", Shape::disc},     {"#gpPt4", Shape::square},    {"#gpPt8", Shape::triangle},
      {"#gpPt12", Shape::diamond}, {"#gpPt5", Shape::open_disc}, {"#gpPt3", Shape::open_square}};
  const auto found = shapes.find(reference);
  return found == shapes.end() ? Shape::disc : found->second;
}

class Rewriter {
 public:
  std::string rewrite(const std::string& svg, const std::string& label) {
    std::size_t at = 0;
    while ((at = svg.find('<', at)) != std::string::npos) {
      const std::size_t end = svg.find('>', at);
      if (end == std::string::npos) { break; }
      const Tag tag = parse_tag(std::string_view(svg).substr(at + 1, end - at - 1));
      at = end + 1;
      if (tag.name == "defs" || tag.name == "title" || tag.name == "desc") {
        at = svg.find("</" + tag.name, at);
      } else if (tag.name == "text") {
        const std::size_t close = svg.find("</text>", at);
        text(svg.substr(at, close - at));
        at = close;
      } else {
        element(tag);
      }
    }
    flush();
    return "<svg role=\"img\" viewBox=\"" + view_box_ + "\" aria-label=\"" + escape_markup(label) +
           "\">" + out_ + texts_ + "</svg>";
  }

 private:
  void element(const Tag& tag) {
    if (tag.name == "svg") { view_box_ = tag.get("viewBox"); }
    if (tag.name == "g") { groups_.push_back(tag); }
    // What lies above must not join a path that lies below.
    if (tag.get("id").find("plot_plot_") != std::string::npos) { flush(); }
    if (tag.name == "/g" && !groups_.empty()) { groups_.pop_back(); }
    if (tag.name == "path") { path(tag); }
    if (tag.name == "polygon") { polygon(tag); }
    if (tag.name == "use") { marker(tag); }
    if (tag.name == "image") { image(tag); }
  }

  [[nodiscard]] std::string inherited(const std::string& key, const std::string& otherwise) const {
    for (auto group = groups_.rbegin(); group != groups_.rend(); ++group) {
      if (group->attributes.contains(key)) { return group->get(key); }
    }
    return otherwise;
  }

  /// Lines of equal attributes become one path, all ticks for instance.
  SvgPath& open(const std::string& attributes) {
    for (auto& [known, path] : open_) {
      if (known == attributes) { return path; }
    }
    return open_.emplace_back(attributes, SvgPath{}).second;
  }

  void flush() {
    // Tints lie under the grid, the grid under axes and ticks.
    for (const char* lower : {"class=\"l g\"", "class=\"f z"}) {
      std::ranges::stable_partition(
          open_, [&](const auto& each) { return each.first.starts_with(lower); });
    }
    for (const auto& [attributes, path] : open_) {
      if (!path.empty()) { out_ += "<path " + attributes + " d=\"" + path.data() + "\"/>"; }
    }
    open_.clear();
  }

  void path(const Tag& tag) {
    const Colour colour = colour_of(tag.get("stroke"));
    std::string attributes = "class=\"l " + colour.css_class + "\" stroke-width=\"" +
                             svg_number(std::atof(inherited("stroke-width", "1").c_str())) + "\"";
    const std::string dashes = tag.get("stroke-dasharray");
    if (!dashes.empty()) { attributes += " stroke-dasharray=\"" + dashes + "\""; }
    open(attributes).append(tag.get("d"));
  }

  void polygon(const Tag& tag) {
    const Colour colour = colour_of(tag.get("fill"));
    std::string attributes = colour.css_class.empty()
                                 ? "fill=\"" + colour.value + "\" shape-rendering=\"crispEdges\""
                                 : "class=\"f " + colour.css_class + "\"";
    const std::string opacity = tag.get("fill-opacity");
    if (!opacity.empty()) {
      attributes += " opacity=\"" + svg_number(std::atof(opacity.c_str())) + "\"";
    }
    SvgPath& shape = open(attributes);
    shape.append(tag.get("points"));
    shape.close();
  }

  void marker(const Tag& tag) {
    double x = 0.0;
    double y = 0.0;
    double scale = 0.0;
    if (std::sscanf(tag.get("transform").c_str(), "translate(%lf,%lf) scale(%lf)", &x, &y,
                    &scale) != 3) {
      return;
    }
    const Shape shape = shape_of(tag.get("xlink:href"));
    const std::string colour = colour_of(tag.get("color")).css_class;
    open(marker_attributes(shape, colour, scale)).marker(shape, x, y, scale);
  }

  void image(const Tag& tag) {
    flush();
    out_ += "<image";
    for (const char* key : {"x", "y", "width", "height"}) {
      out_ += std::string(" ") + key + "=\"" + tag.get(key) + "\"";
    }
    out_ += " preserveAspectRatio=\"none\" href=\"" + tag.get("xlink:href") + "\"/>";
  }

  /// The content keeps its tspans (exponents) without what only repeats the default.
  void text(const std::string& content) {
    std::string inner;
    for (std::size_t at = 0; at < content.size();) {
      const std::size_t end =
          content[at] == '<' ? content.find('>', at) + 1 : content.find('<', at);
      const std::string piece = content.substr(at, end - at);
      at = std::min(end, content.size());
      inner += piece[0] == '<'
                   ? tspan(parse_tag(std::string_view(piece).substr(1, piece.size() - 2)))
                   : piece;
    }
    const std::size_t first = inner.find_first_not_of(' ');
    if (first == std::string::npos) { return; }
    const std::string anchor = inherited("text-anchor", "start");
    const bool note = colour_of(inherited("fill", "")).css_class == "n";
    texts_ += std::string(note ? "<text class=\"note\" " : "<text ") +
              position(inherited("transform", "")) +
              (anchor == "start" ? "" : " text-anchor=\"" + anchor + "\"") + ">" +
              with_powers(inner.substr(first)) + "</text>";
  }

  /// A tick label "−5e−05" as a power of ten.
  static std::string with_powers(const std::string& text) {
    static const std::regex scientific("^([−0-9.]+)e(−|-|\\+?)0*([1-9][0-9]*)$");
    std::smatch parts;
    if (!std::regex_match(text, parts, scientific)) { return text; }
    const std::string sign = parts[2].str().empty() || parts[2] == "+" ? "" : "−";
    return parts[1].str() + "·10<tspan class=\"up\" dy=\"-5\">" + sign + parts[3].str() +
           "</tspan>";
  }

  static std::string tspan(const Tag& tag) {
    const std::string dy = tag.get("dy");
    if (tag.name == "/tspan" || dy.empty()) { return {}; }
    // SVG has no end for a shift: an exponent lasts until the one that takes it back.
    const bool up = dy[0] == '-';
    return up ? "<tspan class=\"up\" dy=\"-5\">" : "</tspan>";
  }

  static std::string position(const std::string& transform) {
    double x = 0.0;
    double y = 0.0;
    double angle = 0.0;
    const int found =
        std::sscanf(transform.c_str(), "translate(%lf,%lf) rotate(%lf)", &x, &y, &angle);
    if (found < 3) { return "x=\"" + svg_number(x) + "\" y=\"" + svg_number(y) + "\""; }
    return "transform=\"translate(" + svg_number(x) + " " + svg_number(y) + ")rotate(" +
           svg_number(angle) + ")\"";
  }

  std::string out_{}, texts_{}, view_box_{};
  std::vector<Tag> groups_{};
  std::vector<std::pair<std::string, SvgPath>> open_{};
};

}  // namespace

std::string svg_for_page(const std::string& gnuplot, const std::string& label) {
  return Rewriter().rewrite(gnuplot, label);
}

namespace {

std::string file_text(const std::filesystem::path& path) {
  try {
    return io::read_text(path, 256U << 20U);
  } catch (const InputError& problem) {
    throw DrawingError(std::string("gnuplot drew nothing: ") + problem.what());
  }
}

/// Own and user's settings of gnuplot are left out, so that every machine draws the same.
void run_gnuplot(const std::filesystem::path& folder) {
  const std::string in = "'" + folder.string() + "/";
  const std::string command =
      "GNUTERM=svg LC_ALL=C.UTF-8 gnuplot -d " + in + "figures.gp' 2>" + in + "log' </dev/null";
  const int status = std::system(command.c_str());
  if (status == 0) { return; }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    throw DrawingError("gnuplot is not installed; scripts/setup installs it");
  }
  throw DrawingError("gnuplot failed: " + file_text(folder / "log").substr(0, 500));
}

/// A stroke of the series, its marker, or a filled box.
std::string sample(const Look& look) {
  const std::string colour = look.colour == ink_colour ? "k" : "s" + std::to_string(look.colour);
  std::string svg = "<svg class=\"sample\" viewBox=\"0 0 28 12\" aria-hidden=\"true\">";
  if (look.opacity > 0.0) {
    svg += "<path class=\"f " + colour + "\" opacity=\"" + svg_number(look.opacity + 0.08) +
           "\" d=\"M1 1h26v10h-26z\"/>";
  }
  if (look.line) {
    const char* dashes[] = {"", " stroke-dasharray=\"6 3.5\"", " stroke-dasharray=\"7 3 1.5 3\""};
    svg += "<path class=\"l " + colour + "\" stroke-width=\"2\"" + dashes[look.dash] +
           " d=\"M1 6h26\"/>";
  }
  if (look.points) {
    constexpr double r = 3.0;
    SvgPath path;
    path.marker(look.shape, 14.0, 6.0, r);
    svg += "<path " + marker_attributes(look.shape, colour, r) + " d=\"" + path.data() + "\"/>";
  }
  return svg + "</svg>";
}

/// Line and sign of a kind of mark.
std::string sample(Shape shape) {
  constexpr double r = 3.0;
  SvgPath path;
  path.marker(shape, 14.0, 3.5, r);
  return "<svg class=\"sample\" viewBox=\"0 0 28 12\" aria-hidden=\"true\">"
         "<path class=\"l n\" stroke-width=\".9\" stroke-dasharray=\"1.5 1.5\" d=\"M14 6v6\"/>"
         "<path " +
         marker_attributes(shape, "n", r) + " d=\"" + path.data() + "\"/></svg>";
}

}  // namespace

std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures) {
  if (figures.empty()) { return {}; }
  const io::ScratchFolder scratch;
  const auto picture = [&](std::size_t n) { return scratch.path() / (std::to_string(n) + ".svg"); };
  std::string script;
  for (std::size_t n = 0; n < figures.size(); ++n) {
    script += gnuplot_script(*figures[n], picture(n).string());
  }
  io::replace_file(scratch.path() / "figures.gp", script);
  run_gnuplot(scratch.path());
  std::vector<std::string> drawings;
  for (std::size_t n = 0; n < figures.size(); ++n) {
    const std::string label = figures[n]->title + ". " + figures[n]->caption;
    drawings.push_back(svg_for_page(file_text(picture(n)), label));
  }
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

}  // namespace palpate
