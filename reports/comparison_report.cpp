// SPDX-License-Identifier: MIT
#include "reports/comparison_report.hpp"

#include <algorithm>
#include <iterator>

#include "fixtures/io/recording_fields.hpp"
#include "reports/comparison_figures.hpp"
#include "reports/comparison_tables.hpp"
#include "reports/comparison_words.hpp"
#include "reports/figure_svg.hpp"
#include "reports/html_page.hpp"
#include "reports/markup.hpp"

namespace palpate {

using namespace comparison;

namespace {

/// So many recordings are shown with all their figures; of more, each shows one.
constexpr std::size_t few_recordings = 3;
/// Beyond these a recording has tables alone: a page stays below some megabytes.
constexpr std::size_t most_drawn = 60;

/// The figures of one recording or one group, drawn.
struct Exhibits {
  std::vector<Figure> figures{};
  std::vector<std::string> drawings{};
};

struct Drawn {
  std::vector<Exhibits> recordings{};
  std::vector<Exhibits> groups{};
};

bool compared(const Comparison& one) { return one.verdict != Verdict::not_comparable; }

std::vector<Figure> figures_of(const ComparisonReport& report, std::size_t n) {
  if (!compared(report.found.recordings[n]) || n >= most_drawn) { return {}; }
  if (report.recordings.size() <= few_recordings) { return recording_figures(report, n); }
  return {overlay_figure(report, n)};
}

/// All by one process of gnuplot.
Drawn draw(const ComparisonReport& report) {
  Drawn drawn;
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    drawn.recordings.push_back({.figures = figures_of(report, n)});
  }
  for (std::size_t n = 0; n < report.found.groups.size(); ++n) {
    drawn.groups.push_back({.figures = group_figures(report, n)});
  }
  std::vector<const Figure*> all;
  for (const auto* list : {&drawn.recordings, &drawn.groups}) {
    for (const Exhibits& exhibits : *list) {
      for (const Figure& figure : exhibits.figures) { all.push_back(&figure); }
    }
  }
  std::vector<std::string> svgs = draw_figures(all);
  auto next = svgs.begin();
  for (auto* list : {&drawn.recordings, &drawn.groups}) {
    for (Exhibits& exhibits : *list) {
      for (std::size_t n = 0; n < exhibits.figures.size(); ++n) {
        exhibits.drawings.push_back(std::move(*next++));
      }
    }
  }
  return drawn;
}

std::string html_of(const Exhibits& exhibits) {
  if (exhibits.figures.empty()) { return {}; }
  std::string html = "<div class=\"exhibits\">\n";
  for (std::size_t n = 0; n < exhibits.figures.size(); ++n) {
    html += html_figure(exhibits.figures[n], exhibits.drawings[n]);
  }
  return html + "</div>\n";
}

std::string simulation_words(const ComparedSimulation& simulation) {
  const bool scene = simulation.origin == ComparedSimulation::Origin::scene;
  return (scene ? "simulated from " : "read from ") + simulation.file.filename().string() +
         (simulation.title.empty() ? "" : ": " + simulation.title);
}

void add_simulation_facts(std::vector<Fact>& facts, const ComparedSimulation& simulation) {
  const std::vector<double>& time = simulation.trace.time;
  facts.push_back(
      {"simulation", simulation_words(simulation),
       time.empty() ? "" : quantity(time.back() - time.front(), "s") + " long; FNV-1a " + simulation.hash});
  if (simulation.run_longer > 0.0) {
    facts.push_back(
        {"run longer by", quantity(simulation.run_longer, "s"),
         "than the scene says: the loss of resistance counts once its pressure stayed low for 5 s"});
  }
}

std::vector<Fact> key_facts(const ComparisonReport& report) {
  const ComparisonOptions& o = report.options.comparison;
  std::vector<Fact> facts{{"recordings", kinds_of(report), tally_of(report)},
                          {"quantity", std::string(comparison::name_of(o.quantity)),
                           "verdicts come from features and corridor; ratings explain"}};
  if (report.recordings.size() > 1) {
    facts.insert(facts.begin() + 1,
                 {"subjects", std::to_string(subjects_compared(report)),
                  "who could be compared; a recording that does not say whose it is counts as one"});
  }
  add_simulation_facts(facts, report.simulation);
  const auto& all = report.found.recordings;
  const auto first = std::ranges::find_if(all, compared);
  if (first == all.end()) { return facts; }
  facts.push_back(
      {"clocks", "aligned " + first->alignment.how,
       "asked for: " + std::string(comparison::name_of(o.alignment)) +
           (all.size() > 1 ? "; of the first recording" : "; lag " + quantity(first->alignment.lag, "s"))});
  const double cutoff = first->cutoff;
  facts.push_back({"filter", cutoff > 0.0 ? quantity(cutoff, "Hz") : "none",
                   "low-pass without phase, the same for both; at most a quarter of the lower rate"});
  return facts;
}

/// A sentence under the heading of every recording that is no measurement.
std::string honesty_of(const Recording& recording) {
  if (recording.kind == Recording::Kind::measured) { return {}; }
  return "<p class=\"reason\">" + std::string(io::reconstruction_note) + ": not a measurement</p>\n";
}

std::string recording_article(const ComparisonReport& report, std::size_t n, const Exhibits& exhibits) {
  const Comparison& one = report.found.recordings[n];
  const Recording& recording = report.recordings[n].input.recording;
  std::string html = "<article>\n<h3>" + html_badge(one.verdict) + " <span>" +
                     escape_markup(recording.name) + "</span></h3>\n" +
                     honesty_of(recording);
  if (!recording.note.empty()) { html += "<p class=\"soft\">" + escape_markup(recording.note) + "</p>\n"; }
  if (report.recordings.size() > 1 || report.found.reasons.size() == 1) { html += html_notes(one.reasons); }
  html += html_of(exhibits);
  if (!compared(one)) { return html + "</article>\n"; }
  if (recording.depth.empty()) {
    html += "<p class=\"soft\">Depth was not recorded, so nothing is shown over depth.</p>\n";
  }
  if (report.recordings.size() <= few_recordings) {
    return html + html_features(one.features) + "</article>\n";
  }
  return html + "<details><summary>features, tolerances and verdicts</summary>\n" +
         html_features(one.features) + "</details></article>\n";
}

/// One reason stands in the banner already; many are folded.
std::string reasons_section(const ComparisonReport& report) {
  constexpr std::size_t many = 8;
  const std::vector<std::string>& reasons = report.found.reasons;
  if (reasons.size() < 2) { return {}; }
  const std::string notes = html_notes(reasons);
  return "<h2>Why</h2>\n" + (reasons.size() < many ? notes
                                                   : "<details><summary>" + std::to_string(reasons.size()) +
                                                         " reasons</summary>\n" + notes + "</details>\n");
}

std::string groups_section(const ComparisonReport& report, const Drawn& drawn) {
  if (report.recordings.size() < 2) { return {}; }
  std::string html = "<section>\n<h2>Groups of subjects</h2>\n" + html_groups(report);
  for (std::size_t n = 0; n < report.found.groups.size(); ++n) {
    const GroupSummary& group = report.found.groups[n];
    if (group.features.empty()) { continue; }
    html += "<article>\n<h3>" + html_badge(group.verdict) + " <span>" +
            escape_markup(name_of_group(group.group)) + "</span></h3>\n" +
            (report.found.groups.size() > 1 ? html_notes(group.reasons) : "") + html_of(drawn.groups[n]);
    if (!group.means.empty()) {
      html += "<p class=\"soft\">The simulated insertion against the means over subjects:</p>\n" +
              html_features(group.means);
    }
    html += html_table(subjects_table(group)) + "</article>\n";
  }
  return html + "</section>\n";
}

std::string recordings_section(const ComparisonReport& report, const Drawn& drawn) {
  std::string html = "<section>\n<h2>" +
                     std::string(report.recordings.size() == 1 ? "The recording" : "Every recording") +
                     "</h2>\n";
  if (report.recordings.size() > most_drawn) {
    html += "<p class=\"soft\">The first " + std::to_string(most_drawn) +
            " are drawn; of the others there are tables.</p>\n";
  }
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    html += recording_article(report, n, drawn.recordings[n]);
  }
  return html + "</section>\n";
}

std::vector<Fact> rule_facts(const ComparisonReport& report) {
  const ComparisonOptions& o = report.options.comparison;
  const LossRule& loss = o.features.loss;
  const auto percent = [](double share) { return quantity(100.0 * share, "%"); };
  return {
      {"loss of resistance",
       "a fall by " + percent(loss.least_drop) + " within " + quantity(loss.longest_fall, "s"),
       "held for " + quantity(loss.hold, "s") + ", steady to " + percent(loss.unsteady) + " of the peak"},
      {"uncertainty", "U = " + short_number(o.uncertainties.coverage_factor) + " u_val",
       "u_val² = u_num² + u_input² + u_D²; a feature agrees or differs only if it does so at both ends of ± "
       "U"},
      {"u_D",
       o.quantity == QuantityKind::pressure
           ? "zero " + quantity(o.uncertainties.zero, "Pa") + ", gain " + percent(o.uncertainties.gain)
           : "zero " + quantity(o.uncertainties.zero_force, "N") + ", gain " + percent(o.uncertainties.gain),
       "beside noise, sampling and the alignment"},
      {"u_num and u_input", percent(o.uncertainties.numerical) + " and " + percent(o.uncertainties.input),
       "as stated on the command line; 0 by default"},
      {"corridor",
       "from " + std::to_string(report.options.corridor.least_subjects) + " subjects of a group",
       "several recordings of one subject count as their mean; " +
           percent(report.options.corridor.least_inside) + " of the simulated samples must lie in it"}};
}

std::vector<Fact> provenance_facts(const ComparisonReport& report) {
  std::vector<Fact> facts;
  for (const auto& [name, value] : report.provenance) { facts.push_back({name, value, ""}); }
  for (const ComparedRecording& one : report.recordings) {
    facts.push_back({one.file.filename().string(), "FNV-1a " + one.hash, ""});
  }
  return facts;
}

}  // namespace

std::string to_html(const ComparisonReport& report) {
  const Drawn drawn = draw(report);
  const std::string title = "Recorded and simulated insertion";
  const std::string version = report.provenance.contains("version") ? report.provenance.at("version") : "";
  std::string body =
      html_banner({.title = title,
                   .small_print = {report.command, version.empty() ? "" : "version " + version},
                   .held = holds(report),
                   .verdict = verdict_text(report),
                   .detail = verdict_sentence(report)});
  body += "<main>\n<h2>Key facts</h2>\n" + html_facts(key_facts(report));
  body += reasons_section(report) + "<h2>What was compared</h2>\n" + html_recordings(report) +
          groups_section(report, drawn) + recordings_section(report, drawn) +
          "<section>\n<h2>Whole traces</h2>\n" + html_table(ratings_table(report)) +
          "</section>\n<section>\n<h2>What the recordings lack</h2>\n" + html_table(defects_table(report)) +
          "</section>\n<section>\n<h2>How it was judged</h2>\n" + html_facts(rule_facts(report)) +
          html_table(tolerances_table(report)) +
          "</section>\n<section>\n<h2>What was shown, and what was not</h2>\n" +
          html_table(credibility_table(report)) + "</section>\n</main>\n" +
          html_provenance(provenance_facts(report), report.command);
  return html_page(title, body, {});
}

}  // namespace palpate
