// The thruster controller without physics, for bring-up on a bench: the real link, the real clock, and what it would
// do. It takes itself to rest at a given place, so that timelines that start there are accepted; thrusters and gripper
// are not there, and every attempt to mate or dock counts as a hit.
#define _DEFAULT_SOURCE
#include <argp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bench/key.h"
#include "bench/port.h"
#include "ssv/vehicle.h"

enum { EXIT_USAGE = 64, EXIT_PORT = 69 };

const char* argp_program_version = "ssv-vehicle " BENCH_VERSION;

static volatile sig_atomic_t is_over;
static ssv_controller_t vehicle;
static ssv_vehicle_config_t config;

typedef struct {
    const char *link, *key;
    ssv_link_pose_t pose;
    double print_s;
} options_t;

static const char doc[] =
    "Runs the vehicle's thruster controller on the real clock, without physics, and prints what it would do: a line "
    "for "
    "each change of phase, each attempt to mate or dock, and the thrusts now and then. It stays at one place."
    "\v"
    "Examples:\n"
    "  ssv-vehicle                               sends to a planner at 127.0.0.1:14550\n"
    "  ssv-vehicle --link udp-listen:14555       answers whoever speaks to it\n"
    "  ssv-vehicle --link serial:/dev/ttyUSB0:57600 --at 1,0,0.5\n"
    "\n"
    "Exit codes: 0 interrupted, 64 usage, 69 port or key cannot be opened.";

static const struct argp_option option_list[] = {
    {"link", 'l', "WHERE", 0, "udp:ADDRESS:PORT, udp-listen:PORT or serial:DEVICE:BAUD (default udp:127.0.0.1:14550)",
     0},
    {"at", 'p', "X,Y,Z", 0, "Where the vehicle is, in metres (default 0,0,0)", 0},
    {"attitude", 'q', "W,X,Y,Z", 0, "Its attitude, a unit quaternion (default 1,0,0,0)", 0},
    {"key", 'K', "FILE", 0, "Sign what is sent and hear only what is signed with the key in FILE (64 hex digits)", 0},
    {"every", 'e', "SECONDS", 0, "How often the thrusts are printed while there are any (default 1)", 0},
    {0}};

// So many numbers with commas between them, all of the text.
static bool numbers(const char* text, int count, float* value) {
    for (int i = 0; i < count; i++) {
        char* end;
        value[i] = strtof(text, &end);
        if (end == text || *end != (i + 1 < count ? ',' : '\0')) return false;
        text = end + 1;
    }
    return true;
}

static error_t parse(int key, char* text, struct argp_state* state) {
    options_t* options = state->input;
    char* end;
    switch (key) {
        case 'l': options->link = text; return 0;
        case 'K': options->key = text; return 0;
        case 'p':
            if (!numbers(text, 3, options->pose.p_IS_m)) argp_error(state, "--at takes three numbers, such as 1,0,0.5");
            return 0;
        case 'q':
            if (!numbers(text, 4, options->pose.q_IS)) argp_error(state, "--attitude takes four numbers");
            return 0;
        case 'e':
            options->print_s = strtod(text, &end);
            if (end == text || *end != '\0' || !(options->print_s > 0)) argp_error(state, "--every takes seconds");
            return 0;
        case ARGP_KEY_ARG: argp_error(state, "%s: no arguments are taken", text); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static int64_t clock_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

static void end(int number) {
    (void)number;
    is_over = 1;
}

static void print(int64_t now_us, const ssv_vehicle_output_t* output, double print_s) {
    static const char* const phases[] = {"disarmed", "ready", "executing", "holding", "braking", "stopped", "done"};
    static int phase = -1;
    static int64_t printed_us;
    const ssv_link_vehicle_state_t* state = &vehicle.state;
    bool has_thrust = false;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) has_thrust |= output->u_N[k] != 0;
    if ((int)state->phase != phase) {
        phase = (int)state->phase;
        printf("%10.3f %s%s%s\n", 1e-6 * (double)now_us, phases[phase], state->reason == 0 ? "" : ": ",
               state->reason == 0 ? "" : ssv_link_reason_str(state->reason));
    }
    if (output->attempts)
        printf("%10.3f %s\n", 1e-6 * (double)now_us, output->event.kind == SSV_DOCK ? "docks" : "mates");
    if (has_thrust && (double)(now_us - printed_us) >= 1e6 * print_s) {
        printed_us = now_us;
        printf("%10.3f segment %d, plan time %.3f s, thrusts [N]", 1e-6 * (double)now_us, (int)state->segment,
               1e-9 * (double)state->plan_time_ns);
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) printf(" %.2f", (double)output->u_N[k]);
        printf("\n");
    }
    fflush(stdout);
}

static void run(port_t* port, const options_t* options) {
    const int64_t start_us = clock_us();
    for (int64_t due_us = 0; !is_over;) {
        uint8_t bytes[2048], frame[SSV_LINK_FRAME_BYTES_MAX];
        int64_t now_us = clock_us() - start_us;
        const size_t got =
            port_read(port, now_us < due_us ? (int)((due_us - now_us + 999) / 1000) : 0, bytes, sizeof bytes);
        now_us = clock_us() - start_us;
        if (got > 0) ssv_vehicle_receive(&vehicle, now_us, bytes, got);
        if (now_us >= due_us) { // a tick that is late is made up for at once
            ssv_vehicle_output_t output;
            ssv_vehicle_navigate(&vehicle, now_us, &options->pose);
            ssv_vehicle_tick(&vehicle, now_us, &output);
            print(now_us, &output, options->print_s);
            if (output.attempts) ssv_vehicle_attempted(&vehicle, now_us, true);
            due_us += SSV_VEHICLE_TICK_US;
        }
        for (size_t length; (length = ssv_vehicle_poll(&vehicle, now_us, frame)) > 0;) port_write(port, frame, length);
    }
}

int main(int argc, char** argv) {
    options_t options = {.link = "udp:127.0.0.1:14550", .pose = {.known = true, .q_IS = {1, 0, 0, 0}}, .print_s = 1};
    const struct argp argp = {option_list, parse, NULL, doc, NULL, NULL, NULL};
    char error[400];
    port_t port;
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&argp, argc, argv, 0, NULL, &options);
    if (!port_open(&port, options.link, error, sizeof error)) {
        fprintf(stderr, "ssv-vehicle: %s\n", error);
        return EXIT_PORT;
    }
    ssv_vehicle_config_default(&config, ((uint32_t)time(NULL) ^ ((uint32_t)getpid() << 16)) | 1);
    config.link.sign = options.key != NULL;
    if (config.link.sign && !key_read(options.key, 0, &config.link.signing, error, sizeof error)) {
        fprintf(stderr, "ssv-vehicle: %s\n", error);
        return EXIT_PORT;
    }
    if (!ssv_vehicle_init(&vehicle, &config)) return EXIT_FAILURE;
    const struct sigaction action = {.sa_handler = end};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    if (port.listens) printf("listens on UDP port %d\n", port_number(&port));
    run(&port, &options);
    port_close(&port);
    return EXIT_SUCCESS;
}
