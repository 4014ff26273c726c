// SPDX-License-Identifier: MIT
#pragma once
/// certificate.json, histogram.csv and report.html of a real-time certificate.

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "reports/html/html_page.hpp"
#include "validation/certificate/certificate.hpp"

namespace palpate {

/// A property of the machine; no value if the system does not report it.
struct EnvironmentFact {
  std::string key{};    ///< of certificate.json
  std::string label{};  ///< of the page
  std::variant<std::monostate, bool, double, std::string> value{};
};

struct CertificateReport {
  std::string file{};  ///< of the scene, name alone
  std::string title{};
  std::string scene_hash{};
  certificate::Certificate result{};
  std::vector<EnvironmentFact> environment{};
  std::optional<double>
      cycles_per_second{};    ///< of the processor's counter, where it never changes
  std::string not_counted{};  ///< why there are no instructions of the costliest tick
  std::function<std::string(const ToolHappening&)> happening_name{};
  std::string command{};
  std::map<std::string, std::string> provenance{};
};

/// Percentiles of the times of ticks, by name.
inline constexpr std::array<std::pair<const char*, double>, 5> shown_percentiles{
    {{"p50", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"p99.9", 0.999}, {"p99.99", 0.9999}}};

std::string to_json(const CertificateReport& report);
std::string to_csv(const CertificateReport& report);  ///< the histograms
std::string to_html(const CertificateReport& report);

std::vector<Table> certificate_tables(
    const CertificateReport& report);  ///< phases, misses, provocations, tail
/// Histograms of the responses of scene and empty loop, and of the parts of the scene's responses;
/// none if nothing ran.
std::vector<Figure> histogram_figures(const CertificateReport& report);

/// Phases with their names, those of the worst load first: "the scene, load cpu".
struct NamedPhase {
  std::string name{};
  const certificate::Phase* phase = nullptr;
  bool empty = false;  ///< the empty loop, which has no place in the scene
};
std::vector<NamedPhase> phases_of(const CertificateReport& report);

/// "puncture: skin", or nothing.
std::string happening_at(const CertificateReport& report, const certificate::Moment& moment);

}  // namespace palpate
