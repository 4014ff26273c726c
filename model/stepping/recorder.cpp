// SPDX-License-Identifier: MIT
#include "model/stepping/recorder.hpp"

#include <algorithm>
#include <array>

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
      held_(problem.network().initial_position()),
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
        for (std::size_t s = 0; s < network.springs.size(); ++s) {
          if (network.springs[s].a == node || network.springs[s].b == node) {
            item.springs.push_back(static_cast<int>(s));
          }
        }
        for (std::size_t n = 0; n < problem.loads().size(); ++n) {
          const auto times = std::ranges::count(problem.loads()[n].nodes, node);
          for (long k = 0; k < times; ++k) { item.loads.push_back(static_cast<int>(n)); }
        }
      }
      needs_velocity_ = needs_velocity_ || quantity != RecordedQuantity::position;
      items_.push_back(std::move(item));
    }
  }
}

Eigen::Vector3d Recorder::position(int node, const Eigen::VectorXd& q) const noexcept {
  const Eigen::Index c = problem_.coordinate(node);
  return c < 0 ? Eigen::Vector3d(held_.col(node)) : Eigen::Vector3d(q.segment<3>(c));
}

Eigen::Vector3d Recorder::velocity(int node, const Eigen::VectorXd& v) const noexcept {
  const Eigen::Index c = problem_.coordinate(node);
  return c < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(v.segment<3>(c));
}

Eigen::Vector3d Recorder::force(const Item& item, double t, double gate, const Eigen::VectorXd& q,
                                const Eigen::VectorXd& v) const noexcept {
  const SpringNetwork& network = problem_.network();
  Eigen::Vector3d total = network.mass(item.node) * problem_.gravity();
  for (const int n : item.loads) {
    const Load& load = problem_.loads()[static_cast<std::size_t>(n)];
    total += load_factor(load, t, gate) * load.force;
  }
  for (const int index : item.springs) {
    const Spring& s = network.springs[static_cast<std::size_t>(index)];
    const Eigen::Vector3d d = position(s.b, q) - position(s.a, q);
    const double length = d.norm();
    if (length < zero_length) { continue; }
    const double rate = (velocity(s.b, v) - velocity(s.a, v)).dot(d) / length;
    const Eigen::Vector3d on_a =
        spring_force<double>(law_, s.stiffness, s.viscosity, s.rest_length, d, length, rate);
    total += s.a == item.node ? on_a : Eigen::Vector3d(-on_a);
  }
  return total;
}

void Recorder::sample(double t, double gate, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                      std::span<double> row) const noexcept {
  std::size_t place = 0;
  for (const Item& item : items_) {
    const Eigen::Vector3d value = item.quantity == RecordedQuantity::position
                                      ? position(item.node, q)
                                  : item.quantity == RecordedQuantity::velocity
                                      ? velocity(item.node, v)
                                      : force(item, t, gate, q, v);
    for (int n = 0; n < 3; ++n) { row[place++] = value(n); }
  }
}

}  // namespace palpate
