// SPDX-License-Identifier: MIT
#pragma once
/// What a person writes: a Scene is plain data with documented defaults, SI units throughout.
/// Frame: right-handed, metres, +z points into the tissue, the undeformed skin is z = 0.
/// The file format that fills it is fixtures/io/scene_file.hpp; the rules it must obey are in
/// scene_check.hpp; what it becomes is SpringNetwork or the oscillator of problem.hpp.

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "model/dynamics/falcon_drive.hpp"
#include "model/dynamics/spring_network.hpp"
#include "model/dynamics/tool.hpp"

namespace palpate {

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
    return {.sign = true, .direction = true, .half_force = true, .no_time_step = true,
            .lagged_velocity = true};
  }
};

struct SimulationSettings {
  double duration = 0.5;                             ///< [s]
  double step = 1e-3;                                ///< [s] one tick
  std::optional<int> substeps{};                     ///< integrator steps per tick; empty: auto
  std::string integrator = "auto";                   ///< a name of integrator_registry, or "auto"
  double solver_tolerance = 0.0;                     ///< of implicit schemes, relative; 0: rounding
  Precision precision = Precision::double_precision; ///< of the stepping, never of the reference
  int threads = 1;                                   ///< at most, that share a regular lattice
  double sleep_force = 0.0;                          ///< [N] that sleeping nodes may withhold in all; 0: none sleeps
  double near_radius = 0.0;                          ///< [m] about a tool or a load, beyond which tissue is reduced; 0: none is
  int far_modes = 100;                               ///< that are left of it
  PrintedForm printed{};                             ///< all false: the corrected physics
};

/// What a needle meets in a tissue (model/EQUATIONS.md, "Needle tip"). Bone is rigid: nodes in it are
/// fixed, and it is never pierced.
enum class TissueRole { tissue, epidural_space, dura, bone };

/// Tissue as a homogeneous isotropic solid; springs follow from it (PHYSICS, lattice elasticity).
struct Material {
  std::string name{};
  double youngs_modulus = 0.0;         ///< E [Pa]
  double density = 1000.0;             ///< [kg/m^3]
  double damping_ratio = 0.0;          ///< of each spring against its reduced mass [1]
  std::optional<double> viscosity{};   ///< [N s/m] per spring, instead of damping_ratio
  double cutting_force = 0.0;          ///< [N]
  double friction = 0.0;               ///< [N/m] per metre of shaft
  std::optional<TissueRole> role{};    ///< empty: from its name, role_of()
};

/// A material's role: what it states, else what its name says ("epidural", "dura", "bone" as part of
/// it, in this order), else tissue.
TissueRole role_of(const Material& material);

enum class LatticeWeights { cell, uniform };

/// Regular lattice; node (i, j, l) has index (l * ny + j) * nx + i; x and y are centred on 0,
/// z runs from 0 inwards.
struct Lattice {
  std::array<int, 3> nodes{10, 10, 10};
  double spacing = 0.005;                        ///< a [m]
  int connectivity = 26;                         ///< 6, 18 or 26 neighbours
  LatticeWeights weights = LatticeWeights::cell;
  std::string material{};                        ///< weights = cell
  double stiffness = 50.0;                       ///< [N/m] per spring, weights = uniform
  double viscosity = 0.0;                        ///< [N s/m] per spring, weights = uniform
  double node_mass = 1e-3;                       ///< [kg], weights = uniform
};

/// One layer of a layered block, in order from the skin down.
struct Layer {
  std::string tissue{};    ///< label in results
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
  std::optional<std::vector<Face>> fixed{};        ///< empty: z-max, and none for a network
  bool hold_by_mass = false;                       ///< fixed faces become very heavy nodes instead
  double heavy_mass_factor = 1e6;                  ///< how much heavier [1]
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};          ///< [m/s^2]
  Lattice lattice{};
  LayerBlock block{};
  std::vector<Layer> layers{};
  std::vector<Inclusion> inclusions{};
  SpringNetwork network{};                         ///< source = network, as read from its files
  Oscillator oscillator{};
  std::shared_ptr<const VoxelTissue> voxels{};     ///< source = mesh or mri, as built from its files
  std::shared_ptr<const Skin> skin{};              ///< a surface that follows the tissue, as read from its file
};

enum class Profile { constant, ramp, half_sine };

/// Force on nodes; acts on the integrator steps that begin in [start, end).
struct Load {
  std::vector<int> nodes{};
  std::optional<Face> face{};              ///< instead of nodes
  Eigen::Vector3d force{0.0, 0.0, 0.0};    ///< [N] on each node
  double start = 0.0;                      ///< [s]
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
  std::optional<Needle> needle{};    ///< at most one of needle and probe
  std::optional<Probe> probe{};
  std::optional<Drive> drive{};      ///< of the tool; empty with a tool: the default drive
  std::optional<FalconDrive> falcon{};  ///< of a drive of that kind; empty: the default one
  std::optional<Syringe> syringe{};  ///< only with a needle
  Output output{};
};

}  // namespace palpate
