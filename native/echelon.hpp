// Gaussian elimination modulo a prime, a row at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gsp {
namespace {

// A dense row that is being built: sums of products, reduced late.
template <class F>
class Accumulator {
 public:
  using Residue = typename F::Residue;
  using Sum = typename F::Sum;

  Accumulator(const F& field, int columns) : field_(field), sums_(columns, 0) {}

  int size() const { return static_cast<int>(sums_.size()); }
  void clear() { std::fill(sums_.begin(), sums_.end(), Sum{0}), pending_ = 0; }
  void add(int column, Residue value) {
    sums_[column] = field_.add(field_.reduce(sums_[column]), value);
  }
  void subtract_multiple(int column, const Residue* row, Residue factor, int length) {
    if constexpr (F::kCounted) {
      if (++pending_ > F::kCapacity) reduce_all();
    }
    field_.subtract_multiple(sums_.data() + column, row, factor, length);
  }
  bool is_untouched(int column) const { return sums_[column] == 0; }
  // The residue in a column, which is kept reduced.
  Residue at(int column) {
    const Residue value = field_.reduce(sums_[column]);
    sums_[column] = value;
    return value;
  }
  void set(int column, Residue value) { sums_[column] = value; }

 private:
  void reduce_all() {
    for (Sum& sum : sums_) sum = field_.reduce(sum);
    pending_ = 1;
  }

  const F& field_;
  std::vector<Sum> sums_;
  int pending_ = 0;
};

// Rows in echelon form: row k has a one in its pivot column and zeros before it. A row ends with
// its last entry that is not zero.
template <class F>
class Echelon {
 public:
  using Residue = typename F::Residue;
  using Row = std::vector<Residue>;

  Echelon(const F& field, int columns)
      : field_(field), row_of_(columns, -1), accumulator(field, columns) {}

  int rank() const { return static_cast<int>(pivots_.size()); }
  int columns() const { return accumulator.size(); }
  // The row whose pivot a column is, or -1.
  int row_of(int column) const { return row_of_[column]; }
  int pivot(int row) const { return pivots_[row]; }
  // The entry of a row in a column.
  Residue entry(int row, int column) const {
    const int offset = column - pivots_[row];
    return offset >= 0 && offset < static_cast<int>(rows_[row].size()) ? rows_[row][offset] : 0;
  }
  std::uint64_t work() const { return work_; }

  // Reduces the accumulator by all rows; if something remains it becomes a row: returns whether.
  bool push() {
    const int lead = reduce();
    if (lead < 0) return false;
    row_of_[lead] = rank();
    pivots_.push_back(lead);
    rows_.push_back(taken(lead, field_.inverse(accumulator.at(lead))));
    return true;
  }

  // Reduces the accumulator by all rows; returns its first column that is not zero, or -1.
  int reduce() {
    int lead = -1;
    for (int column = 0; column < columns(); ++column) {
      if (accumulator.is_untouched(column)) continue;
      const Residue value = accumulator.at(column);
      if (value == 0) continue;
      if (row_of_[column] >= 0) {
        eliminate(column, value);
      } else if (lead < 0) {
        lead = column;
      }
    }
    return lead;
  }

  // Makes every pivot the only entry of its column.
  void back_substitute() {
    std::vector<int> order(pivots_);
    std::sort(order.begin(), order.end(), std::greater<int>());
    for (const int pivot : order) {
      Row& row = rows_[row_of_[pivot]];
      const int end = pivot + static_cast<int>(row.size());
      const auto needs = [&](int column) {
        return row[column - pivot] != 0 && row_of_[column] >= 0;
      };
      int first = pivot + 1;
      while (first < end && !needs(first)) ++first;
      if (first == end) continue;
      accumulator.clear();
      for (int column = pivot; column < end; ++column)
        accumulator.set(column, row[column - pivot]);
      for (int column = first; column < columns(); ++column) {
        if (row_of_[column] < 0 || accumulator.is_untouched(column)) continue;
        const Residue value = accumulator.at(column);
        if (value != 0) eliminate(column, value);
      }
      row = taken(pivot, 1);
    }
  }

 private:
  void eliminate(int column, Residue value) {
    const Row& row = rows_[row_of_[column]];
    accumulator.subtract_multiple(column, row.data(), value, static_cast<int>(row.size()));
    work_ += row.size();
  }
  Row taken(int from, Residue factor) {
    Row row(columns() - from);
    for (int column = from; column < columns(); ++column)
      row[column - from] = field_.multiply(accumulator.at(column), factor);
    while (row.back() == 0) row.pop_back();
    return row;
  }

  const F& field_;
  std::vector<int> row_of_, pivots_;
  std::vector<Row> rows_;
  std::uint64_t work_ = 0;

 public:
  Accumulator<F> accumulator;
};

}  // namespace
}  // namespace gsp
