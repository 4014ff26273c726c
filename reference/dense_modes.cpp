// SPDX-License-Identifier: MIT
#include "reference/dense_modes.hpp"

#include <memory>
#include <string>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include "reference/solution.hpp"

namespace palpate::reference {

namespace {

template <class T>
using Owned = std::unique_ptr<T, void (*)(T*)>;

/// GSL works on rows and destroys what it works on.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

gsl_matrix_view view_of(Rows& rows) {
  return gsl_matrix_view_array(rows.data(), static_cast<std::size_t>(rows.rows()),
                               static_cast<std::size_t>(rows.cols()));
}

/// GSL aborts at an error unless it is told not to.
void return_codes_only() {
  static const auto unused_default_handler = gsl_set_error_handler_off();
  (void)unused_default_handler;
}

void check(int status) {
  if (status != GSL_SUCCESS) {
    throw SolverError(std::string("dense modes: GSL: ") + gsl_strerror(status));
  }
}

}  // namespace

SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix) {
  if (matrix.rows() == 0) { return {Eigen::VectorXd(0), Eigen::MatrixXd(0, 0)}; }
  return_codes_only();
  const auto n = static_cast<std::size_t>(matrix.rows());
  Rows work = matrix;
  Rows vectors(matrix.rows(), matrix.cols());
  SymmetricModes modes;
  modes.values.resize(matrix.rows());
  gsl_matrix_view a = view_of(work);
  gsl_matrix_view v = view_of(vectors);
  gsl_vector_view values = gsl_vector_view_array(modes.values.data(), n);
  const Owned<gsl_eigen_symmv_workspace> space(gsl_eigen_symmv_alloc(n), gsl_eigen_symmv_free);
  check(gsl_eigen_symmv(&a.matrix, &values.vector, &v.matrix, space.get()));
  check(gsl_eigen_symmv_sort(&values.vector, &v.matrix, GSL_EIGEN_SORT_VAL_ASC));
  modes.vectors = vectors;
  return modes;
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix) {
  return symmetric_modes(matrix).values;
}

GeneralModes general_modes(const Eigen::MatrixXd& matrix) {
  if (matrix.rows() == 0) { return {}; }
  return_codes_only();
  const auto n = static_cast<std::size_t>(matrix.rows());
  Rows work = matrix;
  gsl_matrix_view a = view_of(work);
  const Owned<gsl_vector_complex> values(gsl_vector_complex_alloc(n), gsl_vector_complex_free);
  const Owned<gsl_matrix_complex> vectors(gsl_matrix_complex_alloc(n, n), gsl_matrix_complex_free);
  const Owned<gsl_eigen_nonsymmv_workspace> space(gsl_eigen_nonsymmv_alloc(n),
                                                  gsl_eigen_nonsymmv_free);
  check(gsl_eigen_nonsymmv(&a.matrix, values.get(), vectors.get(), space.get()));
  GeneralModes modes{Eigen::VectorXcd(matrix.rows()), Eigen::MatrixXcd(matrix.rows(), matrix.rows())};
  const auto complex = [](gsl_complex z) { return std::complex<double>(GSL_REAL(z), GSL_IMAG(z)); };
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    modes.values(row) = complex(gsl_vector_complex_get(values.get(), i));
    for (std::size_t j = 0; j < n; ++j) {
      modes.vectors(row, static_cast<Eigen::Index>(j)) =
          complex(gsl_matrix_complex_get(vectors.get(), i, j));
    }
  }
  return modes;
}

}  // namespace palpate::reference
