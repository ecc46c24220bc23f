/* @NAME@: see platform.h. Written by gsp export --to c.
 *
 * Theorem (Newton-Kantorovich). Poses near the start are exp(w) R, T + t, x = (w, t) in R^6; lengths
 * in units of `reach`, T the place of the middle of the platform. F are the six equations, c(s) the
 * line of values, x(s) = s d the chord to the new pose, Y an approximate inverse of F'(0). If for s
 * in [0, 1]   |Y F(x(s), c(s))| <= beta,   |1 - Y F'(x(s), c(s))| <= q,
 * |Y F''| <= kappa within `tube` of the chord,   q + sqrt(2 kappa beta) < 1,
 * then for each s exactly one pose is within min(tube, (1 - q) / kappa) of x(s), and it is simple.
 *
 * Derivatives of exp(w) y by w of any order have norms of at most |y|; those of products follow by
 * the rule of products (jets: bounds of the orders 0 to 3 by a unit twist). F on the chord: by
 * quadratic interpolation, whose error is at most sqrt(3)/216 of the third derivative.
 *
 * Rounding: no term goes through more than 100 roundings, those of the data included. So EPS =
 * 2^-46 times the moduli of all terms bounds the error, with fused multiplications or without. The
 * errors of cos, sin and sqrt are assumed to be at most two units in the last place. */
#include "platform.h"

#include <math.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "the proofs need IEEE arithmetic: compile without -ffast-math, -Ofast, -funsafe-math-optimizations, -fassociative-math, -freciprocal-math and -ffinite-math-only"
#endif
#if defined(__clang__) /* it has no macros for these options; the pragma overrides them */
#pragma float_control(precise, on)
#endif

#define EPS 0x1p-46
#define OUTWARD (1.0 + 0x1p-40)
#define LONGEST 0.5 /* of the first correction */
#define CORRECTIONS 3 /* with the same Y, */
#define MOST_CORRECTIONS 10 /* and all */
#define CONVERGED 0x1p-42
#define STALLED 0x1p-46 /* corrections that no longer decrease are rounding, if they are below this |Y| */
#define SHORTEST 0x1p-10 /* part of the line */
#define TUBE 0x1p-10
#define NEVER 1e30 /* a bound that proves nothing */

enum { DPP, DPL, DLP, DPH, DHP, DLL, ALL, ALH, AHL, AHH, BASE_CRANK, PLATFORM_CRANK };
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
enum { BASE_SLIDE = PLATFORM_CRANK + 1, PLATFORM_SLIDE };
#endif

/* Points are in frames whose origins are the middles of the bodies, in units of reach. */
typedef struct {
  unsigned char kind[6];
  double Y[6][3], X[6][3]; /* of the platform and of the base: nearest to the middles */
#if HAS_DLP || HAS_DHP || HAS_DLL || HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
  double U[6][3]; /* unit directions and normals of the platform */
#endif
#if HAS_DPL || HAS_DPH || HAS_DLL || HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
  double V[6][3]; /* and of the base */
#endif
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  double A[6][3], B[6][3]; /* points on circles: X (or Y) + A cos + B sin; on rails: X (or Y) + B c */
  double crank[6], rod[6]; /* the radii, of rails 1, and the lengths of the rods */
  double lowest[6], highest[6]; /* of value + offset at a pose, or of its modulus: if no drive changes it */
#endif
  double norm_y[6];          /* not below |Y|, with the crank */
  double moduli[6];          /* not below the sum of the moduli of all that Y and X are sums of */
  double middle[3], origin[3]; /* the middles of platform and base, in length units */
  double reach, shift;       /* a length; a bound of the moduli of the middles by it */
  double unit[6], offset[6]; /* an equation has (value + offset) unit */
  double least[6], most[6];  /* of value + offset, */
#if HAS_DPH || HAS_DHP
  unsigned char either[6];   /* or of its modulus */
#endif
} geometry;

#if HAS_DATA
@DATA@
#endif
typedef struct {
  double q[4], R[3][3], T[3];
} frame;

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static double length(const double *a) { return sqrt(dot(a, a)); }
static double larger(double a, double b) { return a > b ? a : b; }
static double length6(const double *a) { return sqrt(dot(a, a) + dot(a + 3, a + 3)); }
static void cross(const double *a, const double *b, double *out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}
static void add(double *a, double factor, const double *b) {
  int i;
  for (i = 0; i < 3; ++i) a[i] += factor * b[i];
}
static void turn(const frame *f, const double *a, double *out) {
  int i;
  for (i = 0; i < 3; ++i) out[i] = dot(f->R[i], a);
}

/* R of the quaternion, whose norm becomes one. */
static void rotate(frame *f) {
  double *q = f->q, s = 1.0 / sqrt(q[0] * q[0] + dot(q + 1, q + 1));
  double w = q[0] *= s, x = q[1] *= s, y = q[2] *= s, z = q[3] *= s;
  f->R[0][0] = w * w + x * x - y * y - z * z;
  f->R[1][1] = w * w - x * x + y * y - z * z;
  f->R[2][2] = w * w - x * x - y * y + z * z;
  f->R[0][1] = 2.0 * (x * y - w * z);
  f->R[1][0] = 2.0 * (x * y + w * z);
  f->R[0][2] = 2.0 * (x * z + w * y);
  f->R[2][0] = 2.0 * (x * z - w * y);
  f->R[1][2] = 2.0 * (y * z - w * x);
  f->R[2][1] = 2.0 * (y * z + w * x);
}

/* The frame of a pose; zero if there is none. */
static int load(const geometry *g, const platform_pose *pose, frame *f) {
  double shift[3], norm = 0.0, most = 0.0;
  int i;
  for (i = 0; i < 4; ++i) most = larger(most, fabs(f->q[i] = pose->rotation[i]));
  if (!(most > 0.0)) return 0;
  for (i = 0; i < 4; ++i) {
    f->q[i] /= most;
    norm += f->q[i] * f->q[i];
  }
  if (!(norm <= 4.0)) return 0;
  rotate(f);
  turn(f, g->middle, shift);
  for (i = 0; i < 3; ++i) {
    f->T[i] = (pose->position[i] + shift[i] - g->origin[i]) * (1.0 / g->reach);
    if (!(fabs(f->T[i]) < 1e6)) return 0;
  }
  return 1;
}

static void unload(const geometry *g, const frame *f, platform_pose *pose) {
  double shift[3];
  int i;
  for (i = 0; i < 4; ++i) pose->rotation[i] = f->q[i];
  turn(f, g->middle, shift);
  for (i = 0; i < 3; ++i) pose->position[i] = f->T[i] * g->reach - shift[i] + g->origin[i];
}

/* By how much a frame may be off from its pose: what load and unload round. */
static double rounded(const geometry *g, const frame *f) {
  return EPS * (1.0 + length(f->T) + g->shift);
}

/* Moves a pose by a small twist. */
static void move(frame *f, const double *d) {
  double q[4], w[3] = {0.5 * d[0], 0.5 * d[1], 0.5 * d[2]};
  int i;
  for (i = 0; i < 4; ++i) q[i] = f->q[i];
  cross(w, q + 1, f->q + 1);
  f->q[0] = q[0] - dot(w, q + 1);
  for (i = 0; i < 3; ++i) {
    f->q[i + 1] += q[i + 1] + q[0] * w[i];
    f->T[i] += d[i + 3];
  }
  rotate(f);
}

/* The numbers of the constraints, and the points of those with cranks and slides, which move them. */
typedef struct {
  double c[6];
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  double Y[6][3], X[6][3];
#endif
} setting;

/* The points of constraint k at a number. */
static void points(const geometry *g, int k, double c, double *y, double *x) {
  int i;
  for (i = 0; i < 3; ++i) y[i] = g->Y[k][i], x[i] = g->X[k][i];
  (void)c; /* only drives need it */
  switch (g->kind[k]) {
#if HAS_BASE_CRANK
    case BASE_CRANK:
      add(x, cos(c), g->A[k]);
      add(x, sin(c), g->B[k]);
      break;
#endif
#if HAS_PLATFORM_CRANK
    case PLATFORM_CRANK:
      add(y, cos(c), g->A[k]);
      add(y, sin(c), g->B[k]);
      break;
#endif
#if HAS_BASE_SLIDE
    case BASE_SLIDE:
      add(x, c, g->B[k]);
      break;
#endif
#if HAS_PLATFORM_SLIDE
    case PLATFORM_SLIDE:
      add(y, c, g->B[k]);
      break;
#endif
    default:
      break;
  }
}

static void set(const geometry *g, const double *c, setting *s) {
  int k;
  for (k = 0; k < 6; ++k) {
    s->c[k] = c[k];
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    if (g->kind[k] >= BASE_CRANK) points(g, k, c[k], s->Y[k], s->X[k]);
#endif
  }
  (void)g;
}

static const double *platform_point(const geometry *g, int k, const setting *s) {
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  if (g->kind[k] >= BASE_CRANK) return s->Y[k];
#endif
  (void)s;
  return g->Y[k];
}
static const double *base_point(const geometry *g, int k, const setting *s) {
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  if (g->kind[k] >= BASE_CRANK) return s->X[k];
#endif
  (void)s;
  return g->X[k];
}

/* A constraint at a pose: r from the base's point to the platform's, arm = R y, w = R u. */
typedef struct {
  double arm[3], r[3];
#if HAS_DLP || HAS_DHP || HAS_DLL || HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
  double w[3];
#endif
} placed;

static void place(const geometry *g, const frame *f, int k, const double *y, const double *x, placed *p) {
  int i;
  (void)g, (void)k; /* only directions need them */
  turn(f, y, p->arm);
  for (i = 0; i < 3; ++i) p->r[i] = p->arm[i] + f->T[i] - x[i];
#if HAS_DLP || HAS_DHP || HAS_DLL || HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
  turn(f, g->U[k], p->w);
#endif
#if HAS_DPL
  if (g->kind[k] == DPL) add(p->r, -dot(p->r, g->V[k]), g->V[k]);
#endif
#if HAS_DLP
  if (g->kind[k] == DLP) { /* the point of the line that is nearest */
    double s = dot(p->r, p->w);
    add(p->r, -s, p->w);
    add(p->arm, -s, p->w);
  }
#endif
}

/* Equation k, with its number and its two points, and its derivative by a twist if `row` is not null.
 * Distances of lines have signs here. */
static double equation(const geometry *g, const frame *f, int k, double c, const double *y, const double *x,
                       double *row) {
  double F = 0.0;
  placed p;
  double force[3] = {0.0, 0.0, 0.0}, moment[3] = {0.0, 0.0, 0.0};
  place(g, f, k, y, x, &p);
  switch (g->kind[k]) {
#if HAS_DPP || HAS_DPL || HAS_DLP || HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    default: {
      double d = c;
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
      if (g->kind[k] >= BASE_CRANK) d = g->rod[k];
#endif
      F = dot(p.r, p.r) - d * d;
      add(force, 2.0, p.r);
      break;
    }
#endif
#if HAS_DPH
    case DPH:
      F = dot(p.r, g->V[k]) - c;
      add(force, 1.0, g->V[k]);
      break;
#endif
#if HAS_DHP
    case DHP:
      F = -dot(p.r, p.w) - c;
      add(force, -1.0, p.w);
      add(p.arm, -1.0, p.r);
      break;
#endif
#if HAS_DLL
    case DLL: { /* the moment of the lines, r.n, less distance times sine */
      double n[3], vr[3], wvr[3], sine;
      cross(p.w, g->V[k], n);
      cross(g->V[k], p.r, vr);
      cross(p.w, vr, wvr);
      sine = length(n);
      F = dot(p.r, n) - c * sine;
      add(force, 1.0, n);
      add(moment, 1.0, wvr);
      add(moment, c * dot(p.w, g->V[k]) / sine, n);
      break;
    }
#endif
#if HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
    case ALL:
    case ALH:
    case AHL:
    case AHH: {
      double sign = g->kind[k] == AHH ? -1.0 : 1.0, n[3];
      int cosine = g->kind[k] == ALL || g->kind[k] == AHH;
      F = sign * dot(p.w, g->V[k]) - (cosine ? cos(c) : sin(c));
      cross(p.w, g->V[k], n);
      add(moment, sign, n);
      break;
    }
#endif
  }
  if (row) {
    double turned[3];
    int i;
    cross(p.arm, force, turned);
    for (i = 0; i < 3; ++i) {
      row[i] = moment[i] + turned[i];
      row[i + 3] = force[i];
    }
  }
  return F;
}

/* All equations, and their derivatives if J is not null. */
static void equations(const geometry *g, const frame *f, const setting *s, double *F, double (*J)[6]) {
  int k;
  for (k = 0; k < 6; ++k)
    F[k] = equation(g, f, k, s->c[k], platform_point(g, k, s), base_point(g, k, s), J ? J[k] : 0);
}

/* The derivative of an equation by its value. */
static double slope(const geometry *g, const frame *f, int k, const double *c) {
  double y[3], x[3];
  placed p;
  points(g, k, c[k], y, x);
  place(g, f, k, y, x, &p);
  switch (g->kind[k]) {
#if HAS_BASE_CRANK
    case BASE_CRANK:
      return 2.0 * (sin(c[k]) * dot(p.r, g->A[k]) - cos(c[k]) * dot(p.r, g->B[k]));
#endif
#if HAS_PLATFORM_CRANK
    case PLATFORM_CRANK: {
      double a[3], b[3];
      turn(f, g->A[k], a);
      turn(f, g->B[k], b);
      return 2.0 * (cos(c[k]) * dot(p.r, b) - sin(c[k]) * dot(p.r, a));
    }
#endif
#if HAS_BASE_SLIDE
    case BASE_SLIDE:
      return -2.0 * dot(p.r, g->B[k]);
#endif
#if HAS_PLATFORM_SLIDE
    case PLATFORM_SLIDE: {
      double b[3];
      turn(f, g->B[k], b);
      return 2.0 * dot(p.r, b);
    }
#endif
#if HAS_DPH || HAS_DHP
    case DPH:
    case DHP:
      return -1.0;
#endif
#if HAS_DLL
    case DLL: {
      double n[3];
      cross(p.w, g->V[k], n);
      return -length(n);
    }
#endif
#if HAS_ALL || HAS_AHH
    case ALL:
    case AHH:
      return sin(c[k]);
#endif
#if HAS_ALH || HAS_AHL
    case ALH:
    case AHL:
      return -cos(c[k]);
#endif
    default:
      return -2.0 * c[k];
  }
}

/* What the theorem needs to know of each equation. */
typedef struct {
  double first[6];  /* of |F'| */
  double second[6]; /* of |F''| */
  double rest[6];   /* of the second derivative of F' along the chord */
  double third[6];  /* of the third derivative of F along the chord */
  double cross[6];  /* of the change of F' by c alone, for charts about the start */
  double error[6];  /* of F by rounding */
  double slant[6];  /* of F' by rounding */
} bounds;

/* A part of the line of values, and the tube about its chord. */
typedef struct {
  const setting *from, *to;
  double size, radius; /* of the chord, and of all that is within the tube */
} part;

static double largest(const part *b, int k) { return larger(fabs(b->from->c[k]), fabs(b->to->c[k])); }

#if HAS_DPP || HAS_DPL || HAS_DLP || HAS_DLL || HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* The jet of a product. */
static void times(const double *a, const double *b, double *out) {
  out[0] = a[0] * b[0];
  out[1] = a[0] * b[1] + a[1] * b[0];
  out[2] = a[0] * b[2] + 2.0 * a[1] * b[1] + a[2] * b[0];
  out[3] = a[0] * b[3] + 3.0 * (a[1] * b[2] + a[2] * b[1]) + a[3] * b[0];
}
#endif

/* Orders 1 to 3 of r, or of its part across a line of the base, or of its height above a plane:
 * of exp(w) y + t. */
static void moved(double y, double *e) {
  e[1] = sqrt(1.0 + y * y);
  e[2] = e[3] = y;
}

#if HAS_DLP || HAS_DHP
/* The same as the platform sees it: of exp(-w) (x - t), x from the middle to the base's point. */
static void seen(const geometry *g, const frame *f, int k, double radius, double *e) {
  double x[3] = {f->T[0] - g->X[k][0], f->T[1] - g->X[k][1], f->T[2] - g->X[k][2]};
  double far = length(x) + radius;
  e[1] = sqrt(1.0 + far * far);
  e[2] = far + 1.0;
  e[3] = far + 1.1547005383792517;
}
#endif

#if HAS_DPP || HAS_DPL || HAS_DLP || HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* Of |r|^2, with the orders e of r by a unit twist. */
static void bound_square(const geometry *g, int k, const placed *p, const part *b, double *e,
                         double moduli, bounds *out) {
  double size = b->size, x = 0.0, d[4], along[4], d_along[4], turned[2];
  double constant = largest(b, k);
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  double bent = 0.0;
  int own = 0; /* the arm, or the rail, turns with the platform */
  if (g->kind[k] >= BASE_CRANK) {
    double change = fabs(b->to->c[k] - b->from->c[k]);
    x = g->crank[k] * change;
    constant = g->rod[k];
    if (g->kind[k] <= PLATFORM_CRANK) bent = change; /* a rail is straight */
  }
#if HAS_PLATFORM_CRANK
  own |= g->kind[k] == PLATFORM_CRANK;
#endif
#if HAS_PLATFORM_SLIDE
  own |= g->kind[k] == PLATFORM_SLIDE;
#endif
#endif
  (void)g;
  e[0] = length(p->r) + e[1] * b->radius + x;
  along[0] = e[0];
  along[1] = e[1] * size + x;
  along[2] = e[2] * size * size;
  along[3] = e[3] * size * size * size;
  turned[0] = e[2] * size; /* of the derivative of r by a unit twist, orders 1 and 2 */
  turned[1] = e[3] * size * size;
  out->cross[k] = 2.0 * x * e[1];
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
  along[2] += x * bent;
  along[3] += x * bent * bent;
  if (own) {
    double both = x * size;
    along[2] += 2.0 * both;
    along[3] += 3.0 * both * (size + bent);
    turned[0] += x;
    turned[1] += x * (2.0 * size + bent);
    out->cross[k] += 2.0 * e[0] * x;
  }
#endif
  times(e, e, d);
  times(along, along, d_along);
  out->first[k] = d[1];
  out->second[k] = d[2];
  out->rest[k] = 2.0 * (along[2] * e[1] + 2.0 * along[1] * turned[0] + e[0] * turned[1]);
  out->third[k] = d_along[3];
  out->error[k] = EPS * (3.0 * moduli * moduli + 3.0 * constant * constant);
  out->slant[k] = EPS * 4.0 * moduli * (1.0 + moduli);
}
#endif

#if HAS_DLL
/* Bounds of r.n - c |n|, n = w x v. Any points of both lines give the same moment. Chosen are the foot
 * of the common perpendicular on the platform's line (or a point nearer to the middle, if the lines
 * are nearly parallel), and the point of the base's line nearest to it. */
static void bound_lines(const geometry *g, int k, const placed *p, const part *b, double moduli,
                        bounds *out) {
  const double *v = g->V[k];
  double arm[3], r[3], n[3], nv[3], e[4], ne[4], m[4], h[4], size = b->size, s, lowest, cosine, sine;
  double c = largest(b, k), change = fabs(b->to->c[k] - b->from->c[k]);
  int i;
  cross(p->w, v, n);
  sine = length(n);
  cross(v, n, nv); /* w less its part along v */
  s = -dot(p->r, nv) / (sine * sine);
  if (!(fabs(s) < 8.0)) s = s > 0.0 ? 8.0 : -8.0;
  for (i = 0; i < 3; ++i) arm[i] = p->arm[i], r[i] = p->r[i];
  add(arm, s, p->w);
  add(r, s, p->w);
  add(r, -dot(r, v), v);
  moved(length(arm), e);
  e[0] = length(r) + e[1] * b->radius;
  ne[0] = sine + b->radius;
  ne[1] = ne[2] = ne[3] = 1.0;
  times(e, ne, m);
  /* |n| is the sine of an angle that changes by at most the length of a twist. */
  lowest = sine - b->radius;
  if (!(lowest > 0.0)) lowest = 1.0 / NEVER;
  cosine = sqrt(larger(0.0, 1.0 - lowest * lowest));
  h[1] = cosine;
  h[2] = (1.0 + cosine) / lowest;
  h[3] = (3.0 + 3.0 * cosine) / (lowest * lowest) + cosine / lowest;
  out->first[k] = m[1] + c * h[1];
  out->second[k] = m[2] + c * h[2];
  out->rest[k] = size * ((m[3] + c * h[3]) * size + 2.0 * change * h[2]);
  out->third[k] = size * size * ((m[3] + c * h[3]) * size + 3.0 * change * h[2]);
  out->cross[k] = change * h[1];
  out->error[k] = EPS * (3.0 * moduli + 2.0 * c);
  out->slant[k] = EPS * (8.0 * (1.0 + moduli) + 8.0 * c / lowest);
}
#endif

static void bound(const geometry *g, const frame *f, const part *b, bounds *out) {
  double place_size = length(f->T);
  int k;
  for (k = 0; k < 6; ++k) {
    placed p;
    double e[4], moduli = (g->moduli[k] + place_size) * OUTWARD + b->radius;
    place(g, f, k, platform_point(g, k, b->from), base_point(g, k, b->from), &p);
    moved(g->norm_y[k], e);
    switch (g->kind[k]) {
#if HAS_DLP
      case DLP:
        seen(g, f, k, b->radius, e);
        bound_square(g, k, &p, b, e, moduli, out);
        break;
#endif
#if HAS_DPP || HAS_DPL || HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
      default:
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
        if (g->kind[k] >= BASE_CRANK) moduli += g->crank[k] * largest(b, k);
#endif
#if HAS_PLATFORM_SLIDE
        if (g->kind[k] == PLATFORM_SLIDE)
          moved(g->norm_y[k] + largest(b, k), e);
#endif
        bound_square(g, k, &p, b, e, moduli, out);
        break;
#endif
#if HAS_DPH || HAS_DHP
      case DPH:
      case DHP:
#if HAS_DHP
        if (g->kind[k] == DHP) seen(g, f, k, b->radius, e);
#endif
        out->first[k] = e[1];
        out->second[k] = e[2];
        out->rest[k] = e[3] * b->size * b->size;
        out->third[k] = out->rest[k] * b->size;
        out->cross[k] = 0.0;
        out->error[k] = EPS * (moduli + 2.0 * largest(b, k));
        out->slant[k] = EPS * (1.0 + moduli);
        break;
#endif
#if HAS_DLL
      case DLL:
        bound_lines(g, k, &p, b, moduli, out);
        break;
#endif
#if HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
      case ALL:
      case ALH:
      case AHL:
      case AHH: {
        double change = fabs(b->to->c[k] - b->from->c[k]);
        out->first[k] = out->second[k] = 1.0;
        out->rest[k] = b->size * b->size;
        out->third[k] = out->rest[k] * b->size + change * change * change;
        out->cross[k] = 0.0;
        out->error[k] = EPS * (2.0 + 2.0 * largest(b, k));
        out->slant[k] = EPS * 2.0;
        break;
      }
#endif
    }
    out->error[k] += EPS * 2.0 * fabs(g->offset[k]) * g->unit[k] * (1.0 + moduli) * (1.0 + moduli);
  }
}

/* The inverse of a matrix, which is destroyed. Returns the sign of its determinant; zero if it has no
 * inverse. */
static int invert(double (*a)[6], double (*out)[6]) {
  int i, j, k, sign = 1;
  for (i = 0; i < 6; ++i)
    for (j = 0; j < 6; ++j) out[i][j] = i == j ? 1.0 : 0.0;
  for (j = 0; j < 6; ++j) {
    int pivot = j;
    double scale;
    for (i = j + 1; i < 6; ++i)
      if (fabs(a[i][j]) > fabs(a[pivot][j])) pivot = i;
    if (!(fabs(a[pivot][j]) > 1e-12)) return 0;
    if ((pivot != j) != (a[pivot][j] < 0.0)) sign = -sign;
    scale = 1.0 / a[pivot][j];
    for (k = 0; k < 6; ++k) {
      double x = a[pivot][k], z = out[pivot][k];
      a[pivot][k] = a[j][k];
      out[pivot][k] = out[j][k];
      a[j][k] = x * scale;
      out[j][k] = z * scale;
    }
    for (i = 0; i < 6; ++i) {
      double factor = a[i][j];
      if (i == j) continue;
      for (k = j; k < 6; ++k) a[i][k] -= factor * a[j][k];
      for (k = 0; k < 6; ++k) out[i][k] -= factor * out[j][k];
    }
  }
  return sign;
}

/* |Y F|, and -Y F. */
static double correction(double (*inverse)[6], const double *F, double *d) {
  int i, k;
  for (i = 0; i < 6; ++i) {
    d[i] = 0.0;
    for (k = 0; k < 6; ++k) d[i] -= inverse[i][k] * F[k];
  }
  return length6(d);
}

/* The largest |Y x| of all x with |x_k| <= b_k. */
static double spread(double (*inverse)[6], const double *b) {
  double rows[6];
  int i, k;
  for (i = 0; i < 6; ++i) {
    rows[i] = 0.0;
    for (k = 0; k < 6; ++k) rows[i] += fabs(inverse[i][k]) * b[k];
  }
  return length6(rows);
}

/* A pose with its numbers and the equations there. */
typedef struct {
  frame f;
  setting at;
  double F[6], J[6][6];
} knot;

static void evaluate(const geometry *g, knot *n) { equations(g, &n->f, &n->at, n->F, n->J); }

/* Y at a pose; returns |1 - Y F'| with its rounding, or a number above one. */
static double linearize(const knot *n, double (*inverse)[6]) {
  double work[6][6], defect = 0.0, moduli = 0.0;
  int i, j, k;
  for (i = 0; i < 6; ++i)
    for (j = 0; j < 6; ++j) work[i][j] = n->J[i][j];
  if (!invert(work, inverse)) return 2.0;
  for (i = 0; i < 6; ++i) {
    double s[6], m[6];
    for (j = 0; j < 6; ++j) s[j] = i == j ? -1.0 : 0.0, m[j] = 1.0;
    for (k = 0; k < 6; ++k)
      for (j = 0; j < 6; ++j) {
        double x = inverse[i][k] * n->J[k][j];
        s[j] += x;
        m[j] += fabs(x);
      }
    for (j = 0; j < 6; ++j) {
      defect += s[j] * s[j];
      moduli += m[j] * m[j];
    }
  }
  return (sqrt(defect) + 0x1p-49 * sqrt(moduli)) * OUTWARD;
}

/* Bounds |Y (F'(x) - F'(0))| for x = (w, t) = d from one pose to another, with their numbers, and in
 * between. The derivative of exp is 1 + w^x / 2 up to |w|^2 / 6 (and |d|^3 / 5, since d may have the
 * tangent of the angle). The error of linear interpolation is added: an eighth of `rest`. */
static double slanting(const knot *start, const knot *end, const double *d, const bounds *b,
                       double (*inverse)[6]) {
  double rows[6][6], rest[6], sum = 0.0, size = length6(d) * OUTWARD;
  int i, j, k;
  for (k = 0; k < 6; ++k) {
    double turned[3];
    cross(end->J[k], d, turned);
    for (j = 0; j < 6; ++j) rows[k][j] = end->J[k][j] - start->J[k][j];
    add(rows[k], 0.5, turned);
    rest[k] = (1.0 + 1.25 * size) * size * size / 6.0 * b->first[k] + 0.125 * b->rest[k] +
              3.0 * b->slant[k];
  }
  for (i = 0; i < 6; ++i) {
    double s[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    for (k = 0; k < 6; ++k)
      for (j = 0; j < 6; ++j) s[j] += inverse[i][k] * rows[k][j];
    for (j = 0; j < 6; ++j) sum += s[j] * s[j];
  }
  return sqrt(sum) + spread(inverse, rest);
}

typedef struct {
  double measure, error, alone, radius; /* measure below one: proved; radius: of the poses about the chord */
} proof;

/* A part of the line that is to be proved: its ends and its middle. */
typedef struct {
  const knot *start;
  knot *end, middle; /* without J but for the proof about the middle */
  double d[6]; /* the twist from the start to the middle, twice */
  int central; /* the part before was proved about its middle: this one is tried there only */
} segment;

/* Finds d and the middle; the angle is at most twice the tangent of its half, which is the length of
 * the rotation. Zero if it is 120 degrees or more. */
static int span(const geometry *g, segment *p) {
  const frame *f = &p->start->f, *next = &p->end->f;
  frame *middle = &p->middle.f;
  double half[6], v[3], real = f->q[0] * next->q[0] + dot(f->q + 1, next->q + 1);
  int i;
  if (!(fabs(real) > 0.5)) return 0;
  for (i = 0; i < 4; ++i) middle->q[i] = f->q[i] + (real < 0.0 ? -next->q[i] : next->q[i]);
  rotate(middle);
  cross(f->q + 1, next->q + 1, v);
  for (i = 0; i < 3; ++i) {
    middle->T[i] = 0.5 * (f->T[i] + next->T[i]);
    p->d[i] = 2.0 / real * (f->q[0] * next->q[i + 1] - next->q[0] * f->q[i + 1] + v[i]);
    p->d[i + 3] = next->T[i] - f->T[i];
  }
  for (i = 0; i < 6; ++i) half[i] = 0.5 * (p->start->at.c[i] + p->end->at.c[i]);
  set(g, half, &p->middle.at);
  equations(g, middle, &p->middle.at, p->middle.F, 0);
  return 1;
}

/* The theorem for a segment, with charts about its start (Y there, which is at hand) or, dearer and
 * sharper, about its middle. */
static proof prove(const geometry *g, const segment *p, int central, double (*inverse)[6],
                   double defect) {
  bounds b;
  part tubular;
  proof result;
  double bend[6], waste[6], size = length6(p->d) * OUTWARD + 0x1p-45, shake, tube, q, beta, kappa, end,
         root;
  int k;
  tube = 0.5 * size + TUBE;
  tubular.from = &p->start->at, tubular.to = &p->end->at;
  tubular.size = size;
  tubular.radius = (central ? 0.5 * size : size) + tube;
  bound(g, central ? &p->middle.f : &p->start->f, &tubular, &b);
  for (k = 0; k < 6; ++k) bend[k] = p->middle.F[k] - 0.5 * (p->start->F[k] + p->end->F[k]);
  shake = spread(inverse, b.error);
  end = correction(inverse, p->end->F, waste) + shake;
  beta = larger(end, correction(inverse, p->start->F, waste) + shake) + correction(inverse, bend, waste) + shake +
         0.00802 * spread(inverse, b.third);
  beta *= OUTWARD;
  kappa = spread(inverse, b.second) * OUTWARD;
  if (central) {
    double back[6], on[6], quarter = 0.25;
    for (k = 0; k < 6; ++k) on[k] = 0.5 * p->d[k], back[k] = -on[k], b.rest[k] *= quarter;
    q = larger(slanting(&p->middle, p->end, on, &b, inverse),
               slanting(&p->middle, p->start, back, &b, inverse));
  } else
    q = kappa * size + spread(inverse, b.cross) + spread(inverse, b.slant);
  q = (defect + q) * OUTWARD;
  result.measure = (q + sqrt(2.0 * kappa * beta)) * OUTWARD;
  result.alone = (1.0 - q) / kappa;
  if (!(result.alone < tube)) result.alone = tube;
  result.error = 2.0 * end / (1.0 - q) * OUTWARD;
  root = 2.0 * kappa * beta / ((1.0 - q) * (1.0 - q)) * OUTWARD; /* below one if it is proved */
  root = root < 1.0 ? sqrt(1.0 - root) : 0.0;
  result.radius = 2.0 * beta / ((1.0 - q) * (1.0 + root)) * OUTWARD;
  if (!(q < 1.0 && size < LONGEST + 0.25 && 2.0 * beta / (1.0 - q) < tube))
    result.measure = larger(result.measure, 2.0);
  return result;
}

/* The proof about the start or, if that is not enough, about the middle. */
static proof attempt(const geometry *g, segment *p, double (*inverse)[6], double defect) {
  double fresh[6][6];
  proof found = {8.0, 0.0, 0.0, 0.0};
  if (!span(g, p)) return found;
  if (!p->central) {
    found = prove(g, p, 0, inverse, defect);
    if (found.measure < 1.0 || found.measure >= 16.0) return found;
  }
  evaluate(g, &p->middle);
  defect = linearize(&p->middle, fresh);
  if (defect < 0.5) {
    evaluate(g, p->end);
    found = prove(g, p, 1, fresh, defect);
    p->central = found.measure < 1.0;
  }
  return found;
}

/* Is a correction no more than rounding? */
static int stalled(double (*inverse)[6], double size) {
  double sum = 0.0;
  int i, k;
  for (i = 0; i < 6; ++i)
    for (k = 0; k < 6; ++k) sum += inverse[i][k] * inverse[i][k];
  return size < STALLED * sqrt(sum);
}

/* Newton's method to the pose of the numbers of a knot; zero if it does not converge at once. Next to
 * singular poses rounding keeps corrections from CONVERGED: a proof tells whether it may. */
static int converge(const geometry *g, double (*inverse)[6], knot *n) {
  double d[6], fresh[6][6], (*used)[6] = inverse, before, now;
  int i;
  equations(g, &n->f, &n->at, n->F, 0);
  before = correction(inverse, n->F, d);
  if (!(before < LONGEST)) return 0;
  for (i = 0; i < MOST_CORRECTIONS && before > CONVERGED; ++i) {
    move(&n->f, d);
    if (i == CORRECTIONS) { /* slow: Y of where it is now */
      evaluate(g, n);
      if (!(linearize(n, fresh) < 0.5)) return 0;
      used = fresh;
    } else
      equations(g, &n->f, &n->at, n->F, 0);
    now = correction(used, n->F, d);
    if (!(now < 0.6 * before || now < CONVERGED)) return stalled(used, now);
    before = now;
  }
  return before <= CONVERGED || stalled(used, before);
}

/* Values as the equations have them. */
static int in_units(const geometry *g, const double *values, double *c) {
  int k, status = PLATFORM_PROVED;
  for (k = 0; k < 6; ++k) {
    double value = values[k] + g->offset[k];
    if (!(value - value == 0.0)) return PLATFORM_NOT_FINITE;
    c[k] = value * g->unit[k];
#if HAS_DPH || HAS_DHP
    if (g->either[k]) value = fabs(value);
#endif
    if (value < g->least[k] || value > g->most[k]) status = PLATFORM_RANGE;
  }
  return status;
}

#if HAS_DLL
/* The moment of two lines at a frame; zero if its sign is not certain. */
static double moment_of(const geometry *g, const frame *f, int k, double error) {
  placed p;
  double n[3], moment;
  place(g, f, k, g->Y[k], g->X[k], &p);
  cross(p.w, g->V[k], n);
  moment = dot(p.r, n);
  return fabs(moment) > (error + 0x1p-40) * 4.0 * (1.0 + g->moduli[k] + length(f->T)) ? moment : 0.0;
}

/* Gives distances of lines the sign that they have at the pose; zero if one is not certain. */
static int orient(const geometry *g, const frame *f, double error, double *from, double *to) {
  int k, certain = 1;
  for (k = 0; k < 6; ++k) {
    double moment;
    if (g->kind[k] != DLL || (from[k] == 0.0 && to[k] == 0.0)) continue;
    moment = moment_of(g, f, k, error);
    if (moment == 0.0)
      certain = 0;
    else if (moment < 0.0)
      from[k] = -from[k], to[k] = -to[k];
  }
  return certain;
}

/* Will the next step know the sides of all lines, or do they stay on each other? */
static int keeps_sides(const geometry *g, const frame *f, double error, const double *from,
                       const double *to) {
  int k;
  for (k = 0; k < 6; ++k)
    if (g->kind[k] == DLL && (from[k] != 0.0 || to[k] != 0.0) &&
        moment_of(g, f, k, 2.0 * error + 0x1p-40) == 0.0)
      return 0;
  return 1;
}
#endif

/* Not above the least singular value of the Jacobian matrix at the frame of the inverse. */
static double least(const geometry *g, const frame *f, const double *c, double (*inverse)[6],
                    double defect) {
  double sum = 0.0;
  int i, k;
  if (!(defect < 1.0)) return 0.0;
  for (k = 0; k < 6; ++k) {
    double s = slope(g, f, k, c);
    for (i = 0; i < 6; ++i) sum += inverse[i][k] * inverse[i][k] * s * s;
  }
  return (1.0 - defect) / (sqrt(sum) * OUTWARD);
}

/* The sign of the determinant at a pose of some numbers; zero if it is nearly singular. */
static int side(const geometry *g, const frame *f, const double *c) {
  knot n;
  double inverse[6][6];
#if HAS_DLL
  double with_sides[6], same[6];
  int k;
  for (k = 0; k < 6; ++k) with_sides[k] = same[k] = c[k];
  (void)orient(g, f, 0.0, with_sides, same);
  c = with_sides;
#endif
  n.f = *f;
  set(g, c, &n.at);
  evaluate(g, &n);
  return invert(n.J, inverse);
}

/* A proved part of a line of values: its poses are within `radius` of exp(w) R, T + t in the chart of a
 * frame, x = (w, t) = (s - from) d, s from 0 to 1. */
typedef struct {
  frame at;
  double d[6], from; /* 0, or 1/2 if the chart is about the middle */
  double begin, end; /* parts of the line */
  double radius, error, alone;
} piece;

/* Where following a line is, and its limits. */
typedef struct {
  knot at;
  double error, alone, sigma; /* of `at`; an error below zero: any pose that is near */
  double done, step;          /* parts of the line */
  double worst;
  int tries, steps;
  int most_tries;
  double shortest;
#if HAS_PIECES
  int (*keep)(void *, const piece *);
  void *kept;
#endif
} walk;

/* Follows the line of values from first to last, from where a walk is. */
static int chase(const geometry *g, const double *first, const double *last, walk *w) {
  knot next;
  segment whole;
  double to[6], inverse[6][6], defect;
  int k;
  set(g, first, &w->at.at);
  evaluate(g, &w->at);
  whole.start = &w->at, whole.end = &next, whole.central = 0;
  defect = linearize(&w->at, inverse);
  w->sigma = least(g, &w->at.f, first, inverse, defect);
  w->done = 0.0;
  while (w->tries < w->most_tries) {
    double rest = 1.0 - w->done, measure = 8.0, step = w->step;
    proof found;
    int good;
    if (!(defect < 0.5) || step < w->shortest) return PLATFORM_SINGULAR;
    ++w->tries;
    if (step > 0.75 * rest) step = step < rest ? 0.5 * rest : rest;
    for (k = 0; k < 6; ++k)
      to[k] = step == rest ? last[k] : first[k] + (w->done + step) * (last[k] - first[k]);
    next.f = w->at.f;
    set(g, to, &next.at);
    good = converge(g, inverse, &next);
    if (good) {
      found = attempt(g, &whole, inverse, defect);
      measure = found.measure;
      good = measure < 1.0 && 2.0 * w->error + 0x1p-44 < found.alone;
    }
    if (!good) {
      w->step = step * (measure > 1.0 && measure < 4.0 ? 0.8 / measure : 0.3);
      continue;
    }
    ++w->steps;
    w->worst = larger(w->worst, measure);
#if HAS_PIECES
    if (w->keep) {
      piece one;
      one.at = whole.central ? whole.middle.f : w->at.f;
      for (k = 0; k < 6; ++k) one.d[k] = whole.d[k];
      one.from = whole.central ? 0.5 : 0.0;
      one.begin = w->done;
      one.end = step == rest ? 1.0 : w->done + step;
      one.radius = found.radius;
      one.error = found.error;
      one.alone = found.alone;
      if (!w->keep(w->kept, &one)) return PLATFORM_TRIES_SPENT;
    }
#endif
    w->error = found.error;
    w->alone = found.alone;
    w->step = step * (measure < 0.4 ? 2.0 : 0.8 / measure);
    if (step == rest) {
      w->at.f = next.f;
      w->done = 1.0;
      return PLATFORM_PROVED;
    }
    w->at = next;
    w->done += step;
    if (!whole.central) evaluate(g, &w->at);
    defect = linearize(&w->at, inverse);
    w->sigma = least(g, &w->at.f, to, inverse, defect);
  }
  return PLATFORM_TRIES_SPENT;
}

static int follow(const geometry *g, const double *values, platform_state *state,
                  platform_report *report) {
  walk w = {0};
  double first[6], last[6], error = state->error / g->reach;
  int k, status;
  if (report) report->fraction = report->sigma = report->alone = 0.0, report->steps = report->tries = 0;
  status = in_units(g, values, last);
  if (!load(g, &state->pose, &w.at.f) || !(error >= 0.0)) status = PLATFORM_NOT_FINITE;
  for (k = 0; k < 6; ++k) {
    first[k] = (state->values[k] + g->offset[k]) * g->unit[k];
    if (!(first[k] - first[k] == 0.0)) status = PLATFORM_NOT_FINITE;
  }
  if (status) return status;
  w.error = error + rounded(g, &w.at.f);
#if HAS_DLL
  if (!orient(g, &w.at.f, w.error, first, last)) return PLATFORM_SINGULAR;
#endif
  w.step = 1.0;
  w.most_tries = PLATFORM_TRIES;
  w.shortest = SHORTEST;
  status = chase(g, first, last, &w);
  w.error += rounded(g, &w.at.f);
#if HAS_DLL
  if (status == PLATFORM_PROVED && !keeps_sides(g, &w.at.f, w.error, first, last)) status = PLATFORM_SINGULAR;
#endif
  if (status == PLATFORM_PROVED) {
    unload(g, &w.at.f, &state->pose);
    for (k = 0; k < 6; ++k) state->values[k] = values[k];
    state->error = g->reach * w.error;
  }
  if (report) {
    report->fraction = w.done;
    report->alone = w.alone * g->reach;
    report->steps = w.steps;
    report->tries = w.tries;
    report->sigma = w.sigma;
  }
  return status;
}

#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* From the centre of a crank, or the stated point of a slide, to the other end of its rod, in the axes
 * of the drive's body. */
static void other_end(const geometry *g, const frame *f, int k, int on_base, double *r) {
  double apart[3], y[3];
  int i;
  turn(f, g->Y[k], y);
  for (i = 0; i < 3; ++i) apart[i] = g->X[k][i] - f->T[i] - y[i];
  for (i = 0; i < 3; ++i)
    r[i] = on_base ? -apart[i] : f->R[0][i] * apart[0] + f->R[1][i] * apart[1] + f->R[2][i] * apart[2];
}

#endif
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
/* The angle at which a rod reaches its crank, the nearer one to c: |r - A cos - B sin| = rod with r
 * from the centre; zero if there is none. */
static int crank_angle(const geometry *g, const frame *f, int k, double *c) {
  const double turn_size = 6.283185307179586;
  double r[3], a, b, h, right, half, sum;
  other_end(g, f, k, g->kind[k] == BASE_CRANK, r);
  a = dot(r, g->A[k]), b = dot(r, g->B[k]), h = sqrt(a * a + b * b);
  right = 0.5 * (dot(r, r) + dot(g->A[k], g->A[k]) - g->rod[k] * g->rod[k]);
  if (!(fabs(right) <= h)) return 0;
  half = atan2(sqrt((h - right) * (h + right)), right);
  sum = atan2(b, a) - *c;
  a = sum - half, b = sum + half;
  a -= floor(a / turn_size + 0.5) * turn_size;
  b -= floor(b / turn_size + 0.5) * turn_size;
  *c += fabs(a) < fabs(b) ? a : b;
  return 1;
}

#endif
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* How far a slide goes to where its rod reaches, the nearer one to c: |r - B c| = rod with r from the
 * stated point; zero if it does not reach. */
static int slide_way(const geometry *g, const frame *f, int k, double *c) {
  double r[3], along, half;
  other_end(g, f, k, g->kind[k] == BASE_SLIDE, r);
  along = dot(r, g->B[k]);
  add(r, -along, g->B[k]);
  half = g->rod[k] * g->rod[k] - dot(r, r);
  if (!(half >= 0.0)) return 0;
  half = sqrt(half);
  *c = fabs(along - half - *c) < fabs(along + half - *c) ? along - half : along + half;
  return 1;
}
#endif

/* The number of a constraint at a frame, in the units of the equations; that of a crank or slide is the
 * one nearer to c. */
static int number(const geometry *g, const frame *f, int k, double *c) {
  placed p;
#if HAS_DLL || HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
  double n[3] = {0.0, 0.0, 0.0};
#endif
  place(g, f, k, g->Y[k], g->X[k], &p);
#if HAS_DLL || HAS_ALL || HAS_ALH || HAS_AHL || HAS_AHH
  if (g->kind[k] >= DLL) cross(p.w, g->V[k], n);
#endif
  switch (g->kind[k]) {
#if HAS_DPP || HAS_DPL || HAS_DLP
    default:
      c[k] = length(p.r);
      break;
#endif
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK
    case BASE_CRANK:
    case PLATFORM_CRANK:
      if (!(c[k] - c[k] == 0.0)) c[k] = 0.0;
      if (!crank_angle(g, f, k, c + k)) return PLATFORM_RANGE;
      break;
#endif
#if HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    case BASE_SLIDE:
    case PLATFORM_SLIDE:
      if (!(c[k] - c[k] == 0.0)) c[k] = 0.0;
      if (!slide_way(g, f, k, c + k)) return PLATFORM_RANGE;
      break;
#endif
#if HAS_DPH
    case DPH:
      c[k] = dot(p.r, g->V[k]);
      break;
#endif
#if HAS_DHP
    case DHP:
      c[k] = -dot(p.r, p.w);
      break;
#endif
#if HAS_DLL
    case DLL:
      c[k] = fabs(dot(p.r, n)) / length(n);
      if (!(c[k] - c[k] == 0.0)) return PLATFORM_SINGULAR; /* parallel lines */
      break;
#endif
#if HAS_ALL || HAS_AHH
    case ALL:
    case AHH:
      c[k] = atan2(length(n), g->kind[k] == AHH ? -dot(p.w, g->V[k]) : dot(p.w, g->V[k]));
      break;
#endif
#if HAS_ALH || HAS_AHL
    case ALH:
    case AHL:
      c[k] = atan2(dot(p.w, g->V[k]), length(n));
      break;
#endif
  }
  return PLATFORM_PROVED;
}

#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
/* Is a value that no drive changes the stated one? */
static int stays(const geometry *g, int k, double value) {
#if HAS_DPH || HAS_DHP
  if (g->either[k]) value = fabs(value);
#endif
  return value >= g->lowest[k] && value <= g->highest[k];
}
#endif

static int measure(const geometry *g, const platform_pose *pose, double *values) {
  frame f;
  int k;
  if (!load(g, pose, &f)) return PLATFORM_NOT_FINITE;
  for (k = 0; k < 6; ++k) {
    double c[6];
    int status;
    c[k] = (values[k] + g->offset[k]) * g->unit[k];
    status = number(g, &f, k, c);
    if (status) return status;
    values[k] = c[k] / g->unit[k] - g->offset[k];
#if HAS_BASE_CRANK || HAS_PLATFORM_CRANK || HAS_BASE_SLIDE || HAS_PLATFORM_SLIDE
    if (!stays(g, k, c[k] / g->unit[k])) return PLATFORM_RANGE;
#endif
  }
  return PLATFORM_PROVED;
}

static int differentiate(const geometry *g, const platform_pose *pose, const double *values,
                         double (*J)[6]) {
  frame f;
  setting at;
  double c[6], F[6], shift[3];
  int i, k;
  if (!load(g, pose, &f)) return PLATFORM_NOT_FINITE;
  for (k = 0; k < 6; ++k) {
    double value = values[k] + g->offset[k];
    if (!(value - value == 0.0)) return PLATFORM_NOT_FINITE;
    c[k] = value * g->unit[k];
  }
#if HAS_DLL
  {
    double same[6];
    for (k = 0; k < 6; ++k) same[k] = c[k];
    (void)orient(g, &f, 0.0, c, same);
  }
#endif
  set(g, c, &at);
  equations(g, &f, &at, F, J);
  turn(&f, g->middle, shift);
  for (k = 0; k < 6; ++k) {
    double moment[3], scale = slope(g, &f, k, c) * g->unit[k];
#if HAS_DLL
    if (c[k] < 0.0 && g->kind[k] == DLL) scale = -scale;
#endif
    if (!(fabs(scale) > 1e-12 * g->unit[k])) return PLATFORM_SINGULAR; /* a distance or sine of zero */
    scale = -1.0 / scale;
    cross(shift, J[k] + 3, moment);
    for (i = 0; i < 3; ++i) {
      J[k][i] = scale * (J[k][i] + moment[i] * (1.0 / g->reach));
      J[k][i + 3] *= scale * (1.0 / g->reach);
    }
  }
  return PLATFORM_PROVED;
}

/* With cranks and slides as near as can be to the given values; those of the pose are there then. */
static int begin_near(const geometry *g, const platform_pose *pose, double *values, platform_state *state,
                      platform_report *report) {
  double c[6], inverse[6][6], defect;
  knot at;
  segment still;
  proof found = {8.0, 0.0, 0.0, 0.0};
  int k, status = measure(g, pose, values);
  if (status || !load(g, pose, &at.f)) return status;
#if HAS_DLL
  for (k = 0; k < 6; ++k) /* lines that meet */
    if (g->kind[k] == DLL && moment_of(g, &at.f, k, 0.0) == 0.0) values[k] = -g->offset[k];
#endif
  for (k = 0; k < 6; ++k) c[k] = (values[k] + g->offset[k]) * g->unit[k];
#if HAS_DLL
  {
    double same[6];
    for (k = 0; k < 6; ++k) same[k] = c[k];
    (void)orient(g, &at.f, 0.0, c, same);
  }
#endif
  set(g, c, &at.at);
  evaluate(g, &at);
  defect = linearize(&at, inverse);
  still.start = still.end = &at, still.central = 0;
  if (defect < 0.5) found = attempt(g, &still, inverse, defect);
  if (!(found.measure < 1.0)) found.error = found.alone = 0.0;
  state->pose = *pose;
  state->error = g->reach * (found.error + rounded(g, &at.f));
  for (k = 0; k < 6; ++k) state->values[k] = values[k];
  if (report) {
    report->fraction = found.measure < 1.0 ? 1.0 : 0.0;
    report->sigma = least(g, &at.f, c, inverse, defect);
    report->alone = found.alone * g->reach;
    report->steps = report->tries = 0;
  }
  return status;
}

static int begin(const geometry *g, const platform_pose *pose, platform_state *state,
                 platform_report *report) {
  double values[6];
  int k;
  for (k = 0; k < 6; ++k) values[k] = -g->offset[k];
  return begin_near(g, pose, values, state, report);
}

static const char *text(int status) {
  switch (status) {
    case PLATFORM_PROVED:
      return "proved";
    case PLATFORM_NOT_FINITE:
      return "an argument is not finite, or a quaternion is zero";
    case PLATFORM_RANGE:
      return "a value is outside its range, or a crank does not reach";
    case PLATFORM_SINGULAR:
      return "refused: too near to a singular pose, here or ahead";
    case PLATFORM_TRIES_SPENT:
      return "refused: the line of values is too long";
    case PLATFORM_NOT_FOUND:
      return "no pose within the limits was found";
    default:
      return "no status";
  }
}

#if HAS_DATA
int platform_inverse(const platform_pose *pose, double values[6]) { return measure(&data, pose, values); }

int platform_jacobian(const platform_pose *pose, const double values[6], double J[6][6]) {
  return differentiate(&data, pose, values, J);
}

int platform_start(const platform_pose *pose, platform_state *state, platform_report *report) {
  return begin(&data, pose, state, report);
}

int platform_forward(const double values[6], platform_state *state, platform_report *report) {
  return follow(&data, values, state, report);
}

const char *platform_text(int status) { return text(status); }
#endif
