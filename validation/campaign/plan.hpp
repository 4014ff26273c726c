// SPDX-License-Identifier: MIT
#pragma once
/// Plan of a campaign: values of the parameters for every row of a design, and shares of a list of
/// jobs (docs/campaigns.md).

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::campaign {

/// Share `index` of `count` of a list: every count-th item. Indices begin with 1.
struct Shard {
  std::size_t index = 1;
  std::size_t count = 1;

  /// Returns true if the shard contains the item at this position, counted from 0.
  [[nodiscard]] bool has(std::size_t position) const { return position % count + 1 == index; }
  [[nodiscard]] std::string text() const {
    return std::to_string(index) + "/" + std::to_string(count);
  }
};

/// Reads "i/N" with 1 <= i <= N. `from` names the source in messages. Throws InputError.
Shard parse_shard(std::string_view text, std::string_view from);

/// Returns numbers as the array expression of Slurm: "3,17-20". The numbers must be sorted.
std::string array_expression(std::span<const std::size_t> numbers);

enum class Method { grid, latin_hypercube, sobol, saltelli };
enum class Scale { linear, log };

/// Numeric key of a scene that a campaign varies: a list of values, or a range.
struct Parameter {
  std::string key{};
  std::vector<double> values{};  ///< for a grid; empty: `count` values of the range
  std::vector<double> range{};   ///< lowest and highest value
  int count = 0;
  Scale scale = Scale::linear;

  /// Returns the value at a share of the range from 0 to 1.
  [[nodiscard]] double at(double share) const;
};

struct Design {
  Method method = Method::grid;
  int samples = 0;  ///< rows of a Latin hypercube or a Sobol sequence; base samples of Saltelli
  std::uint64_t seed = 1;  ///< of the Latin hypercube
  std::vector<Parameter> parameters{};
};

/// The generator of GSL has up to 40 dimensions; Saltelli's design needs two for each parameter.
inline constexpr std::size_t most_dimensions = 40;

/// Returns the number of rows, or the largest number of its type if there are more. The design must
/// be valid.
std::size_t row_count(const Design& design);

/// Returns one row of parameter values after the other. Saltelli's design has k + 2 rows for each
/// base sample: A, B, and A with the value of one parameter from B (Saltelli et al., Comput. Phys.
/// Commun. 181 (2010) 259). The design must be valid.
std::vector<std::vector<double>> rows_of(const Design& design);

}  // namespace palpate::campaign
