// SPDX-License-Identifier: MIT
/// Kernels that are timed: S26 with n nodes a side (bench_cases.hpp), in all available variants;
/// and the cases of `palpate bench` that time them.

#include <algorithm>
#include <array>
#include <memory>
#include <thread>

#include "model/kernels/lattice_network.hpp"
#include "model/kernels/lattice_rows.hpp"
#include "model/kernels/network_system.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/step_plan.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/number_text.hpp"

namespace palpate::bench {

namespace {

struct KernelVariant {
  const char* name = "";
  Precision precision = Precision::double_precision;
  bool lattice = true;  ///< false: the same springs in a list
  bool uneven = false;  ///< individual stiffness for every spring
  bool damped = true;
  int threads = 1;
  /// lattice::Kernels::name of a lattice; nullptr: the best on this processor
  const char* instructions = nullptr;

  [[nodiscard]] bool in_double() const { return precision == Precision::double_precision; }
};

constexpr Precision single = Precision::single_precision;

constexpr std::array<KernelVariant, 12> all_variants{
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

/// Semi-implicit Euler with steps of 1 ms, without the setup of a Simulation: bounds of the
/// spectrum alone take minutes for a million nodes.
struct Stepping {
  std::function<void(long times)> step{};
  double springs = 0.0;  ///< computed in a step
};

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

std::span<const KernelVariant> kernel_variants() { return all_variants; }

/// Returns the variants that memory bandwidth may limit, for the largest size.
std::span<const KernelVariant> largest_variants() { return std::span(all_variants).first(4); }

Stepping stepping_of(const KernelVariant& variant, int n) {
  return variant.in_double() ? stepping_in<double>(variant, n) : stepping_in<float>(variant, n);
}

/// Returns the minimum memory traffic of a step in one pass from the layout (lattice_view.hpp)
/// [bytes]: per node, position, velocity and force read and written, inverse mass read, and spring
/// constants that rows do not share.
double bytes_moved(const KernelVariant& variant, int n) {
  constexpr double read_and_written = 2.0 * 3.0 * 3.0;
  constexpr double inverse_mass = 1.0;
  return (read_and_written + inverse_mass + constants_per_node(variant)) * size_of_number(variant) *
         nodes(n);
}

/// Returns the size of all data that a step accesses [bytes].
double working_set(const KernelVariant& variant, int n) {
  return (3.0 * 3.0 + 1.0 + constants_per_node(variant)) * size_of_number(variant) * nodes(n);
}

// Limits of this machine, measured together with the kernels.

constexpr long roots_at_once = 2048;

/// Returns work of one square root and one division per number, with the instructions of the
/// lattice kernels: a lower limit of the cost of a spring. Buffers stay in the first-level cache;
/// one repetition processes `roots_at_once` numbers.
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
/// Returns work of the vector update a += x b: two numbers read and one written in place, without
/// other memory traffic. The two vectors together have `bytes`, so the bandwidth is that of the
/// cache or memory level for a working set of this size. One repetition moves 1.5 `bytes`.
std::function<void(long times)> vector_update(double bytes) {
  const std::vector<double> zeros(static_cast<std::size_t>(bytes / (2.0 * sizeof(double))), 0.0);
  return [a = zeros, b = std::vector<double>(zeros.size(), 1.0)](long times) mutable {
    for (long time = 0; time < times; ++time) {
      const double x = 1e-9 * static_cast<double>(time);
      for (std::size_t n = 0; n < a.size(); ++n) { a[n] += x * b[n]; }
    }
  };
}

/// Returns the slowdown of a thread by a second thread with its own work: 1 on two idle processors,
/// 2 if both share one, in between if memory limits them. Median of rounds, wall clock.
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

/// Returns the same slowdown for roots and quotients, which do not use memory.
double side_by_side_slowdown() {
  constexpr long times = 4000;  // some 20 ms
  const auto mine = roots_and_quotients<double>();
  const auto other = roots_and_quotients<double>();
  return side_by_side_slowdown([&] { mine(times); }, [&] { other(times); });
}

/// Cost of the square root and division of a spring [ns].
struct RootLimits {
  double in_double = 0.0;
  double in_float = 0.0;
};

/// Times of one kernel at one size, per spring and step.
struct KernelTime {
  const KernelVariant* variant = nullptr;
  double least = 0.0;      ///< [ns]
  double median = 0.0;     ///< [ns]
  double bytes = 0.0;      ///< memory traffic; lattices only
  double bandwidth = 0.0;  ///< [bytes/s] of a working set of that size; lattices only
  double root = 0.0;       ///< root and quotient [ns]

  [[nodiscard]] double memory() const { return 1e9 * bytes / bandwidth; }  ///< [ns]
  /// Lower limit of the time of a lattice step [ns].
  [[nodiscard]] double bound() const { return std::max(memory(), root); }
};

struct KernelSize {
  int n = 0;
  std::vector<KernelTime> times{};  ///< in the order of kernel_variants()

  /// nullptr if it was not timed at this size.
  [[nodiscard]] const KernelTime* find(std::string_view name) const {
    const auto found = std::ranges::find(
        times, name, [](const KernelTime& time) { return std::string_view(time.variant->name); });
    return found == times.end() ? nullptr : &*found;
  }
};

std::string two_digits(double value) { return formatted("%.2f", value); }

Table times_table(std::span<const KernelSize> sizes) {
  Table table = make_table("kernels", "Time of a spring in a step",
                           "Nanoseconds per spring and step of semi-implicit Euler: least, and "
                           "median in brackets, of interleaved rounds by the processor time of one "
                           "thread. A lattice takes the step in one pass over memory.",
                           {"kernel"});
  table.timing = true;
  for (const KernelSize& size : sizes) {
    table.columns.push_back("n = " + std::to_string(size.n) + " (ns)");
  }
  for (const KernelVariant& variant : kernel_variants()) {
    std::vector<Cell> row{variant.name};
    for (const KernelSize& size : sizes) {
      const KernelTime* time = size.find(variant.name);
      row.emplace_back(
          time == nullptr ? "-" : two_digits(time->least) + " (" + two_digits(time->median) + ")");
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table bounds_table(std::span<const KernelSize> sizes) {
  Table table = make_table(
      "bounds", "How far lattices are from what the machine allows",
      "The bound is the larger of two: a square root and a division; and the bytes that a step in "
      "one pass cannot do without (of each node position and velocity, read and written, the "
      "inverse mass, read; with a stiffness of its own also 13 pairs of constants, 13 numbers "
      "undamped) at the bandwidth that a += x b reached over as much data in the same rounds.",
      {"kernel", "n", "bytes per spring", "bandwidth (GB/s)", "memory (ns)", "root, quotient (ns)",
       "time (ns)", "time / bound"});
  table.timing = true;
  for (const KernelVariant& variant : kernel_variants()) {
    if (!variant.lattice) { continue; }
    for (const KernelSize& size : sizes) {
      const KernelTime* t = size.find(variant.name);
      if (t == nullptr) { continue; }
      table.rows.push_back({variant.name, size.n, t->bytes, 1e-9 * t->bandwidth, t->memory(),
                            t->root, t->least, t->least / t->bound()});
    }
  }
  return table;
}

Table limits_table(const RootLimits& limits) {
  return {.id = "limits",
          .title = "What arithmetic costs here",
          .caption =
              "A square root and a division for each spring, with the instructions that the "
              "kernels use.",
          .columns = {"limit", "value (ns)"},
          .rows = {{"root and quotient, double", limits.in_double},
                   {"root and quotient, float", limits.in_float}},
          .timing = true};
}

Series curve_of(std::span<const KernelSize> sizes, const KernelVariant& variant,
                const std::string& label, Series::Style style, double (*value)(const KernelTime&)) {
  Series series{.label = label, .style = style};
  for (const KernelSize& size : sizes) {
    if (const KernelTime* time = size.find(variant.name)) { series.add(size.n, value(*time)); }
  }
  return series;
}

Figure times_figure(std::span<const KernelSize> sizes, const RootLimits& limits,
                    Precision precision) {
  const bool in_double = precision == Precision::double_precision;
  const std::string kind = in_double ? "double" : "float";
  Figure figure =
      plot("kernels-" + kind, "Time of a spring in a step by size, " + kind,
           "Least of interleaved rounds. Dashed, what no damped lattice can beat: a square root "
           "and a division; and what memory takes for the bytes of a step, in the same rounds.",
           logarithmic("nodes along a side (1)"), logarithmic("time per spring and step (ns)"));
  figure.timing = true;
  for (const KernelVariant& variant : kernel_variants()) {
    if (variant.precision != precision ||
        (!variant.damped && (variant.uneven || !variant.lattice))) {
      continue;
    }
    const std::string name = variant.name;
    figure.series.push_back(curve_of(sizes, variant, name.substr(0, name.rfind(',')),
                                     Series::Style::line_and_points,
                                     [](const KernelTime& t) { return t.least; }));
  }
  const double root = in_double ? limits.in_double : limits.in_float;
  figure.series.push_back(
      {.label = "bound: root, quotient",
       .style = Series::Style::dashed,
       .x = {static_cast<double>(sizes.front().n), static_cast<double>(sizes.back().n)},
       .y = {root, root}});
  for (const KernelVariant& variant : kernel_variants()) {
    if (variant.precision != precision || !variant.lattice || !variant.damped) { continue; }
    figure.series.push_back(
        curve_of(sizes, variant, variant.uneven ? "bound: memory, own stiffness" : "bound: memory",
                 Series::Style::dashed, [](const KernelTime& t) { return t.memory(); }));
  }
  return figure;
}

RootLimits measure_roots() {
  const std::vector<Timed> timed = time_interleaved(
      {{"double", roots_and_quotients<double>()}, {"float", roots_and_quotients<float>()}});
  return {.in_double = 1e9 * timed[0].least / roots_at_once,
          .in_float = 1e9 * timed[1].least / roots_at_once};
}

/// Times all kernels of one size, and for each lattice memory traffic of the same amount in the
/// same rounds.
KernelSize measure_size(int n, std::span<const KernelVariant> variants, const RootLimits& limits) {
  std::vector<double> springs;
  std::vector<Contender> contenders;
  for (const KernelVariant& variant : variants) {
    Stepping stepping = stepping_of(variant, n);
    springs.push_back(stepping.springs);
    contenders.push_back({variant.name, std::move(stepping.step)});
  }
  for (const KernelVariant& variant : variants) {
    if (!variant.lattice) { continue; }
    contenders.push_back({variant.name, vector_update(working_set(variant, n))});
  }
  const std::vector<Timed> timed = time_interleaved(contenders);
  KernelSize size{.n = n};
  std::size_t update = variants.size();
  for (std::size_t v = 0; v < variants.size(); ++v) {
    KernelTime time{.variant = &variants[v],
                    .least = 1e9 * timed[v].least / springs[v],
                    .median = 1e9 * timed[v].median / springs[v],
                    .root = variants[v].in_double() ? limits.in_double : limits.in_float};
    if (variants[v].lattice) {
      time.bytes = bytes_moved(variants[v], n) / springs[v];
      time.bandwidth = 1.5 * working_set(variants[v], n) / timed[update++].least;
    }
    size.times.push_back(time);
  }
  return size;
}

void judge_size(const KernelSize& size, const std::string& kind, Outcome& outcome) {
  const KernelTime* list = size.find("list, " + kind);
  const KernelTime* lattice = size.find("lattice, " + kind);
  const std::string at = kind + "_n" + std::to_string(size.n);
  if (list != nullptr && lattice != nullptr) {
    outcome.judge_at_least("list_over_lattice_" + at, list->least / lattice->least, 2.0,
                           "a kernel of its own must at least halve the cost, else it goes");
  }
  if (size.n == 80 && lattice != nullptr) {
    outcome.judge_at_most("lattice_over_bound_" + at, lattice->least / lattice->bound(), 1.3,
                          "required: at most so far from the larger of root and quotient, and "
                          "memory, measured in the same run");
  }
}

void measure_kernels(const CaseContext& context, Outcome& outcome) {
  const RootLimits limits = measure_roots();
  std::vector<KernelSize> sizes;
  for (const int n : context.quick ? std::vector{10, 20} : std::vector{10, 20, 40, 80, 100}) {
    sizes.push_back(measure_size(n, n > 80 ? largest_variants() : kernel_variants(), limits));
  }
  for (const KernelSize& size : sizes) {
    for (const char* kind : {"double", "float"}) { judge_size(size, kind, outcome); }
    for (const KernelTime& time : size.times) {
      outcome.timings.push_back(
          {std::string(time.variant->name) + ", n = " + std::to_string(size.n), time.least, "ns"});
    }
  }
  outcome.tables = {times_table(sizes), bounds_table(sizes), limits_table(limits)};
  outcome.figures = {times_figure(sizes, limits, Precision::double_precision),
                     times_figure(sizes, limits, Precision::single_precision)};
}

// Speed-up by kernels for wider instruction sets: the same steps of the same lattice with each
// kernel that this processor supports.

/// Times a spring and step with each instruction set, the best set first: least of interleaved
/// rounds [ns].
template <class Real> std::vector<double> time_sets(KernelVariant variant, int n) {
  double springs = 0.0;
  std::vector<Contender> contenders;
  for (const lattice::Kernels<Real>& kernels : lattice_kernels<Real>()) {
    variant.instructions = kernels.name;
    Stepping stepping = stepping_of(variant, n);
    springs = stepping.springs;
    contenders.push_back({kernels.name, std::move(stepping.step)});
  }
  std::vector<double> least;
  for (const Timed& timed : time_interleaved(contenders)) {
    least.push_back(1e9 * timed.least / springs);
  }
  return least;
}

void measure_instruction_sets(const CaseContext& /*context*/, Outcome& outcome) {
  if (lattice_kernels<double>().size() == 1) {
    outcome.skip(
        "this processor has no more than the baseline, or PALPATE_INSTRUCTIONS allows no more");
    return;
  }
  Table& table = outcome.table(
      "instruction-sets", "Kernels for each instruction set of this processor",
      "The problem of bench/kernels in regular lattices; nanoseconds per spring and step of "
      "semi-implicit Euler, least of interleaved rounds by the processor time of one thread.",
      {"kernel", "n"});
  table.timing = true;
  for (const lattice::Kernels<double>& kernels : lattice_kernels<double>()) {
    table.columns.push_back(std::string(kernels.name) + " (ns)");
  }
  table.columns.emplace_back("smallest / widest (1)");
  double worst = unbounded;
  for (const KernelVariant& variant : largest_variants()) {
    for (const int n : {10, 20, 40}) {
      const std::vector<double> times =
          variant.in_double() ? time_sets<double>(variant, n) : time_sets<float>(variant, n);
      std::vector<Cell> row{variant.name, n};
      row.insert(row.end(), times.begin(), times.end());
      row.emplace_back(times.back() / times.front());
      table.rows.push_back(std::move(row));
      for (std::size_t s = 1; s < times.size(); ++s) {
        worst = std::min(worst, times[s] / times.front());
      }
    }
  }
  outcome.judge_at_least(
      "least_worth_of_the_widest", worst, 0.9,
      "wanted: the kernels that are chosen are the quickest; a tenth is noise of this comparison");
}

// Speed-up of a lattice by a second thread, if a second processor is free.

constexpr double wanted_speed_up = 1.7;
/// Largest slowdown by other load: of the ideal speed-up of 2, 1.8 must remain.
constexpr double most_slowdown = 1.1;

struct Pair {
  int n = 0;
  KernelVariant variant{};
  double one = 0.0;  ///< [ns] per spring and step, least by the wall clock
  double two = 0.0;
  double two_median = 0.0;
  double slowdown =
      0.0;  ///< of roots and quotients before, or of two copies of the same steps after

  [[nodiscard]] bool second_was_free() const { return slowdown <= most_slowdown; }
};

/// Times one thread and two alternately, both created anew each time: waiting threads spin, so they
/// must exist only while they are timed, and both variants must use equally new memory.
Pair time_pair(const KernelVariant& variant, int n) {
  KernelVariant shared = variant;
  shared.threads = 2;
  Stepping stepping;
  const auto contender = [&](const char* name, const KernelVariant& of) {
    return Contender{name, [&](long times) { stepping.step(times); }, Clock::wall,
                     [&stepping, &of, n] {
                       stepping = stepping_of(of, n);
                       stepping.step(3);  // the first touch new memory
                     },
                     [&stepping] { stepping = {}; }};
  };
  const Contender one = contender("one", variant);
  const Contender two = contender("two", shared);
  const std::vector<Timed> timed = time_interleaved({one, two}, {.rounds = 5, .batch = 0.03});
  const Stepping alone = stepping_of(variant, n);
  const Stepping copy = stepping_of(variant, n);
  const long times = std::max(1L, std::lround(0.02 / timed[0].least));  // 20 ms
  const double scale = 1e9 / alone.springs;
  return {.n = n,
          .variant = variant,
          .one = scale * timed[0].least,
          .two = scale * timed[1].least,
          .two_median = scale * timed[1].median,
          .slowdown = side_by_side_slowdown([&] { alone.step(times); }, [&] { copy.step(times); })};
}

Table pairs_table(const std::vector<Pair>& pairs) {
  Table table = make_table(
      "threads", "One thread and two",
      "Nanoseconds per spring and step, least of interleaved rounds by the wall clock: the "
      "processor time of one thread would leave out what the other does. Both compute the same "
      "bits. Side by side: how many times longer two copies of roots and quotients took than one "
      "before, or two copies of the same steps after; the larger.",
      {"kernel", "n", "one thread (ns)", "two threads (ns)", "two, median (ns)", "one / two (1)",
       "side by side (1)"});
  table.timing = true;
  for (const Pair& pair : pairs) {
    table.rows.push_back({pair.variant.name, pair.n, pair.one, pair.two, pair.two_median,
                          pair.one / pair.two, pair.slowdown});
  }
  return table;
}

/// Judges only if a second processor is free before and after; the times are shown in any case.
std::vector<Pair> time_pairs(const CaseContext& context, double& most) {
  std::vector<Pair> pairs;
  for (const int n : context.quick ? std::vector{40} : std::vector{40, 80}) {
    for (const KernelVariant& variant : largest_variants()) {
      if (context.quick && variant.uneven) { continue; }
      const double before = side_by_side_slowdown();
      most = std::max(most, before);
      if (before > most_slowdown) { continue; }
      pairs.push_back(time_pair(variant, n));
      pairs.back().slowdown = std::max(before, pairs.back().slowdown);
      most = std::max(most, pairs.back().slowdown);
    }
  }
  return pairs;
}

void measure_threads(const CaseContext& context, Outcome& outcome) {
  if (std::thread::hardware_concurrency() < 2) {
    outcome.skip("this machine has one processor");
    return;
  }
  double most = 0.0;
  const std::vector<Pair> pairs = time_pairs(context, most);
  if (!pairs.empty()) { outcome.tables = {pairs_table(pairs)}; }
  for (const Pair& pair : pairs) {
    if (pair.variant.uneven || !pair.second_was_free()) { continue; }
    outcome.judge_at_least("one_over_two_" +
                               std::string(pair.variant.in_double() ? "double" : "float") + "_n" +
                               std::to_string(pair.n),
                           pair.one / pair.two, wanted_speed_up,
                           "asked of the project: two processors at least 1.7 times one");
  }
  const std::string busy = "two copies of the same work side by side took up to " +
                           two_digits(most) + " times as long as one; at most " +
                           two_digits(most_slowdown) + " where two processors are free";
  if (outcome.quantities.empty()) {
    outcome.skip("no second processor was free: " + busy);
  } else if (most > most_slowdown) {
    outcome.notes.push_back(
        "Not judged where no second processor was free, or memory held both up: " + busy + ".");
  }
}

// Savings by each part that a scene does not need: ticks without it and ticks that compute it.

/// Scene that needs all parts but one.
struct SkippedThing {
  std::string name{};
  Scene scene{};
  SpringNetwork network{};
};

constexpr int nodes_a_side = 24;
constexpr long ticks = 20;

/// The pulled cube with weight and nothing held: nothing is left out.
Scene whole_scene() {
  Scene scene = s26_scene(nodes_a_side);
  scene.simulation.duration = 1e3;
  scene.tissue.gravity = {0.0, 0.0, 1e-3};
  scene.tissue.fixed.emplace();
  return scene;
}

SkippedThing thing(std::string name, const Scene& scene, bool as_list) {
  SkippedThing made{.name = std::move(name), .scene = scene, .network = build_network(scene)};
  if (as_list) { break_lattice(made.network); }
  return made;
}

/// Half of the nodes: rows of them, layer by layer.
void fix_half(SpringNetwork& network) {
  const std::size_t half = network.fixed.size() / 2;
  std::fill_n(network.fixed.begin(), half, std::uint8_t{1});
}

std::vector<SkippedThing> skipped_things() {
  std::vector<SkippedThing> things;
  for (const bool as_list : {false, true}) {
    const std::string where = as_list ? "list: " : "lattice: ";
    Scene undamped = whole_scene();
    undamped.tissue.lattice.viscosity = 0.0;
    things.push_back(thing(where + "dampers, of no viscosity", undamped, as_list));
    Scene weightless = whole_scene();
    weightless.tissue.gravity.setZero();
    things.push_back(thing(where + "weight, without gravity", weightless, as_list));
    things.push_back(
        thing(where + "fixed nodes and their springs, half of all", whole_scene(), as_list));
    fix_half(things.back().network);
  }
  Scene asleep = whole_scene();
  asleep.tissue.gravity.setZero();
  asleep.simulation.sleep_force = 1e-3;
  things.push_back(thing("lattice: nodes at rest, in the first " + std::to_string(ticks) + " ticks",
                         asleep, false));
  return things;
}

/// Times ticks from the beginning, each time with a new simulation created outside the measured
/// time.
Contender contender(const SkippedThing& what, bool skip, std::unique_ptr<Simulation>& simulation) {
  return {.name = what.name,
          .repeat =
              [&simulation](long times) {
                for (long n = 0; n < times * ticks; ++n) { (void)simulation->tick(); }
              },
          .begin =
              [&simulation, &what, skip] {
                simulation = std::make_unique<Simulation>(what.scene, what.network, skip);
                for (int n = 0; n < 3; ++n) {
                  (void)simulation->tick();
                }  // the first touch new memory
              },
          .end = [&simulation] { simulation.reset(); }};
}

/// A cube of one material that has only some of the optional terms.
SkippedThing cube_of(std::string name, Material material) {
  Scene scene = whole_scene();
  scene.tissue.gravity.setZero();
  material.name = "tissue";
  material.youngs_modulus = 5e3;
  scene.materials = {std::move(material)};
  scene.tissue.lattice.weights = LatticeWeights::cell;
  scene.tissue.lattice.material = "tissue";
  SkippedThing made = thing(std::move(name), scene, false);
  for (double& mass : made.network.mass) { mass = 1e-2; }  // every term is stable with one substep
  return made;
}

/// Cost of the optional terms of a material, each beside springs alone.
void time_terms(Outcome& outcome) {
  const Material plain{.retardation_time = 1e-4};
  Material compressed = plain;
  compressed.poissons_ratio = 0.45;
  Material exponential = plain;
  exponential.stiffening = Stiffening{.rate = 8.0};
  Material polynomial = plain;
  polynomial.stiffening =
      Stiffening{.law = Stiffening::Law::polynomial, .quadratic = 4.0, .cubic = 40.0};
  Material one = plain;
  one.relaxation = {{0.3, 1.0}};
  Material three = plain;
  three.relaxation = {{0.2, 0.1}, {0.2, 1.0}, {0.1, 10.0}};
  Material all = three;
  all.poissons_ratio = 0.45;
  all.stiffening = exponential.stiffening;
  std::vector<SkippedThing> cubes{cube_of("springs of a lattice", plain),
                                  cube_of("springs of a list", plain),
                                  cube_of("cell volumes, nu = 0.45", compressed),
                                  cube_of("stiffening, exponential", exponential),
                                  cube_of("stiffening, polynomial", polynomial),
                                  cube_of("relaxation, one branch", one),
                                  cube_of("relaxation, three branches", three),
                                  cube_of("all: nu, exponential, three branches", all)};
  break_lattice(cubes[1].network);
  std::vector<std::unique_ptr<Simulation>> simulations(cubes.size());
  std::vector<Contender> contenders;
  for (std::size_t n = 0; n < cubes.size(); ++n) {
    contenders.push_back(contender(cubes[n], true, simulations[n]));
  }
  const std::vector<Timed> timed = time_interleaved(contenders, {.rounds = 5, .batch = 0.0});
  Table& table = outcome.table(
      "terms", "What the terms of a material cost",
      "The same cube with weights from a material, as above: nanoseconds per cell and step. A "
      "scene computes only the terms that one of its materials has.",
      {"terms", "per cell and step (ns)", "over springs of a list (1)"});
  table.timing = true;
  const double cells = std::pow(nodes_a_side - 1.0, 3) * static_cast<double>(ticks);
  for (std::size_t n = 0; n < cubes.size(); ++n) {
    table.rows.push_back(
        {cubes[n].name, 1e9 * timed[n].least / cells, timed[n].least / timed[1].least});
  }
}

void measure_skips(const CaseContext& /*context*/, Outcome& outcome) {
  Table& table = outcome.table(
      "skips", "What is left out",
      "A cube of " + std::to_string(nodes_a_side) +
          " nodes a side that needs all but the one thing, semi-implicit Euler: microseconds of a "
          "tick, least of interleaved rounds by the processor time of one thread. Both ways give "
          "the same bits, but for nodes at rest (ctest -R \"model/(skip|lattice_sleep)\").",
      {"left out", "computed (us)", "left out (us)", "computed / left out (1)"});
  table.timing = true;
  double worst = unbounded;
  for (const SkippedThing& what : skipped_things()) {
    std::unique_ptr<Simulation> simulation;
    const std::vector<Timed> timed =
        time_interleaved({contender(what, false, simulation), contender(what, true, simulation)},
                         {.rounds = 9, .batch = 0.0});
    const double scale = 1e6 / static_cast<double>(ticks);
    const double worth = timed[0].least / timed[1].least;
    worst = std::min(worst, worth);
    table.rows.push_back({what.name, scale * timed[0].least, scale * timed[1].least, worth});
  }
  time_terms(outcome);
  outcome.judge_at_least(
      "least_worth", worst, 0.9,
      "wanted: leaving something out never costs time; a tenth is noise of this comparison");
}

}  // namespace

std::vector<Case> kernel_cases() {
  return {
      {"bench/kernels", "timing",
       "Kernels of regular lattices cost less than half of a list of springs at every size, and "
       "beyond the caches little more than what memory or a root and a quotient take.",
       measure_kernels, 60.0},
      {"bench/instruction-sets", "timing",
       "Of a regular lattice's kernels for the instruction sets of this processor the widest is "
       "the quickest.",
       measure_instruction_sets, 20.0},
      {"bench/threads", "timing",
       "Two threads take a lattice of 40 nodes a side or more 1.7 times as fast as one.",
       measure_threads, 30.0},
      {"bench/skips", "timing", "Leaving out what a scene does not need never makes a tick slower.",
       measure_skips, 10.0}};
}

}  // namespace palpate::bench
