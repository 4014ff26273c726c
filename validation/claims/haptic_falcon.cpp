// SPDX-License-Identifier: MIT
/// Scenes with a hand on the emulated Falcon, and their runs.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "device/falcon/driver.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/haptic_loop.hpp"
#include "validation/case.hpp"
#include "validation/claims/haptic_fixture.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/roll_out.hpp"
#include "validation/subject/falcon_loop.hpp"

namespace palpate::haptics {

struct Held {
  Trace run{};
  FalconFacts facts{};
};

Held hold(const CaseContext& context, Scene scene) {
  Held held;
  held.run = roll_out(context, std::move(scene), {}, {.falcon = &held.facts});
  return held;
}

Scene chain_in_hand(bool quick, double stiffness) {
  Scene scene = tools::chain_scene({.stiffness = stiffness});
  scene.materials = {tools::tissue_of("tough", 1.0, 1000.0, 0.0)};
  scene.tissue.layers = {{"tough", "tough", 0.05}};
  scene.drive = Drive{.kind = Drive::Kind::falcon, .speed = 0.03, .depth = 0.003};
  scene.falcon = FalconDrive{.quantised = false, .friction = false};
  scene.simulation = {
      .duration = quick ? 0.3 : 1.0, .step = 1e-3, .substeps = 40, .integrator = "velocity-verlet"};
  return scene;
}

// Falcon in the loop: comparison with a continuous solution between ticks, insertion by hand
// through the layers, and energy at the port.

namespace {

reference::HeldTool reference_of(const Scene& scene, const device::Intent& intent) {
  const device::falcon::EmulatedFalconOptions options = falcon_options(scene);
  const device::falcon::Geometry& g = options.body.geometry;
  const device::Hand hand = hand_of(scene);
  const FalconDrive& falcon = *scene.falcon;
  reference::HeldTool held;
  held.legs = {.arm = g.thigh,
               .shin = g.shin,
               .link = g.link_offset(),
               .radial = g.radial_offset(),
               .base_lateral = g.base_lateral,
               .effector_lateral = g.effector_lateral,
               .azimuth = g.azimuth};
  held.grip_mass =
      options.body.plant.effector_mass + options.body.plant.tool_mass + hand.impedance.mass;
  held.arm_inertia = options.body.plant.arm_inertia;
  held.hand_stiffness = hand.impedance.stiffness;
  held.hand_viscosity = hand.impedance.viscosity;
  held.motor_lag = options.body.motors.time_constant;
  held.coupling_stiffness = falcon.coupling_stiffness;
  held.coupling_viscosity = falcon.coupling_viscosity;
  held.tool_mass = scene.needle->mass;
  held.period = 1.0 / falcon.rate;
  held.delay = falcon.delay;
  held.start = grip_start(scene);
  held.intent = [&intent](double time, Eigen::Vector3d& place, Eigen::Vector3d& velocity) {
    const device::IntentPoint point = intent.at(time);
    place = point.position;
    velocity = point.velocity;
  };
  return held;
}

void measure_reference(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "held-tool",
                .title = "A hand presses a chain through the device",
                .caption =
                    "Way of the grip and of the tool, and what CVODE makes of hand, device "
                    "and chain between the same ticks.",
                .x = {.label = "time (s)"},
                .y = {.label = "way (mm)"}};
  for (const int delay : {0, 1}) {
    Scene scene = chain_in_hand(context.quick, 1e4);  // all ten as stiff as the hand
    scene.falcon->delay = delay;
    const Held held = hold(context, scene);
    const device::Intent intent = hand_of(scene).intent;
    const long ticks = std::lround(scene.simulation.duration / scene.simulation.step);
    const reference::HeldToolMotion truth = reference::solve_held_tool(
        reference_of(scene, intent), build_network(scene), ticks,
        {.relative = 1e-10, .position_scale = 1e-3, .velocity_scale = 1e-2});
    const Trace& trace = held.run;
    const auto column = [&](const char* name) -> const std::vector<double>& {
      return trace.find(name)->values;
    };
    double grip = column("device.z_m").size() == truth.time.size() ? 0.0 : std::nan("");
    double tool = grip;
    Series way{.label = "grip"};
    Series tip{.label = "tool"};
    Series exact{.label = "CVODE", .style = Series::Style::dashed};
    for (std::size_t n = 0; n < truth.time.size() && n < trace.time.size(); ++n) {
      const double z = column("device.z_m")[n];
      const double s = column("tool.insertion_m")[n];
      const double off =
          Eigen::Vector3d(column("device.x_m")[n] - truth.grip[n].x(),
                          column("device.y_m")[n] - truth.grip[n].y(), z - truth.grip[n].z())
              .norm();
      const double tool_off = std::abs(s - truth.place[n]);
      grip = std::isnan(off) ? off : std::max(grip, off);
      tool = std::isnan(tool_off) ? tool_off : std::max(tool, tool_off);
      way.x.push_back(truth.time[n]);
      way.y.push_back(1e3 * (truth.grip.front().z() - z));
      tip.x.push_back(truth.time[n]);
      tip.y.push_back(1e3 * s);
      exact.x.push_back(truth.time[n]);
      exact.y.push_back(1e3 * truth.place[n]);
    }
    const std::string late = delay == 0 ? "" : "_one_tick_late";
    const std::string bound =
        "asked for: a micrometre over the run; steps of 25 us and 50 us leave less";
    outcome.judge({.name = "largest_error_of_the_grip" + late,
                   .value = grip,
                   .unit = "m",
                   .upper = 1e-6,
                   .bound_from = bound});
    outcome.judge({.name = "largest_error_of_the_tool" + late,
                   .value = tool,
                   .unit = "m",
                   .upper = 1e-6,
                   .bound_from = bound});
    if (delay == 0) { figure.series = {std::move(way), std::move(tip), std::move(exact)}; }
  }
  outcome.figures.push_back(std::move(figure));
}

/// Layers of needle cases with the fat thickness of the four groups of the trial (skin to epidural
/// space 17.80 + 0.978 BMI, Ravi et al. 2011; fixtures/scenes/epidural-bmi-*.toml).
struct Group {
  const char* name;
  double fat;  ///< [m]
};
constexpr Group groups[] = {
    {"BMI 22", 0.0048}, {"BMI 30", 0.0126}, {"BMI 40", 0.0224}, {"BMI 47", 0.0293}};
constexpr double hand_speed = 0.02;  // [m/s]

Scene layers_in_hand(double fat, Drive::Technique technique) {
  Scene scene = tools::seven_soft_layers(0.005, 4);
  scene.tissue.layers[1].thickness = fat;
  scene.drive = Drive{.kind = Drive::Kind::falcon,
                      .technique = technique,
                      .from = -0.002,
                      .speed = hand_speed,
                      .advance = 0.003,
                      .pause = 0.3,
                      .depth = 0.12};
  scene.falcon = FalconDrive{.hand = FalconDrive::Hand::firm, .start_height = 0.165};
  const double way = fat + 0.03;
  const double pauses = technique == Drive::Technique::intermittent ? 0.65 * way / 0.003 : 0.0;
  scene.simulation = {.duration = 1.0 + way / hand_speed + pauses, .step = 1e-3};
  return scene;
}

Series force_over_depth(const Trace& trace, const std::string& label) {
  Series series{.label = label};
  const std::vector<double>& depth = trace.find("tool.depth_m")->values;
  const std::vector<double>& force = trace.find("device.delivered_n")->values;
  for (std::size_t n = 0; n < depth.size(); ++n) {
    series.x.push_back(1e3 * depth[n]);
    series.y.push_back(force[n]);
  }
  return series;
}

void measure_groups(const CaseContext& context, Outcome& outcome) {
  Table table{
      .id = "groups",
      .title = "The same hand through four bodies",
      .columns = {"group", "technique", "loss of resistance (mm deep)", "overshoot (mm)",
                  "asked for (N)", "delivered (N)", "saturated ticks (%)", "fed in at most (mJ)"}};
  Figure figure{.id = "groups",
                .title = "Force on the hand over depth",
                .caption =
                    "What the motors pull the hand with, continuous advance; layers of "
                    "needle cases, a hundredth of published forces of ligament.",
                .x = {.label = "tip depth (mm)"},
                .y = {.label = "force (N)"}};
  double arrived = 0.0;
  double asked = 0.0;
  double worst = 0.0;
  for (const Group& group : groups) {
    for (const auto technique : {Drive::Technique::continuous, Drive::Technique::intermittent}) {
      const bool continuous = technique == Drive::Technique::continuous;
      if (context.quick && !continuous) { continue; }
      const Held held = hold(context, layers_in_hand(group.fat, technique));
      asked += 1.0;
      double depth = std::nan("");
      if (held.facts.lost_resistance_at && !held.run.diverged) {
        const auto tick =
            static_cast<std::size_t>(std::lround(*held.facts.lost_resistance_at / 1e-3));
        depth = held.run.find("tool.depth_m")->values[tick];
        arrived += 1.0;
      }
      const double border = 0.0144 + group.fat;
      worst = std::isnan(depth) ? depth : std::max(worst, std::abs(depth - border));
      table.rows.push_back({std::string(group.name),
                            std::string(continuous ? "continuous" : "intermittent"), 1e3 * depth,
                            1e3 * held.facts.overshoot, held.facts.largest_requested,
                            held.facts.largest_delivered,
                            100.0 * static_cast<double>(held.facts.saturated) /
                                static_cast<double>(held.facts.ticks),
                            -1e3 * held.facts.least_energy});
      if (continuous) { figure.series.push_back(force_over_depth(held.run, group.name)); }
    }
  }
  outcome.judge({.name = "share_that_arrives",
                 .value = arrived / asked,
                 .lower = 1.0,
                 .bound_from = "the hand's intent lies far beyond the epidural space"});
  outcome.judge({.name = "largest_error_of_its_depth",
                 .value = worst,
                 .unit = "m",
                 .upper = 5e-4,
                 .bound_from =
                     "theory: the border is dented by the flavum's 1.2 N over its modulus times "
                     "the spacing, 500 kPa x 5 mm"});
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

void measure_overshoot(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "overshoot",
                .title = "Overshoot by reaction delay",
                .caption =
                    "How far the tip goes beyond the loss of resistance, by the delay after "
                    "which the hand answers; 20 mm/s, firm hand.",
                .x = {.label = "reaction delay (ms)"},
                .y = {.label = "overshoot (mm)"}};
  Series series{.label = "through the Falcon", .style = Series::Style::line_and_points};
  double least_rise = unbounded;
  double largest_rise = 0.0;
  double swing = 0.0;
  for (const double delay : {0.0, 0.05, 0.1, 0.15, 0.2}) {
    Scene scene = layers_in_hand(groups[0].fat, Drive::Technique::continuous);
    scene.tissue.layers[5].thickness = 0.02;  // room behind the flavum
    scene.falcon->reaction_delay = delay;
    const Held held = hold(context, scene);
    const double overshoot = held.facts.lost_resistance_at ? held.facts.overshoot : std::nan("");
    if (!series.y.empty()) {
      const double rise = overshoot - 1e-3 * series.y.back();
      least_rise = std::isnan(rise) ? rise : std::min(least_rise, rise);
      largest_rise = std::isnan(rise) ? rise : std::max(largest_rise, rise);
    }
    swing = std::max(swing, held.facts.largest_delivered / hand_of(scene).impedance.stiffness);
    series.x.push_back(1e3 * delay);
    series.y.push_back(1e3 * overshoot);
  }
  outcome.judge({.name = "least_rise_by_50_ms",
                 .value = least_rise,
                 .unit = "m",
                 .lower = 0.0,
                 .bound_from = "the claim itself"});
  outcome.judge({.name = "largest_rise_by_50_ms",
                 .value = largest_rise,
                 .unit = "m",
                 .upper = hand_speed * 0.05 + swing,
                 .bound_from =
                     "theory: the intent goes on at 20 mm/s; the hand swings about it by the "
                     "force that falls away over its stiffness"});
  figure.series.push_back(std::move(series));
  outcome.figures.push_back(std::move(figure));
}

void measure_passivity(const CaseContext& context, Outcome& outcome) {
  // Three ticks late, and stiffer than a light hand can hold then: active.
  Scene scene = chain_in_hand(false, 5e4);
  scene.simulation.substeps = 100;
  scene.falcon->hand = FalconDrive::Hand::light;
  scene.falcon->delay = 3;
  scene.falcon->coupling_stiffness = 6000.0;
  scene.falcon->coupling_viscosity = 5.0;
  Figure figure{.id = "port-energy",
                .title = "Energy at the port, with and without controller",
                .caption =
                    "A stiff coupling three ticks late feeds energy in; the controller damps it "
                    "as soon as the observer goes below zero.",
                .x = {.label = "time (s)"},
                .y = {.label = "energy (mJ)"}};
  for (const bool controlled : {false, true}) {
    scene.falcon->passivity_controller = controlled;
    const Held held = hold(context, scene);
    const std::vector<double>& energy = held.run.find("device.energy_j")->values;
    Series series{.label = controlled ? "with controller" : "without"};
    double fed = 0.0;
    for (std::size_t n = 0; n < energy.size(); ++n) {
      if (n > 0) { fed = std::max(fed, energy[n - 1] - energy[n]); }
      series.x.push_back(held.run.time[n]);
      series.y.push_back(1e3 * energy[n]);
    }
    figure.series.push_back(std::move(series));
    const double blind = (scene.falcon->delay + 2) * fed;
    outcome.judge({.name = controlled ? "least_energy_with_controller" : "least_energy_without",
                   .value = held.facts.least_energy,
                   .unit = "J"});
    Quantity shortage{.name = controlled ? "shortage_with_controller" : "shortage_without",
                      .value = -held.facts.least_energy / blind};
    if (controlled) {
      shortage.upper = 1.0;
      shortage.bound_from =
          "theory: what can be fed in before the controller's damping arrives, the "
          "delay and two ticks at the most that any tick fed in";
    } else {
      shortage.lower = 1.0;
      shortage.bound_from = "the same amount: without the controller it goes on";
    }
    outcome.judge(shortage);
  }
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> falcon_cases() {
  return {
      {.name = "haptics/falcon/reference",
       .suite = "haptics",
       .claim = "Hand, device, coupling and tool move as CVODE moves them between the same "
                "ticks.",
       .measure = measure_reference,
       .weight = 3.0},
      {.name = "haptics/falcon/groups",
       .suite = "haptics",
       .claim = "By hand through the Falcon the needle arrives in the epidural space of all four "
                "groups, with either technique.",
       .measure = measure_groups,
       .weight = 5.0},
      {.name = "haptics/falcon/overshoot",
       .suite = "haptics",
       .claim = "The later the hand answers a loss of resistance, the further the needle goes.",
       .measure = measure_overshoot,
       .weight = 2.0},
      {.name = "haptics/falcon/passivity",
       .suite = "haptics",
       .claim = "Where a rendering feeds energy in the observer says how much, and the "
                "controller takes it back.",
       .measure = measure_passivity,
       .weight = 1.0}};
}

// Force at the hand compared with the requested force, through the available drivers.

namespace {

using namespace device::falcon;

/// The pull of arms at rest once the currents have settled, frame of the device [N].
Eigen::Vector3d delivered(DriverProfile& profile, const Kinematics& kinematics,
                          const Eigen::Vector3d& place, const Eigen::Vector3d& force) {
  const Command command = profile.words(place, force);
  const Eigen::Vector3d torque = torque_of_words(MotorOptions{}, command.sent);
  return kinematics.jacobian(place)->transpose().inverse() * torque;
}

/// Returns the largest change of a force at this position if every motor word decreases by one [N].
double worth_of_words(const Kinematics& kinematics, const Eigen::Vector3d& place) {
  const Eigen::Matrix3d force_of_torque = kinematics.jacobian(place)->transpose().inverse();
  return force_of_torque.cwiseAbs().rowwise().sum().norm() / MotorOptions{}.words_per_newton_metre;
}

constexpr double gentle = 3.0;  // [N] within reach everywhere on the needle's way
const Eigen::Vector3d outward = Eigen::Vector3d::UnitZ();

void along_the_way(const Kinematics& kinematics, Outcome& outcome) {
  CorrectProfile correct(kinematics);
  StockProfile stock;
  Figure figure{
      .id = "over-depth",
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
  outcome.judge({.name = "largest_error_of_the_correct_driver_in_words",
                 .value = error,
                 .upper = 1.0,
                 .bound_from = "theory: words are cut to whole ones, one at most in each motor"});
  const double scale = libnifalcon_scale / martin_hillier_scale;
  const std::string source =
      "published: wrong z column of the Jacobian, 1.37 at z 95 mm to 1.16 at 155 mm on "
      "the axis, times 10,000 over 6,616 words per N m";
  outcome.judge({.name = "least_gain_of_the_stock_driver",
                 .value = least,
                 .lower = 1.155 * scale,
                 .bound_from = source + ", to half a unit of the last digit"});
  outcome.judge({.name = "largest_gain_of_the_stock_driver",
                 .value = largest,
                 .upper = 1.375 * scale,
                 .bound_from = source + ", to half a unit of the last digit"});
}

void over_force(const Kinematics& kinematics, Outcome& outcome) {
  CorrectProfile correct(kinematics);
  StockProfile stock;
  const Eigen::Vector3d place(0.0, 0.0, 0.125);
  Figure figure{
      .id = "over-force",
      .title = "What a growing force becomes in the middle of the workspace",
      .caption =
          "Along the needle. The correct driver stops at the motors' limit; the stock one asks "
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
  outcome.judge({.name = "the_correct_driver_never_turns_a_force_round",
                 .value = forward,
                 .unit = "N",
                 .lower = 0.0,
                 .bound_from = "theory: words are clamped"});
  outcome.judge(
      {.name = "the_stock_driver_does",
       .value = back,
       .unit = "N",
       .upper = -1.0,
       .bound_from = "its words wrap at 32768: shown, so that the emulator is known to have it"});
}

void measure_profiles(const CaseContext&, Outcome& outcome) {
  const Kinematics kinematics;
  along_the_way(kinematics, outcome);
  over_force(kinematics, outcome);
}

}  // namespace

std::vector<Case> profile_cases() {
  return {
      {.name = "haptics/falcon/profiles",
       .suite = "haptics",
       .claim =
           "Through a correct driver the hand gets what was asked for, through the common open one "
           "up to twice as much, and beyond 16 bits the opposite.",
       .measure = measure_profiles,
       .weight = 0.1}};
}

}  // namespace palpate::haptics
