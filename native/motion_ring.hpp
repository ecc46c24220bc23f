// The equations of a platform modulo a prime, as polynomials in coordinates of the rigid motions.
//
// The coordinates are R, and as asked for T, U = R^T T, rho = T.T and further functions, linear in
// R and T x R (the mutual moments of lines). All quadrics that vanish on the motions are found
// exactly: N times a coordinate is a quadratic form in the Study coordinates (e, f), so a product
// of two coordinates is a quartic form, reduced modulo e.f by its leading term e0 f0.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "counting.hpp"
#include "echelon.hpp"
#include "monomials.hpp"

namespace gsp {
namespace {

template <class F>
struct Polynomial {
  std::vector<std::pair<Monomial, typename F::Residue>> terms;
  int degree = 0;
};

template <class F>
class MotionRing {
 public:
  using Residue = typename F::Residue;
  using Quadric = std::vector<Residue>;  // coefficients of products of coordinates

  MotionRing(const F& field, const CountingProblem& problem) : field_(field), problem_(problem) {
    const auto use = [&](int from, int count) {
      for (int k = from; k < from + count; ++k) {
        local_[k] = static_cast<int>(coordinates_.size());
        coordinates_.push_back(k);
      }
    };
    use(0, 1 + 9);
    if (problem.blocks & kTranslation) use(10, 3);
    if (problem.blocks & kBody) use(13, 3);
    if (problem.blocks & kDistance) use(16, 1);
    use(kFunctions, problem.moments);
    substitute();
  }

  // Whether the linear equations alone contradict each other.
  bool is_inconsistent() const { return inconsistent_; }
  int variables() const { return static_cast<int>(free_.size()); }

  // A combination of coordinates as an affine form in the variables, the constant last.
  std::vector<Residue> affine(const std::uint64_t* row) const {
    std::vector<Residue> result(variables() + 1, 0);
    for (int k = 0; k < kFunctions + problem_.moments; ++k)
      if (row[k] != 0)
        for (int x = 0; x <= variables(); ++x)
          result[x] = field_.add(
              result[x], field_.multiply(static_cast<Residue>(row[k]), forms_[local_[k]][x]));
    return result;
  }

  // The generators of the ideal; says what they are if asked to.
  std::vector<Polynomial<F>> generators(Elimination* elimination = nullptr) const {
    std::vector<Polynomial<F>> result;
    for (const Quadric& quadric : relations())
      if (keep(quadric, result) && elimination != nullptr)
        elimination->relations.emplace_back(quadric.begin(), quadric.end());
    for (const auto& [equation, quadric] : quadrics_)
      if (keep(quadric, result) && elimination != nullptr)
        elimination->quadrics.push_back(equation);
    if (elimination != nullptr) {
      elimination->coordinates = coordinates_;
      for (const int k : free_) elimination->variables.push_back(coordinates_[k]);
    }
    return result;
  }

 private:
  static constexpr int kQuartics = 330;  // monomials of degree four in eight variables

  int count() const { return static_cast<int>(coordinates_.size()); }
  int pair(int i, int j) const { return i >= j ? i * (i + 1) / 2 + j : pair(j, i); }
  int pairs() const { return count() * (count() + 1) / 2; }

  Residue integer(int value) const {
    return value >= 0 ? static_cast<Residue>(value)
                      : field_.negative(static_cast<Residue>(-value));
  }
  void add_to(Quadric& quadric, int i, int j, Residue value) const {
    Residue& at = quadric[pair(i, j)];
    at = field_.add(at, value);
  }

  // --- the equations as quadrics in the coordinates

  // Adds a function of the motion; functions that are no coordinates are products of them.
  void add_function(Quadric& quadric, const std::uint64_t* row) const {
    for (int k = 0; k < kFunctions + problem_.moments; ++k) {
      const Residue c = static_cast<Residue>(row[k]);
      if (c == 0) continue;
      if (local_[k] >= 0) {
        add_to(quadric, local_[k], 0, c);
      } else if (k == 16) {
        const int from = local_[10] >= 0 ? 10 : 13;  // rho = T.T = U.U
        for (int i = 0; i < 3; ++i) add_to(quadric, local_[from + i], local_[from + i], c);
      } else if (k > 16) {
        add_moment(quadric, (k - 17) / 3, (k - 17) % 3, c);
      } else if (k >= 13) {
        for (int i = 0; i < 3; ++i)  // U = R^T T
          add_to(quadric, local_[1 + 3 * i + (k - 13)], local_[10 + i], c);
      } else {
        for (int j = 0; j < 3; ++j)  // T = R U
          add_to(quadric, local_[1 + 3 * (k - 10) + j], local_[13 + j], c);
      }
    }
  }
  // Adds a multiple of (T x R)_ij = (R x U)_ij.
  void add_moment(Quadric& quadric, int i, int j, Residue c) const {
    const auto rotation = [&](int a, int b) { return local_[1 + 3 * (a % 3) + b % 3]; };
    const auto vector = [&](int from, int a) { return local_[from + a % 3]; };
    if (local_[10] >= 0) {
      add_to(quadric, rotation(i + 2, j), vector(10, i + 1), c);
      add_to(quadric, rotation(i + 1, j), vector(10, i + 2), field_.negative(c));
    } else {
      add_to(quadric, rotation(i, j + 1), vector(13, j + 2), c);
      add_to(quadric, rotation(i, j + 2), vector(13, j + 1), field_.negative(c));
    }
  }
  bool is_linear(const std::uint64_t* row) const {
    for (int k = 0; k < kFunctions + problem_.moments; ++k)
      if (row[k] != 0 && local_[k] < 0) return false;
    return true;
  }

  // Solves the linear equations for some of the coordinates.
  void substitute() {
    const int width = kFunctions + problem_.moments, m = count() - 1;
    Echelon<F> linear(field_, m + 1);  // columns: the last coordinate first, the constant last
    for (int equation = 0; equation < problem_.equations; ++equation) {
      const std::uint64_t* row = problem_.functions + equation * width;
      bool squared = false;
      for (int s = 0; s < problem_.squares; ++s) squared |= problem_.owners[s] == equation;
      if (!squared && is_linear(row)) {
        linear.accumulator.clear();
        for (int k = 0; k < width; ++k)
          if (row[k] != 0)
            linear.accumulator.set(m - local_[k], static_cast<Residue>(row[k]));
        linear.push();
        continue;
      }
      Quadric quadric(pairs(), 0);
      add_function(quadric, row);
      for (int s = 0; s < problem_.squares; ++s) {
        if (problem_.owners[s] != equation) continue;
        const std::uint64_t* form = problem_.square_functions + s * width;
        const Residue weight = static_cast<Residue>(problem_.weights[s]);
        for (int i = 0; i < width; ++i)
          for (int j = 0; j < width; ++j)
            if (form[i] != 0 && form[j] != 0)
              add_to(quadric, local_[i], local_[j],
                     field_.multiply(weight, field_.multiply(static_cast<Residue>(form[i]),
                                                             static_cast<Residue>(form[j]))));
      }
      quadrics_.emplace_back(equation, std::move(quadric));
    }
    linear.back_substitute();
    inconsistent_ = linear.row_of(m) >= 0;
    for (int k = 1; k <= m; ++k)
      if (linear.row_of(m - k) < 0) free_.push_back(k);
    const int n = variables();
    forms_.assign(m + 1, std::vector<Residue>(n + 1, 0));
    forms_[0][n] = 1;
    for (int i = 0; i < n; ++i) forms_[free_[i]][i] = 1;
    for (int row = 0; row < linear.rank(); ++row) {
      std::vector<Residue>& form = forms_[m - linear.pivot(row)];
      if (linear.pivot(row) == m) continue;
      for (int i = 0; i < n; ++i) form[i] = field_.negative(linear.entry(row, m - free_[i]));
      form[n] = field_.negative(linear.entry(row, m));
    }
  }

  // Appends a quadric in the coordinates as a polynomial in the variables; false if it is zero.
  bool keep(const Quadric& quadric, std::vector<Polynomial<F>>& result) const {
    const int n = variables();
    std::vector<Residue> sums((n + 1) * (n + 1), 0);
    for (int i = 0; i < count(); ++i)
      for (int j = 0; j <= i; ++j) {
        const Residue c = quadric[pair(i, j)];
        if (c == 0) continue;
        for (int x = 0; x <= n; ++x) {
          if (forms_[i][x] == 0) continue;
          const Residue cx = field_.multiply(c, forms_[i][x]);
          for (int y = 0; y <= n; ++y) {
            if (forms_[j][y] == 0) continue;
            Residue& sum = sums[std::min(x, y) * (n + 1) + std::max(x, y)];
            sum = field_.add(sum, field_.multiply(cx, forms_[j][y]));
          }
        }
      }
    Polynomial<F> polynomial;
    for (int x = 0; x <= n; ++x)
      for (int y = x; y <= n; ++y) {
        if (sums[x * (n + 1) + y] == 0) continue;
        const Monomial m = (x < n ? variable(x) : 0) + (y < n ? variable(y) : 0);
        polynomial.terms.emplace_back(m, sums[x * (n + 1) + y]);
        polynomial.degree = std::max(polynomial.degree, (x < n) + (y < n));
      }
    if (polynomial.terms.empty()) return false;
    result.push_back(std::move(polynomial));
    return true;
  }

  // --- the quadrics that vanish on the motions

  using Form = std::vector<std::pair<std::array<int, 2>, Residue>>;  // terms z_i z_j

  Form form_of(int coordinate) const {
    std::array<Residue, 64> sums{};
    for (int k = 0; k < kFunctions; ++k) {
      const Residue factor =
          coordinate < kFunctions
              ? Residue{k == coordinate}
              : static_cast<Residue>(
                    problem_.moment_functions[(coordinate - kFunctions) * kFunctions + k]);
      if (factor == 0) continue;
      for (int i = 0; i < 8; ++i)
        for (int j = i; j < 8; ++j) {
          const int entry = problem_.hessians[64 * k + 8 * i + j];
          if (entry == 0) continue;
          Residue& sum = sums[8 * i + j];
          sum = field_.add(sum, field_.multiply(factor, integer(i == j ? entry / 2 : entry)));
        }
    }
    // Modulo e.f: e0 f0 = -(e1 f1 + e2 f2 + e3 f3).
    for (int i = 1; i < 4; ++i)
      sums[8 * i + i + 4] = field_.subtract(sums[8 * i + i + 4], sums[4]);
    sums[4] = 0;
    Form form;
    for (int i = 0; i < 8; ++i)
      for (int j = i; j < 8; ++j)
        if (sums[8 * i + j] != 0) form.push_back({{i, j}, sums[8 * i + j]});
    return form;
  }

  // A quartic form by the numbers of its monomials, and which of them were touched.
  struct QuarticForm {
    std::vector<Residue> sums = std::vector<Residue>(kQuartics, 0);
    std::vector<int> touched;
  };

  // The number of z_a z_b z_c z_d.
  static int quartic_number(std::array<int, 4> z) {
    std::sort(z.begin(), z.end());
    return z[0] + z[1] * (z[1] + 1) / 2 + z[2] * (z[2] + 1) * (z[2] + 2) / 6 +
           z[3] * (z[3] + 1) * (z[3] + 2) * (z[3] + 3) / 24;
  }

  void add_quartic(QuarticForm& quartic, const std::array<int, 4>& z, Residue value) const {
    const auto e0 = std::find(z.begin(), z.end(), 0), f0 = std::find(z.begin(), z.end(), 4);
    if (e0 != z.end() && f0 != z.end()) {
      for (int i = 1; i < 4; ++i) {
        std::array<int, 4> other = z;
        other[e0 - z.begin()] = i;
        other[f0 - z.begin()] = i + 4;
        add_quartic(quartic, other, field_.negative(value));
      }
      return;
    }
    const int number = quartic_number(z);
    quartic.sums[number] = field_.add(quartic.sums[number], value);
    quartic.touched.push_back(number);
  }

  std::vector<Quadric> relations() const {
    // Coordinates among whose products relations are sought; the moments are the last ones.
    const int used = count() - (problem_.moment_relations ? 0 : problem_.moments);
    const int products_used = used * (used + 1) / 2;
    std::vector<Form> forms;
    for (const int k : coordinates_) forms.push_back(form_of(k));
    // Rows: the quartic monomials; columns: the products, whose dependences are the relations.
    std::vector<std::vector<std::pair<int, Residue>>> rows(kQuartics);
    std::vector<int> column_of(pairs()), pair_at;
    const auto weight = [&](int i) {
      return coordinates_[i] < 10 ? 0 : coordinates_[i] == 16 ? 2 : 1;
    };
    for (int w = 0; w <= 4; ++w)
      for (int i = 0; i < used; ++i)
        for (int j = 0; j <= i; ++j)
          if (weight(i) + weight(j) == w) {
            column_of[pair(i, j)] = static_cast<int>(pair_at.size());
            pair_at.push_back(pair(i, j));
          }
    QuarticForm quartic;
    for (int i = 0; i < used; ++i)
      for (int j = 0; j <= i; ++j) {
        for (const auto& [a, x] : forms[i])
          for (const auto& [b, y] : forms[j])
            add_quartic(quartic, {a[0], a[1], b[0], b[1]}, field_.multiply(x, y));
        for (const int number : quartic.touched) {
          Residue& value = quartic.sums[number];
          if (value != 0) rows[number].emplace_back(column_of[pair(i, j)], value);
          value = 0;
        }
        quartic.touched.clear();
      }
    Echelon<F> products(field_, products_used);
    for (const auto& row : rows) {
      if (row.empty()) continue;
      products.accumulator.clear();
      for (const auto& [column, value] : row) products.accumulator.set(column, value);
      products.push();
    }
    products.back_substitute();
    std::vector<Quadric> result;
    for (int column = 0; column < products_used; ++column) {
      if (products.row_of(column) >= 0) continue;
      Quadric relation(pairs(), 0);
      relation[pair_at[column]] = 1;
      for (int row = 0; row < products.rank(); ++row)
        relation[pair_at[products.pivot(row)]] = field_.negative(products.entry(row, column));
      result.push_back(std::move(relation));
    }
    return result;
  }

  const F& field_;
  const CountingProblem& problem_;
  std::vector<int> coordinates_;
  std::vector<int> local_ = std::vector<int>(kFunctions + problem_.moments, -1);
  std::vector<int> free_;
  std::vector<std::vector<Residue>> forms_;
  std::vector<std::pair<int, Quadric>> quadrics_;  // with the numbers of their equations
  bool inconsistent_ = false;
};

}  // namespace
}  // namespace gsp
