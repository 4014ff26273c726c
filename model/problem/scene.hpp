// SPDX-License-Identifier: MIT
#pragma once
/// Scene: plain data with documented defaults in SI units. The tissue frame is right-handed, in
/// metres, with +z into the tissue and the undeformed skin at z = 0. fixtures/io/scene_file.hpp
/// reads a scene, model/tissue/scene_check.hpp checks it, and problem.hpp defines its equation of
/// motion.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

/// Tool that a hand holds through a haptic device: `[falcon]` of a scene file.
struct FalconDrive {
  /// Impedance of the hand on the grip: presets of mass, viscosity and stiffness.
  enum class Hand { light, medium, firm, two_stage } hand = Hand::medium;
  /// Stiffness of the hand on the grip, at the preset's damping ratio; left out: the preset's
  /// [N/m].
  std::optional<double> hand_stiffness{};
  /// Published leg lengths of the device.
  enum class Geometry { libnifalcon, martin_hillier } geometry = Geometry::libnifalcon;
  /// Motor driver: exact, or with the defects of the common open-source driver.
  enum class Profile { correct, stock } profile = Profile::correct;
  /// Method for the tool position between two steps of slower tissue.
  enum class Between { hold, extrapolate } between = Between::hold;

  double rate = 1000.0;                ///< of the haptic loop [Hz]
  int delay = 0;                       ///< ticks between a position and the resulting force
  double coupling_stiffness = 2000.0;  ///< between grip and tool [N/m]
  double coupling_viscosity = 20.0;    ///< [N s/m]
  double start_height = 0.16;          ///< z of the grip in the device, tip on the skin [m]
  double tremor = 0.0;                 ///< amplitude of the hand's tremor [m]
  double reaction_delay = 0.175;      ///< from a loss of resistance to the reaction of the hand [s]
  bool quantised = true;              ///< encoder counts and motor commands are integers
  bool friction = true;               ///< in the device's joints
  bool passivity_controller = false;  ///< dissipates energy that the rendering would generate
  double supply_power = 30.0;         ///< of the device's three motors together [W]
  double thermal_time = 0.0;          ///< time constant of a motor's heating [s]; 0: no limit
  double continuous_power = 10.0;     ///< that one motor can take for ever [W]
  int seed = 1;                       ///< seed of all random numbers
};

/// Rigid needle with a sharp tip on the line entry + s direction; s = 0 is on the undeformed skin.
struct Needle {
  double diameter = 1.651e-3;       ///< outer, 16 gauge; size of the contact at the tip [m]
  Eigen::Vector2d entry{0.0, 0.0};  ///< x and y of the intersection with z = 0 [m]
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< of insertion; normalised
  double mass = 0.02;                        ///< of needle and syringe, for a drive by force [kg]
};

/// Returns the outer diameter [m] of a Stubs needle gauge (ISO 9626); empty for an unknown gauge.
std::optional<double> diameter_of_gauge(int gauge);

/// Grid of positions on the skin that a probe palpates in sequence, centred on the probe's entry.
struct PalpationGrid {
  std::array<int, 2> sites{9, 9};  ///< along x and y
  double spacing = 0.004;          ///< [m]

  [[nodiscard]] Eigen::Vector2d half_span() const {
    return 0.5 * spacing * Eigen::Vector2d(sites[0] - 1, sites[1] - 1);
  }
};

/// Blunt tool that presses on the skin with a force distributed over its footprint.
struct Probe {
  enum class Shape { fingertip, ultrasound } shape = Shape::fingertip;
  Eigen::Vector2d size{0.015, 0.015};  ///< fingertip: diameter; ultrasound: along x and y [m]
  /// A rigid face moves all of the skin beneath it alike; a uniform one has the same pressure
  /// everywhere, and its displacement is the mean.
  enum class FaceKind { rigid, uniform } face = FaceKind::rigid;
  /// Radius of curvature of a rigid fingertip, at least the radius of the disc [m]; empty: flat.
  std::optional<double> tip_radius{};
  Eigen::Vector2d entry{0.0, 0.0};  ///< centre of the footprint [m]
  /// Times [s] and centres [m] of a probe that slides along the skin, instead of `entry`: linear
  /// between the times, constant before and after. Not empty, times ascend.
  std::optional<std::vector<Eigen::Vector3d>> path{};
  double mass = 0.1;  ///< for a drive by force [kg]
  /// Returns the centre of the footprint at a time [m].
  [[nodiscard]] Eigen::Vector2d centre(double t) const noexcept;
  /// Radius of a disc with the area of the footprint [m].
  [[nodiscard]] double radius() const {
    return shape == Shape::fingertip ? 0.5 * size.x() : std::sqrt(size.prod() / std::numbers::pi);
  }
  std::optional<PalpationGrid> map{};  ///< map of the palpated stiffness, in addition to the run
};

/// Hand's end of the coupling to the tool at one time of a recording.
struct GripSample {
  double time = 0.0;      ///< [s]
  double position = 0.0;  ///< along the tool's line [m]
  double velocity = 0.0;  ///< [m/s]
};

struct Drive {
  enum class Kind { trajectory, force, falcon, recorded } kind = Kind::trajectory;
  enum class Technique { continuous, intermittent } technique = Technique::continuous;
  double start = 0.0;  ///< the tool rests before this time [s]
  double from = 0.0;   ///< tip position on its line before the start [m]; 0: at the skin
  // Kind::trajectory
  double speed = 0.005;           ///< [m/s] while advancing
  double advance = 0.002;         ///< length of one advance, intermittent [m]
  double pause = 0.5;             ///< between two advances or two pushes, intermittent [s]
  std::optional<double> depth{};  ///< end of the advance [m]; empty: no end
  double hold = 0.5;            ///< time at that depth, or at full force, before the withdrawal [s]
  double withdraw_speed = 0.0;  ///< 0: no withdrawal [m/s]
  double grip_stiffness = 5000.0;  ///< between hand and tool when bone stops the tool [N/m]
  // Kind::force
  double force = 10.0;           ///< full force of the hand [N]
  double rise = 1.0;             ///< from zero to full force [s]
  double push = 0.2;             ///< duration of one push, intermittent [s]
  double withdraw_force = 0.0;   ///< after `hold`; 0: the push does not end [N]
  double hand_viscosity = 50.0;  ///< of the hand, opposes the tool's velocity [N s/m]
  // Kind::recorded
  std::string recording{};  ///< name of the file with the grip, beside the scene file
  std::shared_ptr<const std::vector<GripSample>> grip{};  ///< its content, ascending in time

  /// Returns true if a device or a recording holds the tool through the coupling of [falcon].
  [[nodiscard]] bool is_coupled() const { return kind == Kind::falcon || kind == Kind::recorded; }
};

/// Fluid between thumb and needle tip (model/EQUATIONS.md, "Syringe"). The default is saline.
struct Syringe {
  /// Technique of the thumb. full: it always presses with its largest force. drives: it pushes the
  /// needle through the plunger, so that the pressure carries the reaction of the tissue (Eqs. 1
  /// and 2). tests: it presses with its largest force while the needle rests, and not otherwise.
  enum class Thumb { full, drives, tests } thumb = Thumb::full;
  double hand_share = 0.0;              ///< of the other hand in the force on a driven needle [1]
  double plunger_friction = 0.0;        ///< [N]
  double plunger_area = 1.767e-4;       ///< [m^2]
  double compliance = 2.0e-12;          ///< C of the wall and any air [m^3/Pa]
  double thumb_force = 11.0;            ///< largest force of the thumb [N]
  double thumb_flow = 1.0e-7;           ///< largest flow that the thumb can supply [m^3/s]
  double tissue_resistance = 2.0e12;    ///< R of solid tissue [Pa s/m^3]
  double epidural_resistance = 2.0e10;  ///< R into the epidural space [Pa s/m^3]
  double open_resistance = 1.0e9;       ///< R of the needle with its tip in air [Pa s/m^3]
};

/// Returns a syringe with 10 ml of air: C = V / p0, flows 55 times those of saline (viscosities).
Syringe air_syringe();

enum class Precision { double_precision, single_precision };

/// Errata of the paper's printed equations, selectable one by one (model/EQUATIONS.md, "Errata").
struct PrintedForm {
  bool sign = false;             ///< Eqs. 11-13: a stretched spring pushes its ends apart
  bool reversed = false;         ///< with `sign`: the printed force with opposite sign
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
  double step = 1e-3;               ///< one tick [s]
  std::optional<int> substeps{};    ///< integrator steps per tick; empty: automatic
  std::string integrator = "auto";  ///< name in integrators(), or "auto"
  double solver_tolerance = 0.0;    ///< relative tolerance of implicit schemes; 0: rounding
  int solver_corrections = 0;       ///< after which their steps end if they converge; 0: no limit
  Precision precision = Precision::double_precision;  ///< of the integrator
  int threads = 1;                                    ///< upper limit for a regular lattice
  double sleep_force = 0.0;  ///< limit of all force withheld on sleeping nodes [N]; 0: none sleeps
  /// Tissue integrated in full around tool and loads [m]; 0: all; empty: chosen by force_error.
  std::optional<double> near_radius = 0.0;
  int far_modes = 100;        ///< number of modes that represent the far tissue, or the most
  double force_error = 0.02;  ///< wanted of the tool's force, over its peak [1]
  PrintedForm printed{};      ///< all false: the corrected physics
};

/// Mechanical role of a tissue for a needle (model/EQUATIONS.md, "Needle tip"). Bone is rigid: its
/// nodes are fixed and it cannot be punctured.
enum class TissueRole { tissue, epidural_space, dura, bone };

/// Young's modulus of a material from a time on.
struct ModulusChange {
  double time = 0.0;            ///< the nearest border of a tick [s]
  double youngs_modulus = 0.0;  ///< [Pa]
};

/// Tissue as a homogeneous isotropic solid, from which the spring constants are computed.
struct Material {
  std::string name{};
  double youngs_modulus = 0.0;        ///< E [Pa]
  double poissons_ratio = 0.25;       ///< nu [1]; 1/4 needs springs only
  double density = 1000.0;            ///< [kg/m^3]
  double damping_ratio = 0.0;         ///< of each spring, relative to its reduced mass [1]
  std::optional<double> viscosity{};  ///< per spring, replaces damping_ratio [N s/m]
  /// tau of a Kelvin-Voigt solid, viscosity over stiffness [s]; replaces damping_ratio.
  std::optional<double> retardation_time{};
  std::optional<Stiffening> stiffening{};
  std::vector<RelaxationBranch> relaxation{};  ///< at most three branches
  std::vector<ModulusChange> changes{};        ///< during the run, ascending in time
  /// Force at which the tip begins a crack; empty: the cutting force [N].
  std::optional<double> puncture_force{};
  double cutting_force = 0.0;  ///< at which the tip goes on cutting [N]
  /// Dent over which the tip's contact becomes as stiff as that of a flat punch; 0: at once [m].
  double indentation_toe = 0.0;
  double friction = 0.0;  ///< per metre of shaft, with a travel at 1 mm/s [N/m]
  /// Distance over which the shaft drags the tissue along before it slides; 0: none [m].
  double friction_travel = 0.0;
  double friction_exponent = 0.0;  ///< of the sliding speed, with a travel [1]
  /// R to the outflow from a needle with its tip here; empty: that of the syringe [Pa s/m^3].
  std::optional<double> outflow_resistance{};
  std::optional<TissueRole> role{};  ///< empty: derived from the name by role_of()
};

/// Returns the law of a material; linear and elastic if it has neither stiffening nor relaxation.
MaterialLaw law_of(const Material& material);

/// Returns the given role, or that of "epidural", "dura" or "bone" in the name, otherwise tissue.
TissueRole role_of(const Material& material);

/// Returns the first material of that name, or null.
const Material* find_material(const std::vector<Material>& materials, std::string_view name);

enum class LatticeWeights { cell, uniform };

/// Regular lattice. Node (i, j, l) has index (l * ny + j) * nx + i; x and y are centred on 0, and z
/// begins at 0 and increases into the tissue.
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

/// Layer of a layered block; layers are listed from the skin down.
struct Layer {
  std::string tissue{};    ///< label in results
  std::string material{};  ///< empty in a gap
  double thickness = 0.0;  ///< [m]
  bool gap = false;        ///< without tissue, and without resistance to a needle
};

/// Lateral size of a layered block; its depth is the sum of the layers.
struct LayerBlock {
  std::array<int, 2> nodes{10, 10};  ///< along x and y
  double spacing = 0.005;            ///< a [m]
  int connectivity = 26;
};

/// Body of another material inside a lattice or layered block; later ones override earlier ones.
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
  std::optional<std::vector<Face>> fixed{};  ///< empty: z-max; none for a network
  bool hold_by_mass = false;                 ///< fixed faces become heavy nodes instead
  double heavy_mass_factor = 1e6;            ///< mass ratio of heavy nodes [1]
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};    ///< [m/s^2]
  Lattice lattice{};
  LayerBlock block{};
  std::vector<Layer> layers{};
  std::vector<Inclusion> inclusions{};
  SpringNetwork network{};  ///< source = network: read from its files
  Oscillator oscillator{};
  std::shared_ptr<const VoxelTissue> voxels{};  ///< source = mesh or mri: built from its files
  std::shared_ptr<const Skin> skin{};  ///< surface that follows the tissue, read from its file
};

enum class Profile { constant, ramp, half_sine };

/// Force on nodes; acts in the integrator steps that begin in [start, end).
struct Load {
  std::vector<int> nodes{};
  std::optional<Face> face{};            ///< replaces `nodes`
  Eigen::Vector3d force{0.0, 0.0, 0.0};  ///< on each node [N]
  double start = 0.0;                    ///< [s]
  double end = std::numeric_limits<double>::infinity();
  Profile profile = Profile::constant;
};

enum class RecordedQuantity { position, velocity, force };

struct Record {
  std::string name{};
  std::variant<int, Eigen::Vector3d> where{0};  ///< node, or a point: the nearest node
  std::vector<RecordedQuantity> quantities{RecordedQuantity::position};
};

struct Output {
  int frames = 60;  ///< stored snapshots of all nodes, evenly spaced over the ticks; 0: none
  /// Sums the energy dissipated by dampers in every step of a run with a tool, at the cost of two
  /// more passes over the springs. Not a key of scene files.
  bool audit = false;
};

struct Scene {
  std::string title{};
  SimulationSettings simulation{};
  Tissue tissue{};
  std::vector<Material> materials{};  ///< from the file and from the shipped library
  std::vector<Load> loads{};
  std::vector<Record> records{};
  std::optional<Needle> needle{};  ///< at most one of needle and probe is set
  std::optional<Probe> probe{};
  std::optional<Drive> drive{};         ///< of the tool; empty with a tool: default drive
  std::optional<FalconDrive> falcon{};  ///< for a drive of kind falcon; empty: default values
  std::optional<Syringe> syringe{};     ///< only with a needle
  Output output{};
};

/// Returns the nodes within a millionth of the body's extent of the extreme coordinate of a face.
std::vector<int> face_nodes(const NodeVectors& rest_position, Face face);

/// Returns the scene's loads with every face replaced by its nodes.
std::vector<Load> resolve_loads(const Scene& scene, const SpringNetwork& network);

/// Returns the node of a record; of equally near nodes the one of the lowest index.
int record_node(const Record& record, const SpringNetwork& network);

}  // namespace palpate
