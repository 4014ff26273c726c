// SPDX-License-Identifier: MIT
#pragma once
/// CVODE over y of Mechanics, restarted at every event. Private to reference/insertion*.cpp.

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "reference/insertion_transitions.hpp"
#include "reference/sundials.hpp"

namespace palpate::reference::insertion {

/// Adams-Moulton up to order 12 with functional iteration. SolverError naming the library's flag.
class Flow {
 public:
  Flow(Mechanics& mechanics, const Tolerance& tolerance, const InsertionOptions& options);
  Flow(const Flow&) = delete;  // the library keeps its address
  Flow& operator=(const Flow&) = delete;
  ~Flow();

  /// From y at `time` on, in one mode, never beyond `stop` [s].
  void restart(double time, double stop, const Mode& mode, const Eigen::VectorXd& y);
  /// Goes on to `goal` [s] or to the first event before it; returns what happened.
  std::set<Root> advance(double goal, Eigen::VectorXd& y);
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] long steps() const { return steps_ + steps_since_restart(); }

 private:
  void set_tolerance(const Tolerance& tolerance);
  void set_roots(const Eigen::VectorXd& y);
  [[nodiscard]] long steps_since_restart() const;
  void check(int flag, const char* function) const;
  static int right_hand_side(realtype t, N_Vector y, N_Vector dy, void* flow);
  static int roots(realtype t, N_Vector y, realtype* values, void* flow);
  static void complain(int code, const char*, const char* function, char* message, void* flow);

  Mechanics& mechanics_;
  Mode mode_{};
  Eigen::VectorXd y_, dy_;
  std::vector<Root> names_;
  sundials::Context context_;
  sundials::Vector state_;
  sundials::Vector absolute_;
  sundials::NonlinearSolver fixed_point_;
  void* memory_ = nullptr;  ///< freed before what it points to
  double time_ = 0.0;
  long steps_ = 0;
  std::string complaint_;  ///< last message of the library
  std::string cause_;      ///< why a callback refused
};

}  // namespace palpate::reference::insertion
