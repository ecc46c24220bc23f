// Counting the solutions of six equations on the rigid motions modulo a prime.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace gsp {

// The functions of a motion: 1, R (by rows), T, U, rho and T x R (by rows), as in
// gspcli.certification.study without e.f; further ones (moments) follow them.
constexpr int kFunctions = 26;

// Blocks of coordinates besides R and the moments.
enum Blocks : unsigned { kTranslation = 1, kBody = 2, kDistance = 4 };

struct CountingProblem {
  std::uint64_t prime;
  std::uint64_t seed;  // of random linear forms
  unsigned blocks;
  const std::int64_t* hessians;  // (kFunctions, 8, 8), of N times the functions
  int moments;
  const std::uint64_t* moment_functions;  // (moments, kFunctions)
  // Each equation: a function plus its weighted squares of functions is zero.
  int equations;
  const std::uint64_t* functions;  // (equations, kFunctions + moments)
  int squares;
  const std::uint64_t* square_functions;  // (squares, kFunctions + moments)
  const std::uint64_t* weights;           // (squares,)
  const std::int64_t* owners;             // (squares,)
  bool find_distinct;
  std::uint64_t max_work;     // multiplications
  std::uint64_t max_entries;  // residues kept
  std::function<void()> check;  // called now and then; may throw
};

enum class CountingOutcome : std::int32_t { kFinite = 0, kInfinite = 1, kStopped = 2 };

struct CountingResult {
  CountingOutcome outcome;
  int solutions;             // with multiplicity, if finite
  int distinct;              // -1 if not asked for or not found
  int falls;                 // equations of lower degree that came up
  bool all_commutators;      // whether none was left to a random combination
  std::uint64_t work;
  std::vector<int> hilbert;  // normal monomials of each degree
};

using Count = CountingResult(const CountingProblem&);
Count count_portable, count_avx2, count_avx512;

}  // namespace gsp
