// SPDX-License-Identifier: MIT
#pragma once

namespace palpate::certificate {

/// Upper limit of the probability that a tick misses, after `misses` of `ticks`, one-sided (Clopper &
/// Pearson, Biometrika 26, 1934): the p for which so few misses or fewer have the chance 1 - confidence.
/// After none it is 1 - (1 - confidence)^(1/n), some 3/n at 95 %. 1 where every tick missed, or none was
/// counted. The inverse is Boost's: gsl_cdf_beta_Pinv of GSL 2.7 ends the program for one miss of 1000, where
/// its steps do not converge.
double miss_probability_upper(long misses, long ticks, double confidence = 0.95);

}  // namespace palpate::certificate
