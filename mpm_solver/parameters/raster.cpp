// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/parameters/raster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "common/base/read_file.hpp"
#include "common/base/require.hpp"
#include "mpm_solver/parameters/interpolation.hpp"

namespace gabion::mpm {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Share of a value by which files round the number that stands for no data.
constexpr double digits = 1e-5;

const std::vector<std::string> header_names = {"ncols",     "nrows",       "xllcorner",
                                               "yllcorner", "xllcenter",   "yllcenter",
                                               "cellsize",  "nodata_value"};

/// Words of a text, with the number of the line of each.
class Words {
 public:
  Words(const std::string& path, std::string_view text) : path_(path), text_(text) {}

  /// The next word, empty: there is none.
  std::string_view next() {
    while (at_ < text_.size() && is_blank(text_[at_])) line_ += text_[at_++] == '\n';
    const std::size_t first = at_;
    while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
    return text_.substr(first, at_ - first);
  }
  std::string_view peek() {
    const Words before = *this;
    const std::string_view word = next();
    at_ = before.at_;
    line_ = before.line_;
    return word;
  }
  double number(std::string_view word) const {
    double value = 0;
    const char* end = word.data() + word.size();
    const auto [last, error] = std::from_chars(word.data(), end, value);
    require<ConfigError>(error == std::errc() && last == end && !word.empty(),
                         "{}: line {}: found \"{}\", allowed: a number", path_, line_, word);
    return value;
  }
  int line() const { return line_; }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  std::string path_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

std::string lower(std::string_view word) {
  std::string result(word);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

std::map<std::string, double> read_header(const std::string& path, Words& words) {
  std::map<std::string, double> head;
  for (;;) {
    const std::string name = lower(words.peek());
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0])) || name == "nan") break;
    words.next();
    require<ConfigError>(
        std::ranges::find(header_names, name) != header_names.end(),
        "{}: line {}: found \"{}\", allowed: ncols, nrows, xllcorner or xllcenter, yllcorner or "
        "yllcenter, cellsize, nodata_value; cells are square and lie along the axes",
        path, words.line(), name);
    head[name] = words.number(words.next());
  }
  return head;
}

int count_of(const std::string& path, const std::map<std::string, double>& head,
             const std::string& name) {
  const auto found = head.find(name);
  const double count = found == head.end() ? 0 : found->second;
  require<ConfigError>(count >= 2 && count <= 1e6 && count == std::floor(count),
                       "{}: header: {}: found {}, allowed: a whole number of at least 2", path,
                       name, found == head.end() ? "none" : fmt::format("{:g}", count));
  return static_cast<int>(count);
}

// Centre of the first cell along an axis, in coordinates of the file.
double low_of(const std::string& path, const std::map<std::string, double>& head, char axis,
              double spacing) {
  const std::string corner = fmt::format("{}llcorner", axis);
  const std::string centre = fmt::format("{}llcenter", axis);
  require<ConfigError>(head.contains(corner) != head.contains(centre),
                       "{}: header: allowed: exactly one of {} and {}", path, corner, centre);
  return head.contains(centre) ? head.at(centre) : head.at(corner) + spacing / 2;
}

}  // namespace

Raster read_raster(const std::string& path, const Vector<2>& origin) {
  const std::string text = read_file(path, "raster");
  require<ConfigError>(
      path.ends_with(".asc"),
      "{}: found another ending, allowed: .asc, an ESRI ASCII grid; gdal_translate -of AAIGrid "
      "makes one of other rasters",
      path);
  Words words(path, text);
  const auto head = read_header(path, words);
  Raster raster{.path = path};
  raster.columns = count_of(path, head, "ncols");
  raster.rows = count_of(path, head, "nrows");
  raster.spacing = head.contains("cellsize") ? head.at("cellsize") : 0;
  require<ConfigError>(raster.spacing > 0 && std::isfinite(raster.spacing),
                       "{}: header: cellsize: found {:g}, allowed: a number > 0", path,
                       raster.spacing);
  raster.low = {low_of(path, head, 'x', raster.spacing) - origin[0],
                low_of(path, head, 'y', raster.spacing) - origin[1]};
  const double none = head.contains("nodata_value") ? head.at("nodata_value") : -9999;
  raster.values.assign(static_cast<std::size_t>(raster.columns) * raster.rows, nan);
  for (int row = raster.rows - 1; row >= 0; --row) {  // the first one is that in the north
    for (int column = 0; column < raster.columns; ++column) {
      const std::string_view word = words.next();
      require<ConfigError>(!word.empty(), "{}: found fewer values than {} rows of {}", path,
                           raster.rows, raster.columns);
      const double value = words.number(word);
      const bool is_none = std::abs(value - none) <= digits * std::abs(none);
      const auto place = static_cast<std::size_t>(row) * raster.columns + column;
      if (!is_none && std::isfinite(value)) raster.values[place] = value;
    }
  }
  const bool is_end = words.next().empty();
  require<ConfigError>(is_end, "{}: line {}: found more values than {} rows of {}", path,
                       words.line(), raster.rows, raster.columns);
  return raster;
}

double Raster::at(const Vector<2>& x) const {
  const PlaceBetween i = place_between(x[0], low[0], spacing, columns);
  const PlaceBetween j = place_between(x[1], low[1], spacing, rows);
  require<ConfigError>(i.first >= 0 && j.first >= 0, [&] {
    return fmt::format(
        "{}: it reaches from ({:.9g}, {:.9g}) to ({:.9g}, {:.9g}) in coordinates of the scene "
        "(the centres of its cells), found a point at ({:.9g}, {:.9g})",
        path, low[0], low[1], low[0] + (columns - 1) * spacing, low[1] + (rows - 1) * spacing, x[0],
        x[1]);
  });
  const auto value = [&](int row, int column) {
    const double found = values[static_cast<std::size_t>(row) * columns + column];
    require<ConfigError>(!std::isnan(found),
                         "{}: no data in row {}, column {}, which a point at ({:.9g}, {:.9g}) "
                         "needs",
                         path, rows - row, column + 1, x[0], x[1]);
    return found;
  };
  return between(j, [&](int dj) {
    return between(i, [&](int di) { return value(j.first + dj, i.first + di); });
  });
}

}  // namespace gabion::mpm
