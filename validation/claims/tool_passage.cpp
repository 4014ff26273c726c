// SPDX-License-Identifier: MIT
/// Needle insertions: layers in order, loss of resistance, bone, angles, spacing, reinsertion.

#include <algorithm>
#include <cmath>

#include "model/problem/tool.hpp"
#include "validation/claims/tool_fixture.hpp"

namespace palpate::tools {

namespace {

Scene timed(Scene scene, double duration, double step = 1e-3) {
  scene.simulation = {.duration = duration, .step = step, .integrator = "velocity-verlet"};
  return scene;
}

std::string kinds(const Trace& run) {
  std::string all;
  for (const Event& e : run.events) { all += (all.empty() ? "" : " ") + e.kind; }
  return all;
}

/// Tool at the first sample at or after an instant.
ToolReport at(const Trace& run, double time) {
  const std::vector<ToolReport> tool = tool_rows(run);
  const auto found = std::ranges::lower_bound(run.time, time - 1e-9);
  const auto n = std::min<std::ptrdiff_t>(found - run.time.begin(),
                                          static_cast<std::ptrdiff_t>(tool.size()) - 1);
  return tool[static_cast<std::size_t>(n)];
}

void judge_true(Outcome& outcome, const std::string& name, bool holds, const std::string& why) {
  outcome.judge({.name = name, .value = holds ? 1.0 : 0.0, .lower = 1.0, .bound_from = why});
}

void measure_order(const CaseContext& context, Outcome& outcome) {
  const Scene scene = timed(seven_soft_layers(), 1.25, 1e-4);
  const Trace run = roll_out(context, scene, {.tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  judge_true(outcome, "events_in_order",
             kinds(run) ==
                 "contact puncture puncture puncture puncture puncture "
                 "loss-of-resistance dural-puncture",
             "five layers, the epidural space, the dura");
  std::vector<std::vector<Cell>> rows;
  for (std::size_t n = 0; n < scene.tissue.layers.size(); ++n) {
    const Layer& layer = scene.tissue.layers[n];
    const Material& material = scene.materials[n];
    double peak = 0.0;
    for (std::size_t k = 0; k < tool.size(); ++k) {
      if (run.texts("tool.layer")[k] != layer.tissue) { continue; }
      peak = std::fmax(peak, std::max(tool[k].forces.cutting, tool[k].forces.stiffness));
    }
    rows.push_back({layer.tissue, 1e3 * layer.thickness, material.cutting_force, peak});
    const double slack = std::max(material.cutting_force, 1.0) * 1e-12;
    outcome.judge({.name = "peak_in_" + layer.material,
                   .value = peak,
                   .unit = "N",
                   .lower = material.cutting_force - slack,
                   // A layer begins with what the tip still carried where it was stuck before.
                   .upper = material.cutting_force + slack,
                   .bound_from = "law: the tip sticks up to the cutting force and cuts at it"});
  }
  outcome.tables.push_back({.id = "peaks",
                            .title = "Peak force at the tip",
                            .columns = {"layer", "thickness (mm)", "cutting force (N)", "peak (N)"},
                            .rows = rows});
}

void measure_loss(const CaseContext& context, Outcome& outcome) {
  Scene scene = timed(seven_soft_layers(), 1.1);
  const Syringe syringe{};
  scene.syringe = syringe;
  const Trace run = roll_out(context, scene, {.tool = true});
  const double loss = run.time_of("loss-of-resistance");
  const ToolForces& before = at(run, loss - 2e-3).forces;
  const ToolForces& after = at(run, loss).forces;
  outcome.judge({.name = "drop_of_the_tip_force",
                 .value = before.cutting + before.stiffness - after.cutting - after.stiffness,
                 .unit = "N",
                 .lower = 1.2 - 1e-12,
                 .upper = 1.2 + 1e-12,
                 .bound_from = "law: from the cutting force of the flavum to that of the epidural "
                               "space, which is none, within a tick"});
  double high = 0.0;
  const auto begin = std::ranges::lower_bound(run.time, loss) - run.time.begin();
  const auto first = static_cast<std::size_t>(std::max<std::ptrdiff_t>(begin - 1, 0));
  high = run.values("syringe.pressure_pa").empty() ? std::nan("")
                                                   : run.values("syringe.pressure_pa")[first];
  const double low = syringe.thumb_flow * syringe.epidural_resistance;
  const auto crossing = [&](double share) {
    const double level = low + share * (high - low);
    for (std::size_t n = first + 1; n < run.values("syringe.pressure_pa").size(); ++n) {
      if (run.values("syringe.pressure_pa")[n] > level) { continue; }
      const double part =
          (run.values("syringe.pressure_pa")[n - 1] - level) /
          (run.values("syringe.pressure_pa")[n - 1] - run.values("syringe.pressure_pa")[n]);
      return run.time[n - 1] + part * (run.time[n] - run.time[n - 1]);
    }
    return std::nan("");
  };
  const double rc = syringe.epidural_resistance * syringe.compliance;
  outcome.judge({.name = "drop_time_90_10_over_r_c",
                 .value = (crossing(0.1) - crossing(0.9)) / rc,
                 .lower = std::log(9.0) - 2e-3,
                 .upper = std::log(9.0) + 2e-3,
                 .bound_from = "theory: ln 9 of an exponential; ticks of 1 ms interpolated"});
  outcome.judge({.name = "pressure_before",
                 .value = high,
                 .unit = "Pa",
                 .lower = 0.1 * syringe.thumb_force / syringe.plunger_area,
                 .upper = syringe.thumb_force / syringe.plunger_area * (1.0 + 1e-12),
                 .bound_from = "Eq. 1: the thumb's largest force over the plunger"});
  Figure figure{.id = "loss",
                .title = "Loss of resistance",
                .caption =
                    "Pressure in the syringe and force on the needle around the entry into "
                    "the epidural space.",
                .x = {.label = "time (s)"},
                .y = {.label = "pressure (kPa)"}};
  std::vector<double> kilopascal;
  for (const double p : run.values("syringe.pressure_pa")) { kilopascal.push_back(1e-3 * p); }
  figure.series = {curve("saline pressure", run.time, kilopascal)};
  outcome.figures.push_back(std::move(figure));
}

void measure_bone(const CaseContext& context, Outcome& outcome) {
  Scene scene = timed(seven_soft_layers(), 2.0);
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
  scene.tissue.layers[4] = {"lamina", "bone", 0.0122};
  scene.tissue.layers.resize(5);
  const double bone = 0.0158;
  scene.drive = Drive{.kind = Drive::Kind::force, .force = 100.0, .rise = 1.0};
  const Trace run = roll_out(context, scene, {.tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  double deepest = 0.0;
  for (const ToolReport& row : tool) { deepest = std::fmax(deepest, row.place); }
  outcome.judge({.name = "deepest_place_less_the_bone_s",
                 .value = run.diverged ? std::nan("") : deepest - bone,
                 .unit = "m",
                 .upper = 1e-15,
                 .bound_from = "law: bone is never pierced; rounding of 16 mm"});
  const ToolForces& f = tool.back().forces;
  outcome.judge({.name = "force_at_rest_less_the_hand_s",
                 .value = std::abs(f.total - 100.0),
                 .unit = "N",
                 .upper = 1e-9,
                 .bound_from = "balance"});
  outcome.judge({.name = "bone_events",
                 .value = static_cast<double>(run.count("bone")),
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "told once"});
}

void measure_track(const CaseContext& context, Outcome& outcome) {
  Scene scene = timed(seven_soft_layers(), 2.6, 1e-4);
  scene.drive->from = -0.002;
  scene.drive->technique = Drive::Technique::continuous;
  scene.drive->depth = 0.012;
  scene.drive->hold = 0.1;
  scene.drive->withdraw_speed = 0.02;
  const Trace run = roll_out(context, scene, {.tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  double tip = 0.0;
  double rub = 0.0;
  const double back = 0.014 / 0.02 + 0.15;
  double cut = 0.0;
  for (std::size_t n = 0; n < tool.size(); ++n) {
    if (run.time[n] < back || tool[n].place <= 1e-4) { continue; }
    tip = std::fmax(tip, tool[n].forces.cutting);
    rub = std::fmin(rub, tool[n].forces.friction);
    cut = std::fmax(cut, tool[n].losses.cutting);
  }
  outcome.judge({.name = "cutting_force_on_the_way_back",
                 .value = tip,
                 .unit = "N",
                 .upper = 0.0,
                 .bound_from = "law: a track is cut once"});
  outcome.judge({.name = "friction_on_the_way_back",
                 .value = rub,
                 .unit = "N",
                 .upper = -0.05,
                 .bound_from = "friction stays, the other way round"});
  outcome.judge({.name = "withdrawals",
                 .value = static_cast<double>(run.count("withdrawn")),
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "told once"});
}

/// Depth along the needle in undeformed tissue at which each layer is entered.
void measure_angles(const CaseContext& context, Outcome& outcome) {
  std::vector<std::vector<Cell>> rows;
  for (const double degrees : {0.0, 15.0, 30.0}) {
    Scene scene = timed(seven_soft_layers(0.004, 9), 0.8, 2e-5);
    const double angle = degrees * M_PI / 180.0;
    scene.needle->direction = {std::sin(angle), 0.0, std::cos(angle)};
    scene.needle->entry = {-0.0053, 0.0011};
    const Trace run = roll_out(context, scene, {.tool = true});
    double border = 0.0;
    double worst = 0.0;
    for (int n = 0; n < 3; ++n) {
      border += scene.tissue.layers[static_cast<std::size_t>(n)].thickness / std::cos(angle);
      const std::string& next = scene.tissue.layers[static_cast<std::size_t>(n + 1)].tissue;
      const double cut = at(run, run.time_of("puncture", next)).cut;
      worst = std::isnan(cut) ? cut : std::max(worst, std::abs(cut - border));
      rows.push_back({degrees, next, 1e3 * border, 1e3 * cut});
    }
    outcome.judge(
        {.name = "entry_error_at_" + std::to_string(static_cast<int>(degrees)) + "_degrees",
         .value = worst,
         .unit = "m",
         .upper = 2e-5,
         .bound_from = "theory: thickness over the cosine; a tick of 20 us, in which tissue "
                       "that is set free moves 20 um at 1 m/s"});
    double lateral = 0.0;
    for (const ToolReport& tool : tool_rows(run)) {
      lateral = std::fmax(lateral, tool.forces.lateral);
    }
    if (degrees > 0.0) {
      outcome.judge(
          {.name = "lateral_force_at_" + std::to_string(static_cast<int>(degrees)) + "_degrees",
           .value = lateral,
           .unit = "N",
           .lower = 1e-3,
           .upper = 5.0,
           .bound_from = "a slanting shaft is pressed sideways, by less than the force "
                         "along it"});
    }
  }
  outcome.tables.push_back({.id = "entries",
                            .title = "Where a slanting needle enters its layers",
                            .columns = {"angle (degrees)", "layer", "border (mm)", "entered (mm)"},
                            .rows = rows});
}

void measure_spacing(const CaseContext& context, Outcome& outcome) {
  const double coarse = 0.004;
  const Trace wide = roll_out(context, timed(seven_soft_layers(coarse, 4), 1.15), {.tool = true});
  const std::vector<ToolReport> wide_tool = tool_rows(wide);
  const Trace fine =
      roll_out(context, timed(seven_soft_layers(0.5 * coarse, 8), 1.15), {.tool = true});
  double worst = 0.0;
  std::vector<std::vector<Cell>> rows;
  for (const Event& e : wide.events) {
    const double one = at(wide, e.time).place;
    const double other = at(fine, fine.time_of(e.kind, e.detail)).place;
    worst = std::isnan(fine.time_of(e.kind, e.detail)) ? std::nan("")
                                                       : std::max(worst, std::abs(one - other));
    rows.push_back({e.kind, e.detail, 1e3 * one, 1e3 * other});
  }
  outcome.judge(
      {.name = "largest_shift_over_spacing",
       .value = worst / coarse,
       .upper = 1.0,
       .bound_from = "continuity: halving the spacing moves no puncture by more than it"});
  double jump = 0.0;
  for (std::size_t n = 1; n < wide_tool.size(); ++n) {
    if (wide_tool[n].forces.cutting == 0.0 || wide_tool[n - 1].forces.cutting == 0.0) { continue; }
    const bool rebounds = std::ranges::any_of(wide.events, [&](const Event& e) {
      return wide.time[n] >= e.time && wide.time[n] < e.time + 0.01;
    });
    if (rebounds) { continue; }
    jump = std::fmax(jump, std::abs(wide_tool[n].forces.total - wide_tool[n - 1].forces.total));
  }
  outcome.judge({.name = "largest_jump_while_cutting",
                 .value = jump,
                 .unit = "N",
                 .upper = 40.0 * 0.02 * 1e-3 * 3.0,
                 .bound_from = "law: only friction grows while a layer is cut, by f times the "
                               "advance, three times as fast at most; 10 ms of rebound behind "
                               "each event left out"});
  outcome.tables.push_back({.id = "spacing",
                            .title = "Places of the tip at two spacings",
                            .columns = {"event", "layer", "4 mm: place (mm)", "2 mm: place (mm)"},
                            .rows = rows});
}

void measure_thin(const CaseContext& context, Outcome& outcome) {
  Scene scene = timed(seven_soft_layers(), 0.9, 1e-4);
  // A membrane of a twentieth of the spacing, in the middle of a cell.
  scene.materials.push_back(tissue_of("membrane", 300e3, 1.0, 0.0));
  scene.tissue.layers.insert(scene.tissue.layers.begin() + 3, {"membrane", "membrane", 0.0002});
  const Trace run = roll_out(context, scene, {.tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  double peak = 0.0;
  for (std::size_t n = 0; n < tool.size(); ++n) {
    if (run.texts("tool.layer")[n] == "membrane") {
      peak = std::fmax(peak, tool[n].forces.stiffness);
    }
  }
  outcome.judge({.name = "punctures_of_the_membrane",
                 .value = std::isnan(run.time_of("puncture", "membrane")) ? 0.0 : 1.0,
                 .lower = 1.0,
                 .bound_from = "no layer is skipped"});
  outcome.judge({.name = "peak_in_the_membrane",
                 .value = peak,
                 .unit = "N",
                 .lower = 0.99,
                 .upper = 1.0 + 1e-12,
                 .bound_from = "its cutting force; the last tick before it is 1 % below"});
}

}  // namespace

std::vector<Case> passage_cases() {
  const auto one = [](std::string name, std::string claim, auto measure, double weight) {
    return Case{.name = "needle/" + std::move(name),
                .suite = "accuracy",
                .claim = std::move(claim),
                .measure = measure,
                .weight = weight};
  };
  return {
      one("layers", "Seven layers are punctured in order, each at its cutting force.",
          measure_order, 2.0),
      one("loss-of-resistance",
          "In the epidural space the tip's force falls at once and the saline's pressure with "
          "R C.",
          measure_loss, 1.0),
      one("bone", "A hundred newtons do not move the tip into bone.", measure_bone, 1.0),
      one("track", "A track is cut once; drawn back, the shaft rubs the other way.", measure_track,
          2.0),
      one("angles", "At 0, 15 and 30 degrees, off the nodes, layers are entered where they lie.",
          measure_angles, 5.0),
      one("spacing", "Halving the lattice spacing moves no puncture by more than the spacing.",
          measure_spacing, 4.0),
      one("thin-layer", "A layer thinner than the spacing is met like any other.", measure_thin,
          2.0)};
}

// Published moduli of ligament under a needle, at ticks of a millisecond.

namespace {

void measure_moduli(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_published_layers(8);
  scene.drive->speed = 0.02;
  const double whole = 2.1;
  std::vector<std::vector<Cell>> rows;
  Trace runs[2];
  const char* names[] = {"auto", "velocity-verlet"};
  for (int n = 0; n < 2; ++n) {
    scene.simulation = {.duration = n == 0          ? whole
                                    : context.quick ? 0.3
                                                    : whole,
                        .step = 1e-3,
                        .integrator = names[n]};
    runs[n] = roll_out(context, scene, {.tool = true});
    const double ticks = static_cast<double>(runs[n].rows() - 1);
    rows.push_back(
        {runs[n].method, static_cast<double>(runs[n].substeps), 1e3 * runs[n].seconds / ticks});
    outcome.timings.push_back(
        {"ms_per_tick_" + runs[n].method, 1e3 * runs[n].seconds / ticks, "ms"});
  }
  const Trace& chosen = runs[0];
  outcome.judge({.name = "diverged",
                 .value = chosen.diverged ? 1.0 : 0.0,
                 .upper = 0.0,
                 .bound_from = "stable at ticks of 1 ms, whatever the integrator needs inside"});
  outcome.judge({.name = "loss_of_resistance",
                 .value = static_cast<double>(chosen.count("loss-of-resistance")),
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "the needle arrives"});
  double worst = 0.0;
  double peak = 0.0;
  std::vector<double> depth, force, other;
  const std::size_t samples = std::min(runs[0].rows(), runs[1].rows());
  for (std::size_t n = 0; n < runs[0].rows(); ++n) {
    depth.push_back(1e3 * runs[0].at("tool.insertion_m", n));
    force.push_back(runs[0].at("tool.force_n", n));
    peak = std::fmax(peak, force.back());
    if (n < samples) { other.push_back(runs[1].at("tool.force_n", n)); }
  }
  // At punctures the two may be a tick apart, where the whole force drops.
  std::size_t far = 0;
  for (std::size_t n = 0; n < samples; ++n) {
    const double error = std::abs(force[n] - other[n]);
    if (!(error <= 0.01 * peak)) { ++far; }
    worst = std::isnan(error) ? error : std::max(worst, error);
  }
  outcome.judge(
      {.name = "share_of_ticks_more_than_1_percent_of_peak_apart",
       .value = std::isnan(worst) ? worst : static_cast<double>(far) / static_cast<double>(samples),
       .upper = 0.02,
       .bound_from = "implicit and explicit stepping agree but for the ticks at punctures "
                     "and the jolt of the first contact"});
  outcome.judge({.name = "peak_force",
                 .value = peak,
                 .unit = "N",
                 .lower = 8.0,
                 .upper = 16.0,
                 .bound_from = "published: 12.1 N at the flavum (Davidor et al. 2023), within a "
                               "third"});
  outcome.tables.push_back({.id = "cost",
                            .title = "What a tick of 1 ms costs",
                            .columns = {"integrator", "substeps", "time per tick (ms)"},
                            .rows = rows,
                            .timing = true});
  Figure figure{.id = "force-depth",
                .title = "Force over depth with published moduli",
                .caption =
                    "Seven layers at 20 mm/s: automatic stepping and explicit stepping with "
                    "a hundred substeps.",
                .x = {.label = "place of the tip (mm)"},
                .y = {.label = "force (N)"}};
  figure.series.push_back(curve(chosen.method, depth, force));
  depth.resize(other.size());
  figure.series.push_back(curve("velocity-verlet", depth, other, Series::Style::dashed));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> moduli_cases() {
  return {{.name = "needle/published-moduli",
           .suite = "stability",
           .claim = "Ligament of 15 MPa is stable at ticks of 1 ms, and what it costs is told.",
           .measure = measure_moduli,
           .weight = 10.0}};
}

// Extremes of speed, force and step: every value is finite, or divergence is reported.

namespace {

struct Extreme {
  const char* name;
  void (*make)(Scene&);
};

constexpr Extreme extremes[] = {
    {"1 m/s",
     [](Scene& s) {
       s.drive->speed = 1.0;
       s.simulation.duration = 0.03;
     }},
    {"1 um/s", [](Scene& s) { s.drive->speed = 1e-6; }},
    {"nothing to cut",
     [](Scene& s) {
       for (Material& m : s.materials) { m.cutting_force = 0.0; }
     }},
    {"1000 N to cut",
     [](Scene& s) {
       for (Material& m : s.materials) { m.cutting_force = 1e3; }
     }},
    {"no friction",
     [](Scene& s) {
       for (Material& m : s.materials) { m.friction = 0.0; }
     }},
    {"1000 times the friction",
     [](Scene& s) {
       for (Material& m : s.materials) { m.friction *= 1e3; }
     }},
    {"ticks of 0.1 ms", [](Scene& s) { s.simulation.step = 1e-4; }},
    {"ticks of 2 ms", [](Scene& s) { s.simulation.step = 2e-3; }},
    {"a thrust of 5 m/s",
     [](Scene& s) {
       s.drive->from = -0.02;
       s.drive->speed = 5.0;
       s.simulation.duration = 0.008;
     }},
    {"10 N at once",
     [](Scene& s) { s.drive = Drive{.kind = Drive::Kind::force, .force = 10.0, .rise = 0.0}; }},
    {"pushes of 5 N",
     [](Scene& s) {
       s.drive = Drive{.kind = Drive::Kind::force,
                       .technique = Drive::Technique::intermittent,
                       .pause = 0.02,
                       .force = 5.0,
                       .rise = 0.0,
                       .push = 0.01};
     }},
    {"a needle of a milligram",
     [](Scene& s) {
       s.needle->mass = 1e-6;
       s.drive =
           Drive{.kind = Drive::Kind::force, .force = 1.0, .rise = 0.1, .hand_viscosity = 0.0};
     }},
    {"single precision", [](Scene& s) { s.simulation.precision = Precision::single_precision; }},
    {"beyond the block",
     [](Scene& s) {
       s.drive->speed = 0.2;
       s.simulation.duration = 0.3;
     }},
};

bool finite(const Trace& run) {
  const std::vector<ToolReport> tool = tool_rows(run);
  for (const ToolReport& t : tool) {
    const ToolForces& f = t.forces;
    for (const double value : {t.place, t.velocity, t.depth, t.cut, t.slip, f.cutting, f.friction,
                               f.stiffness, f.total, f.applied, f.lateral, t.losses.impact}) {
      if (!std::isfinite(value)) { return false; }
    }
  }
  return !tool.empty();
}

void measure_stress(const CaseContext& context, Outcome& outcome) {
  std::vector<std::vector<Cell>> rows;
  for (const char* integrator : {"auto", "velocity-verlet", "implicit-euler"}) {
    double broken = 0.0;
    double diverged = 0.0;
    for (const Extreme& extreme : extremes) {
      Scene scene = seven_soft_layers();
      scene.simulation = {.duration = 0.2, .step = 1e-3, .integrator = integrator};
      extreme.make(scene);
      const Trace run = roll_out(context, scene, {.tool = true});
      const std::vector<ToolReport> tool = tool_rows(run);
      const bool whole = finite(run);
      broken += whole ? 0.0 : 1.0;
      diverged += run.diverged ? 1.0 : 0.0;
      double peak = 0.0;
      for (const ToolReport& t : tool) { peak = std::fmax(peak, t.forces.total); }
      rows.push_back({std::string(extreme.name), std::string(integrator),
                      std::string(run.diverged ? "diverged, and said so"
                                  : whole      ? "finite"
                                               : "BROKEN"),
                      peak});
    }
    outcome.judge({.name = std::string("runs_with_values_that_are_not_finite_") + integrator,
                   .value = broken,
                   .upper = 0.0,
                   .bound_from = "a run is finite, or stops and says so"});
    outcome.judge({.name = std::string("runs_that_diverged_") + integrator,
                   .value = diverged,
                   .upper = integrator == std::string("auto") ? 0.0 : 3.0,
                   .bound_from =
                       "automatic stepping keeps every one of them; a scheme asked for by "
                       "name may give up on a few and says so"});
  }
  outcome.tables.push_back({.id = "stress",
                            .title = "Extremes",
                            .columns = {"scene", "integrator", "outcome", "peak force (N)"},
                            .rows = rows});
}

}  // namespace

std::vector<Case> stress_cases() {
  return {{.name = "needle/stress",
           .suite = "stability",
           .claim = "At extremes of speed, force and step an insertion stays finite or says that "
                    "it diverged.",
           .measure = measure_stress,
           .weight = 6.0}};
}

}  // namespace palpate::tools
