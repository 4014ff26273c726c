// SPDX-License-Identifier: MIT
/// What reaches the hand of a force that was asked for, through the drivers that users have.
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "device/falcon/driver_profile.hpp"
#include "validation/cases/haptic_rig.hpp"

namespace palpate::haptics {

namespace {

using namespace device::falcon;

/// The pull of arms at rest once the currents have settled, frame of the device [N].
Eigen::Vector3d delivered(DriverProfile& profile, const Kinematics& kinematics,
                          const Eigen::Vector3d& place, const Eigen::Vector3d& force) {
  const Command command = profile.words(place, force);
  const Eigen::Vector3d torque = torque_of_words(MotorOptions{}, command.sent);
  return kinematics.jacobian(place)->transpose().inverse() * torque;
}

/// Most that one word less in every motor takes from a force at this place [N].
double worth_of_words(const Kinematics& kinematics, const Eigen::Vector3d& place) {
  const Eigen::Matrix3d force_of_torque = kinematics.jacobian(place)->transpose().inverse();
  return force_of_torque.cwiseAbs().rowwise().sum().norm() / MotorOptions{}.words_per_newton_metre;
}

constexpr double gentle = 3.0;  // [N] within reach everywhere on the needle's way
const Eigen::Vector3d outward = Eigen::Vector3d::UnitZ();

void along_the_way(const Kinematics& kinematics, Outcome& outcome) {
  CorrectProfile correct(kinematics);
  StockProfile stock;
  Figure figure{.id = "over-depth",
                .title = "3 N asked for against the insertion",
                .caption = "What the motors pull with along the needle's way through the workspace.",
                .x = {.label = "place of the grip, z (mm)"},
                .y = {.label = "delivered (N)"}};
  Series through_correct{.label = "correct"};
  Series through_stock{.label = "stock"};
  double error = 0.0;
  double least = unbounded;
  double largest = 0.0;
  for (double z = 0.095; z < 0.1551; z += 0.0025) {
    const Eigen::Vector3d place(0.0, 0.0, z);
    const Eigen::Vector3d right = delivered(correct, kinematics, place, gentle * outward);
    const Eigen::Vector3d wrong = delivered(stock, kinematics, place, gentle * outward);
    error = std::max(error, (right - gentle * outward).norm() / worth_of_words(kinematics, place));
    const double ratio = wrong.z() / gentle;
    least = std::min(least, ratio);
    largest = std::max(largest, ratio);
    through_correct.x.push_back(1e3 * z);
    through_correct.y.push_back(right.z());
    through_stock.x.push_back(1e3 * z);
    through_stock.y.push_back(wrong.z());
  }
  figure.series = {std::move(through_correct), std::move(through_stock)};
  outcome.figures.push_back(std::move(figure));
  outcome.judge({.name = "largest_error_of_the_correct_driver_in_words", .value = error, .upper = 1.0,
                 .bound_from = "theory: words are cut to whole ones, one at most in each motor"});
  const double scale = libnifalcon_scale / martin_hillier_scale;
  const std::string source = "published: wrong z column of the Jacobian, 1.37 at z 95 mm to 1.16 at 155 mm on "
                             "the axis, times 10,000 over 6,616 words per N m";
  outcome.judge({.name = "least_gain_of_the_stock_driver", .value = least, .lower = 1.155 * scale,
                 .bound_from = source + ", to half a unit of the last digit"});
  outcome.judge({.name = "largest_gain_of_the_stock_driver", .value = largest, .upper = 1.375 * scale,
                 .bound_from = source + ", to half a unit of the last digit"});
}

void over_force(const Kinematics& kinematics, Outcome& outcome) {
  CorrectProfile correct(kinematics);
  StockProfile stock;
  const Eigen::Vector3d place(0.0, 0.0, 0.125);
  Figure figure{.id = "over-force",
                .title = "What a growing force becomes in the middle of the workspace",
                .caption = "Along the needle. The correct driver stops at the motors' limit; the stock one asks "
                           "for more, and where its words leave 16 bits the force turns round.",
                .x = {.label = "asked for (N)"},
                .y = {.label = "delivered (N)"}};
  Series through_correct{.label = "correct"};
  Series through_stock{.label = "stock"};
  double back = 0.0;
  double forward = 0.0;
  for (int n = 0; n <= 280; ++n) {
    const double force = 0.5 * n;
    const double right = delivered(correct, kinematics, place, force * outward).z();
    const double wrong = delivered(stock, kinematics, place, force * outward).z();
    back = std::min(back, wrong);
    forward = std::min(forward, right);
    through_correct.x.push_back(force);
    through_correct.y.push_back(right);
    through_stock.x.push_back(force);
    through_stock.y.push_back(wrong);
  }
  figure.series = {std::move(through_correct), std::move(through_stock)};
  outcome.figures.push_back(std::move(figure));
  outcome.judge({.name = "the_correct_driver_never_turns_a_force_round", .value = forward, .unit = "N",
                 .lower = 0.0, .bound_from = "theory: words are clamped"});
  outcome.judge({.name = "the_stock_driver_does", .value = back, .unit = "N", .upper = -1.0,
                 .bound_from = "its words wrap at 32768: shown, so that the emulator is known to have it"});
}

void measure_profiles(const CaseContext&, Outcome& outcome) {
  const Kinematics kinematics;
  along_the_way(kinematics, outcome);
  over_force(kinematics, outcome);
}

}  // namespace

std::vector<Case> profile_cases() {
  return {{.name = "haptics/falcon/profiles",
           .suite = "haptics",
           .claim = "Through a correct driver the hand gets what was asked for, through the common open one "
                    "up to twice as much, and beyond 16 bits the opposite.",
           .measure = measure_profiles,
           .weight = 0.1}};
}

}  // namespace palpate::haptics
