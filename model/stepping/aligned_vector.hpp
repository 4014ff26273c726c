// SPDX-License-Identifier: MIT
#pragma once
/// Numbers that kernels read: they begin where a cache line does, so that no register is loaded from two lines.

#include <vector>

#include <Eigen/Core>

namespace palpate {

static_assert(EIGEN_DEFAULT_ALIGN_BYTES >= 64, "compile with EIGEN_MAX_ALIGN_BYTES=64, as palpate_build_options does");

template <class Real>
using AlignedVector = std::vector<Real, Eigen::aligned_allocator<Real>>;

}  // namespace palpate
