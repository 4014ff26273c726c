// SPDX-License-Identifier: MIT
#pragma once
/// Line of a needle or footprint of a probe in a network (model/EQUATIONS.md, "Needle line"). Only
/// the references use it. It is implemented from the equations, independently of the model's code.

#include <Eigen/Core>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::reference {

struct TrackSupport {
  int node = 0;
  double weight = 0.0;  ///< weights of one contact point sum to 1 [1]
};

struct TrackKnot {
  double depth = 0.0;  ///< xi_k [m] on the undeformed line
  std::vector<TrackSupport> supports{};
};

struct TrackInterval {
  double begin = 0.0;  ///< xi [m]
  double end = std::numeric_limits<double>::infinity();
  /// Forces at which the tip begins and goes on cutting, infinite for bone and beneath a probe [N].
  double puncture_force = 0.0;
  double cutting_force = 0.0;
  double toe = 0.0;       ///< D_1 of the contact [m]
  double friction = 0.0;  ///< [N/m]
  double travel = 0.0;    ///< delta of creeping friction [m]; 0: friction of Coulomb
  double exponent = 0.0;  ///< nu of creeping friction [1]
  std::vector<RelaxationBranch> branches{};  ///< of the contact
  TissueRole role = TissueRole::tissue;
  std::string label{};  ///< of the layer, or of the material without a layer
};

/// Compliance c_s of the tissue between the tip and the contact point at a depth.
struct TrackGive {
  double depth = 0.0;       ///< xi [m]
  double compliance = 0.0;  ///< [m/N]
  double continuum = 0.0;   ///< c_c, of the continuum; 0 unless a layer has a toe [m/N]
};

/// Contact that is not linear (model/EQUATIONS.md, "Large dent of a skin", "Face of a probe"): the
/// gap is compliance x phi(T).
struct TrackDent {
  std::vector<double> force{};       ///< T, ascending from 0 [N]
  std::vector<double> phi{};         ///< at these forces [N]; linear between and beyond
  std::vector<double> compliance{};  ///< at the depths of NeedleTrack::give [m/N]

  [[nodiscard]] double phi_of(double at) const;
  [[nodiscard]] double force_of(double x) const;
  [[nodiscard]] double work(double at) const;  ///< integral of T over phi [N^2]
};

struct NeedleTrack {
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< n
  std::vector<TrackKnot> knots{};            ///< ascending in depth; no node belongs to two of them
  std::vector<TrackInterval> intervals{};    ///< contiguous from the first contact point on
  double bone = std::numeric_limits<double>::infinity();  ///< depth xi at which bone begins [m]
  /// c_s at ascending depths, linear between them and constant beyond; positive, or empty: the tip
  /// sticks to the contact point itself.
  std::vector<TrackGive> give{};
  std::map<std::size_t, TrackDent> dents{};  ///< of intervals whose contact is not linear

  [[nodiscard]] double entry() const { return knots.front().depth; }  ///< xi_0 [m]
  /// Returns the last contact point above or at `depth` [m], or 0.
  [[nodiscard]] std::size_t segment_at(double depth) const;
  [[nodiscard]] std::size_t interval_at(double depth) const;
  /// Returns the last entry of `give` above or at `depth` [m], or 0.
  [[nodiscard]] std::size_t stretch_at(double depth) const;
  /// Returns the depth at which the stretch after an entry of `give` ends [m].
  [[nodiscard]] double stretch_end(std::size_t stretch) const {
    return stretch + 1 < give.size() ? give[stretch + 1].depth
                                     : std::numeric_limits<double>::infinity();
  }
  /// Returns the law of the contact in an interval; null: the gap is c_s T.
  [[nodiscard]] const TrackDent* dent_in(std::size_t interval) const {
    const auto found = dents.find(interval);
    return found == dents.end() ? nullptr : &found->second;
  }
  /// Returns c_s at a depth, or the compliance of a large dent, and its slope [m/N, 1/N], extended
  /// linearly from a stretch; 0 without `give`.
  [[nodiscard]] std::array<double, 2> give_at(std::size_t interval, std::size_t stretch,
                                              double depth) const;
  /// Returns the gap between tip and contact point under a force [N] at a depth, and its slope over
  /// the depth [m, 1], extended from a stretch like give_at().
  [[nodiscard]] std::array<double, 2> gap_at(std::size_t interval, std::size_t stretch,
                                             double depth, double force) const;
  /// Returns the elastic force of the contact under a gap [N].
  [[nodiscard]] double force_at(std::size_t interval, std::size_t stretch, double depth,
                                double gap) const;
  /// Returns the energy of the contact under an elastic force [J].
  [[nodiscard]] double energy_at(std::size_t interval, std::size_t stretch, double depth,
                                 double force) const;
  /// Returns the hat functions of contact points `segment` and `segment + 1` at a depth [1]; the
  /// second is 0 beyond the last contact point.
  [[nodiscard]] std::array<double, 2> hats(std::size_t segment, double depth) const;
  /// Returns l_k [N] of the contact points down to a depth in this segment and interval, without
  /// creeping friction. Both are extended smoothly beyond their ends, for the trial steps of a
  /// solver.
  [[nodiscard]] Eigen::VectorXd friction_shares(std::size_t segment, std::size_t interval,
                                                double depth) const;
  /// Returns l_k [N] of the creeping friction of one interval down to a depth.
  [[nodiscard]] Eigen::VectorXd creeping_shares(std::size_t interval, double depth) const;

 private:
  /// Adds the friction of an interval between two depths in the segment that begins at knot k.
  void add_friction(std::size_t k, std::size_t interval, double from, double to,
                    Eigen::VectorXd& shares) const;
  /// Returns c_c and its slope [m/N, 1/N].
  [[nodiscard]] std::array<double, 2> continuum_at(std::size_t stretch, double depth) const;
};

/// Returns the track of the scene's needle or probe. c_s and the dent of the continuum are taken
/// from the model: they are input of the equation of motion. The grid's own dent is computed.
/// Throws SolverError if there is neither, or no node beneath it.
NeedleTrack needle_track(const Scene& scene, const SpringNetwork& network);

}  // namespace palpate::reference
