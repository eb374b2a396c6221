/* What the examples need of a bare Cortex-M7: start-up, text through semihosting, a count of ticks. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Puts out a text that ends with 0, through the debugger or emulator (semihosting). */
void board_write(const char *text);

/* Starts the system timer at its largest period. */
void board_timer_start(void);

/* Ticks of the processor clock since the last call; right if fewer than 2^24 have passed. */
uint32_t board_timer_ticks(void);

/* The program. Its result is the exit code. */
int main(void);

#endif
