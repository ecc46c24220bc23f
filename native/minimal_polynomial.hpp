// The minimal polynomial of a linear form on a finite algebra, and how many values it takes.
#pragma once

#include <algorithm>
#include <vector>

#include "border_basis.hpp"

namespace gsp {

// The shortest recurrence of a sequence (Berlekamp and Massey), constant term of the recurrence
// first: sum of c_j s_(i - j) = 0 with c_0 = 1.
template <class F>
std::vector<typename F::Residue> shortest_recurrence(
    const F& field, const std::vector<typename F::Residue>& s) {
  using Residue = typename F::Residue;
  std::vector<Residue> c{1}, b{1};
  Residue discrepancy = 1;
  int length = 0, shift = 1;
  for (int i = 0; i < static_cast<int>(s.size()); ++i) {
    Residue delta = s[i];
    for (int j = 1; j <= length; ++j)
      if (j < static_cast<int>(c.size())) delta = field.add(delta, field.multiply(c[j], s[i - j]));
    if (delta == 0) {
      ++shift;
      continue;
    }
    const std::vector<Residue> kept = c;
    const Residue factor = field.multiply(delta, field.inverse(discrepancy));
    c.resize(std::max(c.size(), b.size() + shift), 0);
    for (std::size_t j = 0; j < b.size(); ++j)
      c[j + shift] = field.subtract(c[j + shift], field.multiply(factor, b[j]));
    if (2 * length <= i) {
      length = i + 1 - length;
      b = kept;
      discrepancy = delta;
      shift = 1;
    } else {
      ++shift;
    }
  }
  c.resize(length + 1, 0);
  return c;
}

// The degree of the greatest common divisor of a polynomial, highest coefficient first, and its
// derivative.
template <class F>
int degree_of_repeated_factors(const F& field, const std::vector<typename F::Residue>& f) {
  using Residue = typename F::Residue;
  std::vector<Residue> a(f), b;
  const std::size_t degree = f.size() - 1;
  for (std::size_t k = 0; k < degree; ++k)
    b.push_back(field.multiply(f[k], static_cast<Residue>(degree - k)));
  const auto trim = [](std::vector<Residue>& x) {
    x.erase(x.begin(), std::find_if(x.begin(), x.end(), [](Residue c) { return c != 0; }));
  };
  trim(b);
  while (!b.empty()) {
    const Residue inverse = field.inverse(b.front());
    while (a.size() >= b.size()) {
      const Residue factor = field.multiply(a.front(), inverse);
      for (std::size_t k = 0; k < b.size(); ++k)
        a[k] = field.subtract(a[k], field.multiply(factor, b[k]));
      a.erase(a.begin());
    }
    trim(a);
    std::swap(a, b);
  }
  return static_cast<int>(a.size()) - 1;
}

// How many values a random linear form takes on the solutions: no more than there are distinct
// ones, and as many unless a random choice was unlucky.
template <class F>
int count_values(const F& field, BorderBasis<F>& basis, int variables, Budget& budget) {
  using Residue = typename F::Residue;
  const int size = basis.dimension();
  if (size == 0) return 0;
  std::vector<Residue> form(variables);
  for (Residue& x : form) x = basis.random();
  budget.keep(static_cast<std::uint64_t>(size) * size);
  std::vector<std::vector<Residue>> rows;
  Accumulator<F> sums(field, size);
  const auto taken = [&] {
    std::vector<Residue> row(size);
    for (int k = 0; k < size; ++k) row[k] = sums.at(k);
    return row;
  };
  for (int k = 0; k < size; ++k) {
    sums.clear();
    for (int i = 0; i < variables; ++i) {
      const std::vector<Residue> image = basis.image(k, i);
      sums.subtract_multiple(0, image.data(), field.negative(form[i]), size);
    }
    budget.spend(static_cast<std::uint64_t>(variables) * size);
    rows.push_back(taken());
  }
  std::vector<Residue> vector(size, 0), weights(size), sequence;
  vector[0] = 1;
  for (Residue& x : weights) x = basis.random();
  for (int step = 0; step < 2 * size; ++step) {
    Residue value = 0;
    for (int k = 0; k < size; ++k)
      value = field.add(value, field.multiply(vector[k], weights[k]));
    sequence.push_back(value);
    sums.clear();
    for (int k = 0; k < size; ++k)
      if (vector[k] != 0)
        sums.subtract_multiple(0, rows[k].data(), field.negative(vector[k]), size);
    budget.spend(static_cast<std::uint64_t>(size) * size);
    vector = taken();
  }
  const std::vector<Residue> polynomial = shortest_recurrence(field, sequence);
  return static_cast<int>(polynomial.size()) - 1 - degree_of_repeated_factors(field, polynomial);
}

}  // namespace gsp
