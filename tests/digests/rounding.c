/* Linked to the firmware of examples/cortex-m7 with --wrap=main: a host that rounds upwards and flushes subnormals to zero. */
#include <stdint.h>

enum { UPWARDS_AND_FLUSHING = 0x01400000, CONTROL = 0x03C00000 };

int __real_main(void);
int __wrap_main(void);

int __wrap_main(void)
{
    uint32_t after;
    int status;
    __asm__ volatile("vmsr fpscr, %0" ::"r"(UPWARDS_AND_FLUSHING));
    status = __real_main();
    __asm__ volatile("vmrs %0, fpscr" : "=r"(after));
    return (after & CONTROL) == UPWARDS_AND_FLUSHING ? status : 1;
}
