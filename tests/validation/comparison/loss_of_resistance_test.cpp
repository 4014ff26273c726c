// SPDX-License-Identifier: MIT
#include "validation/comparison/loss_of_resistance.hpp"

#include <functional>

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;
using Status = LossOfResistance::Status;

/// 100 samples a second of a law in units of the peak.
LossOfResistance found_in(double duration, const std::function<double(double)>& law) {
  Samples pressure{.step = 0.01};
  for (int n = 0; n <= static_cast<int>(duration * 100.0); ++n) { pressure.value.push_back(law(0.01 * n)); }
  return find_loss(pressure);
}

double ramp(double t) { return 20.0 + 40.0 * t / 6.0; }
auto falls_to(double level) {
  return [level](double t) { return t < 6.0 ? ramp(t) : level; };
}

TEST("a fall that is held for more than 5 s is a loss of resistance") {
  const LossOfResistance loss = found_in(14.0, falls_to(8.0));
  CHECK(loss.found() && !loss.weak);
  CHECK(loss.fallen_index == 600);
  CHECK(loss.peak_index == 599);
  CHECK_NEAR(loss.plateau, 8.0, 0.0);
  CHECK_NEAR(loss.relative_drop, 1.0 - 8.0 / ramp(5.99), 1e-12);
}

TEST("a weak one of 45 % is found and said to be weak") {
  const LossOfResistance loss = found_in(14.0, falls_to(0.55 * 60.0));
  CHECK(loss.found() && loss.weak);
}

TEST("a fall of 33 % is none, and the reason has its size") {
  const LossOfResistance loss = found_in(14.0, falls_to(0.67 * 60.0));
  CHECK(loss.status == Status::not_found);
  CHECK(loss.reason.find("fell by 33 %") != std::string::npos);
}

TEST("a fall that comes back is none, and the reason says when") {
  const LossOfResistance loss = found_in(20.0, [](double t) { return t > 6.0 && t < 9.0 ? 10.0 : 50.0; });
  CHECK(loss.status == Status::not_found);
  CHECK(loss.reason.find("came back after 2.9") != std::string::npos ||
        loss.reason.find("came back after 3.0") != std::string::npos);
}

TEST("a trace that ends too early cannot be decided, and what fell can still be measured") {
  const LossOfResistance loss = found_in(9.0, falls_to(8.0));
  CHECK(loss.status == Status::undecided && loss.fell());
  CHECK(loss.reason.find("ends 3.0") != std::string::npos);
  CHECK_NEAR(loss.plateau, 8.0, 0.0);
  CHECK(!found_in(6.5, falls_to(8.0)).fell());  // nothing settled yet
}

TEST("pressure held against bone is none") {
  CHECK(found_in(20.0, [](double t) { return std::min(60.0, ramp(t)); }).status == Status::not_found);
}

TEST("a slow leak is none") {
  const LossOfResistance loss =
      found_in(40.0, [](double t) { return t < 6.0 ? ramp(t) : 60.0 * std::exp(-(t - 6.0) / 5.0); });
  CHECK(loss.status == Status::not_found);  // falls by 33 % in any 2 s
  const LossOfResistance faster =
      found_in(40.0, [](double t) { return t < 6.0 ? ramp(t) : 60.0 * std::exp(-(t - 6.0) / 3.0); });
  CHECK(faster.status == Status::not_found);  // by 49 %, but there is no plateau
}

TEST("pushes of a thumb with rests of less than 5 s are none") {
  const LossOfResistance loss = found_in(40.0, [](double t) { return std::fmod(t, 4.5) < 0.5 ? 60.0 : 2.0; });
  CHECK(loss.status != Status::found);
}

TEST("flushing the needle long before is none, and hides nothing") {
  const LossOfResistance loss = found_in(30.0, [](double t) {
    if (t < 1.0) { return 20.0; }
    if (t < 10.0) { return 0.0; }
    return t < 18.0 ? 7.5 * (t - 10.0) : 8.0;
  });
  CHECK(loss.found());
  CHECK_NEAR(0.01 * static_cast<double>(loss.fallen_index), 18.0, 0.011);
}

TEST("a gap in the plateau of more than a tenth hides it") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 1400; ++n) { pressure.value.push_back(falls_to(8.0)(0.01 * n)); }
  for (std::size_t n = 700; n < 740; ++n) { pressure.value[n] = not_measured; }
  CHECK(find_loss(pressure).found());
  for (std::size_t n = 700; n < 800; ++n) { pressure.value[n] = not_measured; }
  const LossOfResistance hidden = find_loss(pressure);
  CHECK(hidden.status == Status::undecided && hidden.fell());
  CHECK(hidden.reason == "a gap hides whether a fall of 87 % was held for 5 s");  // 1 - 8 / 60
}

TEST("a gap that begins soon after the fall and never ends hides it") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 700; ++n) { pressure.value.push_back(falls_to(8.0)(0.01 * n)); }
  pressure.value.resize(3000, not_measured);
  const LossOfResistance hidden = find_loss(pressure);
  CHECK(hidden.status == Status::undecided);
  CHECK(hidden.reason.find("gap") != std::string::npos);
}

TEST("a fall within a gap longer than a fall may take is not told from a slow one") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 2000; ++n) { pressure.value.push_back(falls_to(8.0)(0.01 * n)); }
  for (std::size_t n = 550; n < 850; ++n) { pressure.value[n] = not_measured; }
  const LossOfResistance hidden = find_loss(pressure);
  CHECK(hidden.status == Status::undecided && !hidden.fell());
  CHECK(hidden.reason.starts_with("a gap of 3.01 s hides how the pressure fell by 8"));
  for (std::size_t n = 900; n < 2000; ++n) { pressure.value[n] = 50.0; }  // comes back at once: no event
  CHECK(find_loss(pressure).status == Status::not_found);
}

TEST("a gap hides nothing of a fall that was seen to come back, nor a later one that was held") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 3000; ++n) {
    pressure.value.push_back(n < 600 || (n >= 1000 && n < 1600) ? 60.0 : 8.0);
  }
  for (std::size_t n = 700; n < 800; ++n) { pressure.value[n] = not_measured; }
  const LossOfResistance later = find_loss(pressure);
  CHECK(later.found() && later.fallen_index == 1600);
  for (std::size_t n = 1600; n < 3000; ++n) { pressure.value[n] = 60.0; }
  CHECK(find_loss(pressure).status == Status::not_found);
}

TEST("a last fall that the trace cuts short is open whatever came before it") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 2000; ++n) {
    pressure.value.push_back(n > 600 && n < 900 ? 2.0 : n < 1800 ? 60.0 : 8.0);
  }
  const LossOfResistance open = find_loss(pressure);
  CHECK(open.status == Status::undecided);
  CHECK(open.reason == "the trace ends 2.00 s after a fall of 87 %; 5 s needed");
}

TEST("no pressure, no numbers and hardly any samples are none") {
  CHECK(found_in(20.0, [](double) { return -3.0; }).reason == "no pressure above zero");
  CHECK(found_in(20.0, [](double) { return not_measured; }).status == Status::not_found);
  CHECK(find_loss({}).status == Status::not_found);
}

TEST("suction in the epidural space is a drop of more than all") {
  const LossOfResistance loss = found_in(14.0, falls_to(-4.0));
  CHECK(loss.found());
  CHECK(loss.relative_drop > 1.0);
}

}  // namespace
