// The path tracker: the interface of the three builds of tracker.cpp, one for each instruction set.
//
// Nothing here but plain data: a translation unit compiled for AVX-512 must not emit functions
// that the linker could merge with those of the portable build.
#pragma once

#include <cstdint>

namespace gsp {

constexpr int kVariables = 8;  // e0..e3, f0..f3
constexpr int kEquations = 6;  // besides e.f = 0
constexpr int kQuadrics = 2 * kEquations;

// A quadric is a combination of these functions, in this order: monomials e_i e_j (i <= j, row by
// row); T and U (without their factor 2); e_i f_j + e_j f_i (i < j, row by row) and e_i f_i (i >
// 0); f.f. On e.f = 0 they are a basis. Groups that a homotopy does not use are skipped.
constexpr int kFeatures = 26;
enum Group : unsigned { kT = 1, kU = 2, kS = 4, kRho = 8 };
constexpr int kOffsetT = 10, kOffsetU = 13, kOffsetS = 16, kOffsetRho = 25;

struct Complex {
  double re, im;
};

constexpr int kMore = 1;  // doubles that are added to one for 32 digits

// A quadric whose coefficients run along the straight line start + t change. The change is known
// to as many digits as the tracker computes with: `more` is what doubles cannot tell of it.
struct Quadric {
  unsigned groups;
  Complex start[kFeatures];
  Complex change[kFeatures];
  Complex more[kMore][kFeatures];
};

// Six equations: quadric i alone, or quadric i times quadric 6 + i = tau N^2.
struct Homotopy {
  bool product[kEquations];
  Quadric quadric[kQuadrics];
  Complex tau_start[kEquations];
  Complex tau_change[kEquations];
  Complex tau_more[kMore][kEquations];
};

// The same where all quadrics are real but for their values and how two factors make a product:
// A_i + i value N = 0, or (A_i + iB_i) (A_i - iB_i) = tau N^2. Quadric 6 + i is B_i.
struct RealLine {
  unsigned groups;
  double start[kFeatures];
  double change[kFeatures];
};
struct RealHomotopy {
  bool product[kEquations];
  RealLine quadric[kQuadrics];
  double value_start[kEquations];
  double value_change[kEquations];
  Complex tau_start[kEquations];
  Complex tau_change[kEquations];
};

struct Options {
  double predictor_tolerance;  // aimed length of the first Newton correction (points have norm 1)
  double contraction;          // largest ratio of second to first Newton correction
  double arrival;              // largest second Newton correction at t = 1
  double radius_fraction;      // largest step as a part of the estimated radius of convergence
  double min_step;             // a step in t below this fails
  double waypoint;             // 1 - t at which paths that cannot reach t = 1 are handed back
  double nearest;              // 1 - t below which a path that cannot step to t = 1 counts as such
  int max_steps;
  int late_steps;  // beyond the waypoint
};

enum Status : std::uint8_t { kRegular = 0, kSingular = 1, kFailed = 2 };

// Arrays over the paths of one homotopy.
struct Results {
  Complex* point;          // (paths, 8), norm 1
  Complex* low;            // (paths, kMore, 8), what more digits add to it; null in doubles
  double* left;            // 1 - t where the point belongs to
  std::uint8_t* status;
  std::int32_t* steps;     // accepted and rejected
  double* condition;       // of the inverse Jacobian matrix, Frobenius, equations of magnitude 1
  double* curvature;       // likewise, equations undivided: bounds J^-1 D^2 F
  double* residual;        // largest equation at the point, divided by its magnitude
  double* correction;      // length of the last Newton correction
};

// Tracks the paths of one homotopy that start at `points` (paths, 8) from t = 0 to t = 1; what more
// digits add to the points is `low` (paths, kMore, 8), or null. They start at t = 1 - left (paths) if
// that is not null; where it is zero nothing but Newton's method is done.
using Track = void(const Homotopy&, const Options&, int paths, const Complex* points,
                   const Complex* low, const double* left, const Results&);
Track track_portable, track_avx2, track_avx512;
// The same in 32 digits.
Track track_portable_double_double, track_avx2_double_double, track_avx512_double_double;

// The same in double precision with series of fewer terms, for paths that are short.
Track track_portable_short, track_avx2_short, track_avx512_short;
using TrackReal = void(const RealHomotopy&, const Options&, int paths, const Complex* points,
                       const Complex* low, const double* left, const Results&);
TrackReal track_portable_real, track_avx2_real, track_avx512_real;

}  // namespace gsp
