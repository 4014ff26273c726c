// SPDX-License-Identifier: MIT
#include "validation/bench/machine_limits.hpp"

#include <cmath>

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
  const auto limit = lattice_kernels<Real>().roots_and_quotients;
  for (long n = 0; n < times; ++n) { limit(from_.data(), to_.data(), count); }
}

Triad::Triad() : a_(count, 0.0), b_(count, 1.0), c_(count, 2.0) {}

void Triad::repeat(long times) {
  double* a = a_.data();
  const double* b = b_.data();
  const double* c = c_.data();
  for (long time = 0; time < times; ++time) {
    const double x = 1.0 + 1e-9 * static_cast<double>(time);
    for (std::size_t n = 0; n < count; ++n) { a[n] = b[n] + x * c[n]; }
  }
}

template class RootsAndQuotients<double>;
template class RootsAndQuotients<float>;

}  // namespace palpate::bench
