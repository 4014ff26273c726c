// SPDX-License-Identifier: MIT

#include "reports/view/view.hpp"

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <numeric>
#include <zlib.h>

#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/skin.hpp"
#include "model/tissue/solids.hpp"
#include "reports/view/view_encoding.hpp"
#include "tests/check.hpp"
#include "validation/outcome.hpp"

namespace PALPATE_FILE {

using namespace palpate;

SpringNetwork block(std::array<int, 3> nodes) {
  return uniform_lattice({.nodes = nodes, .spacing = 0.01, .connectivity = 26}, 10.0, 0.0, 1e-3);
}

/// Volume by the divergence theorem; negative if faces point inwards.
double enclosed_volume(const std::vector<GridFace>& faces, const NodeVectors& position) {
  double volume = 0.0;
  for (const GridFace& face : faces) {
    const auto at = [&](std::size_t corner) {
      return Eigen::Vector3d(position.col(face.nodes[corner]));
    };
    volume += (at(0).dot(at(1).cross(at(2))) + at(0).dot(at(2).cross(at(3)))) / 6.0;
  }
  return volume;
}

/// Network without the nodes in `gone` and without their springs.
SpringNetwork without(const SpringNetwork& network,
                      const std::function<bool(const Eigen::Vector3d&)>& gone) {
  SpringNetwork rest;
  std::vector<int> number(static_cast<std::size_t>(network.node_count()), -1), kept;
  for (int n = 0; n < network.node_count(); ++n) {
    if (gone(network.rest_position.col(n))) { continue; }
    number[static_cast<std::size_t>(n)] = static_cast<int>(kept.size());
    kept.push_back(n);
  }
  rest.rest_position = network.rest_position(Eigen::all, kept);
  rest.mass = network.mass(kept);
  rest.fixed.assign(kept.size(), 0);
  for (Spring spring : network.springs) {
    spring.a = number[static_cast<std::size_t>(spring.a)];
    spring.b = number[static_cast<std::size_t>(spring.b)];
    if (spring.a >= 0 && spring.b >= 0) { rest.springs.push_back(spring); }
  }
  return rest;
}

CellGrid grid_of(const SpringNetwork& network) {
  const auto grid = CellGrid::of(network);
  REQUIRE(grid.has_value());
  return *grid;
}

TEST("a lattice has a cell between every eight nodes, none across a gap, and encloses its volume") {
  SpringNetwork network = block({4, 5, 6});
  const std::vector<GridFace> faces = exposed_faces(grid_of(network));
  CHECK(grid_of(network).cells().size() == 3 * 4 * 5);
  CHECK(faces.size() == 2 * (3 * 4 + 4 * 5 + 3 * 5));
  CHECK_NEAR(enclosed_volume(faces, network.rest_position), 0.03 * 0.04 * 0.05, 1e-18);  // rounding
  // Two legs of 3 x 3 nodes on a base; the gap between the legs is one cell wide.
  network = without(block({8, 3, 6}), [](const Eigen::Vector3d& x) {
    return std::abs(x.x()) < 0.01 && x.z() < 0.015;
  });
  CHECK_NEAR(enclosed_volume(exposed_faces(grid_of(network)), network.rest_position),
             0.07 * 0.02 * 0.03 + 2.0 * 0.02 * 0.02 * 0.02, 1e-17);
}

TEST("a cell that lacks a spring along an edge is no tissue; its planes may have any distances") {
  SpringNetwork network = block({4, 3, 3});
  network.springs.edit([](std::vector<Spring>& all) {
    std::erase_if(all, [](const Spring& spring) { return spring.a == 1 && spring.b == 2; });
  });
  CHECK(grid_of(network).cells().size() == 3 * 2 * 2 - 1);
  network = block({3, 3, 3});
  for (auto node : network.rest_position.colwise()) { node.z() += 40.0 * node.z() * node.z(); }
  CHECK(grid_of(network).cells().size() == 8);
}

TEST("nodes anywhere are on no grid; every second plane of a grid has cells of twice the size") {
  SpringNetwork anywhere = block({5, 5, 5});
  std::srand(3);
  anywhere.rest_position += 0.002 * NodeVectors::Random(3, 125);
  anywhere.springs.edit([](std::vector<Spring>& all) {
    std::erase_if(all, [](const Spring& spring) { return spring.a == 62; });
  });
  anywhere.springs = SpringList(anywhere.springs.listed());  // nor are they a lattice
  CHECK(!CellGrid::of(anywhere));
  const SpringNetwork network = block({5, 5, 7});
  const CellGrid coarse = CellGrid::of(network)->thinned(2);
  CHECK(coarse.cells().size() == 2 * 2 * 3);
  CHECK_NEAR(enclosed_volume(exposed_faces(coarse), network.rest_position), 0.04 * 0.04 * 0.06,
             1e-17);
}

/// Nodes in a row along `direction`, 1 m apart, the last one fixed.
SpringNetwork row(const Eigen::Vector3d& direction, int nodes, double stiffness) {
  SpringNetwork network;
  network.rest_position.resize(3, nodes);
  for (int n = 0; n < nodes; ++n) { network.rest_position.col(n) = n * direction; }
  network.mass = Eigen::VectorXd::Ones(nodes);
  network.fixed.assign(static_cast<std::size_t>(nodes), 0);
  network.fixed.back() = 1;
  for (int n = 0; n + 1 < nodes; ++n) {
    network.springs.push_back({n, n + 1, stiffness, 7.0, 1.0});
  }
  return network;
}

TEST("inside a chain the principal force is the chain's tension, along the chain") {
  const Eigen::Vector3d direction = Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
  const SpringNetwork network = row(direction, 4, 50.0);
  for (const double stretch : {0.1, -0.1}) {
    const NodeVectors position = (1.0 + stretch) * network.rest_position;
    const ForceLines lines = force_lines(network, {}, position);
    const double tension = 50.0 * stretch;
    CHECK_NEAR(lines.line(3, 1), tension, 1e-5);        // single precision
    CHECK_NEAR(lines.line(3, 0), 0.5 * tension, 1e-5);  // one spring only
    CHECK_NEAR(std::abs(lines.line.col(2).head<3>().cast<double>().dot(direction)), 1.0, 1e-6);
    CHECK_NEAR(lines.held, Eigen::Vector3d(-tension * direction), 1e-12);
  }
}

TEST("the force furthest from zero is drawn, none at rest, and the printed sign as printed") {
  SpringNetwork bent = row(Eigen::Vector3d::UnitX(), 3, 10.0);
  bent.rest_position.col(2) << 1.0, 1.0, 0.0;
  NodeVectors position = bent.rest_position;
  position(0, 0) -= 0.1;  // pulls along x
  position(1, 2) -= 0.3;  // pushes along y
  const ForceLines lines = force_lines(bent, {}, position);
  CHECK_NEAR(lines.line(3, 1), -1.5, 1e-6);
  CHECK_NEAR(std::abs(lines.line(1, 1)), 1.0, 1e-6);
  const SpringNetwork network = row(Eigen::Vector3d::UnitX(), 3, 10.0);
  const NodeVectors& rest = network.rest_position;
  CHECK(force_lines(network, {}, rest).line.isZero(0.0F));
  CHECK(force_lines(network, {}, NodeVectors::Zero(3, 3)).line.isZero(0.0F));
  CHECK_NEAR(force_lines(network, SpringLaw::from({.sign = true}), 1.1 * rest).line(3, 1), -1.0,
             1e-6);
}

std::vector<std::uint8_t> inflated(const std::string& packed) {
  std::vector<std::uint8_t> bytes(1U << 20U);
  uLongf size = bytes.size();
  const int code =
      uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size());
  bytes.resize(code == Z_OK ? size : 0);
  return bytes;
}

TEST("base64 is that of RFC 4648, section 10, and deflated text is inflated to the same text") {
  const char* coded[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (std::size_t n = 0; n < 7; ++n) { CHECK(base64(std::string("foobar", n)) == coded[n]); }
  CHECK(base64(std::string("\xff\xfe\x00", 3)) == "//4A");
  std::string text;
  for (int n = 0; n < 5000; ++n) { text += static_cast<char>(n * n % 251); }
  const std::vector<std::uint8_t> back = inflated(deflate(text));
  CHECK(std::string(back.begin(), back.end()) == text);
}

TEST("differences lie in planes of bytes, the lowest first, and may be negative") {
  PackedBytes packed;
  packed.add_differences(std::array<std::int64_t, 3>{258, 257, 600}, 16);
  packed.add_differences(std::array<std::int64_t, 1>{0x01020304}, 32);
  packed.add_changes(std::array<std::int16_t, 2>{-3, 5}, std::array<std::int16_t, 2>{-1, -300});
  packed.add_bytes(std::array<std::uint8_t, 1>{9});
  const std::vector<std::uint8_t> expected{2, 255, 87, 1, 255, 1, 4, 3, 2, 1, 254, 49, 255, 1, 9};
  CHECK(inflated(packed.deflated()) == expected);
}

/// Lattice in synthetic motion.
struct ViewSample {
  Scene scene{};
  std::unique_ptr<NetworkProblem> problem{};
  Trace trace{};

  [[nodiscard]] std::optional<View> view() const { return make_view({scene, *problem, trace}); }
};

/// Block that is compressed at its middle by an increasing load, deeper in every frame.
ViewSample pressed_block(std::array<int, 3> nodes, int frames) {
  ViewSample sample;
  sample.scene.tissue.lattice = {
      .nodes = nodes, .spacing = 0.004, .weights = LatticeWeights::uniform, .node_mass = 1e-3};
  sample.scene.loads = {{.nodes = {0}, .force = {0.0, 0.0, 2.0}, .profile = Profile::constant}};
  const SpringNetwork network = build_network(sample.scene);
  for (int n = 0; n < frames; ++n) {
    NodeVectors position = network.rest_position;
    for (Eigen::Index node = 0; node < position.cols(); ++node) {
      if (network.is_fixed(static_cast<int>(node))) { continue; }
      const Eigen::Vector3d x = network.rest_position.col(node);
      position(2, node) +=
          1e-3 * n / frames * std::exp(-1e4 * x.head<2>().squaredNorm()) * std::exp(-60.0 * x.z());
      position(0, node) +=
          1e-4 * n / frames * std::sin(900.0 * x.y() + 31.0 * static_cast<double>(node));
    }
    sample.trace.frames.time.push_back(0.01 * n);
    sample.trace.frames.position.push_back(position);
    sample.trace.time.push_back(0.01 * n);
  }
  sample.problem = std::make_unique<NetworkProblem>(network, resolve_loads(sample.scene, network));
  return sample;
}

/// Layers of 12 mm with a body of another material in the last one, along z.
ViewSample layered_block(std::vector<Layer> layers) {
  ViewSample sample;
  sample.scene.tissue.source = Source::layers;
  sample.scene.tissue.block = {.nodes = {5, 5}, .spacing = 0.002};
  sample.scene.materials = {{.name = "a", .youngs_modulus = 1e3},
                            {.name = "b", .youngs_modulus = 2e3}};
  sample.scene.tissue.layers = std::move(layers);
  sample.scene.tissue.inclusions = {
      {Inclusion::Shape::box, {0.0, 0.0, 0.010}, {0.0041, 0.0041, 0.0041}, "a"}};
  const SpringNetwork network = build_network(sample.scene);
  sample.trace = {.time = {0.0}, .frames = {.time = {0.0}, .position = {network.rest_position}}};
  sample.problem = std::make_unique<NetworkProblem>(network);
  return sample;
}

TEST("a small network is shown whole, with its skin, springs, forces and largest reaction") {
  const ViewSample sample = pressed_block({6, 6, 5}, 7);
  const auto view = sample.view();
  REQUIRE(view);
  CHECK(view->rest == sample.problem->network().rest_position);
  CHECK(view->notes.empty());
  CHECK(view->springs.size() == sample.problem->network().springs.size());
  CHECK(std::accumulate(view->cell.begin(), view->cell.end(), 0) == 5 * 5 * 4);
  CHECK(view->surfaces.size() == 1);
  CHECK(view->surfaces[0].vertices.size() == 36);
  CHECK(view->surfaces[0].triangles.size() == 2 * 25);
  CHECK(view->frames.size() == 7);
  CHECK(view->peak == 6);
  CHECK_NEAR(view->frames[3].applied, 2.0, 1e-15);
  CHECK_NEAR(view->frames[4].displacement,
             NodeVectors(sample.trace.frames.position[4] - view->rest), 1e-18);
  CHECK(view->frames[6].reaction > view->frames[5].reaction);
  CHECK(view->frames[5].reaction > 0.0);
}

TEST("cells and nodes have the label of what fills them") {
  const auto view = layered_block({{"skin", "a", 0.004}, {"fat", "b", 0.008}}).view();
  REQUIRE(view);
  CHECK(view->labels == std::vector<std::string>({"skin", "fat", "a"}));
  std::vector<int> cells(3, 0);
  for (std::size_t n = 0; n < view->cell.size(); ++n) { cells[view->label[n]] += view->cell[n]; }
  // 4 x 4 cells a plane, 2 planes of skin and 4 of fat; the body fills 2 x 2 x 2 of these.
  CHECK(cells == std::vector<int>({32, 56, 8}));
}

TEST("nodes at a gap have the label of their own side") {
  const auto view = layered_block({{"skin", "a", 0.004},
                                   {.tissue = "air", .thickness = 0.004, .gap = true},
                                   {"fat", "b", 0.004}})
                        .view();
  REQUIRE(view);
  CHECK(view->labels == std::vector<std::string>({"skin", "fat", "a"}));
  std::vector<int> cells(3, 0);
  for (std::size_t n = 0; n < view->cell.size(); ++n) { cells[view->label[n]] += view->cell[n]; }
  CHECK(cells == std::vector<int>({32, 24, 8}));
}

TEST("frames are thinned to sixty with keyframes between; states that are not finite are absent") {
  ViewSample sample = pressed_block({3, 3, 3}, 200);
  sample.trace.keyframes.time = {0.0, 0.123};
  sample.trace.keyframes.position = {sample.trace.frames.position[0],
                                     sample.trace.frames.position[12]};
  const auto view = sample.view();
  CHECK(view->frames.size() == 61);
  CHECK(std::ranges::is_sorted(view->frames, {}, &ViewFrame::time));
  CHECK(std::ranges::count(view->frames, 0.123, &ViewFrame::time) == 1);
  CHECK(view->frames.front().time == 0.0);
  CHECK(view->frames.back().time == sample.trace.frames.time.back());
  sample = pressed_block({3, 3, 3}, 3);
  sample.trace.frames.position[2](1, 4) = std::nan("");
  CHECK(sample.view()->frames.size() == 2);
  sample.trace.frames.position.clear();
  CHECK(!sample.view());
}

TEST("a large block keeps its surface, its cut and what is near the tool, a larger one planes") {
  const ViewSample sample = pressed_block({40, 40, 40}, 1);
  const SpringNetwork& network = sample.problem->network();
  const ViewFocus focus{.end = {0.0, 0.0, 0.05}, .radius = 0.01};
  const ShownNodes shown = shown_nodes(network, focus, {});
  CHECK(shown.nodes.size() < static_cast<std::size_t>(most_nodes_shown));
  CHECK_CONTAINS(shown.note, "of 64");
  std::vector<std::uint8_t> is_shown(64000, 0);
  for (const int node : shown.nodes) { is_shown[static_cast<std::size_t>(node)] = 1; }
  for (int node = 0; node < 64000; ++node) {
    const GridPlace& place = shown.grid->places()[static_cast<std::size_t>(node)];
    const bool outer = std::ranges::any_of(place, [](int n) { return n == 0 || n == 39; });
    const Eigen::Vector3d x = network.rest_position.col(node);
    const bool near = x.head<2>().norm() < 0.006 && x.z() < 0.05;
    if (outer || near || std::abs(x.y()) < 0.003) {
      CHECK(is_shown[static_cast<std::size_t>(node)] == 1);
    }
  }
  // A block too large even for that is shown by every n-th plane.
  const SpringNetwork huge = uniform_lattice(
      {.nodes = {150, 150, 60}, .spacing = 0.001, .connectivity = 6}, 1.0, 0.0, 1e-3);
  const ShownNodes planes = shown_nodes(huge, {.cut = 0.0}, {7});
  CHECK(planes.nodes.size() <= static_cast<std::size_t>(most_nodes_shown) + 1);
  CHECK_CONTAINS(planes.note, "every 2nd plane");
  CHECK(std::ranges::find(planes.nodes, 7) != planes.nodes.end());
}

TEST("a given surface follows the nodes that it names and replaces the skin of the grid") {
  const ViewSample sample = pressed_block({3, 3, 3}, 2);
  const ViewSurface torso{.label = "torso",
                          .rest = NodeVectors::Zero(3, 3),
                          .vertices = {{{0, 0.5}, {1, 0.5}}, {{5, 1.0}}, {{8, 1.0}}},
                          .triangles = {{0, 1, 2}}};
  const auto view = make_view({sample.scene, *sample.problem, sample.trace, {torso}});
  CHECK(view->surfaces.size() == 1);
  CHECK(view->surfaces[0].label == "torso");
  CHECK(view->surfaces[0].vertices[1][0].node == 5);
}

/// A patch of skin 4 mm above a block of 20 mm, four times as wide.
ViewSample beneath_patch(int steps) {
  ViewSample sample = pressed_block({6, 6, 6}, 3);
  sample.scene.tissue.skin = std::make_shared<const Skin>(
      patch_surface({0.04, 0.04}, steps, [](double, double) { return -0.004; }), true);
  return sample;
}

TEST("the skin around the tissue is shown, and what lies within two spacings of it follows") {
  const ViewSample sample = beneath_patch(40);
  std::vector<std::string> notes;
  const auto skin = view_of_skin(sample.scene, notes);
  // 18 mm to either side: half the block and two spacings; and the squares that intersect the
  // border.
  REQUIRE(skin);
  CHECK(!skin->of_cells);
  CHECK(skin->triangles.size() >= 2 * 18 * 18);
  CHECK(skin->triangles.size() <= 2 * 20 * 20);
  REQUIRE(notes.size() == 1);
  CHECK_CONTAINS(notes[0], " of 3200 faces of the skin are shown");
  for (std::size_t n = 0; n < skin->vertices.size(); ++n) {
    const Eigen::Vector3d at = skin->rest.col(static_cast<Eigen::Index>(n));
    const double beside = (at.head<2>().cwiseAbs().array() - 0.01).max(0.0).matrix().norm();
    const bool near = std::hypot(beside, 0.004) <= 0.008 * (1.0 + 1e-9);
    CHECK(skin->vertices[n].empty() != near);
    double sum = 0.0;
    for (const ViewSurface::Support& support : skin->vertices[n]) { sum += support.weight; }
    CHECK_NEAR(sum, near ? 1.0 : 0.0, 1e-15);
  }
  const auto view = make_view({sample.scene, *sample.problem, sample.trace, {*skin}});
  REQUIRE(view);
  CHECK(view->surfaces.size() == 1);
  CHECK(view->surfaces[0].vertices.size() == skin->vertices.size());
  // The upper nodes are drawn on the skin, so that no gap is seen between them.
  CHECK_NEAR(view->rest.row(2).minCoeff(), -0.004, 1e-12);
  CHECK(std::ranges::any_of(view->notes, [](const std::string& note) {
    return note.starts_with("the upper nodes are drawn on the skin, at most ");
  }));
}

TEST("without a skin there is none to show, and one of too many faces is left out with a note") {
  std::vector<std::string> notes;
  CHECK(!view_of_skin(pressed_block({3, 3, 3}, 2).scene, notes));
  CHECK(notes.empty());
  CHECK(!view_of_skin(beneath_patch(400).scene, notes));
  REQUIRE(notes.size() == 1);
  CHECK_CONTAINS(notes[0], "the skin is not shown: ");
}

TEST("a page of ten thousand nodes with their springs at sixty instants stays below 5 MB") {
  const ViewSample sample = pressed_block({20, 20, 25}, 60);
  const auto view = sample.view();
  CHECK(view->rest.cols() == 10'000);
  CHECK(view->frames.size() == 60);
  CHECK(view->springs.size() > 100'000);
  CHECK(render({.parts = {view_section(*view)}}).size() + view_script().size() < 5'000'000);
}

TEST("too many numbers are made fewer by leaving out instants, and the page has a note") {
  const auto view = pressed_block({8, 8, 8}, 40).view();
  const EncodedView whole = encode(*view);
  CHECK(whole.notes.empty());
  const EncodedView fewer = encode(*view, whole.numbers.size() / 3);
  REQUIRE(fewer.notes.size() == 1);
  CHECK_CONTAINS(fewer.notes[0], "of 40 instants");
  const auto header = nlohmann::json::parse(fewer.header);
  CHECK(header["frames"].size() < 40);
  CHECK(header["frames"][header["peak"].get<std::size_t>()]["reaction"] ==
        view->frames[view->peak].reaction);
}

TEST("nothing in the page makes a request or ends a script") {
  ViewSample sample = pressed_block({3, 3, 3}, 2);
  sample.scene.tissue.lattice.material = "a </script><b>";
  const std::string html = render({.parts = {view_section(*sample.view())}});
  CHECK_LACKS(html, "src=", "url(", "@import", "a </script>", "<b>a");
  CHECK(html == render({.parts = {view_section(*sample.view())}}));
}

TEST("pictures for print show the tissues of the section at the cut and its displacement") {
  const auto view = pressed_block({6, 7, 5}, 3).view();
  const std::vector<Figure> figures = still_figures(*view);
  REQUIRE(figures.size() == 2);
  std::size_t nodes = 0;
  for (const Series& series : figures[0].series) { nodes += series.x.size(); }
  CHECK(nodes == 6 * 5);  // one plane of nodes normal to y
  REQUIRE(figures[1].heat_map);
  const double largest = view->frames[view->peak].displacement.colwise().norm().maxCoeff();
  const HeatMap& map = *figures[1].heat_map;
  CHECK(map.z.size() == map.x.size() * map.y.size());
  Largest shown;
  for (const double z : map.z) {
    if (!std::isnan(z)) { shown.add(z); }
  }
  CHECK(shown.value() <= 1e3 * largest * (1.0 + 1e-12));
  CHECK(shown.value() > 0.0);
  const Eigen::VectorXd x = 1e3 * view->rest.row(0).transpose();
  CHECK(map.x.front() <= x.minCoeff() + 1.0);  // [mm] a tenth of the spacing, for displacement
  CHECK(map.x.back() >= x.maxCoeff() - 1.0);
  CHECK_CONTAINS(figures[1].caption, "in the colour of their displacement");
  CHECK(*figures[0].y.minimum > *figures[0].y.maximum);  // the skin is above
}

TEST("a picture of nodes in one place, far from the origin, has few pixels") {
  auto view = pressed_block({3, 3, 3}, 2).view();
  view->rest.setZero();
  view->rest.row(0).setConstant(1e6);
  for (auto& frame : view->frames) { frame.displacement.setZero(); }
  const std::vector<Figure> figures = still_figures(*view);
  REQUIRE(figures.size() == 2);
  REQUIRE(figures[1].heat_map);
  CHECK(figures[1].heat_map->x.size() < 100);
  CHECK(figures[1].heat_map->y.size() < 100);
}

}  // namespace PALPATE_FILE
