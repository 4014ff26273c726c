// SPDX-License-Identifier: MIT
/// A network with a tool in it remembers forces that were looked at; no scheme may be able to tell.
#include <memory>

#include "model/dynamics/problem.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/network_system.hpp"
#include "model/stepping/tool_system.hpp"
#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"

namespace {

using namespace palpate;

constexpr double h = 2e-5;

/// A scene's tissue, tool and scheme, stepped by hand.
class Stage {
 public:
  Stage(const Scene& scene, const IntegratorInfo& scheme)
      : scheme_(scheme),
        problem_(make_problem(scene)),
        network_(make_network_system<double>(network_problem(), {.h = h, .matrices = scheme.implicit})),
        contact_(scene, network_problem(), network_->layout()),
        system_(*network_, contact_),
        integrator_(scheme.make<double>()) {
    const Eigen::Index dof = system_.dof();
    state_ = {Vector<double>::Zero(dof), Vector<double>::Zero(dof)};
    state_.position.head(network_->dof()) = network_->initial_position();
    if (contact_.is_coordinate()) { state_.position(dof - 1) = contact_.initial_place(); }
    contact_.begin(state_);
    integrator_->prepare(system_, state_, h);
    scratch_.setZero(dof);
  }
  void look() {
    const Vector<double>& v = t_ == 0.0 ? state_.velocity : integrator_->velocity_at(state_);
    energy_ = system_.measure(t_, load_gate(t_, h), state_.position, v, scratch_);
  }
  void step() {
    if (t_ == 0.0) { integrator_->start(system_, state_, 0.0, h); }
    if (contact_.begin_step(t_, h, state_, scheme_.implicit)) {
      system_.forget();
      ++jumps_;
    }
    integrator_->step(system_, state_, t_, h);
    t_ += h;
    contact_.end_step(t_, state_);
  }
  [[nodiscard]] const State<double>& state() const { return state_; }
  [[nodiscard]] int jumps() const { return jumps_; }
  /// Of the springs, as the look told and as the network tells [J].
  [[nodiscard]] double energy() const { return energy_; }
  [[nodiscard]] double energy_asked() const {
    return network_->energy(state_.position, Vector<double>::Zero(system_.dof()));
  }

 private:
  const NetworkProblem& network_problem() const { return dynamic_cast<const NetworkProblem&>(*problem_); }

  const IntegratorInfo& scheme_;
  std::unique_ptr<Problem> problem_;
  std::unique_ptr<NetworkSystem<double>> network_;
  ToolContact<double> contact_;
  ToolSystem<double> system_;
  std::unique_ptr<Integrator<double>> integrator_;
  State<double> state_;
  Vector<double> scratch_;
  double t_ = 0.0;
  double energy_ = 0.0;
  int jumps_ = 0;
};

void compare(const Scene& scene, int steps, int least_jumps) {
  for (const IntegratorInfo* scheme : integrators()) {
    Stage seen(scene, *scheme);
    Stage unseen(scene, *scheme);
    for (int n = 0; n < steps; ++n) {
      seen.look();
      CHECK_NEAR(seen.energy(), seen.energy_asked(), 1e-12 * seen.energy());
      seen.step();
      unseen.step();
    }
    CHECK(seen.state().position == unseen.state().position);
    CHECK(seen.state().velocity == unseen.state().velocity);
    CHECK(seen.energy() > 0.0);
    CHECK(seen.jumps() >= least_jumps);
  }
}

TEST("a look at the forces between steps changes no bit of what follows: a tool on a path") {
  Scene scene = layered_scene();
  scene.drive = Drive{.technique = Drive::Technique::intermittent, .speed = 0.02, .advance = 1e-4, .pause = 1e-3};
  compare(scene, 500, 3);
}

TEST("a look at the forces between steps changes no bit of what follows: a pushed tool") {
  Scene scene = layered_scene();
  scene.drive = Drive{.kind = Drive::Kind::force, .from = 0.0, .force = 2.0, .rise = 0.005};
  compare(scene, 500, 0);
}

}  // namespace
