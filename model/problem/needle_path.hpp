// SPDX-License-Identifier: MIT
#pragma once
/// Path of a needle through a network (model/EQUATIONS.md, "Needle line").

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate {

/// Material of the path from `begin` to `end` [m] on the undeformed line from the skin.
struct PathInterval {
  double begin = 0.0;
  double end = std::numeric_limits<double>::infinity();
  double puncture_force = 0.0;   ///< at which the tip begins to cut [N]
  double cutting_force = 0.0;    ///< at which it goes on [N]
  double indentation_toe = 0.0;  ///< [m]
  double friction = 0.0;         ///< [N/m] per metre of shaft
  double friction_travel = 0.0;  ///< [m]; 0: friction of Coulomb
  double friction_exponent = 0.0;
  std::optional<double> outflow_resistance{};  ///< [Pa s/m^3]
  TissueRole role = TissueRole::tissue;
  std::string label{};           ///< name of the layer or of its material
  double youngs_modulus = 0.0;   ///< [Pa]; 0 in a gap or in an unknown material
  double poissons_ratio = 0.25;  ///< [1]
  MaterialLaw law{};             ///< stiffening and relaxation
};

/// Returns the interval of a material between two depths [m].
PathInterval interval_in(const Material& material, std::string label, double begin, double end);

/// Returns the materials along entry + xi n in order of xi, from the skin to infinity: layers, the
/// lattice's material, inclusions, or the boxes of voxels. `first` is the depth at which the tissue
/// begins; layers of a bare network are measured from it.
std::vector<PathInterval> intervals_along(const Scene& scene, const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double first);

/// Returns the label of intervals_along() at a point, on the line along z.
std::string label_at(const Scene& scene, const Eigen::Vector3d& point, double first);

struct NodeGrid;  // tissue_grid.hpp

/// Layer of a flat block, with the number of cells along its thickness that lie in it alone.
struct ResolvedLayer {
  std::string tissue{};
  double thickness = 0.0;  ///< [m]
  int cells = 0;
};
/// Returns the layers of a flat block; empty for other tissues.
std::vector<ResolvedLayer> resolved_layers(const Scene& scene);

/// Dents of a contact that is not linear: of a skin or membrane that is dented by more than its
/// thickness (model/EQUATIONS.md, "Large dent of a skin"), or under a spherical fingertip ("Face of
/// a probe"). Forces are multiples of `step`.
struct DentTable {
  std::size_t interval = 0;        ///< of the path, to which the law applies
  double step = 0.0;               ///< [N]
  std::vector<double> multiple{};  ///< ascending from 0 [1]
  std::vector<double> dent{};      ///< of the continuum under each force at the begin [m]
  double small_dent = 0.0;         ///< of the continuum in small deformation, at the last force [m]
  double end_dent = 0.0;           ///< of the continuum under the cutting force at the end [m]
  /// phi, the force of a linear contact with the same gap, for each force [N]; linear between them
  /// and beyond. Empty until the grid's own dent is known.
  std::vector<double> linear_force{};
  std::vector<double> compliance{};  ///< gap over phi at the depths of the table [m/N]

  /// Least slope of phi in a skin: no contact is rigid.
  static constexpr double least_slope = 0.05;
  /// Sets phi for a contact with the compliance `unit` [m/N]. `own` are the dents of the grid under
  /// the same forces [m], `least` the least slope of phi.
  void set_gaps(double unit, const std::vector<double>& own, double least);
  /// Completes the law of a layer of the path: `own` are the dents of the grid under the same
  /// forces at its begin, `own_end` the one under the cutting force at its end [m].
  void complete(const PathInterval& layer, const std::vector<double>& depth,
                const std::vector<double>& lacking, const std::vector<double>& own, double own_end);
  [[nodiscard]] bool is_complete() const noexcept { return !linear_force.empty(); }
  [[nodiscard]] double phi(double force) const noexcept;  ///< [N]
  /// Returns T and its slope over phi, for a value of phi.
  [[nodiscard]] std::array<double, 2> force_of(double phi) const noexcept;
  [[nodiscard]] double work(double force) const noexcept;  ///< integral of T over phi [N^2]
  /// Returns the compliance of the contact where it is stiffest [m/N].
  [[nodiscard]] double least_compliance() const;
};

/// Force of a tip on the tissue between it and the contact point, which is dented by a gap
/// (model/EQUATIONS.md, "Contact of a size"). Without a toe and a table the force is
/// gap / compliance.
struct DentLaw {
  double compliance = 0.0;           ///< c_s, that the grid lacks [m/N]
  double continuum = 0.0;            ///< c_c, of the continuum [m/N]
  double toe = 0.0;                  ///< dent of the continuum up to which the contact stiffens [m]
  const DentTable* table = nullptr;  ///< of a deep dent or a sphere; not with a toe

  /// Slope of the force at rest as a share of 1 / c_c.
  static constexpr double slope_at_rest = 0.02;

  [[nodiscard]] bool is_linear() const noexcept { return toe == 0.0 && table == nullptr; }
  [[nodiscard]] double force(double gap) const noexcept;   ///< [N]
  [[nodiscard]] double slope(double gap) const noexcept;   ///< of the force over the gap [N/m]
  [[nodiscard]] double gap(double force) const noexcept;   ///< [m]
  [[nodiscard]] double energy(double gap) const noexcept;  ///< [J]

 private:
  [[nodiscard]] double dent(double gap) const noexcept;
  [[nodiscard]] double at_dent(double dent) const noexcept;
};

/// Axial compliance between a tool and the tissue around its tip that the grid lacks, because its
/// cells are not small against the tool (model/EQUATIONS.md, "Contact of a size").
struct TipCompliance {
  /// Ascending depths of the values [m], borders of layers among them: c_s has a sharp bend there.
  std::vector<double> depth{};
  std::vector<double> value{};  ///< [m/N]; linear between depths, constant beyond; empty: none
  std::vector<double> of_continuum{};  ///< compliance of the layered continuum there [m/N]
  double continuum = 0.0;              ///< the same at the skin [m/N]
  double grid = 0.0;                   ///< compliance of the unbounded grid there [m/N]
  double spacing = 0.0;                ///< of the planes of nodes [m]
  /// Largest excess of the grid's compliance over the continuum's, relative; it is not corrected.
  double excess = 0.0;
  /// Laws of contacts that are not linear: of layers that are dented deeply, or of a sphere. A
  /// table without dents marks a layer for which no such law was found; its contact is linear.
  std::vector<DentTable> tables{};
  [[nodiscard]] double at(double place) const noexcept;
  /// Returns true if the force of every contact is proportional to its gap.
  [[nodiscard]] bool is_linear() const noexcept;
  /// Returns the law of the contact at a place in an interval of the path, whose tissue may have a
  /// toe [m].
  [[nodiscard]] DentLaw law(double place, double toe, std::size_t interval) const noexcept;
  /// Returns the next depth of the table beyond `place`; infinite beyond the last [m].
  [[nodiscard]] double next(double place) const noexcept;
};

/// Factors of the terms of the pressure under a probe's face, for a unit force; the first is 1
/// (model/EQUATIONS.md, "Contact of a size").
using FacePressure = Eigen::VectorXd;

/// Face of a probe on the skin nodes of a regular grid, one in each column of nodes.
struct ProbeFace {
  struct Point {
    Eigen::Vector2d place{0.0, 0.0};  ///< relative to the centre of the face [m]
    double share = 0.0;  ///< of the force, also negative; the shares of all points sum to one
  };
  std::vector<Point> points{};
  Eigen::Vector2d first{0.0, 0.0};    ///< place of the first column [m]
  Eigen::Vector2d spacing{0.0, 0.0};  ///< [m]
  std::array<int, 2> count{0, 0};
  std::vector<int> node{};  ///< of each column, x fastest; -1: no tissue

  /// Computes the share of each column's node in a force on a face with its centre at a place [m].
  void press(const Eigen::Vector2d& centre, std::span<double> share) const noexcept;
};

/// Contact points of a tool and the materials along it. The path of a probe has one contact point.
class NeedlePath {
 public:
  struct Support {
    int node = 0;
    double weight = 0.0;  ///< the weights of a contact point sum to one
    int column = -1;      ///< of a sliding probe's face, whose weights change
  };
  /// Contact point: a material point on the path that moves with the weighted mean of nodes.
  struct Knot {
    double depth = 0.0;     ///< xi_k on the undeformed line [m]
    std::size_t first = 0;  ///< index of its first support
    std::size_t count = 0;
  };
  /// Material point with weight 1 - share on `knot` and share on knot + 1.
  struct Place {
    std::size_t knot = 0;
    double share = 0.0;
  };

  /// Builds the path of the tool of a scene, which must have a needle or a probe. Throws
  /// std::invalid_argument if no node is near the line of the needle or below the probe.
  NeedlePath(const Scene& scene, const SpringNetwork& network);

  [[nodiscard]] const Eigen::Vector3d& origin() const { return origin_; }        ///< at s = 0 [m]
  [[nodiscard]] const Eigen::Vector3d& direction() const { return direction_; }  ///< n
  [[nodiscard]] const std::vector<Knot>& knots() const { return knots_; }
  [[nodiscard]] std::span<const Support> supports(const Knot& knot) const {
    return {supports_.data() + knot.first, knot.count};
  }
  [[nodiscard]] const std::vector<PathInterval>& intervals() const { return intervals_; }
  /// Returns the materials along the line, also below a probe, which does not cut them.
  [[nodiscard]] const std::vector<PathInterval>& tissue() const {
    return beneath_.empty() ? intervals_ : beneath_;
  }
  /// Returns the pressure of a probe; empty for a needle.
  [[nodiscard]] const FacePressure& face_pressure() const { return pressure_; }
  /// Returns the face of a sliding probe, whose supports are all nodes that it ever presses; empty
  /// for other tools.
  [[nodiscard]] const std::optional<ProbeFace>& sliding_face() const { return sliding_face_; }
  /// Returns the depth at which bone begins [m]; infinite without bone.
  [[nodiscard]] double bone() const { return bone_; }

  /// Computes the compliance that the grid lacks. Empty for a bare network, whose material is
  /// unknown, and if the grid is as stiff as the continuum to 1 %. Otherwise no value is below 1 %
  /// of the continuum's compliance at the skin, so that the tip is nowhere rigid.
  [[nodiscard]] TipCompliance tip_compliance(const Scene& scene,
                                             const SpringNetwork& network) const;
  [[nodiscard]] Place place(double depth) const noexcept;
  /// Returns the index of the interval at `depth`; a boundary belongs to the next interval.
  [[nodiscard]] std::size_t interval_at(double depth) const noexcept;
  /// Computes the friction limits l_k [N] of Coulomb for a tip at `depth` and returns their sum.
  double friction(double depth, std::span<double> of_knot) const noexcept;
  /// The same for an interval with a travel.
  double friction(std::size_t interval, double depth, std::span<double> of_knot) const noexcept;

 private:
  /// Part of an interval between two contact points, with its friction.
  struct Piece {
    double begin = 0.0;
    double end = 0.0;
    double friction = 0.0;     ///< [N/m]
    std::size_t knot = 0;      ///< contact point before it
    std::size_t interval = 0;  ///< of the materials
  };
  /// Sums the friction of pieces; `interval`: of this one alone, or of all.
  double sum_friction(std::span<const Piece> pieces, std::optional<std::size_t> interval,
                      double depth, std::span<double> of_knot) const noexcept;
  void of_needle(const Scene& scene, const SpringNetwork& network);
  void of_probe(const Scene& scene, const SpringNetwork& network);
  void add_knot(double depth, const std::vector<Support>& supports);
  void network_knots(const SpringNetwork& network);
  /// Throws std::invalid_argument if all nodes that the tool moves are fixed.
  void require_free_node(const SpringNetwork& network, const char* where) const;
  void cut_into_pieces();

  Eigen::Vector3d origin_{0.0, 0.0, 0.0};
  Eigen::Vector3d direction_{0.0, 0.0, 1.0};
  std::vector<Knot> knots_;
  std::vector<Support> supports_;
  std::vector<PathInterval> intervals_;
  std::vector<PathInterval> beneath_;
  FacePressure pressure_;
  std::optional<ProbeFace> sliding_face_;
  std::vector<Piece> pieces_;   ///< with friction of Coulomb, in order of depth
  std::vector<Piece> dragged_;  ///< with a travel
  double bone_ = std::numeric_limits<double>::infinity();
};

}  // namespace palpate
