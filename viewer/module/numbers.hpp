// The numbers of a platform as gspcli.pictures.live_numbers writes them: doubles, one after the other.
#pragma once

#include <vector>

#include "../../native/tracker.hpp"

namespace gsp::live {

class Numbers {
 public:
  explicit Numbers(const double* at) : at_(at) {}

  const double* doubles(int count) {
    const double* const found = at_;
    at_ += count;
    return found;
  }
  const Complex* complexes(int count) { return reinterpret_cast<const Complex*>(doubles(2 * count)); }
  double number() { return *doubles(1); }
  int integer() { return static_cast<int>(number()); }
  template <class Integer>
  std::vector<Integer> integers(int count) {
    const double* const from = doubles(count);
    return {from, from + count};
  }

 private:
  const double* at_;
};

}  // namespace gsp::live
