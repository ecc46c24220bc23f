// Follows real branches of solutions in lanes, and has each segment proved (segment_proof.hpp).
#include <algorithm>
#include <cmath>
#include <vector>

#include "segment_proof.hpp"

namespace gsp {
namespace {

// Segments that are followed before they are proved.
constexpr int kBlock = 8;
// Points before the last one that predict the next: on a parabola through two of them, or on the
// quartic through all, whichever predicted the last point better. Values have corners at rows.
constexpr int kBefore = 4;

// The place of a branch: at `row`, and `part` of 2^`level` equal steps to the next row.
struct Cursor {
  Branch* branch = nullptr;
  int row = 0, level = 0;
  std::int64_t part = 0;
  double z[N];
  double end = 0.0;    // a bound of the distance of the proved zero
  double alone = 0.0;  // a distance within which there is no other zero
  // The points before at the same step, the last one first.
  double before[kBefore][N];
  int known = 0;
  bool bent = false;  // whether the quartic predicts better
  int successes = 0;  // blocks in a row that were kept whole
  // The block that is being tried.
  int count = 0;
  double point[kBlock][N], from[kBlock][kConstraints], to[kBlock][kConstraints];
  double measure[kBlock], ends[kBlock], uniqueness[kBlock];
};

INLINE void value_at(const Branch& b, int row, std::int64_t part, int level, double* out) {
  const double* v = b.values + std::ptrdiff_t{row} * kConstraints;
  if (part == 0) {
    std::copy(v, v + kConstraints, out);
    return;
  }
  const double t = std::ldexp(static_cast<double>(part), -level);
  for (int k = 0; k < kConstraints; ++k) out[k] = v[k] + t * (v[k + kConstraints] - v[k]);
}

INLINE void advance(int& row, std::int64_t& part, int level) {
  if (++part == std::int64_t{1} << level) {
    part = 0;
    ++row;
  }
}

constexpr double kProved = 0.98;
// Newton's method: a correction below this leaves an error of its square.
constexpr double kConverged = 1e-8;
constexpr double kDiverged = 0.5;
constexpr int kNewtonSteps = 6;
// A step is doubled when all segments of a block have a measure below this,
constexpr double kEasy = 0.35;
// or after so many blocks without failure: rounding may keep the measure large for any step.
constexpr int kPatience = 4;

class Follower {
 public:
  Follower(const MovingSystem& system, const FollowOptions& options, Branch* branches, int count)
      : system_(system), options_(options), next_(branches), last_(branches + count) {}

  void run() {
    for (Cursor& cursor : cursors_) refill(cursor);
    while (true) {
      bool active = false;
      for (Cursor& cursor : cursors_) active |= cursor.branch != nullptr;
      if (!active) return;
      march();
      if (options_.certify) prove_blocks();
      for (Cursor& cursor : cursors_)
        if (cursor.branch) keep_proved_steps(cursor);
    }
  }

 private:
  // Newton's method for all lanes at their values; false for those where it does not converge.
  void newton(const D* c, D* z, bool* converged) {
    const D first = newton_step(system_, c, z);
    D step = first;
    for (int i = 1; i < kNewtonSteps; ++i) {
      // A finished lane is not changed, so that no branch depends on the others.
      const Mask busy = (step >= kConverged) & (step < kDiverged);
      bool any = false;
      for (int l = 0; l < W; ++l) any |= busy[l] != 0;
      if (!any) break;
      D moved[N];
      std::copy(z, z + N, moved);
      const D next = newton_step(system_, c, moved);
      step = busy ? next : step;
      for (int k = 0; k < N; ++k) z[k] = busy ? moved[k] : z[k];
    }
    for (int l = 0; l < W; ++l) converged[l] = step[l] < kConverged && first[l] < kDiverged;
  }

  void coefficients(const D* values, D* c) const {
    for (int k = 0; k < kConstraints; ++k) c[k] = coefficient(system_.equation[k], values[k]);
  }

  // Gives a free lane the next branch that has a solution near its start.
  void refill(Cursor& cursor) {
    cursor.branch = nullptr;
    while (next_ != last_) {
      Branch& b = *next_++;
      b.stop = Stop::kStart;
      b.reached = -1;
      b.fraction = b.alone = 0.0;
      b.segments = b.tries = 0;
      b.worst = 0.0;
      D z[N], v[kConstraints], c[kConstraints];
      bool converged[W];
      for (int i = 0; i < N; ++i) z[i] = splat(b.start[i]);
      for (int k = 0; k < kConstraints; ++k) v[k] = splat(b.values[k]);
      coefficients(v, c);
      newton(c, z, converged);
      if (!converged[0]) continue;
      cursor = Cursor{};
      cursor.branch = &b;
      for (int i = 0; i < N; ++i) {
        cursor.z[i] = b.point[i] = b.last[i] = b.previous[i] = z[i][0];
      }
      if (b.near > 0.0) cursor.end = b.near + distance(cursor.z, b.start);
      b.reached = 0;
      if (b.rows > 1) return;
      b.stop = Stop::kEnd;
      cursor.branch = nullptr;
    }
  }

  // Follows each branch for a block of steps.
  void march() {
    D now[N], before[kBefore][N];
    Mask curved;
    int known[W], row[W], level[W];
    std::int64_t part[W];
    bool going[W], bent[W];
    for (int l = 0; l < W; ++l) {
      const Cursor& cursor = cursors_[l];
      going[l] = cursor.branch != nullptr;
      // An idle lane repeats the first busy one.
      const Cursor& source = going[l] ? cursor : busy();
      row[l] = source.row;
      part[l] = source.part;
      level[l] = source.level;
      known[l] = source.known;
      bent[l] = source.bent;
      for (int i = 0; i < N; ++i) {
        now[i][l] = source.z[i];
        for (int j = 0; j < kBefore; ++j)
          before[j][i][l] = j < known[l] ? source.before[j][i] : source.z[i];
      }
      cursors_[l].count = 0;
    }
    for (int s = 0; s < kBlock; ++s) {
      D v[kConstraints], c[kConstraints], z[N], w1, w2;
      bool any = false, all_known = false;
      for (int l = 0; l < W; ++l) {
        Cursor& cursor = cursors_[l];
        // From an odd part one step less is taken, so that the step can be doubled afterwards.
        const int steps = kBlock - static_cast<int>(cursor.part % 2);
        going[l] = going[l] && s < steps && row[l] + 1 < cursor.branch->rows;
        if (going[l]) {
          value_at(*cursor.branch, row[l], part[l], level[l], cursor.from[s]);
          advance(row[l], part[l], level[l]);
          value_at(*cursor.branch, row[l], part[l], level[l], cursor.to[s]);
          for (int k = 0; k < kConstraints; ++k) v[k][l] = cursor.to[s][k];
          any = true;
        }
        // Weights of the points before: of a parabola, a line or nothing.
        w1[l] = known[l] == 0 ? 0.0 : known[l] == 1 ? -1.0 : -3.0;
        w2[l] = known[l] >= 2 ? 1.0 : 0.0;
        curved[l] = bent[l] ? -1 : 0;
        all_known |= going[l] && known[l] == kBefore;
      }
      if (!any) return;
      for (int l = 0; l < W; ++l)
        if (!going[l]) {
          const int other = static_cast<int>(std::find(going, going + W, true) - going);
          for (int k = 0; k < kConstraints; ++k) v[k][l] = v[k][other];
          for (int i = 0; i < N; ++i) {
            now[i][l] = now[i][other];
            for (auto& point : before) point[i][l] = point[i][other];
          }
          w1[l] = w1[other];
          w2[l] = w2[other];
          curved[l] = curved[other];
        }
      coefficients(v, c);
      const D w0 = 1.0 - w1 - w2;
      D parabola[N], quartic[N] = {};
      for (int i = 0; i < N; ++i)
        z[i] = parabola[i] = w0 * now[i] + w1 * before[0][i] + w2 * before[1][i];
      if (all_known)
        for (int i = 0; i < N; ++i) {
          quartic[i] = 5.0 * (now[i] - before[2][i]) - 10.0 * (before[0][i] - before[1][i]) +
                       before[3][i];
          z[i] = curved ? quartic[i] : parabola[i];
        }
      bool converged[W];
      newton(c, z, converged);
      if (all_known) {
        D off{};  // by how much more the parabola misses the point
        for (int i = 0; i < N; ++i) {
          const D a = z[i] - parabola[i], b = z[i] - quartic[i];
          off += a * a - b * b;
        }
        for (int l = 0; l < W; ++l) bent[l] = known[l] == kBefore && off[l] > 0.0;
      }
      for (int l = 0; l < W; ++l) {
        if (!going[l]) continue;
        going[l] = converged[l];
        Cursor& cursor = cursors_[l];
        cursor.measure[s] = converged[l] ? 0.0 : kGaveUp;
        ++cursor.count;
        for (int i = 0; i < N; ++i) cursor.point[s][i] = z[i][l];
        known[l] = std::min(known[l] + 1, kBefore);
        cursor.bent = bent[l];
      }
      for (int i = 0; i < N; ++i) {
        for (int j = kBefore - 1; j > 0; --j) before[j][i] = before[j - 1][i];
        before[0][i] = now[i];
        now[i] = z[i];
      }
    }
  }

  const Cursor& busy() const {
    return *std::find_if(cursors_, cursors_ + W, [](const Cursor& c) { return c.branch; });
  }

  // Proves all steps of the blocks, eight of any branches at a time.
  void prove_blocks() {
    struct Step {
      Cursor* cursor;
      int index;
    } steps[W];
    int filled = 0;
    const auto flush = [&] {
      if (!filled) return;
      D from[kConstraints], to[kConstraints], z0[N], z1[N];
      for (int l = 0; l < W; ++l) {
        const Step& step = steps[l < filled ? l : 0];
        const Cursor& cursor = *step.cursor;
        const double* start = step.index ? cursor.point[step.index - 1] : cursor.z;
        for (int i = 0; i < N; ++i) {
          z0[i][l] = start[i];
          z1[i][l] = cursor.point[step.index][i];
        }
        for (int k = 0; k < kConstraints; ++k) {
          from[k][l] = cursor.from[step.index][k];
          to[k][l] = cursor.to[step.index][k];
        }
      }
      const Proof proof = prove(system_, from, to, z0, z1);
      for (int l = 0; l < filled; ++l) {
        Cursor& cursor = *steps[l].cursor;
        const int s = steps[l].index;
        cursor.measure[s] = proof.measure[l];
        cursor.ends[s] = proof.end[l];
        cursor.uniqueness[s] = proof.uniqueness[l];
        ++cursor.branch->tries;
      }
      filled = 0;
    };
    for (Cursor& cursor : cursors_) {
      if (!cursor.branch) continue;
      for (int s = 0; s < cursor.count; ++s) {
        if (cursor.measure[s] == kGaveUp) break;
        steps[filled++] = {&cursor, s};
        if (filled == W) flush();
      }
    }
    flush();
  }

  // Keeps the steps that hold, and chooses the next step size.
  void keep_proved_steps(Cursor& cursor) {
    Branch& b = *cursor.branch;
    double worst = 0.0;
    int s = 0;
    for (; s < cursor.count; ++s) {
      const double measure = cursor.measure[s];
      if (options_.certify) {
        // Points are scaled to another patch: a factor of at most four.
        const bool joined = 4.0 * cursor.end + 0x1p-40 < cursor.uniqueness[s];
        if (!(measure < kProved && joined)) break;
        cursor.end = cursor.ends[s];
        cursor.alone = cursor.uniqueness[s];
        worst = std::max(worst, measure);
      } else {
        if (measure == kGaveUp || distance(cursor.z, cursor.point[s]) > kLongest) break;
        ++b.tries;
      }
      ++b.segments;
      cursor.known = std::min(cursor.known + 1, kBefore);
      for (int j = kBefore - 1; j > 0; --j)
        std::copy(cursor.before[j - 1], cursor.before[j - 1] + N, cursor.before[j]);
      std::copy(cursor.z, cursor.z + N, cursor.before[0]);
      std::copy(cursor.point[s], cursor.point[s] + N, cursor.z);
      advance(cursor.row, cursor.part, cursor.level);
      if (cursor.part == 0)
        std::copy(cursor.z, cursor.z + N, b.point + std::ptrdiff_t{cursor.row} * N);
    }
    b.worst = std::max(b.worst, worst);
    if (cursor.row + 1 >= b.rows) return finish(cursor, Stop::kEnd);
    if (s == cursor.count) {
      ++cursor.successes;
      if (cursor.level > 0 && cursor.part % 2 == 0 &&
          (worst < kEasy || cursor.successes >= kPatience)) {
        cursor.successes = 0;
        --cursor.level;
        cursor.part /= 2;
        // Every second one of the points has the distance of the next step.
        for (int j = 0; 2 * j + 1 < cursor.known; ++j)
          std::copy(cursor.before[2 * j + 1], cursor.before[2 * j + 1] + N, cursor.before[j]);
        cursor.known /= 2;
        cursor.bent = false;
      }
      return;
    }
    cursor.successes = 0;
    cursor.bent = false;
    // The measure is about proportional to the step.
    const double measure = cursor.measure[s];
    int halvings = 1;
    if (measure == kGaveUp || !(measure < 8.0))
      halvings = 3;
    else if (measure > 1.6)
      halvings = 2;
    if (cursor.level >= options_.most_halvings) return finish(cursor, Stop::kStep);
    halvings = std::min(halvings, options_.most_halvings - cursor.level);
    cursor.level += halvings;
    cursor.part <<= halvings;
    const double scale = std::ldexp(1.0, -halvings);
    if (cursor.known)
      for (int i = 0; i < N; ++i)
        cursor.before[0][i] = cursor.z[i] + scale * (cursor.before[0][i] - cursor.z[i]);
    cursor.known = std::min(cursor.known, 1);
  }

  static double distance(const double* a, const double* b) {
    double s = 0.0;
    for (int i = 0; i < N; ++i) s += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(s);
  }

  void finish(Cursor& cursor, Stop stop) {
    Branch& b = *cursor.branch;
    b.stop = stop;
    b.reached = cursor.row;
    b.fraction = std::ldexp(static_cast<double>(cursor.part), -cursor.level);
    b.near = cursor.end;
    b.alone = cursor.alone;
    std::copy(cursor.z, cursor.z + N, b.last);
    std::copy(cursor.known ? cursor.before[0] : cursor.z,
              (cursor.known ? cursor.before[0] : cursor.z) + N, b.previous);
    refill(cursor);
  }

  static constexpr double kGaveUp = 1e300;
  const MovingSystem& system_;
  const FollowOptions options_;
  Branch *next_, *last_;
  Cursor cursors_[W];
};

}  // namespace

void GSP_FOLLOW(const MovingSystem& system, const FollowOptions& options, Branch* branches,
                int count) {
  Follower(system, options, branches, count).run();
}

}  // namespace gsp
