// How long planning takes, in process and over LCM, for every shipped scenario. What it prints is in its --help, below.
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

#define REPEATS 300
#define MAX_SCENARIOS 32
#define CALIBRATION_STEPS 100000
#define ANSWER_TIMEOUT_US 500000
#define ANSWER_TRIES 20

typedef struct {
    double ms[REPEATS];
} samples_t;

typedef struct {
    const char* name;
    lcm_ssv_scenario_t question;
    int64_t plan_hash;
    int segments, bytes;
    samples_t calibration, in_process, over_lcm;
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
    const uint8_t* id = (const uint8_t*)datagram->data + 24; // after the type hash and the four counts
    uint64_t value = 0;
    for (int i = 0; datagram->data_size >= 32 && i < 8; i++) {
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
    glob_t found;
    if (glob(SSV_HOST_DIR "/scenarios/*.yaml", 0, NULL, &found) != 0) {
        give_up("no scenarios in " SSV_HOST_DIR "/scenarios");
    }
    int count = 0;
    for (; count < MAX_SCENARIOS && (size_t)count < found.gl_pathc; count++) {
        row_t* row = &rows[count];
        const char* path = found.gl_pathv[count];
        if (!scenario_file_read(path, SSV_HOST_DIR "/models", &row->question, error, sizeof error)) {
            give_up(error);
        }
        row->name = strdup(strrchr(path, '/') + 1);
        row->question.request_id = (int64_t)(count + 1) * REPEATS;
    }
    globfree(&found);
    return count;
}

/// One repeat of everything, so that all figures of a row saw the same disturbances.
static void measure(row_t* row, int repeat, link_t* link) {
    static ssv_answer_t answer;
    row->calibration.ms[repeat] = calibrate_ms();
    const double start = now_ms();
    ssv_answer(&row->question, &answer);
    row->in_process.ms[repeat] = now_ms() - start;
    if (answer.wire.status != LCM_SSV_PLAN_T_STATUS_OK) {
        give_up(answer.wire.reason);
    }
    row->segments = answer.wire.num_segments;
    row->bytes = lcm_ssv_plan_t_encoded_size(&answer.wire);
    row->over_lcm.ms[repeat] = round_trip_ms(link, &row->question);
    row->question.request_id++;
}

static int compare(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

static void sort(samples_t* samples) { qsort(samples->ms, REPEATS, sizeof samples->ms[0], compare); }

static double median(const samples_t* sorted) { return sorted->ms[REPEATS / 2]; }
static double p99(const samples_t* sorted) { return sorted->ms[REPEATS * 99 / 100]; }
static double worst(const samples_t* sorted) { return sorted->ms[REPEATS - 1]; }

static void print_table(const row_t* rows, int count) {
    printf("%d plans of each scenario; times in ms\n\n", REPEATS);
    printf("%-22s %29s   %26s\n", "", "in process", "over LCM");
    printf("%-22s %8s %8s %8s   %8s %8s %8s  %7s %7s %8s %6s\n", "scenario", "median", "p99", "worst", "median", "p99",
           "worst", "plans/s", "x loop", "segments", "bytes");
    for (int i = 0; i < count; i++) {
        const row_t* row = &rows[i];
        printf("%-22s %8.3f %8.3f %8.3f   %8.3f %8.3f %8.3f  %7.0f %7.2f %8d %6d\n", row->name, median(&row->in_process),
               p99(&row->in_process), worst(&row->in_process), median(&row->over_lcm), p99(&row->over_lcm),
               worst(&row->over_lcm), 1e3 / median(&row->in_process), median(&row->in_process) / median(&row->calibration),
               row->segments, row->bytes);
    }
    printf("\nx loop: the median in process, in units of %d dependent square roots and quotients, here %.3f ms; to compare\n"
           "machines, or versions of the planner on a machine whose speed varies.\n",
           CALIBRATION_STEPS, median(&rows[0].calibration));
}

static void print_times(const char* name, const samples_t* sorted) {
    printf("\"%s\": {\"median_ms\": %.6f, \"p99_ms\": %.6f, \"worst_ms\": %.6f}, ", name, median(sorted), p99(sorted),
           worst(sorted));
}

static void print_json(const row_t* rows, int count) {
    printf("{\"repeats\": %d, \"scenarios\": [", REPEATS);
    for (int i = 0; i < count; i++) {
        const row_t* row = &rows[i];
        printf("%s\n  {\"scenario\": \"%s\", ", i == 0 ? "" : ",", row->name);
        print_times("in_process", &row->in_process);
        print_times("over_lcm", &row->over_lcm);
        print_times("calibration", &row->calibration);
        const double in_process_ms = median(&row->in_process);
        printf("\"plans_per_s\": %.3f, \"per_calibration\": %.6f, \"segments\": %d, \"bytes\": %d}", 1e3 / in_process_ms,
               in_process_ms / median(&row->calibration), row->segments, row->bytes);
    }
    printf("\n]}\n");
}

static const char manual[] =
    "Measures how long planning takes for every scenario in host/scenarios, in process and as a round trip over LCM to an "
    "ssv-plannerd of its own, and compares it with a fixed calibration loop."
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
    static row_t rows[MAX_SCENARIOS];
    static const struct argp parser = {option_table, parse_option, NULL, manual, NULL, NULL, NULL};
    bool json = false;
    argp_parse(&parser, argc, argv, 0, NULL, &json);

    const int count = read_scenarios(rows);
    link_t link = link_open();
    lcm_subscribe(link.lcm, "SSV_PLAN", on_plan, &link);
    lcm_ssv_scenario_t first = rows[0].question;
    first.request_id = 0;
    round_trip_ms(&link, &first); // until the daemon is up
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        for (int i = 0; i < count; i++) {
            measure(&rows[i], repeat, &link);
        }
    }
    link_close(&link);
    for (int i = 0; i < count; i++) {
        sort(&rows[i].calibration);
        sort(&rows[i].in_process);
        sort(&rows[i].over_lcm);
    }
    if (json) {
        print_json(rows, count);
    } else {
        print_table(rows, count);
    }
    return EXIT_SUCCESS;
}
