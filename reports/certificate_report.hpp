// SPDX-License-Identifier: MIT
#pragma once
/// Contents of certificate.json, histogram.csv and report.html of a real-time certificate.

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

/// Property of the machine. It has no value if the system does not report it.
struct EnvironmentFact {
  std::string key{};    ///< key in certificate.json
  std::string label{};  ///< label on the page
  std::variant<std::monostate, bool, double, std::string> value{};
};

struct CertificateReport {
  std::string file{};  ///< file name of the scene, without folder
  std::string title{};
  std::string scene_hash{};      ///< SHA-256 over the five items below
  std::string resolved_scene{};  ///< the scene that ran, with every key
  std::vector<std::pair<std::string, std::string>> inputs{};  ///< name and SHA-256 of each file
  std::string subject_hash{};     ///< SHA-256 of the library of another simulator than the model
  std::string subject_options{};  ///< JSON that it received
  std::string code_hash{};        ///< of the object code that computes
  std::string program_hash{};     ///< SHA-256 of the program's file; not in scene_hash
  long nodes = 0;
  long springs = 0;
  certificate::Certificate result{};
  std::vector<EnvironmentFact> environment{};
  std::optional<double> cycles_per_second{};  ///< of the time stamp counter, if constant [1/s]
  std::string not_counted{};  ///< reason why the instructions of the slowest tick are not counted
  std::function<std::string(const ToolHappening&)> happening_name{};
  std::string command{};
  std::map<std::string, std::string> provenance{};
};

/// Percentiles of tick times, with their names.
inline constexpr std::array<std::pair<const char*, double>, 5> shown_percentiles{
    {{"p50", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"p99.9", 0.999}, {"p99.99", 0.9999}}};

/// Contents of certificate.json. Its last key `seal` is the SHA-256 of the file with 64 zeros in
/// the place of the seal; the seal covers the SHA-256 of histogram.csv.
std::string to_json(const CertificateReport& report);
std::string to_csv(const CertificateReport& report);  ///< histograms of tick times
std::string to_html(const CertificateReport& report);

/// Verdict and reason of a certificate whose seal fits.
struct SealedVerdict {
  std::string verdict{};
  std::string reason{};
};

/// Returns what a certificate.json says, given the contents of it and of its histogram.csv. Throws
/// InputError, which begins with the name of the file, if its seal or the histogram does not fit.
SealedVerdict verified_certificate(const std::string& json, const std::string& histogram,
                                   const std::string& file);

/// Phase with its name, such as "the scene, load cpu". Phases of the heaviest load come first.
struct NamedPhase {
  std::string name{};
  const certificate::Phase* phase = nullptr;
  bool empty = false;  ///< true for the empty loop, which runs without the scene
};
std::vector<NamedPhase> phases_of(const CertificateReport& report);

}  // namespace palpate
