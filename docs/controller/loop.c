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

int main(void) {
  const nano_hexapod_pose home = NANO_HEXAPOD_HOME;
  nano_hexapod_state state;
  nano_hexapod_report report;
  int cycle, status;
  if (nano_hexapod_start(&home, &state)) return 1;
  for (cycle = 1; cycle <= 100; ++cycle) {
    double values[6];
    read_values(cycle, values);
    status = nano_hexapod_forward(values, &state, &report);
    if (status) { /* stop the machine: the state is still the last proved pose */
      printf("cycle %d: refused (%d) after %g of the way, sigma %.3g\n", cycle, status,
             report.fraction, report.sigma);
      return 1;
    }
  }
  printf("lifted to z = %.6f m, exact within %.1e m, no other pose within %.1e m\n",
         state.pose.position[2], state.error, report.alone);
  return 0;
}
