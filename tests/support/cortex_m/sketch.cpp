// Runs docs/controller/hexapod.ino on the board, and counts what a step costs: with -icount shift=0 an
// instruction takes a nanosecond, so a tick of 25 MHz is 40 instructions.
#include <stdint.h>
#include <stdio.h>

extern "C" {
void board_write(const char *text);
uint32_t board_ticks(void);
}

struct Port {
  void begin(long) {}
  void print(const char *text) { board_write(text); }
  void println(const char *text) { board_write(text), board_write("\n"); }
  void println(double x) {
    char text[32];
    snprintf(text, sizeof text, "%ld\n", static_cast<long>(x + (x < 0 ? -0.5 : 0.5)));
    board_write(text);
  }
};
static Port Serial;

#include "hexapod.ino"

extern "C" int main(void) {
  setup();
  for (int i = 0; i < 100; ++i) loop();
  if (state.pose.position[2] == home.position[2]) return 1;
  // The cost of a step of one part, and of one that spends its tries: past the singular poses.
  double values[6];
  nano_hexapod_report report;
  for (int k = 0; k < 6; ++k) values[k] = state.values[k] + 1e-6;
  uint32_t from = board_ticks();
  int status = nano_hexapod_forward(values, &state, &report);
  Serial.println(40.0 * ((from - board_ticks()) & 0xFFFFFF));
  if (status || report.tries != 1) return 2;
  for (int i = 0; i < 100 && !status; ++i) {
    for (int k = 0; k < 6; ++k) values[k] += k % 2 ? -0.01 : 0.01;
    from = board_ticks();
    status = nano_hexapod_forward(values, &state, &report);
  }
  Serial.println(40.0 * ((from - board_ticks()) & 0xFFFFFF));
  Serial.println(double(report.tries));
  return status ? 0 : 3;
}

extern "C" {
void _exit(int) { for (;;) {} }
int _sbrk(int) { return -1; }
int _write(int, const char *, int) { return -1; }
int _read(int, char *, int) { return -1; }
int _close(int) { return -1; }
int _lseek(int, int, int) { return -1; }
int _fstat(int, void *) { return -1; }
int _isatty(int) { return 0; }
int _kill(int, int) { return -1; }
int _getpid() { return 1; }
}
