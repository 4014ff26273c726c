// SPDX-License-Identifier: MIT
/// Coupling of a tool's line to the nodes of a network (model/EQUATIONS.md, "Needle line").

#include "reference/needle_track.hpp"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_sf_legendre.h>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "reference/solution.hpp"
#include "reference/static_equilibrium.hpp"

namespace palpate::reference {

namespace {

std::vector<TrackKnot> needle_knots(const Scene& scene, const SpringNetwork& network);
TrackKnot probe_knot(const Scene& scene, const SpringNetwork& network);
std::vector<TrackInterval> track_intervals(const Scene& scene, double entry);
std::vector<TrackInterval> base_intervals(const Scene& scene, double entry, double n_z);
void add_give(const Scene& scene, const SpringNetwork& network, NeedleTrack& track);

}  // namespace

std::size_t NeedleTrack::segment_at(double depth) const {
  const auto above = std::ranges::upper_bound(knots, depth, {}, &TrackKnot::depth);
  return above == knots.begin() ? 0 : static_cast<std::size_t>(above - knots.begin()) - 1;
}

std::size_t NeedleTrack::interval_at(double depth) const {
  const auto above = std::ranges::upper_bound(intervals, depth, {}, &TrackInterval::begin);
  return above == intervals.begin() ? 0 : static_cast<std::size_t>(above - intervals.begin()) - 1;
}

std::size_t NeedleTrack::stretch_at(double depth) const {
  const auto above = std::ranges::upper_bound(give, depth, {}, &TrackGive::depth);
  return above == give.begin() ? 0 : static_cast<std::size_t>(above - give.begin()) - 1;
}

std::array<double, 2> NeedleTrack::give_at(std::size_t interval, std::size_t stretch,
                                           double depth) const {
  if (give.empty()) { return {0.0, 0.0}; }
  const TrackDent* large = dent_in(interval);
  const auto at = [&](std::size_t n) {
    return large == nullptr ? give[n].compliance : large->compliance[n];
  };
  const double here = at(stretch);
  if (stretch + 1 == give.size()) { return {here, 0.0}; }
  const double from = give[stretch].depth;
  const double slope = (at(stretch + 1) - here) / (give[stretch + 1].depth - from);
  return {here + slope * (depth - from), slope};
}

namespace {

/// Contact of a sharp tip (model/EQUATIONS.md, "Contact of a size") in tissue of compliance
/// `continuum` [m/N], with the dent D of the continuum [m].
struct Toe {
  double end = 0.0;  ///< D_1 [m]
  double continuum = 0.0;
  static constexpr double rest = 0.02;  ///< r

  /// Returns T and dT/dD.
  [[nodiscard]] std::array<double, 2> force(double dent) const {
    const double bent = std::clamp(dent, 0.0, end);
    const double slope = (rest + (1.0 - rest) * bent / end) / continuum;
    const double mean = (rest + 0.5 * (1.0 - rest) * bent / end) / continuum;
    return {mean * bent + slope * (dent - bent), slope};
  }
  /// Returns D under a force, by Newton's method from above, where T(D) is convex.
  [[nodiscard]] double dent(double value) const {
    double at = std::max(value * continuum + end, 0.0);
    for (int n = 0; n < 60; ++n) {
      const auto [now, slope] = force(at);
      const double change = (now - value) / slope;
      at -= change;
      if (std::abs(change) <= 1e-15 * std::max(end, std::abs(at))) { break; }
    }
    return at;
  }
  /// Returns D where D - soft T(D) is the gap; soft < c_c.
  [[nodiscard]] double dent_under_gap(double gap, double soft) const {
    double at = std::max(gap / (1.0 - soft / continuum), 0.0);
    for (int n = 0; n < 60; ++n) {
      const auto [now, slope] = force(at);
      const double change = (at - soft * now - gap) / (1.0 - soft * slope);
      at -= change;
      if (std::abs(change) <= 1e-15 * std::max(end, std::abs(at))) { break; }
    }
    return at;
  }
  /// Returns the integral of T over D [J].
  [[nodiscard]] double work(double dent) const {
    const double bent = std::min(dent, end);
    const double in_toe =
        (0.5 * rest * bent * bent + (1.0 - rest) * bent * bent * bent / (6.0 * end)) / continuum;
    return in_toe + 0.5 * (force(bent)[0] + force(dent)[0]) * (dent - bent);
  }
};

}  // namespace

std::array<double, 2> NeedleTrack::continuum_at(std::size_t stretch, double depth) const {
  const TrackGive& here = give[stretch];
  if (stretch + 1 == give.size()) { return {here.continuum, 0.0}; }
  const TrackGive& next = give[stretch + 1];
  const double slope = (next.continuum - here.continuum) / (next.depth - here.depth);
  return {here.continuum + slope * (depth - here.depth), slope};
}

std::array<double, 2> NeedleTrack::gap_at(std::size_t interval, std::size_t stretch, double depth,
                                          double force) const {
  const auto [soft, slope] = give_at(interval, stretch, depth);
  if (give.empty() || intervals[interval].toe == 0.0) {
    const TrackDent* large = dent_in(interval);
    const double phi = large == nullptr ? force : large->phi_of(force);
    return {soft * phi, slope * phi};
  }
  const auto [continuum, softens] = continuum_at(stretch, depth);
  const Toe toe{intervals[interval].toe, continuum};
  const double whole = toe.dent(force);
  // c_c T is a function of D alone.
  const double deepens = force * softens / (continuum * toe.force(whole)[1]);
  return {whole - (continuum - soft) * force, deepens - (softens - slope) * force};
}

double NeedleTrack::force_at(std::size_t interval, std::size_t stretch, double depth,
                             double gap) const {
  const double soft = give_at(interval, stretch, depth)[0];
  if (intervals[interval].toe == 0.0) {
    const TrackDent* large = dent_in(interval);
    return large == nullptr ? gap / soft : large->force_of(gap / soft);
  }
  const Toe toe{intervals[interval].toe, continuum_at(stretch, depth)[0]};
  return toe.force(toe.dent_under_gap(gap, toe.continuum - soft))[0];
}

double NeedleTrack::energy_at(std::size_t interval, std::size_t stretch, double depth,
                              double force) const {
  const double soft = give_at(interval, stretch, depth)[0];
  if (give.empty() || intervals[interval].toe == 0.0) {
    const TrackDent* large = dent_in(interval);
    return soft * (large == nullptr ? 0.5 * force * force : large->work(force));
  }
  const Toe toe{intervals[interval].toe, continuum_at(stretch, depth)[0]};
  return toe.work(toe.dent(force)) - 0.5 * (toe.continuum - soft) * force * force;
}

namespace {

/// Returns y at x between points with ascending x: linear, also beyond the first and the last.
double on_polygon(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, at);
  const auto n = static_cast<std::size_t>(above - x.begin());
  return std::lerp(y[n - 1], y[n], (at - x[n - 1]) / (x[n] - x[n - 1]));
}

}  // namespace

double TrackDent::phi_of(double at) const { return on_polygon(force, phi, at); }

double TrackDent::force_of(double x) const { return on_polygon(phi, force, x); }

double TrackDent::work(double at) const {
  double sum = 0.0;
  double from = 0.0;
  for (std::size_t n = 1; from < at; ++n) {
    const double to = n + 1 < force.size() ? std::min(force[n], at) : at;
    sum += 0.5 * (from + to) * (phi_of(to) - phi_of(from));
    from = to;
  }
  return sum;
}

std::array<double, 2> NeedleTrack::hats(std::size_t segment, double depth) const {
  if (segment + 1 == knots.size()) { return {1.0, 0.0}; }
  const double begin = knots[segment].depth;
  const double share = (depth - begin) / (knots[segment + 1].depth - begin);
  return {1.0 - share, share};
}

Eigen::VectorXd NeedleTrack::friction_shares(std::size_t segment, std::size_t interval,
                                             double depth) const {
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots.size()));
  for (std::size_t k = 0; k <= segment; ++k) {
    for (std::size_t n = 0; n <= interval; ++n) {
      const TrackInterval& part = intervals[n];
      if (part.travel > 0.0) { continue; }
      const double from = std::max(knots[k].depth, part.begin);
      // At the tip its depth ends the integral, even if rounding places it outside the segment.
      const bool at_tip = k == segment && n == interval;
      const double lower = k == segment ? part.end : std::min(knots[k + 1].depth, part.end);
      if (at_tip || lower > from) { add_friction(k, n, from, at_tip ? depth : lower, shares); }
    }
  }
  return shares;
}

Eigen::VectorXd NeedleTrack::creeping_shares(std::size_t interval, double depth) const {
  const TrackInterval& part = intervals[interval];
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots.size()));
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double from = std::max(knots[k].depth, part.begin);
    const double to = std::min({knots[k + 1].depth, part.end, depth});
    if (to > from) { add_friction(k, interval, from, to, shares); }
  }
  return shares;
}

void NeedleTrack::add_friction(std::size_t k, std::size_t interval, double from, double to,
                               Eigen::VectorXd& shares) const {
  const double friction = intervals[interval].friction;
  const auto middle = hats(k, 0.5 * (from + to));  // the midpoint rule is exact
  const auto i = static_cast<Eigen::Index>(k);
  shares(i) += friction * (middle[0] * (to - from));
  if (k + 1 < knots.size()) { shares(i + 1) += friction * (middle[1] * (to - from)); }
}

NeedleTrack needle_track(const Scene& scene, const SpringNetwork& network) {
  NeedleTrack track;
  if (scene.probe) {
    track.knots = {probe_knot(scene, network)};
    add_give(scene, network, track);
    track.intervals = {{.begin = track.entry(),
                        .puncture_force = std::numeric_limits<double>::infinity(),
                        .cutting_force = std::numeric_limits<double>::infinity(),
                        .branches = base_intervals(scene, track.entry(), 1.0).front().branches,
                        .label = "skin"}};
    return track;
  }
  if (!scene.needle) { throw SolverError("insertion: the scene has neither needle nor probe"); }
  track.direction = scene.needle->direction.normalized();
  track.knots = needle_knots(scene, network);
  if (track.knots.empty()) { throw SolverError("insertion: no node lies on the needle's line"); }
  track.intervals = track_intervals(scene, track.entry());
  for (const TrackInterval& part : track.intervals) {
    if (part.role == TissueRole::bone) { track.bone = std::min(track.bone, part.begin); }
  }
  add_give(scene, network, track);
  return track;
}

namespace {

using Eigen::Vector3d;

constexpr double rounding = 1e-9;  ///< tolerance of a position, in units of the spacing

/// Returns the dents of the network alone at rest [m] under forces [N] of 0, step, 2 step and so on
/// at a depth.
std::vector<double> own_dents(const Scene& scene, const SpringNetwork& network,
                              const NeedleTrack& track, double depth, double step,
                              std::size_t count) {
  const std::size_t segment = track.segment_at(depth);
  const std::array<double, 2> hats = track.hats(segment, depth);
  std::vector<TrackSupport> pressed;
  for (std::size_t n = 0; n < 2 && hats[n] != 0.0; ++n) {
    for (const TrackSupport& support : track.knots[segment + n].supports) {
      pressed.push_back({support.node, hats[n] * support.weight});
    }
  }
  std::vector<double> dents;
  double begin = 0.0;
  Eigen::VectorXd position;
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<Load> loads;
    for (const TrackSupport& at : pressed) {
      const double force = static_cast<double>(k) * step * at.weight;
      loads.push_back({.nodes = {at.node}, .force = force * track.direction});
    }
    const NetworkProblem problem(network, std::move(loads), scene.tissue.gravity);
    if (k == 0) { position = problem.initial_position(); }
    position = static_equilibrium(problem, {}, position).position;
    double place = 0.0;
    for (const TrackSupport& at : pressed) {
      const Eigen::Index first = problem.coordinate(at.node);
      if (first >= 0) { place += at.weight * track.direction.dot(position.segment<3>(first)); }
    }
    if (k == 0) { begin = place; }
    dents.push_back(place - begin);
  }
  return dents;
}

void add_give(const Scene& scene, const SpringNetwork& network, NeedleTrack& track) {
  const NeedlePath path(scene, network);
  TipCompliance tip = path.tip_compliance(scene, network);
  for (std::size_t n = 0; n < tip.value.size(); ++n) {
    track.give.push_back({tip.depth[n], tip.value[n]});
    if (!tip.of_continuum.empty()) { track.give.back().continuum = tip.of_continuum[n]; }
  }
  for (DentTable& table : tip.tables) {
    if (table.dent.empty()) { continue; }
    if (!table.is_complete()) {
      const std::size_t count = table.dent.size();
      const auto dents = [&](double depth, double step) {
        return own_dents(scene, network, track, depth, step, count);
      };
      const PathInterval& layer = path.intervals()[table.interval];
      const double at_end = dents(layer.end, layer.cutting_force / double(count - 1)).back();
      table.complete(layer, tip.depth, tip.value, dents(layer.begin, table.step), at_end);
    }
    TrackDent& dent = track.dents[table.interval];
    dent = {.phi = table.linear_force, .compliance = table.compliance};
    for (const double multiple : table.multiple) { dent.force.push_back(multiple * table.step); }
  }
}

struct Grid {
  int nx = 0;
  int ny = 0;
  int nz = 0;
  double spacing = 0.0;  ///< [m]
};

std::optional<Grid> grid_of(const Scene& scene, const SpringNetwork& network) {
  const Tissue& tissue = scene.tissue;
  if (tissue.source == Source::lattice) {
    const auto& n = tissue.lattice.nodes;
    return Grid{n[0], n[1], n[2], tissue.lattice.spacing};
  }
  if (tissue.source != Source::layers) { return std::nullopt; }
  const auto& n = tissue.block.nodes;
  return Grid{n[0], n[1], static_cast<int>(network.node_count()) / (n[0] * n[1]),
              tissue.block.spacing};
}

/// Returns the cell and the fraction of a position along one axis with `count` nodes from `first`
/// on.
std::optional<std::pair<int, double>> cell_of(double place, double first, double spacing,
                                              int count) {
  const double steps = (place - first) / spacing;
  if (steps < -rounding || steps > count - 1 + rounding) { return std::nullopt; }
  const int cell = std::clamp(static_cast<int>(std::floor(steps)), 0, count - 2);
  return std::pair{cell, std::clamp(steps - cell, 0.0, 1.0)};
}

/// Returns points of equal force of a rigid flat punch, 16 on each of 8 circles with equal parts of
/// the force between them: within r it is F (1 - sqrt(1 - r^2 / radius^2)).
std::vector<Eigen::Vector2d> points_of_force(double radius) {
  std::vector<Eigen::Vector2d> points;
  for (double part = 1.0 / 16.0; part < 1.0; part += 1.0 / 8.0) {
    const double r = radius * std::sqrt(1.0 - (1.0 - part) * (1.0 - part));
    for (int n = 1; n < 32; n += 2) {
      points.emplace_back(r * std::cos(n * std::numbers::pi / 16.0),
                          r * std::sin(n * std::numbers::pi / 16.0));
    }
  }
  return points;
}

std::vector<TrackKnot> lattice_knots(const Needle& needle, const Grid& grid,
                                     const SpringNetwork& network) {
  const Vector3d n = needle.direction.normalized();
  const std::vector<Eigen::Vector2d> points = points_of_force(0.5 * needle.diameter);
  const std::vector<Eigen::Vector2d> on_axis{Eigen::Vector2d::Zero()};
  std::vector<TrackKnot> knots;
  for (int l = 0; l < grid.nz; ++l) {
    const int corner = l * grid.nx * grid.ny;
    const Vector3d first = network.rest_position.col(corner);
    TrackKnot knot{.depth = first.z() / n.z()};
    const Eigen::Vector2d axis = needle.entry + knot.depth * n.head<2>();
    std::map<int, double> share;
    const auto outside = [&](const Eigen::Vector2d& point) {
      return !cell_of(axis.x() + point.x(), first.x(), grid.spacing, grid.nx) ||
             !cell_of(axis.y() + point.y(), first.y(), grid.spacing, grid.ny);
    };
    // A disc that the sides of the block cut off acts on the axis alone.
    const bool cut_off = std::ranges::any_of(points, outside);
    for (const Eigen::Vector2d& point : cut_off ? on_axis : points) {
      const auto x = cell_of(axis.x() + point.x(), first.x(), grid.spacing, grid.nx);
      const auto y = cell_of(axis.y() + point.y(), first.y(), grid.spacing, grid.ny);
      if (!x || !y) { continue; }
      const int node = corner + y->first * grid.nx + x->first;
      share[node] += (1.0 - x->second) * (1.0 - y->second);
      share[node + 1] += x->second * (1.0 - y->second);
      share[node + grid.nx] += (1.0 - x->second) * y->second;
      share[node + grid.nx + 1] += x->second * y->second;
    }
    double sum = 0.0;
    for (const auto& [node, weight] : share) { sum += weight; }
    for (const auto& [node, weight] : share) {
      if (weight > rounding * sum) { knot.supports.push_back({node, weight / sum}); }
    }
    if (!knot.supports.empty()) { knots.push_back(std::move(knot)); }
  }
  return knots;
}

double median_length(const SpringNetwork& network) {
  std::vector<double> lengths;
  for (const Spring& spring : network.springs) { lengths.push_back(spring.rest_length); }
  if (lengths.empty()) { throw SolverError("insertion: a network without springs has no scale"); }
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::ranges::nth_element(lengths, middle);
  return *middle;
}

/// Returns a contact point with weights that sum to 1 and the weighted mean depth.
TrackKnot knot_of(const std::vector<TrackSupport>& supports, const SpringNetwork& network,
                  const Vector3d& entry, const Vector3d& n) {
  TrackKnot knot{.supports = supports};
  const double sum = std::transform_reduce(supports.begin(), supports.end(), 0.0, std::plus<>(),
                                           [](const TrackSupport& s) { return s.weight; });
  for (TrackSupport& support : knot.supports) {
    support.weight /= sum;
    knot.depth += support.weight * n.dot(network.rest_position.col(support.node) - entry);
  }
  return knot;
}

std::vector<TrackKnot> network_knots(const Needle& needle, const SpringNetwork& network) {
  const Vector3d n = needle.direction.normalized();
  const Vector3d entry{needle.entry.x(), needle.entry.y(), 0.0};
  const double radius = median_length(network);
  std::vector<TrackSupport> near;
  double first = std::numeric_limits<double>::infinity();
  for (int i = 0; i < static_cast<int>(network.node_count()); ++i) {
    const Vector3d from = network.rest_position.col(i) - entry;
    const double away = (from - n.dot(from) * n).norm();
    if (away >= (1.0 - rounding) * radius) { continue; }
    near.push_back({i, 1.0 - away / radius});
    first = std::min(first, n.dot(from));
  }
  std::map<long, std::vector<TrackSupport>> slabs;
  for (const TrackSupport& support : near) {
    const double depth = n.dot(network.rest_position.col(support.node) - entry);
    slabs[std::lround(std::floor((depth - first) / (0.5 * radius) + rounding))].push_back(support);
  }
  std::vector<TrackKnot> knots;
  for (const auto& [number, supports] : slabs) {
    knots.push_back(knot_of(supports, network, entry, n));
  }
  return knots;
}

/// Calls add(place, force) for small parts of the unit force of a probe's face, relative to its
/// centre [m]. Under a flat punch the force is proportional to sin(s) ds dt on a disc with the
/// radius a sin(s), and to ds dt on a rectangle with x = b cos(s) and y = l cos(t). The other terms
/// of the pressure are P_2n(cos(s)) and cos(2 m s) cos(2 n t) times that, and a uniform pressure is
/// cos(s) and sin(s) sin(t) times that.
template <class Add>
void for_each_part(const Probe& probe, const Eigen::VectorXd& pressure, Add add) {
  constexpr double pi = std::numbers::pi;
  constexpr int many = 240;
  const Eigen::Vector2d half = 0.5 * probe.size;
  const bool disc = probe.shape == Probe::Shape::fingertip;
  const bool uniform = probe.face == Probe::FaceKind::uniform;
  for (int i = 0; i < many; ++i) {
    for (int j = 0; j < many; ++j) {
      const double s = pi * (i + 0.5) / many;
      const double t = pi * (j + 0.5) / many;
      if (disc) {
        const double r = half.x() * std::sin(0.5 * s);
        const double cosine = std::cos(0.5 * s);
        double sum = uniform ? cosine : 0.0;
        for (int n = 0; n < pressure.size() && !uniform; ++n) {
          sum += pressure(n) * gsl_sf_legendre_Pl(2 * n, cosine);
        }
        add(Eigen::Vector2d(r * std::cos(2.0 * t), r * std::sin(2.0 * t)), std::sin(0.5 * s) * sum);
      } else {
        double sum = uniform ? std::sin(s) * std::sin(t) : 0.0;
        int term = 0;
        for (int m = 0; term < pressure.size() && !uniform; ++m) {
          for (int n = 0; m + n < 5; ++n) {
            sum += pressure(term++) * std::cos(2.0 * m * s) * std::cos(2.0 * n * t);
          }
        }
        add(Eigen::Vector2d(half.x() * std::cos(s), half.y() * std::cos(t)), sum);
      }
    }
  }
}

/// Returns the contact points of a needle. A lattice has one at each intersection of the line with
/// a plane of nodes across z, with bilinear weights of a disc of the needle's diameter. Any other
/// network has one for each slab of R/2, from the first node on, that contains nodes nearer than R
/// to the line; R is the median spring length and weights are proportional to 1 - r/R. Throws
/// SolverError for a network without springs.
std::vector<TrackKnot> needle_knots(const Scene& scene, const SpringNetwork& network) {
  if (const auto grid = grid_of(scene, network)) {
    return lattice_knots(*scene.needle, *grid, network);
  }
  return network_knots(*scene.needle, network);
}

/// Returns the contact point of a probe. A node of the skin has the mean over the pressure of the
/// bilinear function around it, of the width of a spacing; in a network without a grid that is the
/// median length of a spring. Throws SolverError if there is no node.
TrackKnot probe_knot(const Scene& scene, const SpringNetwork& network) {
  const Probe& probe = *scene.probe;
  const auto grid = grid_of(scene, network);
  const double width = grid ? grid->spacing : median_length(network);
  std::vector<TrackSupport> supports;
  for (const int node : face_nodes(network.rest_position, Face::z_min)) {
    const Eigen::Vector2d at = network.rest_position.col(node).head<2>() - probe.entry;
    const bool far = ((at.cwiseAbs() - 0.5 * probe.size).array() >= width).any();
    if (!far) { supports.push_back({node, 0.0}); }
  }
  for_each_part(probe, NeedlePath(scene, network).face_pressure(),
                [&](const Eigen::Vector2d& place, double force) {
                  for (TrackSupport& support : supports) {
                    const Eigen::Vector2d at =
                        network.rest_position.col(support.node).head<2>() - probe.entry - place;
                    support.weight += force * std::max(0.0, 1.0 - std::abs(at.x()) / width) *
                                      std::max(0.0, 1.0 - std::abs(at.y()) / width);
                  }
                });
  std::erase_if(supports, [](const TrackSupport& s) { return s.weight == 0.0; });
  if (supports.empty()) { throw SolverError("insertion: no node lies beneath the probe"); }
  return knot_of(supports, network, Vector3d::Zero(), Vector3d::UnitZ());
}

constexpr double infinity = std::numeric_limits<double>::infinity();

TrackInterval made_of(const Scene& scene, const std::string& material, const std::string& label) {
  const auto found = std::ranges::find(scene.materials, material, &Material::name);
  if (found == scene.materials.end()) { throw SolverError("insertion: no material " + material); }
  const TissueRole role = role_of(*found);
  const bool bone = role == TissueRole::bone;
  return {.puncture_force = bone ? infinity : found->puncture_force.value_or(found->cutting_force),
          .cutting_force = bone ? infinity : found->cutting_force,
          .toe = found->indentation_toe,
          .friction = found->friction,
          .travel = found->friction_travel,
          .exponent = found->friction_exponent,
          .branches = found->relaxation,
          .role = role,
          .label = label.empty() ? material : label};
}

std::vector<TrackInterval> base_intervals(const Scene& scene, double entry, double n_z) {
  const Tissue& tissue = scene.tissue;
  std::vector<TrackInterval> parts;
  double begin = entry;
  const bool only_material =
      tissue.source == Source::lattice && tissue.lattice.weights == LatticeWeights::cell;
  if (!only_material) {
    for (const Layer& layer : tissue.layers) {
      parts.push_back(layer.gap ? TrackInterval{.label = layer.tissue}
                                : made_of(scene, layer.material, layer.tissue));
      parts.back().begin = begin;
      begin += layer.thickness / n_z;
      parts.back().end = begin;
    }
  }
  if (parts.empty()) {
    parts.push_back(only_material ? made_of(scene, tissue.lattice.material, "") : TrackInterval{});
    parts.back().begin = entry;
  }
  parts.back().end = infinity;
  return parts;
}

struct Stretch {
  double begin = -infinity;
  double end = infinity;
};

/// Returns the part of the line point + xi n inside the body, if any.
std::optional<Stretch> inside(const Inclusion& body, const Eigen::Vector3d& point,
                              const Eigen::Vector3d& n) {
  const Eigen::Vector3d from = point - body.centre;
  if (body.shape == Inclusion::Shape::sphere) {
    const double middle = -from.dot(n);
    const double radius = 0.5 * body.size.x();
    const double half = radius * radius - (from + middle * n).squaredNorm();
    if (half <= 0.0) { return std::nullopt; }
    return Stretch{middle - std::sqrt(half), middle + std::sqrt(half)};
  }
  Stretch stretch;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = 0.5 * body.size(axis);
    if (n(axis) == 0.0) {
      if (std::abs(from(axis)) > half) { return std::nullopt; }
      continue;
    }
    const double one = (-half - from(axis)) / n(axis);
    const double other = (half - from(axis)) / n(axis);
    stretch.begin = std::max(stretch.begin, std::min(one, other));
    stretch.end = std::min(stretch.end, std::max(one, other));
  }
  if (stretch.end <= stretch.begin) { return std::nullopt; }
  return stretch;
}

/// Returns the intervals with those inside `body` replaced.
std::vector<TrackInterval> overlaid(const std::vector<TrackInterval>& parts,
                                    const TrackInterval& body) {
  std::vector<TrackInterval> result;
  for (const TrackInterval& part : parts) {
    TrackInterval before = part;
    before.end = std::min(part.end, body.begin);
    TrackInterval after = part;
    after.begin = std::max(part.begin, body.end);
    if (before.begin < before.end) { result.push_back(before); }
    if (body.begin >= part.begin && body.begin < part.end) { result.push_back(body); }
    if (after.begin < after.end) { result.push_back(after); }
  }
  return result;
}

/// Returns the intervals from `entry` = xi_0 [m]: layers by thickness / n_z (the last is
/// unbounded), else the lattice's material, else no resistance. Inclusions override them; the last
/// one that contains a point applies. Throws SolverError for an unknown material.
std::vector<TrackInterval> track_intervals(const Scene& scene, double entry) {
  const Needle& needle = scene.needle.value();
  const Eigen::Vector3d n = needle.direction.normalized();
  const Eigen::Vector3d point{needle.entry.x(), needle.entry.y(), 0.0};
  std::vector<TrackInterval> parts = base_intervals(scene, entry, n.z());
  for (const Inclusion& inclusion : scene.tissue.inclusions) {
    const auto stretch = inside(inclusion, point, n);
    if (!stretch || stretch->end <= entry) { continue; }
    TrackInterval body = made_of(scene, inclusion.material, "");
    body.begin = std::max(stretch->begin, entry);
    body.end = stretch->end;
    parts = overlaid(parts, body);
  }
  return parts;
}

}  // namespace

}  // namespace palpate::reference
