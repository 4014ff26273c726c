// SPDX-License-Identifier: MIT
#include "validation/bench/model_runs.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/list_network.hpp"
#include "model/stepping/simulation.hpp"
#include "reference/insertion.hpp"
#include "reference/solvers.hpp"
#include "validation/bench/interleaved.hpp"
#include "validation/insertion.hpp"

namespace palpate::bench {

namespace {

class QuickProblem final : public Problem {
 public:
  explicit QuickProblem(const NetworkProblem& plain)
      : plain_(plain), system_(plain, {}, 1.0, true), q_(plain.dof()), v_(plain.dof()), f_(plain.dof()) {}
  [[nodiscard]] Eigen::Index dof() const override { return plain_.dof(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return plain_.mass(); }
  [[nodiscard]] Eigen::VectorXd initial_position() const override { return plain_.initial_position(); }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override { return plain_.initial_velocity(); }
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::Ref<Eigen::VectorXd> f) const override {
    q_ = q;
    v_ = v;
    system_.force(t, gate, q_, v_, f_);
    f = f_;
  }
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q, const Eigen::Ref<const Eigen::VectorXd>& v,
                Eigen::SparseMatrix<double>& stiffness, Eigen::SparseMatrix<double>& damping) const override {
    plain_.jacobian(q, v, stiffness, damping);
  }
  [[nodiscard]] std::vector<double> breaks() const override { return plain_.breaks(); }
  [[nodiscard]] double shortest_feature() const override { return plain_.shortest_feature(); }
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override {
    return plain_.energy(q, v);
  }

 private:
  const NetworkProblem& plain_;
  mutable ListNetwork<double> system_;
  mutable Eigen::VectorXd q_, v_, f_;
};

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// Implicit schemes evaluate once an iteration at least.
long evaluations_of(std::string_view scheme, long steps) {
  return steps * find_integrator(scheme)->evaluations;
}

}  // namespace

std::vector<double> instants_of(const Scene& scene) {
  std::vector<double> times;
  const long count = std::lround(scene.simulation.duration / scene.simulation.step);
  for (long n = 0; n <= count; ++n) { times.push_back(static_cast<double>(n) * scene.simulation.step); }
  return times;
}

PointScene::PointScene(const CaseContext& context, const Scene& scene, int node)
    : context_(context), plain_(make_problem(scene)), instants_(instants_of(scene)) {
  const auto* network = dynamic_cast<const NetworkProblem*>(plain_.get());
  if (network == nullptr) { return; }
  quick_ = std::make_unique<QuickProblem>(*network);
  first_ = network->coordinate(node);
  count_ = 3;
}

PointScene::~PointScene() = default;

Run PointScene::here(const Scene& scene) const {
  const Motion motion = simulate(context_, scene, nullptr, {.energy = true});
  const std::string scheme(Simulation(scene).plan().integrator->name);
  return {.tool = motion.position.middleRows(first_, count_),
          .position = motion.position,
          .energy = vector_of(motion.energy),
          .seconds = motion.seconds,
          .evaluations = evaluations_of(scheme, motion.steps),
          .failed = motion.diverged};
}

Run PointScene::there(const std::string& solver, const reference::Tolerance& tolerance) const {
  Run run;
  try {
    const double begin = seconds_on(Clock::processor);
    const auto solution =
        reference::solver_named(solver).solve(quick_ ? *quick_ : *plain_, instants_, tolerance);
    const double busy = seconds_on(Clock::processor) - begin;
    run = {.tool = solution.position.middleRows(first_, count_),
           .position = solution.position,
           .seconds = std::min(busy, solution.seconds),
           .evaluations = solution.evaluations};
    run.energy.resize(solution.position.cols());
    for (Eigen::Index n = 0; n < run.energy.size(); ++n) {
      run.energy(n) = plain_->energy(solution.position.col(n), solution.velocity.col(n));
    }
  } catch (const reference::SolverError&) { run.failed = true; }
  return run;
}

Run needle_here(const CaseContext& context, const Scene& scene) {
  const Insertion insertion = insert_tool(context, scene, {.motion = true});
  Run run{.tool = Eigen::MatrixXd(1, static_cast<Eigen::Index>(insertion.tool.size())),
          .position = insertion.position,
          .energy = vector_of(insertion.energy),
          .seconds = insertion.seconds,
          .failed = insertion.diverged};
  for (Eigen::Index n = 0; n < run.tool.cols(); ++n) {
    run.tool(0, n) = insertion.tool[static_cast<std::size_t>(n)].forces.total;
  }
  const long ticks = static_cast<long>(insertion.tool.size()) - 1;
  run.evaluations = evaluations_of(insertion.integrator, ticks * insertion.substeps);
  return run;
}

NeedleReference needle_there(const Scene& scene, double tolerance) {
  const std::vector<double> times = instants_of(scene);
  const SpringNetwork network = build_network(scene);
  const double begin = seconds_on(Clock::processor);
  const reference::Insertion solved =
      reference::solve_insertion(scene, network, times, {.relative = tolerance});
  const double busy = seconds_on(Clock::processor) - begin;
  const auto count = static_cast<Eigen::Index>(times.size());
  NeedleReference found;
  found.run = {.tool = Eigen::MatrixXd(1, count),
               .position = Eigen::MatrixXd(solved.instants.front().position.size(), count),
               .energy = Eigen::VectorXd(count),
               .seconds = std::min(busy, solved.seconds),
               .evaluations = solved.evaluations};
  for (Eigen::Index n = 0; n < count; ++n) {
    const reference::InsertionInstant& instant = solved.instants[static_cast<std::size_t>(n)];
    found.run.tool(0, n) = instant.total;
    found.run.position.col(n) = instant.position;
    found.run.energy(n) = instant.energy.stored;
    found.jumps.push_back(std::ranges::any_of(solved.events, [&](const reference::InsertionEvent& event) {
      return event.kind != reference::InsertionEvent::Kind::knot_passed &&
             std::abs(instant.time - event.time) <= 2.0 * scene.simulation.step;
    }));
  }
  return found;
}

}  // namespace palpate::bench
