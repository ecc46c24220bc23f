// A limit of work and memory.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <utility>

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

}  // namespace
}  // namespace gsp
