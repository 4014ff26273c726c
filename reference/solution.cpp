// SPDX-License-Identifier: MIT

#include "reference/solution.hpp"

#include <array>
#include <bit>
#include <boost/version.hpp>
#include <cmath>
#include <cstdio>
#include <gsl/gsl_version.h>
#include <span>
#include <sundials/sundials_config.h>

namespace palpate::reference {

namespace {

/// Bytes of all added numbers, in order.
class Numbers {
 public:
  void add(double value) {
    const auto bytes = std::bit_cast<std::array<char, sizeof value>>(value);
    bytes_.append(bytes.data(), bytes.size());
  }
  void add(const Eigen::Ref<const Eigen::VectorXd>& values) {
    add(static_cast<double>(values.size()));
    for (const double value : values) { add(value); }
  }
  void add(std::span<const double> values) {
    add(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_{};
};

/// Adds forces and activation times at states around the start, which depend on all data of a
/// problem.
void add_probes(Numbers& numbers, const Problem& problem, const std::vector<double>& times) {
  const Eigen::VectorXd start = problem.initial_position();
  const Eigen::VectorXd velocity = problem.initial_velocity();
  Eigen::VectorXd q = start;
  Eigen::VectorXd v = velocity;
  Eigen::VectorXd f(problem.dof());
  for (int probe = 0; probe < 4; ++probe) {
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const double angle = 1.0 + 7.31 * static_cast<double>(i) + 3.7 * probe;
      q(i) = start(i) + (probe == 0 ? 0.0 : 1e-3 * std::cos(angle));
      v(i) = velocity(i) + (probe == 0 ? 0.0 : 1e-1 * std::sin(1.3 * angle));
    }
    const double t = times.back() * (0.13 + 0.29 * probe);
    problem.force(t, t, q, v, f);
    numbers.add(f);
    numbers.add(problem.energy(q, v));
  }
}

void add_network(Numbers& numbers, const NetworkProblem& problem) {
  for (const std::size_t count : {problem.network().springs.size(), problem.network().laws.size(),
                                  problem.network().cells.size(), problem.loads().size()}) {
    numbers.add(static_cast<double>(count));
  }
  for (const Spring& s : problem.network().springs) {
    numbers.add(std::array{static_cast<double>(s.a), static_cast<double>(s.b), s.stiffness,
                           s.viscosity, s.rest_length});
  }
  for (const MaterialLaw& law : problem.network().laws) {
    const Stiffening& s = law.stiffening;
    numbers.add(std::array{static_cast<double>(s.law), s.rate, s.quadratic, s.cubic, s.largest});
    for (const RelaxationBranch& b : law.branches) { numbers.add(std::array{b.share, b.time}); }
  }
  if (!problem.network().laws.empty()) {
    for (const Spring& s : problem.network().springs) { numbers.add(static_cast<double>(s.law)); }
    for (const VolumeCell& cell : problem.network().cells) {
      numbers.add(static_cast<double>(cell.law));
    }
  }
  for (const VolumeCell& cell : problem.network().cells) {
    for (const int node : cell.nodes) { numbers.add(static_cast<double>(node)); }
    numbers.add(std::array{cell.stiffness, cell.viscosity, cell.collapse, cell.volume});
  }
  for (const Load& load : problem.loads()) {
    numbers.add(load.start);
    numbers.add(load.end);
    numbers.add(static_cast<double>(load.profile));
    numbers.add(Eigen::VectorXd(load.force));
    numbers.add(static_cast<double>(load.nodes.size()));
    for (const int node : load.nodes) { numbers.add(static_cast<double>(node)); }
  }
  numbers.add(Eigen::VectorXd(problem.gravity()));
}

}  // namespace

std::string cache_key(const std::string& code, const std::string& solver, const Problem& problem,
                      const std::vector<double>& times, const Tolerance& tolerance) {
  Numbers numbers;
  numbers.add(problem.mass());
  numbers.add(problem.initial_position());
  numbers.add(problem.initial_velocity());
  numbers.add(problem.breaks());
  numbers.add(problem.shortest_feature());
  numbers.add(times);
  add_probes(numbers, problem, times);
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&problem)) {
    add_network(numbers, *network);
  }
  std::array<char, 160> settings{};
  std::snprintf(settings.data(), settings.size(),
                "rtol=%.17g position=%.17g velocity=%.17g dof=%ld", tolerance.relative,
                tolerance.position_scale, tolerance.velocity_scale,
                static_cast<long>(problem.dof()));
  return "solver=" + solver +
         " SUNDIALS=" SUNDIALS_VERSION " GSL=" GSL_VERSION " Boost=" BOOST_LIB_VERSION
         " format=2 " +
         settings.data() + " code=" + code + "\n" + numbers.bytes();
}

Trace solve_cached(const Cache* cache, const std::string& solver, Solver compute,
                   const Problem& problem, const std::vector<double>& times,
                   const Tolerance& tolerance) {
  if (cache == nullptr) { return compute(problem, times, tolerance); }
  const std::string key = cache_key(cache->code, solver, problem, times, tolerance);
  if (cache->load) {
    if (std::optional<Trace> kept = cache->load(key)) { return *std::move(kept); }
  }
  Trace solution = compute(problem, times, tolerance);
  if (cache->save) { cache->save(key, solution); }
  return solution;
}

}  // namespace palpate::reference
