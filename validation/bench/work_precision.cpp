// SPDX-License-Identifier: MIT
#include "validation/bench/work_precision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "model/stepping/simulation.hpp"
#include "validation/bench/interleaved.hpp"

namespace palpate::bench {

namespace {

double root_mean_square(const Eigen::MatrixXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

/// Of the tool's error, at each tick that counts.
Eigen::VectorXd lengths(const Eigen::MatrixXd& error, const std::vector<bool>& left_out) {
  Eigen::VectorXd length = error.colwise().norm().transpose();
  for (std::size_t n = 0; n < left_out.size(); ++n) {
    if (left_out[n]) { length(static_cast<Eigen::Index>(n)) = 0.0; }
  }
  return length;
}

/// What the signal has come to.
Eigen::VectorXd final_of(const Eigen::MatrixXd& signal) { return signal.rightCols(1) - signal.leftCols(1); }

/// In the component that has come furthest.
double error_at_end(const Eigen::MatrixXd& signal, const Eigen::MatrixXd& truth) {
  Eigen::Index component = 0;
  const double size = final_of(truth).cwiseAbs().maxCoeff(&component);
  return std::abs(final_of(signal)(component) - final_of(truth)(component)) / size;
}

/// A scene that the model takes in one way.
struct Candidate {
  Point point{};
  Scene scene{};
};

std::string substeps_text(int substeps) {
  return std::to_string(substeps) + (substeps == 1 ? " substep" : " substeps");
}

/// Its errors; false when it is of no use.
bool judge_once(const Study& study, Candidate& candidate, double& seconds) {
  const Run run = study.here(candidate.scene);
  seconds = run.seconds;
  candidate.point.evaluations = run.evaluations;
  candidate.point.errors = errors_of(run, study.truth);
  return !run.failed && candidate.point.errors.tool < 1.0;
}

Candidate candidate_of(const Study& study, const Reduction& reduction, Point::Kind kind) {
  Candidate candidate{.point = {.kind = kind, .far_field = reduction.near_radius > 0.0}, .scene = study.scene};
  candidate.scene.simulation.near_radius = reduction.near_radius;
  if (candidate.point.far_field) { candidate.scene.simulation.far_modes = reduction.far_modes; }
  return candidate;
}

std::string method_of(const std::string& scheme, const Candidate& candidate) {
  return scheme + (candidate.point.kind == Point::Kind::in_float ? ", float" : "") +
         (candidate.point.far_field ? ", far field" : "");
}

void add_scheme(const Study& study, const std::string& scheme, const Reduction& reduction, Precision precision,
                double patience, std::vector<Candidate>& candidates) {
  const bool single = precision == Precision::single_precision;
  double before = unbounded;
  double seconds = 0.0;
  for (int substeps = study.least_substeps; substeps <= study.most_substeps && 2.0 * seconds <= patience;
       substeps *= 2) {
    Candidate candidate =
        candidate_of(study, reduction, single ? Point::Kind::in_float : Point::Kind::in_double);
    candidate.point.method = method_of(scheme, candidate);
    candidate.point.setting = substeps_text(substeps);
    candidate.scene.simulation.integrator = scheme;
    candidate.scene.simulation.substeps = substeps;
    candidate.scene.simulation.precision = precision;
    if (!judge_once(study, candidate, seconds)) { continue; }
    const double error = candidate.point.errors.tool;
    candidates.push_back(candidate);
    // Below the floor, or where rounding or a jump keeps it, finer steps tell nothing.
    if (error < study.truth.floor || error > 0.9 * before) { break; }
    before = error;
  }
}

void add_automatic(const Study& study, const Reduction& reduction, std::vector<Candidate>& candidates) {
  Candidate candidate = candidate_of(study, reduction, Point::Kind::automatic);
  candidate.point.method = method_of("auto", candidate);
  candidate.scene.simulation.integrator = "auto";
  candidate.scene.simulation.substeps.reset();
  const StepPlan plan = Simulation(candidate.scene).plan();
  candidate.point.setting = std::string(plan.integrator->name) + ", " + substeps_text(plan.substeps);
  double seconds = 0.0;
  if (judge_once(study, candidate, seconds)) { candidates.push_back(candidate); }
}

/// The ticks alone, all candidates in turn; what comes before them is timed too.
void time_candidates(std::vector<Candidate>& candidates, int rounds) {
  std::vector<std::unique_ptr<Simulation>> simulations(candidates.size());
  std::vector<Contender> contenders;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    std::unique_ptr<Simulation>& simulation = simulations[c];
    contenders.push_back(
        {.name = candidates[c].point.method,
         .repeat =
             [&simulation](long) {
               for (long n = simulation->tick_count(); n > 0; --n) { (void)simulation->tick(); }
             },
         .begin =
             [&simulation, &candidate = candidates[c]] {
               const double begin = seconds_on(Clock::processor);
               simulation = std::make_unique<Simulation>(candidate.scene);
               const double took = seconds_on(Clock::processor) - begin;
               candidate.point.loading = std::fmin(candidate.point.loading, took);
             },
         .end = [&simulation] { simulation.reset(); }});
  }
  const std::vector<Timed> timed = time_interleaved(contenders, {.rounds = rounds, .batch = 0.0});
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    candidates[c].point.seconds = timed[c].least;
    candidates[c].point.median = timed[c].median;
  }
}

void add_solver(const Study& study, const std::string& name, double patience, std::vector<Point>& points) {
  double spent = 0.0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "%.0e", tolerance);
    Point point{.method = name, .setting = text.data(), .kind = Point::Kind::elsewhere};
    std::vector<double> seconds;
    for (int n = 0; n < 3 && spent < patience; ++n) {
      const Run run = study.there(name, tolerance);
      if (run.failed) { break; }
      seconds.push_back(run.seconds);
      spent += run.seconds;
      point.evaluations = run.evaluations;
      point.errors = errors_of(run, study.truth);
    }
    if (seconds.empty() || point.errors.tool >= 1.0) { continue; }
    std::ranges::sort(seconds);
    point.seconds = seconds.front();
    point.median = seconds[seconds.size() / 2];
    points.push_back(point);
  }
}

/// What a point stands against.
bool same_field(const Point& a, const Point& b) {
  const auto field = [](const Point& p) {
    return p.kind == Point::Kind::automatic ? Point::Kind::in_double : p.kind;
  };
  return field(a) == field(b) && a.far_field == b.far_field;
}

}  // namespace

Errors errors_of(const Run& run, const Truth& truth) {
  const bool usable = !run.failed && run.tool.cols() == truth.run.tool.cols() && run.tool.allFinite() &&
                      run.position.size() == truth.run.position.size() && run.position.allFinite();
  if (!usable) { return {unbounded, unbounded, unbounded, unbounded, unbounded, unbounded}; }
  const Eigen::VectorXd tool = lengths(run.tool - truth.run.tool, truth.left_out);
  const Eigen::MatrixXd everywhere = run.position - truth.run.position;
  return {.tool = tool.maxCoeff() / truth.peak,
          .tool_mean = root_mean_square(tool) / truth.peak,
          .tool_at_end = error_at_end(run.tool, truth.run.tool),
          .trajectory = everywhere.cwiseAbs().maxCoeff() / truth.travel,
          .trajectory_mean = root_mean_square(everywhere) / truth.travel,
          .energy = (run.energy - truth.run.energy).cwiseAbs().maxCoeff() / truth.energy};
}

Truth truth_of(Run first, const Run& second, std::vector<bool> left_out) {
  Truth truth{.run = std::move(first), .left_out = std::move(left_out)};
  const Run& run = truth.run;
  truth.peak = (run.tool.colwise() - run.tool.col(0)).colwise().norm().maxCoeff();
  truth.travel = (run.position.colwise() - run.position.col(0)).cwiseAbs().maxCoeff();
  truth.energy = (run.energy.array() - run.energy(0)).abs().maxCoeff();
  truth.floor = errors_of(second, truth).tool;
  return truth;
}

std::vector<Point> measure_points(const Study& study, double patience, int rounds) {
  std::vector<Candidate> candidates;
  const auto add_schemes = [&](const std::vector<std::string>& schemes, const Reduction& reduction) {
    for (const std::string& scheme : schemes) {
      add_scheme(study, scheme, reduction, Precision::double_precision, patience, candidates);
      if (study.in_float && !find_integrator(scheme)->implicit) {
        add_scheme(study, scheme, reduction, Precision::single_precision, patience, candidates);
      }
    }
  };
  add_schemes(study.schemes, {});
  if (study.reduction.near_radius > 0.0) {
    add_schemes(study.schemes_of_reduction, study.reduction);
    add_automatic(study, study.reduction, candidates);
  }
  add_automatic(study, {}, candidates);
  time_candidates(candidates, rounds);
  std::vector<Point> points;
  for (const Candidate& candidate : candidates) { points.push_back(candidate.point); }
  for (const std::string& name : study.solvers) { add_solver(study, name, 3.0 * patience, points); }
  std::ranges::stable_partition(points, [](const Point& p) { return p.kind != Point::Kind::automatic; });
  return points;
}

const Point* cheapest(const std::vector<Point>& points, double error, bool here) {
  const Point* best = nullptr;
  for (const Point& point : points) {
    if (point.here() != here || !(point.errors.tool <= error)) { continue; }
    if (best == nullptr || point.seconds < best->seconds) { best = &point; }
  }
  return best;
}

bool on_frontier(const std::vector<Point>& points, const Point& point) {
  return std::ranges::none_of(points, [&](const Point& other) {
    return &other != &point && same_field(other, point) && other.seconds < point.seconds &&
           other.errors.tool < point.errors.tool;
  });
}

double automatic_over_best(const std::vector<Point>& points) {
  double worst = std::nan("");
  for (const Point& automatic : points) {
    if (automatic.kind != Point::Kind::automatic) { continue; }
    worst = std::fmax(worst, 0.0);
    for (const Point& p : points) {
      if (p.kind != Point::Kind::in_double || !same_field(p, automatic)) { continue; }
      if (p.errors.tool <= automatic.errors.tool) { worst = std::max(worst, automatic.seconds / p.median); }
    }
  }
  return worst;
}

double largest_error_of_automatic(const std::vector<Point>& points) {
  double largest = std::nan("");
  for (const Point& p : points) {
    if (p.kind == Point::Kind::automatic) { largest = std::fmax(largest, p.errors.tool); }
  }
  return largest;
}

double noise_of(const std::vector<Point>& points) {
  std::vector<double> apart;
  for (const Point& p : points) {
    if (p.here()) { apart.push_back(p.median / p.seconds); }
  }
  const auto tenth = apart.begin() + static_cast<std::ptrdiff_t>(9 * apart.size() / 10);
  std::ranges::nth_element(apart, tenth);
  return std::max(1.1, *tenth);
}

}  // namespace palpate::bench
