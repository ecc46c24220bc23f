/* Random and spoilt arguments, for sanitizers: -DPREFIX=name -DSOURCE='"name.c"'. */
#include SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CAT2(a, b) a##b
#define CAT(a, b) CAT2(a, b)
#define PUBLIC(name) CAT(PREFIX, name)

static double any(void) { return 2.0 * rand() / RAND_MAX - 1.0; }

int main(void) {
  const double spoilt[8] = {0.0, -0.0, 1e308, -1e308, 1e-320, NAN, INFINITY, -INFINITY};
  long count[5] = {0, 0, 0, 0, 0}, i;
  int k;
  for (i = 0; i < 20000; ++i) {
    PUBLIC(_state) s, old;
    PUBLIC(_pose) p;
    PUBLIC(_report) r;
    double v[6], J[6][6], *numbers = (double *)&s;
    int e;
    for (k = 0; k < 3; ++k) p.position[k] = data.reach * any();
    for (k = 0; k < 4; ++k) p.rotation[k] = any();
    memset(&s, 0, sizeof s);
    e = PUBLIC(_start)(&p, &s, i % 2 ? &r : 0);
    if (e) continue;
    if (i % 2 && !(r.sigma >= 0.0 && r.alone >= 0.0)) return 5;
    for (k = 0; k < 6; ++k) v[k] = s.values[k] + 0.02 * any() / data.unit[k];
    if (i % 4 == 0) numbers[rand() % 14] = spoilt[rand() % 8];
    if (i % 4 == 1) v[rand() % 6] = spoilt[rand() % 8];
    old = s;
    e = PUBLIC(_forward)(v, &s, i % 3 ? &r : 0);
    if (e < 0 || e > 4) return 1;
    ++count[e];
    if (e && memcmp(&s, &old, sizeof s)) return 2;
    for (k = 0; !e && k < 14; ++k)
      if (!(fabs(numbers[k]) < 1e12)) return 3;
    if (e == 0 && i % 4 == 1 && v[0] != v[0]) return 4;
    PUBLIC(_jacobian)(&s.pose, s.values, J);
    PUBLIC(_inverse)(&s.pose, v);
  }
  printf("%ld %ld %ld %ld %ld\n", count[0], count[1], count[2], count[3], count[4]);
  return 0;
}
