/* What the two call-state programs share: a table of calls against states, and calls with bad arguments.

   Each cell of the first table is one of
     +  allowed by the standard: OK
     k  not listed by the standard, answered all the same (the reason stands with the table): OK
     D  Discard, and nothing changed
     -  not allowed in this state: Error, one message of that status, nothing changed
     u  allowed only with a capability that this FMU does not state: as -
     e  listed by the standard, refused all the same (the reason stands with the table): as -
   "Nothing changed" is: the bytes of the serialised state before and after are equal. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, ERROR };

typedef struct {
    const char *name;
    int (*call)(void);
    const char *states;
} Row;

/* Of the program that includes this: an instance in state number k (0 ends the life of the last one), and its image. */
static void reach(int state);
static size_t image(unsigned char **bytes);
static int image_possible(int state);

static int messages, last_status; /* what the logger was told since the last call */
static int checks, failures;

static void expect(int holds, const char *name, const char *state, const char *what) {
    checks++;
    if (!holds) {
        failures++;
        printf("%s in %s: %s\n", name, state, what);
    }
}

static unsigned char *before; /* the image before a call that must be refused */
static size_t before_bytes;

static void look_before(int compare) {
    before_bytes = compare ? image(&before) : 0;
    messages = 0;
}

/* What a call has answered that must be refused with `status`: that, one message of that status, and the same image as before. */
static void refused(const char *name, const char *state, int answer, int status, int compare, int logger) {
    unsigned char *after = NULL;
    expect(answer == status, name, state, status == ERROR ? "not refused with Error" : "not discarded");
    if (logger) expect(messages == 1 && last_status == status, name, state, "not one message of that status");
    if (compare) expect(image(&after) == before_bytes && !memcmp(before, after, before_bytes), name, state, "something has changed");
    free(before);
    free(after);
    before = NULL;
}

static void refused_call(const char *name, const char *state, int (*call)(void), int status, int compare, int logger) {
    look_before(compare);
    refused(name, state, call(), status, compare, logger);
}

/* A call with a bad argument, refused with `status`. */
#define MISUSE(what, status, call) \
    look_before(1);                \
    refused(what, "misuse", call, status, 1, logger_given);

static void check_table(const Row *rows, size_t count, const char *const *states, int logger) {
    for (size_t r = 0; r < count; r++) {
        for (int s = 0; states[s]; s++) {
            reach(s);
            char cell = rows[r].states[2 * s];
            messages = 0;
            switch (cell) {
                case '+':
                case 'k': expect(rows[r].call() == OK, rows[r].name, states[s], "not OK"); break;
                case 'D': refused_call(rows[r].name, states[s], rows[r].call, DISCARD, 1, logger); break;
                case '-':
                case 'u':
                case 'e': refused_call(rows[r].name, states[s], rows[r].call, ERROR, image_possible(s), logger); break;
                default: expect(0, rows[r].name, states[s], "no such cell");
            }
        }
    }
    reach(-1);
}

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define NOT_A_NUMBER (0.0 / zero)
static double zero = 0.0;
