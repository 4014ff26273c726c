// SPDX-License-Identifier: MIT
#pragma once
/// What a run leaves behind. A model run, a reference, a baseline and a recording are all Traces.

#include <string>
#include <string_view>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

struct Column {
  std::string name{};            ///< as in trace.csv, "tip.x_m"
  std::string unit{};            ///< "m"
  std::vector<double> values{};  ///< one per row
};

struct TextColumn {
  std::string name{};
  std::vector<std::string> values{};
};

struct Event {
  double time = 0.0;  ///< [s]
  std::string kind{};
  std::string detail{};
};

struct Trace {
  std::vector<double> time{};  ///< [s], one per row; a row is a tick
  std::vector<Column> columns{};
  std::vector<TextColumn> text_columns{};
  std::vector<Event> events{};
  std::vector<double> frame_time{};   ///< [s]
  std::vector<NodeVectors> frames{};  ///< positions of all nodes [m], in the scene's numbering

  [[nodiscard]] const Column* find(std::string_view name) const {
    for (const Column& column : columns) {
      if (column.name == name) { return &column; }
    }
    return nullptr;
  }
};

}  // namespace palpate
