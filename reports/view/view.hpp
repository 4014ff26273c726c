// SPDX-License-Identifier: MIT
#pragma once
/// Principal forces at the nodes of a network (model/EQUATIONS.md, "Force lines").

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/problem/spring_law.hpp"
#include "model/problem/trace.hpp"

namespace palpate {

struct ForceLines {
  /// Per node: unit direction of the principal force with the largest magnitude, then that force
  /// [N], positive in tension.
  Eigen::Matrix4Xf line{};
  Eigen::Vector3d held{0.0, 0.0, 0.0};  ///< sum of the elastic spring forces on all fixed nodes [N]
};

/// Computes the force lines. `position` contains all nodes [m], 3 x nodes.
ForceLines force_lines(const SpringNetwork& network, const SpringLaw& law,
                       const NodeVectors& position);

// Data of the 3-D view of a run, in SI units and the tissue frame: a subset of the network nodes,
// renumbered, at selected times of the trace.

/// Number of event ticks shown in a view: twenty, or fewer if their node positions need more than
/// 240 MB.
inline int events_shown(Eigen::Index nodes) {
  constexpr Eigen::Index most = 20;
  constexpr Eigen::Index most_places = 10'000'000;  // positions of 24 bytes each
  return static_cast<int>(std::min(most, most_places / std::max<Eigen::Index>(nodes, 1)));
}

/// Rigid tool that moves along its path.
struct ViewTool {
  enum class Shape { needle, fingertip, ultrasound } shape = Shape::needle;
  Eigen::Vector3d origin{0.0, 0.0, 0.0};     ///< tip at position 0 on the path [m]
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< unit vector along the path
  Eigen::Vector2d size{0.0, 0.0};  ///< lateral widths [m]; needle, fingertip: diameter twice
};

/// Surface attached to the tissue. The displacement of a vertex is the weighted mean of the
/// displacements of its supporting nodes.
struct ViewSurface {
  struct Support {
    int node = 0;
    double weight = 1.0;  ///< weights of a vertex sum to one
  };
  std::string label{};
  NodeVectors rest{};                            ///< undeformed vertex positions [m]
  std::vector<std::vector<Support>> vertices{};  ///< supports; none: fixed vertex
  std::vector<std::array<int, 3>> triangles{};   ///< vertices; right-hand rule, normal outward
  bool of_cells = false;  ///< true if the surface consists of faces of tissue cells
};

struct ViewSpring {
  int a = 0;
  int b = 0;
  double stiffness = 0.0;  ///< [N/m]
};

struct ViewFrame {
  double time = 0.0;           ///< [s]
  NodeVectors displacement{};  ///< displacement from the undeformed position [m]
  Eigen::Matrix4Xf line{};     ///< force lines: unit direction and principal force [N]
  double place = 0.0;          ///< position of the tool tip along its path, in space [m]
  double depth = 0.0;          ///< depth of the tip in the undeformed tissue [m]
  double applied = 0.0;        ///< force applied by the hand, or by loads [N]
  double reaction = 0.0;       ///< reaction force on the tool, or at the fixed nodes [N]
  std::string layer{};         ///< layer that contains the tip
  std::string event{};
};

struct View {
  NodeVectors rest{};                 ///< undeformed node positions [m]
  std::vector<std::uint8_t> label{};  ///< label of each node, as an index of `labels`
  std::vector<std::string> labels{};  ///< tissue names; at least one
  std::vector<std::uint8_t> fixed{};
  Eigen::VectorXd stiffness{};              ///< mean stiffness of the springs of each node [N/m]
  std::vector<std::array<int, 3>> place{};  ///< grid indices of each node; empty: no grid
  std::vector<std::uint8_t> cell{};         ///< 1: the node is the lowest corner of a tissue cell
  std::vector<ViewSpring> springs{};
  std::vector<ViewSurface> surfaces{};
  std::vector<ViewFrame> frames{};  ///< frames; at least one
  std::size_t peak = 0;             ///< index of the frame with the largest reaction
  std::optional<ViewTool> tool{};
  double cut = 0.0;                  ///< y of the plane through the tool, or through the middle [m]
  std::vector<std::string> notes{};  ///< nodes and frames that are omitted
};

struct ViewInput {
  const Scene& scene;
  const NetworkProblem& problem;
  const Trace& trace;
  std::vector<ViewSurface> surfaces{};  ///< empty: the skin of the grid, if any
};

/// Creates the view. Returns nothing if the trace has no frames.
std::optional<View> make_view(const ViewInput& input);

// Skin surface of a scene for its 3-D view.

inline constexpr std::size_t most_faces_shown = 60'000;

/// Returns the skin faces around the tissue, up to half the tissue length on every side, with
/// vertices supported by tissue nodes. Returns nothing if there is no skin or too many faces; the
/// latter adds a note.
std::optional<ViewSurface> view_of_skin(const Scene& scene, std::vector<std::string>& notes);

}  // namespace palpate
