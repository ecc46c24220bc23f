// All poses of platforms with three distances and three angles (Algorithm 6.6), if they are in
// general position: first the rotations, then at each the translations.
//
// An angle constraint is linear in R, so times N = e.e it is a real quadric in the quaternion space
// P^3. Three of them in general position meet in eight points, and none has N = 0 (Section 6.1,
// Proposition 6.1). The translations that meet the distances are where three surfaces meet.
#include "modules.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "bindings.hpp"
#include "intersection.hpp"
#include "products.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

using Number = std::complex<double>;

// The positions of a platform with a known orientation (Propositions 6.4, 6.5 and 6.7).
//
// With the rotation fixed, each distance constraint keeps the translation T on a surface: DPH, DHP
// and DLL on a plane or two parallel ones, DPP on a sphere, DPL and DLP on a circular cylinder,
// and so does DLL when its lines are parallel. Three such surfaces meet in 2^m points, m of them
// being quadrics once the differences of spheres have been replaced by planes.
//
// Coordinates are X = (s, t), homogeneous in a basis B of the f with e.f = 0: the Study point of
// X is (s e, B t). Surfaces are forms in X, and a plane is a vector of length 4, a quadric a
// symmetric matrix of order 4. At a complex rotation N may be small and R large. The forms are made
// of the quaternion, nowhere divided by N and without cancellation, so that they stay accurate.
// Lengths should be of order one and the points near the origin.

// Real forms in the Study parameters (e, f), (4, 8) each. In this order: heights over planes and
// moments of lines; squares, of spheres, then of cylinders; heights along the axes of the
// cylinders; three normals of each pair of lines. See gspcli.geometry.measurement.
struct Measures {
  int heights, spheres, cylinders, pairs;
  const double* form;
  const int* skew;      // (pairs): which heights are moments
  int signs;            // combinations of sides
  const double* sign;   // (signs, heights)
  const double* basis;  // (3, 4, 4): forms of T or of U, which are the coordinates; or null
  int squares() const { return spheres + cylinders; }
  int circles() const { return spheres > 1 ? spheres - 1 : 0; }
  int planes() const { return heights + circles(); }
  int forms() const { return heights + squares() + cylinders + 3 * pairs; }
};

// Surfaces at one rotation; those of real rotations are exactly real.
struct Surfaces {
  std::complex<double>* plane;    // (signs, planes, 4): heights, then circles of the first sphere
  std::complex<double>* quadric;  // (squares, 4, 4): spheres first
  std::complex<double>* basis;    // (4, 3): of the f
  double* skewness;               // least squared sine, in absolute value, of pairs of lines
};

// A basis of the f with e.f = 0, as columns: in the coordinates of the forms if there are any. Else
// it is orthogonal in the Hermitian sense, so that it stays sound where N vanishes: it comes from
// the reflection that takes the first unit vector into a multiple of conj(e).
void make_basis(const Number* e, const double* forms, Number (*basis)[3]) {
  if (forms) {
    for (int l = 0; l < 4; ++l)
      for (int c = 0; c < 3; ++c) {
        basis[l][c] = 0.0;
        for (int k = 0; k < 4; ++k) basis[l][c] += 0.25 * forms[16 * c + 4 * k + l] * e[k];
      }
    return;
  }
  Number mirror[4];
  for (int i = 0; i < 4; ++i) mirror[i] = std::conj(e[i]);
  const double size = std::abs(mirror[0]);
  mirror[0] += size > 0.0 ? mirror[0] / size : 1.0;
  double square = 0.0;
  for (const Number& x : mirror) square += std::norm(x);
  for (int l = 0; l < 4; ++l)
    for (int c = 0; c < 3; ++c)
      basis[l][c] = (l == c + 1 ? 0.5 : 0.0) -
                    product(mirror[l], std::conj(mirror[c + 1])) / square;
}


// At the quaternion e, the distances (heights) and (squares) given apart.
void make_surfaces(const Measures& given, const Number* e, const double* flat,
                   const double* curved, const Surfaces& out) {
  Number basis[4][3], norm = 0.0;
  make_basis(e, given.basis, basis);
  for (int k = 0; k < 4; ++k) norm += product(e[k], e[k]);
  for (int l = 0; l < 4; ++l)
    for (int c = 0; c < 3; ++c) out.basis[3 * l + c] = basis[l][c];

  // Each form as a linear form in (s, t).
  std::vector<Number> linear(4 * given.forms());
  for (int i = 0; i < given.forms(); ++i) {
    Number row[8] = {};
    for (int k = 0; k < 4; ++k)
      for (int l = 0; l < 8; ++l) row[l] += given.form[32 * i + 8 * k + l] * e[k];
    Number* form = &linear[4 * i];
    for (int l = 0; l < 4; ++l) {
      form[0] += product(row[l], e[l]);
      for (int c = 0; c < 3; ++c) form[1 + c] += product(row[4 + l], basis[l][c]);
    }
  }
  const Number* heights = linear.data();
  const Number* squares = heights + 4 * given.heights;
  const Number* axial = squares + 4 * given.squares();
  const Number* normals = axial + 4 * given.cylinders;

  Number metric[3][3] = {};
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (int l = 0; l < 4; ++l) metric[c][d] += 4.0 * product(basis[l][c], basis[l][d]);
  for (int i = 0; i < given.squares(); ++i) {
    Number(*q)[4] = reinterpret_cast<Number(*)[4]>(out.quadric + 16 * i);
    q[0][0] = squares[4 * i] - curved[i] * curved[i] * norm;
    for (int c = 0; c < 3; ++c) {
      q[0][1 + c] = q[1 + c][0] = 0.5 * squares[4 * i + 1 + c];
      for (int d = 0; d < 3; ++d) q[1 + c][1 + d] = metric[c][d];
    }
    if (i < given.spheres) continue;
    const Number* along = axial + 4 * (i - given.spheres);
    for (int c = 0; c < 4; ++c)
      for (int d = 0; d < 4; ++d)
        q[c][d] = product(norm, q[c][d]) - product(along[c], along[d]);
  }

  // What a distance adds to the first coefficient of a plane.
  std::vector<Number> offset(given.heights);
  for (int j = 0; j < given.heights; ++j) offset[j] = flat[j] * norm;
  *out.skewness = 1.0;
  for (int p = 0; p < given.pairs; ++p) {
    Number square = 0.0;
    for (int i = 0; i < 3; ++i)
      square += product(normals[12 * p + 4 * i], normals[12 * p + 4 * i]);
    offset[given.skew[p]] = flat[given.skew[p]] * std::sqrt(square);
    *out.skewness = std::min(*out.skewness, std::abs(square) / std::norm(norm));
  }
  for (int s = 0; s < given.signs; ++s) {
    Number* plane = out.plane + 4 * s * given.planes();
    std::copy(heights, heights + 4 * given.heights, plane);
    for (int j = 0; j < given.heights; ++j)
      plane[4 * j] -= given.sign[s * given.heights + j] * offset[j];
    // Spheres differ by the plane of their common circle.
    for (int i = 0; i < given.circles(); ++i)
      for (int c = 0; c < 4; ++c)
        plane[4 * (given.heights + i) + c] =
            (c ? 2.0 : 1.0) * (out.quadric[16 * (i + 1) + c] - out.quadric[c]);
  }
}

constexpr int kAngles = 3;
constexpr int kRotations = 8;

// Directions of the angles on the platform and on the base, (3, 3) each.
struct Directions {
  const double* u;
  const double* v;
};

// Sets of values: cosines R u . v, heights and lengths, of which there are as many as `Measures` has.
struct ValueSets {
  int count;
  const double* cosine;  // (count, 3)
  const double* flat;    // (count, heights)
  const double* curved;  // (count, squares)
};

constexpr int kStudy = 8;
constexpr double kRounding = std::numeric_limits<double>::epsilon();
// Rotations with a larger error relative to N are not good enough.
constexpr double kAccuracy = 1e-11;
// A coordinate of a point of norm one is not zero if it is larger than this and its error.
constexpr double kCertain = 1e-12;
// Squared sine below which lines are not trusted to be skew.
constexpr double kNearlyParallel = 1e-6;

bool certainly_not_zero(double size, double error) {
  return size > std::max(kCertain, 100.0 * error);
}

// The quadric N (v . R u - cosine) of quaternions e = (e0, w), symmetric: its part in N is
// (e0^2 - w.w) u.v + 2 e0 w.(u x v) + 2 (w.u)(w.v).
void make_angle_form(const double* u, const double* v, double cosine, Number (*form)[4]) {
  const double along = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  form[0][0] = along - cosine;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    form[0][1 + i] = form[1 + i][0] = u[j] * v[k] - u[k] * v[j];
    for (int l = 0; l < 3; ++l) form[1 + i][1 + l] = u[i] * v[l] + u[l] * v[i];
    form[1 + i][1 + i] -= along + cosine;
  }
}

// Where systems of k planes and 3 - k quadrics meet.
struct Meeting {
  std::vector<Number> point;  // (systems, 2^(3-k), 4)
  std::vector<double> error;  // (systems, 2^(3-k))
  std::unique_ptr<bool[]> ok;

  Meeting(Intersect* intersect, int groups, int systems, int planes, const Number* plane,
          const Number* quadric, const double* accuracy, const bool* real)
      : point(4 * count(groups * systems, planes)), error(count(groups * systems, planes)),
        ok(new bool[groups * systems]) {
    intersect({groups, systems, reinterpret_cast<const Complex*>(plane),
               reinterpret_cast<const Complex*>(quadric), accuracy, real},
              planes, {reinterpret_cast<Complex*>(point.data()), error.data(), ok.get()});
  }

 private:
  static std::size_t count(int systems, int planes) {
    return static_cast<std::size_t>(systems) << (3 - planes);
  }
};

// The rotations of sets of values; of a pair of conjugates only one.
struct Rotations {
  std::vector<Number> e;         // (rotations, 4), norm 1
  std::vector<double> accuracy;  // of what is computed from them
  std::vector<char> real;
  std::vector<int> owner;  // whose set they are

  int count() const { return static_cast<int>(owner.size()); }
};

// Sets whose quadrics do not certainly meet in eight simple finite points have no rotations.
Rotations find_rotations(const Directions& given, const ValueSets& values, Intersect* intersect) {
  std::vector<Number> form(values.count * kAngles * 16);
  for (int b = 0; b < values.count; ++b)
    for (int k = 0; k < kAngles; ++k)
      make_angle_form(given.u + 3 * k, given.v + 3 * k, values.cosine[kAngles * b + k],
                      reinterpret_cast<Number(*)[4]>(&form[(b * kAngles + k) * 16]));
  const std::vector<double> accuracy(values.count, kRounding);
  const std::unique_ptr<bool[]> real(new bool[values.count]);
  std::fill(real.get(), real.get() + values.count, true);
  const Meeting found(intersect, values.count, 1, 0, nullptr, form.data(), accuracy.data(),
                      real.get());
  Rotations out;
  for (int b = 0; b < values.count; ++b) {
    const Number* const points = &found.point[b * kRotations * 4];
    const double* const errors = &found.error[b * kRotations];
    bool known = found.ok[b];
    for (int p = 0; p < kRotations; ++p) {
      Number square = 0.0;
      for (int i = 0; i < 4; ++i) square += product(points[4 * p + i], points[4 * p + i]);
      const double norm = std::abs(square);
      known = known && certainly_not_zero(norm, errors[p]) && errors[p] < kAccuracy * norm;
    }
    if (!known) continue;
    for (int p = 0; p < kRotations;) {
      const Number* const e = points + 4 * p;
      const bool is_real = std::all_of(e, e + 4, [](const Number& x) { return x.imag() == 0.0; });
      out.e.insert(out.e.end(), e, e + 4);
      out.accuracy.push_back(errors[p] + kRounding);
      out.real.push_back(is_real);
      out.owner.push_back(b);
      // Conjugates come one directly after the other.
      p += is_real ? 1 : 2;
    }
  }
  return out;
}

int points_of(const Measures& given) { return 1 << (3 - given.planes()); }


// How many poses each set has in general position on each combination of sides.
int poses_of(const Measures& given) { return kRotations * points_of(given); }

// Returns Study points of any norm of all poses of each set (count, signs, poses, 8); those of real
// poses are exactly real. Also whether the set is in general position: then there are no other
// poses, by Bezout's theorem. If not, the points are zero.
void solve_closed_forms(const Directions& directions, const Measures& measures,
                        const ValueSets& values, Intersect* intersect, Number* point,
                        bool* general) {
  const Rotations turned = find_rotations(directions, values, intersect);
  const int rotations = turned.count(), planes = measures.planes(), squares = measures.squares();
  // Of the spheres one is left: the others are planes.
  const int quadrics = squares - measures.circles();
  std::vector<Number> plane(rotations * measures.signs * planes * 4),
      quadric(rotations * quadrics * 16), basis(rotations * 12), each(squares * 16);
  std::vector<double> skewness(rotations);
  for (int r = 0; r < rotations; ++r) {
    const int b = turned.owner[r];
    make_surfaces(measures, &turned.e[4 * r], values.flat + b * measures.heights,
                  values.curved + b * squares,
                  {plane.data() + r * measures.signs * planes * 4, each.data(), &basis[12 * r],
                   &skewness[r]});
    for (int i = 0, j = 0; i < squares; ++i)
      if (i == 0 || i >= measures.spheres)
        std::copy_n(&each[16 * i], 16, &quadric[(r * quadrics + j++) * 16]);
  }
  const std::unique_ptr<bool[]> real(new bool[rotations]);
  std::copy(turned.real.begin(), turned.real.end(), real.get());
  const Meeting placed(intersect, rotations, measures.signs, planes, plane.data(), quadric.data(),
                       turned.accuracy.data(), real.get());

  const int points = points_of(measures), poses = kRotations * points;
  const std::size_t each_set = static_cast<std::size_t>(measures.signs) * poses * kStudy;
  std::vector<int> filled(values.count);  // poses of each side
  std::fill(general, general + values.count, true);
  std::fill(point, point + values.count * each_set, Number());
  for (int r = 0; r < rotations; ++r) {
    const int b = turned.owner[r], copies = turned.real[r] ? 1 : 2;
    bool good = skewness[r] > kNearlyParallel;
    for (int s = 0; s < measures.signs; ++s) {
      const int system = r * measures.signs + s;
      good = good && placed.ok[system];
      for (int p = 0; p < points; ++p) {
        const Number* const x = &placed.point[(system * points + p) * 4];
        good = good && certainly_not_zero(std::abs(x[0]), placed.error[system * points + p]);
        Number* const study =
            point + b * each_set + (s * poses + filled[b] + copies * p) * kStudy;
        for (int l = 0; l < 4; ++l) {
          study[l] = product(x[0], turned.e[4 * r + l]);
          for (int c = 0; c < 3; ++c)
            study[4 + l] += product(basis[12 * r + 3 * l + c], x[1 + c]);
        }
        if (!turned.real[r])
          std::transform(study, study + kStudy, study + kStudy,
                         [](const Number& z) { return std::conj(z); });
      }
    }
    filled[b] += copies * points;
    general[b] = general[b] && good;
  }
  for (int b = 0; b < values.count; ++b) {
    general[b] = general[b] && filled[b] == poses;
    if (!general[b]) std::fill_n(point + b * each_set, each_set, Number());
  }
}

// The build of the intersections that has a name.
Intersect* (*choose)(const std::string& build);

// Points into the arrays, which must outlive it.
Measures measures_of(const Array<double, 3>& forms, int spheres, const std::vector<int>& skew,
                     const Array<double, 2>& signs, const std::optional<Array<double, 3>>& basis,
                     std::size_t squares) {
  const int k = static_cast<int>(signs.shape(1));
  require(0 <= spheres && spheres <= static_cast<int>(squares), "spheres must be among the squares");
  require(!basis || (basis->shape(0) == 3 && basis->shape(1) == 4 && basis->shape(2) == 4),
          "basis must have shape (3, 4, 4)");
  const Measures given{k,
                       spheres,
                       static_cast<int>(squares) - spheres,
                       static_cast<int>(skew.size()),
                       forms.data(),
                       skew.data(),
                       static_cast<int>(signs.shape(0)),
                       signs.data(),
                       basis ? basis->data() : nullptr};
  require(forms.shape(0) == static_cast<std::size_t>(given.forms()) && forms.shape(1) == 4 &&
              forms.shape(2) == 8,
          "there must be a form (4, 8) for each height, square, axis and normal");
  require(std::all_of(skew.begin(), skew.end(), [&](int i) { return 0 <= i && i < k; }),
          "moments must be among the heights");
  return given;
}

nb::tuple surfaces(Array<double, 3> forms, int spheres, std::vector<int> skew,
                   Array<double, 2> signs, std::optional<Array<double, 3>> basis,
                   Array<Number, 2> e, Array<double, 2> flat, Array<double, 2> curved) {
  const std::size_t rotations = e.shape(0), combinations = signs.shape(0), k = signs.shape(1);
  const std::size_t m = curved.shape(1), three = 3, four = 4;
  require(e.shape(1) == 4 && flat.shape(0) == rotations && flat.shape(1) == k &&
              curved.shape(0) == rotations,
          "e, flat and curved must have shapes (rotations, 4), (rotations, k), (rotations, m)");
  const Measures given = measures_of(forms, spheres, skew, signs, basis, m);
  const std::size_t planes = given.planes();
  const auto array = [&](std::size_t size) { return std::make_unique<Number[]>(rotations * size); };
  auto plane = array(combinations * planes * 4), quadric = array(m * 16), base = array(12);
  auto skewness = std::make_unique<double[]>(rotations);
  for (std::size_t r = 0; r < rotations; ++r)
    make_surfaces(given, e.data() + 4 * r, flat.data() + k * r, curved.data() + m * r,
                  {plane.get() + r * combinations * planes * 4, quadric.get() + r * m * 16,
                   base.get() + 12 * r, skewness.get() + r});
  return nb::make_tuple(owned(std::move(plane), {rotations, combinations, planes, four}),
                        owned(std::move(quadric), {rotations, m, four, four}),
                        owned(std::move(base), {rotations, four, three}),
                        owned(std::move(skewness), {rotations}));
}

nb::tuple intersect(Array<Number, 4> planes, Array<Number, 4> quadrics, Array<double, 1> accuracy,
                    Array<bool, 1> real, const std::string& build) {
  const std::size_t groups = planes.shape(0), systems = planes.shape(1), k = planes.shape(2);
  require(k <= 3 && planes.shape(3) == 4, "planes must have shape (groups, systems, k, 4)");
  require(quadrics.shape(0) == groups && quadrics.shape(1) == 3 - k && quadrics.shape(2) == 4 &&
              quadrics.shape(3) == 4,
          "quadrics must have shape (groups, 3 - k, 4, 4)");
  require(accuracy.shape(0) == groups && real.shape(0) == groups,
          "accuracy and real must have shape (groups,)");
  Intersect* const run = choose(build);
  const std::size_t total = groups * systems, each = std::size_t{8} >> k, four = 4;
  auto point = std::make_unique<Number[]>(total * each * four);
  auto error = std::make_unique<double[]>(total * each);
  auto ok = std::make_unique<bool[]>(total);
  {
    nb::gil_scoped_release release;
    run({static_cast<int>(groups), static_cast<int>(systems),
         reinterpret_cast<const Complex*>(planes.data()),
         reinterpret_cast<const Complex*>(quadrics.data()), accuracy.data(), real.data()},
        static_cast<int>(k), {reinterpret_cast<Complex*>(point.get()), error.get(), ok.get()});
  }
  return nb::make_tuple(owned(std::move(point), {groups, systems, each, four}),
                        owned(std::move(error), {groups, systems, each}),
                        owned(std::move(ok), {groups, systems}));
}

nb::tuple closed_forms(Array<double, 2> u, Array<double, 2> v, Array<double, 2> cosines,
                       Array<double, 3> forms, int spheres, std::vector<int> skew,
                       Array<double, 2> signs, std::optional<Array<double, 3>> basis,
                       Array<double, 2> flat, Array<double, 2> curved) {
  const std::size_t sets = cosines.shape(0), three = kAngles, eight = 8;
  require(u.shape(0) == three && u.shape(1) == 3 && v.shape(0) == three && v.shape(1) == 3,
          "u and v must have shape (3, 3)");
  require(cosines.shape(1) == three && flat.shape(0) == sets && curved.shape(0) == sets,
          "cosines, flat and curved must have shapes (sets, 3), (sets, k), (sets, m)");
  require(flat.shape(1) == signs.shape(1) && flat.shape(1) + curved.shape(1) == 3,
          "there must be three distances");
  const Measures given = measures_of(forms, spheres, skew, signs, basis, curved.shape(1));
  const std::size_t combinations = given.signs, poses = poses_of(given);
  auto point = std::make_unique<Number[]>(sets * combinations * poses * eight);
  auto general = std::make_unique<bool[]>(sets);
  {
    nb::gil_scoped_release release;
    solve_closed_forms({u.data(), v.data()}, given,
                       {static_cast<int>(sets), cosines.data(), flat.data(), curved.data()},
                       choose(""), point.get(), general.get());
  }
  return nb::make_tuple(owned(std::move(point), {sets, combinations, poses, eight}),
                        owned(std::move(general), {sets}));
}

}  // namespace

void bind_closed_form(nb::module_& m, Intersect* (*choose_intersect)(const std::string& build)) {
  choose = choose_intersect;
  m.def("surfaces", &surfaces, "forms"_a, "spheres"_a, "skew"_a, "signs"_a, "basis"_a.none(),
        "e"_a, "flat"_a, "curved"_a,
        "Return planes, quadrics, bases and skewness at rotations; see closed_form.cpp.");
  m.def("intersect", &intersect, "planes"_a, "quadrics"_a, "accuracy"_a, "real"_a, nb::kw_only(),
        "build"_a = "", "Return points, errors and what has been solved; see intersection.hpp.");
  m.def("closed_forms", &closed_forms, "u"_a, "v"_a, "cosines"_a, "forms"_a, "spheres"_a, "skew"_a,
        "signs"_a, "basis"_a.none(), "flat"_a, "curved"_a,
        "Return Study points of all poses, and which sets are in general position; see "
        "gspcli.geometry.three_angles.");
}

}  // namespace gsp
