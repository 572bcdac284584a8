/* A HAL component: the laser barrier of chipbreak.lasersim in front of the simulated machine's spindle.
 *
 * Tools come from a table of numbers that Python writes (laser.py): for each its gauge length, its number of
 * teeth, what it is, and rows of heights with the radius of the hollow and the radius and angle of each edge.
 * The pin "select" says which of them is in the spindle; a negative number blocks the beam.
 *
 * The headers of HAL are in a package of their own, so the few functions used are declared here.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

enum { IN = 16, OUT = 32 };
enum { TEETH = 12 };

int hal_init(const char *name);
int hal_ready(int id);
void *hal_malloc(long size);
int hal_pin_float_newf(int way, volatile double **pin, int id, const char *format, ...);
int hal_pin_bit_newf(int way, volatile bool **pin, int id, const char *format, ...);
int hal_export_funct(const char *name, void (*run)(void *, long), void *data, int fp, int again, int id);

struct tool {
    double gauge, teeth, core, is_missing, runout, runout_rad, step, count;
    const double *rows;
};

struct pins {
    volatile double *x, *y, *z, *select, *orient_angle, *speed;
    volatile bool *turns, *orient, *is_oriented, *broken, *looks_for_gap;
};

enum { PULSE_MS = 10, GAP_MS = 15 }; /* how long the signal stays, and how long it waits for an edge */

static const double beam_x = BEAM_X, beam_y = BEAM_Y, beam_z = BEAM_Z, focus_half = FOCUS_HALF;
static struct tool *tools;
static int tool_count;
static double angle_rad, turned_rad; /* now, and how far since the last look */
static int since_edge_ms = 1000;

/* One column of a tool's rows at a height; above the last row nothing changes any more. */
static double column(const struct tool *tool, double height, int index)
{
    int width = 1 + 2 * (int)tool->teeth, last = (int)tool->count - 1;
    double at = height / tool->step;
    int low = (int)floor(at);
    if (low >= last)
        return tool->rows[last * width + index];
    double share = at - low;
    return tool->rows[low * width + index] * (1 - share) + tool->rows[(low + 1) * width + index] * share;
}

/* The largest cosine of an angle that goes down by what the spindle has turned. */
static double most(double off)
{
    double first = fmod(off, 2 * M_PI);
    if (first < 0)
        first += 2 * M_PI;
    return turned_rad >= first ? 1 : fmax(cos(first), cos(first - turned_rad));
}

/* How far the tool has reached toward an angle since the last look: each edge where it was at each moment. */
static double reached(const struct tool *tool, double height, double toward)
{
    double begin = angle_rad - turned_rad, whole = 0, best = 0, e = tool->runout;
    double about = tool->runout_rad - toward;
    for (int i = 0; i < (int)tool->teeth; i++) {
        double radius = column(tool, height, 1 + 2 * i), at = column(tool, height, 2 + 2 * i) - toward;
        double x = radius * cos(at) + e * cos(about), y = radius * sin(at) + e * sin(about);
        whole = fmax(whole, radius);
        best = fmax(best, hypot(x, y) * most(atan2(y, x) - begin));
    }
    double core = height < GASH && tool->core < 1 ? 0 : tool->core;
    return fmax(best, core * whole + e * most(about - begin));
}

static bool is_broken(const struct pins *pin)
{
    int number = (int)lround(*pin->select);
    if (number < 0 || number >= tool_count)
        return true;
    const struct tool *tool = &tools[number];
    double height = beam_z - (*pin->z - tool->gauge), off = beam_y - *pin->y;
    if (tool->is_missing || height < 0)
        return false;
    double reach = reached(tool, height, off >= 0 ? M_PI / 2 : -M_PI / 2);
    double aside = fabs(beam_x - *pin->x);
    double nearest = hypot(off, fmax(aside - focus_half, 0)), farthest = hypot(off, aside + focus_half);
    return nearest <= reach + 1e-7 && farthest >= column(tool, height, 0) - 1e-7;
}

static void run(void *data, long period)
{
    struct pins *pin = data;
    turned_rad = *pin->turns ? fabs(*pin->speed) * 2 * M_PI * period * 1e-9 : 0;
    angle_rad = fmod(angle_rad + turned_rad, 2 * M_PI);
    if (*pin->orient)
        angle_rad = *pin->orient_angle * M_PI / 180;
    *pin->is_oriented = *pin->orient;
    since_edge_ms = is_broken(pin) ? 0 : since_edge_ms + 1;
    *pin->broken = *pin->looks_for_gap ? since_edge_ms >= GAP_MS : since_edge_ms <= PULSE_MS;
}

static int read_table(void)
{
    FILE *file = fopen(TABLE, "rb");
    double count, head[8];
    if (!file || fread(&count, sizeof count, 1, file) != 1)
        return -1;
    tool_count = (int)count;
    tools = calloc(tool_count, sizeof *tools);
    for (int i = 0; i < tool_count; i++) {
        if (fread(head, sizeof head, 1, file) != 1 || head[1] > TEETH)
            return -1;
        size_t size = (size_t)head[7] * (1 + 2 * (size_t)head[1]);
        double *rows = malloc(size * sizeof *rows);
        if (fread(rows, sizeof *rows, size, file) != size)
            return -1;
        tools[i] = (struct tool){head[0], head[1], head[2], head[3], head[4], head[5], head[6], head[7], rows};
    }
    fclose(file);
    return 0;
}

int rtapi_app_main(void)
{
    int id = hal_init("laser");
    if (id < 0 || read_table() != 0)
        return -1;
    struct pins *pin = hal_malloc(sizeof *pin);
    int bad = !pin;
    bad = bad || hal_pin_float_newf(IN, &pin->x, id, "laser.x");
    bad = bad || hal_pin_float_newf(IN, &pin->y, id, "laser.y");
    bad = bad || hal_pin_float_newf(IN, &pin->z, id, "laser.z");
    bad = bad || hal_pin_float_newf(IN, &pin->select, id, "laser.select");
    bad = bad || hal_pin_float_newf(IN, &pin->orient_angle, id, "laser.orient-angle");
    bad = bad || hal_pin_float_newf(IN, &pin->speed, id, "laser.speed");
    bad = bad || hal_pin_bit_newf(IN, &pin->looks_for_gap, id, "laser.looks-for-gap");
    bad = bad || hal_pin_bit_newf(IN, &pin->turns, id, "laser.turns");
    bad = bad || hal_pin_bit_newf(IN, &pin->orient, id, "laser.orient");
    bad = bad || hal_pin_bit_newf(OUT, &pin->is_oriented, id, "laser.is-oriented");
    bad = bad || hal_pin_bit_newf(OUT, &pin->broken, id, "laser.broken");
    bad = bad || hal_export_funct("laser", run, pin, 1, 0, id);
    if (bad)
        return -1;
    return hal_ready(id);
}

void rtapi_app_exit(void) {}
