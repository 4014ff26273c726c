// SPDX-License-Identifier: MIT
#include "reference/needle_track.hpp"

#include <numeric>

#include "tests/reference/insertion_samples.hpp"
#include "reference/hand_motion.hpp"
#include "tests/check.hpp"

using namespace palpate;
using namespace palpate::reference;

namespace {

NeedleTrack track_of(const Scene& scene) { return needle_track(scene, build_network(scene)); }

double at(const std::vector<HandPiece>& hand, double time) {
  double value = 0.0;
  for (const HandPiece& piece : hand) {
    if (piece.start <= time) { value = piece.at(time); }
  }
  return value;
}

}  // namespace

TEST("an oblique line meets each plane of a lattice, and its knots' mean place is on the line") {
  Scene scene = sample::block_scene(5, {{0.02, 0.1, 1.0}}, {});
  scene.needle->entry = {0.0012, -0.0007};
  scene.needle->direction = {0.2, 0.1, 1.0};
  const SpringNetwork network = build_network(scene);
  const NeedleTrack track = needle_track(scene, network);
  CHECK(track.knots.size() == 5);
  for (const TrackKnot& knot : track.knots) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const TrackSupport& support : knot.supports) {
      mean += support.weight * network.rest_position.col(support.node);
    }
    const Eigen::Vector3d on_line =
        Eigen::Vector3d(0.0012, -0.0007, 0.0) + knot.depth * track.direction;
    CHECK_NEAR(mean, on_line, 1e-15);
  }
}

TEST("planes beside which the line passes have no knot") {
  Scene scene = sample::block_scene(5, {{0.02, 0.1, 1.0}}, {});
  scene.needle->direction = {1.0, 0.0, 1.0};
  CHECK(track_of(scene).knots.size() == 3);
}

TEST("layers along an oblique needle are longer, and the last one goes on") {
  Scene scene = sample::block_scene(5, {{0.01, 0.1, 1.0}, {0.01, 0.2, 2.0}}, {});
  scene.needle->direction = {0.6, 0.0, 0.8};
  const NeedleTrack track = track_of(scene);
  CHECK(track.intervals.size() == 2);
  CHECK_NEAR(track.intervals[0].end, 0.0125, 1e-16);
  CHECK(std::isinf(track.intervals[1].end));
}

TEST("the last inclusion that holds a point wins, by its exact shape") {
  Scene scene = sample::block_scene(5, {{0.03, 0.1, 1.0}}, {});
  scene.materials.push_back({.name = "cyst", .youngs_modulus = 1e3, .cutting_force = 0.4});
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e4});
  scene.tissue.inclusions = {
      {Inclusion::Shape::sphere, {0.003, 0.0, 0.01}, {0.01, 0.0, 0.0}, "cyst"},
      {Inclusion::Shape::box, {0.0, 0.0, 0.014}, {0.004, 0.004, 0.004}, "bone"}};
  const NeedleTrack track = track_of(scene);
  const std::vector<double> begins{0.0, 0.006, 0.012, 0.016};
  const std::vector<std::string> labels{"layer 0", "cyst", "bone", "layer 0"};
  CHECK(track.intervals.size() == begins.size());
  for (std::size_t n = 0; n < std::min(begins.size(), track.intervals.size()); ++n) {
    CHECK_NEAR(track.intervals[n].begin, begins[n], 1e-16);
    CHECK(track.intervals[n].label == labels[n]);
  }
  CHECK_NEAR(track.bone, 0.012, 1e-16);
}

TEST("shares of friction are the integrals of f times the hat functions") {
  const Scene scene = sample::needle_scene(sample::Chain{}.network(),
                                           {{0.012, 0.1, 10.0}, {0.01, 0.1, 30.0}}, {});
  const NeedleTrack track = track_of(scene);
  for (const double depth : {0.004, 0.011, 0.013, 0.024, 0.037}) {
    const Eigen::VectorXd shares =
        track.friction_shares(track.segment_at(depth), track.interval_at(depth), depth);
    CHECK_NEAR(shares.sum(), 10.0 * std::min(depth, 0.012) + 30.0 * std::max(depth - 0.012, 0.0),
               1e-15);
    double moment = 0.0;
    for (Eigen::Index i = 0; i < shares.size(); ++i) { moment += shares(i) * 0.01 * double(i); }
    const double upper = std::min(depth, 0.012);
    const double expected = 5.0 * upper * upper +
                            (depth > 0.012 ? 15.0 * (depth * depth - 0.012 * 0.012) : 0.0);
    CHECK_NEAR(moment, expected, 1e-16);  // hat functions meet xi itself exactly
  }
}

TEST("a round probe loads nodes by the area of its footprint in their cells") {
  Scene scene = sample::block_scene(5, {{0.02, 0.1, 1.0}}, {});
  scene.needle.reset();
  scene.probe = Probe{.size = {0.01, 0.01}};
  const NeedleTrack track = track_of(scene);
  CHECK(track.knots.size() == 1);
  double centre = 0.0;
  double sum = 0.0;
  for (const TrackSupport& support : track.knots[0].supports) {
    sum += support.weight;
    if (support.node == 12) { centre = support.weight; }
  }
  CHECK_NEAR(sum, 1.0, 1e-14);
  constexpr double disc = 3.14159265358979 * 0.005 * 0.005;  // the centre's cell lies within it
  CHECK_NEAR(centre, 0.005 * 0.005 / disc, 1e-6);
}

TEST("an intermittent trajectory advances, pauses, ends at its depth and comes back") {
  const Drive drive{.technique = Drive::Technique::intermittent, .start = 0.1, .from = -0.001,
                    .speed = 0.01, .advance = 0.002, .pause = 0.3, .depth = 0.004, .hold = 0.5,
                    .withdraw_speed = 0.02};
  const auto hand = hand_motion(drive, 10.0);
  const std::vector<std::pair<double, double>> places{
      {0.05, -0.001}, {0.2, 0.0}, {0.3, 0.001}, {0.59, 0.001}, {0.7, 0.002}, {0.8, 0.003},
      {1.2, 0.004},   {1.69, 0.004}, {1.8, 0.002}, {1.95, -0.001}, {5.0, -0.001}};
  for (const auto& [time, place] : places) { CHECK_NEAR(at(hand, time), place, 1e-12); }
}

TEST("a force rises, pushes and pauses, and is reversed after its hold") {
  const Drive drive{.kind = Drive::Kind::force, .technique = Drive::Technique::intermittent,
                    .start = 0.1, .pause = 0.3, .hold = 1.1, .force = 4.0, .rise = 0.4,
                    .push = 0.2, .withdraw_force = 1.0};
  const auto hand = hand_motion(drive, 10.0);
  const std::vector<std::pair<double, double>> forces{{0.05, 0.0}, {0.3, 2.0},  {0.6, 4.0},
                                                      {0.8, 0.0},  {1.1, 4.0},  {1.3, 0.0},
                                                      {1.55, 4.0}, {1.65, -1.0}, {9.0, -1.0}};
  for (const auto& [time, force] : forces) { CHECK_NEAR(at(hand, time), force, 1e-12); }
}
