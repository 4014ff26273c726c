// SPDX-License-Identifier: MIT
#pragma once
/// How force runs through a network (model/EQUATIONS.md, "Force lines").

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
  /// Of each node: unit direction of the principal force of largest size, then that force [N], pull
  /// positive.
  Eigen::Matrix4Xf line{};
  Eigen::Vector3d held{0.0, 0.0, 0.0};  ///< elastic force of the springs on all fixed nodes [N]
};

/// `position` of all nodes [m], 3 x nodes.
ForceLines force_lines(const SpringNetwork& network, const SpringLaw& law,
                       const NodeVectors& position);

// What the 3-D view of a run shows, in SI and in the tissue's frame: a part of the nodes of its
// network, numbered anew, at some instants of its trace.

/// Ticks with events that a view of so many nodes shows: twenty, fewer where their places took over
/// 240 MB.
inline int events_shown(Eigen::Index nodes) {
  constexpr Eigen::Index most = 20;
  constexpr Eigen::Index most_places = 10'000'000;  // of 24 bytes
  return static_cast<int>(std::min(most, most_places / std::max<Eigen::Index>(nodes, 1)));
}

/// The tool as a body that moves along its line.
struct ViewTool {
  enum class Shape { needle, fingertip, ultrasound } shape = Shape::needle;
  Eigen::Vector3d origin{0.0, 0.0, 0.0};     ///< of the tip at place 0 [m]
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< unit
  Eigen::Vector2d size{0.0, 0.0};            ///< across; needle and fingertip: diameter twice [m]
};

/// A surface that follows the tissue: every vertex moves by the weighted mean of what nodes move
/// by.
struct ViewSurface {
  struct Support {
    int node = 0;
    double weight = 1.0;  ///< those of a vertex sum to one
  };
  std::string label{};
  NodeVectors rest{};                            ///< undeformed places of the vertices [m]
  std::vector<std::vector<Support>> vertices{};  ///< without any the vertex stays
  std::vector<std::array<int, 3>> triangles{};   ///< of vertices, outwards by the right hand
  bool of_cells = false;                         ///< it is made of sides of the cells of tissue
};

struct ViewSpring {
  int a = 0;
  int b = 0;
  double stiffness = 0.0;  ///< [N/m]
};

struct ViewFrame {
  double time = 0.0;           ///< [s]
  NodeVectors displacement{};  ///< from the undeformed place [m]
  Eigen::Matrix4Xf
      line{};             ///< force lines: unit direction and principal force [N] (force_lines.hpp)
  double place = 0.0;     ///< of the tool's tip on its line, in space [m]
  double depth = 0.0;     ///< of the tip in the undeformed tissue [m]
  double applied = 0.0;   ///< by the hand, or by loads [N]
  double reaction = 0.0;  ///< on the tool, or of what holds the tissue [N]
  std::string layer{};    ///< that the tip is in
  std::string event{};
};

struct View {
  NodeVectors rest{};                 ///< undeformed places [m]
  std::vector<std::uint8_t> label{};  ///< of each node, an index of labels
  std::vector<std::string> labels{};  ///< what the tissue is made of, at least one
  std::vector<std::uint8_t> fixed{};
  Eigen::VectorXd stiffness{};  ///< mean over the springs of a node [N/m]
  std::vector<std::array<int, 3>>
      place{};                       ///< on a grid that need not be regular; empty: there is none
  std::vector<std::uint8_t> cell{};  ///< 1: the node is the lowest corner of a cell of tissue
  std::vector<ViewSpring> springs{};
  std::vector<ViewSurface> surfaces{};
  std::vector<ViewFrame> frames{};  ///< at least one
  std::size_t peak = 0;             ///< frame of the largest reaction
  std::optional<ViewTool> tool{};
  double cut = 0.0;  ///< y of the sagittal plane through the tool, or the middle [m]
  std::vector<std::string> notes{};  ///< what is not as in the network: nodes or frames left out
};

struct ViewInput {
  const Scene& scene;
  const NetworkProblem& problem;
  const Trace& trace;
  std::vector<ViewSurface>
      surfaces{};  ///< of nodes of the network; empty: the skin of its grid, if it has one
};

/// Nothing where the trace has no frames.
std::optional<View> make_view(const ViewInput& input);

// The surface of a scene's skin as its 3-D view shows it.

inline constexpr std::size_t most_faces_shown = 60'000;

/// Faces around the tissue, half its length on every side, their vertices carried by its nodes.
/// Nothing without a skin, or where there are more of them than can be shown; `notes` says so.
std::optional<ViewSurface> view_of_skin(const Scene& scene, std::vector<std::string>& notes);

}  // namespace palpate
