// SPDX-License-Identifier: MIT
#include "model/stepping/panel_factors.hpp"

#include <random>

#include "tests/check.hpp"

using namespace palpate;

namespace {

/// Laplacian of an n x n x n grid with three coordinates a node, a little of everything added.
template <class Real>
Eigen::SparseMatrix<Real> grid(int n) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(0.1, 1.0);
  std::vector<Eigen::Triplet<Real>> entries;
  const auto at = [&](int x, int y, int z) { return (z * n + y) * n + x; };
  const auto tie = [&](int a, int b) {
    for (int i = 0; i < 3; ++i) {
      const auto stiffness = static_cast<Real>(any(random));
      const int j = static_cast<int>(random() % 3);
      entries.emplace_back(3 * a + i, 3 * a + i, stiffness);
      entries.emplace_back(3 * b + j, 3 * b + j, stiffness);
      entries.emplace_back(3 * a + i, 3 * b + j, -stiffness);
      entries.emplace_back(3 * b + j, 3 * a + i, -stiffness);
    }
  };
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        if (x + 1 < n) { tie(at(x, y, z), at(x + 1, y, z)); }
        if (y + 1 < n) { tie(at(x, y, z), at(x, y + 1, z)); }
        if (z + 1 < n) { tie(at(x, y, z), at(x, y, z + 1)); }
      }
    }
  }
  const int size = 3 * n * n * n;
  for (int i = 0; i < size; ++i) { entries.emplace_back(i, i, Real(0.1)); }
  Eigen::SparseMatrix<Real> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

template <class Real>
double residual(const Eigen::SparseMatrix<Real>& matrix, const panels::Kernels& kernels = panel_kernels().front()) {
  PanelFactors<Real> factors(kernels);
  factors.take(Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>>(matrix));
  CHECK(factors.usable());
  CHECK(factors.panel_count() <= static_cast<std::size_t>(matrix.cols()));
  const Vector<Real> right = Vector<Real>::LinSpaced(matrix.cols(), Real(-1), Real(2));
  Vector<Real> x = Vector<Real>::Zero(matrix.cols());
  factors.solve(right, x);
  return static_cast<double>((matrix * x - right).norm() / right.norm());
}

}  // namespace

TEST("panels solve what the factors solve, to single precision") {
  // Condition below (12 + 0.1) / 0.1; rounding of 6e-8 along a column of up to 375 entries.
  for (const int n : {1, 2, 5}) {
    for (const panels::Kernels& kernels : panel_kernels()) {
      CHECK(residual(grid<double>(n), kernels) < 120.0 * 375.0 * 6e-8);
      CHECK(residual(grid<float>(n), kernels) < 120.0 * 375.0 * 6e-8);
    }
  }
}

TEST("columns with the same rows share a panel, and nothing is lost where there are none") {
  Eigen::SparseMatrix<double> full = Eigen::MatrixXd::Ones(40, 40).sparseView();
  full.diagonal().array() += 40.0;
  PanelFactors<double> factors;
  factors.take(Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(full));
  CHECK(factors.panel_count() == 2);  // of 32 columns at most
  CHECK_NEAR(residual(full), 0.0, 1e-6);
  Eigen::SparseMatrix<double> diagonal(4, 4);
  diagonal.setIdentity();
  diagonal *= 4.0;
  CHECK_NEAR(residual(diagonal), 0.0, 1e-7);
}

TEST("what single precision cannot hold is not usable") {
  Eigen::SparseMatrix<double> tiny(2, 2);
  tiny.setIdentity();
  tiny *= 1e-60;
  PanelFactors<double> factors;
  factors.take(Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(tiny));
  CHECK(!factors.usable());
}
