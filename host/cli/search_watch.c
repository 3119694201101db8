#include "search_watch.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "line.h"

search_watch_t search_watch_begin(const pricing_t* pricing) {
    return (search_watch_t){
        .pricing = pricing, .begun_s = line_now_s(), .best = INFINITY, .on_terminal = isatty(STDERR_FILENO) == 1};
}

double search_watch_clock_s(void* context) {
    search_watch_t* const watch = context;
    const double now = line_now_s();
    if (watch->gives_up != NULL && watch->gives_up(watch->context)) return INFINITY;
    if (watch->on_terminal && now - watch->shown_s >= 0.2) {
        const pricing_counts_t counts = pricing_counts(watch->pricing);
        watch->shown_s = now;
        fprintf(stderr, "ssv: %.0f s, ", now - watch->begun_s);
        if (isfinite(watch->best)) fprintf(stderr, "best J %.1f, ", watch->best);
        if (watch->bound > 0) {
            fprintf(stderr, "bound %.1f (%.1f %%), ", watch->bound, 100 * (watch->best / watch->bound - 1));
        }
        fprintf(stderr, "%" PRIu64 " prices, %" PRIu64 " known   \r", counts.asked, counts.known);
    }
    return now;
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
