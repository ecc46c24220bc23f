// The points of both bodies, and exact numbers as doubles: small loops that every solve begins with.
#include <algorithm>
#include <cmath>
#include <vector>

#include "bindings.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

constexpr int kCoordinates = 3;

double distance(const double* p, const double* q) {
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

// The mean of the points without those far from the others. A point is far if its distance from the
// central point is many times that of the nearer half.
void find_centre(std::size_t count, const double* point, double far, double* centre) {
  std::vector<double> from(count), best;
  double least = INFINITY;
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < count; ++j)
      sum += from[j] = distance(point + kCoordinates * i, point + kCoordinates * j);
    if (sum < least || best.empty()) least = sum, best = from;
  }
  from = best;
  std::sort(from.begin(), from.end());
  double usual = 0.0;
  // If points coincide, no point is far.
  for (std::size_t k = (count - 1) / 2; k < count && usual == 0.0; ++k) usual = from[k];
  std::fill(centre, centre + kCoordinates, 0.0);
  std::size_t used = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(best[i] <= far * usual)) continue;
    ++used;
    for (int k = 0; k < kCoordinates; ++k) centre[k] += point[kCoordinates * i + k];
  }
  for (int k = 0; k < kCoordinates; ++k) centre[k] /= static_cast<double>(used);
}

nb::tuple centres(Array<double, 3> points, double far) {
  const std::size_t bodies = points.shape(0), count = points.shape(1);
  const std::size_t three = kCoordinates;
  require(count > 0 && points.shape(2) == three, "points must have shape (bodies, count, 3)");
  auto centre = std::make_unique<double[]>(bodies * three);
  double extent = 0.0;
  for (std::size_t b = 0; b < bodies; ++b) {
    const double* const point = points.data() + b * count * three;
    find_centre(count, point, far, centre.get() + b * three);
    for (std::size_t i = 0; i < count; ++i) {
      double square = 0.0;
      for (std::size_t k = 0; k < three; ++k) {
        const double offset = point[i * three + k] - centre[b * three + k];
        square += offset * offset;
      }
      extent = std::max(extent, square);
    }
  }
  return nb::make_tuple(owned(std::move(centre), {bodies, three}), std::sqrt(extent));
}

nb::object quotients(Array<double, 2> ratios) {
  const std::size_t count = ratios.shape(0), parts = 3;
  require(ratios.shape(1) == 2, "ratios must have shape (count, 2)");
  auto found = std::make_unique<double[]>(parts * count);
  for (std::size_t i = 0; i < count; ++i) {
    const double p = ratios(i, 0), q = ratios(i, 1), high = p / q;
    found[i] = high;
    // Exact but for the division: of what was divided and of the rounded quotient times the divisor.
    found[count + i] = std::fma(-high, q, p) / q;
    found[2 * count + i] = std::fabs(high);
  }
  return nb::cast(owned(std::move(found), {parts, count}));
}

}  // namespace

void bind_bodies(nb::module_& m) {
  m.def("centres", &centres, "points"_a, nb::kw_only(), "far"_a,
        "Return means of points, without far ones, and how far any is from them; see "
        "gspcli.geometry.arrangement.");
  m.def("quotients", &quotients, "ratios"_a,
        "Return quotients of integers as two doubles and a size; see gspcli.certification.numbers.doubled.");
}

}  // namespace gsp
