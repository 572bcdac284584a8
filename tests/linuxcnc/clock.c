/* Makes the realtime threads of a simulated LinuxCNC wait CLOCK_SPEED_UP times less than they ask for.
 *
 * Preloaded into every program of one test run; it touches only rtapi_app, whose threads sleep until absolute
 * points of time, one servo period apart.  Each thread keeps the last point it asked for and the moment it was
 * let go; the next wait is the difference of the two points, divided.  A thread that comes late is let go at
 * once and starts counting anew, so that lost wall time is never made up by a burst.
 *
 * A thread only waits for points of time that are to come.  Where the clock is slowed down the points would soon
 * lie behind it, and the thread would run on without a wait: so it is told that it is the point that it last
 * asked for.
 *
 * These threads also go before the reader of the program, as on a realtime kernel: without one LinuxCNC gives
 * them no priority at all.  Where that is not allowed they stay as they are.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef int (*sleeper)(clockid_t, int, const struct timespec *, struct timespec *);
typedef int (*teller)(clockid_t, struct timespec *);

static sleeper real_sleep;
static teller real_time;
static double speed_up = 1.0;
static int is_motion;
static __thread int is_raised;
static __thread long long asked_ns, released_ns;

static long long in_ns(const struct timespec *t) { return t->tv_sec * 1000000000LL + t->tv_nsec; }

__attribute__((constructor)) static void prepare(void)
{
    const char *text = getenv("CLOCK_SPEED_UP");
    real_sleep = (sleeper)dlsym(RTLD_NEXT, "clock_nanosleep");
    real_time = (teller)dlsym(RTLD_NEXT, "clock_gettime");
    is_motion = strcmp(program_invocation_short_name, "rtapi_app") == 0;
    if (text && is_motion)
        speed_up = atof(text);
}

static void go_before_the_reader(void)
{
    struct sched_param above = {.sched_priority = 2};
    pthread_setschedparam(pthread_self(), SCHED_RR, &above);
    is_raised = 1;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left)
{
    if (is_motion && !is_raised && (flags & TIMER_ABSTIME))
        go_before_the_reader();
    if (speed_up == 1.0 || !(flags & TIMER_ABSTIME))
        return real_sleep(clock, flags, until, left);

    long long point = in_ns(until);
    struct timespec now;
    real_time(clock, &now);
    long long wake = in_ns(&now);
    if (asked_ns && point > asked_ns) {
        long long due = released_ns + (long long)((point - asked_ns) / speed_up);
        if (due > wake)
            wake = due;
    }
    struct timespec release = {wake / 1000000000LL, wake % 1000000000LL};
    int result = real_sleep(clock, flags, &release, left);
    asked_ns = point;
    released_ns = wake;
    return result;
}

int clock_gettime(clockid_t clock, struct timespec *now)
{
    if (speed_up >= 1.0 || !asked_ns) {
        if (!real_time) /* another library may ask before this one is prepared */
            real_time = (teller)dlsym(RTLD_NEXT, "clock_gettime");
        return real_time(clock, now);
    }
    now->tv_sec = asked_ns / 1000000000LL;
    now->tv_nsec = asked_ns % 1000000000LL;
    return 0;
}
