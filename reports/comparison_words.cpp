// SPDX-License-Identifier: MIT
#include "reports/comparison_words.hpp"

#include <algorithm>
#include <cctype>

#include "fixtures/io/recording_fields.hpp"
#include "reports/markup.hpp"

namespace palpate {

using namespace comparison;

namespace {

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void append_part(std::string& text, const std::string& part) { text += (text.empty() ? "" : ", ") + part; }

std::size_t reconstructed_count(const ComparisonReport& report) {
  return static_cast<std::size_t>(std::ranges::count_if(report.recordings, [](const ComparedRecording& one) {
    return one.input.recording.kind == Recording::Kind::reconstructed;
  }));
}

std::size_t verdict_count(const ComparisonReport& report, Verdict verdict) {
  return static_cast<std::size_t>(std::ranges::count(report.found.recordings, verdict, &Comparison::verdict));
}

/// Collects counts above zero by their words.
struct DefectWords {
  std::string text{};
  void add(std::size_t count, const char* what) {
    if (count > 0) { append_part(text, std::to_string(count) + " " + what); }
  }
};

}  // namespace

bool any_reconstructed(const ComparisonReport& report) { return reconstructed_count(report) > 0; }

std::string kinds_of(const ComparisonReport& report) {
  const std::size_t rebuilt = reconstructed_count(report);
  const std::size_t measured = report.recordings.size() - rebuilt;
  std::string text;
  if (measured > 0) { text = counted(measured, "measured recording", "measured recordings"); }
  if (rebuilt > 0) {
    text += (text.empty() ? "" : " and ") + counted(rebuilt, "recording ", "recordings ") +
            std::string(io::reconstruction_note);
  }
  return text;
}

std::string subjects_of(const SubjectCorridor& corridor) {
  const std::string subjects = counted(corridor.subjects, "subject", "subjects");
  return corridor.recordings == corridor.subjects
             ? subjects
             : subjects + " (" + counted(corridor.recordings, "recording", "recordings") + ")";
}

std::size_t subjects_compared(const ComparisonReport& report) {
  std::size_t count = 0;
  for (const GroupSummary& group : report.found.groups) { count += group.subjects; }
  return count;
}

std::string name_of_group(const std::string& group) { return group.empty() ? "without a group" : group; }

std::string tally_of(const ComparisonReport& report) {
  std::string text;
  const auto add = [&](Verdict verdict, const char* one, const char* many) {
    const std::size_t count = verdict_count(report, verdict);
    if (count > 0) { append_part(text, counted(count, one, many)); }
  };
  add(Verdict::agrees, "agrees", "agree");
  add(Verdict::not_distinguishable, "is not distinguishable", "are not distinguishable");
  add(Verdict::differs, "differs", "differ");
  add(Verdict::not_comparable, "cannot be compared", "cannot be compared");
  return text;
}

bool holds(const ComparisonReport& report) {
  return report.found.verdict == Verdict::agrees && verdict_count(report, Verdict::not_comparable) == 0;
}

std::string verdict_text(const ComparisonReport& report) {
  std::string text(name_of(report.found.verdict));
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const std::size_t left_out = verdict_count(report, Verdict::not_comparable);
  if (left_out > 0 && report.found.verdict != Verdict::not_comparable) {
    text += ", but " + counted(left_out, "recording", "recordings") + " cannot be compared";
  }
  return text;
}

std::string verdict_sentence(const ComparisonReport& report) {
  if (!report.simulation.failure.empty()) { return "The simulation " + report.simulation.failure + "."; }
  std::string sentence = "The simulated " + std::string(name_of(report.options.comparison.quantity)) +
                         " was judged against " + kinds_of(report);
  if (report.found.verdict == Verdict::agrees) {
    sentence += ". Every feature that can be judged lies within its tolerance.";
  } else {
    sentence += report.found.reasons.empty() ? "." : ": " + report.found.reasons.front() + ".";
  }
  if (any_reconstructed(report)) { sentence += " What was reconstructed is no evidence about patients."; }
  return sentence;
}

std::string shown(const RecordingDefects& defects) {
  DefectWords words;
  words.add(defects.missing, "missing samples");
  words.add(defects.gaps, "gaps");
  words.add(defects.bad_frames, "bad frames");
  words.add(defects.not_finite, "samples without a number");
  words.add(defects.out_of_range, "out of range");
  words.add(defects.clipped, "clipped");
  words.add(defects.not_increasing, "rows out of order, left out");
  words.add(defects.battery_low, "with the battery low");
  return words.text.empty() ? "nothing" : words.text;
}

}  // namespace palpate
