// SPDX-License-Identifier: MIT
#include "reports/view.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/needle_path.hpp"
#include "reports/force_lines.hpp"
#include "reports/markup.hpp"
#include "reports/tool_pass.hpp"
#include "reports/view_thinning.hpp"

namespace palpate {

namespace {

constexpr std::size_t most_even_frames = 60;
constexpr std::size_t most_springs_shown = 150'000;
constexpr std::size_t most_labels = 32;

std::optional<ViewTool> tool_of(const Scene& scene, const SpringNetwork& network) {
  if (!scene.needle && !scene.probe) { return std::nullopt; }
  const NeedlePath path = tool_path(scene, network);
  ViewTool tool{.origin = path.origin(), .direction = path.direction()};
  if (scene.needle) {
    tool.size.setConstant(scene.needle->diameter);
    return tool;
  }
  const bool fingertip = scene.probe->shape == Probe::Shape::fingertip;
  tool.shape = fingertip ? ViewTool::Shape::fingertip : ViewTool::Shape::ultrasound;
  tool.size = fingertip ? Eigen::Vector2d::Constant(scene.probe->size.x()).eval() : scene.probe->size;
  return tool;
}

ViewFocus focus_of(const View& view, const SpringNetwork& network, const Trace& trace) {
  ViewFocus focus{.cut = view.cut};
  if (!view.tool) { return focus; }
  constexpr double share = 0.12;  // of the body's largest extent
  const NodeVectors& rest = network.rest_position;
  focus.radius = share * (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).maxCoeff();
  const double deepest = std::max(0.0, std::ranges::max(values_of(trace, "tool.depth_m")));
  focus.begin = view.tool->origin;
  focus.end = view.tool->origin + deepest * view.tool->direction;
  return focus;
}

/// The middle of the cell at a node; of a node that is no cell's lowest corner, halfway to the node below it.
Eigen::Vector3d place_of_material(const SpringNetwork& network, const std::optional<CellGrid>& grid, int node) {
  const Eigen::Vector3d own = network.rest_position.col(node);
  if (!grid) { return own; }
  const GridPlace& place = grid->places()[static_cast<std::size_t>(node)];
  if (!grid->is_cell(place)) {
    const int below = grid->node_at(beside(place, 2, 1));
    return below < 0 ? own : Eigen::Vector3d(0.5 * (own + network.rest_position.col(below)));
  }
  const std::array<int, 8> corners = grid->corners(place);
  return 0.5 * (own + network.rest_position.col(corners[7]));
}

/// Layers that are nowhere what a cell is told to be of.
void tell_thin_layers(View& view, const Scene& scene) {
  std::string missing;
  for (const Layer& layer : scene.tissue.layers) {
    const std::string& label = layer.tissue.empty() ? layer.material : layer.tissue;
    if (std::ranges::find(view.labels, label) != view.labels.end()) { continue; }
    missing += (missing.empty() ? "" : ", ") + label;
  }
  if (!missing.empty()) {
    view.notes.push_back("thinner than the cells that hold them, and not told apart here: " + missing);
  }
}

void add_nodes(View& view, const ViewInput& input, const ShownNodes& shown) {
  const SpringNetwork& network = input.problem.network();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(network.node_count());
  Eigen::VectorXd count = sum;
  for (const Spring& spring : network.springs) {
    for (const int end : {spring.a, spring.b}) {
      sum(end) += spring.stiffness;
      count(end) += 1.0;
    }
  }
  const double first = std::min(0.0, network.rest_position.row(2).minCoeff());
  view.rest.resize(3, static_cast<Eigen::Index>(shown.nodes.size()));
  view.stiffness.resize(view.rest.cols());
  for (Eigen::Index n = 0; n < view.rest.cols(); ++n) {
    const int node = shown.nodes[static_cast<std::size_t>(n)];
    view.rest.col(n) = network.rest_position.col(node);
    view.stiffness(n) = sum(node) / std::max(1.0, count(node));
    view.fixed.push_back(network.fixed[static_cast<std::size_t>(node)]);
    std::string label = label_at(input.scene, place_of_material(network, shown.grid, node), first);
    if (label.empty()) { label = "tissue"; }
    auto known = std::ranges::find(view.labels, label);
    if (known == view.labels.end() && view.labels.size() < most_labels) { known = view.labels.insert(known, label); }
    view.label.push_back(
        static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(known - view.labels.begin(), most_labels - 1)));
  }
}

std::vector<int> numbers_of(const ShownNodes& shown, Eigen::Index nodes) {
  std::vector<int> number(static_cast<std::size_t>(nodes), -1);
  for (std::size_t n = 0; n < shown.nodes.size(); ++n) {
    number[static_cast<std::size_t>(shown.nodes[n])] = static_cast<int>(n);
  }
  return number;
}

void add_grid(View& view, const ShownNodes& shown, const std::vector<int>& number) {
  if (!shown.grid) { return; }
  for (const int node : shown.nodes) {
    const GridPlace& place = shown.grid->places()[static_cast<std::size_t>(node)];
    const std::array<int, 8> corners = shown.grid->corners(place);
    view.place.push_back(place);
    view.cell.push_back(shown.grid->is_cell(place) && std::ranges::all_of(corners, [&](int corner) {
                          return number[static_cast<std::size_t>(corner)] >= 0;
                        }));
  }
}

/// The skin of a grid: sides of its cells towards -z.
ViewSurface skin_of(const CellGrid& grid, const NodeVectors& rest) {
  ViewSurface skin{.label = "skin", .of_cells = true};
  std::vector<int> nodes;
  std::vector<int> vertex(grid.places().size(), -1);
  for (const GridFace& face : exposed_faces(grid, [](const GridPlace&) { return true; })) {
    const int above = grid.node_at(face.cell);
    const int opposite = grid.node_at({face.cell[0] + 1, face.cell[1] + 1, face.cell[2]});
    if (face.nodes[0] != above || face.nodes[2] != opposite) { continue; }
    std::array<int, 4> corner{};
    for (std::size_t n = 0; n < 4; ++n) {
      int& own = vertex[static_cast<std::size_t>(face.nodes[n])];
      if (own < 0) {
        own = static_cast<int>(skin.vertices.size());
        skin.vertices.push_back({{face.nodes[n], 1.0}});
        nodes.push_back(face.nodes[n]);
      }
      corner[n] = own;
    }
    skin.triangles.push_back({corner[0], corner[1], corner[2]});
    skin.triangles.push_back({corner[0], corner[2], corner[3]});
  }
  skin.rest = rest(Eigen::all, nodes);
  return skin;
}

void add_surfaces(View& view, std::vector<ViewSurface> surfaces, const std::vector<int>& number) {
  for (ViewSurface& surface : surfaces) {
    for (auto& vertex : surface.vertices) {
      for (ViewSurface::Support& support : vertex) { support.node = number[static_cast<std::size_t>(support.node)]; }
    }
    view.surfaces.push_back(std::move(surface));
  }
}

void add_springs(View& view, const SpringNetwork& network, const std::vector<int>& number) {
  std::vector<ViewSpring> springs;
  std::vector<double> lengths;
  for (const Spring& spring : network.springs) {
    const int a = number[static_cast<std::size_t>(spring.a)];
    const int b = number[static_cast<std::size_t>(spring.b)];
    if (a < 0 || b < 0) { continue; }
    springs.push_back({a, b, spring.stiffness});
    lengths.push_back(spring.rest_length);
  }
  if (springs.size() <= most_springs_shown) {
    view.springs = std::move(springs);
    return;
  }
  std::vector<double> sorted = lengths;
  std::ranges::nth_element(sorted, sorted.begin() + most_springs_shown);
  for (std::size_t n = 0; n < springs.size(); ++n) {
    if (lengths[n] < sorted[most_springs_shown]) { view.springs.push_back(springs[n]); }
  }
  view.notes.push_back("of " + short_number(static_cast<double>(springs.size()), 9) +
                       " springs between these nodes the " + short_number(static_cast<double>(view.springs.size()), 9) +
                       " shortest are shown");
}

/// Instants of the view: frames of the trace, thinned evenly, and moments between them.
std::vector<std::pair<double, const NodeVectors*>> instants_of(const ViewInput& input) {
  std::vector<std::pair<double, const NodeVectors*>> instants;
  const std::size_t count = input.trace.frames.size();
  const std::size_t even = std::min(count, most_even_frames);
  for (std::size_t n = 0; n < even; ++n) {
    const std::size_t frame = even < 2 ? 0 : n * (count - 1) / (even - 1);
    instants.emplace_back(input.trace.frame_time[frame], &input.trace.frames[frame]);
  }
  for (std::size_t n = 0; n < input.moments.time.size(); ++n) {
    if (std::ranges::find(instants, input.moments.time[n], &std::pair<double, const NodeVectors*>::first) ==
        instants.end()) {
      instants.emplace_back(input.moments.time[n], &input.moments.positions[n]);
    }
  }
  std::ranges::sort(instants, {}, &std::pair<double, const NodeVectors*>::first);
  std::erase_if(instants, [](const auto& instant) { return !instant.second->allFinite(); });
  return instants;
}

/// What a row says that happened.
std::string happened_in(const Trace& trace, std::size_t row) {
  const auto found = std::ranges::find(trace.text_columns, "tool.event", &TextColumn::name);
  if (found == trace.text_columns.end()) { return {}; }
  std::string text;
  for (const char c : found->values[row]) { text += c == ';' ? std::string(", ") : std::string(1, c); }
  return text;
}

void tell_forces(ViewFrame& frame, const ViewInput& input, const Eigen::Vector3d& held) {
  const Trace& trace = input.trace;
  if (has_tool(trace)) {
    const std::size_t row = row_at(trace, frame.time);
    frame.place = values_of(trace, "tool.insertion_m")[row];
    frame.depth = values_of(trace, "tool.depth_m")[row];
    frame.applied = values_of(trace, "tool.applied_n")[row];
    frame.reaction = values_of(trace, "tool.force_n")[row];
    frame.layer = layer_in(trace, row);
    frame.event = in_words(happened_in(trace, row));
  } else {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Load& load : input.problem.loads()) {
      sum += load_factor(load, frame.time, frame.time) * static_cast<double>(load.nodes.size()) * load.force;
    }
    frame.applied = sum.norm();
    frame.reaction = held.norm();
  }
}

void add_frames(View& view, const ViewInput& input, const ShownNodes& shown) {
  const SpringNetwork& network = input.problem.network();
  const SpringLaw law = SpringLaw::from(input.scene.simulation.printed);
  for (const auto& [time, position] : instants_of(input)) {
    const ForceLines lines = force_lines(network, law, *position);
    ViewFrame frame{.time = time};
    frame.displacement = (*position)(Eigen::all, shown.nodes) - view.rest;
    frame.line = lines.line(Eigen::all, shown.nodes);
    tell_forces(frame, input, lines.held);
    view.frames.push_back(std::move(frame));
  }
  const auto peak = std::ranges::max_element(view.frames, {}, &ViewFrame::reaction);
  view.peak = static_cast<std::size_t>(peak - view.frames.begin());
}

}  // namespace

std::optional<View> make_view(const ViewInput& input) {
  const SpringNetwork& network = input.problem.network();
  if (input.trace.frames.empty() || network.node_count() == 0) { return std::nullopt; }
  View view{.tool = tool_of(input.scene, network)};
  const auto y = network.rest_position.row(1);
  view.cut = view.tool ? view.tool->origin.y() : 0.5 * (y.minCoeff() + y.maxCoeff());
  std::vector<int> needed;
  for (const ViewSurface& surface : input.surfaces) {
    for (const auto& vertex : surface.vertices) {
      for (const ViewSurface::Support& support : vertex) { needed.push_back(support.node); }
    }
  }
  const ShownNodes shown = shown_nodes(network, focus_of(view, network, input.trace), needed);
  if (!shown.note.empty()) { view.notes.push_back(shown.note); }
  const std::vector<int> number = numbers_of(shown, network.node_count());
  add_nodes(view, input, shown);
  tell_thin_layers(view, input.scene);
  add_grid(view, shown, number);
  std::vector<ViewSurface> surfaces = input.surfaces;
  if (surfaces.empty() && shown.grid) { surfaces.push_back(skin_of(*shown.grid, network.rest_position)); }
  add_surfaces(view, std::move(surfaces), number);
  add_springs(view, network, number);
  add_frames(view, input, shown);
  if (view.frames.empty()) { return std::nullopt; }
  return view;
}

}  // namespace palpate
