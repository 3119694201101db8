// How long planning takes by each method, in process and over LCM, for every shipped scenario, and at what price. What it
// prints is in its --help, below.
#define _GNU_SOURCE
#include <argp.h>
#include <glob.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <lcm/lcm.h>

#include "scenario_file.h"
#include "ssv/answer.h"

#define MAX_REPEATS 300
#define MAX_ROWS 96
#define BOUNDS_PER_SAMPLE 1000
#define CALIBRATION_STEPS 100000
#define ANSWER_TIMEOUT_US 500000
#define ANSWER_TRIES 20

typedef struct {
    const char *method, *effort;
    int8_t wire_method, wire_effort;
    int repeats; // p99 wants a hundred; more where planning is fast
} way_t;

// The first is what the others are compared with.
static const way_t ways[] = {
    {"paper", "", LCM_SSV_OPTIONS_T_METHOD_PAPER, LCM_SSV_OPTIONS_T_EFFORT_QUICK, MAX_REPEATS},
    {"optimal", "quick", LCM_SSV_OPTIONS_T_METHOD_OPTIMAL, LCM_SSV_OPTIONS_T_EFFORT_QUICK, MAX_REPEATS},
    {"optimal", "best", LCM_SSV_OPTIONS_T_METHOD_OPTIMAL, LCM_SSV_OPTIONS_T_EFFORT_BEST, 100},
};
#define NUM_WAYS ((int)(sizeof ways / sizeof ways[0]))

typedef struct {
    int count;
    double value[MAX_REPEATS];
} samples_t;

/// One scenario, planned in one way.
typedef struct {
    const char* name;
    const way_t* way;
    lcm_ssv_scenario_t question;
    ssv_problem_t problem;
    double cost, cost_over_paper, bound_over_cost;
    int segments, bytes;
    samples_t calibration_ms, in_process_ms, over_lcm_ms, bound_ns;
} row_t;

typedef struct {
    lcm_t* lcm;
    pid_t daemon;
    int64_t last_answered; // request id
} link_t;

__attribute__((noreturn)) static void give_up(const char* what) {
    fprintf(stderr, "bench_planner: %s\n", what);
    exit(EXIT_FAILURE);
}

static double now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

/// A fixed chain of dependent products, quotients and roots: what one core does with doubles.
static double calibrate_ms(void) {
    volatile double outside = 2; // read and written between the two looks at the clock, so the loop stays there
    const double start = now_ms();
    double x = outside;
    for (int i = 0; i < CALIBRATION_STEPS; i++) {
        x = sqrt(x * 1.25 + 3 / x);
    }
    outside = x;
    return now_ms() - start;
}

static void on_plan(const lcm_recv_buf_t* datagram, const char* channel, void* user) {
    (void)channel;
    link_t* link = user;
    const uint8_t* id = (const uint8_t*)datagram->data + 28; // after the type hash and the five counts
    uint64_t value = 0;
    for (int i = 0; datagram->data_size >= 36 && i < 8; i++) {
        value = value << 8 | id[i];
    }
    link->last_answered = (int64_t)value;
}

/// Sends the question until its answer comes. @return the time from the last sending to the answer.
static double round_trip_ms(link_t* link, const lcm_ssv_scenario_t* question) {
    uint8_t bytes[4096];
    const int size = lcm_ssv_scenario_t_encode(bytes, 0, sizeof bytes, question);
    for (int i = 0; i < ANSWER_TRIES; i++) {
        const double start = now_ms();
        if (size < 0 || lcm_publish(link->lcm, "SSV_SCENARIO", bytes, (unsigned)size) != 0) {
            give_up("cannot send over LCM");
        }
        while (lcm_handle_timeout(link->lcm, ANSWER_TIMEOUT_US / 1000) > 0) {
            if (link->last_answered == question->request_id) {
                return now_ms() - start;
            }
        }
    }
    give_up("ssv-plannerd does not answer");
}

/// A daemon of our own on a multicast port of our own.
static link_t link_open(void) {
    char url[64];
    snprintf(url, sizeof url, "udpm://239.255.76.67:%d?ttl=0", 20000 + (int)(getpid() % 20000));
    link_t link = {lcm_create(url), 0, -1};
    if (link.lcm == NULL) {
        give_up("no LCM over UDP multicast: `bash tests/run.sh -R bench -V` runs this where there is");
    }
    link.daemon = fork();
    if (link.daemon == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (freopen("/dev/null", "w", stderr) != NULL) {
            execl(SSV_DAEMON, SSV_DAEMON, "--lcm-url", url, (char*)NULL);
        }
        _exit(127);
    }
    return link;
}

static void link_close(link_t* link) {
    kill(link->daemon, SIGTERM);
    waitpid(link->daemon, NULL, 0);
    lcm_destroy(link->lcm);
}

static int read_scenarios(row_t* rows) {
    static char error[1024];
    ssv_scenario_t scenario;
    ssv_fault_t fault;
    glob_t found;
    if (glob(SSV_HOST_DIR "/scenarios/*.yaml", 0, NULL, &found) != 0) {
        give_up("no scenarios in " SSV_HOST_DIR "/scenarios");
    }
    int count = 0;
    for (; count < MAX_ROWS && (size_t)(count / NUM_WAYS) < found.gl_pathc; count++) {
        row_t* row = &rows[count];
        const char* path = found.gl_pathv[count / NUM_WAYS];
        const char* name = strrchr(path, '/') + 1;
        if (!scenario_file_read(path, SSV_HOST_DIR "/models", &row->question, error, sizeof error)) {
            give_up(error);
        }
        row->name = strndup(name, strcspn(name, "."));
        row->way = &ways[count % NUM_WAYS];
        row->question.options.method = row->way->wire_method;
        row->question.options.effort = row->way->wire_effort;
        row->question.request_id = (int64_t)(count + 1) * MAX_REPEATS;
        ssv_scenario_from_wire(&scenario, &row->question);
        if (ssv_problem_init(&row->problem, &scenario, &fault) != SSV_OK) {
            give_up(path);
        }
    }
    globfree(&found);
    return count;
}

static double bound_ns(const ssv_problem_t* problem) {
    volatile double outside;
    const double start = now_ms();
    for (int i = 0; i < BOUNDS_PER_SAMPLE; i++) {
        outside = real_to_double(ssv_lower_bound(problem));
    }
    (void)outside;
    return (now_ms() - start) * 1e6 / BOUNDS_PER_SAMPLE;
}

static void add(samples_t* samples, double value) { samples->value[samples->count++] = value; }

/// One repeat of everything, so that all figures of a row saw the same disturbances.
static void measure(row_t* row, link_t* link) {
    static ssv_answer_t answer;
    add(&row->calibration_ms, calibrate_ms());
    const double start = now_ms();
    ssv_answer(&row->question, &answer);
    add(&row->in_process_ms, now_ms() - start);
    if (answer.wire.quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        give_up(answer.wire.quote.reason);
    }
    row->segments = answer.wire.num_segments;
    row->bytes = lcm_ssv_plan_t_encoded_size(&answer.wire);
    row->cost = answer.wire.quote.cost;
    row->bound_over_cost = answer.wire.quote.cost_lower_bound / answer.wire.quote.cost;
    add(&row->over_lcm_ms, round_trip_ms(link, &row->question));
    add(&row->bound_ns, bound_ns(&row->problem));
    row->question.request_id++;
}

static int compare(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

static void sort(samples_t* samples) { qsort(samples->value, (size_t)samples->count, sizeof samples->value[0], compare); }

static double median(const samples_t* sorted) { return sorted->value[sorted->count / 2]; }
static double p99(const samples_t* sorted) { return sorted->value[(sorted->count - 1) * 99 / 100]; }
static double worst(const samples_t* sorted) { return sorted->value[sorted->count - 1]; }

static void print_table(const row_t* rows, int count) {
    printf("Times in ms, of %d plans each (effort best: %d)\n\n", ways[0].repeats, ways[NUM_WAYS - 1].repeats);
    printf("%-30s %26s %18s\n", "", "in process", "over LCM");
    printf("%-15s %-14s %8s %8s %8s %9s %8s %8s %8s %8s %7s %7s %6s %6s\n", "scenario", "method, effort", "median", "p99",
           "worst", "median", "p99", "plans/s", "x loop", "J/paper", "J_lo/J", "J_lo ns", "segs", "bytes");
    for (int i = 0; i < count; i++) {
        const row_t* row = &rows[i];
        char way[32];
        snprintf(way, sizeof way, "%s %s", row->way->method, row->way->effort);
        printf("%-15s %-14s %8.3f %8.3f %8.3f %9.3f %8.3f %8.0f %8.2f %8.4f %7.4f %7.0f %6d %6d\n", row->name, way,
               median(&row->in_process_ms), p99(&row->in_process_ms), worst(&row->in_process_ms), median(&row->over_lcm_ms),
               p99(&row->over_lcm_ms), 1e3 / median(&row->in_process_ms),
               median(&row->in_process_ms) / median(&row->calibration_ms), row->cost_over_paper, row->bound_over_cost,
               median(&row->bound_ns), row->segments, row->bytes);
    }
    printf("\nx loop: the median in process, in units of %d dependent square roots and quotients, here %.3f ms; to compare\n"
           "machines, or versions of the planner on a machine whose speed varies. J/paper: over the price of method paper.\n"
           "J_lo: the lower bound of the price, and the time that one call of ssv_lower_bound takes.\n",
           CALIBRATION_STEPS, median(&rows[0].calibration_ms));
}

static void print_times(const char* name, const char* unit, const samples_t* sorted) {
    printf("\"%s\": {\"median_%s\": %.6f, \"p99_%s\": %.6f, \"worst_%s\": %.6f}, ", name, unit, median(sorted), unit,
           p99(sorted), unit, worst(sorted));
}

static void print_json(const row_t* rows, int count) {
    printf("{\"rows\": [");
    for (int i = 0; i < count; i++) {
        const row_t* row = &rows[i];
        printf("%s\n  {\"scenario\": \"%s\", \"method\": \"%s\", \"effort\": \"%s\", \"repeats\": %d, ", i == 0 ? "" : ",",
               row->name, row->way->method, row->way->effort, row->way->repeats);
        print_times("in_process", "ms", &row->in_process_ms);
        print_times("over_lcm", "ms", &row->over_lcm_ms);
        print_times("calibration", "ms", &row->calibration_ms);
        print_times("bound", "ns", &row->bound_ns);
        const double in_process_ms = median(&row->in_process_ms);
        printf("\"plans_per_s\": %.3f, \"per_calibration\": %.6f, \"J\": %.9g, \"J_over_paper\": %.9g, "
               "\"bound_over_J\": %.9g, \"segments\": %d, \"bytes\": %d}",
               1e3 / in_process_ms, in_process_ms / median(&row->calibration_ms), row->cost, row->cost_over_paper,
               row->bound_over_cost, row->segments, row->bytes);
    }
    printf("\n]}\n");
}

static const char manual[] =
    "Measures how long planning takes for every scenario in host/scenarios, by method paper and by method optimal with "
    "either effort, in process and as a round trip over LCM to an ssv-plannerd of its own, and compares it with a fixed "
    "calibration loop; and what the plans cost, against method paper and the lower bound."
    "\v"
    "It needs LCM over UDP multicast; `bash tests/run.sh -R bench -V` runs it in a private network.\n\n"
    "Exit codes: 0 measured, 1 not possible, 64 wrong usage.\n";

static const struct argp_option option_table[] = {{"json", 'j', NULL, 0, "print JSON instead of a table", 0},
                                                  {NULL, 0, NULL, 0, NULL, 0}};

static error_t parse_option(int key, char* argument, struct argp_state* state) {
    switch (key) {
        case 'j': *(bool*)state->input = true; return 0;
        case ARGP_KEY_ARG: argp_error(state, "unexpected argument '%s'", argument); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

int main(int argc, char** argv) {
    static row_t rows[MAX_ROWS];
    static const struct argp parser = {option_table, parse_option, NULL, manual, NULL, NULL, NULL};
    bool json = false;
    argp_parse(&parser, argc, argv, 0, NULL, &json);

    const int count = read_scenarios(rows);
    link_t link = link_open();
    lcm_subscribe(link.lcm, "SSV_PLAN", on_plan, &link);
    lcm_ssv_scenario_t first = rows[0].question;
    first.request_id = 0;
    round_trip_ms(&link, &first); // until the daemon is up
    for (int repeat = 0; repeat < MAX_REPEATS; repeat++) {
        for (int i = 0; i < count; i++) {
            if (repeat < rows[i].way->repeats) {
                measure(&rows[i], &link);
            }
        }
    }
    link_close(&link);
    for (int i = 0; i < count; i++) {
        row_t* row = &rows[i];
        row->cost_over_paper = row->cost / rows[i - i % NUM_WAYS].cost;
        sort(&row->calibration_ms);
        sort(&row->in_process_ms);
        sort(&row->over_lcm_ms);
        sort(&row->bound_ns);
    }
    if (json) {
        print_json(rows, count);
    } else {
        print_table(rows, count);
    }
    return EXIT_SUCCESS;
}
