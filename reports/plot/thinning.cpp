// SPDX-License-Identifier: MIT

#include "reports/plot/thinning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace palpate {

namespace {

bool is_gap(const Pixel& at) { return !std::isfinite(at.x) || !std::isfinite(at.y); }

/// Samples that determine the envelope of one pixel column, in order.
class Envelope {
 public:
  explicit Envelope(std::vector<std::size_t>& kept) : kept_(kept) {}

  void add(std::size_t index, const Pixel& low, const Pixel& high) {
    const double column = std::floor(low.x);
    if (!open_ || column != column_) {
      close();
      open_ = true;
      column_ = column;
      picks_ = {index, index, index, index};
      low_ = low.y;
      high_ = high.y;
    }
    if (low.y < low_) { low_ = low.y, picks_[1] = index; }
    if (high.y > high_) { high_ = high.y, picks_[2] = index; }
    picks_[3] = index;
  }

  void close() {
    if (!open_) { return; }
    std::ranges::sort(picks_);
    for (const std::size_t index : picks_) {
      if (kept_.empty() || kept_.back() != index) { kept_.push_back(index); }
    }
    open_ = false;
  }

 private:
  std::vector<std::size_t>& kept_;
  std::array<std::size_t, 4> picks_{};
  double column_ = 0.0, low_ = 0.0, high_ = 0.0;
  bool open_ = false;
};

class Thinning {
 public:
  Thinning(const Series& series, const Projection& project) : series_(series), project_(project) {
    count_ = std::min(series.x.size(), series.y.size());
    if (band()) { count_ = std::min(count_, series.y2.size()); }
  }

  [[nodiscard]] bool rises() const { return std::is_sorted(series_.x.begin(), series_.x.end()); }

  std::vector<std::size_t> curve() {
    Envelope envelope(kept_);
    for (std::size_t n = 0; n < count_; ++n) {
      const Pixel low = lower(n);
      const Pixel high = upper(n);
      if (is_gap(low) || is_gap(high)) {
        envelope.close();
        keep_gap(n);
      } else {
        envelope.add(n, low, high);
        gap_ = false;
      }
    }
    envelope.close();
    return std::move(kept_);
  }

  std::vector<std::size_t> path() {
    Pixel last{std::nan(""), std::nan("")};
    for (std::size_t n = 0; n < count_; ++n) {
      const Pixel at = lower(n);
      if (is_gap(at)) {
        keep_gap(n);
      } else if (n + 1 == count_ || !(std::hypot(at.x - last.x, at.y - last.y) < 0.5)) {
        kept_.push_back(n);
        gap_ = false;
      } else {
        continue;
      }
      last = at;
    }
    return std::move(kept_);
  }

  std::vector<std::size_t> points() {
    std::set<std::pair<long, long>> covered;
    for (std::size_t n = 0; n < count_; ++n) {
      const Pixel at = lower(n);
      if (is_gap(at)) { continue; }
      if (covered.emplace(std::lround(at.x), std::lround(at.y)).second) { kept_.push_back(n); }
    }
    return std::move(kept_);
  }

 private:
  [[nodiscard]] bool band() const { return series_.filled(); }
  [[nodiscard]] Pixel lower(std::size_t n) const { return project_(series_.x[n], series_.y[n]); }
  [[nodiscard]] Pixel upper(std::size_t n) const {
    return band() ? project_(series_.x[n], series_.y2[n]) : lower(n);
  }
  void keep_gap(std::size_t n) {
    if (!gap_) { kept_.push_back(n); }
    gap_ = true;
  }

  const Series& series_;
  const Projection& project_;
  std::size_t count_ = 0;
  std::vector<std::size_t> kept_{};
  bool gap_ = false;
};

}  // namespace

std::vector<std::size_t> thinned(const Series& series, const Projection& project) {
  Thinning thinning(series, project);
  if (series.style == Series::Style::points) { return thinning.points(); }
  if (series.filled() || thinning.rises()) { return thinning.curve(); }
  return thinning.path();
}

}  // namespace palpate
