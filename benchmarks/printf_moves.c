/* The plain way to write many moves: one printf a block.  Prints the seconds of the loop. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return 2;
    long count = atol(argv[3]);
    double *values = malloc(2 * count * sizeof *values);
    FILE *in = fopen(argv[1], "rb");
    if (!values || !in || fread(values, sizeof *values, 2 * count, in) != (size_t)(2 * count))
        return 1;
    double start = now();
    FILE *out = fopen(argv[2], "wb");
    if (!out || setvbuf(out, NULL, _IOFBF, 1 << 20))
        return 1;
    for (long i = 0; i < count; i++)
        fprintf(out, "Z%.3f F%.5f\n", values[2 * i], values[2 * i + 1]);
    if (fclose(out))
        return 1;
    printf("%.6f\n", now() - start);
    return 0;
}
