/* The benchmark's sheet and sphere as a careful C programmer writes them: nodes, a list of edges, a loop over edges, a loop
 * over nodes. The same law, damage, draws, time step and impulse contact as the kernel; one thread, double precision, no
 * root and no division in the loop over edges unless "textbook" asks for them.
 *
 * Arguments: nodes_per_side steps_before file_of_segments, then h, node mass, yarn area, dt, sphere radius, sphere mass,
 * sphere speed, critical stretch, A, B, alpha_fail (SI units), and "careful" or "textbook".
 * The file holds modulus and damage rate of every segment, horizontal ones first, as doubles.
 * Prints the largest deflection (m) and the number of failed segments when the first steps are done. Then, for every number
 * on standard input: takes so many steps from that state and prints the process's CPU seconds. */

#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int n;         /* nodes per side */
static int edges;     /* segments */
static double h, dt;  /* spacing, time step */
static double *x, *v; /* positions and velocities, 3 per node */
static double *f;     /* change of velocity in this step, 3 per node */
static int *first, *second; /* nodes of an edge */
static double *k;           /* alpha E A dt / (2 h m): change of velocity per q and length */
static double *worst;       /* largest q = U^2 - 1 so far, at least the critical one */
static double *modulus, *rate;
static double stiffness; /* k over alpha E */
static double critical_stretch, damage_a, damage_b, alpha_fail;
static double radius, node_mass, body_mass, body_z, body_speed;
static int failed;

static void *allocate(size_t count, size_t size)
{
    void *place = calloc(count, size);
    if (!place) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return place;
}

/* A new maximum of the stretch beyond the critical one. */
static void damage(int e, double q)
{
    double alpha = damage_a * (exp(-rate[e] * (sqrt(1.0 + q) - critical_stretch)) - damage_b);
    if (alpha > 1.0)
        alpha = 1.0;
    if (alpha <= alpha_fail) {
        failed++;
        worst[e] = HUGE_VAL;
        k[e] = 0.0;
    } else {
        worst[e] = q;
        k[e] = alpha * modulus[e] * stiffness;
    }
}

static void forces_careful(void)
{
    const double inverse = 1.0 / (h * h);
    const double *restrict p = x;
    double *restrict to = f;
    for (int e = 0; e < edges; e++) {
        const int a = 3 * first[e], b = 3 * second[e];
        const double dx = p[b] - p[a], dy = p[b + 1] - p[a + 1], dz = p[b + 2] - p[a + 2];
        const double q = (dx * dx + dy * dy + dz * dz) * inverse - 1.0;
        if (q > worst[e])
            damage(e, q);
        const double s = k[e] * (q > 0.0 ? q : 0.0);
        to[a] += s * dx, to[a + 1] += s * dy, to[a + 2] += s * dz;
        to[b] -= s * dx, to[b + 1] -= s * dy, to[b + 2] -= s * dz;
    }
}

/* As the formulas stand in a textbook: length, stretch, strain, force along the unit vector. */
static void forces_textbook(void)
{
    for (int e = 0; e < edges; e++) {
        const int a = 3 * first[e], b = 3 * second[e];
        const double dx = x[b] - x[a], dy = x[b + 1] - x[a + 1], dz = x[b + 2] - x[a + 2];
        const double length = sqrt(dx * dx + dy * dy + dz * dz);
        const double stretch = length / h;
        if (stretch > 1.0) {
            const double q = stretch * stretch - 1.0;
            if (q > worst[e])
                damage(e, q);
            const double s = k[e] * q * stretch * h / length;
            f[a] += s * dx, f[a + 1] += s * dy, f[a + 2] += s * dz;
            f[b] -= s * dx, f[b + 1] -= s * dy, f[b + 2] -= s * dz;
        }
    }
}

static void (*forces)(void);

/* Impulse contact of one node with the free sphere, without restitution, before the node moves. */
static void touch(int node, double r2)
{
    double *u = v + 3 * node;
    const double *p = x + 3 * node;
    const double distance = sqrt(r2), gap = distance - radius;
    const double nx = p[0] / distance, ny = p[1] / distance, nz = (p[2] - body_z) / distance;
    const double approach = (gap > 0.0 ? gap : 0.0) / dt + nx * u[0] + ny * u[1] + nz * (u[2] - body_speed);
    if (approach < 0.0) {
        const double impulse = -approach / (1.0 / node_mass + 1.0 / body_mass);
        u[0] += nx * impulse / node_mass, u[1] += ny * impulse / node_mass, u[2] += nz * impulse / node_mass;
        body_speed -= nz * impulse / body_mass;
    }
}

/* The four sides are held. */
static void move(void)
{
    const double reach2 = (radius + h) * (radius + h);
    for (int j = 1; j < n - 1; j++) {
        for (int i = 1; i < n - 1; i++) {
            const int node = j * n + i;
            double *restrict p = x + 3 * node, *restrict u = v + 3 * node, *restrict c = f + 3 * node;
            u[0] += c[0], u[1] += c[1], u[2] += c[2];
            c[0] = c[1] = c[2] = 0.0;
            const double dz = p[2] - body_z, r2 = p[0] * p[0] + p[1] * p[1] + dz * dz;
            if (r2 < reach2)
                touch(node, r2);
            p[0] += dt * u[0], p[1] += dt * u[1], p[2] += dt * u[2];
        }
    }
    body_z += dt * body_speed;
}

static void advance(long steps)
{
    for (long step = 0; step < steps; step++) {
        forces();
        move();
    }
}

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

/* Everything that a step changes, kept so that every round starts from the same state. */
static size_t state_size(void)
{
    return sizeof(double) * (6 * (size_t)n * n + 2 * (size_t)edges + 2);
}

static void copy_state(char *image, int out)
{
    void *parts[] = {x, v, k, worst, &body_z, &body_speed};
    const size_t nodes = 3 * sizeof(double) * (size_t)n * n, segments = sizeof(double) * (size_t)edges;
    const size_t sizes[] = {nodes, nodes, segments, segments, sizeof(double), sizeof(double)};
    for (int part = 0; part < 6; part++) {
        memcpy(out ? (void *)image : parts[part], out ? parts[part] : (void *)image, sizes[part]);
        image += sizes[part];
    }
}

int main(int count, char **arguments)
{
    if (count != 16) {
        fprintf(stderr, "see the top of plain.c\n");
        return 2;
    }
    n = atoi(arguments[1]);
    const long before = atol(arguments[2]);
    double numbers[11];
    for (int i = 0; i < 11; i++)
        numbers[i] = atof(arguments[4 + i]);
    h = numbers[0], node_mass = numbers[1], dt = numbers[3], radius = numbers[4], body_mass = numbers[5];
    body_speed = numbers[6], critical_stretch = numbers[7];
    damage_a = numbers[8], damage_b = numbers[9], alpha_fail = numbers[10];
    stiffness = numbers[2] * dt / (2.0 * h * node_mass);
    body_z = -radius;
    forces = strcmp(arguments[15], "textbook") ? forces_careful : forces_textbook;

    const size_t nodes = (size_t)n * n;
    edges = 2 * n * (n - 1);
    x = allocate(3 * nodes, sizeof(double)), v = allocate(3 * nodes, sizeof(double));
    f = allocate(3 * nodes, sizeof(double));
    first = allocate(edges, sizeof(int)), second = allocate(edges, sizeof(int));
    k = allocate(edges, sizeof(double)), worst = allocate(edges, sizeof(double));
    modulus = allocate(edges, sizeof(double)), rate = allocate(edges, sizeof(double));

    FILE *file = fopen(arguments[3], "rb");
    double *drawn = allocate(2 * (size_t)edges, sizeof(double));
    if (!file || fread(drawn, sizeof(double), 2 * (size_t)edges, file) != 2 * (size_t)edges) {
        fprintf(stderr, "cannot read %s\n", arguments[3]);
        return 1;
    }
    fclose(file);
    /* Edges in the order of their first nodes, so that both loops walk through memory once. */
    int e = 0;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) {
            const int node = j * n + i;
            x[3 * node] = (i - 0.5 * (n - 1)) * h, x[3 * node + 1] = (j - 0.5 * (n - 1)) * h;
            for (int axis = 0; axis < 2; axis++) {
                if (axis == 0 ? i + 1 == n : j + 1 == n)
                    continue;
                const int number = axis == 0 ? j * (n - 1) + i : n * (n - 1) + node;
                first[e] = node, second[e] = axis == 0 ? node + 1 : node + n;
                modulus[e] = drawn[2 * number], rate[e] = drawn[2 * number + 1];
                k[e] = modulus[e] * stiffness;
                worst[e] = (critical_stretch - 1.0) * (critical_stretch + 1.0);
                e++;
            }
        }
    }
    free(drawn);

    advance(before);
    double deflection = 0.0;
    for (size_t i = 0; i < nodes; i++)
        deflection = fmax(deflection, fabs(x[3 * i + 2]));
    char *image = allocate(state_size(), 1);
    copy_state(image, 1);
    printf("ready %.17g %d\n", deflection, failed);
    fflush(stdout);

    long steps;
    while (scanf("%ld", &steps) == 1) {
        copy_state(image, 0);
        const double start = cpu_seconds();
        advance(steps);
        printf("%.9g\n", cpu_seconds() - start);
        fflush(stdout);
    }
    return 0;
}
