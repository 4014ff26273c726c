// SPDX-License-Identifier: MIT
#pragma once
/// Compliance of the active contact constraints for a preconditioner P. Corrects x = P^-1 r so that
/// the constrained contact points move as r alone moves their masses (model/EQUATIONS.md, "Held
/// constraints"). The linear solver then needs no iterations for the constraints.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "model/kernels/system.hpp"

namespace palpate {

template <class Real> class ConstraintCompliance {
 public:
  /// Free node that a contact point interpolates from.
  struct Support {
    Eigen::Index coordinate;
    double weight;
    double inverse_mass;
  };
  using Solve = std::function<void(const Vector<Real>& right, Vector<Real>& solution)>;

  /// Computes P^-1 for each contact point and axis; calls `solve` once for each and allocates. The
  /// supports of contact point k are `begin[k]` to `begin[k + 1]`. `force_rows` is the largest
  /// number of rows from add_force_row(); `tool` is the tool's coordinate, or -1.
  void learn(std::vector<Support> supports, std::vector<std::size_t> begin, std::size_t force_rows,
             Eigen::Index tool, double tool_mass, Eigen::Index dof, const Solve& solve) {
    supports_ = std::move(supports);
    begin_ = std::move(begin);
    solve_ = solve;
    tool_ = tool;
    tool_mass_ = tool_mass;
    dof_ = dof;
    const auto knots = static_cast<Eigen::Index>(begin_.size()) - 1;
    response_.resize(dof, 3 * knots);
    Vector<Real> right = Vector<Real>::Zero(dof);
    Vector<Real> solution = right;
    for (Eigen::Index column = 0; column < 3 * knots; ++column) {
      right.setZero();
      const auto knot = static_cast<std::size_t>(column / 3);
      for (std::size_t i = begin_[knot]; i < begin_[knot + 1]; ++i) {
        right(supports_[i].coordinate + column % 3) = static_cast<Real>(supports_[i].weight);
      }
      solve(right, solution);
      response_.col(column) = solution;
    }
    gram_.setZero(3 * knots, 3 * knots);
    for (Eigen::Index row = 0; row < 3 * knots; ++row) {
      const auto knot = static_cast<std::size_t>(row / 3);
      for (std::size_t i = begin_[knot]; i < begin_[knot + 1]; ++i) {
        gram_.row(row) += supports_[i].weight *
                          response_.row(supports_[i].coordinate + row % 3).template cast<double>();
      }
    }
    right_.setZero(dof);
    solution_ = solution;
    if (tool >= 0) {
      right = Vector<Real>::Unit(dof, tool);
      solve(right, solution);
      tool_response_ = static_cast<double>(solution(tool));
    }
    const auto count = static_cast<std::size_t>(knots);
    const auto rows = 2 * knots + 3 + static_cast<Eigen::Index>(force_rows);
    row_.resize(static_cast<std::size_t>(rows));
    coefficients_.resize(4 * count + 2 + force_rows * count);
    image_.setZero(3 * knots, rows);
    small_.setZero(rows, rows);
    knots_.setZero(3 * knots);
    inertial_.setZero(3 * knots);
    shares_.setZero(3 * knots);
    multipliers_.setZero(rows);
  }
  [[nodiscard]] bool learned() const { return dof_ > 0; }
  /// Changes the weights of a single contact point; constraints must act along `axis` alone. Solves
  /// for the response only if the sum of |weight change| since the last solve exceeds `most_moved`.
  /// Constraints hold exactly with an older response; the distribution of the contact force then
  /// lags by one correction. Does not allocate.
  void reweigh(std::span<const Support> supports, Eigen::Index axis) noexcept {
    double moved = 0.0;
    for (std::size_t i = 0; i < supports.size(); ++i) {
      supports_[i].weight = supports[i].weight;
      const auto before = static_cast<double>(right_(supports_[i].coordinate + axis));
      moved += std::abs(supports_[i].weight - before);
    }
    if (!(moved <= most_moved)) {
      for (const Support& s : supports_) {
        right_(s.coordinate + axis) = static_cast<Real>(s.weight);
      }
      solve_(right_, solution_);
      response_.col(axis) = solution_;
    }
    gram_(axis, axis) = 0.0;
    for (const Support& s : supports_) {
      gram_(axis, axis) += s.weight * static_cast<double>(response_(s.coordinate + axis, axis));
    }
  }

  /// Removes all constraint rows. A row is the sum over contact points of coefficient . U, plus
  /// `on_tool` times the tool's coordinate.
  void clear() noexcept { rows_ = 0; }
  /// Adds a row, rigid or with the mobility `softness` [1/kg], and returns the coefficients of
  /// contact points [first, first + count), which the caller must set.
  std::span<Eigen::Vector3d> add_row(std::size_t first, std::size_t count, double on_tool,
                                     double softness = 0.0) noexcept {
    if (rows_ == 0) { used_ = 0; }
    row_[rows_++] = {first, count, on_tool, used_, softness, true};
    used_ += count;
    return {coefficients_.data() + used_ - count, count};
  }
  /// The same for a force of the matrix that P lacks: row^T row / softness.
  std::span<Eigen::Vector3d> add_force_row(std::size_t first, std::size_t count, double on_tool,
                                           double softness) noexcept {
    const auto coefficients = add_row(first, count, on_tool, softness);
    row_[rows_ - 1].constrains = false;
    return coefficients;
  }
  /// Factorises the constraint matrix; call it after the last row.
  void factorise() noexcept {
    const auto count = static_cast<Eigen::Index>(rows_);
    for (Eigen::Index j = 0; j < count; ++j) {
      const Row& row = row_[static_cast<std::size_t>(j)];
      auto image = image_.col(j);
      image.setZero();
      for (std::size_t n = 0; n < row.count; ++n) {
        const auto at = static_cast<Eigen::Index>(3 * (row.first + n));
        for (int axis = 0; axis < 3; ++axis) {
          image += coefficients_[row.coefficients + n](axis) * gram_.col(at + axis);
        }
      }
      for (Eigen::Index i = 0; i < count; ++i) {
        small_(i, j) =
            along(row_[static_cast<std::size_t>(i)], image, row.on_tool * tool_response_);
      }
      small_(j, j) += row.softness;
    }
    // In-place Cholesky factorisation, row by row. A row whose pivot is negative from rounding is
    // not constrained.
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) {
        const double rest = small_(i, j) - small_.row(i).head(j).dot(small_.row(j).head(j));
        if (i == j) {
          small_(i, i) = rest > 1e-12 * small_(i, i) ? std::sqrt(rest) : 1e150;
        } else {
          small_(i, j) = rest / small_(j, j);
        }
      }
    }
  }
  void correct(const Vector<Real>& r, Vector<Real>& x) const noexcept {
    const auto count = static_cast<Eigen::Index>(rows_);
    if (count == 0) { return; }
    knots_.setZero();
    inertial_.setZero();
    for (std::size_t k = 0; k + 1 < begin_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(3 * k);
      for (std::size_t i = begin_[k]; i < begin_[k + 1]; ++i) {
        const Support& s = supports_[i];
        knots_.segment<3>(at) +=
            s.weight * x.template segment<3>(s.coordinate).template cast<double>();
        inertial_.segment<3>(at) += (s.weight * s.inverse_mass) *
                                    r.template segment<3>(s.coordinate).template cast<double>();
      }
    }
    const double tool = tool_ < 0 ? 0.0 : static_cast<double>(x(tool_));
    const double tool_inertial = tool_ < 0 ? 0.0 : static_cast<double>(r(tool_)) / tool_mass_;
    auto mu = multipliers_.head(count);
    double on_tool = 0.0;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Row& row = row_[static_cast<std::size_t>(i)];
      mu(i) =
          (row.constrains ? along(row, inertial_, tool_inertial) : 0.0) - along(row, knots_, tool);
    }
    for (Eigen::Index i = 0; i < count; ++i) {
      mu(i) = (mu(i) - small_.row(i).head(i).dot(mu.head(i))) / small_(i, i);
    }
    for (Eigen::Index i = count - 1; i >= 0; --i) {
      const Eigen::Index after = count - i - 1;
      mu(i) = (mu(i) - small_.col(i).segment(i + 1, after).dot(mu.tail(after))) / small_(i, i);
    }
    knots_.setZero();
    std::size_t reached = 0;  // contact points up to the deepest constrained one
    for (Eigen::Index i = 0; i < count; ++i) {
      const Row& row = row_[static_cast<std::size_t>(i)];
      on_tool += mu(i) * row.on_tool;
      reached = std::max(reached, row.first + row.count);
      for (std::size_t n = 0; n < row.count; ++n) {
        knots_.segment<3>(static_cast<Eigen::Index>(3 * (row.first + n))) +=
            mu(i) * coefficients_[row.coefficients + n];
      }
    }
    shares_ = knots_.template cast<Real>();
    const auto columns = static_cast<Eigen::Index>(3 * reached);
    x.noalias() += response_.leftCols(columns) * shares_.head(columns);
    if (tool_ >= 0) { x(tool_) += static_cast<Real>(on_tool * tool_response_); }
  }
  /// Returns w P^-1 w^T [1/kg]: the response along n of two neighbouring contact points to a unit
  /// impulse along n that is divided between them, without constraints.
  [[nodiscard]] double response_at(std::size_t knot, double share,
                                   const Eigen::Vector3d& n) const noexcept {
    const auto low = static_cast<Eigen::Index>(3 * knot);
    const auto at = [&](Eigen::Index row, Eigen::Index column) {
      return n.dot(gram_.template block<3, 3>(row, column) * n);
    };
    const double rest = 1.0 - share;
    if (share == 0.0) { return at(low, low); }
    return rest * rest * at(low, low) + rest * share * (at(low, low + 3) + at(low + 3, low)) +
           share * share * at(low + 3, low + 3);
  }
  /// Returns W P^-1 W^T of row i without the other constraints [1/kg].
  [[nodiscard]] double response_of(std::size_t i) const noexcept {
    const auto row = static_cast<Eigen::Index>(i);
    return small_.row(row).head(row + 1).squaredNorm();
  }

 private:
  static constexpr double most_moved = 0.05;

  struct Row {
    std::size_t first = 0;
    std::size_t count = 0;
    double on_tool = 0.0;
    std::size_t coefficients = 0;  ///< index of the first coefficient
    double softness = 0.0;         ///< of a constraint that is not rigid [1/kg]
    bool constrains = true;
  };
  [[nodiscard]] double along(const Row& row, const Eigen::Ref<const Eigen::VectorXd>& knots,
                             double tool) const noexcept {
    double sum = row.on_tool * tool;
    for (std::size_t n = 0; n < row.count; ++n) {
      const auto at = static_cast<Eigen::Index>(3 * (row.first + n));
      sum += coefficients_[row.coefficients + n].dot(knots.template segment<3>(at));
    }
    return sum;
  }

  std::vector<Support> supports_{};
  std::vector<std::size_t> begin_{};
  Eigen::Index tool_ = -1;
  double tool_mass_ = 0.0;
  Eigen::Index dof_ = 0;
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> response_{};  ///< P^-1 of each direction
  Eigen::MatrixXd gram_{};  ///< 3 contact points x 3 contact points
  Solve solve_{};
  Vector<Real> right_{};  ///< weights of the last response of reweigh(); zero before
  Vector<Real> solution_{};
  double tool_response_ = 0.0;  ///< P^-1 of the tool's coordinate, on which no spring acts

  std::vector<Row> row_{};
  std::vector<Eigen::Vector3d> coefficients_{};
  std::size_t rows_ = 0;
  std::size_t used_ = 0;
  Eigen::MatrixXd image_{};  ///< gram times the rows
  Eigen::MatrixXd small_{};  ///< matrix of the rows, then its Cholesky factor
  mutable Eigen::VectorXd knots_{};
  mutable Eigen::VectorXd inertial_{};
  mutable Vector<Real> shares_{};  ///< weights of the directions in the correction
  mutable Eigen::VectorXd multipliers_{};
};

}  // namespace palpate
