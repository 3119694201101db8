#include "search_watch.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "line.h"

search_watch_t search_watch_begin(const pricing_t* pricing, double time_limit_s, bool (*gives_up)(void* context),
                                  void* context) {
    return (search_watch_t){.pricing = pricing,
                            .begun_s = line_now_s(),
                            .time_limit_s = time_limit_s,
                            .best = INFINITY,
                            .gives_up = gives_up,
                            .context = context,
                            .on_terminal = isatty(STDERR_FILENO) == 1};
}

static void show_progress(const search_watch_t* watch, double elapsed_s) {
    const pricing_counts_t counts = pricing_counts(watch->pricing);
    fprintf(stderr, "ssv: %.0f s, ", elapsed_s);
    if (isfinite(watch->best)) fprintf(stderr, "best J %.1f, ", watch->best);
    if (watch->bound > 0) {
        fprintf(stderr, "bound %.1f (%.1f %%), ", watch->bound, 100 * (watch->best / watch->bound - 1));
    }
    fprintf(stderr, "%" PRIu64 " prices, %" PRIu64 " known   \r", counts.asked, counts.known);
}

bool search_watch_must_stop(void* context) {
    search_watch_t* const watch = context;
    const double now = line_now_s();
    if (watch->on_terminal && now - watch->shown_s >= 0.2) {
        watch->shown_s = now;
        show_progress(watch, now - watch->begun_s);
    }
    watch->stopped =
        watch->gives_up(watch->context) || (watch->time_limit_s > 0 && now - watch->begun_s >= watch->time_limit_s);
    return watch->stopped;
}

void search_watch_found(void* context, double cost, double lower_bound) {
    search_watch_t* const watch = context;
    watch->bound = lower_bound;
    if (!isfinite(watch->best)) watch->first_s = line_now_s() - watch->begun_s;
    watch->best = cost;
}

void search_watch_end(const search_watch_t* watch) {
    if (watch->on_terminal) fprintf(stderr, "\r%*s\r", 78, "");
}
