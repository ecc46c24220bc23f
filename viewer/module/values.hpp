// Six values as equations have them: on paths, and in proofs (gspcli.certification.poses.many_values).
#pragma once

#include <vector>

#include "numbers.hpp"

namespace gsp::live {

// The numbers that native/ends.hpp needs of each value, in its order.
constexpr int kOfValue = 6;

// Sums of two doubles.
struct Doubled {
  double high, low;
};

class Values {
 public:
  explicit Values(Numbers& numbers);

  int choices() const { return choices_; }
  // Values of readings: `corrected` numbers are what the platform has.
  void correct(const double* readings, double* corrected) const;
  // As equations of paths have them, for one choice of sides: lengths in units of the paths, cosines.
  void inner(const double* values, int choice, double* out) const;
  // What those are linear in: squares of distances without sides.
  void parameters(const double* values, int choice, double* out) const;
  // For the proofs, (6, 6).
  void proved(const double* values, int choice, double scale, double* out) const;
  // The sine of an angle from -90 to 90 degrees in the unit of the file, or the cosine of one from 0 to 180.
  Doubled sine(double angle, bool complement) const;
  bool degrees() const { return degrees_; }
  // Largest distance.
  double largest(const double* values) const;

 private:
  Doubled cosine(double angle, int constraint) const;

  struct Constraint {
    bool is_distance, is_square, is_height, is_complement;
    double sign, factor, offset;
  };
  Constraint constraint_[kEquations];
  int choices_;
  const double* choice_;  // (choices, 6)
  double length_;
  // Sines: gspcli.certification.numbers.doubled.
  bool degrees_;
  Doubled quarter_, unit_;
  int terms_, small_;
  const double* term_;  // (terms, 2)
  double error_, gap_;
};

}  // namespace gsp::live
