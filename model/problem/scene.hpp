// SPDX-License-Identifier: MIT
#pragma once
/// Scene: plain data with documented defaults, SI units throughout.
/// Frame: right-handed, metres, +z points into the tissue, the undeformed skin is z = 0.
/// fixtures/io/scene_file.hpp reads it from a file, model/tissue/scene_check.hpp has its rules, and
/// problem.hpp has what it becomes.

#include <Eigen/Core>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

/// Tool that a hand holds through a haptic device: `[falcon]` of a scene file.
struct FalconDrive {
  /// How the hand on the grip resists: presets of mass, viscosity and stiffness.
  enum class Hand { light, medium, firm, two_stage } hand = Hand::medium;
  /// Published lengths of the device's legs.
  enum class Geometry { libnifalcon, martin_hillier } geometry = Geometry::libnifalcon;
  /// The driver between loop and wire: exact, or with the defects of the common open one.
  enum class Profile { correct, stock } profile = Profile::correct;
  /// What the loop takes for the tool's place between two steps of slower tissue.
  enum class Between { hold, extrapolate } between = Between::hold;

  double rate = 1000.0;                ///< of the haptic loop [Hz]
  int delay = 0;                       ///< whole ticks from a position to the force it leads to
  double coupling_stiffness = 2000.0;  ///< between grip and tool [N/m]
  double coupling_viscosity = 20.0;    ///< [N s/m]
  double start_height =
      0.16;             ///< of the grip along the device's z where the tip is on the skin [m]
  double tremor = 0.0;  ///< amplitude of the hand's tremor [m]
  double reaction_delay = 0.175;      ///< from a loss of resistance to the hand's answer [s]
  bool quantised = true;              ///< whole encoder counts and motor words
  bool friction = true;               ///< in the device's joints
  bool passivity_controller = false;  ///< damps what the rendering would feed in
  int seed = 1;                       ///< of everything random
};

/// Rigid needle with a sharp tip on the line entry + s direction; s = 0 on the undeformed skin.
struct Needle {
  double diameter = 1.651e-3;                ///< [m] outer; 16 gauge. Reported, not mechanical
  Eigen::Vector2d entry{0.0, 0.0};           ///< x and y where the line meets z = 0 [m]
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< of insertion; made a unit vector
  double mass = 0.02;                        ///< [kg] of needle and syringe; drive by force
};

/// Outer diameter [m] of a Stubs needle gauge (ISO 9626), or nothing for one that is not made.
std::optional<double> diameter_of_gauge(int gauge);

/// A grid of places on the skin that a probe feels in turn, its middle at the probe's entry.
struct PalpationGrid {
  std::array<int, 2> sites{9, 9};  ///< along x and y
  double spacing = 0.004;          ///< [m]

  [[nodiscard]] Eigen::Vector2d half_span() const {
    return 0.5 * spacing * Eigen::Vector2d(sites[0] - 1, sites[1] - 1);
  }
};

/// Blunt tool that presses on the skin: the force is spread over its footprint, nothing is cut.
struct Probe {
  enum class Shape { fingertip, ultrasound } shape = Shape::fingertip;
  Eigen::Vector2d size{0.015, 0.015};  ///< [m] fingertip: diameter; ultrasound: along x and y
  Eigen::Vector2d entry{0.0, 0.0};     ///< centre of the footprint [m]
  double mass = 0.1;                   ///< [kg] drive by force
  std::optional<PalpationGrid> map{};  ///< of the stiffness that it feels, beside the run
};

struct Drive {
  enum class Kind { trajectory, force, falcon } kind = Kind::trajectory;
  enum class Technique { continuous, intermittent } technique = Technique::continuous;
  double start = 0.0;  ///< [s] before it the tool rests
  double from = 0.0;   ///< tip on its line before the start [m]; 0: at the skin
  // Kind::trajectory
  double speed = 0.005;            ///< [m/s] while advancing
  double advance = 0.002;          ///< [m] of one advance, intermittent
  double pause = 0.5;              ///< [s] between two advances or two load_cases, intermittent
  std::optional<double> depth{};   ///< [m] where the advance ends; empty: it does not
  double hold = 0.5;               ///< [s] at that depth, or at full force, before the withdrawal
  double withdraw_speed = 0.0;     ///< [m/s]; 0: the tool stays
  double grip_stiffness = 5000.0;  ///< [N/m] between hand and tool where bone stops the tool
  // Kind::force
  double force = 10.0;           ///< [N] of the hand when fully on
  double rise = 1.0;             ///< [s] from none to full
  double push = 0.2;             ///< [s] of one push, intermittent
  double withdraw_force = 0.0;   ///< [N] after hold; 0: the push goes on for ever
  double hand_viscosity = 50.0;  ///< [N s/m] of the hand, against the tool's velocity
};

/// Fluid between thumb and needle tip (model/EQUATIONS.md, "Syringe"); saline by default.
struct Syringe {
  double plunger_area = 1.767e-4;       ///< [m^2]
  double compliance = 2.0e-12;          ///< C [m^3/Pa] of the wall and any air
  double thumb_force = 11.0;            ///< largest force of the thumb [N]
  double thumb_flow = 1.0e-7;           ///< largest flow that the thumb keeps up [m^3/s]
  double tissue_resistance = 2.0e12;    ///< R to flow into solid tissue [Pa s/m^3]
  double epidural_resistance = 2.0e10;  ///< R into the epidural space [Pa s/m^3]
  double open_resistance = 1.0e9;       ///< R of the needle itself, tip in air [Pa s/m^3]
};

/// 10 ml of air instead: C = V / p0, and flows 55 times those of saline, the ratio of viscosities.
Syringe air_syringe();

enum class Precision { double_precision, single_precision };

/// Errata of the paper's printed equations, each on its own (model/EQUATIONS.md, "Errata").
struct PrintedForm {
  bool sign = false;             ///< Eqs. 11-13: a stretched spring pushes its ends apart
  bool reversed = false;         ///< with `sign`: the printed force turned round as a whole
  bool direction = false;        ///< Eq. 12: multiplies by d instead of the unit vector d / L
  bool half_force = false;       ///< Eq. 14: half of each spring's force
  bool no_time_step = false;     ///< pseudo-code: velocity += acceleration, position += velocity
  bool lagged_velocity = false;  ///< Eq. 9: extension rate from the previous displacement

  [[nodiscard]] bool any() const {
    return sign || reversed || direction || half_force || no_time_step || lagged_velocity;
  }
  static PrintedForm all() {
    return {.sign = true,
            .direction = true,
            .half_force = true,
            .no_time_step = true,
            .lagged_velocity = true};
  }
};

struct SimulationSettings {
  double duration = 0.5;            ///< [s]
  double step = 1e-3;               ///< [s] one tick
  std::optional<int> substeps{};    ///< integrator steps per tick; empty: auto
  std::string integrator = "auto";  ///< a name of integrator_registry, or "auto"
  double solver_tolerance = 0.0;    ///< of implicit schemes, relative; 0: rounding
  Precision precision = Precision::double_precision;  ///< of the stepping, never of the reference
  int threads = 1;                                    ///< at most, that share a regular lattice
  double sleep_force = 0.0;  ///< [N] that sleeping nodes may withhold in all; 0: none sleeps
  double near_radius =
      0.0;              ///< [m] about a tool or a load, beyond which tissue is reduced; 0: none is
  int far_modes = 100;  ///< that are left of it
  PrintedForm printed{};  ///< all false: the corrected physics
};

/// Mechanical role of a tissue for a needle (model/EQUATIONS.md, "Needle tip"). Bone is rigid:
/// nodes in it are fixed, and it is never pierced.
enum class TissueRole { tissue, epidural_space, dura, bone };

/// Tissue as a homogeneous isotropic solid; springs follow from it (PHYSICS, lattice elasticity).
struct Material {
  std::string name{};
  double youngs_modulus = 0.0;        ///< E [Pa]
  double density = 1000.0;            ///< [kg/m^3]
  double damping_ratio = 0.0;         ///< of each spring against its reduced mass [1]
  std::optional<double> viscosity{};  ///< [N s/m] per spring, instead of damping_ratio
  double cutting_force = 0.0;         ///< [N]
  double friction = 0.0;              ///< [N/m] per metre of shaft
  std::optional<TissueRole> role{};   ///< empty: from its name, role_of()
};

/// A material's role: what it states, else what its name says ("epidural", "dura", "bone" as part
/// of it, in this order), else tissue.
TissueRole role_of(const Material& material);

/// The first material of that name, or null.
const Material* find_material(const std::vector<Material>& materials, std::string_view name);

enum class LatticeWeights { cell, uniform };

/// Regular lattice; node (i, j, l) has index (l * ny + j) * nx + i; x and y are centred on 0,
/// z runs from 0 inwards.
struct Lattice {
  std::array<int, 3> nodes{10, 10, 10};
  double spacing = 0.005;  ///< a [m]
  int connectivity = 26;   ///< 6, 18 or 26 neighbours
  LatticeWeights weights = LatticeWeights::cell;
  std::string material{};   ///< weights = cell
  double stiffness = 50.0;  ///< [N/m] per spring, weights = uniform
  double viscosity = 0.0;   ///< [N s/m] per spring, weights = uniform
  double node_mass = 1e-3;  ///< [kg], weights = uniform
};

/// One layer of a layered block, in order from the skin down.
struct Layer {
  std::string tissue{};  ///< label in results
  std::string material{};
  double thickness = 0.0;  ///< [m]
};

/// Lateral extent of a layered block; its depth is the sum of the layers.
struct LayerBlock {
  std::array<int, 2> nodes{10, 10};  ///< along x and y
  double spacing = 0.005;            ///< a [m]
  int connectivity = 26;
};

/// A body of another material inside a lattice or layered block; later ones win.
struct Inclusion {
  enum class Shape { sphere, box } shape = Shape::sphere;
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d size{0.0, 0.0, 0.0};    ///< [m] sphere: diameter in x; box: edge lengths
  std::string material{};
};

/// Single spring-mass-damper of Eqs. 3-6, driven by drive_amplitude * cos(drive_frequency * t).
struct Oscillator {
  double mass = 1.0;             ///< [kg]
  double stiffness = 1.0;        ///< [N/m]
  double viscosity = 0.1;        ///< [N s/m]
  double displacement = 1.0;     ///< x(0) [m]
  double velocity = 0.0;         ///< x'(0) [m/s]
  double drive_amplitude = 0.0;  ///< [N]
  double drive_frequency = 0.0;  ///< [rad/s]
};

enum class Source { lattice, layers, network, oscillator, mesh, mri };
struct VoxelTissue;  // voxel_tissue.hpp
class Skin;          // skin.hpp
enum class Face { x_min, x_max, y_min, y_max, z_min, z_max };

struct Tissue {
  Source source = Source::lattice;
  std::optional<std::vector<Face>> fixed{};  ///< empty: z-max, and none for a network
  bool hold_by_mass = false;                 ///< fixed faces become very heavy nodes instead
  double heavy_mass_factor = 1e6;            ///< how much heavier [1]
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};    ///< [m/s^2]
  Lattice lattice{};
  LayerBlock block{};
  std::vector<Layer> layers{};
  std::vector<Inclusion> inclusions{};
  SpringNetwork network{};  ///< source = network, as read from its files
  Oscillator oscillator{};
  std::shared_ptr<const VoxelTissue> voxels{};  ///< source = mesh or mri, as built from its files
  std::shared_ptr<const Skin> skin{};  ///< a surface that follows the tissue, as read from its file
};

enum class Profile { constant, ramp, half_sine };

/// Force on nodes; acts on the integrator steps that begin in [start, end).
struct Load {
  std::vector<int> nodes{};
  std::optional<Face> face{};            ///< instead of nodes
  Eigen::Vector3d force{0.0, 0.0, 0.0};  ///< [N] on each node
  double start = 0.0;                    ///< [s]
  double end = std::numeric_limits<double>::infinity();
  Profile profile = Profile::constant;
};

enum class RecordedQuantity { position, velocity, force };

struct Record {
  std::string name{};
  std::variant<int, Eigen::Vector3d> where{0};  ///< node index, or point: the nearest node
  std::vector<RecordedQuantity> quantities{RecordedQuantity::position};
};

struct Output {
  int frames = 60;  ///< snapshots of all nodes kept, evenly spaced over the ticks; 0: none
  /// With a tool: what dampers take is summed up in every step, which costs two passes over the
  /// springs. Not a key of scene files.
  bool audit = false;
};

struct Scene {
  std::string title{};
  SimulationSettings simulation{};
  Tissue tissue{};
  std::vector<Material> materials{};  ///< those of the file and of the shipped library
  std::vector<Load> loads{};
  std::vector<Record> records{};
  std::optional<Needle> needle{};  ///< at most one of needle and probe
  std::optional<Probe> probe{};
  std::optional<Drive> drive{};         ///< of the tool; empty with a tool: the default drive
  std::optional<FalconDrive> falcon{};  ///< of a drive of that kind; empty: the default one
  std::optional<Syringe> syringe{};     ///< only with a needle
  Output output{};
};

/// Nodes of a face: those within a millionth of the body's extent of its extreme coordinate.
std::vector<int> face_nodes(const NodeVectors& rest_position, Face face);

/// The scene's loads with every face replaced by its nodes.
std::vector<Load> resolve_loads(const Scene& scene, const SpringNetwork& network);

/// Node of a record: its index, or the node nearest to its point (the lowest of equals).
int record_node(const Record& record, const SpringNetwork& network);

/// Name as in scene files, "z-max".
std::string_view name_of(Face face);

}  // namespace palpate
