// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/ranks/partition.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

namespace {

// A plane is sought in so many rounds: each cuts the interval that holds it into so many bins, and
// counts the places in them. 64^4 bins over a side resolve any grid that fits into memory.
constexpr int num_rounds = 4;
constexpr int num_bins = 64;

/// Search for the plane that divides one part of the tree.
struct Search {
  int axis = 0;
  double low = 0, high = 0;              // bounds of the plane [m]
  double below_low = 0, below_high = 0;  // places of all ranks in the part below each of them
  double wanted = 0;                     // below the plane

  double edge(int bin) const {
    return bin == num_bins ? high : low + (high - low) * bin / num_bins;
  }
  int bin_of(double x) const {
    const double place = std::floor((x - low) / (high - low) * num_bins);
    int bin = static_cast<int>(std::clamp(place, 0.0, num_bins - 1.0));
    while (bin > 0 && x < edge(bin)) --bin;
    while (bin + 1 < num_bins && x >= edge(bin + 1)) ++bin;
    return bin;
  }
  double position() const { return wanted - below_low <= below_high - wanted ? low : high; }
};

/// The parts of one level of the tree and their places.
template <int dim>
class Level {
 public:
  using Range = typename Partition<dim>::Range;

  Level(MPI_Comm comm, std::span<const Vector<dim>> places, std::vector<Range> ranges,
        std::vector<std::int32_t> range_of)
      : comm_(comm), places_(places), ranges_(std::move(ranges)), range_of_(std::move(range_of)) {}

  bool is_last() const {
    return std::none_of(ranges_.begin(), ranges_.end(),
                        [](const Range& range) { return range.is_parted(); });
  }

  void find_planes(std::vector<AxisPlane>& planes) {
    begin();
    for (int round = 0; round < num_rounds; ++round) narrow();
    for (std::size_t k = 0; k < ranges_.size(); ++k) {
      if (!ranges_[k].is_parted()) continue;
      planes[ranges_[k].plane()] = {searches_[k].axis, searches_[k].position()};
    }
  }

  Level next(const std::vector<AxisPlane>& planes) const {
    std::vector<Range> ranges;
    std::vector<std::int32_t> first;  // of the ranges that each becomes
    for (const Range& range : ranges_) {
      first.push_back(static_cast<std::int32_t>(ranges.size()));
      ranges.push_back(range.is_parted() ? range.below() : range);
      if (range.is_parted()) ranges.push_back(range.above());
    }
    std::vector<std::int32_t> range_of(range_of_.size());
    for (std::size_t p = 0; p < range_of_.size(); ++p) {
      const Range& range = ranges_[range_of_[p]];
      range_of[p] = first[range_of_[p]];
      if (!range.is_parted()) continue;
      const AxisPlane& plane = planes[range.plane()];
      if (!(places_[p][plane.axis] < plane.position)) ++range_of[p];
    }
    return {comm_, places_, std::move(ranges), std::move(range_of)};
  }

 private:
  // The box around each part, its longest side, and how many places lie in it.
  void begin() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const std::size_t width = 2 * dim;
    std::vector<double> bounds(width * ranges_.size(), -infinity), counts(ranges_.size(), 0.0);
    for (std::size_t p = 0; p < range_of_.size(); ++p) {
      double* const of_part = bounds.data() + width * range_of_[p];
      for (int d = 0; d < dim; ++d) {
        of_part[d] = std::max(of_part[d], -places_[p][d]);
        of_part[dim + d] = std::max(of_part[dim + d], places_[p][d]);
      }
      counts[range_of_[p]] += 1;
    }
    max_over_ranks(comm_, std::span<double>(bounds));
    sum_over_ranks(comm_, std::span<double>(counts));
    searches_.assign(ranges_.size(), {});
    for (std::size_t k = 0; k < ranges_.size(); ++k) {
      if (counts[k] == 0) continue;
      const double* const of_part = bounds.data() + width * k;
      Search& search = searches_[k];
      for (int d = 0; d < dim; ++d) {
        const double low = -of_part[d], high = of_part[dim + d];
        if (d > 0 && !(high - low > search.high - search.low)) continue;
        search.axis = d;
        search.low = low;
        search.high = high;
      }
      const Range& range = ranges_[k];
      search.wanted = counts[k] * (range.middle() - range.first) / (range.last - range.first);
      search.below_high = counts[k];
    }
  }

  void narrow() {
    std::vector<double> counts(num_bins * ranges_.size(), 0.0);
    for (std::size_t p = 0; p < range_of_.size(); ++p) {
      const Search& search = searches_[range_of_[p]];
      const double x = places_[p][search.axis];
      if (!(search.high > search.low) || x < search.low || x > search.high) continue;
      counts[static_cast<std::size_t>(num_bins) * range_of_[p] + search.bin_of(x)] += 1;
    }
    sum_over_ranks(comm_, std::span<double>(counts));
    for (std::size_t k = 0; k < ranges_.size(); ++k) {
      Search& search = searches_[k];
      if (!(search.high > search.low)) continue;
      double below = search.below_low;
      const double* const of_part = counts.data() + num_bins * k;
      int bin = 0;
      while (bin + 1 < num_bins && below + of_part[bin] < search.wanted) below += of_part[bin++];
      const double low = search.edge(bin), high = search.edge(bin + 1);
      const double below_high = bin + 1 < num_bins ? below + of_part[bin] : search.below_high;
      search.low = low;
      search.high = high;
      search.below_low = below;
      search.below_high = below_high;
    }
  }

  MPI_Comm comm_;
  std::span<const Vector<dim>> places_;
  std::vector<Range> ranges_;
  std::vector<std::int32_t> range_of_;  // of each place
  std::vector<Search> searches_;        // of each range
};

}  // namespace

template <int dim>
Partition<dim> bisect(MPI_Comm comm, int num_parts, std::span<const Vector<dim>> places) {
  std::vector<AxisPlane> planes(num_parts - 1);
  Level<dim> level(comm, places, {{0, num_parts}}, std::vector<std::int32_t>(places.size(), 0));
  while (!level.is_last()) {
    level.find_planes(planes);
    level = level.next(planes);
  }
  return Partition<dim>(std::move(planes));
}

template Partition<2> bisect<2>(MPI_Comm, int, std::span<const Vector<2>>);
template Partition<3> bisect<3>(MPI_Comm, int, std::span<const Vector<3>>);

}  // namespace gabion
