/* Starts digests.c on a bare Cortex-M7, with the start-up code of examples/cortex-m7. */
#include "board.h"
#include "digests.h"

void write_text(const char *text)
{
    board_write(text);
}

int main(void)
{
    return print_digests();
}
