/* Start-up code for a Cortex-M7 with double-precision floating point. Nothing here is particular to one board: registers of
 * the core only, and text through semihosting. The memory map is in an500.ld. */
#include "board.h"

extern uint32_t stack_top, data_from, data_start, data_end, bss_start, bss_end;

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define CPACR REGISTER(0xE000ED88)
#define SYST_CSR REGISTER(0xE000E010)
#define SYST_RVR REGISTER(0xE000E014)
#define SYST_CVR REGISTER(0xE000E018)

/* Asks the debugger or emulator for something. */
static uint32_t semihost(uint32_t operation, uint32_t argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uint32_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_write(const char *text)
{
    semihost(0x04 /* SYS_WRITE0 */, (uint32_t)text);
}

/* Ends the program: successfully or not. */
static void board_exit(int code)
{
    for (;;)
        semihost(0x18 /* SYS_EXIT */, code == 0 ? 0x20026 /* application exit */ : 0x20023 /* run-time error */);
}

void board_timer_start(void)
{
    SYST_RVR = 0xFFFFFF;
    SYST_CVR = 0;
    SYST_CSR = 5; /* on, with the processor clock, without interrupts */
    board_timer_ticks();
}

uint32_t board_timer_ticks(void)
{
    static uint32_t last;
    uint32_t now = SYST_CVR, ticks = (last - now) & 0xFFFFFF;
    last = now;
    return ticks;
}

static void fault(void)
{
    board_write("fault\n");
    board_exit(1);
}

void reset(void);
void reset(void)
{
    uint32_t *from, *to;
    CPACR |= 0xFu << 20; /* floating point on, before its first instruction */
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    for (from = &data_from, to = &data_start; to < &data_end;)
        *to++ = *from++;
    for (to = &bss_start; to < &bss_end;)
        *to++ = 0;
    board_exit(main());
}

/* First the stack, then where to begin, then the faults. */
__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    &stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};
