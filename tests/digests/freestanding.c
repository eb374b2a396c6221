/* Starts digests.c on x86-64 Linux without a C library or anything else: write and exit are system calls. */
#include "digests.h"

static long call(long number, long a, long b, long c)
{
    long result;
    __asm__ volatile("syscall" : "=a"(result) : "a"(number), "D"(a), "S"(b), "d"(c) : "rcx", "r11", "memory");
    return result;
}

void write_text(const char *text)
{
    long length = 0;
    while (text[length] != 0)
        length++;
    call(1, 1, (long)text, length);
}

/* The kernel enters here with a stack aligned to 16 bytes and no return address. */
__attribute__((force_align_arg_pointer, noreturn)) void _start(void)
{
    call(60, print_digests(), 0, 0);
    __builtin_unreachable();
}
