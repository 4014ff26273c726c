// SPDX-License-Identifier: MIT
#include "reports/figure_data.hpp"

#include <algorithm>

#include "model/dynamics/scene_check.hpp"

namespace palpate {

namespace {

void write_figure(io::Hdf5File& file, const std::string& above, const Figure& figure) {
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Series& series = figure.series[n];
    const std::string group = above + series_group(figure, n);
    file.write(group + "/x", series.x, figure.x.label);
    file.write(group + "/y", series.y, figure.y.label);
    if (!series.y2.empty()) { file.write(group + "/y2", series.y2, figure.y.label); }
    file.write_attribute(group, "label", series.label);
  }
  if (figure.heat_map) {
    const std::string group = above + heat_map_group(figure);
    file.write(group + "/x", figure.heat_map->x, figure.x.label);
    file.write(group + "/y", figure.heat_map->y, figure.y.label);
    file.write(group + "/z", figure.heat_map->z, figure.heat_map->label);
  }
  const std::string group = above + "/figures/" + figure.id;
  file.make_group(group);
  file.write_attribute(group, "title", figure.title);
  file.write_attribute(group, "caption", figure.caption);
}

/// Names the file and what is wrong in it.
void require(bool fits, const std::filesystem::path& file, const std::string& group) {
  if (!fits) {
    throw InputError(file.string() + ": " + group + ": data sets of different lengths");
  }
}

void read_figure(const io::Hdf5File& file, const std::filesystem::path& path, const std::string& above,
                 Figure& figure) {
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    Series& series = figure.series[n];
    const std::string group = above + series_group(figure, n);
    series.x = file.read(group + "/x");
    series.y = file.read(group + "/y");
    if (file.contains(group + "/y2")) { series.y2 = file.read(group + "/y2"); }
    require(series.x.size() == series.y.size() &&
                (!series.filled() || series.x.size() == series.y2.size()),
            path, group);
  }
  if (!figure.heat_map) { return; }
  HeatMap& map = *figure.heat_map;
  const std::string group = above + heat_map_group(figure);
  map.x = file.read(group + "/x");
  map.y = file.read(group + "/y");
  map.z = file.read(group + "/z");
  require(map.z.size() == map.x.size() * map.y.size(), path, group);
}

}  // namespace

std::string series_group(const Figure& figure, std::size_t index) {
  return "/figures/" + figure.id + "/series_" + std::to_string(index);
}

std::string heat_map_group(const Figure& figure) { return "/figures/" + figure.id + "/heat_map"; }

std::string trace_file_name(const std::string& case_name) {
  std::string name = case_name;
  std::ranges::replace(name, '/', '-');
  return name + ".h5";
}

void write_figure_data(const std::filesystem::path& traces, const Outcome& outcome) {
  if (outcome.figures.empty()) { return; }
  io::Hdf5File file = io::Hdf5File::create(traces / trace_file_name(outcome.name));
  write_figures(file, "", outcome.figures);
  file.write_attribute("/", "case", outcome.name);
  file.commit();
}

void read_figure_data(const std::filesystem::path& traces, Outcome& outcome) {
  if (outcome.figures.empty()) { return; }
  const std::filesystem::path path = traces / trace_file_name(outcome.name);
  const io::Hdf5File file = io::Hdf5File::open(path);
  read_figures(file, path, "", outcome.figures);
}

void write_figures(io::Hdf5File& file, const std::string& above, const std::vector<Figure>& figures) {
  for (const Figure& figure : figures) { write_figure(file, above, figure); }
}

void read_figures(const io::Hdf5File& file, const std::filesystem::path& path, const std::string& above,
                  std::vector<Figure>& figures) {
  for (Figure& figure : figures) { read_figure(file, path, above, figure); }
}

}  // namespace palpate
