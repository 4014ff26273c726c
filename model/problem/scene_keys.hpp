// SPDX-License-Identifier: MIT
#pragma once
/// Every key of a Scene, listed once with its unit, range, words and one sentence. The default of a
/// key is the default of its member.
///
/// The reader of scene files, check_scene() and docs/scenes.md are visitors of these lists. A
/// visitor has the members
///   value(name, member, key)       a key
///   table(name, member)            a table [name] of keys
///   optional_table(name, member)   a table that may be absent, held as std::optional
///   list(name, members)            a list [[name]] of tables
///   exactly_one(a, b), at_most_one(a, b)   keys that exclude each other
/// Lists accept constant objects, so that a scene can be visited without a copy.

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "model/problem/rules.hpp"
#include "model/problem/scene.hpp"

namespace palpate {

/// Allowed values of a number. Values of a key with several numbers obey the range one by one.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool above_low = false;       ///< `low` itself is not allowed
  bool below_high = false;      ///< `high` itself is not allowed
  std::span<const int> only{};  ///< when not empty: the allowed values, and the bounds are unused

  [[nodiscard]] bool holds(double value) const;  ///< `value` must be finite
  [[nodiscard]] std::string text() const;        ///< "must be > 0"; empty for any number
};

inline bool Range::holds(double value) const {
  if (!only.empty()) {
    return std::ranges::any_of(only, [&](int allowed) { return value == allowed; });
  }
  return (above_low ? value > low : !(value < low)) &&
         (below_high ? value < high : !(value > high));
}

inline std::string Range::text() const {
  const bool bottom = std::isfinite(low);
  const bool top = std::isfinite(high);
  if (!only.empty()) {
    std::string list;
    for (std::size_t n = 0; n < only.size(); ++n) {
      list += (n == 0 ? "" : n + 1 == only.size() ? " or " : ", ") + std::to_string(only[n]);
    }
    return "must be " + list;
  }
  if (bottom && top && !above_low && !below_high) {
    return "must be from " + number_in_words(low) + " to " + number_in_words(high);
  }
  const std::string least = (above_low ? "> " : ">= ") + number_in_words(low);
  const std::string most = (below_high ? "< " : "<= ") + number_in_words(high);
  if (!bottom && !top) { return {}; }
  return "must be " + (bottom && top ? least + " and " + most : bottom ? least : most);
}

namespace range {
inline constexpr std::array neighbour_counts{6, 18, 26};
inline constexpr Range any{};
inline constexpr Range positive{.low = 0.0, .above_low = true};
inline constexpr Range non_negative{.low = 0.0};
/// Volumes of cells and their inverses are then numbers well inside the range of a double.
inline constexpr Range spacing{.low = 1e-9, .high = 1e9};
inline constexpr Range share{.low = 0.0, .high = 1.0};
inline constexpr Range percent{.low = 0.0, .high = 100.0};
inline constexpr Range neighbours{.only = neighbour_counts};
constexpr Range at_least(double low) { return {.low = low}; }
constexpr Range at_most(double high) { return {.high = high}; }
constexpr Range from_to(double low, double high) { return {.low = low, .high = high}; }
constexpr Range from_to_below(double low, double high) {
  return {.low = low, .high = high, .below_high = true};
}
}  // namespace range

/// Properties of a key apart from its name and its type.
struct Key {
  std::string_view unit{};
  Range range{};
  std::string_view doc{};
  bool required = false;
  bool endless = false;  ///< the default is infinity and means "no end"; a file cannot give it

  /// Returns the unit for use after a number in a message, e.g. " m"; empty for pure numbers.
  [[nodiscard]] std::string after_number() const {
    return unit.empty() || unit == "1" ? std::string() : " " + std::string(unit);
  }
};

constexpr Key required(Key key) {
  key.required = true;
  return key;
}

template <class E> using WordOf = std::pair<std::string_view, E>;
/// Pairs words with the values 0, 1, 2 ... of E, in the order of their declaration.
template <class E, class... Names> constexpr auto in_order(E /*type*/, Names... names) {
  int value = 0;
  return std::array{WordOf<E>{names, static_cast<E>(value++)}...};
}

// words(E{}) returns the words of a key that takes one of a few, each with its value.
constexpr auto words(Precision e) { return in_order(e, "double", "float"); }
constexpr auto words(Source e) {
  return in_order(e, "lattice", "layers", "network", "oscillator", "mesh", "mri");
}
constexpr auto words(Face e) {
  return in_order(e, "x-min", "x-max", "y-min", "y-max", "z-min", "z-max");
}
constexpr auto words(Stiffening::Law e) { return in_order(e, "exponential", "polynomial"); }
constexpr auto words(LatticeWeights e) { return in_order(e, "cell", "uniform"); }
constexpr auto words(Inclusion::Shape e) { return in_order(e, "sphere", "box"); }
constexpr auto words(Profile e) { return in_order(e, "constant", "ramp", "half-sine"); }
constexpr auto words(RecordedQuantity e) { return in_order(e, "position", "velocity", "force"); }
constexpr auto words(TissueRole e) {
  return in_order(e, "tissue", "epidural-space", "dura", "bone");
}
constexpr auto words(Probe::Shape e) { return in_order(e, "fingertip", "ultrasound"); }
constexpr auto words(Probe::FaceKind e) { return in_order(e, "rigid", "uniform"); }
constexpr auto words(Drive::Kind e) {
  return in_order(e, "trajectory", "force", "falcon", "recorded");
}
constexpr auto words(Drive::Technique e) { return in_order(e, "continuous", "intermittent"); }
constexpr auto words(Syringe::Thumb e) { return in_order(e, "full", "drives", "tests"); }
constexpr auto words(FalconDrive::Hand e) {
  return in_order(e, "light", "medium", "firm", "two-stage");
}
constexpr auto words(FalconDrive::Geometry e) {
  return in_order(e, "libnifalcon", "martin-hillier");
}
constexpr auto words(FalconDrive::Profile e) { return in_order(e, "correct", "stock"); }
constexpr auto words(FalconDrive::Between e) { return in_order(e, "hold", "extrapolate"); }

// Keys whose value in a file is not simply the value of one member. Each refers to the member that
// the key sets; numbers() returns those that the key's range is about.

/// Key with the value "auto", which empties the member, or a number.
template <class T> struct AutoOr {
  T& number;
  [[nodiscard]] std::remove_const_t<T> numbers() const { return number; }
};
/// Key with one of two words, each of which sets the member to a value; the first is the default.
template <class T> struct Preset {
  using Words = std::array<WordOf<std::remove_const_t<T>>, 2>;
  T& member;
  Words words;
};
template <class T> Preset<T> preset(T& member, typename Preset<T>::Words words) {
  return {member, words};
}
/// Key with the value "none", one face or a list of faces.
template <class T> struct FixedFaces { T& faces; };
/// Key with the index of a node.
template <class T> struct NodeOf {
  T& where;
  [[nodiscard]] std::optional<int> numbers() const {
    const int* node = std::get_if<int>(&where);
    return node != nullptr ? std::optional(*node) : std::nullopt;
  }
};
/// Key with a point that replaces the index of a node.
template <class T> struct PointOf {
  T& where;
  [[nodiscard]] std::optional<Eigen::Vector3d> numbers() const {
    const Eigen::Vector3d* point = std::get_if<Eigen::Vector3d>(&where);
    return point != nullptr ? std::optional(*point) : std::nullopt;
  }
};
/// Key with one length for all edges, or one length for each.
template <class T> struct Edges {
  T& size;
  [[nodiscard]] const T& numbers() const { return size; }
};
/// Key with a needle gauge, which sets the diameter.
template <class T> struct GaugeOf { T& diameter; };
/// Key with the shape of a probe, which also sets the default size.
template <class T> struct ProbeShape { T& probe; };
/// Key with a text that becomes part of a column name.
template <class T> struct Label { T& text; };

/// Default footprint of an ultrasound probe [m].
inline const Eigen::Vector2d ultrasound_footprint{0.06, 0.015};

/// Calls `holds(number)` for each number of a member until one call returns false; returns whether
/// all calls returned true. Texts, words and flags have no numbers.
template <class T, class Check> bool all_numbers(const T& member, Check holds) {
  if constexpr (std::same_as<T, double> || std::same_as<T, int>) {
    return holds(member);
  } else if constexpr (requires { member.numbers(); }) {
    return all_numbers(member.numbers(), holds);
  } else if constexpr (requires { member.has_value(); }) {
    return !member || all_numbers(*member, holds);
  } else if constexpr (requires { member.data()[member.size()]; }) {
    using Element = std::remove_cvref_t<decltype(*member.data())>;
    if constexpr (std::same_as<Element, double> || std::same_as<Element, int>) {
      const std::span<const Element> all(member.data(), static_cast<std::size_t>(member.size()));
      for (const Element number : all) {
        if (!holds(number)) { return false; }
      }
    }
  }
  return true;
}

/// Concept of a type T, constant or not.
template <class T, class Plain>
concept Is = std::same_as<std::remove_const_t<T>, Plain>;

template <class Visitor, Is<PrintedForm> T> void fields(Visitor& v, T& p) {
  v.value("sign", p.sign, {.doc = "Eqs. 11-13: a stretched spring pushes its ends apart"});
  v.value("reversed", p.reversed, {.doc = "With `sign`: the whole printed force, reversed"});
  v.value("direction", p.direction,
          {.doc = "Eq. 12: the force is multiplied by d instead of its unit vector"});
  v.value("half_force", p.half_force, {.doc = "Eq. 14: half of the force of each spring"});
  v.value("no_time_step", p.no_time_step, {.doc = "Pseudo-code: updates without the time step"});
  v.value("lagged_velocity", p.lagged_velocity,
          {.doc = "Eq. 9: spring velocity from the previous displacement"});
}

template <class Visitor, Is<SimulationSettings> T> void fields(Visitor& v, T& s) {
  v.value("duration", s.duration, {"s", range::positive, "Simulated time"});
  v.value("step", s.step, {"s", range::positive, "Length of one tick"});
  v.value("substeps", AutoOr{s.substeps}, {"", range::at_least(1), "Integrator steps per tick"});
  v.value("integrator", s.integrator, {.doc = "`palpate run --help` lists the names"});
  v.value("solver_tolerance", s.solver_tolerance,
          {"1", range::from_to_below(0, 1),
           "Implicit integrators: error left in the change of velocity of a step, relative; 0: "
           "rounding error only"});
  v.value("solver_corrections", s.solver_corrections,
          {"", range::from_to(0, 1000),
           "Implicit integrators: corrections after which a step ends while they decrease; 0: when "
           "the tolerance is met"});
  v.value("precision", s.precision,
          {.doc = "Precision of the steps; the reference always uses double"});
  v.value("threads", s.threads,
          {"", range::from_to(1, 64),
           "Maximum number of threads for a regular lattice; each occupies one processor also "
           "while it waits"});
  v.value("sleep_force", s.sleep_force,
          {"N", range::non_negative,
           "Largest sum of the residual forces of all sleeping nodes; 0: no node sleeps"});
  v.value("near_radius", AutoOr{s.near_radius},
          {"m", range::non_negative,
           "Distance from a tool or a load beyond which the tissue becomes a linear reduced-order "
           "model; 0: no reduction; \"auto\": the smallest that `force_error` allows"});
  v.value("far_modes", s.far_modes,
          {"", range::from_to(1, 1000),
           "Modes of the reduced-order model; with `near_radius = \"auto\"` the most"});
  v.value("force_error", s.force_error,
          {"1", range::from_to_below(0, 1),
           "Error wanted of the force, over its peak: `near_radius = \"auto\"` may cause half of "
           "it, and a run warns of a reduced-order model with more"});
  v.value("equations", preset(s.printed, {{{"physical", {}}, {"as-printed", PrintedForm::all()}}}),
          {.doc = "Corrected physics, or the equations of the paper as printed (all errata)"});
  v.table("printed", s.printed);
}

template <class Visitor, Is<Lattice> T> void fields(Visitor& v, T& l) {
  v.value("nodes", l.nodes, {"", range::at_least(2), "Nodes along x, y and z"});
  v.value("spacing", l.spacing, {"m", range::spacing, "Distance between nodes"});
  v.value("connectivity", l.connectivity,
          {"", range::neighbours, "Number of neighbours of a node"});
  v.value("weights", l.weights,
          {.doc = "Springs from a material, or the same stiffness for all springs"});
  v.value("material", l.material, {.doc = "With weights = \"cell\": name of a material"});
  v.value("stiffness", l.stiffness,
          {"N/m", range::positive, "With weights = \"uniform\": stiffness of a spring"});
  v.value("viscosity", l.viscosity,
          {"N s/m", range::non_negative, "With weights = \"uniform\": viscosity of a spring"});
  v.value("node_mass", l.node_mass,
          {"kg", range::positive, "With weights = \"uniform\": mass of a node"});
}

template <class Visitor, Is<LayerBlock> T> void fields(Visitor& v, T& b) {
  v.value("nodes", b.nodes, {"", range::at_least(2), "Nodes along x and y"});
  v.value("spacing", b.spacing, {"m", range::spacing, "Distance between nodes"});
  v.value("connectivity", b.connectivity,
          {"", range::neighbours, "Number of neighbours of a node"});
}

template <class Visitor, Is<Oscillator> T> void fields(Visitor& v, T& o) {
  v.value("mass", o.mass, {"kg", range::positive, "Mass m"});
  v.value("stiffness", o.stiffness, {"N/m", range::non_negative, "Stiffness k"});
  v.value("viscosity", o.viscosity,
          {.unit = "N s/m", .doc = "Viscosity c; a negative value adds energy"});
  v.value("displacement", o.displacement, {.unit = "m", .doc = "Displacement at t = 0"});
  v.value("velocity", o.velocity, {.unit = "m/s", .doc = "Velocity at t = 0"});
  v.value("drive_amplitude", o.drive_amplitude,
          {.unit = "N", .doc = "Amplitude F0 of the force F0 cos(W t)"});
  v.value("drive_frequency", o.drive_frequency,
          {.unit = "rad/s", .doc = "Angular frequency W of the force"});
}

template <class Visitor, Is<Tissue> T> void fields(Visitor& v, T& t) {
  v.value("source", t.source, {.doc = "Table below that defines the tissue"});
  v.value("fixed", FixedFaces{t.fixed}, {.doc = "Faces whose nodes do not move"});
  v.value("hold", preset(t.hold_by_mass, {{{"fixed", false}, {"heavy", true}}}),
          {.doc = "Nodes of fixed faces are fixed exactly, or made very heavy"});
  v.value("heavy_mass_factor", t.heavy_mass_factor,
          {"1", range::positive, "With hold = \"heavy\": factor on the mass of these nodes"});
  v.value("gravity", t.gravity, {.unit = "m/s^2", .doc = "Acceleration of every free node"});
  v.table("lattice", t.lattice);
  v.table("layers", t.block);
  v.table("oscillator", t.oscillator);
}

template <class Visitor, Is<Stiffening> T> void fields(Visitor& v, T& s) {
  v.value(
      "law", s.law,
      required({.doc = "Tension k L0 g(e) of a spring with strain e, the same in compression"}));
  v.value("rate", s.rate,
          {"1", range::non_negative, "Exponential: a of g = (exp(a e) - 1) / a; must be > 0"});
  v.value("quadratic", s.quadratic,
          {"1", range::non_negative, "Polynomial: b of g = e + b e^2 + c e^3"});
  v.value("cubic", s.cubic, {"1", range::non_negative, "Polynomial: c of g"});
  v.value(
      "largest", s.largest,
      {"1", range::from_to(1, 1e6),
       "Stiffness relative to that at rest at which stiffening ends: g is straight from there"});
}

template <class Visitor, Is<RelaxationBranch> T> void fields(Visitor& v, T& b) {
  v.value("share", b.share,
          required({"1",
                    {.low = 0.0, .high = 1.0, .above_low = true, .below_high = true},
                    "Share of the stiffness at once that decays"}));
  v.value("time", b.time, required({"s", range::positive, "Time in which it decays to 1/e"}));
}

template <class Visitor, Is<ModulusChange> T> void fields(Visitor& v, T& c) {
  v.value("time", c.time,
          required({"s", range::non_negative, "Time of the change; the nearest border of a tick"}));
  v.value("youngs_modulus", c.youngs_modulus,
          required({"Pa", range::positive, "Young's modulus from then on; strains stay"}));
}

template <class Visitor, Is<Material> T> void fields(Visitor& v, T& m) {
  v.value("name", m.name,
          required({.doc = "Name; replaces the library material of the same name"}));
  v.value("youngs_modulus", m.youngs_modulus,
          required({"Pa", range::positive, "Young's modulus E"}));
  v.value("poissons_ratio", m.poissons_ratio,
          {"1", range::from_to_below(0.25, 0.5),
           "Poisson's ratio nu; above 0.25 the cells resist changes of their volume"});
  v.value("density", m.density, {"kg/m^3", range::positive, "Density of the tissue"});
  v.value("damping_ratio", m.damping_ratio,
          {"1", range::non_negative, "Damping ratio of each spring with its reduced mass"});
  v.value("viscosity", m.viscosity,
          {"N s/m", range::non_negative, "Viscosity of a spring, instead of damping_ratio"});
  v.value("retardation_time", m.retardation_time,
          {"s", range::non_negative,
           "Viscosity over stiffness of the tissue (Kelvin-Voigt), on every grid"});
  v.at_most_one("damping_ratio", "viscosity");
  v.at_most_one("damping_ratio", "retardation_time");
  v.at_most_one("viscosity", "retardation_time");
  v.optional_table("stiffening", m.stiffening);
  v.list("relaxation", m.relaxation);
  v.list("change", m.changes);
  v.value("puncture_force", m.puncture_force,
          {"N", range::non_negative,
           "Force at which the needle tip begins to cut; left out: cutting_force"});
  v.value("cutting_force", m.cutting_force,
          {"N", range::non_negative, "Force at which the needle tip goes on cutting"});
  v.value("indentation_toe", m.indentation_toe,
          {"m", range::non_negative,
           "Dent over which the tip's contact stiffens to that of a flat punch"});
  v.value("friction", m.friction,
          {"N/m", range::non_negative,
           "Friction force per metre of needle shaft; with friction_travel that at 1 mm/s"});
  v.value("friction_travel", m.friction_travel,
          {"m", range::non_negative,
           "Distance over which the shaft drags the tissue along before it slides"});
  v.value("friction_exponent", m.friction_exponent,
          {"1", {.low = 0.0, .high = 1.0}, "Exponent of the sliding speed in the friction force"});
  v.value("outflow_resistance", m.outflow_resistance,
          {"Pa s/m^3", range::positive,
           "Flow resistance for a needle with its tip here; left out: that of [syringe]"});
  v.value("role", m.role, {.doc = "Kind of tissue for a needle; left out: from the name"});
}

template <class Visitor, Is<Layer> T> void fields(Visitor& v, T& l) {
  v.value("tissue", l.tissue, {.doc = "Label in results; left out: the material's name"});
  v.value("material", l.material, {.doc = "Name of a material; must be given but for a gap"});
  v.value("thickness", l.thickness, required({"m", range::positive, "Thickness of the layer"}));
  v.value("gap", l.gap, {.doc = "A gap without tissue between two layers"});
}

template <class Visitor, Is<Inclusion> T> void fields(Visitor& v, T& i) {
  v.value("shape", i.shape, {.doc = "Shape of the body"});
  v.value("centre", i.centre, required({.unit = "m", .doc = "Centre of the body"}));
  v.value("size", Edges{i.size},
          required({"m", range::positive, "Sphere: diameter; box: edge lengths"}));
  v.value("material", i.material,
          required({.doc = "Material of cells whose centre is inside the body"}));
}

template <class Visitor, Is<Load> T> void fields(Visitor& v, T& l) {
  v.value("nodes", l.nodes, {"", range::non_negative, "Indices of the loaded nodes"});
  v.value("face", l.face, {.doc = "Instead of nodes: all nodes of a face"});
  v.exactly_one("nodes", "face");
  v.value("force", l.force, required({.unit = "N", .doc = "Force on each node"}));
  v.value("start", l.start, {"s", range::non_negative, "Time at which the load begins"});
  v.value("end", l.end,
          {.unit = "s",
           .range = range::positive,
           .doc = "Time at which the load ends",
           .endless = true});
  v.value("profile", l.profile, {.doc = "Course of the force over [start, end)"});
}

template <class Visitor, Is<Record> T> void fields(Visitor& v, T& r) {
  v.value("name", Label{r.name}, required({.doc = "First part of the column names"}));
  v.value("node", NodeOf{r.where}, {"", range::non_negative, "Index of the node"});
  v.value("point", PointOf{r.where}, {.unit = "m", .doc = "Instead of node: the nearest node"});
  v.exactly_one("node", "point");
  v.value("quantities", r.quantities, {.doc = "Recorded quantities"});
}

template <class Visitor, Is<Output> T> void fields(Visitor& v, T& o) {
  v.value("frames", o.frames, {"", range::non_negative, "Number of stored states of all nodes"});
}

template <class Visitor, Is<Needle> T> void fields(Visitor& v, T& n) {
  v.value("gauge", GaugeOf{n.diameter}, {.doc = "Stubs gauge; sets the diameter"});
  v.value("diameter", n.diameter,
          {"m", range::positive, "Outer diameter: the size of the contact at the tip"});
  v.at_most_one("gauge", "diameter");
  v.value("entry", n.entry,
          {.unit = "m", .doc = "Point where the needle line crosses the undeformed skin"});
  v.value("direction", n.direction,
          {.doc = "Direction of insertion, of any length; at most 60 degrees from z"});
  v.value("mass", n.mass,
          {"kg", range::positive, "Mass of needle and syringe, used when a force drives them"});
}

template <class Visitor, Is<PalpationGrid> T> void fields(Visitor& v, T& g) {
  v.value("sites", g.sites, {"", range::at_least(1), "Sites along x and y"});
  v.value("spacing", g.spacing, {"m", range::positive, "Distance between neighbouring sites"});
}

template <class Visitor, Is<Probe> T> void fields(Visitor& v, T& p) {
  v.value("shape", ProbeShape{p}, {.doc = "Shape of the footprint: a disc or a rectangle"});
  v.value("size", Edges{p.size},
          {"m", range::positive, "Fingertip: diameter; ultrasound: edges along x and y"});
  v.value("face", p.face,
          {.doc = "Rigid face, or uniform pressure as under a cushion or soft pulp"});
  v.value("tip_radius", p.tip_radius,
          {"m", range::positive, "Radius of curvature of a rigid fingertip; left out: flat"});
  v.value("entry", p.entry, {.unit = "m", .doc = "Centre of the footprint on the skin"});
  v.value("path", p.path,
          {.unit = "s, m",
           .doc = "Times and centres of a probe that slides along the skin; linear between the "
                  "times, which ascend"});
  v.at_most_one("entry", "path");
  v.value("mass", p.mass,
          {"kg", range::positive, "Mass of the probe, used when a force drives it"});
  v.optional_table("map", p.map);
}

template <class Visitor, Is<Drive> T> void fields(Visitor& v, T& d) {
  v.value("kind", d.kind,
          {.doc = "The position of the tool is prescribed, or the force of the hand, or a haptic "
                  "device holds the tool, or its grip follows a recording"});
  v.value("recording", d.recording,
          {.doc = "Recorded: CSV file with columns time_s, grip.position_m and "
                  "grip.velocity_m_per_s, such as a trace.csv of `palpate live`"});
  v.value("technique", d.technique,
          {.doc = "Continuous advance, or steps with pauses between them"});
  v.value("start", d.start, {"s", range::non_negative, "The tool rests before this time"});
  v.value("from", d.from,
          {"m", range::at_most(0),
           "Position of the tip along its line before the start; 0: on the skin, < 0: outside the "
           "tissue"});
  v.value("pause", d.pause,
          {"s", range::non_negative, "Intermittent: time between two advances or two pushes"});
  v.value(
      "hold", d.hold,
      {"s", range::non_negative, "Time at full depth, or at full force, before the withdrawal"});
  v.value("speed", d.speed, {"m/s", range::positive, "Trajectory: speed of the advance"});
  v.value("advance", d.advance,
          {"m", range::positive, "Trajectory, intermittent: length of one advance"});
  v.value("depth", d.depth,
          {.unit = "m",
           .doc = "Trajectory: position where the advance ends; left out: it does not end"});
  v.value("withdraw_speed", d.withdraw_speed,
          {"m/s", range::non_negative,
           "Trajectory: speed of the withdrawal after `hold`; 0: the tool stays"});
  v.value("grip_stiffness", d.grip_stiffness,
          {"N/m", range::positive,
           "Trajectory: stiffness between hand and tool when bone stops the tool"});
  v.value("force", d.force, {"N", range::positive, "Force: largest force of the hand"});
  v.value("rise", d.rise,
          {"s", range::non_negative,
           "Force: time in which the force rises from zero to its largest value"});
  v.value("push", d.push, {"s", range::positive, "Force, intermittent: duration of one push"});
  v.value("withdraw_force", d.withdraw_force,
          {"N", range::non_negative,
           "Force: force of the withdrawal after `hold`; 0: the push does not end"});
  v.value("hand_viscosity", d.hand_viscosity,
          {"N s/m", range::non_negative,
           "Force: viscosity of the hand, which opposes the velocity of the tool"});
}

template <class Visitor, Is<FalconDrive> T> void fields(Visitor& v, T& f) {
  v.value("hand", f.hand, {.doc = "Preset of mass, viscosity and stiffness of the hand"});
  v.value(
      "hand_stiffness", f.hand_stiffness,
      {"N/m", range::from_to(10, 20000),
       "Stiffness of the hand on the grip, at the damping ratio of the preset; left out: of the "
       "preset"});
  v.value("geometry", f.geometry, {.doc = "Published lengths of the device's legs"});
  v.value("profile", f.profile,
          {.doc = "Driver: exact, or with the defects of the common open-source driver"});
  v.value("rate", f.rate, {"Hz", range::from_to(100, 20000), "Rate of the haptic loop"});
  v.value("delay", f.delay,
          {"", range::from_to(0, 100), "Ticks between a position and the force computed from it"});
  v.value("between", f.between,
          {.doc = "Tool position between two steps when the tissue is slower than the loop"});
  v.value("coupling_stiffness", f.coupling_stiffness,
          {"N/m", range::positive, "Stiffness between grip and tool"});
  v.value("coupling_viscosity", f.coupling_viscosity,
          {"N s/m", range::non_negative, "Viscosity between grip and tool"});
  v.value("start_height", f.start_height,
          {"m", range::from_to(0.08, 0.175),
           "z of the grip in the device frame when the tip is on the skin; the range is the reach "
           "of the device"});
  v.value("tremor", f.tremor,
          {"m", range::non_negative, "Amplitude of the hand tremor, 8 to 12 Hz"});
  v.value("reaction_delay", f.reaction_delay,
          {"s", range::non_negative, "Time from a loss of resistance to the reaction of the hand"});
  v.value("quantised", f.quantised, {.doc = "Use whole encoder counts and motor words"});
  v.value("friction", f.friction, {.doc = "Friction in the joints of the device"});
  v.value("passivity_controller", f.passivity_controller,
          {.doc = "Dissipates energy that the rendering would generate"});
  v.value("supply_power", f.supply_power,
          {"W", range::positive,
           "Power of the supply: the currents of all motors shrink together when they would take "
           "more; default: data sheet"});
  v.value("thermal_time", f.thermal_time,
          {"s", range::non_negative, "Time constant of a motor's heating; 0: no thermal limit"});
  v.value("continuous_power", f.continuous_power,
          {"W", range::positive,
           "Power that one motor can take for ever, if thermal_time is not 0; assumed"});
  v.value("seed", f.seed, {"", range::non_negative, "Seed of all random numbers of the device"});
}

template <class Visitor, Is<Syringe> T> void fields(Visitor& v, T& s) {
  v.value("preset", preset(s, {{{"saline", {}}, {"air", air_syringe()}}}),
          {.doc = "Fluid; sets the defaults of the keys below"});
  v.value(
      "thumb", s.thumb,
      {.doc = "Technique: always full force; push the needle by the plunger; test at rest only"});
  v.value("hand_share", s.hand_share,
          {"1", range::from_to_below(0.0, 1.0),
           "Share of the other hand in the force on a needle that the thumb drives"});
  v.value("plunger_friction", s.plunger_friction,
          {"N", range::non_negative, "Friction of the plunger"});
  v.value("plunger_area", s.plunger_area,
          {"m^2", range::positive, "Area of the plunger; default: bore of 15 mm"});
  v.value("compliance", s.compliance,
          {"m^3/Pa", range::positive, "Compliance of the wall and any air"});
  v.value("thumb_force", s.thumb_force, {"N", range::non_negative, "Largest force of the thumb"});
  v.value("thumb_flow", s.thumb_flow,
          {"m^3/s", range::non_negative, "Largest flow that the thumb can maintain"});
  v.value("tissue_resistance", s.tissue_resistance,
          {"Pa s/m^3", range::positive, "Flow resistance of solid tissue"});
  v.value("epidural_resistance", s.epidural_resistance,
          {"Pa s/m^3", range::positive, "Flow resistance of the epidural space"});
  v.value("open_resistance", s.open_resistance,
          {"Pa s/m^3", range::positive, "Flow resistance of the needle with its tip in air"});
}

/// The keys of a scene; `tissue` is the scene's own tissue or an object that adds keys to it.
template <class Visitor, Is<Scene> T, class TissueKeys>
void scene_fields(Visitor& v, T& s, TissueKeys& tissue) {
  v.value("title", s.title, {.doc = "Any text"});
  v.table("simulation", s.simulation);
  v.table("tissue", tissue);
  v.list("material", s.materials);
  v.list("layer", s.tissue.layers);
  v.list("inclusion", s.tissue.inclusions);
  v.list("load", s.loads);
  v.list("record", s.records);
  v.table("output", s.output);
  v.optional_table("needle", s.needle);
  v.optional_table("probe", s.probe);
  v.optional_table("drive", s.drive);
  v.optional_table("falcon", s.falcon);
  v.optional_table("syringe", s.syringe);
}

template <class Visitor, Is<Scene> T> void fields(Visitor& v, T& s) {
  scene_fields(v, s, s.tissue);
}

}  // namespace palpate
