// SPDX-License-Identifier: MIT
/// palpate_subject_model.so: the model of this project behind palpate_subject.h.

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fixtures/io/scene_file.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/subject/palpate_subject.h"

struct palpate_subject {
  palpate::Scene scene;
  palpate::SpringNetwork network;
  std::optional<palpate::Simulation> simulation;
  Eigen::VectorXd coordinates;
  std::vector<double> row;
  std::size_t pressure = 0;  ///< column of the syringe's pressure; beyond the row without one

  void begin() {
    simulation.emplace(scene, network);
    const std::vector<palpate::Column>& columns = simulation->columns();
    row.resize(columns.size());
    const auto found = std::ranges::find(columns, "syringe.pressure_pa", &palpate::Column::name);
    pressure = static_cast<std::size_t>(found - columns.begin());
  }
};

namespace {

using namespace palpate;

/// Calls a function and turns its exceptions into PALPATE_FAILED.
template <class Function> int guarded(Function function) {
  try {
    return function();
  } catch (const std::exception&) { return PALPATE_FAILED; }
}

int load(const char* folder, const char*, palpate_subject** subject, char* error,
         std::size_t error_size) {
  try {
    auto made = std::make_unique<palpate_subject>();
    made->scene = io::read_scene(std::string(folder) + "/scene.toml").scene;
    made->network = build_network(made->scene);
    made->begin();
    *subject = made.release();
    return PALPATE_OK;
  } catch (const std::exception& problem) {
    if (error_size > 0) { std::snprintf(error, error_size, "%s", problem.what()); }
    return PALPATE_FAILED;
  }
}

int reset(palpate_subject* subject, std::uint64_t) {
  return guarded([&] {
    subject->begin();
    return PALPATE_OK;
  });
}

void write_output(palpate_subject& subject, palpate_tool_output& output) {
  const ToolReport tool = subject.simulation->tool();
  const ToolForces& f = tool.forces;
  std::copy_n(f.on_tool.data(), 3, output.force);
  output.cutting = f.cutting;
  output.friction = f.friction;
  output.stiffness = f.stiffness;
  output.insertion = tool.place;
  output.insertion_rate = tool.velocity;
  output.cut = tool.cut;
  output.depth = tool.depth;
  output.applied = f.applied;
  output.substeps = static_cast<std::uint32_t>(subject.simulation->plan().substeps);
  if (subject.pressure < subject.row.size()) {
    subject.simulation->sample(subject.row);
    output.pressure = subject.row[subject.pressure];
  }
  for (const ToolHappening& happening : subject.simulation->tool_happenings()) {
    output.events |= 1U << static_cast<unsigned>(happening.event);
    output.event_time = happening.time;
  }
  output.events |= tool.touching ? PALPATE_TOOL_TOUCHING : PALPATE_TOOL_APART;
  subject.simulation->forget_tool_happenings();
}

int step(palpate_subject* subject, double, double dt, const palpate_tool_input* input,
         palpate_tool_output* output) {
  if (dt == 0.0) {
    if (output != nullptr) { write_output(*subject, *output); }
    return PALPATE_OK;
  }
  if (input != nullptr && (input->flags & PALPATE_TOOL_COUPLED) != 0) {
    subject->simulation->move_handle(input->insertion, input->insertion_rate);
  }
  const StepStatus status = subject->simulation->tick();
  if (output != nullptr) { write_output(*subject, *output); }
  return status == StepStatus::ok ? PALPATE_OK : PALPATE_DIVERGED;
}

int get_state(palpate_subject* subject, double* position, double* velocity, std::size_t nodes) {
  return guarded([&] {
    const SpringNetwork& network = subject->network;
    if (static_cast<std::size_t>(network.node_count()) != nodes) { return int{PALPATE_FAILED}; }
    const auto columns = static_cast<Eigen::Index>(nodes);
    subject->simulation->node_positions(Eigen::Map<NodeVectors>(position, 3, columns));
    Eigen::Map<NodeVectors> rates(velocity, 3, columns);
    rates.setZero();
    subject->coordinates.resize(subject->simulation->problem().dof());
    subject->simulation->velocities(subject->coordinates);
    Eigen::Index n = 0;
    for (Eigen::Index node = 0; node < columns; ++node) {
      if (network.is_fixed(static_cast<int>(node))) { continue; }
      rates.col(node) = subject->coordinates.segment<3>(n);
      n += 3;
    }
    return int{PALPATE_OK};
  });
}

int set_parameter(palpate_subject* subject, const char* name, double value) {
  if (std::strcmp(name, "substeps") != 0) { return PALPATE_UNSUPPORTED; }
  if (!(value >= 1.0 && value <= 1e6)) { return PALPATE_FAILED; }
  subject->scene.simulation.substeps = static_cast<int>(value);
  return PALPATE_OK;
}

void destroy(palpate_subject* subject) { delete subject; }

}  // namespace

extern "C" const palpate_subject_api* palpate_subject_api_v1(void) {
  static const palpate_subject_api api{
      .abi = PALPATE_SUBJECT_ABI,
      .size = sizeof(palpate_subject_api),
      .name = "palpate",
      .version = PALPATE_VERSION,
      .licence = "MIT",
      .parameters = "substeps",
      .capabilities = PALPATE_CAN_SPRINGS | PALPATE_CAN_SPRING_DAMPING | PALPATE_CAN_FIXED_NODES |
                      PALPATE_CAN_INITIAL_STATE | PALPATE_CAN_LOADS | PALPATE_CAN_GRAVITY |
                      PALPATE_CAN_STATE | PALPATE_CAN_NEEDLE | PALPATE_CAN_PROBE |
                      PALPATE_CAN_SYRINGE | PALPATE_CAN_MATERIAL_LAWS | PALPATE_CAN_REPEAT,
      .load = load,
      .reset = reset,
      .step = step,
      .get_state = get_state,
      .set_state = nullptr,
      .set_parameter = set_parameter,
      .energy = nullptr,
      .destroy = destroy};
  return &api;
}
