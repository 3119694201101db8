// ssv-replay: arguments in, table or JSON out.
#define _DEFAULT_SOURCE
#include <argp.h>
#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "replay.h"

enum { EXIT_WITHIN = 0, EXIT_OTHER = 1, EXIT_INVALID = 2, EXIT_OUTSIDE = 3, EXIT_NOT_JUDGED = 4, EXIT_USAGE = 64 };

const char* argp_program_version = "ssv-replay " SIM_VERSION;

static const char DOC[] =
    "Flies a plan open loop in independent 6-DOF physics and prints how far from the task it mates and docks, and how "
    "near it comes to what stands around.\v"
    "PLAN.json is what `ssv plan --format json` writes; - reads it from standard input. The physics knows bodies, drag "
    "and "
    "thrusters from the plan's scenario and nothing of the planner. The beam joins at the mate event as it lies. Where "
    "the plan's task has anything around, vehicle and beam must not touch it; nearer than its margin is told and not "
    "judged. Steps become finer until they move no figure by more than a twentieth of its tolerance. A plan is "
    "feed-forward: --off shows what little of an error in the model or the thrusters it takes for the flight to "
    "miss.\n\n"
    "Examples:\n"
    "  ssv plan paper_case.yaml --format json | ssv-replay -\n"
    "  ssv-replay --format json plan.json\n"
    "  ssv-replay plan.json --off mass=+5%,drag=+5%,thrust=-1%,thruster1=-5%\n\n"
    "Exit codes:\n"
    "  0   every figure is within its tolerance\n"
    "  2   the plan file is absent, unreadable or invalid, or its status is not ok\n"
    "  3   a figure is outside its tolerance, or something was touched\n"
    "  4   not judged: the motion is too unstable to be computed, or its time\n"
    "      constants are too short for so long a flight\n"
    "  64  wrong usage\n"
    "  1   anything else: the output cannot be written";

static const struct argp_option OPTIONS[] = {
    {"format", 'f', "table|json", 0, "table for people (default) or JSON for scripts", 0},
    {"off", 'o', "WHAT=+N%,...", 0,
     "Fly it with mass (inertia and added mass too) or drag of both bodies, thrust of all thrusters, or thruster1 to "
     "thruster6 by so much larger or smaller than the plan takes them for",
     0},
    {0},
};

typedef struct {
    const char* plan;
    bool json;
    const char* off_text; ///< as it was given; NULL: nothing is off
    replay_off_t off;
} arguments_t;

/// Takes one WHAT=+N%. @return whether it is one.
static bool take_off(const char* what, size_t length, double factor, replay_off_t* off) {
    if (length == 4 && strncmp(what, "mass", length) == 0 && factor > 0) {
        off->mass *= factor;
    } else if (length == 4 && strncmp(what, "drag", length) == 0) {
        off->drag *= factor;
    } else if (length == 6 && strncmp(what, "thrust", length) == 0) {
        for (int t = 0; t < PLAN_THRUSTERS; t++) {
            off->thruster[t] *= factor;
        }
    } else if (length == 9 && strncmp(what, "thruster", 8) == 0 && what[8] >= '1' && what[8] <= '0' + PLAN_THRUSTERS) {
        off->thruster[what[8] - '1'] *= factor;
    } else {
        return false;
    }
    return true;
}

static void parse_off(const char* text, replay_off_t* off, struct argp_state* state) {
    for (const char* what = text; what != NULL;) {
        const char* const number = strchr(what, '=');
        char* end = NULL;
        const double percent = number == NULL ? -1000 : strtod(number + 1, &end);
        if (!(percent >= -100 && percent <= 1000) || end == number + 1 || *end != '%' ||
            (end[1] != ',' && end[1] != '\0') || !take_off(what, (size_t)(number - what), 1 + percent / 100, off)) {
            argp_error(
                state,
                "--off takes mass, drag, thrust and thruster1 to thruster6 with percents of -100 to 1000, such as "
                "mass=+5%%,thrust=-1%%, and mass of more than -100; not %s",
                what);
            return;
        }
        what = end[1] == ',' ? end + 2 : NULL;
    }
}

static error_t parse_argument(int key, char* value, struct argp_state* state) {
    arguments_t* arguments = state->input;
    switch (key) {
        case 'f':
            if (strcmp(value, "table") != 0 && strcmp(value, "json") != 0) {
                argp_error(state, "--format is table or json, not %s", value);
            }
            arguments->json = strcmp(value, "json") == 0;
            return 0;
        case 'o':
            arguments->off_text = value;
            parse_off(value, &arguments->off, state);
            return 0;
        case ARGP_KEY_ARG:
            if (arguments->plan != NULL) {
                argp_error(state, "one plan at a time, please: %s is too many", value);
            }
            arguments->plan = value;
            return 0;
        case ARGP_KEY_END:
            if (arguments->plan == NULL) {
                argp_error(state, "which plan? Give PLAN.json, or - for standard input");
            }
            return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

/// One judged figure; table, JSON and verdict all read this.
typedef struct {
    const char* group;
    const char* name; ///< of its key in JSON, unit included
    double value, limit;
    bool is_least; ///< whether the limit is the least that it may be, else the most, either way
} figure_t;

enum { MOST_FIGURES = 12, ARRIVAL_FIGURES = 4 };

static bool has_come_near(const replay_flight_t* flight) { return flight->nearest.obstacle != SIM_NO_OBSTACLE; }

/// @return how many figures there are: the last one only if the flight came near anything.
static size_t judge(const plan_file_t* plan, const replay_flight_t* flight, figure_t figure[MOST_FIGURES]) {
    static const struct {
        const char* name;
        double limit;
    } arrival[ARRIVAL_FIGURES] = {{"position_error_mm", REPLAY_POSITION_MAX_MM},
                                  {"pointing_error_deg", REPLAY_POINTING_MAX_DEG},
                                  {"speed_m_s", REPLAY_SPEED_MAX_M_S},
                                  {"rate_rad_s", REPLAY_RATE_MAX_RAD_S}};
    const replay_arrival_t* at[2] = {&flight->mate, &flight->dock};
    size_t n = 0;
    for (size_t e = 0; e < 2; e++) {
        const double value[ARRIVAL_FIGURES] = {at[e]->position_mm, at[e]->pointing_deg, at[e]->speed_m_s,
                                               at[e]->rate_rad_s};
        for (size_t i = 0; i < ARRIVAL_FIGURES; i++) {
            figure[n++] = (figure_t){e == 0 ? "mate" : "dock", arrival[i].name, value[i], arrival[i].limit, false};
        }
    }
    // The cost may be zero (a task already done); then any impulse at all is too much.
    const double difference_Ns = flight->impulse_Ns - plan->impulse_Ns;
    const double difference_percent = difference_Ns == 0 ? 0 : 100 * difference_Ns / fmax(plan->impulse_Ns, 1e-9);
    figure[n++] = (figure_t){"thrust", "max_over_force_max", flight->thrust_ratio, 1 + 1e-9 + plan->rounding, false};
    figure[n++] = (figure_t){"impulse", "error_percent", difference_percent, 0.5, false};
    figure[n++] = (figure_t){"time", "error_us", 1e6 * (flight->time_s - plan->time_s),
                             1 + 1e6 * plan->rounding * plan->time_s, false};
    if (has_come_near(flight)) {
        figure[n++] = (figure_t){"clearance", "least_mm", 1e3 * flight->nearest.least_m, 0, true};
    }
    return n;
}

static bool within(const figure_t* figure) {
    return figure->is_least ? figure->value >= figure->limit : fabs(figure->value) <= figure->limit;
}

static const char* body_of(const sim_nearest_t* nearest) { return nearest->is_beam ? "beam" : "vehicle"; }

static void print_clearance(const plan_file_t* plan, const sim_nearest_t* nearest) {
    char obstacle[24];
    snprintf(obstacle, sizeof obstacle, "obstacle %d", nearest->obstacle);
    printf("  %-16s %12.1f %12.1f %12s mm%s\n", "clearance", 1e3 * nearest->least_m, 1e3 * plan->clearance_m, "",
           nearest->least_m < 0                       ? " TOUCHED"
           : nearest->least_m < plan->around.margin_m ? ", below the margin"
                                                      : "");
    printf("  %-16s %s and %s at %.3f s; margin %.1f mm\n", "", body_of(nearest),
           nearest->obstacle == SIM_ITS_BEAM    ? "its beam"
           : nearest->obstacle == SIM_TANK_WALL ? "the tank's wall"
                                                : obstacle,
           nearest->t_s, 1e3 * plan->around.margin_m);
}

static bool print_table(const arguments_t* arguments, const plan_file_t* plan, const replay_flight_t* flight,
                        const figure_t* figure) {
    static const struct {
        const char* label;
        const char* unit;
    } row[ARRIVAL_FIGURES] = {
        {"position error", "mm"}, {"pointing error", "deg"}, {"residual speed", "m/s"}, {"residual rate", "rad/s"}};
    const figure_t* thrust = &figure[2 * ARRIVAL_FIGURES];
    const figure_t* impulse = thrust + 1;
    const figure_t* time = thrust + 2;
    printf("Plan %016" PRIx64 ", flown open loop%s%s\n\n", (uint64_t)plan->request_id,
           arguments->off_text == NULL ? "" : " with ", arguments->off_text == NULL ? "" : arguments->off_text);
    printf("  %-16s %12s %12s %12s\n", "", "at mate", "at dock", "limit");
    for (size_t i = 0; i < ARRIVAL_FIGURES; i++) {
        printf("  %-16s %12.4g %12.4g %12g %-6s%s\n", row[i].label, figure[i].value, figure[ARRIVAL_FIGURES + i].value,
               figure[i].limit, row[i].unit,
               within(&figure[i]) && within(&figure[ARRIVAL_FIGURES + i]) ? "" : " OUTSIDE");
    }
    printf("\n  %-16s %12s %12s %12s\n", "", "flown", "planned", "difference");
    printf("  %-16s %12.9f %12s %12s of F_MAX%s\n", "largest thrust", thrust->value, "<= 1", "",
           within(thrust) ? "" : " OUTSIDE");
    printf("  %-16s %12.4f %12.4f %11.4f%% N s%s\n", "impulse", flight->impulse_Ns, plan->impulse_Ns, impulse->value,
           within(impulse) ? "" : " OUTSIDE, limit 0.5 %");
    printf("  %-16s %12.6f %12.6f %9.3g us s%s\n", "time", flight->time_s, plan->time_s, time->value,
           within(time) ? "" : " OUTSIDE");
    if (has_come_near(flight)) {
        print_clearance(plan, &flight->nearest);
    }
    printf("\n  %" PRId64 " steps; the last refinement moved the end by %.1e m, %.1e rad.\n", flight->num_steps,
           flight->moved_m, flight->turned_rad);
    return fflush(stdout) == 0 && !ferror(stdout);
}

static json_t* clearance_json(const plan_file_t* plan, const sim_nearest_t* nearest) {
    return json_pack("{s:f, s:f, s:s, s:i, s:f}", "planned_mm", 1e3 * plan->clearance_m, "margin_mm",
                     1e3 * plan->around.margin_m, "body", body_of(nearest), "obstacle", nearest->obstacle, "t_s",
                     nearest->t_s);
}

static bool write_json(json_t* root) {
    const bool written = root != NULL && json_dumpf(root, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0 &&
                         putchar('\n') != EOF && fflush(stdout) == 0;
    json_decref(root);
    return written;
}

static bool print_json(const arguments_t* arguments, const plan_file_t* plan, const replay_flight_t* flight,
                       const figure_t* figure, size_t num, bool all_within) {
    json_t* outside = json_array();
    json_t* root = json_pack(
        "{s:o, s:s?, s:b, s:o, s:{}, s:{}, s:{}, s:{s:f, s:f}, s:{s:f, s:f}, s:{s:I, s:f, s:f}, s:o}", "request_id",
        json_sprintf("%016" PRIx64, (uint64_t)plan->request_id), "off", arguments->off_text, "within_tolerances",
        all_within, "outside", outside, "mate", "dock", "thrust", "impulse", "flown_Ns", flight->impulse_Ns,
        "planned_Ns", plan->impulse_Ns, "time", "flown_s", flight->time_s, "planned_s", plan->time_s, "integration",
        "steps", (json_int_t)flight->num_steps, "moved_m", flight->moved_m, "turned_rad", flight->turned_rad,
        "clearance", has_come_near(flight) ? clearance_json(plan, &flight->nearest) : json_null());
    for (size_t i = 0; i < num; i++) {
        json_object_set_new(json_object_get(root, figure[i].group), figure[i].name, json_real(figure[i].value));
        if (!within(&figure[i])) {
            json_array_append_new(outside, json_sprintf("%s.%s", figure[i].group, figure[i].name));
        }
    }
    return write_json(root);
}

/// Says why there is no verdict. @return the exit code.
static int not_judged(const arguments_t* arguments, const plan_file_t* plan, const replay_flight_t* flight,
                      replay_end_t end) {
    char reason[256];
    if (end == REPLAY_TOO_LONG) {
        snprintf(reason, sizeof reason,
                 "time constants are too short for a flight of %.0f s: it would take more than some 20 million steps",
                 flight->time_s);
    } else {
        snprintf(
            reason, sizeof reason,
            "the motion is so unstable that the rounding of doubles alone moves the end of the flight by %.2g m and "
            "%.2g rad",
            flight->moved_m, flight->turned_rad);
    }
    fprintf(stderr, "ssv-replay: %s: not judged: %s\n", arguments->plan, reason);
    if (arguments->json && !write_json(json_pack("{s:o, s:s?, s:n, s:s}", "request_id",
                                                 json_sprintf("%016" PRIx64, (uint64_t)plan->request_id), "off",
                                                 arguments->off_text, "within_tolerances", "not_judged", reason))) {
        fprintf(stderr, "ssv-replay: cannot write the result: %s\n", strerror(errno));
        return EXIT_OTHER;
    }
    return EXIT_NOT_JUDGED;
}

/// A line on the terminal, for flights that take their time.
typedef struct {
    double started_s, told_s;
    bool is_open;
} line_t;

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void tell(void* context, int run, double share) {
    line_t* line = context;
    const double time_s = now_s();
    if (time_s < line->started_s + 0.5 || time_s < line->told_s + 0.1) {
        return;
    }
    fprintf(stderr, "\r\033[Kflying, run %d: %.0f %%", run + 1, 100 * share);
    line->told_s = time_s;
    line->is_open = true;
}

static replay_end_t fly(const plan_file_t* plan, replay_flight_t* flight) {
    line_t line = {.started_s = now_s()};
    const replay_listener_t listener = {tell, &line};
    const replay_end_t end = replay_fly(plan, isatty(STDERR_FILENO) == 1 ? &listener : NULL, flight);
    if (line.is_open) {
        fputs("\r\033[K", stderr);
    }
    return end;
}

int main(int argc, char** argv) {
    const struct argp parser = {OPTIONS, parse_argument, "PLAN.json", DOC, NULL, NULL, NULL};
    arguments_t arguments = {.off = {1, 1, {1, 1, 1, 1, 1, 1}}};
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&parser, argc, argv, 0, NULL, &arguments);

    plan_file_t plan;
    char error[1024];
    if (!plan_file_read(arguments.plan, &plan, error, sizeof error)) {
        fprintf(stderr, "ssv-replay: %s\n", error);
        return EXIT_INVALID;
    }
    replay_put_off(&arguments.off, &plan);
    replay_flight_t flight;
    const replay_end_t end = fly(&plan, &flight);
    if (end != REPLAY_JUDGED) {
        const int code = not_judged(&arguments, &plan, &flight, end);
        plan_file_free(&plan);
        return code;
    }
    figure_t figure[MOST_FIGURES];
    const size_t num = judge(&plan, &flight, figure);
    bool all_within = true;
    for (size_t i = 0; i < num; i++) {
        all_within = all_within && within(&figure[i]);
    }
    const bool written = arguments.json ? print_json(&arguments, &plan, &flight, figure, num, all_within)
                                        : print_table(&arguments, &plan, &flight, figure);
    plan_file_free(&plan);
    if (!written) {
        fprintf(stderr, "ssv-replay: cannot write the result: %s\n", strerror(errno));
        return EXIT_OTHER;
    }
    return all_within ? EXIT_WITHIN : EXIT_OUTSIDE;
}
