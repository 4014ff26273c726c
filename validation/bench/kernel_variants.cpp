// SPDX-License-Identifier: MIT

#include "validation/bench/kernel_variants.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string_view>
#include <thread>
#include <vector>

#include "model/kernels/lattice_network.hpp"
#include "model/kernels/lattice_rows.hpp"
#include "model/kernels/network_system.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/step_plan.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/text.hpp"

namespace palpate::bench {

namespace {

constexpr Precision single = Precision::single_precision;

constexpr std::array<KernelVariant, 12> variants{
    {{.name = "lattice, double"},
     {.name = "lattice, float", .precision = single},
     {.name = "lattice, own stiffness, double", .uneven = true},
     {.name = "lattice, own stiffness, float", .precision = single, .uneven = true},
     {.name = "lattice, undamped, double", .damped = false},
     {.name = "lattice, undamped, float", .precision = single, .damped = false},
     {.name = "lattice, own stiffness, undamped, double", .uneven = true, .damped = false},
     {.name = "lattice, own stiffness, undamped, float",
      .precision = single,
      .uneven = true,
      .damped = false},
     {.name = "list, double", .lattice = false},
     {.name = "list, float", .precision = single, .lattice = false},
     {.name = "list, undamped, double", .lattice = false, .damped = false},
     {.name = "list, undamped, float", .precision = single, .lattice = false, .damped = false}}};

double nodes(int n) { return std::pow(n, 3); }

double size_of_number(const KernelVariant& variant) {
  return static_cast<double>(variant.in_double() ? sizeof(double) : sizeof(float));
}

/// Numbers of its springs that a node has for itself.
double constants_per_node(const KernelVariant& variant) {
  if (!variant.uneven) { return 0.0; }
  return lattice::slots * (variant.damped ? 2.0 : 1.0);
}

NetworkProblem problem_of(const KernelVariant& variant, int n) {
  const Scene scene = s26_scene(n);
  SpringNetwork network = build_network(scene);
  long place = 0;
  network.springs.change_each([&](Spring& spring) {
    // Golden ratio: spread evenly between 0.75 and 1.25, no two alike.
    const double share = 0.618033988749895 * static_cast<double>(place++);
    if (variant.uneven) { spring.stiffness *= 0.75 + 0.5 * (share - std::floor(share)); }
    if (!variant.damped) { spring.viscosity = 0.0; }
  });
  if (!variant.lattice) { break_lattice(network); }
  const std::vector<Load> loads = resolve_loads(scene, network);
  return NetworkProblem(std::move(network), loads);
}

constexpr double h = 1e-3;  ///< [s]

template <class Real>
std::unique_ptr<NetworkSystem<Real>> system_of(const NetworkProblem& problem,
                                               const KernelVariant& variant) {
  if (variant.instructions == nullptr) {
    return make_network_system<Real>(
        problem, {.h = h, .lattice = variant.lattice, .threads = variant.threads});
  }
  const std::vector<lattice::Kernels<Real>> kernels = lattice_kernels<Real>();
  const std::string_view name = variant.instructions;
  const auto wanted =
      std::ranges::find_if(kernels, [&](const auto& set) { return set.name == name; });
  return make_lattice_network<Real>(problem, {.threads = variant.threads, .kernels = *wanted});
}

/// State of a kernel that is stepped.
template <class Real> struct SteppedKernel {
  SteppedKernel(const KernelVariant& variant, int n)
      : problem(problem_of(variant, n)),
        system(system_of<Real>(problem, variant)),
        state{system->initial_position(), system->initial_velocity()},
        integrator(find_integrator("euler-cromer")->make<Real>()) {
    integrator->prepare(*system, state, h);
    integrator->start(*system, state, 0.0, h);
  }

  NetworkProblem problem;
  std::unique_ptr<NetworkSystem<Real>> system;
  State<Real> state;
  std::unique_ptr<Integrator<Real>> integrator;
  long steps = 0;
};

template <class Real> Stepping stepping_in(const KernelVariant& variant, int n) {
  const auto kernel = std::make_shared<SteppedKernel<Real>>(variant, n);
  const auto step = [kernel](long times) {
    for (long k = 0; k < times; ++k) {
      kernel->integrator->step(*kernel->system, kernel->state,
                               h * static_cast<double>(kernel->steps++), h);
    }
  };
  return {.step = step, .springs = static_cast<double>(kernel->system->spring_count())};
}

}  // namespace

void break_lattice(SpringNetwork& network) {
  const double distance = (network.rest_position.col(2) - network.rest_position.col(0)).norm();
  network.springs.push_back({0, 2, 1e-9, 0.0, distance});
}

std::span<const KernelVariant> kernel_variants() { return variants; }

std::span<const KernelVariant> largest_variants() { return std::span(variants).first(4); }

Stepping stepping_of(const KernelVariant& variant, int n) {
  return variant.in_double() ? stepping_in<double>(variant, n) : stepping_in<float>(variant, n);
}

double bytes_moved(const KernelVariant& variant, int n) {
  constexpr double read_and_written = 2.0 * 3.0 * 3.0;
  constexpr double inverse_mass = 1.0;
  return (read_and_written + inverse_mass + constants_per_node(variant)) * size_of_number(variant) *
         nodes(n);
}

double working_set(const KernelVariant& variant, int n) {
  return (3.0 * 3.0 + 1.0 + constants_per_node(variant)) * size_of_number(variant) * nodes(n);
}

template <class Real> std::function<void(long times)> roots_and_quotients() {
  std::vector<Real> from(roots_at_once);
  for (std::size_t n = 0; n < from.size(); ++n) {
    from[n] = static_cast<Real>(1.0 + 1e-3 * static_cast<double>(n % 997));
  }
  return [from, to = from,
          limit = lattice_kernels<Real>().front().roots_and_quotients](long times) mutable {
    for (long n = 0; n < times; ++n) { limit(from.data(), to.data(), roots_at_once); }
  };
}
template std::function<void(long times)> roots_and_quotients<double>();
template std::function<void(long times)> roots_and_quotients<float>();

std::function<void(long times)> vector_update(double bytes) {
  const std::vector<double> zeros(static_cast<std::size_t>(bytes / (2.0 * sizeof(double))), 0.0);
  return [a = zeros, b = std::vector<double>(zeros.size(), 1.0)](long times) mutable {
    for (long time = 0; time < times; ++time) {
      const double x = 1e-9 * static_cast<double>(time);
      for (std::size_t n = 0; n < a.size(); ++n) { a[n] += x * b[n]; }
    }
  };
}

double side_by_side_slowdown(const std::function<void()>& mine,
                             const std::function<void()>& other) {
  const Contender alone{"alone", [&](long) { mine(); }, Clock::wall};
  const Contender together{"together",
                           [&](long) {
                             std::thread second(other);
                             mine();
                             second.join();
                           },
                           Clock::wall};
  const std::vector<Timed> timed = time_interleaved({alone, together}, {.rounds = 9, .batch = 0.0});
  return timed[1].median / timed[0].median;
}

double side_by_side_slowdown() {
  constexpr long times = 4000;  // some 20 ms
  const auto mine = roots_and_quotients<double>();
  const auto other = roots_and_quotients<double>();
  return side_by_side_slowdown([&] { mine(times); }, [&] { other(times); });
}

}  // namespace palpate::bench
