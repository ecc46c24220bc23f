// A sketch for a Teensy 4 (Cortex-M7 with doubles in hardware): proved poses, and what they cost.
//
//   gsp export @nano-hexapod --to c --mode 8 -o nano_hexapod.c     # both files into the folder of the sketch
#include "nano_hexapod.h"

static nano_hexapod_state state;
static const nano_hexapod_pose home = NANO_HEXAPOD_HOME;
static int cycle;

void setup() {
  Serial.begin(115200);
  if (nano_hexapod_start(&home, &state, 0)) Serial.println("no start");
}

void loop() {
  nano_hexapod_pose goal = home;
  nano_hexapod_report report;
  double values[6];
  goal.position[2] += 1e-5 * ++cycle;  // stands for the encoders
  nano_hexapod_inverse(&goal, values);
  const int status = nano_hexapod_forward(values, &state, &report);
  if (status) {
    Serial.print("stop the motors: ");
    Serial.println(nano_hexapod_text(status));
    return;
  }
  if (cycle % 100 == 0) Serial.println(state.pose.position[2] * 1e6);  // micrometres
}
