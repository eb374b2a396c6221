/* A shield as a table: what is left of a fragment, in some ten nanoseconds and without the library, for a real-time host.
 *
 *     fabric-fragments cylinder.toml --velocities 20 30 40 50 60 --shots 8 --table     writes fragments/table.h
 *
 * fragment_table.h beside this file was written so. Linear between velocities; beyond the ends the ends are kept. */
#include "fragment_table.h"
#include <stdio.h>

/* The value of a row at this velocity, m/s. */
static double interpolated(const double *row, double velocity)
{
    int k = 1;
    double part;
    while (k < FRAGMENT_VELOCITIES - 1 && velocity > fragment_velocity[k])
        k++;
    part = (velocity - fragment_velocity[k - 1]) / (fragment_velocity[k] - fragment_velocity[k - 1]);
    part = part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
    return row[k - 1] + part * (row[k] - row[k - 1]);
}

int main(void)
{
    const double velocity = 45.0;
    int k;
    for (k = 0; k < FRAGMENT_CASES; k++)
        printf("case %d at %.0f m/s: through with probability %.2f, %.2f J left on average\n", k, velocity,
               interpolated(fragment_through[k], velocity), interpolated(fragment_left[k], velocity));
    return 0;
}
