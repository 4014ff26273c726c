// SPDX-License-Identifier: MIT
#include "model/stepping/lattice_network.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace palpate {

namespace {

template <class Real>
LatticeSprings<Real> springs_of(const NetworkProblem& problem, int lanes, bool skip, bool may_fold) {
  const auto shape = lattice_of(problem.network());
  if (!shape) { throw std::invalid_argument("the network is no regular lattice"); }
  return LatticeSprings<Real>(problem, *shape, lanes, skip, may_fold);
}

/// What is larger [bytes] outgrows the caches; at 7 MB asking for rows ahead gains nothing, at 14 a sixth
/// (docs/bench.md).
constexpr std::size_t largest_cached = 8UL << 20U;

/// Places, velocities and masses, and what springs are by.
template <class Real>
lattice::Fetch fetch_for(Eigen::Index coordinates, std::size_t spring_bytes) {
  if (spring_bytes > largest_cached) { return lattice::Fetch::rows_and_constants; }
  const bool fits = 7 * sizeof(Real) * static_cast<std::size_t>(coordinates) / 3 <= largest_cached;
  return fits ? lattice::Fetch::nothing : lattice::Fetch::rows;
}

}  // namespace

template <class Real>
LatticeNetwork<Real>::LatticeNetwork(const NetworkProblem& problem, bool skip, int threads,
                                     const lattice::Kernels<Real>& kernels, bool may_fold)
    : LatticeNetwork(problem, springs_of<Real>(problem, kernels.lanes, skip, may_fold), kernels, skip, threads) {}

template <class Real>
LatticeNetwork<Real>::LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                                     const lattice::Kernels<Real>& kernels, bool skip, int threads)
    : NetworkSystem<Real>(problem, springs.layout(), skip),
      springs_(std::move(springs)),
      damped_(springs_.view().numbers > 1),
      kernels_(kernels),
      slabs_(std::make_unique<LatticeSlabs<Real>>(springs_.view(), threads)) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(this->layout().size);
  scatter(problem.mass(), this->layout(), mass);
  this->set_mass(mass);
  this->spread_weight();
  const lattice::Fetch fetch = fetch_for<Real>(this->layout().size, springs_.memory_bytes());
  force_ = (damped_ ? kernels.force : kernels.undamped_force).at(fetch);
  step_ = (damped_ ? kernels.step : kernels.undamped_step).at(fetch);
}

template <class Real>
void LatticeNetwork<Real>::let_sleep(double most_withheld, std::span<const int> touched) {
  const NetworkProblem& problem = this->problem();
  const SpringNetwork& network = problem.network();
  const LatticeRows& rows = springs_.rows();
  std::vector<unsigned char> awake(rows.count(), 0);
  const auto wake = [&](int node) { awake[rows.row_of(rows.place_of(node))] = 1; };
  const auto stirred = [](const NodeVectors& columns, int node) {
    return columns.cols() > 0 && !columns.col(node).isZero(0.0);
  };
  for (int node = 0; node < network.node_count(); ++node) {
    if (stirred(network.initial_displacement, node) || stirred(network.initial_velocity, node)) { wake(node); }
  }
  for (const Load& load : problem.loads()) { std::ranges::for_each(load.nodes, wake); }
  std::ranges::for_each(touched, wake);
  lattice::View<Real> view = springs_.view();
  sleep_.emplace(view, std::move(awake), most_withheld);
  view.row_moves = sleep_->awake();
  slabs_ = std::make_unique<LatticeSlabs<Real>>(view, 1);
}

template <class Real>
void LatticeNetwork<Real>::add_springs(const Vector<Real>& q, const Vector<Real>& v,
                                       Vector<Real>& f) noexcept {
  slabs_->sweep(force_, {q.data(), v.data(), f.data()});
  if (sleep_) { sleep_->wake_pulled(f.data(), this->inverse_mass().data()); }
}

template <class Real>
double LatticeNetwork<Real>::measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                             Vector<Real>& f) noexcept {
  const double energy = slabs_->sweep(damped_ ? kernels_.measured_force : kernels_.measured_undamped_force,
                                      {q.data(), v.data(), f.data()});
  if (sleep_) { sleep_->wake_pulled(f.data(), this->inverse_mass().data()); }
  return energy;
}

/// Loads of a layer keep their order.
template <class Real>
void LatticeNetwork<Real>::sort_loads() {
  const lattice::View<Real> view = springs_.view();
  const long layer_length = view.layer_length;
  const auto layer_of = [&](const auto& on) { return (on.coordinate - view.lead) / layer_length; };
  loaded_ = this->loaded();
  std::ranges::stable_sort(loaded_, {}, layer_of);
  pulls_.clear();
  pulls_begin_.assign(static_cast<std::size_t>(view.rows2) + 1, 0);
  for (const auto& on : loaded_) {
    pulls_.push_back({.element = (on.coordinate - view.lead) % layer_length});
    ++pulls_begin_[static_cast<std::size_t>(layer_of(on)) + 1];
  }
  std::partial_sum(pulls_begin_.begin(), pulls_begin_.end(), pulls_begin_.begin());
}

template <class Real>
void LatticeNetwork<Real>::prepare_one_pass() {
  if (!sleep_) {
    sort_loads();
    slabs_->prepare_steps();
    return;
  }
  next_force_.setZero(this->layout().size);
  this->put_weight(next_force_);
}

template <class Real>
double LatticeNetwork<Real>::one_pass(double t, double gate, Real h, State<Real>& state) noexcept {
  if (sleep_) { return one_pass_with_sleep(t, gate, h, state); }
  for (std::size_t n = 0; n < loaded_.size(); ++n) {
    const Eigen::Vector3d force = this->load_at(loaded_[n], t, gate);
    for (int c = 0; c < 3; ++c) { pulls_[n].force[c] = static_cast<Real>(force(c)); }
  }
  return slabs_->step(step_,
                      {.q = state.position.data(),
                       .v = state.velocity.data(),
                       .inverse_mass = this->inverse_mass().data(),
                       .h = h},
                      {.weight = this->weight().size() > 0 ? this->weight().data() : nullptr,
                       .pulls = pulls_.data(),
                       .pulls_begin = pulls_begin_.data()});
}

/// Sleeping rows keep the forces that are withheld from them, so those of all rows are kept.
template <class Real>
double LatticeNetwork<Real>::one_pass_with_sleep(double t, double gate, Real h, State<Real>& state) noexcept {
  this->add_loads(t, gate, Real(1), next_force_);
  const lattice::Move<Real> move{.q = state.position.data(),
                                 .v = state.velocity.data(),
                                 .inverse_mass = this->inverse_mass().data(),
                                 .h = h};
  const lattice::Fields<Real> fields{.q = move.q, .v = move.v, .f = next_force_.data(), .move = &move};
  const double squares = slabs_->sweep(step_, fields);
  return squares + sleep_->wake_in_step(fields);
}

template <class Real>
void LatticeNetwork<Real>::damping(const Vector<Real>& q, const Vector<Real>& w,
                                   Vector<Real>& f) noexcept {
  f.setZero();
  if (!damped_) { return; }
  slabs_->sweep(kernels_.damping, {q.data(), w.data(), f.data()});
  if (sleep_) { sleep_->withhold(f.data()); }
  f = -f;
}

template <class Real>
double LatticeNetwork<Real>::elastic_energy(const Vector<Real>& q) const noexcept {
  return slabs_->sweep(kernels_.energy, {.q = q.data()});
}

template <class Real>
std::size_t LatticeNetwork<Real>::spring_bytes() const noexcept {
  return springs_.memory_bytes() + slabs_->memory_bytes() + (sleep_ ? sleep_->memory_bytes() : 0) +
         static_cast<std::size_t>(next_force_.size()) * sizeof(Real) + pulls_.size() * sizeof(Pull<Real>);
}

template class LatticeNetwork<double>;
template class LatticeNetwork<float>;

}  // namespace palpate
