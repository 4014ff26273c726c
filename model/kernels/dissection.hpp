// SPDX-License-Identifier: MIT
#pragma once
/// Order of elimination for the sparse factorisation of a tissue's matrix.

#include <Eigen/SparseCore>

#include "model/problem/spring_network.hpp"

namespace palpate {

/// Returns the permutation from the rows of a symmetric matrix to those of its factors, by nested
/// dissection of the nodes in space (A. George, SIAM J. Numer. Anal. 10, 345, 1973): the nodes of
/// two halves across their longest side, then those of one half that touch the other. It leaves
/// fewer entries in the factors of a block than an ordering by degree. Rows 3 n to 3 n + 2 belong
/// to the node at column n of `place`, in any unit of length; further rows come last, in their
/// order. The matrix may be given by one half.
template <class Real>
Eigen::PermutationMatrix<Eigen::Dynamic> nested_dissection(const Eigen::SparseMatrix<Real>& matrix,
                                                           const NodeVectors& place);

}  // namespace palpate
