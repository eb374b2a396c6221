/* Starts digests.c under an operating system; the host rounds as ROUNDING says, which must not matter. */
#include "digests.h"

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
