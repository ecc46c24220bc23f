/* The nearest pose that keeps ranges and cones.
 *
 * The distance of two poses is sqrt(|p - p'|^2 + (weight theta)^2): p is the place of the pivot, theta
 * the angle between the rotations. It is minimized by sequential quadratic programming from the pose
 * of the state: half its square with the curvature of the limits, weighted by their multipliers, under
 * linearized limits. That is a search: it does not exclude nearer poses. What is found is proved as a
 * step is: the straight line of values leads there; it keeps all ranges, since its ends do.
 *
 * A limit is a slack, a length that must not be negative. That of a crank or slide is how much its rod
 * would be too short, or too long, at the end of the range. It is smooth where the rod does not reach,
 * too: from there on it is how much the rod is too short or too long at its dead point. */

#define MARGIN 1e-7    /* by which the limits are narrower, of the weight; or radians */
#define SEARCH_STEPS 30 /* of one search */
#define SEARCH_SHORT 1e-9 /* the search ends with a step that is shorter, of the weight */
#define SEARCH_LONGEST 0.5
#define SEARCH_HALVINGS 12
#define SEARCH_GOALS 8  /* on the way to the given pose, if the step to the nearest one is refused */
#define DIFFERENCE 1e-6 /* of which second derivatives are made */
#define CONVEX 0.05     /* the least pivot of the quadratic problem with curved limits */
#define ACTIVE_STEPS 64
#define SLACKS 24       /* two of each constraint, then the cones */
#define NO_RANGE 1e29
#define DEAD 1e-6       /* nearer to a dead point the derivative of a drive's number is not used */

/* The limits of a platform, in the units of its numbers. */
typedef struct {
  double low[6], high[6];           /* of the numbers in the equations; -NEVER and NEVER without a range */
  double axis[12][3], half[12];     /* of the cones, in the frames of their bodies */
  double pivot[3], weight;          /* a point of the platform, from its middle; a radian is such a length */
  unsigned char cones, still;       /* how many; whether the platform does not turn */
  unsigned char leg[12], on_base[12]; /* of the cones */
} limits;

#if HAS_DATA
@LIMITS@
#endif
/* A search for the nearest pose to a goal. */
typedef struct {
  const geometry *g;
  const limits *l;
  frame goal;
  double place[3];           /* of the pivot at the goal */
  double low[6], high[6];    /* narrower, on the sides where the platform is */
  double margin[6];
  double near[6], working[6];   /* of cranks and slides: an angle to which theirs is the nearest; 1 or -1 */
} search;

/* A quadratic problem about a frame, in y = (weight omega, velocity). */
typedef struct {
  double value, gradient[6], hessian[6][6]; /* half the square of the distance */
  double room[SLACKS], rows[SLACKS][6];     /* the limits and their derivatives by twists */
} local_problem;

/* Takes the sides and working modes of a frame with its numbers. */
static void search_from(search *s, const geometry *g, const limits *l, const frame *f, const double *c) {
  int k;
  s->g = g, s->l = l;
  for (k = 0; k < 6; ++k) {
    double low = l->low[k], high = l->high[k], margin = MARGIN * l->weight;
#if HAS_DPH || HAS_DHP
    if (g->either[k]) {
      double least = low;
      if (low == 0.0) low = -high;
      else if (c[k] < 0.0) low = -high, high = -least;
    }
#endif
    if (g->kind[k] >= ALL && g->kind[k] <= AHH) margin = MARGIN;
    if (margin > 0.25 * (high - low)) margin = 0.25 * (high - low);
    s->margin[k] = margin;
    if (g->kind[k] >= BASE_CRANK) margin = 0.0; /* of the slacks */
    s->low[k] = low + margin, s->high[k] = high - margin;
    s->near[k] = high < NO_RANGE && low > -NO_RANGE ? 0.5 * (low + high) : c[k];
    s->working[k] = slope(g, f, k, c) < 0.0 ? -1.0 : 1.0;
  }
}

static void search_for(search *s, const frame *goal) {
  int i;
  s->goal = *goal;
  turn(goal, s->l->pivot, s->place);
  for (i = 0; i < 3; ++i) s->place[i] += goal->T[i];
}

#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* A rod with its drive at a frame: r is from the centre of the crank, or from the stated point of the
 * slide, to the other end, in the axes of the drive's body. The drive's two numbers are as far from
 * `middle` on both sides. */
typedef struct {
  double r[3], middle, number, change[3]; /* of the number, by r; of the middle at a dead point */
  double room[2], by[2][3]; /* slacks of both ends of the range, and their derivatives by r */
} drive_limits;

#endif
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
/* The rod reaches |r|^2 + arm^2 - rod^2 = 2 h cos(angle - middle). With the angle within a range that
 * is cos(e) of the ends' angles e from the middle, as far as these matter. */
static void limit_crank(const search *s, const frame *f, int k, drive_limits *d) {
  const double half_turn = 3.141592653589793;
  const geometry *g = s->g;
  double working = s->working[k], a, b, h, right, cosine, sine, e, value, bend, turns, dh, dm, margin = s->margin[k];
  int i, upper = working < 0.0; /* the number is before the middle: the upper end is nearer to it */
  other_end(g, f, k, g->kind[k] == BASE_CRANK, d->r);
  a = dot(d->r, g->A[k]), b = dot(d->r, g->B[k]), h = sqrt(a * a + b * b) + 1.0 / NEVER;
  right = 0.5 * (dot(d->r, d->r) + dot(g->A[k], g->A[k]) - g->rod[k] * g->rod[k]);
  cosine = right / h;
  cosine = cosine > 1.0 ? 1.0 : cosine < -1.0 ? -1.0 : cosine;
  d->middle = atan2(b, a);
  d->number = d->middle + working * acos(cosine);
  turns = 2.0 * half_turn * floor((s->near[k] - d->number) / (2.0 * half_turn) + 0.5);
  d->middle += turns, d->number += turns;
  sine = sqrt(1.0 - cosine * cosine);
  e = working * ((upper ? s->high[k] : s->low[k]) - d->middle);
  if (e <= 0.0)
    value = 1.0, bend = 0.0;
  else if (e <= half_turn)
    value = cos(e), bend = -sin(e);
  else
    value = -2.0 - cos(e), bend = sin(e);
  d->room[upper] = (h * value - right) / g->rod[k] - margin;
  for (i = 0; i < 3; ++i) {
    dh = (a * g->A[k][i] + b * g->B[k][i]) / h, dm = (a * g->B[k][i] - b * g->A[k][i]) / (h * h);
    d->by[upper][i] = (value * dh - h * bend * working * dm - d->r[i]) / g->rod[k];
    d->change[i] = dm - (sine > DEAD ? working * (d->r[i] - cosine * dh) / (h * sine) : 0.0);
  }
  e = working * ((upper ? s->low[k] : s->high[k]) - d->middle);
  if (e >= half_turn)
    value = -1.0, bend = 0.0;
  else if (e >= 0.0)
    value = cos(e), bend = -sin(e);
  else
    value = 2.0 - cos(e), bend = sin(e);
  d->room[!upper] = (right - h * value) / g->rod[k] - margin;
  for (i = 0; i < 3; ++i) {
    dh = (a * g->A[k][i] + b * g->B[k][i]) / h, dm = (a * g->B[k][i] - b * g->A[k][i]) / (h * h);
    d->by[!upper][i] = (d->r[i] - value * dh + h * bend * working * dm) / g->rod[k];
  }
}

#endif
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* The rod reaches rod^2 - |r across the rail|^2 = (number - middle)^2. */
static void limit_slide(const search *s, const frame *f, int k, drive_limits *d) {
  const geometry *g = s->g;
  double working = s->working[k], across[3], room, half, e, twice = 2.0 * g->rod[k], margin = s->margin[k];
  int i, upper = working < 0.0;
  other_end(g, f, k, g->kind[k] == BASE_SLIDE, d->r);
  d->middle = dot(d->r, g->B[k]);
  for (i = 0; i < 3; ++i) across[i] = d->r[i] - d->middle * g->B[k][i];
  room = g->rod[k] * g->rod[k] - dot(across, across);
  half = sqrt(larger(room, 0.0));
  d->number = d->middle + working * half;
  for (i = 0; i < 3; ++i) d->change[i] = g->B[k][i] - (half > DEAD * g->rod[k] ? working * across[i] / half : 0.0);
  e = larger(working * ((upper ? s->high[k] : s->low[k]) - d->middle), 0.0);
  d->room[upper] = (room - e * e) / twice - margin;
  for (i = 0; i < 3; ++i) d->by[upper][i] = 2.0 * (e * working * g->B[k][i] - across[i]) / twice;
  e = working * ((upper ? s->low[k] : s->high[k]) - d->middle);
  d->room[!upper] = e > NO_RANGE ? NEVER : (e * fabs(e) - room) / twice - margin;
  for (i = 0; i < 3; ++i)
    d->by[!upper][i] = e > NO_RANGE ? 0.0 : 2.0 * (across[i] - fabs(e) * working * g->B[k][i]) / twice;
}

#endif
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* The derivative by a twist, from that by r of a drive. */
static void by_twist(const geometry *g, const frame *f, int k, const double *by, double *row) {
  double arm[3], force[3], apart[3];
  int i, on_base = g->kind[k] == BASE_CRANK;
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  on_base |= g->kind[k] == BASE_SLIDE;
#endif
  if (on_base) {
    turn(f, g->Y[k], arm);
    cross(arm, by, row);
    for (i = 0; i < 3; ++i) row[i + 3] = by[i];
    return;
  }
  turn(f, by, force);
  for (i = 0; i < 3; ++i) apart[i] = g->X[k][i] - f->T[i], row[i + 3] = -force[i];
  cross(force, apart, row);
}

#endif
#if HAS_CONES
/* The slack of a cone, and its derivative: the leg moves with the platform, and with its drive. */
static void limit_cone(const search *s, const frame *f, int i, const double *c, double (*changes)[6],
                       double *room, double *row) {
  const geometry *g = s->g;
  const limits *l = s->l;
  int j, k = l->leg[i], on_base = l->on_base[i];
  double sign = on_base ? 1.0 : -1.0, y[3], x[3], axis[3], leg[3], side[3], towards[3], moment[3], size, along, sine;
  placed p;
  points(g, k, c[k], y, x);
  place(g, f, k, y, x, &p);
  for (j = 0; j < 3; ++j) axis[j] = l->axis[i][j];
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
  {
    int turns = g->kind[k] == (on_base ? BASE_CRANK : PLATFORM_CRANK);
    double pin[3] = {0.0, 0.0, 0.0};
    if (turns) { /* with its arm */
      double square = dot(g->A[k], g->A[k]), share, round[3];
      cross(g->A[k], g->B[k], pin);
      for (j = 0; j < 3; ++j) pin[j] /= square;
      share = dot(pin, axis);
      cross(pin, axis, round);
      for (j = 0; j < 3; ++j)
        axis[j] = share * pin[j] + cos(c[k]) * (axis[j] - share * pin[j]) + sin(c[k]) * round[j];
    }
#endif
    if (!on_base) {
      double turned[3];
      turn(f, axis, turned);
      for (j = 0; j < 3; ++j) axis[j] = turned[j];
    }
    size = length(p.r);
    for (j = 0; j < 3; ++j) leg[j] = sign * p.r[j] / size;
    cross(axis, leg, side);
    along = dot(axis, leg), sine = length(side);
    *room = l->weight * (l->half[i] - MARGIN - atan2(sine, along));
    if (!(size > 0.0)) *room = NEVER; /* it has no direction */
    for (j = 0; j < 6; ++j) row[j] = 0.0;
    if (!(size > 0.0 && sine > 1e-12)) return;
    for (j = 0; j < 3; ++j) {
      towards[j] = sign * (axis[j] - along * leg[j]) / (size * sine);
      side[j] /= sine;
    }
    cross(p.arm, towards, moment);
    for (j = 0; j < 3; ++j) {
      row[j] = l->weight * (moment[j] + (on_base ? 0.0 : side[j]));
      row[j + 3] = l->weight * towards[j];
    }
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    if (g->kind[k] >= BASE_CRANK) {
      double velocity[3] = {0.0, 0.0, 0.0}, own;
      int on_platform = g->kind[k] == PLATFORM_CRANK;
#if HAS_PLATFORM_SLIDE
      on_platform |= g->kind[k] == PLATFORM_SLIDE;
#endif
      if (g->kind[k] <= PLATFORM_CRANK) {
        add(velocity, -sin(c[k]), g->A[k]);
        add(velocity, cos(c[k]), g->B[k]);
      } else
        add(velocity, 1.0, g->B[k]);
      if (on_platform) {
        double turned[3];
        turn(f, velocity, turned);
        own = dot(towards, turned);
      } else
        own = -dot(towards, velocity);
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
      if (turns) {
        double turned[3];
        if (on_platform) {
          turn(f, pin, turned);
          own += dot(side, turned);
        } else
          own += dot(side, pin);
      }
#endif
      for (j = 0; j < 6; ++j) row[j] += l->weight * own * changes[k][j];
    }
#endif
    (void)changes;
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
  }
#endif
}

#endif
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
static void limit_drive(const search *s, const frame *f, int k, drive_limits *d) {
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  if (s->g->kind[k] <= PLATFORM_CRANK)
#endif
    limit_crank(s, f, k, d);
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  else
#endif
#endif
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    limit_slide(s, f, k, d);
#endif
}

#endif
/* Is a slack of constraint k asked for, or a cone that depends on its drive? */
static int is_needed(const search *s, const double *needed, int k) {
  if (!needed || needed[2 * k] > 0.0 || needed[2 * k + 1] > 0.0) return 1;
#if HAS_CONES
  {
    int i;
    for (i = 0; i < s->l->cones; ++i)
      if (needed[12 + i] > 0.0 && s->l->leg[i] == k) return 1;
  }
#endif
  (void)s;
  return 0;
}

/* The slacks at a frame and their derivatives by a twist; of those with `needed`, if it is not null. */
static void slacks(const search *s, const frame *f, const double *needed, double *room, double (*rows)[6]) {
  const geometry *g = s->g;
  double c[6], changes[6][6];
  int i, k;
  for (k = 0; k < 6; ++k) {
    double row[6], scale, size = 1.0, *low = rows[2 * k], *high = rows[2 * k + 1];
    c[k] = s->near[k];
    if (!is_needed(s, needed, k)) continue;
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    if (g->kind[k] >= BASE_CRANK) {
      drive_limits d;
      limit_drive(s, f, k, &d);
      c[k] = d.number;
      for (i = 0; i < 2; ++i) {
        room[2 * k + i] = d.room[i];
        by_twist(g, f, k, d.by[i], rows[2 * k + i]);
      }
      by_twist(g, f, k, d.change, changes[k]);
      continue;
    }
#endif
    room[2 * k] = room[2 * k + 1] = NEVER;
    for (i = 0; i < 6; ++i) low[i] = high[i] = 0.0;
    if (number(g, f, k, c)) c[k] = 0.0;
    if (s->low[k] <= -NO_RANGE && s->high[k] >= NO_RANGE) continue;
    if (g->kind[k] >= ALL) size = s->l->weight;
    if (s->low[k] > -NO_RANGE) room[2 * k] = size * (c[k] - s->low[k]);
    if (s->high[k] < NO_RANGE) room[2 * k + 1] = size * (s->high[k] - c[k]);
#if HAS_DLL
    if (g->kind[k] == DLL && moment_of(g, f, k, 0.0) < 0.0) c[k] = -c[k], size = -size;
#endif
    scale = slope(g, f, k, c);
    scale = fabs(scale) > 1e-12 ? -size / scale : 0.0;
    (void)equation(g, f, k, c[k], g->Y[k], g->X[k], row);
    for (i = 0; i < 6; ++i) low[i] = scale * row[i], high[i] = -low[i];
  }
#if HAS_CONES
  for (i = 0; i < s->l->cones; ++i)
    if (!needed || needed[12 + i] > 0.0) limit_cone(s, f, i, c, changes, room + 12 + i, rows[12 + i]);
#endif
  (void)changes;
}

static int slack_count(const search *s) { return 12 + s->l->cones; }

/* Half the square of the distance from the goal, with gradient and Hessian in y. */
static void away(const search *s, const frame *f, local_problem *p) {
  const double *q = f->q, *o = s->goal.q;
  double v[3], w[3], arm[3], off[3], axis[3], real, size, angle, across, weight = s->l->weight;
  int i, j, k;
  real = q[0] * o[0] + dot(q + 1, o + 1);
  cross(o + 1, q + 1, v);
  for (i = 0; i < 3; ++i) v[i] += o[0] * q[i + 1] - q[0] * o[i + 1];
  if (real < 0.0) {
    real = -real;
    for (i = 0; i < 3; ++i) v[i] = -v[i];
  }
  size = length(v);
  angle = 2.0 * atan2(size, real);
  turn(f, s->l->pivot, arm);
  for (i = 0; i < 3; ++i) {
    axis[i] = size > 0.0 ? v[i] / size : 0.0;
    w[i] = weight * angle * axis[i];
    off[i] = f->T[i] + arm[i] - s->place[i];
    arm[i] /= weight;
  }
  p->value = 0.5 * (dot(off, off) + dot(w, w));
  cross(arm, off, p->gradient);
  across = angle < 1e-6 ? 1.0 : 0.5 * angle / tan(0.5 * angle);
  if (!(across > 0.2)) across = 0.2;
  for (i = 0; i < 3; ++i) {
    p->gradient[i] += w[i];
    p->gradient[i + 3] = off[i];
    for (j = 0; j < 3; ++j) {
      double square = (i == j) * dot(arm, arm) - arm[i] * arm[j];
      p->hessian[i][j] = square + across * (i == j) + (1.0 - across) * axis[i] * axis[j];
      p->hessian[i + 3][j + 3] = i == j;
      k = 3 - i - j; /* the arm as a matrix */
      p->hessian[i][j + 3] = i == j ? 0.0 : (j == (i + 1) % 3 ? -arm[k] : arm[k]);
      p->hessian[j + 3][i] = p->hessian[i][j + 3];
    }
  }
  if (s->l->still) /* no turn */
    for (i = 0; i < 3; ++i) {
      p->gradient[i] = 0.0;
      for (j = 0; j < 6; ++j) p->hessian[i][j] = p->hessian[j][i] = i == j;
    }
}

static void linearized(const search *s, const frame *f, local_problem *p) {
  int i, j;
  away(s, f, p);
  slacks(s, f, 0, p->room, p->rows);
  for (i = 0; i < slack_count(s); ++i)
    for (j = 0; j < 3; ++j) p->rows[i][j] = s->l->still ? 0.0 : p->rows[i][j] / s->l->weight;
}

/* Half the square of the distance, and `weight` times by how much limits are violated. */
static double merit(const search *s, const local_problem *p, double weight) {
  double sum = 0.0;
  int i;
  for (i = 0; i < slack_count(s); ++i) sum += larger(-p->room[i], 0.0);
  return p->value + weight * sum;
}

static double tightest(const search *s, const local_problem *p) {
  double least = NEVER;
  int i;
  for (i = 0; i < slack_count(s); ++i)
    if (!(p->room[i] >= least)) least = p->room[i];
  return least;
}

/* Moves a frame by y. */
static void step_by(const search *s, const double *y, frame *f) {
  double d[6];
  int i;
  for (i = 0; i < 3; ++i) d[i] = y[i] / s->l->weight, d[i + 3] = y[i + 3];
  move(f, d);
}

/* The second derivatives of the slacks, weighted by multipliers. */
static void curved(const search *s, const frame *f, const local_problem *p, const double *multipliers,
                   double (*C)[6]) {
  double room[SLACKS], rows[SLACKS][6], weight = s->l->weight;
  int i, j, k;
  for (i = 0; i < 6; ++i)
    for (j = 0; j < 6; ++j) C[i][j] = 0.0;
  for (j = s->l->still ? 3 : 0; j < 6; ++j) {
    double y[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    frame moved = *f;
    y[j] = DIFFERENCE * weight;
    step_by(s, y, &moved);
    slacks(s, &moved, multipliers, room, rows);
    for (k = 0; k < slack_count(s); ++k) {
      if (!(multipliers[k] > 0.0)) continue;
      for (i = s->l->still ? 3 : 0; i < 6; ++i) {
        double change = (i < 3 ? rows[k][i] / weight : rows[k][i]) - p->rows[k][i];
        C[i][j] += 0.5 * multipliers[k] * change / y[j];
        C[j][i] += 0.5 * multipliers[k] * change / y[j];
      }
    }
  }
}

/* The lower triangle with L L^T = H - share C, but the inverses of its diagonal; zero if a pivot is not
 * above `least`. */
static int cholesky(double (*H)[6], double (*C)[6], double share, double least, double (*L)[6]) {
  int i, j, k;
  for (j = 0; j < 6; ++j)
    for (i = j; i < 6; ++i) {
      double x = H[i][j] - share * C[i][j];
      for (k = 0; k < j; ++k) x -= L[i][k] * L[j][k];
      if (i > j)
        L[i][j] = x * L[j][j];
      else if (x > least)
        L[j][j] = 1.0 / sqrt(x);
      else
        return 0;
    }
  return 1;
}

/* L^-1 x. */
static void forwards(double (*L)[6], const double *x, double *out) {
  int i, k;
  for (i = 0; i < 6; ++i) {
    out[i] = x[i];
    for (k = 0; k < i; ++k) out[i] -= L[i][k] * out[k];
    out[i] *= L[i][i];
  }
}

/* L^-T x. */
static void backwards(double (*L)[6], const double *x, double *out) {
  int i, k;
  for (i = 5; i >= 0; --i) {
    out[i] = x[i];
    for (k = i + 1; k < 6; ++k) out[i] -= L[k][i] * out[k];
    out[i] *= L[i][i];
  }
}

static double dot6(const double *a, const double *b) { return dot(a, b) + dot(a + 3, b + 3); }

/* What of z is across the rows of Z, and its shares of them: z = Z^T shares + d. */
static void split(double (*Z)[6], const int *active, int count, const double *z, double *d, double *shares) {
  double Q[6][6], U[6][6], onto[6];
  int i, j, k;
  for (j = 0; j < 6; ++j) d[j] = z[j];
  for (k = 0; k < count; ++k) {
    for (j = 0; j < 6; ++j) Q[k][j] = Z[active[k]][j];
    for (i = 0; i < k; ++i) {
      U[i][k] = dot6(Q[i], Q[k]);
      for (j = 0; j < 6; ++j) Q[k][j] -= U[i][k] * Q[i][j];
    }
    U[k][k] = sqrt(dot6(Q[k], Q[k])) + 1.0 / NEVER;
    for (j = 0; j < 6; ++j) Q[k][j] /= U[k][k];
    onto[k] = dot6(Q[k], d);
    for (j = 0; j < 6; ++j) d[j] -= onto[k] * Q[k][j];
  }
  for (k = count - 1; k >= 0; --k) {
    shares[k] = onto[k];
    for (i = k + 1; i < count; ++i) shares[k] -= U[k][i] * shares[i];
    shares[k] /= U[k][k];
  }
}

/* The shortest y with Z y >= b and its multipliers; zero if there is none. The dual method of
 * D. Goldfarb and A. Idnani (Math. Programming 27, 1983): adds the most violated row, drops rows whose
 * multiplier becomes zero. */
static int shortest(int count, double (*Z)[6], const double *b, double *y, double *multipliers) {
  int active[6], n = 0, left = ACTIVE_STEPS, i, j, p;
  for (i = 0; i < count; ++i) multipliers[i] = 0.0;
  for (j = 0; j < 6; ++j) y[j] = 0.0;
  for (;;) {
    double worst = -1e-11 * (1.0 + length6(y)), extra = 0.0;
    p = -1;
    for (i = 0; i < count; ++i) {
      double room = dot6(Z[i], y) - b[i];
      int is_active = 0;
      for (j = 0; j < n; ++j) is_active |= active[j] == i;
      if (!is_active && room < worst) worst = room, p = i;
    }
    if (p < 0) return 1;
    for (;;) {
      double d[6], shares[6], most = NEVER, full = NEVER, size;
      int drop = -1;
      if (!left--) return 0;
      split(Z, active, n, Z[p], d, shares);
      for (i = 0; i < n; ++i)
        if (shares[i] > 1e-12 && multipliers[active[i]] < most * shares[i])
          most = multipliers[active[i]] / shares[i], drop = i;
      size = dot6(d, d);
      if (n < 6 && size > 1e-14) full = (b[p] - dot6(Z[p], y)) / size;
      if (full >= NEVER && drop < 0) return 0;
      if (full < most) most = full, drop = -1;
      if (full < NEVER)
        for (j = 0; j < 6; ++j) y[j] += most * d[j];
      for (i = 0; i < n; ++i) multipliers[active[i]] -= most * shares[i];
      extra += most;
      if (drop < 0) break;
      multipliers[active[drop]] = 0.0;
      for (--n, i = drop; i < n; ++i) active[i] = active[i + 1];
    }
    multipliers[p] = extra;
    active[n++] = p;
  }
}

/* The step of the quadratic problem, and its multipliers; if the linearized limits contradict each
 * other, the one that reduces the violation. */
static void best_step(const search *s, const frame *f, local_problem *p, double *multipliers, double *step) {
  double C[6][6], L[6][6], Z[SLACKS][6], b[SLACKS], norm[SLACKS], pull[6], y[6], share, sum = 0.0;
  int i, j, k, count = slack_count(s);
  for (i = 0; i < count; ++i) sum += multipliers[i];
  share = sum > 0.0 ? 1.0 : 0.0;
  if (share > 0.0) curved(s, f, p, multipliers, C);
  else
    for (i = 0; i < 6; ++i)
      for (j = 0; j < 6; ++j) C[i][j] = 0.0;
  while (!cholesky(p->hessian, C, share, share > 0.0 ? CONVEX : 1e-9, L)) {
    if (share <= 0.0) { /* a pivot very far away */
      for (i = 0; i < 6; ++i) p->hessian[i][i] += 1.0;
      continue;
    }
    share = share > 0.2 ? 0.5 * share : 0.0;
  }
  forwards(L, p->gradient, pull);
  for (i = 0; i < count; ++i) {
    norm[i] = 1.0, b[i] = -NEVER;
    for (j = 0; j < 6; ++j) Z[i][j] = 0.0;
    if (p->room[i] >= NO_RANGE) continue;
    forwards(L, p->rows[i], Z[i]);
    norm[i] = sqrt(dot6(Z[i], Z[i]));
    if (!(norm[i] > 0.0)) norm[i] = 1.0;
    b[i] = (dot6(Z[i], pull) - p->room[i]) / norm[i];
    for (j = 0; j < 6; ++j) Z[i][j] /= norm[i];
  }
  if (shortest(count, Z, b, y, multipliers)) {
    for (j = 0; j < 6; ++j) y[j] -= pull[j];
    backwards(L, y, step);
    for (i = 0; i < count; ++i) multipliers[i] /= norm[i];
    return;
  }
  for (i = 0; i < 6; ++i) {
    pull[i] = 0.0;
    for (j = 0; j < 6; ++j) C[i][j] = i == j ? 1e-6 : 0.0;
  }
  for (k = 0; k < count; ++k) {
    multipliers[k] = 0.0;
    if (p->room[k] < 0.0)
      for (i = 0; i < 6; ++i) {
        pull[i] -= p->room[k] * p->rows[k][i];
        for (j = 0; j < 6; ++j) C[i][j] += p->rows[k][i] * p->rows[k][j];
      }
  }
  (void)cholesky(C, C, 0.0, 0.0, L);
  forwards(L, pull, y);
  backwards(L, y, step);
}

/* Moves a frame to a pose within the limits to which no small motion leads nearer; zero if the search
 * does not end within them. `distance` is that to the goal, in units of reach. */
static int seek(const search *s, frame *f, double *distance) {
  local_problem now;
  double multipliers[SLACKS], step[6], weight = 1.0, small = SEARCH_SHORT * s->l->weight;
  int i, j, count = slack_count(s);
  for (i = 0; i < SLACKS; ++i) multipliers[i] = 0.0;
  linearized(s, &s->goal, &now);
  if (!s->l->still && tightest(s, &now) >= 0.0) {
    *f = s->goal;
    *distance = 0.0;
    return 1;
  }
  linearized(s, f, &now);
  for (i = 0; i < SEARCH_STEPS; ++i) {
    double size, before, sum = 0.0;
    frame moved;
    best_step(s, f, &now, multipliers, step);
    size = length6(step);
    if (!(size - size == 0.0)) return 0;
    if (size > SEARCH_LONGEST * s->l->weight) {
      for (j = 0; j < 6; ++j) step[j] *= SEARCH_LONGEST * s->l->weight / size;
      size = SEARCH_LONGEST * s->l->weight;
    }
    for (j = 0; j < count; ++j) sum += multipliers[j];
    weight = larger(weight, 2.0 * sum);
    before = merit(s, &now, weight);
    for (j = 0; j < SEARCH_HALVINGS; ++j) {
      int k;
      moved = *f;
      step_by(s, step, &moved);
      linearized(s, &moved, &now);
      if (merit(s, &now, weight) <= before * (1.0 + 1e-13) || size < small) break;
      for (k = 0; k < 6; ++k) step[k] *= 0.5;
      size *= 0.5;
    }
    *f = moved;
    if (size < small) break;
  }
  *distance = sqrt(2.0 * now.value);
  return tightest(s, &now) > -0.5 * MARGIN * s->l->weight;
}

/* One step towards a goal: the search, and the proof of the straight line of values to what it found. */
static int towards(const geometry *g, const limits *l, const frame *goal, platform_state *state,
                   platform_report *report) {
  search s;
  frame at, found, end;
  platform_state next = *state;
  double here[6], c[6], values[6], distance, off = 0.0;
  int k, status;
  if (!load(g, &state->pose, &at)) return PLATFORM_NOT_FINITE;
  for (k = 0; k < 6; ++k) {
    c[k] = here[k] = (state->values[k] + g->offset[k]) * g->unit[k];
    if (!(c[k] - c[k] == 0.0)) return PLATFORM_NOT_FINITE;
  }
  search_from(&s, g, l, &at, c);
  search_for(&s, goal);
  found = at;
  if (!seek(&s, &found, &distance)) return PLATFORM_NOT_FOUND;
  for (k = 0; k < 6; ++k) {
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    if (g->kind[k] >= BASE_CRANK) { /* on its side of the dead point */
      drive_limits d;
      limit_drive(&s, &found, k, &d);
      c[k] = d.number;
    } else
#endif
    if ((status = number(g, &found, k, c)) != 0)
      return status;
    /* A range of one number is met by the number, not by a pose in doubles. */
    if (s.low[k] == s.high[k]) c[k] = s.low[k];
    values[k] = c[k] / g->unit[k] - g->offset[k];
  }
  /* A proved line keeps the sign of the determinant. */
  if (side(g, &at, here) != side(g, &found, c)) return PLATFORM_SINGULAR;
  status = follow(g, values, &next, report);
  if (status) return status;
  (void)load(g, &next.pose, &end);
  for (k = 0; k < 3; ++k) off += fabs(end.T[k] - found.T[k]) + fabs(dot(end.R[k], found.R[k]) - 1.0);
  if (!(off < 1e-5)) return PLATFORM_SINGULAR; /* on another branch */
  *state = next;
  return PLATFORM_PROVED;
}

static int approach(const geometry *g, const limits *l, const platform_pose *given, platform_state *state,
                    platform_report *report) {
  frame start, goal, between;
  int i, k, status;
  if (!load(g, given, &goal) || !load(g, &state->pose, &start)) return PLATFORM_NOT_FINITE;
  status = towards(g, l, &goal, state, report);
  if (status != PLATFORM_SINGULAR && status != PLATFORM_TRIES_SPENT && status != PLATFORM_NOT_FOUND)
    return status;
  if (start.q[0] * goal.q[0] + dot(start.q + 1, goal.q + 1) < 0.0)
    for (i = 0; i < 4; ++i) start.q[i] = -start.q[i];
  for (k = 1; k <= SEARCH_GOALS; ++k) {
    double share = (double)k / SEARCH_GOALS;
    for (i = 0; i < 4; ++i) between.q[i] = (1.0 - share) * start.q[i] + share * goal.q[i];
    for (i = 0; i < 3; ++i) between.T[i] = (1.0 - share) * start.T[i] + share * goal.T[i];
    rotate(&between);
    status = towards(g, l, &between, state, report);
    if (status) break;
  }
  return status;
}

#if HAS_DATA
int platform_nearest(const platform_pose *given, platform_state *state, platform_report *report) {
  return approach(&data, &within, given, state, report);
}
#endif
