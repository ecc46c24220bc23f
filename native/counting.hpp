// Counting the solutions of six equations on the rigid motions modulo a prime.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace gsp {

// The functions of a motion: 1, R (by rows), T, U, rho and T x R (by rows), as in
// gspcli.geometry.study without e.f; further ones (moments) follow them.
constexpr int kFunctions = 26;

// Blocks of coordinates besides R and the moments.
enum Blocks : unsigned { kTranslation = 1, kBody = 2, kDistance = 4 };

// A step of the elimination: which rows were independent, and the column where each one leads.
// Columns: the products of normal monomials of degree d - 1 and variables, then the normal ones,
// both the greatest first. A source is the number of a generator; -1, an earlier step and a row of
// it; or a commutator: two variables and the exponents of the normal monomial.
struct EliminationStep {
  int degree;
  std::vector<std::vector<int>> sources;
  std::vector<int> pivots;
};

// What arithmetic in other numbers needs to follow a computation.
struct Elimination {
  std::vector<int> variables;  // which functions of the motion they are
  std::vector<int> coordinates;  // those in use, with 1
  // The generators: first quadrics that vanish on the motions, over the products x_i x_j, j <= i, of
  // coordinates, row by row; then equations that are not linear, by their numbers.
  std::vector<std::vector<std::uint64_t>> relations;
  std::vector<int> quadrics;
  std::vector<EliminationStep> steps;
};

struct CountingProblem {
  std::uint64_t prime;
  std::uint64_t seed;  // of random linear forms
  unsigned blocks;
  const std::int64_t* hessians;  // (kFunctions, 8, 8), of N times the functions
  int moments;
  const std::uint64_t* moment_functions;  // (moments, kFunctions)
  // Each equation: a function plus its weighted squares of functions is zero. Further rows are
  // for `groups`.
  int equations;
  const std::uint64_t* functions;  // (equations and more, kFunctions + moments)
  int squares;
  const std::uint64_t* square_functions;  // (squares, kFunctions + moments)
  const std::uint64_t* weights;           // (squares,)
  const std::int64_t* owners;             // (squares,)
  // Whether all quadrics that vanish on the motions are sought, or only those without moments:
  // then the moments' definitions must be among the equations.
  bool moment_relations;
  bool find_distinct;
  // For each group of equations the solutions are counted where none of its sides vanishes; those
  // equations are numbered behind the ones to be solved, and linear in coordinates but for squares.
  std::vector<std::vector<int>> groups;
  std::uint64_t max_work;     // multiplications
  std::uint64_t max_entries;  // residues kept
  std::function<void()> check;  // called now and then; may throw
  Elimination* elimination;     // filled in unless null
};

enum class CountingOutcome : std::int32_t { kFinite = 0, kInfinite = 1, kStopped = 2 };

struct CountingResult {
  CountingOutcome outcome;
  int solutions;             // with multiplicity, if finite
  int distinct;              // -1 if not asked for or not found
  std::vector<int> apart;           // solutions of each group, with multiplicity
  std::vector<int> apart_distinct;  // distinct ones
  int falls;                 // equations of lower degree that came up
  int reach;                 // as of BorderBasis
  bool all_commutators;      // whether none was left to a random combination
  std::uint64_t work;
};

using Count = CountingResult(const CountingProblem&);
Count count_portable, count_avx2, count_avx512;

}  // namespace gsp
