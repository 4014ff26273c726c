// SPDX-License-Identifier: MIT
#include <cstdio>

#include "device/falcon/encoders.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors.hpp"
#include "device/falcon/packet.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/number_text.hpp"
#include "fixtures/io/pose_csv.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"

namespace palpate::cli {
namespace {

namespace falcon = device::falcon;

constexpr std::string_view header =
    "theta1_1_rad,theta1_2_rad,theta1_3_rad,count_1,count_2,count_3,forward_x_m,forward_y_m,"
    "forward_z_m,torque_1_nm,torque_2_nm,torque_3_nm,word_1,word_2,word_3,packet\n";

/// What the device makes of one pose: angles and torques at the pose itself, the position that its
/// whole counts stand for, the words of the torques.
struct Solution {
  Eigen::Vector3d theta1{};
  falcon::Counts counts{};
  Eigen::Vector3d forward{};
  Eigen::Vector3d torque{};
  falcon::Words words{};
};

std::optional<Solution> solve(const falcon::Kinematics& kinematics, const io::Pose& pose) {
  const auto angles = kinematics.inverse(pose.position);
  const auto jacobian = kinematics.jacobian(pose.position);
  if (!angles || !jacobian) { return std::nullopt; }
  Solution solution{.theta1 = angles->theta1};
  solution.counts = falcon::counts_of_angles(kinematics.geometry(), angles->theta1);
  const Eigen::Vector3d rounded = falcon::angles_of_counts(kinematics.geometry(), solution.counts);
  const auto forward = kinematics.forward(rounded);
  if (!forward) { return std::nullopt; }
  solution.forward = *forward;
  const Eigen::Vector3d torque = falcon::torque_of_force(*jacobian, pose.force);
  solution.torque = torque.array() + 0.0;  // no negative zero
  solution.words = falcon::words_of_torque({}, solution.torque).sent;
  return solution;
}

template <class Values>
void append(std::string& text, const Values& values) {
  for (const auto value : values) {
    io::append_number(text, static_cast<double>(value));
    text += ',';
  }
}

std::string row(const Solution& solution) {
  std::string text;
  append(text, solution.theta1);
  append(text, solution.counts);
  append(text, solution.forward);
  append(text, solution.torque);
  append(text, solution.words);
  for (const std::uint8_t byte : falcon::encode(falcon::HostPacket{.words = solution.words})) {
    text += static_cast<char>(byte);  // printable: markers and nibbles alone
  }
  return text + '\n';
}

}  // namespace

int falcon_solve(const FalconOptions& options) {
  const falcon::Kinematics kinematics;
  io::Problems problems;
  std::string text(header);
  const auto within_reach = [&](const Eigen::Vector3d& position) -> std::string_view {
    const bool reached = solve(kinematics, {.position = position}).has_value();
    return reached ? "" : "must be within the reach of all three legs";
  };
  const std::vector<io::Pose> poses = io::read_pose_csv(options.solve, within_reach, problems);
  problems.throw_if_any();
  for (const io::Pose& pose : poses) { text += row(*solve(kinematics, pose)); }
  const std::filesystem::path folder = make_folder(options.folder("falcon"));
  io::replace_file(folder / "solution.csv", text);
  if (!options.quiet) {
    std::printf("%zu poses: %s\n", poses.size(), (folder / "solution.csv").string().c_str());
  }
  return done;
}

}  // namespace palpate::cli
