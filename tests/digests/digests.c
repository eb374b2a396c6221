/* Runs every scene of scenes.h through the C interface and prints a line "name digest" each: the same file on every
 * target of `cargo xtask digests`, with or without an operating system. All memory is static. */
#include "fabric_kernel.h"
#include "scenes.h"

/* Given by the machine, at the end of this file or as an import of WebAssembly: puts out a text that ends with 0. */
void write_text(const char *text);

/* Prints a line for every scene. 0 if all ran. */
int print_digests(void);

/* Only in libraries built with the feature `choose-instructions`: FK_UNKNOWN_CHOICE if this machine lacks the set. */
int32_t fk_use_instructions(fk_sim *sim, uint32_t set);

/* What the largest scene needs, and some more. */
static unsigned char memory[6 << 16];

static int said(const char *name, const char *what, int32_t status)
{
    write_text(name);
    write_text(": ");
    write_text(what);
    write_text(": ");
    write_text(fk_status_name(status));
    write_text("\n");
    return 1;
}

int print_digests(void)
{
    int i, digit;
    for (i = 0; i < TEST_SCENES; i++) {
        const test_scene *test = &test_scenes[i];
        fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
        fk_sim *sim = 0;
        uint64_t digest = 0;
        char text[18];
        int32_t status;
        test->change(&scene);
        status = fk_init(memory, sizeof memory, &scene, &sim, 0, 0);
        if (status != FK_OK)
            return said(test->name, "init", status);
#ifdef INSTRUCTIONS
        status = fk_use_instructions(sim, INSTRUCTIONS);
        if (status != FK_OK)
            return said(test->name, "this machine lacks the instructions", status);
#endif
        status = test_run(sim, &scene, test->steps);
        if (status != FK_OK)
            return said(test->name, "run", status);
        status = fk_digest(sim, &digest);
        if (status != FK_OK)
            return said(test->name, "digest", status);
        for (digit = 0; digit < 16; digit++)
            text[digit] = "0123456789abcdef"[digest >> (60 - 4 * digit) & 15];
        text[16] = '\n';
        text[17] = 0;
        write_text(test->name);
        write_text(" ");
        write_text(text);
    }
    return 0;
}

#if __STDC_HOSTED__ /* under an operating system, by a host that rounds as ROUNDING says, which must not matter */
#include <fenv.h>
#include <stdio.h>

#ifndef ROUNDING
#define ROUNDING FE_TONEAREST
#endif

void write_text(const char *text)
{
    fputs(text, stdout);
}

int main(void)
{
    return fesetround(ROUNDING) == 0 ? print_digests() : 1;
}

#elif defined __thumb__ /* on a bare Cortex-M7, with the start-up code of examples/cortex-m7 */
#include "board.h"

void write_text(const char *text)
{
    board_write(text);
}

int main(void)
{
    return print_digests();
}

#elif defined __x86_64__ /* on Linux without a C library or anything else: write and exit are system calls */
#include <stddef.h>

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

/* The four functions that the library asks of its host. Compile with -fno-builtin -fno-tree-loop-distribute-patterns, or the
 * compiler makes of each loop a call of the function itself. */
void *memcpy(void *to, const void *from, size_t bytes)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    while (bytes-- > 0)
        *t++ = *f++;
    return to;
}

void *memmove(void *to, const void *from, size_t bytes)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    if (t < f)
        return memcpy(to, from, bytes);
    while (bytes-- > 0)
        t[bytes] = f[bytes];
    return to;
}

void *memset(void *to, int value, size_t bytes)
{
    unsigned char *t = to;
    while (bytes-- > 0)
        *t++ = (unsigned char)value;
    return to;
}

int memcmp(const void *one, const void *other, size_t bytes)
{
    const unsigned char *a = one, *b = other;
    for (; bytes > 0; a++, b++, bytes--)
        if (*a != *b)
            return *a < *b ? -1 : 1;
    return 0;
}

#endif
