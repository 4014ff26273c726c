// SPDX-License-Identifier: MIT
#include "validation/bench/machine_limits.hpp"

#include <cmath>
#include <thread>

#include "model/stepping/lattice_springs.hpp"

namespace palpate::bench {

template <class Real>
RootsAndQuotients<Real>::RootsAndQuotients() : from_(count), to_(count) {
  for (long n = 0; n < count; ++n) {
    from_[static_cast<std::size_t>(n)] = static_cast<Real>(1.0 + 1e-3 * static_cast<double>(n % 997));
  }
}

template <class Real>
void RootsAndQuotients<Real>::repeat(long times) {
  const auto limit = lattice_kernels<Real>().front().roots_and_quotients;
  for (long n = 0; n < times; ++n) { limit(from_.data(), to_.data(), count); }
}

VectorUpdate::VectorUpdate(double bytes)
    : a_(static_cast<std::size_t>(bytes / (2.0 * sizeof(double))), 0.0), b_(a_.size(), 1.0) {}

void VectorUpdate::repeat(long times) {
  double* a = a_.data();
  const double* b = b_.data();
  const std::size_t count = a_.size();
  for (long time = 0; time < times; ++time) {
    const double x = 1e-9 * static_cast<double>(time);
    for (std::size_t n = 0; n < count; ++n) { a[n] += x * b[n]; }
  }
}

double VectorUpdate::bytes_moved() const { return 3.0 * sizeof(double) * static_cast<double>(a_.size()); }

double side_by_side_slowdown(const std::function<void()>& mine, const std::function<void()>& other) {
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
  RootsAndQuotients<double> mine;
  RootsAndQuotients<double> other;
  return side_by_side_slowdown([&] { mine.repeat(times); }, [&] { other.repeat(times); });
}

template class RootsAndQuotients<double>;
template class RootsAndQuotients<float>;

}  // namespace palpate::bench
