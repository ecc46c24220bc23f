/* A control loop: the pose of each set of measured values, proved, or what to do if it is not.
 *
 *   gsp export @nano-hexapod --to c --mode 8 -o nano_hexapod.c
 *   cc -std=c99 -O2 loop.c nano_hexapod.c -lm -o loop && ./loop */
#include <stdio.h>

#include "nano_hexapod.h"

/* Stands for the encoders: the platform is lifted by 1 mm and turned by a degree in 100 cycles. */
static void read_values(int cycle, double values[6]) {
  const nano_hexapod_pose home = NANO_HEXAPOD_HOME;
  nano_hexapod_pose pose = home;
  pose.position[2] += 1e-5 * cycle;
  pose.rotation[3] += 8.7e-5 * cycle;
  nano_hexapod_inverse(&pose, values);
}

/* forward, and the same straight line in shorter steps where one step is not proved. */
static int advance(const double values[6], nano_hexapod_state *state, nano_hexapod_report *report) {
  const nano_hexapod_state start = *state;
  int part, k, status = nano_hexapod_forward(values, state, report);
  if (status != NANO_HEXAPOD_TRIES_SPENT) return status;
  for (part = 1, status = 0; part <= 16 && !status; ++part) {
    double goal[6];
    for (k = 0; k < 6; ++k)
      goal[k] = part == 16 ? values[k] : start.values[k] + part / 16.0 * (values[k] - start.values[k]);
    status = nano_hexapod_forward(goal, state, report);
  }
  return status;
}

int main(void) {
  const nano_hexapod_pose home = NANO_HEXAPOD_HOME;
  nano_hexapod_state state;
  nano_hexapod_report report;
  int cycle, status;
  if (nano_hexapod_start(&home, &state, &report) || report.fraction < 1.0) return 1;
  for (cycle = 1; cycle <= 100; ++cycle) {
    double values[6];
    read_values(cycle, values);
    status = advance(values, &state, &report);
    if (status == NANO_HEXAPOD_NOT_FINITE) continue; /* a reading is lost: go on with the next one */
    if (status) { /* stop the machine, and go back to state.values: that pose is proved */
      printf("cycle %d: %s, after %g of the way, sigma %.3g\n", cycle, nano_hexapod_text(status),
             report.fraction, report.sigma);
      return 1;
    }
  }
  printf("lifted to z = %.6f m, exact within %.1e m, no other pose within %.1e m\n",
         state.pose.position[2], state.error, report.alone);
  return 0;
}
