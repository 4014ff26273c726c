// SPDX-License-Identifier: MIT

#include "reports/view/view.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "model/problem/needle_path.hpp"
#include "model/tissue/skin.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "reports/html/html_page.hpp"
#include "reports/plot/trace_figures.hpp"

namespace palpate {
namespace {

using Tensors = Eigen::Matrix<double, 9, Eigen::Dynamic>;

/// Direction and value of the eigenvalue with the largest magnitude.
Eigen::Vector4f principal(const Eigen::Matrix3d& tensor) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(tensor);
  const Eigen::Vector3d& forces = solver.eigenvalues();
  const int at = std::abs(forces(0)) > std::abs(forces(2)) ? 0 : 2;  // ascending order
  Eigen::Vector4d line;
  line << solver.eigenvectors().col(at), forces(at);
  return line.allFinite() ? Eigen::Vector4f(line.cast<float>()) : Eigen::Vector4f::Zero();
}

constexpr std::size_t most_even_frames = 60;
constexpr std::size_t most_springs_shown = 150'000;
constexpr std::size_t most_labels = 32;

std::optional<ViewTool> tool_of(const Scene& scene, const SpringNetwork& network) {
  if (!scene.needle && !scene.probe) { return std::nullopt; }
  const NeedlePath path(scene, network);
  ViewTool tool{.origin = path.origin(), .direction = path.direction()};
  if (scene.needle) {
    tool.size.setConstant(scene.needle->diameter);
    return tool;
  }
  const bool fingertip = scene.probe->shape == Probe::Shape::fingertip;
  tool.shape = fingertip ? ViewTool::Shape::fingertip : ViewTool::Shape::ultrasound;
  tool.size =
      fingertip ? Eigen::Vector2d::Constant(scene.probe->size.x()).eval() : scene.probe->size;
  return tool;
}

/// Plane of constant y that hides no part of the tool's line: the smallest y between its entry and
/// its deepest place.
double nearest_cut(const ViewTool& tool, const Trace& trace) {
  const double deepest = std::max(0.0, std::ranges::max(values_of(trace, "tool.insertion_m")));
  return tool.origin.y() + std::min(0.0, deepest * tool.direction.y());
}

ViewFocus focus_of(const View& view, const SpringNetwork& network, const Trace& trace) {
  ViewFocus focus{.cut = view.cut};
  if (!view.tool) { return focus; }
  constexpr double share = 0.12;  // fraction of the body's largest extent
  const NodeVectors& rest = network.rest_position;
  focus.radius = share * (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).maxCoeff();
  const double deepest = std::max(0.0, std::ranges::max(values_of(trace, "tool.depth_m")));
  focus.begin = view.tool->origin;
  focus.end = view.tool->origin + deepest * view.tool->direction;
  return focus;
}

/// Centre of the cell at a node. For a node that is not the lowest corner of a cell, the midpoint
/// to the node below it, or a place just above it if tissue ends there.
Eigen::Vector3d place_of_material(const SpringNetwork& network, const std::optional<CellGrid>& grid,
                                  int node) {
  const Eigen::Vector3d own = network.rest_position.col(node);
  if (!grid) { return own; }
  const GridPlace& place = grid->places()[static_cast<std::size_t>(node)];
  if (!grid->is_cell(place)) {
    const int below = grid->node_at(beside(place, 2, 1));
    const int above = grid->node_at(beside(place, 2, -1));
    const auto way_to = [&](int other) -> Eigen::Vector3d {
      return other < 0 ? Eigen::Vector3d(0.0, 0.0, 0.0) : network.rest_position.col(other) - own;
    };
    // Planes of the grid are further apart across a gap.
    const bool ends = below < 0 || (above >= 0 && way_to(below).z() > -1.5 * way_to(above).z());
    return ends ? own + 1e-6 * way_to(above) : own + 0.5 * way_to(below);
  }
  const std::array<int, 8> corners = grid->corners(place);
  return 0.5 * (own + network.rest_position.col(corners[7]));
}

/// Adds a note about layers that are not the label of any node.
void tell_thin_layers(View& view, const Scene& scene) {
  std::string missing;
  for (const Layer& layer : scene.tissue.layers) {
    const std::string& label = layer.tissue.empty() ? layer.material : layer.tissue;
    if (layer.gap || std::ranges::find(view.labels, label) != view.labels.end()) { continue; }
    missing += (missing.empty() ? "" : ", ") + label;
  }
  if (!missing.empty()) {
    view.notes.push_back("thinner than a cell, and not shown separately: " + missing);
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
  view.nodes = shown.nodes;
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
    if (known == view.labels.end() && view.labels.size() < most_labels) {
      known = view.labels.insert(known, label);
    }
    view.label.push_back(static_cast<std::uint8_t>(
        std::min<std::ptrdiff_t>(known - view.labels.begin(), most_labels - 1)));
  }
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

/// New number of an item, which is appended to `kept` at its first use.
int renumbered(int item, std::vector<int>& number, std::vector<int>& kept) {
  int& own = number[static_cast<std::size_t>(item)];
  if (own < 0) {
    own = static_cast<int>(kept.size());
    kept.push_back(item);
  }
  return own;
}

/// Returns whether a face is that of its cell towards -z.
bool faces_up(const CellGrid& grid, const GridFace& face) {
  return face.nodes[0] == grid.node_at(face.cell) &&
         face.nodes[2] == grid.node_at({face.cell[0] + 1, face.cell[1] + 1, face.cell[2]});
}

/// Skin surface of a grid: cell faces towards -z.
ViewSurface skin_of(const CellGrid& grid, const NodeVectors& rest) {
  ViewSurface skin{.label = "skin", .of_cells = true};
  std::vector<int> nodes;
  std::vector<int> vertex(grid.places().size(), -1);
  for (const GridFace& face : exposed_faces(grid)) {
    if (!faces_up(grid, face)) { continue; }
    std::array<int, 4> corner{};
    for (std::size_t n = 0; n < 4; ++n) { corner[n] = renumbered(face.nodes[n], vertex, nodes); }
    skin.triangles.push_back({corner[0], corner[1], corner[2]});
    skin.triangles.push_back({corner[0], corner[2], corner[3]});
  }
  for (const int node : nodes) { skin.vertices.push_back({{node, 1.0}}); }
  skin.rest = rest(Eigen::all, nodes);
  return skin;
}

/// Draws the upper nodes of a grid on the skin that shapes the layers. The cells below it have
/// steps; the picture would show a gap between them and the skin.
void attach_to_skin(View& view, const Skin& skin, const CellGrid& grid, const NodeVectors& rest,
                    const std::vector<int>& number) {
  constexpr double steps = 2.0;  // furthest node that is moved, in heights of its cell
  double furthest = 0.0;
  for (const GridFace& face : exposed_faces(grid)) {
    const bool up = faces_up(grid, face);
    const std::array<int, 8> corners = grid.corners(face.cell);
    for (const int node : face.nodes) {
      const int shown = number[static_cast<std::size_t>(node)];
      if (shown < 0) { continue; }
      const Eigen::Vector3d place = rest.col(node);
      const std::optional<Skin::Stretch> beneath = skin.beneath(place.x(), place.y());
      if (!beneath || !(up || place.z() < beneath->top)) { continue; }
      const double height = rest(2, corners[7]) - rest(2, corners[0]);
      const double way = std::abs(beneath->top - place.z());
      if (way > steps * height) { continue; }
      view.rest(2, shown) = beneath->top;
      furthest = std::max(furthest, way);
    }
  }
  if (furthest > 0.0) {
    view.notes.push_back("the upper nodes are drawn on the skin, at most " +
                         quantity(mm * furthest, "mm") + " from their place in the model");
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
                       " springs between these nodes the " +
                       short_number(static_cast<double>(view.springs.size()), 9) +
                       " shortest are shown");
}

/// Times of the view: trace frames, thinned evenly, and times between them.
std::vector<std::pair<double, const NodeVectors*>> instants_of(const ViewInput& input) {
  std::vector<std::pair<double, const NodeVectors*>> instants;
  const std::size_t count = input.trace.frames.position.size();
  const std::size_t even = std::min(count, most_even_frames);
  for (std::size_t n = 0; n < even; ++n) {
    const std::size_t frame = even < 2 ? 0 : n * (count - 1) / (even - 1);
    instants.emplace_back(input.trace.frames.time[frame], &input.trace.frames.position[frame]);
  }
  for (std::size_t n = 0; n < input.trace.keyframes.time.size(); ++n) {
    if (std::ranges::find(instants, input.trace.keyframes.time[n],
                          &std::pair<double, const NodeVectors*>::first) == instants.end()) {
      instants.emplace_back(input.trace.keyframes.time[n], &input.trace.keyframes.position[n]);
    }
  }
  std::ranges::sort(instants, {}, &std::pair<double, const NodeVectors*>::first);
  std::erase_if(instants, [](const auto& instant) { return !instant.second->allFinite(); });
  return instants;
}

/// Events of a row, each with its layer.
std::string happened_in(const Trace& trace, std::size_t row) {
  std::string text;
  for (const Event& event : trace.events) {
    if (row_at(trace, event.time) != row) { continue; }
    text += (text.empty() ? "" : ", ") + in_words(event.kind) +
            (event.detail.empty() ? "" : ": " + event.detail);
  }
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
    frame.event = happened_in(trace, row);
  } else {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Load& load : input.problem.loads()) {
      sum += load_factor(load, frame.time, frame.time) * static_cast<double>(load.nodes.size()) *
             load.force;
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

Eigen::AlignedBox3d around(const NodeGrid& grid) {
  Eigen::AlignedBox3d box(grid.first,
                          grid.place(grid.count[0] - 1, grid.count[1] - 1, grid.count[2] - 1));
  constexpr double reach = 2.0;  // spacings, as of embed(): what lies further away does not move
  const Eigen::Vector3d room = Eigen::Vector3d::Constant(reach * grid.spacing.maxCoeff());
  return {box.min() - room, box.max() + room};
}

std::vector<std::array<int, 3>> faces_around(const TriangleSurface& surface,
                                             const Eigen::AlignedBox3d& box) {
  std::vector<std::array<int, 3>> faces;
  for (const auto& face : surface.triangle) {
    Eigen::AlignedBox3d around_face;
    for (const int vertex : face) {
      around_face.extend(Eigen::Vector3d(surface.vertex.col(vertex)));
    }
    if (box.intersects(around_face)) { faces.push_back(face); }
  }
  return faces;
}

constexpr GridPlace nowhere{-1, -1, -1};

std::size_t slot(const GridPlace& extent, const GridPlace& p) {
  return (static_cast<std::size_t>(p[2]) * static_cast<std::size_t>(extent[1]) +
          static_cast<std::size_t>(p[1])) *
             static_cast<std::size_t>(extent[0]) +
         static_cast<std::size_t>(p[0]);
}

bool within(const GridPlace& extent, const GridPlace& p) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (p[axis] < 0 || p[axis] >= extent[axis]) { return false; }
  }
  return true;
}

/// Index of the grid plane of each coordinate along an axis.
std::vector<int> planes_of(const Eigen::RowVectorXd& coordinate) {
  const double same = 1e-6 * (coordinate.maxCoeff() - coordinate.minCoeff());
  std::vector<double> planes(coordinate.begin(), coordinate.end());
  std::ranges::sort(planes);
  std::size_t kept = 0;
  for (const double plane : planes) {
    if (kept == 0 || plane - planes[kept - 1] > same) { planes[kept++] = plane; }
  }
  planes.resize(kept);
  std::vector<int> index;
  for (const double x : coordinate) {
    index.push_back(static_cast<int>(std::ranges::upper_bound(planes, x + same) - planes.begin()) -
                    1);
  }
  return index;
}

/// Grid indices of the nodes; empty if few nodes share planes, so that there is no grid.
std::vector<GridPlace> places_by_planes(const NodeVectors& position) {
  constexpr double most_room = 64.0;  // maximum number of grid positions per node
  std::array<std::vector<int>, 3> index;
  double room = 1.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    auto& planes = index[static_cast<std::size_t>(axis)];
    planes = planes_of(position.row(axis));
    room *= 1.0 + *std::ranges::max_element(planes);
  }
  if (room > most_room * static_cast<double>(position.cols())) { return {}; }
  std::vector<GridPlace> places;
  for (std::size_t n = 0; n < index[0].size(); ++n) {
    places.push_back({index[0][n], index[1][n], index[2][n]});
  }
  return places;
}

std::vector<GridPlace> places_of(const SpringNetwork& network) {
  const auto& shape = network.springs.lattice();
  if (!shape) { return places_by_planes(network.rest_position); }
  std::vector<GridPlace> places;
  for (int node = 0; node < shape->node_count(); ++node) { places.push_back(shape->place(node)); }
  return places;
}

/// Bit `axis` of a node is set if a spring connects it to the next node along that axis.
std::vector<std::uint8_t> edges_of(const SpringNetwork& network,
                                   const std::vector<GridPlace>& places) {
  std::vector<std::uint8_t> edges(places.size(), 0);
  for (const Spring& spring : network.springs) {
    const auto a = static_cast<std::size_t>(spring.a);
    const auto b = static_cast<std::size_t>(spring.b);
    GridPlace step{};
    int apart = 0;
    for (std::size_t n = 0; n < 3; ++n) {
      step[n] = places[b][n] - places[a][n];
      apart += std::abs(step[n]);
    }
    if (apart != 1) { continue; }
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto bit = static_cast<std::uint8_t>(1U << axis);
      if (step[axis] != 0) { edges[step[axis] > 0 ? a : b] |= bit; }
    }
  }
  return edges;
}

using Marks = std::vector<std::uint8_t>;  // 1: the node is shown

bool is_near(const ViewFocus& focus, const Eigen::Vector3d& point) {
  const Eigen::Vector3d way = focus.end - focus.begin;
  const double along =
      std::clamp((point - focus.begin).dot(way) / std::max(way.squaredNorm(), 1e-300), 0.0, 1.0);
  return (point - focus.begin - along * way).norm() < focus.radius;
}

/// Marks the corners of the cells at the surface, on both sides of the cut, and near the tool.
Marks shell_of(const CellGrid& grid, const SpringNetwork& network, const ViewFocus& focus) {
  Marks shown(static_cast<std::size_t>(network.node_count()), 0);
  const auto mark = [&](const GridPlace& cell) {
    for (const int node : grid.corners(cell)) { shown[static_cast<std::size_t>(node)] = 1; }
  };
  for (const GridFace& face : exposed_faces(grid)) { mark(face.cell); }
  for (const GridPlace& cell : grid.cells()) {
    const std::array<int, 8> nodes = grid.corners(cell);
    const Eigen::Vector3d low = network.rest_position.col(nodes[0]);
    const Eigen::Vector3d high = network.rest_position.col(nodes[7]);
    const double reach = high.y() - low.y();
    const bool at_cut = low.y() - reach <= focus.cut && focus.cut <= high.y() + reach;
    if (at_cut || is_near(focus, 0.5 * (low + high))) { mark(cell); }
  }
  return shown;
}

Marks all_of(const CellGrid& grid) {
  Marks shown(grid.places().size(), 0);
  for (std::size_t n = 0; n < shown.size(); ++n) { shown[n] = grid.places()[n][0] >= 0; }
  return shown;
}

/// Selects every n-th node, and all nodes near the tool up to the limit.
Marks sample_of(const SpringNetwork& network, const ViewFocus& focus) {
  const auto count = static_cast<std::size_t>(network.node_count());
  Marks shown(count, 0);
  const std::size_t stride = count / most_nodes_shown_all + 1;
  for (std::size_t n = 0; n < count; n += stride) { shown[n] = 1; }
  int room = most_nodes_shown - most_nodes_shown_all;
  for (std::size_t n = 0; n < count && room > 0; ++n) {
    if (shown[n] != 0 || !is_near(focus, network.rest_position.col(static_cast<Eigen::Index>(n)))) {
      continue;
    }
    shown[n] = 1;
    --room;
  }
  return shown;
}

long count_of_marks(const Marks& marks) { return std::ranges::count(marks, std::uint8_t{1}); }

ShownNodes chosen(Marks shown, const std::vector<int>& needed, std::optional<CellGrid> grid,
                  const std::string& which) {
  for (const int node : needed) { shown[static_cast<std::size_t>(node)] = 1; }
  ShownNodes result{.grid = std::move(grid)};
  for (std::size_t n = 0; n < shown.size(); ++n) {
    if (shown[n] != 0) { result.nodes.push_back(static_cast<int>(n)); }
  }
  if (result.nodes.size() < shown.size()) {
    result.note = short_number(static_cast<double>(result.nodes.size()), 9) + " of " +
                  short_number(static_cast<double>(shown.size()), 9) + " nodes are shown: " + which;
  }
  return result;
}

std::string near_tool(const ViewFocus& focus) {
  return focus.radius > 0.0
             ? " and what is within " + quantity(mm * focus.radius, "mm") + " of the tool's line"
             : "";
}

}  // namespace

ForceLines force_lines(const SpringNetwork& network, const SpringLaw& law,
                       const NodeVectors& position) {
  ForceLines result;
  Tensors tensors = Tensors::Zero(9, position.cols());
  for (const Spring& spring : network.springs) {
    const Eigen::Vector3d d = position.col(spring.b) - position.col(spring.a);
    const double length = d.norm();
    if (!(length >= zero_length)) { continue; }
    const Eigen::Vector3d u = d / length;
    const Eigen::Vector3d on_a =
        spring_force<double>(law, {spring.stiffness, spring.rest_length, 0.0}, d, length, 0.0);
    const Eigen::Matrix3d pull = 0.5 * on_a * u.transpose();
    tensors.col(spring.a) += pull.reshaped();
    tensors.col(spring.b) += pull.reshaped();
    if (network.is_fixed(spring.a)) { result.held += on_a; }
    if (network.is_fixed(spring.b)) { result.held -= on_a; }
  }
  result.line = Eigen::Matrix4Xf::Zero(4, position.cols());
  for (Eigen::Index node = 0; node < position.cols(); ++node) {
    if (tensors.col(node).isZero(0.0)) { continue; }
    result.line.col(node) = principal(tensors.col(node).reshaped(3, 3));
  }
  return result;
}

std::optional<View> make_view(const ViewInput& input) {
  const SpringNetwork& network = input.problem.network();
  if (input.trace.frames.position.empty() || network.node_count() == 0) { return std::nullopt; }
  View view{.tool = tool_of(input.scene, network)};
  const auto y = network.rest_position.row(1);
  view.cut = view.tool ? nearest_cut(*view.tool, input.trace) : 0.5 * (y.minCoeff() + y.maxCoeff());
  std::vector<int> needed;
  for (const ViewSurface& surface : input.surfaces) {
    for (const auto& vertex : surface.vertices) {
      for (const ViewSurface::Support& support : vertex) { needed.push_back(support.node); }
    }
  }
  const ShownNodes shown = shown_nodes(network, focus_of(view, network, input.trace), needed);
  if (!shown.note.empty()) { view.notes.push_back(shown.note); }
  std::vector<int> number(static_cast<std::size_t>(network.node_count()), -1);
  for (std::size_t n = 0; n < shown.nodes.size(); ++n) {
    number[static_cast<std::size_t>(shown.nodes[n])] = static_cast<int>(n);
  }
  add_nodes(view, input, shown);
  tell_thin_layers(view, input.scene);
  add_grid(view, shown, number);
  std::vector<ViewSurface> surfaces = input.surfaces;
  if (surfaces.empty() && shown.grid) {
    surfaces.push_back(skin_of(*shown.grid, network.rest_position));
  }
  for (ViewSurface& surface : surfaces) {
    for (auto& vertex : surface.vertices) {
      for (ViewSurface::Support& support : vertex) {
        support.node = number[static_cast<std::size_t>(support.node)];
      }
    }
    view.surfaces.push_back(std::move(surface));
  }
  add_springs(view, network, number);
  add_frames(view, input, shown);
  if (view.frames.empty()) { return std::nullopt; }
  if (input.scene.tissue.skin && input.scene.tissue.skin->shapes_layers() && shown.grid) {
    attach_to_skin(view, *input.scene.tissue.skin, *shown.grid, network.rest_position, number);
  }
  return view;
}

std::optional<ViewSurface> view_of_skin(const Scene& scene, std::vector<std::string>& notes) {
  const std::optional<NodeGrid> grid = scene.tissue.skin ? tissue_grid(scene) : std::nullopt;
  if (!grid) { return {}; }
  const TriangleSurface& surface = scene.tissue.skin->surface();
  ViewSurface skin{.label = "skin", .triangles = faces_around(surface, around(*grid))};
  const auto in_words = [](std::size_t count) {
    return short_number(static_cast<double>(count), 9);
  };
  if (skin.triangles.size() > most_faces_shown) {
    notes.push_back("the skin is not shown: " + in_words(skin.triangles.size()) +
                    " of its faces lie around the tissue, and a page takes " +
                    in_words(most_faces_shown));
    return {};
  }
  if (skin.triangles.size() < surface.triangle.size()) {
    notes.push_back(in_words(skin.triangles.size()) + " of " + in_words(surface.triangle.size()) +
                    " faces of the skin are shown: those around the tissue");
  }
  std::vector<int> vertices;
  std::vector<int> number(static_cast<std::size_t>(surface.vertex.cols()), -1);
  for (auto& face : skin.triangles) {
    for (int& vertex : face) { vertex = renumbered(vertex, number, vertices); }
  }
  skin.rest = surface.vertex(Eigen::all, vertices);
  for (const EmbeddedPoint& point : embed(skin.rest, *grid)) {
    std::vector<ViewSurface::Support>& supports = skin.vertices.emplace_back();
    for (std::size_t n = 0; point.follows() && n < point.node.size(); ++n) {
      if (point.weight[n] > 0.0) { supports.push_back({point.node[n], point.weight[n]}); }
    }
  }
  return skin;
}

int CellGrid::node_at(const GridPlace& place) const {
  return within(extent_, place) ? node_at_[slot(extent_, place)] : -1;
}

bool CellGrid::is_cell(const GridPlace& lowest) const {
  return within(extent_, lowest) && cell_at_[slot(extent_, lowest)] != 0;
}

std::array<int, 8> CellGrid::corners(const GridPlace& lowest) const {
  std::array<int, 8> nodes{};
  for (int n = 0; n < 8; ++n) {
    nodes[static_cast<std::size_t>(n)] =
        node_at({lowest[0] + (n & 1), lowest[1] + (n >> 1 & 1), lowest[2] + (n >> 2)});
  }
  return nodes;
}

void CellGrid::add_nodes(std::vector<GridPlace> places, const std::vector<std::uint8_t>& present) {
  place_ = std::move(places);
  for (std::size_t n = 0; n < place_.size(); ++n) {
    if (present[n] == 0) { place_[n] = nowhere; }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent_[axis] = std::max(extent_[axis], place_[n][axis] + 1);
    }
  }
  node_at_.assign(slot(extent_, {0, 0, extent_[2]}), -1);
  cell_at_.assign(node_at_.size(), 0);
  for (std::size_t n = 0; n < place_.size(); ++n) {
    if (place_[n] != nowhere) { node_at_[slot(extent_, place_[n])] = static_cast<int>(n); }
  }
}

template <class IsCell> void CellGrid::add_cells(IsCell is_cell) {
  for (const GridPlace& place : place_) {
    if (place == nowhere || !is_cell(place)) { continue; }
    cell_at_[slot(extent_, place)] = 1;
    cells_.push_back(place);
  }
}

std::optional<CellGrid> CellGrid::of(const SpringNetwork& network) {
  if (network.node_count() == 0) { return std::nullopt; }
  CellGrid grid;
  std::vector<GridPlace> places = places_of(network);
  if (places.empty()) { return std::nullopt; }
  const std::vector<std::uint8_t> edges = edges_of(network, places);
  grid.add_nodes(std::move(places), std::vector<std::uint8_t>(edges.size(), 1));
  grid.add_cells([&](const GridPlace& lowest) {
    const std::array<int, 8> nodes = grid.corners(lowest);
    for (unsigned n = 0; n < 8; ++n) {
      const auto wanted = static_cast<std::uint8_t>(~n & 7U);  // axes with a further corner
      if (nodes[n] < 0 || (edges[static_cast<std::size_t>(nodes[n])] & wanted) != wanted) {
        return false;
      }
    }
    return true;
  });
  if (grid.cells_.empty()) { return std::nullopt; }
  return grid;
}

CellGrid CellGrid::thinned(int n) const {
  CellGrid grid;
  std::vector<GridPlace> places = place_;
  std::vector<std::uint8_t> present(places.size(), 0);
  for (std::size_t node = 0; node < places.size(); ++node) {
    present[node] = std::ranges::all_of(places[node], [n](int index) { return index % n == 0; });
    for (int& index : places[node]) { index /= n; }
  }
  grid.add_nodes(std::move(places), present);
  grid.add_cells([&](const GridPlace& lowest) {
    const std::array<int, 8> nodes = grid.corners(lowest);
    if (std::ranges::find(nodes, -1) != nodes.end()) { return false; }
    for (int part = 0; part < n * n * n; ++part) {
      const GridPlace fine{n * lowest[0] + part % n, n * lowest[1] + part / n % n,
                           n * lowest[2] + part / (n * n)};
      if (!is_cell(fine)) { return false; }
    }
    return true;
  });
  return grid;
}

std::vector<GridFace> exposed_faces(const CellGrid& grid) {
  // Corners of the faces towards -x, +x, -y, +y, -z, +z.
  static constexpr std::array<std::array<std::size_t, 4>, 6> sides{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  std::vector<GridFace> faces;
  for (const GridPlace& cell : grid.cells()) {
    const std::array<int, 8> nodes = grid.corners(cell);
    for (int side = 0; side < 6; ++side) {
      if (grid.is_cell(beside(cell, side / 2, side % 2 == 0 ? -1 : 1))) { continue; }
      GridFace face{cell, {}};
      for (std::size_t n = 0; n < 4; ++n) {
        face.nodes[n] = nodes[sides[static_cast<std::size_t>(side)][n]];
      }
      faces.push_back(face);
    }
  }
  return faces;
}

ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus,
                       const std::vector<int>& needed) {
  std::optional<CellGrid> grid = CellGrid::of(network);
  if (network.node_count() <= most_nodes_shown_all) {
    return chosen(Marks(static_cast<std::size_t>(network.node_count()), 1), needed, std::move(grid),
                  "");
  }
  if (!grid) {
    return chosen(sample_of(network, focus), needed, std::nullopt, "every n-th" + near_tool(focus));
  }
  for (int n = 1;; ++n) {
    CellGrid coarse = n == 1 ? *grid : grid->thinned(n);
    const std::string planes = n == 1 ? ""
                                      : " of every " + std::to_string(n) +
                                            (n == 2   ? "nd"
                                             : n == 3 ? "rd"
                                                      : "th") +
                                            " plane of the grid";
    const Marks all = all_of(coarse);
    if (count_of_marks(all) <= most_nodes_shown_all) {
      return chosen(all, needed, std::move(coarse), "those" + planes);
    }
    const Marks shell = shell_of(coarse, network, focus);
    if (count_of_marks(shell) > most_nodes_shown) { continue; }
    return chosen(shell, needed, std::move(coarse),
                  "the surface, the plane of the cut" + near_tool(focus) + planes);
  }
}

}  // namespace palpate
