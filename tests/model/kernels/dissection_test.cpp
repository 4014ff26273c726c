// SPDX-License-Identifier: MIT

#include "model/kernels/dissection.hpp"

#include <Eigen/SparseCholesky>
#include <vector>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Matrix = Eigen::SparseMatrix<double>;

/// Matrix of a cube of n x n x n nodes that touch 26 others, with two further rows that touch all.
struct Cube {
  explicit Cube(int n) : place(3, n * n * n), matrix(3 * n * n * n + 2, 3 * n * n * n + 2) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto row_of = [n](int i, int j, int k) { return 3 * ((k * n + j) * n + i); };
    const auto place_of = [n](int row) {
      const int node = row / 3;
      return Eigen::Vector3i(node % n, node / n % n, node / (n * n));
    };
    const int rows = static_cast<int>(3 * place.cols());
    for (int a = 0; a < rows; a += 3) {
      const Eigen::Vector3i at = place_of(a);
      place.col(a / 3) = at.cast<double>();
      for (int k = std::max(at.z() - 1, 0); k <= std::min(at.z() + 1, n - 1); ++k) {
        for (int j = std::max(at.y() - 1, 0); j <= std::min(at.y() + 1, n - 1); ++j) {
          for (int i = std::max(at.x() - 1, 0); i <= std::min(at.x() + 1, n - 1); ++i) {
            for (int c = 0; c < 9; ++c) {
              entries.emplace_back(a + c % 3, row_of(i, j, k) + c / 3, -0.5);
            }
          }
        }
      }
    }
    for (int row = 0; row < rows + 2; ++row) {
      entries.emplace_back(row, row, 200.0);
      for (int further = rows; further < rows + 2 && row < rows; ++further) {
        entries.emplace_back(row, further, 0.1);
        entries.emplace_back(further, row, 0.1);
      }
    }
    matrix.setFromTriplets(entries.begin(), entries.end());
  }
  NodeVectors place;
  Matrix matrix;
};

/// Number of entries of the factors of a matrix in an order of its rows.
Eigen::Index entries_of(const Matrix& matrix,
                        const Eigen::PermutationMatrix<Eigen::Dynamic>& order) {
  Matrix ordered;
  ordered.selfadjointView<Eigen::Lower>() = matrix.selfadjointView<Eigen::Lower>().twistedBy(order);
  const Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factors(ordered);
  CHECK(factors.info() == Eigen::Success);
  return Matrix(factors.matrixL()).nonZeros();
}

TEST("each row has one place in the factors, nodes keep their three rows, further rows are last") {
  const Cube cube(6);
  const auto order = nested_dissection(cube.matrix, cube.place);
  std::vector<int> places(order.indices().begin(), order.indices().end());
  const int rows = static_cast<int>(places.size());
  CHECK(places[places.size() - 2] == rows - 2);
  CHECK(places.back() == rows - 1);
  for (std::size_t n = 0; n + 2 < places.size(); n += 3) {
    CHECK(places[n] % 3 == 0);
    CHECK(places[n + 1] == places[n] + 1);
    CHECK(places[n + 2] == places[n] + 2);
  }
  std::ranges::sort(places);
  for (int n = 0; n < rows; ++n) { CHECK(places[static_cast<std::size_t>(n)] == n); }
}

TEST("factors of a cube have fewer entries than in the order of its rows, or by degree") {
  const Cube cube(9);
  Eigen::PermutationMatrix<Eigen::Dynamic> rows(cube.matrix.rows());
  rows.setIdentity();
  const Eigen::SimplicialLDLT<Matrix> by_degree(cube.matrix);
  const Eigen::Index found = entries_of(cube.matrix, nested_dissection(cube.matrix, cube.place));
  CHECK(static_cast<double>(found) <
        0.9 * static_cast<double>(Matrix(by_degree.matrixL()).nonZeros()));
  CHECK(static_cast<double>(found) < 0.7 * static_cast<double>(entries_of(cube.matrix, rows)));
}

TEST("without places the order is that of the rows") {
  const Cube cube(2);
  CHECK(nested_dissection(cube.matrix, NodeVectors(3, 0)).indices() ==
        Eigen::VectorXi::LinSpaced(26, 0, 25));
}

}  // namespace PALPATE_FILE
