// The simulated vehicle: the real controller and the real link above the physics, for a planner that believes it is
// one.
#define _DEFAULT_SOURCE
#include <argp.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bench/key.h"
#include "bench/port.h"
#include "conditions.h"
#include "scene.h"
#include "truth.h"

enum {
    EXIT_DOCKED = 0,
    EXIT_MISSED = 1,
    EXIT_UNFINISHED = 2,
    EXIT_TOUCHED = 3,
    EXIT_USAGE = 64,
    EXIT_INPUT = 65,
    EXIT_PORT = 69
};

/// After the end of the timeline so long, on the simulated clock, for the planner to hear of it.
#define LINGER_US INT64_C(1500000)

const char* argp_program_version = "ssv-sim " SIM_VERSION;

static volatile sig_atomic_t is_over;

typedef struct {
    const char *plan, *conditions, *link, *lockstep, *key;
    const char* lcm_url; ///< NULL: the bus is told nothing
    unsigned long long seed;
    double rate; ///< simulated seconds per second; 0 with lockstep
    double longest_s;
} options_t;

static const char doc[] =
    "Simulates the vehicle, its beam and the water of PLAN (the output of ssv plan --format json), and speaks the "
    "vehicle "
    "link. It flies what is uploaded; of PLAN it takes the bodies, where they are, where they mate and dock, and what "
    "stands around. When the timeline is flown, or on Ctrl-C, it prints the truth as JSON."
    "\v"
    "Examples:\n"
    "  ssv-sim plan.json\n"
    "  ssv-sim plan.json --link udp-listen:14555 --rate 20 --conditions rough.yaml --seed 7\n"
    "  ssv-sim plan.json --link udp-listen:14555 --lockstep 14556\n"
    "\n"
    "In lockstep time advances by leave alone: a datagram of 8 bytes to the loopback port of --lockstep, a time in "
    "microseconds as a little-endian integer, lets it run to that time; when it is there and everything that the link "
    "had to "
    "say is sent, it answers with its own time in the same form.\n"
    "\n"
    "Exit codes: 0 docked, 1 missed, 2 neither (stopped, interrupted), 3 touched something that was to be kept clear "
    "of, "
    "however it ended, 64 usage, 65 a file is wrong, 69 a port or the bus cannot be opened.";

static const struct argp_option option_list[] = {
    {"link", 'l', "WHERE", 0, "udp:ADDRESS:PORT, udp-listen:PORT or serial:DEVICE:BAUD (default udp:127.0.0.1:14550)",
     0},
    {"key", 'K', "FILE", 0, "Sign what is sent and hear only what is signed with the key in FILE (64 hex digits)", 0},
    {"conditions", 'c', "FILE", 0, "Disturbances and tolerances (default: none)", 0},
    {"seed", 's', "N", 0, "Seed of the disturbances (default 1)", 0},
    {"rate", 'r', "R", 0, "Simulated seconds per second (default 1)", 0},
    {"lockstep", 'k', "PORT", 0, "Advance by leave of this UDP port's peer, as fast as it goes", 0},
    {"lcm-url", 'u', "URL", 0,
     "Tell the bus the truth ten times per simulated second, on SSV_VEHICLE_TRUTH; URL empty: LCM's default", 0},
    {"longest", 't', "SECONDS", 0, "End after so long on the simulated clock (default 100000)", 0},
    {0}};

static error_t parse(int key, char* text, struct argp_state* state) {
    options_t* options = state->input;
    char* end = NULL;
    switch (key) {
        case 'l': options->link = text; return 0;
        case 'K': options->key = text; return 0;
        case 'c': options->conditions = text; return 0;
        case 'k': options->lockstep = text; return 0;
        case 'u': options->lcm_url = text; return 0;
        case 's':
            options->seed = strtoull(text, &end, 10);
            if (end == text || *end != '\0') argp_error(state, "--seed takes a whole number");
            return 0;
        case 'r':
            options->rate = strtod(text, &end);
            if (end == text || *end != '\0' || !(options->rate > 0 && options->rate <= 1e6))
                argp_error(state, "--rate takes a number above 0");
            return 0;
        case 't':
            options->longest_s = strtod(text, &end);
            if (end == text || *end != '\0' || !(options->longest_s > 0)) argp_error(state, "--longest takes seconds");
            return 0;
        case ARGP_KEY_ARG:
            if (options->plan != NULL) argp_error(state, "only one PLAN is taken");
            options->plan = text;
            return 0;
        case ARGP_KEY_END:
            if (options->plan == NULL) argp_error(state, "a PLAN is needed");
            return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static void end(int number) {
    (void)number;
    is_over = 1;
}

static int64_t clock_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

static void hear(sil_t* sil, port_t* port, int wait_ms) {
    uint8_t bytes[2048];
    size_t got;
    while ((got = port_read(port, wait_ms, bytes, sizeof bytes)) > 0) {
        ssv_vehicle_receive(&sil->vehicle, sil->now_us, bytes, got);
        wait_ms = 0;
    }
}

static void tell(sil_t* sil, port_t* port) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    size_t length;
    while ((length = ssv_vehicle_poll(&sil->vehicle, sil->now_us, frame)) > 0) port_write(port, frame, length);
}

static void step(sil_t* sil, port_t* port, truth_t* truth) {
    sil_step(sil);
    tell(sil, port);
    if (truth != NULL) truth_tell(truth, sil);
}

static bool is_done(const sil_t* sil, int64_t* done_us) {
    if (sil->vehicle.state.phase != SSV_LINK_DONE)
        *done_us = -1;
    else if (*done_us < 0)
        *done_us = sil->now_us;
    return *done_us >= 0 && sil->now_us - *done_us >= LINGER_US;
}

static void run_by_clock(sil_t* sil, port_t* port, truth_t* truth, const options_t* options) {
    const int64_t start_us = clock_us();
    int64_t done_us = -1;
    while (!is_over && !is_done(sil, &done_us) && 1e-6 * (double)sil->now_us < options->longest_s) {
        const double due_us = (double)sil->now_us / options->rate, now_us = (double)(clock_us() - start_us);
        hear(sil, port, now_us < due_us ? (int)ceil(1e-3 * (due_us - now_us)) : 0);
        if ((double)(clock_us() - start_us) < due_us) continue;
        step(sil, port, truth);
    }
}

// On the loopback a datagram is there when it is sent, so what the peer said before it gave leave is heard before time
// goes on, and what is said here is there before the answer.
static void run_by_leave(sil_t* sil, port_t* port, port_t* leave, truth_t* truth, const options_t* options) {
    int64_t done_us = -1;
    while (!is_over && !is_done(sil, &done_us) && 1e-6 * (double)sil->now_us < options->longest_s) {
        uint8_t bytes[8];
        uint64_t until_us = 0, now_us;
        if (port_read(leave, 100, bytes, sizeof bytes) != sizeof bytes) continue;
        for (int i = 0; i < 8; i++) until_us |= (uint64_t)bytes[i] << 8 * i;
        hear(sil, port, 0);
        while (sil->now_us < (int64_t)until_us && !is_done(sil, &done_us)) {
            step(sil, port, truth);
        }
        now_us = (uint64_t)sil->now_us;
        for (int i = 0; i < 8; i++) bytes[i] = (uint8_t)(now_us >> 8 * i);
        port_write(leave, bytes, sizeof bytes);
    }
}

static void print_attempt(const char* name, const sil_t* sil, ssv_event_kind_t kind) {
    static const char* const outcomes[] = {"hit", "miss", "out of turn"};
    const sim_attempt_t* attempt = &sil->attempt[kind];
    printf(" \"%s\": {\"attempts\": %d", name, sil->num_attempts[kind]);
    if (sil->num_attempts[kind] > 0)
        printf(
            ", \"outcome\": \"%s\", \"t_s\": %.6f, \"position_m\": %.9g, \"angle_rad\": %.9g, \"speed_m_s\": %.9g, "
            "\"rate_rad_s\": %.9g",
            outcomes[attempt->outcome], attempt->t_s, attempt->arrival.position_m, attempt->arrival.angle_rad,
            attempt->arrival.speed_m_s, attempt->arrival.rate_rad_s);
    printf("},\n");
}

/// How near vehicle and beam came to what stands around; null if nothing does.
static void print_clearance(const sim_watch_t* watch) {
    const sim_nearest_t* nearest = &watch->nearest;
    if (nearest->obstacle == SIM_NO_OBSTACLE) {
        printf(" \"clearance\": null,\n");
        return;
    }
    printf(
        " \"clearance\": {\"least_m\": %.9g, \"margin_m\": %.9g, \"body\": \"%s\", \"obstacle\": %d, \"t_s\": %.6f},\n",
        nearest->least_m, watch->around.margin_m, nearest->is_beam ? "beam" : "vehicle", nearest->obstacle,
        nearest->t_s);
}

static void print_pose(const char* name, const rb_pose_t* X) {
    printf("\"%s\": [%.17g, %.17g, %.17g, %.17g, %.17g, %.17g, %.17g]", name, X->p_m[0], X->p_m[1], X->p_m[2], X->q[0],
           X->q[1], X->q[2], X->q[3]);
}

/// Where vehicle and beam are, and who holds the beam.
static void print_end(const sim_world_t* world) {
    static const char* const beams[] = {"waiting", "carried", "docked"};
    printf(" \"end\": {\"beam\": \"%s\", ", beams[world->beam]);
    print_pose("X_IS", &world->state.eta);
    printf(", ");
    print_pose("X_IB", &world->X_nB);
    printf("},\n");
}

static double norm(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static int report(const sil_t* sil) {
    const bool docked = sil->world.beam == SIM_BEAM_DOCKED;
    const bool missed =
        !docked && (sil->attempt[SSV_MATE].outcome == SIM_MISS || sil->attempt[SSV_DOCK].outcome == SIM_MISS);
    printf("{\"outcome\": \"%s\",\n", docked ? "docked" : missed ? "missed" : "unfinished");
    print_attempt("mate", sil, SSV_MATE);
    print_attempt("dock", sil, SSV_DOCK);
    print_clearance(&sil->watch);
    print_end(&sil->world);
    printf(
        " \"phase\": %d, \"reason\": \"%s\", \"time_s\": %.6f, \"impulse_Ns\": %.9g, \"speed_m_s\": %.9g, "
        "\"rate_rad_s\": %.9g}\n",
        (int)sil->vehicle.state.phase, ssv_link_reason_str(sil->vehicle.state.reason), sil->world.t_s,
        sil->world.impulse_Ns, norm(&sil->world.state.nu[0]), norm(&sil->world.state.nu[3]));
    if (sil->watch.nearest.least_m < 0) return EXIT_TOUCHED;
    return docked ? EXIT_DOCKED : missed ? EXIT_MISSED : EXIT_UNFINISHED;
}

// @return 0, or the exit code after a complaint.
static int set_up(sil_t* sil, const options_t* options) {
    char error[1024];
    plan_file_t plan;
    sil_config_t config;
    if (!plan_file_read(options->plan, &plan, error, sizeof error)) {
        fprintf(stderr, "ssv-sim: %s\n", error);
        return EXIT_INPUT;
    }
    scene_of_plan(&plan, &config);
    plan_file_free(&plan);
    if (options->conditions != NULL && !conditions_read(options->conditions, &config.world, error, sizeof error)) {
        fprintf(stderr, "ssv-sim: %s\n", error);
        return EXIT_INPUT;
    }
    config.sign = options->key != NULL;
    if (config.sign && !key_read(options->key, 0, &config.signing, error, sizeof error)) {
        fprintf(stderr, "ssv-sim: %s\n", error);
        return EXIT_INPUT;
    }
    config.boot_id = 2 * (uint32_t)options->seed + 1; // the same seed is the same boot
    const char* fault = sil_init(sil, &config, options->seed);
    if (fault == NULL) return 0;
    fprintf(stderr, "ssv-sim: %s: %s\n", options->conditions == NULL ? options->plan : options->conditions, fault);
    return EXIT_INPUT;
}

int main(int argc, char** argv) {
    static sil_t sil;
    options_t options = {.link = "udp:127.0.0.1:14550", .seed = 1, .rate = 1, .longest_s = 100000};
    const struct argp argp = {option_list, parse, "PLAN", doc, NULL, NULL, NULL};
    char error[400], where[40];
    port_t port, leave;
    truth_t* truth = NULL;
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&argp, argc, argv, 0, NULL, &options);
    const int wrong = set_up(&sil, &options);
    if (wrong != 0) return wrong;
    if (options.lockstep != NULL) (void)snprintf(where, sizeof where, "udp-listen:%s", options.lockstep);
    if (!port_open(&port, options.link, error, sizeof error) ||
        (options.lockstep != NULL && !port_open(&leave, where, error, sizeof error)) ||
        (options.lcm_url != NULL && (truth = truth_open(options.lcm_url, error, sizeof error)) == NULL)) {
        fprintf(stderr, "ssv-sim: %s\n", error);
        return EXIT_PORT;
    }
    const struct sigaction action = {.sa_handler = end};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    if (port.listens) fprintf(stderr, "link on UDP port %d\n", port_number(&port));
    if (options.lockstep != NULL) fprintf(stderr, "lockstep on UDP port %d\n", port_number(&leave));
    if (options.lockstep != NULL) {
        run_by_leave(&sil, &port, &leave, truth, &options);
        port_close(&leave);
    } else {
        run_by_clock(&sil, &port, truth, &options);
    }
    port_close(&port);
    truth_close(truth);
    return report(&sil);
}
