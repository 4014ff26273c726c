// SPDX-License-Identifier: MIT

#include "reference/solution.hpp"

#include <array>
#include <bit>
#include <boost/version.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <gsl/gsl_version.h>
#include <span>
#include <sundials/sundials_config.h>

namespace palpate::reference {

namespace {

/// Hash of two FNV-1a sums with different offsets over all added bytes.
class Digest {
 public:
  void add(double value) {
    const auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof value>>(value);
    for (const std::uint8_t byte : bytes) {
      for (std::uint64_t& sum : sums_) { sum = (sum ^ byte) * 0x100000001b3ULL; }
      sums_[1] = std::rotl(sums_[1], 7);
    }
  }
  void add(const Eigen::Ref<const Eigen::VectorXd>& values) {
    add(static_cast<double>(values.size()));
    for (const double value : values) { add(value); }
  }
  void add(std::span<const double> values) {
    add(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  }
  [[nodiscard]] std::string text() const {
    std::array<char, 40> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%016llx%016llx",
                  static_cast<unsigned long long>(sums_[0]),
                  static_cast<unsigned long long>(sums_[1]));
    return buffer.data();
  }

 private:
  std::array<std::uint64_t, 2> sums_{0xcbf29ce484222325ULL, 0x9ae16a3b2f90404fULL};
};

/// Adds forces and activation times at states around the start, which depend on all data of a
/// problem.
void add_probes(Digest& digest, const Problem& problem, const std::vector<double>& times) {
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
    digest.add(f);
    digest.add(problem.energy(q, v));
  }
}

void add_network(Digest& digest, const NetworkProblem& problem) {
  for (const Spring& s : problem.network().springs) {
    digest.add(std::array{static_cast<double>(s.a), static_cast<double>(s.b), s.stiffness,
                          s.viscosity, s.rest_length});
  }
  for (const MaterialLaw& law : problem.network().laws) {
    const Stiffening& s = law.stiffening;
    digest.add(std::array{static_cast<double>(s.law), s.rate, s.quadratic, s.cubic, s.largest});
    for (const RelaxationBranch& b : law.branches) { digest.add(std::array{b.share, b.time}); }
  }
  if (!problem.network().laws.empty()) {
    for (const Spring& s : problem.network().springs) { digest.add(static_cast<double>(s.law)); }
    for (const VolumeCell& cell : problem.network().cells) {
      digest.add(static_cast<double>(cell.law));
    }
  }
  for (const VolumeCell& cell : problem.network().cells) {
    for (const int node : cell.nodes) { digest.add(static_cast<double>(node)); }
    digest.add(std::array{cell.stiffness, cell.viscosity, cell.collapse, cell.volume});
  }
  for (const Load& load : problem.loads()) {
    digest.add(load.start);
    digest.add(load.end);
    digest.add(static_cast<double>(load.profile));
    digest.add(Eigen::VectorXd(load.force));
    for (const int node : load.nodes) { digest.add(static_cast<double>(node)); }
  }
  digest.add(Eigen::VectorXd(problem.gravity()));
}

}  // namespace

std::string cache_key(const std::string& solver, const Problem& problem,
                      const std::vector<double>& times, const Tolerance& tolerance) {
  Digest digest;
  digest.add(problem.mass());
  digest.add(problem.initial_position());
  digest.add(problem.initial_velocity());
  digest.add(problem.breaks());
  digest.add(problem.shortest_feature());
  digest.add(times);
  add_probes(digest, problem, times);
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&problem)) {
    add_network(digest, *network);
  }
  std::array<char, 160> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "rtol=%.17g position=%.17g velocity=%.17g dof=%ld",
                tolerance.relative, tolerance.position_scale, tolerance.velocity_scale,
                static_cast<long>(problem.dof()));
  return "solver=" + solver +
         " SUNDIALS=" SUNDIALS_VERSION " GSL=" GSL_VERSION " Boost=" BOOST_LIB_VERSION
         " format=1 " +
         numbers.data() + " problem=" + digest.text();
}

Trace solve_cached(const Cache* cache, const std::string& solver, Solver compute,
                   const Problem& problem, const std::vector<double>& times,
                   const Tolerance& tolerance) {
  if (cache == nullptr || !cache->load) { return compute(problem, times, tolerance); }
  const std::string key = cache_key(solver, problem, times, tolerance);
  if (std::optional<Trace> kept = cache->load(key)) { return *std::move(kept); }
  Trace solution = compute(problem, times, tolerance);
  if (cache->save) { cache->save(key, solution); }
  return solution;
}

}  // namespace palpate::reference
