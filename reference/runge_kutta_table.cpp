// SPDX-License-Identifier: MIT
#include "reference/runge_kutta_table.hpp"

#include <algorithm>
#include <arkode/arkode_butcher_dirk.h>
#include <arkode/arkode_butcher_erk.h>
#include <cmath>

namespace palpate::reference::sundials {

namespace {

Table loaded(ARKodeButcherTable table) {
  if (table == nullptr) { throw SolverError("SUNDIALS: no such Runge-Kutta table"); }
  return Table(table);
}

}  // namespace

bool reuses_no_stale_stage(const ARKodeButcherTableMem& table) {
  const int last = table.stages - 1;
  constexpr double rounding = 1e-10;  // wider than the library's own test
  if (std::abs(table.c[last] - 1.0) > rounding) { return true; }
  for (int j = 0; j < table.stages; ++j) {
    if (std::abs(table.A[last][j] - table.b[j]) > 1e-14) { return false; }
  }
  return true;
}

void refuse_stale_stage(ARKodeButcherTable used, const std::string& solver) {
  if (used != nullptr && reuses_no_stale_stage(*used)) { return; }
  throw SolverError(solver + ": SUNDIALS chose a Runge-Kutta table whose last stage it would reuse stale");
}

Table without_stale_stage(const ARKodeButcherTableMem& table) {
  const bool safe = reuses_no_stale_stage(table);
  Table copy = loaded(ARKodeButcherTable_Alloc(table.stages + (safe ? 0 : 1), table.d != nullptr));
  copy->q = table.q;
  copy->p = table.p;
  std::copy_n(table.c, table.stages, copy->c);  // the added stage keeps c = 0, A = 0, b = 0
  std::copy_n(table.b, table.stages, copy->b);
  if (table.d != nullptr) { std::copy_n(table.d, table.stages, copy->d); }
  for (int i = 0; i < table.stages; ++i) { std::copy_n(table.A[i], table.stages, copy->A[i]); }
  return copy;
}

Table explicit_table(int id) {
  const Table stock = loaded(ARKodeButcherTable_LoadERK(static_cast<ARKODE_ERKTableID>(id)));
  return without_stale_stage(*stock);
}

Table implicit_table(int id) {
  Table stock = loaded(ARKodeButcherTable_LoadDIRK(static_cast<ARKODE_DIRKTableID>(id)));
  if (!reuses_no_stale_stage(*stock)) {
    throw SolverError("SUNDIALS: this table would reuse a stale stage");
  }
  return stock;
}

}  // namespace palpate::reference::sundials
