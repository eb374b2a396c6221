/* Starts digests.c under an operating system. */
#include "digests.h"

#include <stdio.h>

void write_text(const char *text)
{
    fputs(text, stdout);
}

int main(void)
{
    return print_digests();
}
