// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string_view>
#include <type_traits>
#include <vector>

namespace scratch {

/// The project's root, where shipped scenes and recordings lie.
std::filesystem::path source_folder();

}  // namespace scratch

namespace check {

// Smallest test vocabulary that says what we need:
//   TEST("a spring at rest exerts no force") { CHECK_NEAR(force.norm(), 0.0, 1e-15); }
// An executable runs all its cases, those of one file (--file tests/model/load_test.cpp), or those
// whose name contains an argument.

/// Under sanitizers the same code is gone through in fewer steps; what it proves there is not
/// accuracy.
#ifdef PALPATE_SANITIZED
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

struct Case {
  std::string_view name;
  void (*body)();
  std::string_view file;
};

inline std::vector<Case> cases;
inline int checks = 0, failures = 0;
inline double worst_margin = 0.0;  // largest error / tolerance seen so far

inline bool add(std::string_view name, void (*body)(), std::string_view file) {
  cases.push_back({name, body, file});
  return true;
}

inline void fail(const char* file, int line, const char* what) {
  ++failures;
  std::printf("%s:%d: %s\n", file, line, what);
}

inline double distance(double a, double b) { return std::abs(a - b); }
template <class A, class B>  // Eigen matrices: largest coefficient; maxCoeff alone may skip a NaN
auto distance(const A& a, const B& b) -> decltype((a - b).cwiseAbs().maxCoeff()) {
  return (a - b).allFinite() ? (a - b).cwiseAbs().maxCoeff() : std::nan("");
}

template <class A, class B>
void near(const A& actual, const B& expected, double tolerance, const char* text, const char* file,
          int line) {
  const double error = distance(actual, expected);
  ++checks;
  worst_margin = std::fmax(worst_margin, error / tolerance);
  const bool within = error <= tolerance;  // false for NaN
  if (within) { return; }
  fail(file, line, text);
  if constexpr (std::is_arithmetic_v<A>) {
    std::printf("  got %.17g, expected %.17g\n", double(actual), double(expected));
  }
  std::printf("  error %.3g, tolerance %.3g: %.3g times too large\n", error, tolerance,
              error / tolerance);
}

/// File and name: the end of the one and a part of the other.
inline int run(std::string_view file, std::string_view name) {
  for (const Case& test : cases) {
    if (!test.file.ends_with(file) || test.name.find(name) == std::string_view::npos) { continue; }
    const int before = failures;
    try {
      test.body();
    } catch (const std::exception& e) { fail("uncaught exception", 0, e.what()); }
    std::printf("%s  %.*s\n", failures == before ? "pass" : "FAIL",
                static_cast<int>(test.name.size()), test.name.data());
  }
  std::printf("%d checks, %d failures, worst error %.2g of its tolerance\n", checks, failures,
              worst_margin);
  return failures == 0 && checks > 0 ? 0 : 1;
}

}  // namespace check

#define CHECK_JOIN_(a, b) a##b
#define CHECK_JOIN(a, b) CHECK_JOIN_(a, b)
#define TEST(name)                                             \
  static void CHECK_JOIN(test_, __LINE__)();                   \
  static const bool CHECK_JOIN(added_, __LINE__) =             \
      check::add(name, CHECK_JOIN(test_, __LINE__), __FILE__); \
  static void CHECK_JOIN(test_, __LINE__)()
#define CHECK(condition)                                               \
  do {                                                                 \
    ++check::checks;                                                   \
    if (!(condition)) { check::fail(__FILE__, __LINE__, #condition); } \
  } while (false)
#define CHECK_NEAR(actual, expected, tolerance) \
  check::near(actual, expected, tolerance, #actual " == " #expected, __FILE__, __LINE__)
#define CHECK_THROWS(expression, part_of_message)                                     \
  do {                                                                                \
    ++check::checks;                                                                  \
    try {                                                                             \
      (void)(expression);                                                             \
      check::fail(__FILE__, __LINE__, #expression " did not throw");                  \
    } catch (const std::exception& e) {                                               \
      if (std::string_view(e.what()).find(part_of_message) == std::string_view::npos) \
        check::fail(__FILE__, __LINE__, e.what());                                    \
    }                                                                                 \
  } while (false)
