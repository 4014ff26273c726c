// SPDX-License-Identifier: MIT
#pragma once
/// Principal forces at the nodes of a network (model/EQUATIONS.md, "Force lines").

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/problem/spring_law.hpp"
#include "model/problem/spring_network.hpp"
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
  std::vector<int> nodes{};           ///< index in the network of each node
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

inline constexpr std::size_t most_faces_shown = 60'000;

/// Returns the skin faces around the tissue, up to two spacings on every side, with
/// vertices supported by tissue nodes. Returns nothing if there is no skin or too many faces; the
/// latter adds a note.
std::optional<ViewSurface> view_of_skin(const Scene& scene, std::vector<std::string>& notes);

// Grid planes through the nodes of a network, and the tissue cells between them. Spacing may vary
// and nodes may be missing. A cell has eight corners, and its twelve edges are springs.

using GridPlace = std::array<int, 3>;

class CellGrid {
 public:
  /// Finds the grid of a network. Returns nothing if the nodes are not on a grid or if there is no
  /// complete cell.
  static std::optional<CellGrid> of(const SpringNetwork& network);

  [[nodiscard]] const std::vector<GridPlace>& places() const { return place_; }
  [[nodiscard]] int node_at(const GridPlace& place) const;  ///< node index; -1: no node
  [[nodiscard]] bool is_cell(const GridPlace& lowest) const;
  /// Node indices of the corners of a cell. Corner n has bit 0 along x, bit 1 along y, bit 2 along
  /// z.
  [[nodiscard]] std::array<int, 8> corners(const GridPlace& lowest) const;
  /// Cells by their lowest corners.
  [[nodiscard]] const std::vector<GridPlace>& cells() const { return cells_; }

  /// Returns the grid of every n-th plane. A cell exists if all n^3 original cells exist. Node
  /// indices do not change.
  [[nodiscard]] CellGrid thinned(int n) const;

 private:
  void add_nodes(std::vector<GridPlace> places, const std::vector<std::uint8_t>& present);
  template <class IsCell> void add_cells(IsCell is_cell);

  std::vector<GridPlace> place_{};  ///< of every node; (-1, -1, -1): not on this grid
  GridPlace extent_{0, 0, 0};
  std::vector<int> node_at_{};
  std::vector<std::uint8_t> cell_at_{};
  std::vector<GridPlace> cells_{};
};

/// Grid indices shifted by `step` along an axis.
inline GridPlace beside(GridPlace place, int axis, int step) {
  place[static_cast<std::size_t>(axis)] += step;
  return place;
}

/// Face of a cell. The corners are ordered by the right-hand rule with the normal out of the cell.
struct GridFace {
  GridPlace cell{};
  std::array<int, 4> nodes{};
};

/// Faces between the cells and all other space.
std::vector<GridFace> exposed_faces(const CellGrid& grid);

// Selection of the nodes for a view: all nodes of a small network, else the surface, the cut plane
// and the region near the tool. A network that is still too large is thinned to every n-th grid
// plane.

inline constexpr int most_nodes_shown_all = 20'000;
inline constexpr int most_nodes_shown = 60'000;

/// Region shown in full resolution: a segment of the tool path, and the cut plane.
struct ViewFocus {
  Eigen::Vector3d begin{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d end{0.0, 0.0, 0.0};    ///< [m]
  double radius = 0.0;                   ///< radius around the segment [m]; 0: no tool
  double cut = 0.0;                      ///< y coordinate of the plane [m]
};

struct ShownNodes {
  std::vector<int> nodes{};        ///< node indices in ascending order
  std::optional<CellGrid> grid{};  ///< grid of these nodes, with node indices of the network
  std::string note{};              ///< description of the omitted nodes; empty if none
};

/// Selects the nodes to show. The nodes in `needed` are always included.
ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus,
                       const std::vector<int>& needed);

}  // namespace palpate
