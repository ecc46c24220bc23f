/* Calls of an exported controller on arrays: -DPREFIX=name -DSOURCE='"name.c"'. Includes the source, so
 * that what is static in it can be measured, too. */
#include SOURCE
#include <time.h>

#define CAT2(a, b) a##b
#define CAT(a, b) CAT2(a, b)
#define PUBLIC(name) CAT(PREFIX, name)
#define CYCLES 20

typedef PUBLIC(_pose) pose_t;
typedef PUBLIC(_state) state_t;
typedef PUBLIC(_report) report_t;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
static pose_t pose_of(const double *p) {
  pose_t s = {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
  return s;
}

void d_inverse(long n, const double *poses, double *values, int *status) {
  for (long i = 0; i < n; ++i) {
    pose_t p = pose_of(poses + 7 * i);
    status[i] = PUBLIC(_inverse)(&p, values + 6 * i);
  }
}

void d_jacobian(long n, const double *poses, const double *values, double *J, int *status) {
  for (long i = 0; i < n; ++i) {
    pose_t p = pose_of(poses + 7 * i);
    status[i] = PUBLIC(_jacobian)(&p, values + 6 * i, (double(*)[6])(J + 36 * i));
  }
}

/* Walks of `rows` values each from the pose in their first row; each ends at its first refusal, what
 * comes after has the status -1. */
void d_follow(long n, long rows, const double *values, double *poses, int *status, double *reports,
              double *seconds) {
  for (long i = 0; i < n; ++i) {
    state_t s;
    s.pose = pose_of(poses + 7 * rows * i);
    s.error = 0.0;
    for (int k = 0; k < 6; ++k) s.values[k] = values[6 * rows * i + k];
    status[rows * i] = 0;
    for (long r = 1; r < rows; ++r) status[rows * i + r] = -1;
    for (long r = 1; r < rows; ++r) {
      const long at = rows * i + r;
      report_t q;
      const double t = now();
      const int e = PUBLIC(_forward)(values + 6 * at, &s, &q);
      seconds[at] = now() - t;
      status[at] = e;
      double *o = reports + 6 * at;
      o[0] = q.fraction, o[1] = q.sigma, o[2] = q.alone, o[3] = q.steps, o[4] = q.tries, o[5] = s.error;
      if (e) break;
      for (int k = 0; k < 3; ++k) poses[7 * at + k] = s.pose.position[k];
      for (int k = 0; k < 4; ++k) poses[7 * at + 3 + k] = s.pose.rotation[k];
    }
  }
}

/* Newton's method as controllers run it, until a correction is below `tolerance`; 1: it was not. */
static int newton(const geometry *g, frame *f, const setting *at, int most, double tolerance) {
  for (int i = 0; i < most; ++i) {
    double F[6], J[6][6], Y[6][6], d[6];
    equations(g, f, at, F, J);
    if (!invert(J, Y)) return 1;
    const double size = correction(Y, F, d);
    if (!(size < 1e6)) return 1;
    move(f, d);
    if (size < tolerance) return 0;
  }
  return 1;
}

static int newton_pose(const geometry *g, const double *values, pose_t *p, int most, double tolerance) {
  frame f;
  setting at;
  double c[6];
  if (!load(g, p, &f)) return 1;
  for (int k = 0; k < 6; ++k) c[k] = (values[k] + g->offset[k]) * g->unit[k];
  set(g, c, &at);
  const int e = newton(g, &f, &at, most, tolerance);
  unload(g, &f, p);
  return e;
}

void d_newton(long n, long rows, const double *values, double *poses, int *status, long most,
              double tolerance) {
  for (long i = 0; i < n; ++i) {
    pose_t p = pose_of(poses + 7 * rows * i);
    status[rows * i] = 0;
    for (long r = 1; r < rows; ++r) status[rows * i + r] = -1;
    for (long r = 1; r < rows; ++r) {
      const long at = rows * i + r;
      status[at] = newton_pose(&data, values + 6 * at, &p, (int)most, tolerance);
      for (int k = 0; k < 3; ++k) poses[7 * at + k] = p.position[k];
      for (int k = 0; k < 4; ++k) poses[7 * at + 3 + k] = p.rotation[k];
      if (status[at]) break;
    }
  }
}

/* Seconds a call of Newton's method and of forward, in turns, from poses and values to values. */
void d_time(long n, const double *poses, const double *from, const double *to, double *seconds) {
  volatile double sink = 0.0;
  seconds[0] = seconds[1] = 0.0;
  for (int turn = 0; turn < CYCLES; ++turn) {
    double t = now();
    for (long i = 0; i < n; ++i) {
      pose_t p = pose_of(poses + 7 * i);
      newton_pose(&data, to + 6 * i, &p, 20, 1e-10);
      sink += p.position[0];
    }
    seconds[0] += (now() - t) / ((double)n * CYCLES);
    t = now();
    for (long i = 0; i < n; ++i) {
      state_t s;
      s.pose = pose_of(poses + 7 * i);
      s.error = 0.0;
      for (int k = 0; k < 6; ++k) s.values[k] = from[6 * i + k];
      sink += PUBLIC(_forward)(to + 6 * i, &s, 0);
    }
    seconds[1] += (now() - t) / ((double)n * CYCLES);
  }
}

/* The numbers computed at poses, with bounds of their rounding. The frame (T, q), (n, 7), and its bound,
 * (n,); F, (n, 6), and F', (n, 6, 6); error and slant, (n, 6) each; the pose of the frame, (n, 7). */
void d_rounding(long n, const double *poses, const double *values, double *frames, double *off, double *F,
                double *J, double *error, double *slant, double *back) {
  for (long i = 0; i < n; ++i) {
    pose_t p = pose_of(poses + 7 * i);
    frame f;
    bounds b;
    double c[6];
    setting at;
    part whole = {&at, &at, 0.0, 0.0};
    load(&data, &p, &f);
    for (int k = 0; k < 3; ++k) frames[7 * i + k] = f.T[k];
    for (int k = 0; k < 4; ++k) frames[7 * i + 3 + k] = f.q[k];
    off[i] = rounded(&data, &f);
    unload(&data, &f, &p);
    for (int k = 0; k < 3; ++k) back[7 * i + k] = p.position[k];
    for (int k = 0; k < 4; ++k) back[7 * i + 3 + k] = p.rotation[k];
    for (int k = 0; k < 6; ++k) c[k] = (values[6 * i + k] + data.offset[k]) * data.unit[k];
    set(&data, c, &at);
    equations(&data, &f, &at, F + 6 * i, (double(*)[6])(J + 36 * i));
    bound(&data, &f, &whole, &b);
    for (int k = 0; k < 6; ++k) error[6 * i + k] = b.error[k], slant[6 * i + k] = b.slant[k];
  }
}

/* A frame moved by exp(w), t. */
static frame moved_by(const frame *f, const double *x) {
  const double angle = length(x), half = angle > 0.0 ? sin(0.5 * angle) / angle : 0.5;
  double turned[3], w[3] = {half * x[0], half * x[1], half * x[2]};
  frame to = *f;
  cross(w, f->q + 1, turned);
  to.q[0] = cos(0.5 * angle) * f->q[0] - dot(w, f->q + 1);
  for (int i = 0; i < 3; ++i) {
    to.q[i + 1] = cos(0.5 * angle) * f->q[i + 1] + f->q[0] * w[i] + turned[i];
    to.T[i] += x[i + 3];
  }
  rotate(&to);
  return to;
}

/* Derivatives of the equations in the chart about a frame, where the share s of a line is done: by
 * differences, of x = s d + u. */
static void in_chart(const frame *f, const double *d, const double *from, const double *to, double s,
                     double (*J)[6]) {
  const double small = 1e-5;
  double c[6], x[6], F[2][6];
  setting at;
  for (int k = 0; k < 6; ++k) c[k] = from[k] + s * (to[k] - from[k]);
  set(&data, c, &at);
  for (int j = 0; j < 6; ++j) {
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < 6; ++i) x[i] = s * d[i] + (i == j ? (side ? small : -small) : 0.0);
      const frame there = moved_by(f, x);
      equations(&data, &there, &at, F[side], 0);
    }
    for (int k = 0; k < 6; ++k) J[k][j] = (F[1][k] - F[0][k]) / (2.0 * small);
  }
}

/* Second derivatives of F' along lines from poses, by twists d (n, 6) and numbers from and to (n, 6): by
 * differences in their middles, and the bounds `rest`; both (n, 6). */
void d_bends(long n, const double *poses, const double *d, const double *from, const double *to,
             double *found, double *rest) {
  const double h = 0.1;
  for (long i = 0; i < n; ++i) {
    const pose_t p = pose_of(poses + 7 * i);
    frame f;
    setting ends[2];
    bounds b;
    double J[3][6][6];
    load(&data, &p, &f);
    set(&data, from + 6 * i, ends), set(&data, to + 6 * i, ends + 1);
    const part whole = {ends, ends + 1, length6(d + 6 * i), length6(d + 6 * i)};
    bound(&data, &f, &whole, &b);
    for (int m = 0; m < 3; ++m) in_chart(&f, d + 6 * i, from + 6 * i, to + 6 * i, 0.5 + (m - 1) * h, J[m]);
    for (int k = 0; k < 6; ++k) {
      double bent[6];
      for (int j = 0; j < 6; ++j) bent[j] = (J[0][k][j] - 2.0 * J[1][k][j] + J[2][k][j]) / (h * h);
      found[6 * i + k] = length6(bent);
      rest[6 * i + k] = b.rest[k];
    }
  }
}

/* Nearest poses to given ones (n, 7), each from one pose. Moves `found` (n, 7) and `values` (n, 6); `lines`
 * is 1 if one straight line leads there, 2 if several do, and 0 if the state did not move. */
void d_nearest(long n, const double *home, const double *given, double *found, double *values, int *status,
               int *lines, double *seconds) {
  const pose_t begin = pose_of(home);
  state_t start;
  PUBLIC(_start)(&begin, &start, 0);
  for (long i = 0; i < n; ++i) {
    const pose_t goal = pose_of(given + 7 * i);
    state_t s = start, straight = start;
    frame f;
    const double t = now();
    status[i] = PUBLIC(_nearest)(&goal, &s, 0);
    seconds[i] = now() - t;
    const int one = load(&data, &goal, &f) && towards(&data, &within, &f, &straight, 0) == 0;
    int moved = 0;
    for (int k = 0; k < 6; ++k) moved |= s.values[k] != start.values[k], values[6 * i + k] = s.values[k];
    lines[i] = one ? 1 : moved ? 2 : 0;
    for (int k = 0; k < 3; ++k) found[7 * i + k] = s.pose.position[k];
    for (int k = 0; k < 4; ++k) found[7 * i + 3 + k] = s.pose.rotation[k];
  }
}
