// Gaussian elimination modulo a prime, a row at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gsp {
namespace {

// A dense row that is being built: sums of products, reduced late. Multiples of rows may be
// subtracted later, several at once; until then (`flush`) the sums are not valid.
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
      if (++pending_ > F::kCapacity) {
        reduce_all();
        pending_ = 1;
      }
    }
    field_.subtract_multiple(sums_.data() + column, row, factor, length);
  }
  void subtract_later(int column, const Residue* row, Residue factor, int length) {
    if (length < kShortest) {
      subtract_multiple(column, row, factor, length);
      return;
    }
    waiting_[waiting_count_++] = {column, column + length, row, factor};
    if (waiting_count_ == kTogether) flush();
  }
  void flush() {
    if (waiting_count_ == kTogether) {
      subtract_together();
    } else {
      for (int k = 0; k < waiting_count_; ++k) {
        const Waiting& one = waiting_[k];
        subtract_multiple(one.begin, one.row, one.factor, one.end - one.begin);
      }
    }
    waiting_count_ = 0;
  }
  bool is_untouched(int column) const { return sums_[column] == 0; }
  // The residue in a column, which is kept reduced.
  Residue at(int column) {
    const Sum sum = sums_[column];
    if (sum < field_.prime) return static_cast<Residue>(sum);
    const Residue value = field_.reduce(sum);
    sums_[column] = value;
    return value;
  }
  void set(int column, Residue value) { sums_[column] = value; }

 private:
  // The number of rows that are subtracted together, and the least length at which this is quicker.
  static constexpr int kTogether = 8, kShortest = 64;

  struct Waiting {
    int begin, end;  // columns
    const Residue* row;
    Residue factor;
  };

  void reduce_all() {
    for (Sum& sum : sums_) sum = field_.reduce(sum);
    pending_ = 0;
  }
  // Subtracts the common columns of all rows together, and the others of each row alone.
  void subtract_together() {
    int begin = 0, end = size();
    for (const Waiting& one : waiting_) {
      begin = std::max(begin, one.begin);
      end = std::min(end, one.end);
    }
    const Residue* rows[kTogether];
    Residue factors[kTogether];
    for (int k = 0; k < kTogether; ++k) {
      const Waiting& one = waiting_[k];
      const int first = std::min(begin, one.end);
      const int last = std::max(first, std::min(one.end, end));
      if (first > one.begin) subtract_multiple(one.begin, one.row, one.factor, first - one.begin);
      if (last < one.end)
        subtract_multiple(last, one.row + (last - one.begin), one.factor, one.end - last);
      rows[k] = one.row + (begin - one.begin);
      factors[k] = one.factor;
    }
    if (begin >= end) return;
    if constexpr (F::kCounted) {
      if ((pending_ += kTogether) > F::kCapacity) {
        reduce_all();
        pending_ = kTogether;
      }
    }
    field_.subtract_multiples(sums_.data() + begin, rows, factors, end - begin);
  }

  const F& field_;
  std::vector<Sum> sums_;
  std::array<Waiting, kTogether> waiting_;
  int pending_ = 0, waiting_count_ = 0;
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
    for (int begin = 0; begin < columns(); begin += kPanel) {
      const int end = std::min(begin + kPanel, columns());
      for (int column = begin; column < end; ++column) {
        if (accumulator.is_untouched(column)) continue;
        const Residue value = accumulator.at(column);
        if (value == 0) continue;
        if (row_of_[column] >= 0) {
          eliminate(column, value, end);
        } else if (lead < 0) {
          lead = column;
        }
      }
      accumulator.flush();
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
      // The rows used have no entries in other pivots' columns any more: all factors are known.
      for (int column = first; column < end; ++column)
        if (needs(column)) eliminate(column, row[column - pivot], column);
      accumulator.flush();
      row = taken(pivot, 1);
    }
  }

 private:
  // Columns that are brought up to date at once, before those behind them.
  static constexpr int kPanel = 128;

  // Subtracts a multiple of the row that leads in a column: now as far as some column, then later.
  void eliminate(int column, Residue value, int end) {
    const Row& row = rows_[row_of_[column]];
    const int length = static_cast<int>(row.size()), now = std::min(length, end - column);
    accumulator.subtract_multiple(column, row.data(), value, now);
    accumulator.subtract_later(column + now, row.data() + now, value, length - now);
    work_ += length;
  }
  Row taken(int from, Residue factor) {
    int end = columns();
    while (accumulator.at(end - 1) == 0) --end;
    Row row(end - from);
    for (int column = from; column < end; ++column) {
      const Residue value = accumulator.at(column);
      row[column - from] = value == 0 || factor == 1 ? value : field_.multiply(value, factor);
    }
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
