// SPDX-License-Identifier: MIT
/// The bounds from which automatic substeps are chosen, against exact spectra of random networks.
#include <algorithm>
#include <cmath>

#include "model/dynamics/problem.hpp"
#include "model/stepping/spectral_bounds.hpp"
#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

/// Masses, stiffness and viscosity over `decades`; some nodes fixed; rest lengths off by up to 60
/// %.
SpringNetwork random_network(std::uint64_t seed, double decades) {
  Random random(seed);
  constexpr int nodes = 16;
  constexpr int springs = 60;
  const auto spread = [&](double largest) {
    return largest * std::pow(10.0, -random(0.0, decades));
  };
  SpringNetwork network;
  network.rest_position = NodeVectors::NullaryExpr(3, nodes, [&] { return random(-0.01, 0.01); });
  network.mass = Eigen::VectorXd::NullaryExpr(nodes, [&] { return spread(1e-2); });
  network.fixed.assign(nodes, 0);
  for (std::size_t n = 0; n < seed % 4; ++n) { network.fixed[5 * n] = 1; }
  for (int n = 0; n < springs; ++n) {
    const int b = n + 1 < nodes ? n + 1 : static_cast<int>(random(1.0, nodes));
    const int a = static_cast<int>(random(0.0, b));
    const double length = (network.rest_position.col(b) - network.rest_position.col(a)).norm();
    network.springs.push_back({a, b, spread(1e4), spread(1.0), length * (1.0 + random(-0.6, 0.6))});
  }
  return network;
}

struct Ratios {
  Series estimate{.label = "power iteration", .style = Series::Style::points};
  Series upper{.label = "guaranteed bound, frequency", .style = Series::Style::points};
  Series damping{.label = "guaranteed bound, damping", .style = Series::Style::points};
};

Ratios ratios_of(int networks) {
  Ratios ratios;
  for (int n = 0; n < networks; ++n) {
    const double decades = 6.0 * n / (networks - 1);
    const SpringNetwork network = random_network(static_cast<std::uint64_t>(n) + 1, decades);
    const Spectrum truth = spectrum_of(network);
    const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
    const double omega = truth.omega.maxCoeff();
    for (Series* series : {&ratios.estimate, &ratios.upper, &ratios.damping}) {
      series->x.push_back(decades);
    }
    ratios.estimate.y.push_back(bounds.omega_estimate / omega);
    ratios.upper.y.push_back(bounds.omega_upper / omega);
    ratios.damping.y.push_back(bounds.damping_upper / truth.damping_maximum);
  }
  return ratios;
}

void draw(Ratios ratios, Outcome& outcome) {
  Figure figure{.id = "ratios",
                .title = "Bounds over exact values",
                .caption =
                    "Random networks of 16 nodes and 60 springs: the estimate must stay "
                    "below 1 and the guaranteed bounds above it.",
                .x = {.label = "spread of mass, stiffness and viscosity (decades)"},
                .y = {.label = "bound / exact value (1)"}};
  figure.series = {
      std::move(ratios.estimate),
      std::move(ratios.upper),
      std::move(ratios.damping),
      {.label = "exact", .style = Series::Style::dashed, .x = {0.0, 6.0}, .y = {1.0, 1.0}}};
  outcome.figures.push_back(std::move(figure));
}

void measure(const CaseContext& context, Outcome& outcome) {
  Ratios ratios = ratios_of(context.quick ? 60 : 400);
  const auto [low_estimate, high_estimate] = std::ranges::minmax(ratios.estimate.y);
  const auto [low_upper, high_upper] = std::ranges::minmax(ratios.upper.y);
  const auto [low_damping, high_damping] = std::ranges::minmax(ratios.damping.y);
  const char* exact = "exact eigenvalues of the assembled matrices";
  outcome.judge({.name = "largest estimate over true frequency",
                 .value = high_estimate,
                 .upper = 1.0 + 1e-9,
                 .bound_from = exact});
  outcome.judge({.name = "smallest estimate over true frequency",
                 .value = low_estimate,
                 .lower = 0.95,
                 .bound_from = "500 iterations from a start with every wave length"});
  outcome.judge({.name = "smallest frequency bound over true",
                 .value = low_upper,
                 .lower = 1.0 - 1e-11,
                 .bound_from = exact});
  outcome.judge({.name = "largest frequency bound over true",
                 .value = high_upper,
                 .upper = 1.5,
                 .bound_from = "looser, and automatic substeps would waste a third of the work"});
  outcome.judge({.name = "smallest damping bound over true",
                 .value = low_damping,
                 .lower = 1.0 - 1e-11,
                 .bound_from = exact});
  outcome.judge({.name = "largest damping bound over true",
                 .value = high_damping,
                 .upper = 2.25,
                 .bound_from = "as the bound of the frequency, which is its square root"});
  draw(std::move(ratios), outcome);
}

}  // namespace

void add_bound_cases(std::vector<Case>& cases) {
  cases.push_back({.name = "stability/spectral-bounds",
                   .suite = "stability",
                   .claim = "the estimated and the guaranteed highest frequency of a network "
                            "enclose the exact one",
                   .measure = measure});
}

}  // namespace palpate::stability
