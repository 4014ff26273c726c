// SPDX-License-Identifier: MIT
#pragma once
/// One declaration per scheme file; integrator_registry.cpp collects them.

#include "model/stepping/integrator.hpp"

namespace palpate::schemes {

extern const IntegratorInfo euler;
extern const IntegratorInfo euler_cromer;
extern const IntegratorInfo feynman_newton;
extern const IntegratorInfo feynman_newton_printed;
extern const IntegratorInfo leapfrog;
extern const IntegratorInfo velocity_verlet;
extern const IntegratorInfo rk4;
extern const IntegratorInfo implicit_euler;
extern const IntegratorInfo implicit_midpoint;

}  // namespace palpate::schemes
