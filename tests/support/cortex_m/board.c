/* A board with a Cortex-M7 for qemu-system-arm (mps2-an500): start, semihosting, a clock. */
#include <stdint.h>

extern uint32_t __data_start, __data_end, __data_from, __bss_start, __bss_end, __stack;
int main(void);
void board_exit(int code);

static void stop(void) { board_exit(99); }

void reset(void) {
  uint32_t *from = &__data_from, *to;
  for (to = &__data_start; to < &__data_end; ++to) *to = *from++;
  for (to = &__bss_start; to < &__bss_end; ++to) *to = 0;
  *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* the floating-point unit */
  __asm volatile("dsb; isb");
  *(volatile uint32_t *)0xE000E014 = 0xFFFFFF; /* the counter of the system */
  *(volatile uint32_t *)0xE000E018 = 0;
  *(volatile uint32_t *)0xE000E010 = 5;
  board_exit(main());
}

__attribute__((section(".vectors"), used)) void *const vectors[16] = {
    &__stack, (void *)reset, (void *)stop, (void *)stop, (void *)stop, (void *)stop, (void *)stop};

static int call(int operation, const void *argument) {
  register int r0 __asm("r0") = operation;
  register const void *r1 __asm("r1") = argument;
  __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}
void board_write(const char *text) { call(0x04, text); }
void board_exit(int code) {
  uint32_t block[2] = {0x20026, (uint32_t)code};
  call(0x20, block);
  for (;;) {
  }
}
/* Ticks of the 25 MHz of the board, downwards. */
uint32_t board_ticks(void) { return *(volatile uint32_t *)0xE000E018; }
