// Normal monomials and the normal forms of the monomials at their border, as far as they are known.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "budget.hpp"
#include "echelon.hpp"
#include "monomials.hpp"

namespace gsp {
namespace {

template <class F>
class NormalForms {
 public:
  using Residue = typename F::Residue;
  // A vector over the normal monomials up to some degree, the last one first.
  using Vector = std::vector<Residue>;

  int dimension() const { return static_cast<int>(normal_.size()); }
  // A variable times a normal monomial, over the normal monomials in their order.
  Vector image(int k, int i) {
    Vector result = product(normal_[k], i);
    std::reverse(result.begin(), result.end());
    result.resize(dimension(), 0);
    return result;
  }
  // The position of a variable times a normal monomial among the normal ones, or -1.
  int position_of_product(int k, int i) { return position_[times(normal_[k], i)]; }

 protected:
  NormalForms(const F& field, int variables, Budget& budget)
      : field_(field), variables_(variables), budget_(budget), monomials_(variables) {}

  void grow() {
    if (position_.size() < static_cast<std::size_t>(monomials_.size())) {
      position_.resize(monomials_.size(), -1);
      form_.resize(monomials_.size());
    }
  }
  int times(int k, int i) {
    const int result = monomials_.times(k, i);
    grow();
    return result;
  }
  bool is_normal(int k) const { return position_[k] >= 0; }
  Vector unit(int position) const {
    Vector result(position + 1, 0);
    result[0] = 1;
    return result;
  }
  const Vector& known(int k) {
    if (is_normal(k) && form_[k].empty()) {
      form_[k] = unit(position_[k]);
      budget_.keep(form_[k].size());
    }
    return form_[k];
  }
  const Vector& product(int k, int i) { return known(times(k, i)); }
  // The normal form of a monomial below the present degree.
  Vector normal_form(Monomial m, int degree) {
    const int k = monomials_.find(m);
    if (k >= 0 && (is_normal(k) || !form_[k].empty())) return known(k);
    const int i = divisor(m);
    const Vector rest = normal_form(m - variable(i), degree - 1);
    Accumulator<F> sums(field_, dimension());
    add_multiple(sums, rest, i, 1, degree, 0);
    Vector result(dimension());
    for (int t = 0; t < dimension(); ++t) result[t] = sums.at(t);
    return result;
  }
  // A variable that divides a monomial, such that the rest is known, if there is one.
  int divisor(Monomial m) {
    int any = -1;
    for (int i = 0; i < variables_; ++i) {
      if (exponent(m, i) == 0) continue;
      const int k = monomials_.find(m - variable(i));
      if (k >= 0 && (is_normal(k) || !form_[k].empty())) return i;
      any = i;
    }
    return any;
  }
  // Adds a multiple of a variable times a vector. Columns: those of degree d, then the normal
  // monomials, the last one first.
  void add_multiple(Accumulator<F>& sums, const Vector& vector, int i, Residue factor, int d,
                    int top) {
    const int length = static_cast<int>(vector.size());
    for (int t = 0; t < length; ++t) {
      if (vector[t] == 0) continue;
      const Residue value = factor == 1 ? vector[t] : field_.multiply(vector[t], factor);
      add_known(sums, times(normal_[length - 1 - t], i), value, d, top);
    }
    sums.flush();
  }
  void add_known(Accumulator<F>& sums, int k, Residue value, int d, int top) {
    if (top > 0 && monomials_.degree(k) == d) {
      sums.add(column_[k], value);
    } else if (is_normal(k)) {
      sums.add(top + dimension() - 1 - position_[k], value);
    } else {
      const Vector& form = form_[k];
      const int length = static_cast<int>(form.size());
      sums.subtract_later(top + dimension() - length, form.data(), field_.negative(value), length);
      spent_ += length;
    }
  }

  const F& field_;
  int variables_;
  Budget& budget_;
  Monomials monomials_;
  std::vector<int> position_;  // of each monomial among the normal ones, or -1
  std::vector<Vector> form_;   // of each border monomial its normal form
  std::vector<int> normal_;    // the normal monomials, degree by degree
  std::vector<int> start_;     // of each degree the position of its first
  std::vector<int> column_;    // of each monomial of the present degree
  std::uint64_t spent_ = 0;    // multiplications not yet charged
};

}  // namespace
}  // namespace gsp
