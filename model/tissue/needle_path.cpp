// SPDX-License-Identifier: MIT
/// Materials along the line of a needle.

#include "model/problem/needle_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "model/tissue/contact_size.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Stretch {
  double begin = infinity;
  double end = -infinity;
};

/// Returns the interval of the line origin + xi n inside a body; begin >= end if they do not
/// intersect.
Stretch inside(const Inclusion& body, const Eigen::Vector3d& origin, const Eigen::Vector3d& n) {
  const Eigen::Vector3d from = origin - body.centre;
  if (body.shape == Inclusion::Shape::sphere) {
    const double radius = 0.5 * body.size.x();
    const double half = from.dot(n);
    const double square = half * half - from.squaredNorm() + radius * radius;
    if (square <= 0.0) { return {}; }
    return {-half - std::sqrt(square), -half + std::sqrt(square)};
  }
  Stretch stretch{-infinity, infinity};
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = 0.5 * body.size(axis);
    if (n(axis) == 0.0) {
      if (std::abs(from(axis)) > reach) { return {}; }
      continue;
    }
    const double one = (-reach - from(axis)) / n(axis);
    const double other = (reach - from(axis)) / n(axis);
    stretch.begin = std::max(stretch.begin, std::min(one, other));
    stretch.end = std::min(stretch.end, std::max(one, other));
  }
  return stretch;
}

PathInterval interval_of(const Material* material, std::string label) {
  if (material == nullptr) { return {.label = std::move(label)}; }
  return interval_in(*material, std::move(label), 0.0, infinity);
}

PathInterval interval_of(const Scene& scene, const Layer& layer) {
  return interval_of(find_material(scene.materials, layer.material),
                     layer.tissue.empty() ? layer.material : layer.tissue);
}

/// Layers below a skin that need not be flat, with gaps where the line leaves the body. Nodes begin
/// within half a spacing of the skin. Layers are measured from the first node, so that the first
/// layer has its full thickness.
class LayersOnLine {
 public:
  LayersOnLine(const Scene& scene, const Eigen::Vector3d& origin, const Eigen::Vector3d& n)
      : scene_(scene), origin_(origin), n_(n), step_(0.1 * scene.tissue.block.spacing) {}

  std::vector<PathInterval> from(double first) {
    const double start = skin_near(first);
    const double shift = first - start;
    const LatticeShape block = block_shape(scene_);
    const double last = (block.spacing * (block.nodes[2] - 1) - origin_.z()) / n_.z();
    std::vector<PathInterval> intervals;
    std::ptrdiff_t here = std::max<std::ptrdiff_t>(layer(start), 0);
    add(intervals, here, first);
    for (int n = 0; start + n * step_ < last; ++n) {
      double begin = start + n * step_;
      const double end = start + (n + 1) * step_;
      while (layer(end) != here) {
        begin = change(begin, end, here);
        here = layer(begin);
        add(intervals, here, begin + shift);
      }
    }
    return intervals;
  }

 private:
  static constexpr std::ptrdiff_t outside = -1;
  static constexpr double same_place = 1e-9;  // [m]

  [[nodiscard]] std::ptrdiff_t layer(double xi) const {
    const double depth = depth_in_layers(scene_, origin_ + xi * n_);
    return depth < -same_place ? outside
                               : static_cast<std::ptrdiff_t>(layer_at(scene_.tissue.layers, depth));
  }
  /// Returns the depth at which the line enters the body, within one and a half spacings of
  /// `first`; otherwise `first`.
  [[nodiscard]] double skin_near(double first) const {
    for (int n = -15; n < 15; ++n) {
      const double end = first + (n + 1) * step_;
      if (layer(first + n * step_) == outside && layer(end) != outside) {
        return change(first + n * step_, end, outside);
      }
    }
    return first;
  }
  /// Returns the first position after a change between two positions.
  [[nodiscard]] double change(double low, double high, std::ptrdiff_t before) const {
    while (high - low > same_place) {
      const double middle = 0.5 * (low + high);
      (layer(middle) == before ? low : high) = middle;
    }
    return high;
  }
  void add(std::vector<PathInterval>& intervals, std::ptrdiff_t of, double begin) const {
    if (!intervals.empty()) { intervals.back().end = begin; }
    intervals.push_back(
        of == outside ? PathInterval{.label = "gap"}
                      : interval_of(scene_, scene_.tissue.layers[static_cast<std::size_t>(of)]));
    intervals.back().begin = begin;
    intervals.back().end = infinity;
  }

  const Scene& scene_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d n_;
  double step_;
};

/// Returns the layers, or the single material of a lattice, from `first` on.
std::vector<PathInterval> ground(const Scene& scene, const Eigen::Vector3d& origin,
                                 const Eigen::Vector3d& n, double first) {
  if (layers_follow_skin(scene)) { return LayersOnLine(scene, origin, n).from(first); }
  std::vector<PathInterval> intervals;
  double begin = first;
  for (const Layer& layer : scene.tissue.layers) {
    PathInterval next = interval_of(scene, layer);
    next.begin = begin;
    next.end = begin += layer.thickness / n.z();
    intervals.push_back(std::move(next));
  }
  if (intervals.empty()) {
    const std::string& name = scene.tissue.lattice.material;
    intervals.push_back(interval_of(find_material(scene.materials, name), name));
    intervals.front().begin = first;
  }
  intervals.back().end = infinity;
  return intervals;
}

}  // namespace

PathInterval interval_in(const Material& material, std::string label, double begin, double end) {
  const TissueRole role = role_of(material);
  const bool bone = role == TissueRole::bone;
  return {
      .begin = begin,
      .end = end,
      .puncture_force = bone ? infinity : material.puncture_force.value_or(material.cutting_force),
      .cutting_force = bone ? infinity : material.cutting_force,
      .indentation_toe = material.indentation_toe,
      .friction = material.friction,
      .friction_travel = material.friction_travel,
      .friction_exponent = material.friction_exponent,
      .outflow_resistance = material.outflow_resistance,
      .role = role,
      .label = std::move(label),
      .youngs_modulus = material.youngs_modulus,
      .poissons_ratio = material.poissons_ratio,
      .law = law_of(material)};
}

std::vector<PathInterval> intervals_along(const Scene& scene, const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double first) {
  if (scene.tissue.voxels) {
    return voxel_intervals(*scene.tissue.voxels, scene.materials, origin, direction, first);
  }
  std::vector<PathInterval> line = ground(scene, origin, direction, first);
  for (const Inclusion& body : scene.tissue.inclusions) {
    Stretch within = inside(body, origin, direction);
    within.begin = std::max(within.begin, first);
    if (!(within.end > within.begin)) { continue; }
    PathInterval middle = interval_of(find_material(scene.materials, body.material), body.material);
    middle.begin = within.begin;
    middle.end = within.end;
    std::vector<PathInterval> cut;
    for (const PathInterval& old : line) {
      if (old.begin < within.begin) {
        cut.push_back(old);
        cut.back().end = std::min(old.end, within.begin);
      }
      if (old.end > within.begin && old.begin <= within.begin) { cut.push_back(middle); }
      if (old.end > within.end) {
        cut.push_back(old);
        cut.back().begin = std::max(old.begin, within.end);
      }
    }
    line = std::move(cut);
  }
  return line;
}

std::string label_at(const Scene& scene, const Eigen::Vector3d& point, double first) {
  if (layers_follow_skin(scene)) {
    const std::vector<Layer>& layers = scene.tissue.layers;
    const std::vector<Inclusion>& bodies = scene.tissue.inclusions;
    const auto body = std::find_if(bodies.rbegin(), bodies.rend(),
                                   [&](const Inclusion& each) { return contains(each, point); });
    if (body != bodies.rend()) { return body->material; }
    return interval_of(scene, layers[layer_at(layers, depth_in_layers(scene, point))]).label;
  }
  const auto line =
      intervals_along(scene, {point.x(), point.y(), 0.0}, Eigen::Vector3d::UnitZ(), first);
  const auto found =
      std::ranges::find_if(line, [&](const PathInterval& each) { return point.z() < each.end; });
  return found == line.end() ? line.back().label : found->label;
}

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Returns the distance of neighbouring nodes [m]: the median over the nodes of the length of the
/// shortest spring.
double node_spacing(const SpringNetwork& network) {
  std::vector<double> shortest(static_cast<std::size_t>(network.node_count()),
                               std::numeric_limits<double>::infinity());
  for (const Spring& s : network.springs) {
    for (const int node : {s.a, s.b}) {
      double& least = shortest[static_cast<std::size_t>(node)];
      if (s.rest_length > 0.0) { least = std::min(least, s.rest_length); }
    }
  }
  if (shortest.empty()) { return 0.0; }
  const auto middle = shortest.begin() + static_cast<std::ptrdiff_t>(shortest.size() / 2);
  std::ranges::nth_element(shortest, middle);
  return *middle;
}

}  // namespace

void NeedlePath::add_knot(double depth, const std::vector<Support>& supports) {
  knots_.push_back({depth, supports_.size(), supports.size()});
  supports_.insert(supports_.end(), supports.begin(), supports.end());
}

void NeedlePath::require_free_node(const SpringNetwork& network, const char* where) const {
  if (std::ranges::any_of(supports_, [&](const Support& s) { return !network.is_fixed(s.node); })) {
    return;
  }
  throw std::invalid_argument(std::string("no free node lies ") + where +
                              "; more nodes are needed, or fewer fixed faces");
}

void NeedlePath::network_knots(const SpringNetwork& network) {
  const double reach = node_spacing(network);
  struct Near {
    double depth;
    Support support;
  };
  std::vector<Near> near;
  for (Index i = 0; i < network.node_count(); ++i) {
    const Vector3d from = network.rest_position.col(i) - origin_;
    const double depth = from.dot(direction_);
    const double weight = 1.0 - (from - depth * direction_).norm() / reach;
    if (weight > 1e-12) { near.push_back({depth, {static_cast<int>(i), weight}}); }
  }
  std::ranges::sort(near, {}, [](const Near& n) { return std::pair(n.depth, n.support.node); });
  for (std::size_t begin = 0; begin < near.size();) {
    std::size_t end = begin;
    double weight = 0.0;
    double depth = 0.0;
    std::vector<Support> supports;
    for (; end < near.size() && near[end].depth - near[begin].depth <= 0.5 * reach; ++end) {
      supports.push_back(near[end].support);
      weight += near[end].support.weight;
      depth += near[end].support.weight * near[end].depth;
    }
    for (Support& s : supports) { s.weight /= weight; }
    add_knot(depth / weight, supports);
    begin = end;
  }
}

void NeedlePath::cut_into_pieces() {
  for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
    for (std::size_t n = 0; n < intervals_.size(); ++n) {
      const double begin = std::max(knots_[k].depth, intervals_[n].begin);
      const double end = std::min(knots_[k + 1].depth, intervals_[n].end);
      if (!(end > begin)) { continue; }
      std::vector<Piece>& pieces = intervals_[n].friction_travel > 0.0 ? dragged_ : pieces_;
      pieces.push_back({begin, end, intervals_[n].friction, k, n});
    }
  }
  bone_ = bone_depth(intervals_);
}

void NeedlePath::of_needle(const Scene& scene, const SpringNetwork& network) {
  origin_.head<2>() = scene.needle->entry;
  direction_ = scene.needle->direction.normalized();
  if (const std::optional<NodeGrid> grid = tissue_grid(scene)) {
    const double radius = 0.5 * scene.needle->diameter;
    for (const PlaneCrossing& crossing : plane_crossings(*grid, origin_, direction_, radius)) {
      add_knot(crossing.depth, crossing.supports);
    }
  } else {
    network_knots(network);
  }
  if (knots_.empty()) { throw std::invalid_argument("no node lies near the needle's line"); }
  require_free_node(network, "along the needle");
  intervals_ = intervals_along(scene, origin_, direction_, knots_.front().depth);
  cut_into_pieces();
}

void ProbeFace::press(const Eigen::Vector2d& centre, std::span<double> share) const noexcept {
  std::ranges::fill(share, 0.0);
  double total = 0.0;
  for (const Point& point : points) {
    const Eigen::Vector2d at = (centre + point.place - first).cwiseQuotient(spacing);
    std::array<int, 2> low{};
    std::array<std::array<double, 2>, 2> weight{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double steps = std::clamp(at(static_cast<int>(axis)), 0.0, count[axis] - 1.0);
      low[axis] = std::min(static_cast<int>(steps), count[axis] - 2);
      const double part = steps - low[axis];
      weight[axis] = {1.0 - part, part};
    }
    for (std::size_t n = 0; n < 4; ++n) {
      const auto column = static_cast<std::size_t>((low[1] + static_cast<int>(n / 2)) * count[0] +
                                                   low[0] + static_cast<int>(n % 2));
      if (node[column] < 0) { continue; }
      const double part = point.share * weight[0][n % 2] * weight[1][n / 2];
      share[column] += part;
      total += part;
    }
  }
  for (double& part : share) { part /= total; }
}

namespace {

/// Returns the shares of nodes that form no grid, by hats of the width `spacing` around them.
std::vector<double> shares_of(const std::vector<ProbeFace::Point>& points,
                              const Eigen::Vector2d& centre, const std::vector<int>& nodes,
                              const SpringNetwork& network, double spacing) {
  std::vector<double> share;
  double total = 0.0;
  for (const int node : nodes) {
    const Eigen::Vector2d at = network.rest_position.col(node).head<2>() - centre;
    double sum = 0.0;
    for (const ProbeFace::Point& point : points) {
      sum += point.share * (1.0 - (at - point.place).array().abs() / spacing).cwiseMax(0.0).prod();
    }
    share.push_back(sum);
    total += sum;
  }
  for (double& part : share) { part /= total; }
  return share;
}

/// Returns which columns of nodes a face presses at some time on its path.
std::vector<char> touched_columns(const ProbeFace& face, const Probe& probe) {
  std::vector<char> touched(face.node.size(), 0);
  const std::vector<Eigen::Vector3d>& path = *probe.path;
  constexpr double margin = 1.25;  // a cell, and half the distance of the places below, in spacings
  for (std::size_t n = 0; n < path.size(); ++n) {
    const Eigen::Vector2d from = path[n].tail<2>();
    const Eigen::Vector2d way = path[std::min(n + 1, path.size() - 1)].tail<2>() - from;
    const double steps = std::ceil(2.0 * way.cwiseQuotient(face.spacing).cwiseAbs().sum()) + 1.0;
    for (double k = 0.0; k < steps; k += 1.0) {
      const Eigen::Vector2d at = from + k / steps * way;
      for (std::size_t column = 0; column < touched.size(); ++column) {
        const auto nx = static_cast<std::size_t>(face.count[0]);
        const Eigen::Vector2d place(static_cast<double>(column % nx),
                                    static_cast<double>(column / nx));
        const Eigen::Vector2d away = face.first + face.spacing.cwiseProduct(place) - at;
        const Eigen::Vector2d reach = 0.5 * probe.size + margin * face.spacing;
        if ((away.cwiseAbs() - reach).maxCoeff() < 0.0) { touched[column] = 1; }
      }
    }
  }
  return touched;
}

}  // namespace

void NeedlePath::of_probe(const Scene& scene, const SpringNetwork& network) {
  const Probe& probe = *scene.probe;
  origin_.head<2>() = probe.centre(0.0);
  const std::optional<NodeGrid> grid = tissue_grid(scene);
  const double apart = grid ? 0.0 : node_spacing(network);
  ProbeFace face;
  if (grid) {
    face = {.first = grid->first.head<2>(),
            .spacing = grid->spacing.head<2>(),
            .count = {grid->count[0], grid->count[1]},
            .node = skin_columns(*grid)};
  } else {
    face.spacing.setConstant(apart);
    face.node = face_nodes(network.rest_position, Face::z_min);
  }
  const bool slides = grid && probe.path;
  const std::vector<char> touched = slides ? touched_columns(face, probe) : std::vector<char>();
  pressure_ = FacePressure::Unit(std::ssize(face_terms(probe)), 0);
  const auto press = [&] {
    face.points = face_points(probe, pressure_, face.spacing);
    std::vector<double> share(face.node.size());
    if (grid) {
      face.press(origin_.head<2>(), share);
    } else {
      share = shares_of(face.points, origin_.head<2>(), face.node, network, apart);
    }
    std::vector<Support> supports;
    for (std::size_t n = 0; n < share.size(); ++n) {
      const bool may = slides && touched[n] != 0 && face.node[n] >= 0;
      if (std::abs(share[n]) > 1e-12 || may) {
        supports.push_back({face.node[n], share[n], slides ? static_cast<int>(n) : -1});
      }
    }
    std::ranges::sort(supports, {}, &Support::node);
    double depth = 0.0;
    for (const Support& s : supports) { depth += s.weight * network.rest_position(2, s.node); }
    knots_.clear();
    supports_.clear();
    add_knot(depth, supports);
  };
  press();
  require_free_node(network, "beneath the probe");
  const double depth = knots_.front().depth;
  beneath_ = intervals_along(scene, origin_, direction_, depth);
  if (grid) {
    const double bottom = grid->place(0, 0, grid->count[2] - 1).z();
    const auto layers =
        layers_between(beneath_, depth, std::min(bottom, bone_depth(beneath_)), 1.0);
    if (!layers.empty()) {
      pressure_ = face_compliance(layers, probe).best_pressure();
      press();
    }
  }
  if (slides) { sliding_face_ = std::move(face); }
  intervals_ = {{.begin = knots_.front().depth,
                 .puncture_force = infinity,
                 .cutting_force = infinity,
                 .label = beneath_.front().label,
                 .law = beneath_.front().law}};
}

NeedlePath::NeedlePath(const Scene& scene, const SpringNetwork& network) {
  scene.needle ? of_needle(scene, network) : of_probe(scene, network);
}

NeedlePath::Place NeedlePath::place(double depth) const noexcept {
  std::size_t k = 0;
  while (k + 1 < knots_.size() && knots_[k + 1].depth <= depth) { ++k; }
  if (k + 1 == knots_.size()) { return {k, 0.0}; }
  const double share = (depth - knots_[k].depth) / (knots_[k + 1].depth - knots_[k].depth);
  return {k, std::max(share, 0.0)};
}

std::size_t NeedlePath::interval_at(double depth) const noexcept {
  std::size_t n = 0;
  while (n + 1 < intervals_.size() && intervals_[n].end <= depth) { ++n; }
  return n;
}

double NeedlePath::sum_friction(std::span<const Piece> pieces, std::optional<std::size_t> interval,
                                double depth, std::span<double> of_knot) const noexcept {
  std::ranges::fill(of_knot, 0.0);
  double total = 0.0;
  for (const Piece& piece : pieces) {
    if (piece.begin >= depth) { break; }
    if (interval && piece.interval != *interval) { continue; }
    const double end = std::min(piece.end, depth);
    const double force = piece.friction * (end - piece.begin);
    const Knot& low = knots_[piece.knot];
    const Knot& high = knots_[piece.knot + 1];
    const double share = (0.5 * (piece.begin + end) - low.depth) / (high.depth - low.depth);
    of_knot[piece.knot] += (1.0 - share) * force;
    of_knot[piece.knot + 1] += share * force;
    total += force;
  }
  return total;
}

double NeedlePath::friction(double depth, std::span<double> of_knot) const noexcept {
  return sum_friction(pieces_, {}, depth, of_knot);
}

double NeedlePath::friction(std::size_t interval, double depth,
                            std::span<double> of_knot) const noexcept {
  return sum_friction(dragged_, interval, depth, of_knot);
}

}  // namespace palpate
