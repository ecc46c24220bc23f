#include "modules.hpp"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>
#include <memory>
#include <vector>
#include <utility>

#include "bindings.hpp"
#include "products.hpp"
#include "threads.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

// Six quadrics solved for some of the quantities of reduced_homotopy.hpp, by linear algebra.
constexpr int kQuadric = 27;  // coefficients: ten of e e, sixteen of e f, one of f.f

class ReducedQuadrics {
 public:
  using Number = std::complex<double>;
  static constexpr int kColumns = kQuantities + kForms + kEquations;

  // Pivots first; columns: the quantities, the form, the combination of the given quadrics.
  Number row[kEquations][kColumns];
  int quantities = 0, pivots = 0;
  std::int32_t pivot[kEquations];

  // Whether the quadrics depend on e e, w and h alone, and can be solved for some of these: for those
  // that are the pivots of others, if there are others. Without `rest`, other rows depend on e e
  // alone. With it they may depend on quantities without pivots, too.
  bool solve(const Number* quadrics, const ReducedQuadrics* others, bool rest) {
    if (!read(quadrics)) return false;
    double largest = 0.0;
    for (int i = 0; i < kEquations; ++i)
      for (int k = 0; k < quantities; ++k) largest = std::max(largest, std::abs(row[i][k]));
    if (others && others->quantities != quantities) return false;
    const int most = others ? others->pivots : kEquations;
    for (pivots = 0; pivots < most; ++pivots) {
      const auto [size, best, column] = choose(others ? others->pivot[pivots] : -1);
      if (!others && (rest ? size < kSmall * largest : size <= kZero * largest)) break;
      if (size < kSmall * largest) return false;
      eliminate(best, column);
    }
    return rest || pivots == kEquations || choose(-1).size <= kZero * largest;
  }

  int free() const { return quantities - pivots; }

  // The quantities that are no pivots, in order.
  void list_free(std::int32_t* out) const {
    for (std::int32_t k = 0; k < quantities; ++k)
      if (std::find(pivot, pivot + pivots, k) == pivot + pivots) *out++ = k;
  }

 private:
  // Pivots below the first part of the largest entry are zero; in between they are too small to
  // divide by.
  static constexpr double kZero = 1e-12, kSmall = 1e-3;

  bool read(const Number* quadrics) {
    double largest = 0.0, rest = 0.0;
    bool has_h = false;
    for (int i = 0; i < kEquations; ++i) {
      const Number *q = quadrics + i * kQuadric, *mixed = q + kForms;
      for (int k = 0; k < kQuadric; ++k) largest = std::max(largest, std::abs(q[k]));
      // e.f vanishes; the rest must be skew.
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b <= a; ++b)
          rest = std::max(rest, std::abs(mixed[4 * a + b] + mixed[4 * b + a] -
                                         (a == b ? 2.0 * mixed[0] : 0.0)));
      constexpr int kPlace[6] = {1, 2, 3, 11, 13, 6};  // of w in the matrix
      Number* r = row[i];
      for (int k = 0; k < 6; ++k) r[k] = mixed[kPlace[k]];
      r[6] = q[kQuadric - 1];
      has_h |= r[6] != 0.0;
      for (int k = 0; k < kForms; ++k) r[kQuantities + k] = q[k];
      for (int k = 0; k < kEquations; ++k) r[kQuantities + kForms + k] = i == k ? 1.0 : 0.0;
    }
    quantities = has_h ? kQuantities : kQuantities - 1;
    return rest <= kZero * largest;
  }

  struct Choice {
    double size;
    int row, column;
  };
  // The largest entry of the rows without pivots, in one column unless that is -1.
  Choice choose(int column) const {
    Choice best{-1.0, 0, 0};
    for (int i = pivots; i < kEquations; ++i)
      for (int k = 0; k < quantities; ++k)
        if ((column < 0 || k == column) && std::abs(row[i][k]) > best.size)
          best = {std::abs(row[i][k]), i, k};
    return best;
  }

  void eliminate(int from, int column) {
    for (int k = 0; k < kColumns; ++k) std::swap(row[pivots][k], row[from][k]);
    const Number scale = 1.0 / row[pivots][column];
    for (Number& x : row[pivots]) x = product(scale, x);
    for (int i = 0; i < kEquations; ++i) {
      if (i == pivots) continue;
      const Number factor = row[i][column];
      for (int k = 0; k < kColumns; ++k) row[i][k] -= product(factor, row[pivots][k]);
      row[i][column] = 0.0;
    }
    pivot[pivots] = column;
  }
};

using Numbers = std::complex<double>;

// Targets that a thread takes at a time, so that lanes are refilled.
constexpr std::size_t kPiece = 32;

TrackValues* (*choose)(const std::string& build);

ReducedGeometry geometry_of(const Array<std::int32_t, 1>& pivots, const Array<std::int32_t, 1>& free,
                        const Array<double, 2>& forms, const Array<double, 2>& slopes) {
  ReducedGeometry g{};
  const std::size_t scalars = free.shape(0), quantities = scalars + pivots.shape(0);
  g.has_h = quantities == kQuantities;
  require(scalars <= kMostScalars && (g.has_h ? scalars > 0 : quantities == kQuantities - 1),
          "up to three quantities may be free, the others pivots");
  require(forms.shape(0) == kEquations && forms.shape(1) == kForms &&
              slopes.shape(0) == kEquations && slopes.shape(1) == scalars,
          "forms and slopes must have shapes (6, 10) and (6, scalars)");
  g.scalars = static_cast<int>(scalars);
  unsigned seen = 0;
  const auto see = [&](std::int32_t k) {
    require(k >= 0 && k < static_cast<std::int32_t>(quantities), "no such quantity");
    seen |= 1u << k;
    return k;
  };
  for (std::size_t i = 0; i < pivots.shape(0); ++i) g.pivot[i] = see(pivots(i));
  for (std::size_t i = 0; i < scalars; ++i) g.free[i] = see(free(i));
  require(seen == (1u << quantities) - 1, "pivots and free must be all quantities");
  for (std::size_t j = 0; j < kEquations; ++j) {
    for (std::size_t i = 0; i < kForms; ++i) g.form[j][i] = forms(j, i);
    for (std::size_t l = 0; l < scalars; ++l) g.slope[j][l] = slopes(j, l);
  }
  return g;
}

nb::tuple track_values(Array<std::int32_t, 1> pivots, Array<std::int32_t, 1> free,
                     Array<double, 2> forms, Array<double, 2> slopes,
                     Array<Numbers, 2> start_values, Array<Numbers, 3> starts,
                     Array<std::int32_t, 1> start, Array<Numbers, 2> values,
                     double predictor_tolerance, double contraction, double radius_fraction,
                     double min_step, int max_steps, int jobs, const std::string& build) {
  const ReducedGeometry geometry = geometry_of(pivots, free, forms, slopes);
  const std::size_t targets = values.shape(0), paths = starts.shape(1), d = 4 + geometry.scalars;
  const std::size_t eight = kVariables;
  require(start_values.shape(0) == starts.shape(0) && start_values.shape(1) == kEquations &&
              starts.shape(2) == d && start.shape(0) == targets && values.shape(1) == kEquations,
          "starts, their values and those of targets must have shapes that agree");
  for (std::size_t i = 0; i < targets; ++i)
    require(start(i) >= 0 && start(i) < static_cast<std::int32_t>(starts.shape(0)), "no such start");
  const ReducedOptions options{predictor_tolerance, contraction, radius_fraction, min_step, max_steps};
  const auto plain = [](const Numbers* z) { return reinterpret_cast<const Complex*>(z); };
  std::vector<std::int32_t> order(targets);
  for (std::size_t i = 0; i < targets; ++i) order[i] = static_cast<std::int32_t>(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return start(a) < start(b); });
  const ReducedPaths given{static_cast<int>(paths), plain(start_values.data()), plain(starts.data()),
                         start.data(), order.data(), plain(values.data()), nullptr};
  const std::size_t total = targets * paths;
  auto point = std::make_unique<Numbers[]>(total * d);
  auto study = std::make_unique<Numbers[]>(total * eight);
  auto status = std::make_unique<std::uint8_t[]>(total);
  auto steps = std::make_unique<std::int32_t[]>(total);
  const ReducedEnds ends{reinterpret_cast<Complex*>(point.get()),
                     reinterpret_cast<Complex*>(study.get()), status.get(), steps.get()};
  TrackValues* const run = choose(build);
  if (paths > 0) {
    nb::gil_scoped_release release;
    const std::size_t each = (targets + jobs - 1) / jobs;
    const std::size_t piece = std::clamp<std::size_t>(each, 1, kPiece);
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next.fetch_add(piece); i < targets; i = next.fetch_add(piece))
        run(geometry, options, given, static_cast<int>(i),
            static_cast<int>(std::min(i + piece, targets)), ends);
    };
    share(jobs, (targets + piece - 1) / piece, work);
  }
  return nb::make_tuple(owned(std::move(point), {targets, paths, d}),
                        owned(std::move(study), {targets, paths, eight}),
                        owned(std::move(status), {targets, paths}),
                        owned(std::move(steps), {targets, paths}));
}

// Imaginary parts below this part of the largest coefficient are rounding.
constexpr double kNoImaginary = 1e-13;

// The coefficients of solved quadrics, as the start or the end of a line.
void put_line(const ReducedQuadrics& q, const std::int32_t* free, ReducedLine& line, bool ends) {
  const auto put = [&](Complex& from, Complex& change, const Numbers& x) {
    if (ends)
      change = {x.real() - from.re, x.imag() - from.im};
    else
      from = {x.real(), x.imag()};
  };
  for (int j = 0; j < kEquations; ++j) {
    const Numbers* form = q.row[j] + kQuantities;
    double size = 0.0;
    for (int i = 0; i < kForms; ++i) size += std::norm(form[i]);
    for (int l = 0; l < q.free(); ++l) size += std::norm(q.row[j][free[l]]);
    // Equations without a pivot have no scale of their own.
    const double scale = j < q.pivots ? 1.0 : 1.0 / std::sqrt(size);
    for (int i = 0; i < kForms; ++i) put(line.form[j][i], line.form_change[j][i], scale * form[i]);
    for (int l = 0; l < q.free(); ++l)
      put(line.slope[j][l], line.slope_change[j][l], scale * q.row[j][free[l]]);
  }
}

// Takes imaginary parts that are multiples of N out of the forms, if there are no others.
void split(ReducedLine& line, int scalars) {
  constexpr bool kDiagonal[kForms] = {true, false, false, false, true, false, false, true, false, true};
  double rest = 0.0, largest = 0.0;
  for (int j = 0; j < kEquations; ++j) {
    const double value[2] = {-line.form[j][0].im, -line.form_change[j][0].im};
    line.value[j] = value[0], line.value_change[j] = value[1];
    for (int i = 0; i < kForms; ++i) {
      const Complex* const parts[2] = {&line.form[j][i], &line.form_change[j][i]};
      for (int k = 0; k < 2; ++k) {
        rest = std::max(rest, std::abs(parts[k]->im + (kDiagonal[i] ? value[k] : 0.0)));
        largest = std::max(largest, std::abs(parts[k]->re));
      }
    }
    for (int l = 0; l < scalars; ++l)
      rest = std::max({rest, std::abs(line.slope[j][l].im), std::abs(line.slope_change[j][l].im)});
  }
  line.real = rest <= kNoImaginary * largest;
}

// A Study point in the coordinates e, of norm 1, and the free quantities.
void place(const Numbers* z, const ReducedGeometry& geometry, Complex* out) {
  const Numbers *e = z, *f = z + 4;
  double size = 0.0;
  for (int i = 0; i < 4; ++i) size += std::norm(e[i]);
  const auto outer = [&](int i, int j) { return product(e[i], f[j]) - product(e[j], f[i]); };
  Numbers square = 0.0;
  for (int i = 0; i < 4; ++i) square += product(f[i], f[i]);
  const Numbers quantity[kQuantities] = {outer(0, 1), outer(0, 2), outer(0, 3), outer(2, 3),
                                         outer(3, 1), outer(1, 2), square};
  const auto put = [](const Numbers& x) { return Complex{x.real(), x.imag()}; };
  for (int i = 0; i < 4; ++i) out[i] = put(e[i] / std::sqrt(size));
  for (int l = 0; l < geometry.scalars; ++l) out[4 + l] = put(quantity[geometry.free[l]] / size);
}

nb::object track_reduced(Array<Numbers, 2> start, Array<Numbers, 2> points, Array<Numbers, 2> target,
                         double predictor_tolerance, double contraction, double radius_fraction,
                         double min_step, int max_steps, bool lower_rank, const std::string& build) {
  const std::size_t eight = kVariables, paths = points.shape(0);
  require(start.shape(0) == kEquations && start.shape(1) == kQuadric &&
              target.shape(0) == kEquations && target.shape(1) == kQuadric &&
              points.shape(1) == eight,
          "quadrics must have shape (6, 27), points (P, 8)");
  ReducedQuadrics from, to;
  if (!to.solve(target.data(), nullptr, lower_rank) || !from.solve(start.data(), &to, lower_rank))
    return nb::none();
  const std::size_t scalars = to.free();
  if (scalars > kMostScalars || (to.quantities == kQuantities && scalars == 0)) return nb::none();
  ReducedGeometry geometry{};
  geometry.scalars = to.free();
  geometry.has_h = to.quantities == kQuantities;
  std::copy(to.pivot, to.pivot + to.pivots, geometry.pivot);
  to.list_free(geometry.free);
  ReducedLine line;
  put_line(from, geometry.free, line, false);
  put_line(to, geometry.free, line, true);
  split(line, to.free());
  const std::size_t d = 4 + scalars;
  std::vector<Complex> starts(paths * d), ends(paths * d);
  for (std::size_t p = 0; p < paths; ++p)
    place(&points(p, 0), geometry, starts.data() + p * d);
  auto study = std::make_unique<Numbers[]>(paths * eight);
  auto status = std::make_unique<std::uint8_t[]>(paths);
  std::vector<std::int32_t> steps(paths);
  const std::int32_t first = 0;
  const ReducedOptions options{predictor_tolerance, contraction, radius_fraction, min_step, max_steps};
  const ReducedPaths given{static_cast<int>(paths), nullptr, starts.data(), &first, &first, nullptr,
                         &line};
  TrackValues* const run = choose(build);
  {
    nb::gil_scoped_release release;
    run(geometry, options, given, 0, 1,
        {ends.data(), reinterpret_cast<Complex*>(study.get()), status.get(), steps.data()});
  }
  return nb::make_tuple(owned(std::move(study), {paths, eight}), owned(std::move(status), {paths}));
}

}  // namespace

void bind_reduced(nb::module_& m, TrackValues* (*choose_track)(const std::string& build)) {
  choose = choose_track;
  m.def("track_values", &track_values, "pivots"_a, "free"_a, "forms"_a, "slopes"_a,
        "start_values"_a, "starts"_a, "start"_a, "values"_a, nb::kw_only(),
        "predictor_tolerance"_a, "contraction"_a, "radius_fraction"_a, "min_step"_a,
        "max_steps"_a, "jobs"_a = 1, "build"_a = "",
        "Track quadrics of which only multiples of N move; see gspcli.continuation.reduced_homotopy.");
  m.def("track_reduced", &track_reduced, "start"_a, "points"_a, "target"_a, nb::kw_only(),
        "predictor_tolerance"_a, "contraction"_a, "radius_fraction"_a, "min_step"_a,
        "max_steps"_a, "lower_rank"_a = false, "build"_a = "",
        "Track quadrics that are solved for some quantities; see gspcli.continuation.reduced_homotopy.");
}

}  // namespace gsp
