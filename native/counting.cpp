// Counts of solutions, compiled once for each instruction set.
#include "counting.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "echelon.hpp"
#include "monomials.hpp"
#include "motion_ring.hpp"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace gsp {
namespace {

// Thrown when the work exceeds its limits.
struct WorkLimit : std::runtime_error {
  WorkLimit() : std::runtime_error("too much work") {}
};

// Counts multiplications and residues, and looks up now and then.
class Budget {
 public:
  Budget(std::uint64_t max_work, std::uint64_t max_entries, std::function<void()> check)
      : max_work_(max_work), max_entries_(max_entries), check_(std::move(check)) {}

  std::uint64_t work() const { return work_; }
  void spend(std::uint64_t work) {
    work_ += work;
    if (work_ > max_work_) throw WorkLimit();
    if (work_ >= next_check_) {
      next_check_ = work_ + kInterval;
      if (check_) check_();
    }
  }
  void keep(std::uint64_t entries) {
    entries_ += entries;
    if (entries_ > max_entries_) throw WorkLimit();
  }
  void release(std::uint64_t entries) { entries_ -= entries; }

 private:
  static constexpr std::uint64_t kInterval = 50'000'000;
  std::uint64_t max_work_, max_entries_, work_ = 0, entries_ = 0, next_check_ = kInterval;
  std::function<void()> check_;
};

// Integers modulo a prime, below 2^30 or below 2^61, and sums of products that are reduced late.

using Wide = unsigned __int128;

// What both share; `Self` gives `Residue`, `Sum` and `reduce`.
template <class Self, class Residue>
struct ResidueOperations {
  const Self& self() const { return static_cast<const Self&>(*this); }

  Residue add(Residue a, Residue b) const {
    const Residue p = self().prime;
    return a >= p - b ? a - (p - b) : a + b;
  }
  Residue negative(Residue a) const { return a == 0 ? 0 : self().prime - a; }
  Residue subtract(Residue a, Residue b) const { return add(a, negative(b)); }
  // By Euclid's algorithm: `left` is a times `coefficient`, modulo p.
  Residue inverse(Residue a) const {
    if (a <= 1) return a;
    std::uint64_t left = a, next = self().prime;
    std::int64_t coefficient = 1, following = 0;
    while (left != 1) {
      const std::uint64_t quotient = next / left;
      const std::uint64_t rest = next - quotient * left;
      const std::int64_t other = following - static_cast<std::int64_t>(quotient) * coefficient;
      next = left, left = rest;
      following = coefficient, coefficient = other;
    }
    return static_cast<Residue>(coefficient < 0 ? coefficient + static_cast<std::int64_t>(self().prime)
                                                : coefficient);
  }
};

// Modulo an odd prime p below 2^30. A sum stays below 8 p^2 < 2^63, so eight products may be
// subtracted before the next test: if the sum is negative then, 8 p^2 is added.
struct Residues30 : ResidueOperations<Residues30, std::uint32_t> {
  using Residue = std::uint32_t;
  using Sum = std::int64_t;
  static constexpr bool kCounted = false;  // sums never overflow

  explicit Residues30(std::uint64_t p)
      : prime(static_cast<Residue>(p)),
        lift_(static_cast<Sum>(8 * p * p)),
        reciprocal_(~std::uint64_t{0} / p) {}

  Residue reduce(Sum sum) const {
    const auto x = static_cast<std::uint64_t>(sum);
    const auto quotient = static_cast<std::uint64_t>((static_cast<Wide>(x) * reciprocal_) >> 64);
    std::uint64_t rest = x - quotient * prime;
    if (rest >= prime) rest -= prime;
    return static_cast<Residue>(rest >= prime ? rest - prime : rest);
  }
  Residue multiply(Residue a, Residue b) const {
    return reduce(static_cast<Sum>(static_cast<std::uint64_t>(a) * b));
  }
  // sums -= factors[0] * rows[0] + ...: up to eight rows
  template <int n>
  void subtract_multiples(Sum* __restrict sums, const Residue* const (&rows)[n],
                          const Residue (&factors)[n], int length) const {
    static_assert(n <= 8);
    int k = 0;
#if defined(__AVX512F__)
    const __m512i lift = _mm512_set1_epi64(lift_);
    __m512i multipliers[n];
    for (int r = 0; r < n; ++r) multipliers[r] = _mm512_set1_epi64(factors[r]);
    for (; k + 8 <= length; k += 8) {
      __m512i t = _mm512_loadu_si512(sums + k);
      for (int r = 0; r < n; ++r) {
        const auto* from = reinterpret_cast<const __m256i*>(rows[r] + k);
        const __m512i row = _mm512_cvtepu32_epi64(_mm256_loadu_si256(from));
        t = _mm512_sub_epi64(t, _mm512_mul_epu32(row, multipliers[r]));
      }
      // As an unsigned number a negative number is larger than all others.
      _mm512_storeu_si512(sums + k, _mm512_min_epu64(t, _mm512_add_epi64(t, lift)));
    }
#elif defined(__AVX2__)
    const __m256i lift = _mm256_set1_epi64x(lift_), zero = _mm256_setzero_si256();
    __m256i multipliers[n];
    for (int r = 0; r < n; ++r) multipliers[r] = _mm256_set1_epi64x(factors[r]);
    for (; k + 4 <= length; k += 4) {
      auto* at = reinterpret_cast<__m256i*>(sums + k);
      __m256i t = _mm256_loadu_si256(at);
      for (int r = 0; r < n; ++r) {
        const auto* from = reinterpret_cast<const __m128i*>(rows[r] + k);
        const __m256i row = _mm256_cvtepu32_epi64(_mm_loadu_si128(from));
        t = _mm256_sub_epi64(t, _mm256_mul_epu32(row, multipliers[r]));
      }
      const __m256i negative = _mm256_cmpgt_epi64(zero, t);
      _mm256_storeu_si256(at, _mm256_add_epi64(t, _mm256_and_si256(negative, lift)));
    }
#endif
    for (; k < length; ++k) {
      Sum t = sums[k];
      for (int r = 0; r < n; ++r)
        t -= static_cast<Sum>(static_cast<std::uint64_t>(factors[r]) * rows[r][k]);
      sums[k] = t + ((t >> 63) & lift_);
    }
  }
  // sums -= factor * row
  void subtract_multiple(Sum* sums, const Residue* row, Residue factor, int length) const {
    subtract_multiples<1>(sums, {row}, {factor}, length);
  }

  Residue prime;

 private:
  Sum lift_;
  std::uint64_t reciprocal_;
};

// Modulo an odd prime between 2^60 and 2^61. Products are below 2^122: `kCapacity` of them and a
// residue fit into a sum.
struct Residues61 : ResidueOperations<Residues61, std::uint64_t> {
  using Residue = std::uint64_t;
  using Sum = Wide;
  static constexpr bool kCounted = true;
  static constexpr int kCapacity = 60;

  // The division by the normalized divisor 8 p is that of Moeller and Granlund, "Improved division
  // by invariant integers", IEEE Trans. Comput. 60 (2011), algorithm 4.
  explicit Residues61(std::uint64_t p)
      : prime(p),
        divisor_(p << kShift),
        reciprocal_(static_cast<std::uint64_t>(~Wide{0} / (p << kShift) - (Wide{1} << 64))) {}

  Residue reduce(Sum sum) const {
    std::uint64_t high = static_cast<std::uint64_t>(sum >> 64);
    const std::uint64_t low = static_cast<std::uint64_t>(sum);
    if (high >= divisor_) high -= divisor_;
    const Wide q = static_cast<Wide>(reciprocal_) * high +
                   ((static_cast<Wide>(high) << 64) | low);
    const std::uint64_t quotient = static_cast<std::uint64_t>(q >> 64) + 1;
    std::uint64_t rest = low - quotient * divisor_;
    if (rest > static_cast<std::uint64_t>(q)) rest += divisor_;
    if (rest >= divisor_) rest -= divisor_;
    if (rest >= 4 * prime) rest -= 4 * prime;
    if (rest >= 2 * prime) rest -= 2 * prime;
    return rest >= prime ? rest - prime : rest;
  }
  Residue multiply(Residue a, Residue b) const { return reduce(static_cast<Wide>(a) * b); }
  // sums -= factor * row; at most `kCapacity` times before all sums are reduced
  void subtract_multiple(Sum* __restrict sums, const Residue* __restrict row, Residue factor,
                         int length) const {
    const Residue minus = negative(factor);
    for (int k = 0; k < length; ++k) sums[k] += static_cast<Wide>(minus) * row[k];
  }
  // The same with several rows at once, which count as so many times.
  template <int n>
  void subtract_multiples(Sum* __restrict sums, const Residue* const (&rows)[n],
                          const Residue (&factors)[n], int length) const {
    Residue minus[n];
    for (int r = 0; r < n; ++r) minus[r] = negative(factors[r]);
    for (int k = 0; k < length; ++k) {
      Sum t = sums[k];
      for (int r = 0; r < n; ++r) t += static_cast<Wide>(minus[r]) * rows[r][k];
      sums[k] = t;
    }
  }

  Residue prime;

 private:
  static constexpr int kShift = 3;
  std::uint64_t divisor_, reciprocal_;
};

// Border bases modulo a prime: the normal monomials of an ideal and how variables multiply them.
//
// Works degree by degree, after B. Mourrain, "A new criterion for normal form algorithms", AAECC
// 1999. The products of the normal monomials of degree d - 1 and the variables are reduced. They
// are reduced by the generators of degree d and by the commutators x_i (x_j u) = x_j (x_i u), u
// normal of degree d - 2. A relation whose top form vanishes (a fall of degree) becomes a generator
// of its degree, and the work continues from that degree. Rows that were reduced before are kept.
// The normal monomials are those of the degree reverse lexicographic order.

// Normal monomials and the normal forms of the monomials at their border, as far as they are known.

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

template <class F>
class BorderBasis : public NormalForms<F> {
 public:
  using Base = NormalForms<F>;
  using typename Base::Residue;
  using typename Base::Vector;
  using Base::dimension;

  BorderBasis(const F& field, int variables, std::vector<Polynomial<F>> generators,
              std::uint64_t seed, Budget& budget, std::vector<EliminationStep>* trace = nullptr)
      : Base(field, variables, budget),
        generators_(std::move(generators)),
        random_(seed),
        trace_(trace) {}

  // Finds the basis; returns false if the solutions are not finite in number.
  bool compute();

  int falls() const { return falls_; }
  bool all_commutators() const { return all_commutators_; }
  // The degree of the products of generators and monomials of which all relations are sums.
  int reach() const { return reach_; }
  Residue random() { return static_cast<Residue>(random_() % field_.prime); }

 private:
  using Base::add_known, Base::add_multiple, Base::divisor, Base::is_normal, Base::known;
  using Base::normal_form, Base::product, Base::times;
  using Base::budget_, Base::column_, Base::field_, Base::form_, Base::monomials_, Base::normal_;
  using Base::position_, Base::spent_, Base::start_, Base::variables_;

  struct Commutator {
    int monomial, i, j;
  };
  // A reduced row of an earlier step, by the numbers of its monomials.
  struct Carried {
    int step, row;
    std::vector<std::pair<int, Residue>> terms;
  };

  // Makes room for what is kept of each monomial.
  void make_room() {
    origin_.resize(monomials_.size());
    was_normal_.resize(monomials_.size(), 0);
    is_fresh_.resize(monomials_.size(), 0);
  }
  std::vector<int> columns_of(int d);
  void add_generators(Echelon<F>& matrix, int d);
  void add_carried(Echelon<F>& matrix, int d);
  void add_commutators(Echelon<F>& matrix, int d);
  void add_term(Accumulator<F>& sums, Monomial m, int degree, Residue value, int d);
  bool is_carried(int d) const {
    return d < static_cast<int>(carried_.size()) && !carried_[d].empty();
  }
  void carry(const Echelon<F>& matrix, const std::vector<int>& columns, int from, int d);
  void spend(const Echelon<F>& matrix) {
    budget_.spend(matrix.work() - std::exchange(seen_work_, matrix.work()) + matrix.columns() +
                  std::exchange(spent_, 0));
  }
  template <class Source>
  bool push(Echelon<F>& matrix, const Source& source) {
    const bool grown = matrix.push();
    spend(matrix);
    if (grown && trace_ != nullptr) {
      trace_->back().sources.push_back(source());
      trace_->back().pivots.push_back(matrix.pivot(matrix.rank() - 1));
    }
    return grown;
  }
  bool push_commutator(Echelon<F>& matrix, const Commutator& row, int d) {
    matrix.accumulator.clear();
    add_multiple(matrix.accumulator, product(row.monomial, row.i), row.j, 1, d, top_);
    add_multiple(matrix.accumulator, product(row.monomial, row.j), row.i, field_.negative(1), d,
                 top_);
    return push(matrix, [&] {
      std::vector<int> source{row.i, row.j};
      for (int i = 0; i < variables_; ++i)
        source.push_back(exponent(monomials_[row.monomial], i));
      return source;
    });
  }
  bool has_new_commutator(Echelon<F>& matrix, int d);
  Vector times_form(const Vector& form, const Vector& vector, int d);
  bool take_falls(const Echelon<F>& matrix, int& d);
  void commit(const Echelon<F>& matrix, const std::vector<int>& columns, int d);
  void forget_from(int d);
  bool is_positive(int d) const;

  static constexpr int kRowsBetweenTrials = 16, kStreak = 8;
  static constexpr int kTests = sizeof(Residue) == 8 ? 1 : 3;  // small primes need more

  std::vector<Polynomial<F>> generators_;
  std::mt19937_64 random_;
  std::vector<EliminationStep>* trace_;
  std::vector<int> hilbert_;                       // normal monomials of each degree
  std::vector<std::pair<Monomial, int>> leading_;  // minimal leading monomials, their degrees
  std::vector<std::pair<int, int>> origin_;        // of each normal form the step and its row
  std::vector<std::vector<Carried>> carried_;      // by degree
  std::vector<char> was_normal_;  // whether a monomial was normal before the last fall
  std::vector<char> is_fresh_;    // whether it leads since then
  int steps_ = 0;
  int top_ = 0;  // columns of the present degree
  int falls_ = 0;
  // By how much the products may exceed the relations made of them.
  int excess_ = 0;
  int reach_ = 0;
  bool all_commutators_ = true;
  std::uint64_t seen_work_ = 0;
};

template <class F>
bool BorderBasis<F>::compute() {
  Base::grow();
  for (const Polynomial<F>& generator : generators_) {
    if (generator.degree < 2) {  // it was a quadric
      ++falls_;
      excess_ = std::max(excess_, 2 - generator.degree);
    }
    if (generator.degree == 0) return true;  // no solution
  }
  normal_ = {0};
  position_[0] = 0;
  start_ = {0};
  hilbert_ = {1};
  for (int d = 1;; ++d) {
    if (d > kMaxDegree - 1) throw WorkLimit();
    const std::vector<int> columns = columns_of(d);
    Echelon<F> matrix(field_, top_ + dimension());
    seen_work_ = 0;
    if (trace_ != nullptr) trace_->push_back({d, {}, {}});
    ++steps_;
    add_generators(matrix, d);
    add_carried(matrix, d);
    if (d >= 2) add_commutators(matrix, d);
    matrix.back_substitute();
    spend(matrix);
    const int present = d;
    reach_ = std::max(reach_, d + excess_);
    if (take_falls(matrix, d)) {
      excess_ += present - d;
      if (d > 0) carry(matrix, columns, d, present);
      if (d == 0) {
        forget_from(0);
        return true;  // no solution
      }
      forget_from(d);
      --d;
      continue;
    }
    commit(matrix, columns, d);
    int last = static_cast<int>(hilbert_.size()) - 1;
    while (last > 0 && hilbert_[last] == 0) --last;
    if (d >= last + 2) return true;
    if (is_positive(d)) return false;
  }
}

// Numbers the columns: the products of normal monomials of degree d - 1 and the variables.
template <class F>
std::vector<int> BorderBasis<F>::columns_of(int d) {
  std::vector<int> columns;
  for (int k = start_[d - 1]; k < dimension(); ++k)
    for (int i = 0; i < variables_; ++i) columns.push_back(times(normal_[k], i));
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  std::sort(columns.begin(), columns.end(),
            [&](int a, int b) { return monomials_.greater(a, b); });
  make_room();
  column_.assign(monomials_.size(), -1);
  top_ = static_cast<int>(columns.size());
  for (int c = 0; c < top_; ++c) column_[columns[c]] = c;
  return columns;
}

template <class F>
void BorderBasis<F>::add_generators(Echelon<F>& matrix, int d) {
  for (std::size_t g = 0; g < generators_.size(); ++g) {
    const Polynomial<F>& generator = generators_[g];
    if (generator.degree != d) continue;
    matrix.accumulator.clear();
    for (const auto& [m, value] : generator.terms) {
      int degree = 0;
      for (int i = 0; i < variables_; ++i) degree += exponent(m, i);
      add_term(matrix.accumulator, m, degree, value, d);
    }
    push(matrix, [&] { return std::vector<int>{static_cast<int>(g)}; });
  }
}

// Adds a multiple of any monomial up to degree d.
template <class F>
void BorderBasis<F>::add_term(Accumulator<F>& sums, Monomial m, int degree, Residue value, int d) {
  if (degree == 0) {
    sums.add(top_ + dimension() - 1, value);
    return;
  }
  const int i = divisor(m);
  add_multiple(sums, normal_form(m - variable(i), degree - 1), i, value, d, top_);
}

// Makes generators of the rows without a monomial of degree d; d becomes the least of their degrees.
template <class F>
bool BorderBasis<F>::take_falls(const Echelon<F>& matrix, int& d) {
  int least = d;
  for (int row = 0; row < matrix.rank(); ++row) {
    if (matrix.pivot(row) < top_) continue;
    Polynomial<F> generator;
    for (int c = matrix.pivot(row); c < matrix.columns(); ++c) {
      const Residue value = matrix.entry(row, c);
      if (value == 0) continue;
      const int k = normal_[top_ + dimension() - 1 - c];
      generator.terms.emplace_back(monomials_[k], value);
      generator.degree = std::max(generator.degree, monomials_.degree(k));
    }
    least = std::min(least, generator.degree);
    generators_.push_back(std::move(generator));
    ++falls_;
  }
  const bool any = least < d;
  d = least;
  return any;
}

template <class F>
void BorderBasis<F>::commit(const Echelon<F>& matrix, const std::vector<int>& columns, int d) {
  const int before = dimension();
  start_.push_back(before);
  std::vector<int> added;
  for (int c = top_ - 1; c >= 0; --c) {
    if (matrix.row_of(c) >= 0) continue;
    position_[columns[c]] = dimension();
    normal_.push_back(columns[c]);
    added.push_back(c);
  }
  hilbert_.push_back(static_cast<int>(added.size()));
  for (int c = 0; c < top_; ++c) {
    const int row = matrix.row_of(c);
    if (row < 0) continue;
    Vector form(dimension());
    const int fresh = static_cast<int>(added.size());
    for (int t = 0; t < fresh; ++t)
      form[fresh - 1 - t] = field_.negative(matrix.entry(row, added[t]));
    for (int t = 0; t < before; ++t) form[fresh + t] = field_.negative(matrix.entry(row, top_ + t));
    budget_.keep(form.size());
    form_[columns[c]] = std::move(form);
    origin_[columns[c]] = {steps_ - 1, row};
    is_fresh_[columns[c]] = was_normal_[columns[c]];
    const Monomial m = monomials_[columns[c]];
    bool minimal = true;
    for (int i = 0; i < variables_ && minimal; ++i) {
      if (exponent(m, i) == 0) continue;
      const int k = monomials_.find(m - variable(i));
      minimal = k >= 0 && is_normal(k);
    }
    if (minimal) leading_.emplace_back(m, d);
  }
}

template <class F>
void BorderBasis<F>::forget_from(int d) {
  for (int k = 0; k < monomials_.size(); ++k)
    if (monomials_.degree(k) >= d) {
      position_[k] = -1;
      if (k < static_cast<int>(form_.size())) {
        budget_.release(form_[k].size());
        form_[k] = Vector();
      }
    }
  if (static_cast<int>(start_.size()) > d) {
    normal_.resize(start_[d]);
    start_.resize(d);
    hilbert_.resize(d);
  }
  std::erase_if(leading_, [&](const auto& entry) { return entry.second >= d; });
}

// Whether all critical pairs are behind, and some variable has no power that leads.
template <class F>
bool BorderBasis<F>::is_positive(int d) const {
  int needed = 2;
  for (const Polynomial<F>& generator : generators_) needed = std::max(needed, generator.degree);
  for (std::size_t a = 0; a < leading_.size() && needed <= d; ++a)
    for (std::size_t b = a + 1; b < leading_.size(); ++b) {
      int degree = 0;
      bool coprime = true;
      for (int i = 0; i < variables_; ++i) {
        const int x = exponent(leading_[a].first, i), y = exponent(leading_[b].first, i);
        degree += std::max(x, y);
        coprime &= x == 0 || y == 0;
      }
      if (!coprime) needed = std::max(needed, degree);
    }
  if (needed > d) return false;
  for (int i = 0; i < variables_; ++i) {
    const bool pure = std::any_of(leading_.begin(), leading_.end(), [&](const auto& entry) {
      return entry.first == variable(i) * static_cast<unsigned>(entry.second);
    });
    if (!pure) return true;
  }
  return false;
}

// Border bases: rows that were reduced before a fall of degree and are used again after it.

template <class F>
void BorderBasis<F>::add_carried(Echelon<F>& matrix, int d) {
  if (!is_carried(d)) return;
  for (const Carried& carried : carried_[d]) {
    matrix.accumulator.clear();
    for (const auto& [k, value] : carried.terms) {
      const int degree = monomials_.degree(k);
      if (degree == d && k < static_cast<int>(column_.size()) && column_[k] >= 0) {
        matrix.accumulator.add(column_[k], value);
      } else if (degree < d && (is_normal(k) || !form_[k].empty())) {
        add_known(matrix.accumulator, k, value, d, top_);
      } else {
        add_term(matrix.accumulator, monomials_[k], degree, value, d);
      }
    }
    matrix.accumulator.flush();
    push(matrix, [&] { return std::vector<int>{-1, carried.step, carried.row}; });
  }
  budget_.spend(carried_[d].size());
}

// Keeps the reduced rows of the degrees that will be done again.
template <class F>
void BorderBasis<F>::carry(const Echelon<F>& matrix, const std::vector<int>& columns, int from,
                           int d) {
  if (static_cast<int>(carried_.size()) <= d) carried_.resize(d + 1);
  for (int degree = from; degree <= d; ++degree) carried_[degree].clear();
  std::fill(was_normal_.begin(), was_normal_.end(), 0);
  std::fill(is_fresh_.begin(), is_fresh_.end(), 0);
  for (const int k : normal_) was_normal_[k] = 1;
  for (int c = 0; c < top_; ++c) {
    const int row = matrix.row_of(c);
    if (row < 0) {
      was_normal_[columns[c]] = 1;
      continue;
    }
    Carried kept{steps_ - 1, row, {}};
    for (int other = c; other < matrix.columns(); ++other) {
      const Residue value = matrix.entry(row, other);
      if (value == 0) continue;
      kept.terms.emplace_back(
          other < top_ ? columns[other] : normal_[top_ + dimension() - 1 - other], value);
    }
    carried_[d].push_back(std::move(kept));
  }
  for (int k = 0; k < static_cast<int>(form_.size()); ++k) {
    const int degree = monomials_.degree(k);
    if (degree < from || degree >= d || is_normal(k) || form_[k].empty()) continue;
    Carried kept{origin_[k].first, origin_[k].second, {{k, 1}}};
    const int length = static_cast<int>(form_[k].size());
    for (int t = 0; t < length; ++t)
      if (form_[k][t] != 0)
        kept.terms.emplace_back(normal_[length - 1 - t], field_.negative(form_[k][t]));
    carried_[degree].push_back(std::move(kept));
  }
  // The least leading monomials first, so that tails are reduced when they are used.
  for (int degree = from; degree <= d; ++degree)
    std::sort(carried_[degree].begin(), carried_[degree].end(),
              [&](const Carried& a, const Carried& b) {
                return monomials_.greater(b.terms.front().first, a.terms.front().first);
              });
}

// Border bases: commutators of two variables on the normal monomials, and a test whether there are enough.

template <class F>
void BorderBasis<F>::add_commutators(Echelon<F>& matrix, int d) {
  // The first row of each column that is a multiple of an old leading monomial comes first, the
  // least columns first, so that its tail is reduced already.
  std::vector<std::pair<int, Commutator>> first;
  std::vector<Commutator> rest;
  std::vector<char> seen(top_, 0);
  for (int k = start_[d - 2]; k < start_[d - 1]; ++k)
    for (int i = 0; i < variables_; ++i)
      for (int j = i + 1; j < variables_; ++j) {
        const int a = times(normal_[k], i), b = times(normal_[k], j);
        if (is_normal(a) && is_normal(b)) continue;
        const int both = times(a, j);
        const int column =
            both < static_cast<int>(column_.size()) ? column_[both] : -1;
        const bool next_door = is_normal(a) || is_normal(b);
        if (next_door && column >= 0 && !seen[column]) {
          seen[column] = 1;
          first.push_back({column, {normal_[k], i, j}});
        } else {
          rest.push_back({normal_[k], i, j});
        }
      }
  std::sort(first.begin(), first.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  if (is_carried(d)) {
    // Old commutators lie in the span of the rows carried over; new ones come from monomials that
    // did not lead before.
    for (const auto& [column, row] : first) rest.push_back(row);
    const auto old = std::stable_partition(rest.begin(), rest.end(), [&](const Commutator& row) {
      return is_fresh_[times(row.monomial, row.i)] || is_fresh_[times(row.monomial, row.j)];
    });
    for (auto row = rest.begin(); row != old; ++row) push_commutator(matrix, *row, d);
    rest.erase(rest.begin(), old);
  } else {
    for (const auto& [column, row] : first) push_commutator(matrix, row, d);
  }
  std::shuffle(rest.begin(), rest.end(), random_);
  // Random combinations of all commutators show whether the remaining ones add nothing new.
  std::size_t next = 0;
  int streak = kStreak;
  while (next < rest.size()) {
    if (streak >= kStreak) {
      streak = 0;
      int tests = 0;
      while (tests < kTests && !has_new_commutator(matrix, d)) ++tests;
      if (tests == kTests) {
        all_commutators_ = false;
        return;
      }
    }
    for (int k = 0; k < kRowsBetweenTrials && next < rest.size(); ++k, ++next)
      streak = push_commutator(matrix, rest[next], d) ? 0 : streak + 1;
  }
}

template <class F>
typename BorderBasis<F>::Vector BorderBasis<F>::times_form(const Vector& form,
                                                            const Vector& vector, int d) {
  Accumulator<F> sums(field_, dimension());
  for (int i = 0; i < variables_; ++i) add_multiple(sums, vector, i, form[i], d, 0);
  Vector result(dimension());
  for (int t = 0; t < dimension(); ++t) result[t] = sums.at(t);
  return result;
}

// Whether a (b u) - b (a u), for random linear forms a, b and a random combination u, is new.
template <class F>
bool BorderBasis<F>::has_new_commutator(Echelon<F>& matrix, int d) {
  Vector a(variables_), b(variables_), u(start_[d - 1], 0);
  for (Residue& x : a) x = random();
  for (Residue& x : b) x = random();
  for (int t = 0; t < start_[d - 1] - start_[d - 2]; ++t) u[t] = random();
  const Vector au = times_form(a, u, d), bu = times_form(b, u, d);
  matrix.accumulator.clear();
  for (int i = 0; i < variables_; ++i) {
    add_multiple(matrix.accumulator, bu, i, a[i], d, top_);
    add_multiple(matrix.accumulator, au, i, field_.negative(b[i]), d, top_);
  }
  const bool is_new = matrix.reduce() >= 0;
  spend(matrix);
  return is_new;
}

// The finite algebra of the solutions: minimal polynomials of linear forms, and where they vanish.

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

// The algebra of the solutions: a vector space over the normal monomials, in their order.
template <class F>
class SolutionAlgebra {
 public:
  using Residue = typename F::Residue;
  using Vector = std::vector<Residue>;
  using Matrix = std::vector<Vector>;

  SolutionAlgebra(const F& field, BorderBasis<F>& basis, int variables, Budget& budget)
      : field_(field), basis_(basis), variables_(variables), budget_(budget) {}

  // How many values a random linear form takes on the solutions: no more than there are distinct
  // ones, and as many unless a random choice was unlucky. Of many solutions first those of a
  // variable, whose matrix is sparse: if it tells all solutions apart, that is the number.
  int count_values() {
    if (size() == 0) return 0;
    Vector one(size(), 0);
    one[0] = 1;
    if (size() >= kMany && count_values(one, multiplication(sparsest_variable())) == size())
      return size();
    return count_values(one, multiplication(random_form()));
  }

  // An element of the algebra: an affine form plus weighted squares of affine forms; the constant
  // of a form is its last entry.
  struct Element {
    Vector form;
    std::vector<std::pair<Residue, Vector>> squares;
  };

  // How many solutions there are, and how many values a form takes on them, where none of some
  // elements vanishes; on all of them it takes `distinct`.
  std::pair<int, int> count_where_not_zero(const std::vector<Element>& elements, int distinct) {
    Matrix space;
    for (int k = 0; k < size(); ++k) {
      space.emplace_back(size(), 0);
      space.back()[k] = 1;
    }
    for (const Element& element : elements) {
      const Matrix matrix = multiplication(element);
      // The images under powers shrink to the part where the element is a unit.
      for (std::size_t before = size() + 1; !space.empty() && space.size() != before;) {
        before = space.size();
        space = image(space, matrix);
      }
    }
    if (space.empty()) return {0, 0};
    if (static_cast<int>(space.size()) == size()) return {size(), distinct};
    Accumulator<F> sums(field_, size());
    for (const Vector& row : space) sums.subtract_multiple(0, row.data(), basis_.random(), size());
    return {static_cast<int>(space.size()),
            count_values(taken(sums), multiplication(random_form()))};
  }

 private:
  static constexpr int kMany = 100;

  int size() const { return basis_.dimension(); }

  Vector random_form() {
    Vector form(variables_ + 1);
    for (Residue& x : form) x = basis_.random();
    return form;
  }
  // The variable whose products with normal monomials are most often normal.
  Vector sparsest_variable() {
    int best = 0, most = -1;
    for (int i = 0; i < variables_; ++i) {
      int normal = 0;
      for (int k = 0; k < size(); ++k) normal += basis_.position_of_product(k, i) >= 0;
      if (normal > most) best = i, most = normal;
    }
    Vector form(variables_ + 1, 0);
    form[best] = 1;
    return form;
  }
  Vector taken(Accumulator<F>& sums) const {
    sums.flush();
    Vector row(size());
    for (int k = 0; k < size(); ++k) row[k] = sums.at(k);
    return row;
  }
  // The products of an affine form and the normal monomials.
  Matrix multiplication(const Vector& form) {
    budget_.keep(static_cast<std::uint64_t>(size()) * size());
    Matrix rows;
    Accumulator<F> sums(field_, size());
    for (int k = 0; k < size(); ++k) {
      sums.clear();
      sums.set(k, form[variables_]);
      for (int i = 0; i < variables_; ++i) {
        if (form[i] == 0) continue;
        const Vector image = basis_.image(k, i);
        sums.subtract_multiple(0, image.data(), field_.negative(form[i]), size());
      }
      budget_.spend(static_cast<std::uint64_t>(variables_) * size());
      rows.push_back(taken(sums));
    }
    return rows;
  }
  Matrix multiplication(const Element& element) {
    Matrix result = multiplication(element.form);
    for (const auto& [weight, form] : element.squares) {
      const Matrix once = multiplication(form);
      for (int k = 0; k < size(); ++k) {
        const Vector twice = product(once[k], once);
        for (int j = 0; j < size(); ++j)
          result[k][j] = field_.add(result[k][j], field_.multiply(weight, twice[j]));
      }
    }
    return result;
  }
  Vector product(const Vector& vector, const Matrix& matrix) {
    return product(vector, matrix, std::vector<int>(size(), -1));
  }
  // The same for a matrix some of whose rows have a one and nothing else: where, or -1.
  Vector product(const Vector& vector, const Matrix& matrix, const std::vector<int>& ones) {
    Accumulator<F> sums(field_, size());
    std::uint64_t work = size();
    for (int k = 0; k < size(); ++k) {
      if (vector[k] == 0) continue;
      if (ones[k] >= 0) {
        sums.add(ones[k], vector[k]);
      } else {
        sums.subtract_later(0, matrix[k].data(), field_.negative(vector[k]), size());
        work += size();
      }
    }
    budget_.spend(work);
    return taken(sums);
  }
  // Of each row where it has a one and nothing else, or -1.
  std::vector<int> ones(const Matrix& matrix) const {
    std::vector<int> result;
    for (const Vector& row : matrix) {
      const auto is_zero = [](Residue x) { return x == 0; };
      const auto first = std::find_if_not(row.begin(), row.end(), is_zero);
      const bool is_one = first != row.end() && *first == 1 &&
                          std::all_of(first + 1, row.end(), is_zero);
      result.push_back(is_one ? static_cast<int>(first - row.begin()) : -1);
    }
    return result;
  }
  // A basis of the images of some vectors.
  Matrix image(const Matrix& vectors, const Matrix& matrix) {
    Echelon<F> echelon(field_, size());
    Matrix result;
    for (const Vector& vector : vectors) {
      const Vector row = product(vector, matrix);
      echelon.accumulator.clear();
      for (int k = 0; k < size(); ++k) echelon.accumulator.set(k, row[k]);
      const std::uint64_t before = echelon.work();
      if (echelon.push()) result.push_back(row);
      budget_.spend(echelon.work() - before);
    }
    return result;
  }
  // How many values a form takes on the solutions where an element does not vanish.
  int count_values(Vector vector, const Matrix& matrix) {
    const std::vector<int> sparse = ones(matrix);
    Vector weights(size()), sequence;
    for (Residue& x : weights) x = basis_.random();
    for (int step = 0; step < 2 * size(); ++step) {
      Residue value = 0;
      for (int k = 0; k < size(); ++k)
        value = field_.add(value, field_.multiply(vector[k], weights[k]));
      sequence.push_back(value);
      vector = product(vector, matrix, sparse);
    }
    const Vector polynomial = shortest_recurrence(field_, sequence);
    return static_cast<int>(polynomial.size()) - 1 -
           degree_of_repeated_factors(field_, polynomial);
  }

  const F& field_;
  BorderBasis<F>& basis_;
  int variables_;
  Budget& budget_;
};

// A row of the problem as an element of the algebra of solutions.
template <class F>
typename SolutionAlgebra<F>::Element element(const MotionRing<F>& ring,
                                             const CountingProblem& problem, int row) {
  const int width = kFunctions + problem.moments;
  typename SolutionAlgebra<F>::Element result{ring.affine(problem.functions + row * width), {}};
  for (int s = 0; s < problem.squares; ++s)
    if (problem.owners[s] == row)
      result.squares.emplace_back(static_cast<typename F::Residue>(problem.weights[s]),
                                  ring.affine(problem.square_functions + s * width));
  return result;
}

template <class F>
CountingResult count(const CountingProblem& problem) {
  const F field(problem.prime);
  Budget budget(problem.max_work, problem.max_entries, problem.check);
  CountingResult result{CountingOutcome::kFinite, 0, 0, {}, {}, 0, 2, true, 0};
  MotionRing<F> ring(field, problem);
  if (ring.is_inconsistent()) {
    result.falls = 1;
    return result;
  }
  Elimination* const elimination = problem.elimination;
  BorderBasis<F> basis(field, ring.variables(), ring.generators(elimination), problem.seed, budget,
                       elimination == nullptr ? nullptr : &elimination->steps);
  result.distinct = -1;
  try {
    if (basis.compute()) {
      result.solutions = basis.dimension();
    } else {
      result.outcome = CountingOutcome::kInfinite;
    }
  } catch (const WorkLimit&) {
    result.outcome = CountingOutcome::kStopped;
  }
  result.falls = basis.falls();
  result.reach = basis.reach();
  result.all_commutators = basis.all_commutators();
  if (result.outcome == CountingOutcome::kFinite && problem.find_distinct) {
    SolutionAlgebra<F> algebra(field, basis, ring.variables(), budget);
    try {
      result.distinct = algebra.count_values();
      for (const std::vector<int>& group : problem.groups) {
        std::vector<typename SolutionAlgebra<F>::Element> elements;
        for (const int row : group) elements.push_back(element<F>(ring, problem, row));
        const auto [apart, distinct] = algebra.count_where_not_zero(elements, result.distinct);
        result.apart.push_back(apart);
        result.apart_distinct.push_back(distinct);
      }
    } catch (const WorkLimit&) {
    }
  }
  result.work = budget.work();
  return result;
}

}  // namespace

CountingResult GSP_COUNT(const CountingProblem& problem) {
  return problem.prime >> 30 == 0 ? count<Residues30>(problem) : count<Residues61>(problem);
}

}  // namespace gsp
