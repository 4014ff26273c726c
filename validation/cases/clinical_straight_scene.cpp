// SPDX-License-Identifier: MIT
#include "validation/cases/clinical_straight_scene.hpp"

#include "validation/cases/clinical_traces.hpp"

namespace palpate::clinical {

using namespace calibration;

Scene short_way() {
  Scene scene;
  scene.simulation = {.duration = 7.5, .step = 4e-3};
  scene.tissue.source = Source::layers;
  scene.tissue.fixed = {{Face::x_min, Face::x_max, Face::y_min, Face::y_max, Face::z_max}};
  scene.tissue.block = {.nodes = {3, 3}, .spacing = 0.01};
  const auto material = [](const char* name, double modulus, double cutting, double friction) {
    return Material{.name = name,
                    .youngs_modulus = modulus,
                    .density = 1100.0,
                    .damping_ratio = 0.5,
                    .cutting_force = cutting,
                    .friction = friction};
  };
  scene.materials = {material("interspinous", 10e6, 4.56, 74.0), material("flavum", 15e6, 7.4, 354.0),
                     material("epidural-space", 2.4e3, 0.0, 0.0)};
  scene.tissue.layers = {{"interspinous", "interspinous", 0.0105},
                         {"flavum", "flavum", 0.0034},
                         {"epidural space", "epidural-space", 0.006}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.003, .depth = 0.0169};
  scene.syringe = Syringe{};
  return scene;
}

std::vector<Parameter> fitted_parameters(const Scene& scene) {
  std::vector<Parameter> parameters = parameters_of(scene);
  std::erase_if(parameters, [](const Parameter& p) {
    return !p.key.ends_with("cutting_force") && !p.key.ends_with("thumb_force") &&
           !p.key.ends_with("compliance") && !p.key.ends_with("epidural_resistance");
  });
  for (Parameter& p : parameters) {
    if (p.key.starts_with("syringe.")) { p.spread = 0.2; }
    set_default_bounds(p);
  }
  return parameters;
}

Trace trace_of(const Insertion& run, std::vector<double> pressure) {
  Trace trace{.time = run.time};
  std::vector<double> depth;
  std::vector<double> force;
  for (const ToolReport& tool : run.tool) {
    depth.push_back(tool.place);
    force.push_back(tool.forces.total);
  }
  trace.columns = {{"syringe.pressure_pa", "Pa", std::move(pressure)},
                   {"tool.depth_m", "m", std::move(depth)},
                   {"tool.force_n", "N", std::move(force)}};
  return trace;
}

ObservedInsertion candidate(const CaseContext& context, const Scene& scene) {
  const Insertion run = insert_tool(context, scene);
  std::vector<double> pressure = run.pressure;
  damage(context, pressure);
  return observe(trace_of(run, std::move(pressure)));
}

namespace {

Eigen::VectorXd numbers(const Scene& scene) {
  const Syringe& s = *scene.syringe;
  Eigen::VectorXd all(5);
  all << scene.materials[0].cutting_force, scene.materials[1].cutting_force, s.thumb_force,
      s.compliance * s.epidural_resistance, s.epidural_resistance;
  return all;
}

}  // namespace

StraightScene::StraightScene(const CaseContext& context) : base_(short_way()), middle_(numbers(base_)) {
  constexpr double step = 0.2;
  value_ = candidate(context, base_).value;
  slope_.resize(observable_count, middle_.size());
  for (Eigen::Index n = 0; n < middle_.size(); ++n) {
    Eigen::VectorXd there = middle_;
    there[n] *= 1.0 + step;
    slope_.col(n) = (candidate(context, with_numbers(there)).value - value_) / (step * middle_[n]);
  }
}

ObservedInsertion StraightScene::at(const Scene& scene) const {
  return {.value = value_ + slope_ * (numbers(scene) - middle_), .force = ForceSource::recorded};
}

Scene StraightScene::with_numbers(const Eigen::VectorXd& all) const {
  Scene scene = base_;
  scene.materials[0].cutting_force = all[0];
  scene.materials[1].cutting_force = all[1];
  scene.syringe->thumb_force = all[2];
  scene.syringe->compliance = all[3] / all[4];
  scene.syringe->epidural_resistance = all[4];
  return scene;
}

}  // namespace palpate::clinical
