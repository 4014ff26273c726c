// SPDX-License-Identifier: MIT
#pragma once
/// Test macros:
///   TEST("a spring at rest exerts no force") { CHECK_NEAR(force.norm(), 0.0, 1e-15); }
/// An executable runs all its cases, those of one file (--file tests/model/load_test.cpp), or those
/// whose name contains an argument.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// Namespace of a test file: without a name, or in a unity build, which compiles several files as
/// one, with a name for each.
#ifndef PALPATE_FILE
#define PALPATE_FILE
#endif

namespace scratch {

/// Root folder of the project, which contains the shipped scenes and recordings.
std::filesystem::path source_folder();

}  // namespace scratch

namespace check {

/// True in sanitizer builds. They run fewer steps of the same code and do not test accuracy.
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

/// Exception of a failed REQUIRE and of skip(). It ends the case.
struct Abandoned {};

inline std::vector<Case> cases;
inline int checks = 0, failures = 0, skips = 0;
inline double worst_margin = 0.0;  // largest error / tolerance so far
/// Row of a table that the following checks belong to. It is printed with a failure.
inline std::string row;

inline bool add(std::string_view name, void (*body)(), std::string_view file) {
  cases.push_back({name, body, file});
  return true;
}

inline void fail(const char* file, int line, const char* what) {
  ++failures;
  std::printf("%s:%d: %s%s%s\n", file, line, what, row.empty() ? "" : "\n  row: ", row.c_str());
}

/// Ends the case without a failure. The exit code is 77 if all cases were skipped.
[[noreturn]] inline void skip(const char* reason) {
  ++skips;
  std::printf("skipped: %s\n", reason);
  throw Abandoned{};
}

template <class T> std::string shown(const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_arithmetic_v<T>) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", static_cast<double>(value));
    return text;
  } else if constexpr (std::is_same_v<T, std::nullptr_t>) {
    return "nullptr";
  } else if constexpr (std::is_convertible_v<const T&, std::string_view>) {
    return "\"" + std::string(std::string_view(value)) + "\"";
  } else if constexpr (std::is_enum_v<T>) {
    return "enumerator " + std::to_string(static_cast<long long>(value));
  } else if constexpr (std::is_pointer_v<T>) {
    return value == nullptr ? "nullptr" : "a pointer";
  } else {
    return "a value that has no text";
  }
}

/// Result of one comparison, with both operands for the message.
template <class A, class B> struct Comparison {
  bool holds;
  const A& left;
  const B& right;

  explicit operator bool() const { return holds; }
  void print() const {
    std::printf("  left %s, right %s", shown(left).c_str(), shown(right).c_str());
    if constexpr (std::is_arithmetic_v<A> && std::is_arithmetic_v<B>) {
      std::printf(", ratio %.3g", static_cast<double>(left) / static_cast<double>(right));
    }
    std::printf("\n");
  }
};

/// Compares integers of different signedness by value.
template <class A, class B>
inline constexpr bool are_integers =
    std::is_integral_v<A>&& std::is_integral_v<B> && !std::is_same_v<A, bool> &&
    !std::is_same_v<B, bool> && !std::is_same_v<A, char> && !std::is_same_v<B, char>;

/// Left operand of a CHECK. `a && b` and `a || b` do not compile, so each CHECK has one condition.
template <class A> struct Left {
  const A& value;

  explicit operator bool() const { return static_cast<bool>(value); }
  void print() const { std::printf("  value %s\n", shown(value).c_str()); }
  template <class B> void operator&&(const B&) const = delete;
  template <class B> void operator||(const B&) const = delete;
#define CHECK_COMPARE(op, by_value)                                   \
  template <class B> Comparison<A, B> operator op(const B& b) const { \
    if constexpr (are_integers<A, B>) {                               \
      return {by_value(value, b), value, b};                          \
    } else {                                                          \
      return {static_cast<bool>(value op b), value, b};               \
    }                                                                 \
  }
  CHECK_COMPARE(==, std::cmp_equal)
  CHECK_COMPARE(!=, std::cmp_not_equal)
  CHECK_COMPARE(<, std::cmp_less)
  CHECK_COMPARE(<=, std::cmp_less_equal)
  CHECK_COMPARE(>, std::cmp_greater)
  CHECK_COMPARE(>=, std::cmp_greater_equal)
#undef CHECK_COMPARE
};

struct Capture {
  template <class A> Left<A> operator<<(const A& value) const { return {value}; }
};

template <class Expression>
bool judge(const Expression& expression, const char* text, const char* file, int line) {
  ++checks;
  if (static_cast<bool>(expression)) { return true; }
  fail(file, line, text);
  expression.print();
  return false;
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

inline bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

inline std::size_t count(std::string_view text, std::string_view part) {
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != text.npos; ++at) { ++found; }
  return found;
}

/// Checks that a text contains every part, or none of them.
inline void judge_parts(std::string_view text, std::initializer_list<std::string_view> parts,
                        bool expected, const char* what, const char* file, int line) {
  for (const std::string_view part : parts) {
    ++checks;
    if (contains(text, part) == expected) { continue; }
    fail(file, line, what);
    std::printf("  %s \"%.*s\" in text \"%.*s\"\n", expected ? "no" : "found",
                static_cast<int>(part.size()), part.data(),
                static_cast<int>(std::min(text.size(), std::size_t{500})), text.data());
  }
}

/// Checks that the first occurrences of the parts in a text are in this order.
inline void judge_order(std::string_view text, std::initializer_list<std::string_view> parts,
                        const char* what, const char* file, int line) {
  std::size_t least = 0;
  for (const std::string_view part : parts) {
    ++checks;
    const std::size_t found = text.find(part);
    if (found == text.npos || found < least) {
      fail(file, line, what);
      std::printf("  \"%.*s\" is absent or too early\n", static_cast<int>(part.size()),
                  part.data());
      return;
    }
    least = found + 1;
  }
}

/// Runs the cases whose file ends with `file` and whose name contains `name`. Returns the exit
/// code.
inline int run(std::string_view file, std::string_view name) {
  for (const Case& test : cases) {
    if (!test.file.ends_with(file) || test.name.find(name) == std::string_view::npos) { continue; }
    const int before = failures;
    row.clear();
    try {
      test.body();
    } catch (const Abandoned&) {
    } catch (const std::exception& e) { fail("uncaught exception", 0, e.what()); }
    std::printf("%s  %.*s\n", failures == before ? "pass" : "FAIL",
                static_cast<int>(test.name.size()), test.name.data());
  }
  std::printf("%d checks, %d failures, worst error %.2g of its tolerance\n", checks, failures,
              worst_margin);
  if (failures == 0 && checks == 0 && skips > 0) { return 77; }
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
#define CHECK(condition) \
  (void)check::judge(check::Capture{} << condition, #condition, __FILE__, __LINE__)
/// Ends the case on failure. Use it for conditions that the following lines require.
#define REQUIRE(condition)                                                              \
  do {                                                                                  \
    if (!check::judge(check::Capture{} << condition, #condition, __FILE__, __LINE__)) { \
      throw check::Abandoned{};                                                         \
    }                                                                                   \
  } while (false)
#define CHECK_NEAR(actual, expected, tolerance) \
  check::near(actual, expected, tolerance, #actual " == " #expected, __FILE__, __LINE__)
#define CHECK_CONTAINS(text, ...) \
  check::judge_parts(text, {__VA_ARGS__}, true, #text " contains " #__VA_ARGS__, __FILE__, __LINE__)
#define CHECK_LACKS(text, ...) \
  check::judge_parts(text, {__VA_ARGS__}, false, #text " lacks " #__VA_ARGS__, __FILE__, __LINE__)
#define CHECK_ORDER(text, ...) \
  check::judge_order(text, {__VA_ARGS__}, #text " has in order " #__VA_ARGS__, __FILE__, __LINE__)
#define CHECK_THROWS(expression, part_of_message) \
  CHECK_THROWS_AS(std::exception, expression, part_of_message)
#define CHECK_THROWS_AS(type, expression, part_of_message)                                        \
  do {                                                                                            \
    ++check::checks;                                                                              \
    try {                                                                                         \
      (void)(expression);                                                                         \
      check::fail(__FILE__, __LINE__, #expression " did not throw");                              \
    } catch (const type& e) {                                                                     \
      if (!check::contains(e.what(), part_of_message)) check::fail(__FILE__, __LINE__, e.what()); \
    }                                                                                             \
  } while (false)
