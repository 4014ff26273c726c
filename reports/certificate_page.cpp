// SPDX-License-Identifier: MIT
#include <cmath>

#include "reports/certificate_report.hpp"
#include "reports/figure_svg.hpp"
#include "reports/markup.hpp"
#include "reports/shown_units.hpp"

namespace palpate {
namespace {

using namespace certificate;

std::string headline(Verdict verdict) {
  switch (verdict) {
    case Verdict::certified:
      return "Certified";
    case Verdict::not_certified:
      return "Not certified";
    case Verdict::not_qualified:
      break;
  }
  return "Environment not qualified: nothing is certified";
}

std::vector<Fact> claim_facts(const CertificateReport& report) {
  const Certificate& all = report.result;
  std::vector<Fact> facts{
      {"scene", report.file, report.scene_hash},
      {"rate", quantity(all.claim.rate, "Hz"), "a release every " + quantity(us * all.claim.period(), "us")},
      {"deadline", quantity(us * all.claim.deadline, "us"),
       "from the scheduled release until the tick is done"},
      {"allowed", "no miss", "under any load, nor by a provoked tick"}};
  if (const LoadResult* worst = all.worst(); worst != nullptr && worst->scene.record.ticks() > 0) {
    facts.push_back({"miss probability", "below " + short_number(worst->miss_probability_upper(), 3),
                     "with 95 % confidence, from " + std::to_string(worst->scene.record.ticks()) +
                         " ticks with " + std::to_string(worst->scene.record.misses.count()) +
                         " misses, load " + worst->load});
    facts.push_back(
        {"scene began again", std::to_string(worst->scene.restarts) + " times",
         "built anew in pauses between ticks of " + quantity(worst->scene.paused, "s") + " in all"});
  }
  facts.push_back({"computation", budget_words(all), ""});
  return facts;
}

std::vector<Fact> energy_facts(const MissedTick& missed) {
  constexpr double mj = 1e3;
  std::vector<Fact> facts{{"stiffness at the hand", quantity(missed.stiffness, "N/m"), ""},
                          {"largest speed", quantity(missed.speed, "m/s"), "of grip or tool in the scene"},
                          {"bound", quantity(mj * missed.bound, "mJ"),
                           "1/2 K (v T)\u00b2: a spring whose force is held for a period T"},
                          {"against a kept tick", quantity(mj * missed.sampled_bound, "mJ"),
                           "K (v T)\u00b2: a sampled force is held anyway, and is now a period older"}};
  if (missed.measured) {
    const char* word =
        *missed.measured <= missed.sampled_bound
            ? "more than with the tick kept, at the grip: within that bound"
            : "more than with the tick kept, at the grip: beyond that bound, which is of a spring alone; "
              "the coupling's damper adds to it, and force jumps where tissue gives way";
    facts.push_back(
        {"measured", quantity(mj * *missed.measured, "mJ"),
         std::string(word) + ". The tick at " + quantity(missed.measured_at, "s") + " was missed"});
  } else {
    facts.push_back({"measured", "no", "the scene has no device through which a hand would feel it"});
  }
  return facts;
}

std::string value_text(const EnvironmentFact& fact) {
  if (const bool* yes = std::get_if<bool>(&fact.value)) { return *yes ? "yes" : "no"; }
  if (const double* number = std::get_if<double>(&fact.value)) { return short_number(*number, 6); }
  const std::string* text = std::get_if<std::string>(&fact.value);
  return text != nullptr ? *text : "the system does not say";
}

std::string environment_html(const CertificateReport& report) {
  std::vector<Fact> facts;
  for (const EnvironmentFact& fact : report.environment) {
    facts.push_back({fact.label, value_text(fact), ""});
  }
  return "<h2>Environment</h2>\n" + html_facts(facts);
}

std::string tail_html(const CertificateReport& report, const std::vector<Table>& tables) {
  const LoadResult* worst = report.result.worst();
  if (worst == nullptr) { return {}; }
  std::string html = "<h2>Beyond what was seen</h2>\n";
  const Tail& tail = worst->tail;
  if (!tail.refusal.empty()) {
    html += html_notes({"Extrapolation refused: " + tail.refusal + "."});
  } else {
    html +=
        html_notes({tail.beyond_deadline
                        ? "One tick in " + short_number(1.0 / *tail.beyond_deadline, 3) +
                              " is expected beyond the deadline."
                        : "Beyond the deadline is further than two decades from the data: nothing is said "
                          "of it but the limit above."});
  }
  html += "<div class=\"exhibits\">\n";
  for (std::size_t n = 3; n < tables.size(); ++n) {
    if (!tables[n].rows.empty()) { html += html_table(tables[n]); }
  }
  return html + "</div>\n";
}

std::string histogram_html(const CertificateReport& report) {
  const std::vector<Figure> figures = histogram_figures(report);
  std::vector<const Figure*> all;
  for (const Figure& figure : figures) { all.push_back(&figure); }
  const std::vector<std::string> drawings = draw_figures(all);
  std::string html;
  for (std::size_t n = 0; n < figures.size(); ++n) { html += html_figure(figures[n], drawings[n]); }
  return html;
}

std::string html_main(const CertificateReport& report) {
  const std::vector<Table> tables = certificate_tables(report);
  std::string html = "<main>\n<h2>The claim</h2>\n" + html_facts(claim_facts(report)) +
                     html_notes(report.result.notes) + "<h2>The loop</h2>\n";
  if (!tables[0].rows.empty()) {
    html += "<div class=\"exhibits\">\n" + html_table(tables[0]) + html_table(tables[1]) +
            histogram_html(report) + "</div>\n";
  } else {
    html += html_notes({"It did not run."});
  }
  if (!tables[2].rows.empty()) { html += "<h2>Worst ticks</h2>\n" + html_table(tables[2]); }
  html += tail_html(report, tables);
  if (report.result.missed_tick) {
    html += "<h2>What one missed tick does to the hand</h2>\n" +
            html_facts(energy_facts(*report.result.missed_tick));
  }
  return html + environment_html(report) + "</main>\n";
}

}  // namespace

std::string to_html(const CertificateReport& report) {
  const Judgement judgement = judge(report.result);
  const std::string title = "Real-time certificate: " + (report.title.empty() ? report.file : report.title);
  std::vector<Fact> provenance;
  for (const auto& [name, value] : report.provenance) { provenance.push_back({name, value, ""}); }
  return html_page(title,
                   html_banner({.title = title,
                                .small_print = {report.command,
                                                report.result.interrupted ? "interrupted: for what ran" : ""},
                                .held = judgement.verdict == Verdict::certified,
                                .open = judgement.verdict == Verdict::not_qualified,
                                .verdict = headline(judgement.verdict),
                                .detail = judgement.reason}) +
                       html_main(report) + html_provenance(provenance, report.command),
                   {});
}

}  // namespace palpate
