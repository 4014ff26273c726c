// SPDX-License-Identifier: MIT
/// Which kernels a processor gets, and what the environment may ask for.
#include "model/stepping/instruction_set.hpp"

#include <string>

#include "model/stepping/lattice_springs.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;

/// Sets the variable, and puts back what was there.
class Asked {
 public:
  explicit Asked(const char* name) {
    if (const char* before = std::getenv(variable)) { before_ = before; }
    setenv(variable, name, 1);
  }
  ~Asked() {
    if (before_.empty()) {
      unsetenv(variable);
    } else {
      setenv(variable, before_.c_str(), 1);
    }
  }
  Asked(const Asked&) = delete;
  Asked& operator=(const Asked&) = delete;

 private:
  static constexpr const char* variable = "PALPATE_INSTRUCTIONS";
  std::string before_{};
};

std::string best() { return lattice_kernels<double>().front().name; }

}  // namespace

TEST("the widest kernels that the processor can run come first, those that all can run last") {
  const Asked asked("avx512");
  CHECK(best() == (has_avx512() ? "avx512" : has_avx2() ? "avx2" : "baseline"));
  CHECK(std::string(lattice_kernels<double>().back().name) == "baseline");
  CHECK(lattice_kernels<float>().size() == 1U + (has_avx2() ? 1U : 0U) + (has_avx512() ? 1U : 0U));
}

TEST("the environment may ask for smaller ones") {
  {
    const Asked asked("avx2");
    CHECK(best() == (has_avx2() ? "avx2" : "baseline"));
  }
  const Asked asked("baseline");
  CHECK(best() == "baseline" && lattice_kernels<float>().size() == 1);
}

TEST("what is no instruction set is refused, with those that are") {
  const Asked asked("sse9");
  std::string said;
  try {
    (void)lattice_kernels<double>();
  } catch (const std::invalid_argument& error) {
    said = error.what();
  }
  CHECK(said == "PALPATE_INSTRUCTIONS = sse9; must be avx512, avx2 or baseline");
}
