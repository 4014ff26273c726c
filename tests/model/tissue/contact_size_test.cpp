// SPDX-License-Identifier: MIT

#include "model/tissue/contact_size.hpp"

#include <numbers>

#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/static_equilibrium.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

constexpr double modulus = 1e4;
constexpr double a = 0.8255e-3;  // 16 gauge
using std::numbers::pi;

GridColumn column(double h, double nu, int layers) {
  CellMaterial material{.youngs_modulus = modulus};
  material.poissons_ratio = nu;
  const auto count = static_cast<std::size_t>(layers);
  return {.spacing = Eigen::Vector3d::Constant(h),
          .spring_modulus = std::vector<double>(count, material.spring_modulus()),
          .volume_modulus = std::vector<double>(count, material.volume_modulus())};
}

TEST("a deep layer has the stiffness of a half space, and of a full space far inside") {
  for (const double nu : {0.25, 0.4, 0.49}) {
    // Base at 600 radii: it stiffens a half space by about a / H (Hayes et al. 1972).
    const auto c = continuum_compliance({{0.5, modulus, nu}}, a, {0.0, 0.25});
    const double half = 2.0 * modulus * a / (1.0 - nu * nu);
    const double shear = 0.5 * modulus / (1.0 + nu);
    const double full = 32.0 * (1.0 - nu) * shear * a / (3.0 - 4.0 * nu);
    CHECK_NEAR(1.0 / c[0] / half, 1.0, 3e-3);
    CHECK_NEAR(1.0 / c[1] / full, 1.0, 3e-3);
  }
}

TEST("layers of one material are one layer, and a stiff layer below stiffens") {
  const auto one = continuum_compliance({{0.02, modulus, 0.45}}, a, {0.0, 0.004, 0.011});
  const auto three =
      continuum_compliance({{0.005, modulus, 0.45}, {0.001, modulus, 0.45}, {0.014, modulus, 0.45}},
                           a, {0.0, 0.004, 0.011});
  for (std::size_t n = 0; n < 3; ++n) { CHECK_NEAR(three[n], one[n], 1e-6 * one[n]); }
  const auto stiff =
      continuum_compliance({{0.002, modulus, 0.45}, {0.018, 100.0 * modulus, 0.45}}, a, {0.0});
  CHECK(stiff[0] < one[0]);
  CHECK(continuum_compliance({{0.02, modulus, 0.45}}, a, {0.02})[0] == 0.0);
}

TEST("the compliance at a depth does not depend on the other depths, also where plates bend") {
  const std::vector<ColumnLayer> layers{
      {6e-3, 2.4e3, 0.49}, {0.7e-3, 12.2e6, 0.45}, {14e-3, 2.4e3, 0.49}};
  const double alone = continuum_compliance(layers, 0.8e-3, {6e-3})[0];
  std::vector<double> depths{6e-3};
  for (int n = 0; n < 200; ++n) { depths.push_back(1e-4 * n); }
  // Layers of 0.1 mm have parabolas for shape functions: (k h)^2 / 20 where k h = 0.05.
  CHECK_NEAR(continuum_compliance(layers, 0.8e-3, depths)[0], alone, 1.3e-4 * alone);
}

TEST("a disc that is wide against its layer presses a column in confined compression") {
  const double nu = 0.3;
  const double radius = 0.1;
  const double thickness = 0.002;
  const auto c = continuum_compliance({{thickness, modulus, nu}}, radius, {0.0});
  const double confined = modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
  // The mean displacement under p ~ 1 / sqrt(a^2 - r^2) cut off at the thickness h from the edge:
  // c = h / (M pi a^2) (ln(2 a / h) / 2 + O(1)); the bracket is between 1 and 4 here.
  const double column = thickness / (confined * 3.14159265 * radius * radius);
  CHECK(c[0] > column);
  CHECK(c[0] < 4.0 * column);
}

TEST("a fine grid under a spread force has the compliance of the continuum") {
  // Disc of 8 cells' radius, bilinear weights of 64 x 64 points of a punch's pressure.
  for (const double nu : check::sanitized ? std::vector{0.45} : std::vector{0.25, 0.45}) {
    const double h = 1e-3;
    const double radius = 8e-3;
    std::vector<PlaneSupport> disc;
    double total = 0.0;
    for (int i = -8; i <= 8; ++i) {
      for (int j = -8; j <= 8; ++j) {
        double weight = 0.0;
        for (int n = 0; n < 400; ++n) {
          const double x = (i - 0.5 + (n % 20 + 0.5) / 20.0) * h;
          const double y = (j - 0.5 + (n / 20 + 0.5) / 20.0) * h;
          const double rest = radius * radius - x * x - y * y;
          if (rest > 0.0) { weight += 1.0 / std::sqrt(rest); }
        }
        if (weight > 0.0) { disc.push_back({{i * h, j * h}, weight}); }
        total += weight;
      }
    }
    for (PlaneSupport& s : disc) { s.weight /= total; }
    const int layers = 40;
    const auto grid = grid_compliance(column(h, nu, layers),
                                      std::vector<std::vector<PlaneSupport>>(layers, disc));
    const auto exact = continuum_compliance({{layers * h, modulus, nu}}, radius, {0.0, 0.02});
    // Error of the spacing over the radius, to second order inside: (h / a)^2 = 1.6 %; the edge of
    // the disc is resolved to half a cell, 6 %.
    CHECK_NEAR(grid[0].own / exact[0], 1.0, 0.06);
    CHECK_NEAR(grid[20].own / exact[1], 1.0, 0.06);
  }
}

TEST("a point load on a lattice has the stiffness 0.85 E h") {
  // The referee's 0.83 to 0.87 E h for nu = 1/4, measured on finite blocks.
  const std::vector<std::vector<PlaneSupport>> point(20, {{{0.0, 0.0}, 1.0}});
  const auto c = grid_compliance(column(5e-3, 0.25, 20), point);
  CHECK_NEAR(1.0 / c[0].own / (modulus * 5e-3), 0.85, 0.03);
}

TEST("a rigid disc on a layer has the published stiffness, and a rectangle that of a rigid punch") {
  // Table 1 of Hayes et al. 1972 for nu = 0.5 and a / h = 0.2 to 1; for nu = 0.4999 kappa is lower
  // by 1e-3 at most.
  const double nu = 0.4999;
  for (const auto& [ratio, kappa] : {std::pair{0.2, 1.281}, {0.6, 2.211}, {1.0, 3.609}}) {
    const Probe disc{.size = {2.0 * a, 2.0 * a}};
    const FaceCompliance face = face_compliance({{a / ratio, modulus, nu}}, disc);
    const double half_space = 2.0 * modulus * a / (1.0 - nu * nu);
    CHECK_NEAR(1.0 / face.at(face.best_pressure()) / half_space / kappa, 1.0, 4e-3);
    CHECK(face.at(face.best_pressure()) <= face.terms(0, 0));
  }
  // Skin 200 times as stiff as the fat below, against Hayes' integral equation for layers. A flat
  // punch's pressure alone is 20 % too soft for a radius of five thicknesses.
  for (const auto& [ratio, error] :
       {std::pair(1.0, 2e-3), {5.0, 2e-3}, {10.0, 2e-3}, {20.0, 2e-2}}) {
    const double radius = 1e-3 * ratio;
    const FaceCompliance skin = face_compliance({{0.001, 1e6, 0.48}, {0.023, 5e3, 0.49}},
                                                {.size = {2.0 * radius, 2.0 * radius}});
    const double kappa =
        reference::punch_on_layers(radius, {{0.001, 1e6, 0.48}, {0.023, 5e3, 0.49}}).kappa;
    const double exact = kappa * 2.0 * 1e6 * radius / (1.0 - 0.48 * 0.48);
    CHECK_NEAR(1.0 / skin.at(skin.best_pressure()), exact, error * exact);
    if (ratio == 5.0) { CHECK_NEAR(exact, 172.92, 0.01); }
  }
  // Square on a half space: as the electric capacitance of a plate, 0.36679 times its side (F. H.
  // Read, J. Comput. Phys. 133, 1, 1997), 1.0212 times the disc of the same area. The base at 300
  // half sides stiffens by 0.4 %.
  const Probe square{.shape = Probe::Shape::ultrasound, .size = {2.0 * a, 2.0 * a}};
  const FaceCompliance face = face_compliance({{300.0 * a, modulus, 0.25}}, square);
  const double same_area = 2.0 * modulus * square.radius() / (1.0 - 0.0625);
  CHECK_NEAR(1.0 / face.at(face.best_pressure()) / same_area, 1.0212, 0.005);
}

TEST("a uniform pressure on a half space moves its face by the mean of the closed form") {
  // Disc: 3 pi^2 E a / (16 (1 - nu^2)) (K. L. Johnson, Contact Mechanics, 1985, ch. 3); square of
  // side l: pi E l / (1 - nu^2) over 4 ln(1 + sqrt 2) + 4 (1 - sqrt 2) / 3, the mean of l / r over
  // all pairs of its points. The base at 300 radii stiffens by 0.4 %.
  const double nu = 0.25;
  const std::vector<ColumnLayer> deep{{300.0 * a, modulus, nu}};
  const Probe disc{.size = {2.0 * a, 2.0 * a}, .face = Probe::FaceKind::uniform};
  const FaceCompliance face = face_compliance(deep, disc);
  const double exact = 3.0 * pi * pi * modulus * a / (16.0 * (1.0 - nu * nu));
  CHECK(face.terms.size() == 1);
  CHECK_NEAR(1.0 / face.at(face.best_pressure()) / exact, 1.0, 5e-3);
  const Probe square{.shape = Probe::Shape::ultrasound,
                     .size = {2.0 * a, 2.0 * a},
                     .face = Probe::FaceKind::uniform};
  const double pairs = 4.0 * std::log(1.0 + std::sqrt(2.0)) + 4.0 * (1.0 - std::sqrt(2.0)) / 3.0;
  const double of_square = pi * modulus * 2.0 * a / (1.0 - nu * nu) / pairs;
  CHECK_NEAR(1.0 / face_compliance(deep, square).terms(0, 0) / of_square, 1.0, 5e-3);
  // On layers, against the quadrature of the reference.
  const double layered = face_compliance({{0.001, 1e6, 0.48}, {0.023, 5e3, 0.49}},
                                         {.size = {0.015, 0.015}, .face = Probe::FaceKind::uniform})
                             .terms(0, 0);
  const double kappa =
      reference::uniform_pressure_on_layers(0.0075, {{0.001, 1e6, 0.48}, {0.023, 5e3, 0.49}}).kappa;
  CHECK_NEAR(layered * kappa * 2.0 * 1e6 * 0.0075 / (1.0 - 0.48 * 0.48), 1.0, 1e-3);
}

/// Law of a fingertip on layers without a grid.
DentTable sphere_alone(const std::vector<ColumnLayer>& layers, const Probe& probe) {
  DentTable table = sphere_dents(layers, probe);
  table.set_gaps(1e-3, std::vector<double>(table.dent.size(), 0.0), 1e-6);
  table.compliance = {1e-3};
  return table;
}

TEST("a spherical fingertip on a half space has Hertz's force, and then that of a flat punch") {
  const double radius = 0.0075;
  for (const double tip : {0.0075, 0.02}) {
    for (const double nu : {0.25, 0.49}) {
      const DentTable table = sphere_alone({{300.0 * radius, modulus, nu}},
                                           {.size = {0.015, 0.015}, .tip_radius = tip});
      const DentLaw law{.compliance = 1e-3, .table = &table};
      const double plane = modulus / (1.0 - nu * nu);
      const double full = 4.0 * plane * std::pow(radius, 3) / (3.0 * tip);
      // The base stiffens by 0.4 % at the whole face; the table is linear between contact radii
      // 1.076 apart, by which its dents are at most 0.15 % too small: (2 / 9) ln(1.076^3)^2 / 8.
      for (const double share : {1e-3, 3.1e-3, 1e-2, 3.3e-2, 1e-1, 0.37, 1.0}) {
        const double hertz = std::cbrt(9.0 * std::pow(share * full / plane, 2) / (16.0 * tip));
        CHECK_NEAR(law.gap(share * full) / hertz, 1.0, 0.01);
      }
      for (const double share : {1.2, 4.0}) {
        CHECK_NEAR(law.slope(law.gap(share * full)) / (2.0 * plane * radius), 1.0, 5e-3);
      }
    }
  }
}

TEST("a spherical fingertip on layers has the force of Hayes' equation") {
  for (const bool skin : {false, true}) {
    const double first = skin ? 0.001 : 0.004;
    const double stiff = skin ? 1e6 : 2e4;
    const Probe probe{.size = {0.015, 0.015}, .tip_radius = 0.03};
    const DentTable table = sphere_alone({{first, stiff, 0.48}, {0.023, 5e3, 0.49}}, probe);
    const DentLaw law{.compliance = 1e-3, .table = &table};
    for (const double share : {0.03, 0.2, 0.5, 0.9, 1.5}) {
      const double dent = share * law.gap(table.step);
      const reference::SphereForce exact = reference::sphere_on_layers(
          dent, {.radius = 0.0075, .tip_radius = 0.03}, {{first, stiff, 0.48}, {0.023, 5e3, 0.49}});
      CHECK_NEAR(law.force(dent) / exact.force, 1.0, 0.01);
      CHECK(exact.uncertainty < 1e-4);
    }
  }
}

TEST("gap, slope and energy of a spherical fingertip belong to its force, however stiff the grid") {
  const Probe probe{.size = {0.015, 0.015}, .tip_radius = 0.02};
  const std::vector<ColumnLayer> layers{{0.03, modulus, 0.45}};
  const FaceCompliance face = face_compliance(layers, {.size = probe.size});
  const double flat = face.at(face.best_pressure());
  for (const double of_grid : {0.0, 0.6, 1.05}) {  // the last is softer than the continuum
    DentTable table = sphere_dents(layers, probe);
    std::vector<double> own;
    for (const double multiple : table.multiple) {
      own.push_back(of_grid * flat * multiple * table.step);
    }
    table.set_gaps(flat, own, 0.01);
    table.compliance = {flat};
    const DentLaw law{.compliance = flat, .table = &table};
    const double most = law.gap(1.5 * table.step);
    const double step = most / 20000.0;
    double energy = 0.0;
    double steepest = 0.0;
    for (int n = 0; n < 20000; ++n) {
      energy += step * law.force((n + 0.5) * step);
      steepest = std::max(steepest, law.slope((n + 0.5) * step));
    }
    // The midpoint rule misses each of 49 bends by at most a step.
    CHECK_NEAR(law.energy(most), energy, 1e-5 * energy);
    CHECK_NEAR(table.least_compliance() * steepest, 1.0, 1e-9);
    CHECK(table.least_compliance() > (1.0 - 1e-9) * 0.01 * flat);
    for (const double share : {0.002, 0.11, 0.63, 1.4}) {
      const double force = share * table.step;
      const double gap = law.gap(force);
      CHECK_NEAR(law.force(gap), force, 1e-12);
      const double small = 1e-7 * gap;
      const double slope = (law.force(gap + small) - law.force(gap - small)) / (2.0 * small);
      CHECK_NEAR(law.slope(gap), slope, 1e-6 * slope);
      // The grid gives the rest of the dent.
      if (of_grid < 1.0) {
        const double dent = gap + of_grid * flat * force;
        CHECK_NEAR(dent / sphere_alone(layers, probe).phi(force) / 1e-3, 1.0, 1e-9);
      }
    }
    CHECK_NEAR(law.slope(most) * (flat - std::min(of_grid * flat, 0.99 * flat)), 1.0, 1e-6);
  }
}

TEST("the points of a face carry the force of its pressure") {
  for (const auto shape : {Probe::Shape::fingertip, Probe::Shape::ultrasound}) {
    const Probe probe{.shape = shape, .size = {2.0 * a, 2.0 * a}};
    const bool disc = shape == Probe::Shape::fingertip;
    for (const double share : {0.0, 0.4}) {
      // Terms of a mixture of a flat punch's pressure and a share of Hertz's: 3 u^2 = 1 + 2 P_2(u)
      // and 4 (1 - x^2) (1 - y^2) = (1 - T_2(x)) (1 - T_2(y)).
      FacePressure pressure = FacePressure::Unit(std::ssize(face_terms(probe)), 0);
      for (std::size_t n = 0; n < face_terms(probe).size(); ++n) {
        const std::array<int, 2> order = face_terms(probe)[n];
        const double hertz = disc ? 2.0 : order[0] == order[1] ? 1.0 : -1.0;
        const bool has = order[0] <= 1 && order[1] <= 1 && n > 0;
        if (has) { pressure(static_cast<Eigen::Index>(n)) = share * hertz; }
      }
      double force = 0.0;
      double square = 0.0;
      for (const ProbeFace::Point& p : face_points(probe, pressure, {0.3 * a, 0.3 * a})) {
        force += p.share;
        square += p.share * p.place.x() * p.place.x();
      }
      CHECK_NEAR(force, 1.0, 1e-12);
      // Mean of x^2: disc a^2 / 3 and a^2 / 5, rectangle a^2 / 2 and a^2 / 4.
      const double exact = disc ? (1.0 - share) / 3.0 + share / 5.0 : 0.5 - 0.25 * share;
      CHECK_NEAR(square / (a * a), exact, 2e-3);
    }
    // Uniform pressure: a^2 / 4 and a^2 / 3.
    const Probe uniform{.shape = shape, .size = probe.size, .face = Probe::FaceKind::uniform};
    double square = 0.0;
    for (const ProbeFace::Point& p :
         face_points(uniform, FacePressure::Ones(1), {0.3 * a, 0.3 * a})) {
      CHECK(p.share > 0.0);
      square += p.share * p.place.x() * p.place.x();
    }
    CHECK_NEAR(square / (a * a), disc ? 0.25 : 1.0 / 3.0, 2e-3);
  }
}

TEST("a face that moves by a spacing has the same shares, a node further") {
  const FacePressure pressure = Eigen::Vector<double, 5>(1.0, 0.2, -0.3, 0.1, 0.0);
  ProbeFace face{.points = face_points({.size = {0.015, 0.015}}, pressure, {0.004, 0.004}),
                 .first = {-0.04, -0.04},
                 .spacing = {0.004, 0.004},
                 .count = {21, 21},
                 .node = std::vector<int>(441, 1)};
  std::vector<double> here(441);
  std::vector<double> there(441);
  for (const double x : {0.0, 0.0013, -0.0079}) {
    face.press({x, 0.002}, here);
    face.press({x + 0.004, 0.002}, there);
    double sum = 0.0;
    double largest = 0.0;
    double change = 0.0;
    for (std::size_t n = 0; n + 1 < 441; ++n) {
      sum += here[n];
      largest = std::max(largest, std::abs(there[n + 1] - here[n]));
    }
    CHECK_NEAR(sum, 1.0, 1e-14);
    CHECK_NEAR(largest, 0.0, 1e-14);
    // The shares are continuous: a way of 1e-6 of a spacing changes none by more than that.
    face.press({x + 4e-9, 0.002}, there);
    for (std::size_t n = 0; n < 441; ++n) {
      change = std::max(change, std::abs(there[n] - here[n]));
    }
    CHECK(change > 0.0);
    CHECK(change < 1e-6);
  }
}

TEST("a contact with a toe is a cone up to its toe and a flat punch beyond") {
  const double c = 2e-3;
  const double toe = 5e-3;
  constexpr double rest = DentLaw::slope_at_rest;
  // Without a grid the gap is the dent of the continuum (Sneddon 1965, and the slope at rest).
  const DentLaw alone{.compliance = c, .continuum = c, .toe = toe};
  for (const double dent : {1e-4, 1e-3, 4e-3}) {
    CHECK_NEAR(alone.force(dent), (rest * dent + (1.0 - rest) * dent * dent / (2.0 * toe)) / c,
               1e-12);
  }
  CHECK_NEAR(alone.force(9e-3), (9e-3 - 0.5 * (1.0 - rest) * toe) / c, 1e-12);
  CHECK_NEAR(alone.slope(9e-3), 1.0 / c, 1e-9);
}

TEST("gap, slope and energy of a contact with a toe belong to its force") {
  for (const double of_grid : {0.0, 0.4, 0.95}) {
    const DentLaw law{.compliance = 2e-3 * (1.0 - of_grid), .continuum = 2e-3, .toe = 5e-3};
    double energy = 0.0;
    constexpr double step = 1e-6;
    for (double gap = 0.0; gap < 8e-3; gap += step) {
      energy += step * law.force(gap + 0.5 * step);
    }
    // The midpoint rule's error is of the second order in the step.
    CHECK_NEAR(law.energy(8e-3), energy, 1e-6 * energy);
    for (const double gap : {1e-4, 2e-3, 8e-3}) {
      CHECK_NEAR(law.gap(law.force(gap)), gap, 1e-14);
      const double slope = (law.force(gap + step) - law.force(gap - step)) / (2.0 * step);
      CHECK_NEAR(law.slope(gap), slope, 1e-5 * slope);
    }
    CHECK(law.force(-1e-3) < 0.0);
  }
}

TEST("the grid and a contact with a toe are together as soft as the continuum") {
  const DentLaw alone{.compliance = 2e-3, .continuum = 2e-3, .toe = 5e-3};
  const DentLaw above{.compliance = 0.5e-3, .continuum = 2e-3, .toe = 5e-3};
  for (const double force : {0.01, 0.5, 3.0}) {
    CHECK_NEAR(above.gap(force) + 1.5e-3 * force, alone.gap(force), 1e-15);
  }
}

TEST("dents in large deformation begin as those of the layered continuum") {
  for (const double thickness : {5e-3, 28e-3}) {
    const std::vector<ColumnLayer> layers{{2e-3, 1.5e6, 0.48}, {thickness, 9.1e3, 0.49}};
    const double exact = continuum_compliance(layers, 0.8e-3, {0.0})[0];
    const std::vector<double> dents = large_dents(layers, 0, 0.8e-3, {1e-4, 4.0});
    CHECK(dents.size() == 2);
    // Rings of a quarter of the skin and half of the tip are stiffer than the continuum.
    CHECK_NEAR(dents.at(0) / 1e-4, exact, 0.04 * exact);
    CHECK(dents.at(0) / 1e-4 < exact);
    // A plate in tension is stiffer than a bent one.
    CHECK(dents.at(1) / 4.0 < 0.95 * exact);
  }
}

TEST("a membrane between softer layers is dented like the layered continuum, then by its tension") {
  for (const double thickness : {0.3e-3, 0.7e-3}) {
    const std::vector<ColumnLayer> layers{
        {6e-3, 2.4e3, 0.49}, {thickness, 12.2e6, 0.45}, {14e-3, 2.4e3, 0.49}};
    const double exact = continuum_compliance(layers, 0.8e-3, {6e-3})[0];
    const std::vector<double> dents = large_dents(layers, 1, 0.8e-3, {1e-4, 0.1, 0.4, 1.0, 2.0});
    REQUIRE(dents.size() == 5);
    // Rings that grow by a fifth from one to the next.
    CHECK_NEAR(dents.at(0) / 1e-4, exact, 0.02 * exact);
    // Dents grow with the force where a plate bends, and with its cube root where it is in tension.
    CHECK(dents.at(4) / dents.at(3) > std::cbrt(2.0));
    CHECK(dents.at(4) / dents.at(3) < 2.0);
    // needle/dura: the independent solution is 0.40 of the linear one.
    CHECK(dents.at(4) < 0.5 * exact * 2.0);
  }
}

TEST("layers that a tip would pierce have no dent in large deformation") {
  CHECK(large_dents({{2e-3, 1e3, 0.48}, {20e-3, 1e2, 0.48}}, 0, 0.8e-3, {1e-3, 10.0}).empty());
}

/// Law of a contact of 2 mm/N on a skin of 2 mm, and the dents of the grid, linear and stiffening.
DentTable some_large_dent(const std::vector<double>& own, double own_end) {
  DentTable large{.step = 1.0,
                  .multiple = {0.0, 1.0, 2.0, 3.0},
                  .dent = {0.0, 3e-3, 5e-3, 6e-3},
                  .end_dent = 5.2e-3};
  large.complete({.end = 2e-3, .cutting_force = 2.5}, {0.0, 1e-3, 2e-3, 3e-3},
                 {2e-3, 1.9e-3, 1.7e-3, 1.5e-3}, own, own_end);
  return large;
}

TEST("the grid and a contact on a skin give the dent of the continuum together") {
  const std::vector<double> own{0.0, 1e-3, 1.8e-3, 2.5e-3};
  const DentTable large = some_large_dent(own, 1.9e-3);
  const auto law = [&](std::size_t depth) {
    return DentLaw{.compliance = large.compliance[depth], .table = &large};
  };
  for (std::size_t n = 0; n < own.size(); ++n) {
    CHECK_NEAR(law(0).gap(static_cast<double>(n)) + own[n], large.dent[n], 1e-15);
  }
  CHECK_NEAR(law(2).gap(2.5) + 1.9e-3, large.end_dent, 1e-15);
  CHECK_NEAR(law(3).gap(2.5), law(2).gap(2.5), 0.2e-3 * 2.5 + 1e-15);
}

TEST("a skin that is punctured and then cut without force has a law") {
  DentTable large{.step = 1.0, .multiple = {0.0, 1.0, 2.0}, .dent = {0.0, 3e-3, 5e-3}};
  large.complete({.end = 2e-3}, {0.0, 2e-3}, {2e-3, 1.7e-3}, {0.0, 1e-3, 2e-3}, 0.0);
  const DentLaw law{.compliance = large.compliance[1], .table = &large};
  CHECK_NEAR(law.compliance, 1.7e-3, 0.0);
  CHECK_NEAR(law.gap(0.0), 0.0, 0.0);
  CHECK_NEAR(law.force(law.gap(1.5)), 1.5, 1e-12);
}

TEST("gap, slope and energy of a contact on a skin belong to its force, however stiff the grid") {
  // The last grid gives way by more than the continuum.
  for (const std::vector<double>& own : {std::vector<double>{0.0, 1e-3, 1.8e-3, 2.5e-3},
                                         std::vector<double>{0.0, 2e-3, 5.5e-3, 8e-3}}) {
    const DentTable large = some_large_dent(own, 1.9e-3);
    const DentLaw law{.compliance = large.compliance[1], .table = &large};
    const double most = law.gap(4.0);
    const double step = most / 20000.0;
    double energy = 0.0;
    for (int n = 0; n < 20000; ++n) { energy += step * law.force((n + 0.5) * step); }
    // The midpoint rule misses each bend by at most a step.
    CHECK_NEAR(law.energy(most), energy, 1e-6 * energy);
    for (const double force : {0.3, 1.5, 2.7, 4.0}) {
      const double gap = law.gap(force);
      CHECK_NEAR(law.force(gap), force, 1e-12);
      const double slope =
          (law.force(gap + 0.01 * step) - law.force(gap - 0.01 * step)) / (0.02 * step);
      CHECK_NEAR(law.slope(gap), slope, 1e-6 * slope);
      CHECK(law.slope(gap) * DentTable::least_slope * law.compliance < 1.0 + 1e-9);
    }
    CHECK_NEAR(law.force(-1e-3), law.slope(0.0) * -1e-3, 1e-12);
  }
}

TEST("tissue behind a gap has the contact that it has alone") {
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {9, 9}, .spacing = 0.005};
  scene.materials = {{.name = "sheet", .youngs_modulus = 5e5, .density = 1000.0},
                     {.name = "ground", .youngs_modulus = 2e4, .density = 1000.0}};
  scene.tissue.layers = {{"ground", "ground", 0.02}};
  scene.needle = Needle{};
  const auto compliance_of = [](const Scene& of) {
    const SpringNetwork network = build_network(of);
    return NeedlePath(of, network).tip_compliance(of, network);
  };
  const TipCompliance alone = compliance_of(scene);
  scene.tissue.layers = {{"sheet", "sheet", 0.005},
                         {.tissue = "air", .thickness = 0.01, .gap = true},
                         {"ground", "ground", 0.02}};
  const TipCompliance behind = compliance_of(scene);
  REQUIRE(!alone.value.empty());
  REQUIRE(!behind.value.empty());
  CHECK(behind.at(0.0) < 0.1 * alone.at(0.0));  // of the sheet, which is 25 times as stiff
  for (double depth = 0.0; depth < 0.0149; depth += 0.5e-3) {
    CHECK_NEAR(behind.at(0.015 + depth), alone.at(depth), 1e-6 * alone.at(0.0));
  }
  // A sheet behind the gap, which would be dented deeper than it is thick.
  scene.materials[0].cutting_force = 30.0;
  scene.tissue.layers.insert(scene.tissue.layers.begin() + 2, {"sheet", "sheet", 0.005});
  CHECK(compliance_of(scene).tables.empty());  // it is no skin, and has no tissue before it
}

}  // namespace PALPATE_FILE
