// SPDX-License-Identifier: MIT
#include "model/stepping/recorder.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "model/dynamics/network_builder.hpp"

namespace palpate {

namespace {

struct QuantityColumns {
  std::array<const char*, 3> suffixes;
  const char* unit;
};

QuantityColumns columns_of(RecordedQuantity quantity) {
  switch (quantity) {
    case RecordedQuantity::velocity: return {{"vx_m_per_s", "vy_m_per_s", "vz_m_per_s"}, "m/s"};
    case RecordedQuantity::force: return {{"fx_n", "fy_n", "fz_n"}, "N"};
    case RecordedQuantity::position: break;
  }
  return {{"x_m", "y_m", "z_m"}, "m"};
}

}  // namespace

Recorder::Recorder(const Scene& scene, const NetworkProblem& problem)
    : problem_(problem),
      law_(SpringLaw::from(scene.simulation.printed)) {
  const SpringNetwork& network = problem.network();
  for (const Record& record : scene.records) {
    const int node = record_node(record, network);
    for (const RecordedQuantity quantity : record.quantities) {
      const QuantityColumns names = columns_of(quantity);
      for (const char* suffix : names.suffixes) {
        columns_.push_back({record.name + "." + suffix, names.unit, {}});
      }
      Item item{node, quantity, {}, {}};
      if (quantity == RecordedQuantity::force) {
        std::ranges::copy_if(network.springs, std::back_inserter(item.springs),
                             [&](const Spring& s) { return s.a == node || s.b == node; });
        for (std::size_t n = 0; n < problem.loads().size(); ++n) {
          const auto times = std::ranges::count(problem.loads()[n].nodes, node);
          for (long k = 0; k < times; ++k) { item.loads.push_back(static_cast<int>(n)); }
        }
      }
      items_.push_back(std::move(item));
    }
  }
}

Eigen::Vector3d Recorder::force(const Item& item, double t, double gate, NodeMotion& now) const noexcept {
  const SpringNetwork& network = problem_.network();
  Eigen::Vector3d total = network.mass(item.node) * problem_.gravity();
  for (const int n : item.loads) {
    const Load& load = problem_.loads()[static_cast<std::size_t>(n)];
    total += load_factor(load, t, gate) * load.force;
  }
  for (const Spring& s : item.springs) {
    const Eigen::Vector3d d = now.position(s.b) - now.position(s.a);
    const double length = d.norm();
    if (length < zero_length) { continue; }
    const double rate = (now.velocity(s.b) - now.velocity(s.a)).dot(d) / length;
    const Eigen::Vector3d on_a =
        spring_force<double>(law_, s.stiffness, s.viscosity, s.rest_length, d, length, rate);
    total += s.a == item.node ? on_a : Eigen::Vector3d(-on_a);
  }
  return total;
}

void Recorder::sample(double t, double gate, NodeMotion& now, std::span<double> row) const noexcept {
  std::size_t place = 0;
  for (const Item& item : items_) {
    const Eigen::Vector3d value = item.quantity == RecordedQuantity::position
                                      ? now.position(item.node)
                                  : item.quantity == RecordedQuantity::velocity
                                      ? now.velocity(item.node)
                                      : force(item, t, gate, now);
    for (int n = 0; n < 3; ++n) { row[place++] = value(n); }
  }
}

}  // namespace palpate
