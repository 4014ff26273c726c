// SPDX-License-Identifier: MIT

#include "validation/subject/falcon_loop.hpp"

#include <algorithm>

#include "device/falcon/kinematics.hpp"
#include "validation/outcome.hpp"

namespace palpate {

namespace {

FalconDrive settings_of(const Scene& scene) { return scene.falcon.value_or(FalconDrive{}); }
Drive drive_of(const Scene& scene) { return scene.drive.value_or(Drive{}); }

/// Upper bound of the depth if the drive specifies none.
double way_in(const Scene& scene, const Drive& drive) {
  if (drive.depth) { return *drive.depth - drive.from; }
  return drive.speed * (scene.simulation.duration + 1.0);
}

void add_advance(const Scene& scene, const Drive& drive, device::IntentScript& script) {
  const double distance = way_in(scene, drive);
  if (drive.technique == Drive::Technique::continuous) {
    script.actions.emplace_back(device::Advance{.distance = distance, .speed = drive.speed});
    return;
  }
  script.actions.emplace_back(
      device::Intermittent{.distance = distance,
                           .step = {drive.advance, drive.advance},
                           .rest = {drive.pause, drive.pause},
                           .duration = 1.875 * drive.advance / drive.speed});
}

}  // namespace

Eigen::Vector3d grip_start(const Scene& scene) {
  return {0.0, 0.0, settings_of(scene).start_height - drive_of(scene).from};
}

device::falcon::EmulatedFalconOptions falcon_options(const Scene& scene) {
  const FalconDrive settings = settings_of(scene);
  device::falcon::EmulatedFalconOptions options;
  options.body.geometry = settings.geometry == FalconDrive::Geometry::martin_hillier
                              ? device::falcon::martin_hillier()
                              : device::falcon::libnifalcon();
  options.body.start = grip_start(scene);
  options.body.seed = static_cast<std::uint64_t>(settings.seed);
  options.body.plant.gravity = 0.0;  // the hand compensates it, see docs/falcon.md
  options.body.motors.supply_power = settings.supply_power;
  options.body.motors.thermal_time = settings.thermal_time;
  options.body.motors.continuous_power = settings.continuous_power;
  if (!settings.friction) {
    options.body.plant.coulomb = 0.0;
    options.body.plant.viscosity = 0.0;
  }
  options.stock_profile = settings.profile == FalconDrive::Profile::stock;
  options.wire = settings.quantised;
  return options;
}

device::Hand hand_of(const Scene& scene) {
  const FalconDrive settings = settings_of(scene);
  const Drive drive = drive_of(scene);
  device::Hand hand;
  switch (settings.hand) {
    case FalconDrive::Hand::light: hand.impedance = device::light_hand; break;
    case FalconDrive::Hand::medium: break;
    case FalconDrive::Hand::firm: hand.impedance = device::firm_hand; break;
    case FalconDrive::Hand::two_stage: hand.arm = device::arm_stage; break;
  }
  if (settings.hand_stiffness) {
    hand.impedance.viscosity *= std::sqrt(*settings.hand_stiffness / hand.impedance.stiffness);
    hand.impedance.stiffness = *settings.hand_stiffness;
  }
  device::IntentScript script{.start = grip_start(scene),
                              .reaction = {settings.reaction_delay, settings.reaction_delay},
                              .tremor = settings.tremor,
                              .seed = static_cast<std::uint64_t>(settings.seed)};
  if (drive.start > 0.0) { script.actions.emplace_back(device::Hold{drive.start}); }
  add_advance(scene, drive, script);
  if (drive.withdraw_speed > 0.0) {
    if (drive.hold > 0.0) { script.actions.emplace_back(device::Hold{drive.hold}); }
    script.actions.emplace_back(
        device::Withdraw{.distance = way_in(scene, drive), .speed = drive.withdraw_speed});
  }
  hand.intent = device::Intent(script);
  return hand;
}

namespace {

constexpr double velocity_cutoff = 100.0;  // [Hz] of the low pass on differences of counts
constexpr double pi = 3.14159265358979323846;

double larger(double a, double b) noexcept {
  Largest largest(a);
  largest.add(b);
  return largest.value();
}

device::falcon::EmulatedFalconOptions with_faults(device::falcon::EmulatedFalconOptions options,
                                                  const device::falcon::FaultScript& faults) {
  options.faults = faults;
  return options;
}

}  // namespace

FalconLoop::FalconLoop(const Scene& scene, Subject& subject, const FalconLoopOptions& options)
    : settings_(scene.falcon.value_or(FalconDrive{})),
      subject_(subject),
      period_(1.0 / settings_.rate),
      ticks_per_step_(static_cast<int>(std::lround(scene.simulation.step * settings_.rate))),
      falcon_(with_faults(falcon_options(scene), options.faults), hand_of(scene)),
      servo_(falcon_, settings_.delay + options.extra_delay),
      controller_(period_, 0.5 * falcon_.hand().impedance.mass / period_),
      start_(grip_start(scene)),
      start_place_(subject.tool_motion().place),
      place_(start_),
      velocity_share_(settings_.quantised ? 1.0 - std::exp(-2.0 * pi * velocity_cutoff * period_)
                                          : 1.0) {
  const auto legs = falcon_.body().plant().mechanics().kinematics().legs(start_);
  const device::falcon::MotorOptions motors = falcon_options(scene).body.motors;
  const Eigen::Matrix3d jacobian = device::falcon::jacobian(*legs);
  facts_.weakest_force = device::falcon::weakest_force(motors, jacobian);
  facts_.axial_force = device::falcon::largest_force(motors, jacobian, Eigen::Vector3d::UnitZ());
  constexpr int directions = 2000;  // Fibonacci spiral
  for (int n = 0; n < directions; ++n) {
    const double z = 1.0 - (2.0 * n + 1.0) / directions;
    const double angle = pi * (3.0 - std::sqrt(5.0)) * n;
    const double across = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d along(across * std::cos(angle), across * std::sin(angle), z);
    facts_.force_reach.emplace_back(device::falcon::largest_force(motors, jacobian, along) * along);
  }
  facts_.reaction = falcon_.hand().intent.reaction();
  falcon_.observe(options.observer);
  watch_tool();  // a tip that begins on the skin is in contact already
}

StepStatus FalconLoop::tick() noexcept {
  StepStatus status = StepStatus::ok;
  do {
    if (clock_ != nullptr) { clock_->wait(); }
    status = device_tick();
  } while (ticks_of_step_ > 0);
  return status;
}

StepStatus FalconLoop::device_tick() noexcept {
  const double time = device_time();
  servo_.tick([&](const device::DeviceSample& sample) { return render(sample, time); });
  if (ticks_of_step_ == 0) { input_ = {start_place_ + start_.z() - place_.z(), -velocity_.z()}; }
  facts_.saturated += falcon_.saturated() ? 1 : 0;
  facts_.largest_requested = larger(facts_.largest_requested, servo_.sent().norm());
  return finish_device_tick();
}

StepStatus FalconLoop::missed_device_tick() noexcept { return finish_device_tick(); }

StepStatus FalconLoop::finish_device_tick() noexcept {
  ++facts_.ticks;
  falcon_.run_until(device_time() + period_);
  facts_.largest_delivered =
      larger(facts_.largest_delivered, falcon_.body().delivered_force().norm());
  if (++ticks_of_step_ < ticks_per_step_) { return StepStatus::ok; }
  ticks_of_step_ = 0;
  const StepStatus status = subject_.step(input_);
  input_.reset();
  watch_tool();
  return status;
}

/// The tool axis is -z of the device: a coupling that pushes the tool in pushes the hand out.
Eigen::Vector3d FalconLoop::render(const device::DeviceSample& sample, double time) noexcept {
  if (!sample.answered) { ++facts_.unanswered; }
  if (!sample.homed) {  // its counts do not give the position of the grip
    ++facts_.unhomed;
    velocity_.setZero();
    return Eigen::Vector3d::Zero();
  }
  observer_.observe(time, sample.position, servo_.sent());
  estimate_velocity(sample.position);
  const ToolMotion tool = subject_.tool_motion();
  const bool ahead = settings_.between == FalconDrive::Between::extrapolate;
  const double reached = tool.place + (ahead ? tool.velocity * (time - subject_.time()) : 0.0);
  const double held = start_place_ + start_.z() - place_.z();
  const double push = settings_.coupling_stiffness * (held - reached) +
                      settings_.coupling_viscosity * (-velocity_.z() - tool.velocity);
  Eigen::Vector3d force(guide(0, velocity_.x()), guide(1, velocity_.y()), push);
  if (settings_.passivity_controller) {
    force = controller_.limit(observer_.energy(), velocity_, force);
  }
  return force;
}

/// Tissue prevents sideways motion of the needle: the coupling keeps the grip on the line of its
/// entry.
double FalconLoop::guide(int axis, double velocity) const noexcept {
  if (!in_tissue_) { return 0.0; }
  return -settings_.coupling_stiffness * (place_(axis) - entry_(axis)) -
         settings_.coupling_viscosity * velocity;
}

void FalconLoop::estimate_velocity(const Eigen::Vector3d& place) noexcept {
  velocity_ += velocity_share_ * ((place - place_) / period_ - velocity_);
  place_ = place;
}

void FalconLoop::watch_tool() noexcept {
  const double tip = subject_.tool_motion().place;
  for (const ToolHappening& happening : subject_.tool_happenings()) {
    if (happening.event == ToolEvent::contact) {
      in_tissue_ = true;
      entry_ = place_.head<2>();
    }
    if (happening.event == ToolEvent::withdrawn) { in_tissue_ = false; }
    if (happening.event == ToolEvent::loss_of_resistance && !facts_.lost_resistance_at) {
      facts_.lost_resistance_at = happening.time;
      falcon_.hand().intent.loss_of_resistance(happening.time);
      deepest_ = tip;
    }
  }
  if (facts_.lost_resistance_at) { facts_.overshoot = larger(facts_.overshoot, tip - deepest_); }
}

std::vector<Column> FalconLoop::columns() {
  return {{"device.x_m", "m", {}},         {"device.y_m", "m", {}},
          {"device.z_m", "m", {}},         {"device.requested_n", "N", {}},
          {"device.delivered_n", "N", {}}, {"device.saturated", "1", {}},
          {"device.intent_m", "m", {}},    {"device.energy_j", "J", {}}};
}

void FalconLoop::sample(std::span<double> row) const noexcept {
  const device::falcon::PlantBody& body = falcon_.body();
  const Eigen::Vector3d place = body.plant().position();
  const double intent = body.hand().intent.at(body.plant().time()).position.z();
  std::ranges::copy(
      std::initializer_list<double>{place.x(), place.y(), place.z(), servo_.sent().norm(),
                                    body.delivered_force().norm(), falcon_.saturated() ? 1.0 : 0.0,
                                    start_place_ + start_.z() - intent, observer_.energy()},
      row.begin());
}

FalconFacts FalconLoop::facts() const noexcept {
  FalconFacts facts = facts_;
  facts.least_energy = observer_.least();
  facts.least_energy_at = observer_.least_at();
  facts.taken_by_controller = controller_.taken();
  return facts;
}

}  // namespace palpate
