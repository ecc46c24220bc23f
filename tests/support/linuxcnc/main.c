/* Calls the module as LinuxCNC does: inverse and forward there and back, and past a fold. */
#include <stdio.h>

#include "hal.h"
#include "kinematics.h"
#include "rtapi_app.h"

int hal_init(const char *name) { return name ? 1 : -1; }
int hal_ready(int component) { return component - 1; }
int hal_exit(int component) { return component - 1; }

int main(void) {
  EmcPose world = {{0.0, 0.0, 20.0}, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, found = world;
  double joints[6], worst = 0.0;
  int cycle, refused = 0;
  if (rtapi_app_main() || kinematicsType() != KINEMATICS_BOTH) return 1;
  for (cycle = 0; cycle < 200; ++cycle) {
    double off;
    world.tran.x = 0.01 * cycle, world.a = 0.05 * cycle, world.c = -0.04 * cycle;
    if (kinematicsInverse(&world, joints, 0, 0)) return 2;
    if (kinematicsForward(joints, &found, 0, 0)) return 3;
    off = (found.tran.x - world.tran.x) * (found.tran.x - world.tran.x) +
          (found.a - world.a) * (found.a - world.a) + (found.c - world.c) * (found.c - world.c);
    if (off > worst) worst = off;
  }
  for (cycle = 0; cycle < 1000 && !refused; ++cycle) {
    joints[0] += 0.05;
    refused = kinematicsForward(joints, &found, 0, 0);
  }
  rtapi_app_exit();
  printf("%d %d\n", worst < 1e-18, refused);
  return 0;
}
