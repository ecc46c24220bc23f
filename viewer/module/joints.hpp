// Joints that motors move: where they are, and the equations then (gspcli.pictures.live_numbers).
#pragma once

#include "../../native/open_equations.hpp"
#include "values.hpp"

namespace gsp::live {

class Joints {
 public:
  // None unless the first number says so.
  explicit Joints(Numbers& numbers);

  bool are_moved() const { return are_moved_; }
  bool moves(int constraint) const { return motor_[constraint].sort != kValue; }
  // Two numbers of the drive of a constraint that its equation is linear in.
  const double* terms(int constraint) const { return motor_[constraint].terms; }
  // Moves the joints to where corrected numbers of values and motors have them.
  void place(const Values& given, const double* numbers);
  // Puts the lengths of rods in the places of the numbers of their motors.
  void hold(double* numbers) const;
  // Each move writes these again: the equations, weights (4, 6), and the points of both bodies (6, 3) in
  // lengths of the file.
  const OpenEquations& equations() const { return open_; }
  const double* points(bool of_platform) const { return of_platform ? y_ : x_; }

 private:
  enum Sort { kValue, kCrank, kSlide };
  struct Motor {
    int sort;
    bool on_platform;
    double rod, terms[2];
    gsp::Doubled middle[3], across[3], beside[3];  // in lengths of proofs
  };

  bool are_moved_;
  Motor motor_[kEquations]{};
  Primitives primitives_[kEquations]{};
  const double* forms_ = nullptr;  // (27, 8, 8)
  double tiny_ = 0.0, scale_ = 1.0;
  double x_[3 * kEquations]{}, y_[3 * kEquations]{};
  std::vector<double> hessian_, low_, moduli_, weights_;
  std::vector<std::int32_t> table_, turned_;
  OpenEquations open_{};
};

}  // namespace gsp::live
