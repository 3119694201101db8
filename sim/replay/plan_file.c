#include "plan_file.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_scenario_t.h"
#include "lcm_ssv_scene_t.h"
#include "wire/message.h"

#define MAX_DURATION_S 1e5
#define UNIT_TOLERANCE 1e-3
#define PI 3.14159265358979323846

/// A few roundings in float; the other arithmetics' are below every tolerance here.
#define FLOAT_ROUNDING (4.0 * (double)FLT_EPSILON)

/// How exactly the price of a plan is known, relative and at least, but for what float rounds over some ten legs.
#define PRICE_TOLERANCE 1e-6
#define PRICE_ROUNDINGS 40

/// Ranges wide enough for any vehicle in any tank; they keep the arithmetic finite.
typedef enum { POSITIVE, NOT_NEGATIVE, ANY } sign_t;
#define LARGEST 1e10
#define SMALLEST 1e-6

/// The first thing found wrong stays; checking goes on, so callers need not look after each step.
typedef struct {
    const char* file;
    char* error;
    size_t error_size;
    bool failed;
    double rounding; ///< [-] of a number, relative, by the arithmetic that the plan was computed in
} reader_t;

__attribute__((format(printf, 3, 4))) static void fail(reader_t* reader, const char* path, const char* format, ...) {
    if (reader->failed) {
        return;
    }
    reader->failed = true;
    char sentence[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    snprintf(reader->error, reader->error_size, "%s: %s: %s", reader->file, path, sentence);
    tree_make_harmless(reader->error);
}

static double number(reader_t* reader, const char* path, double value, sign_t sign) {
    const double min = sign == POSITIVE ? SMALLEST : sign == NOT_NEGATIVE ? 0 : -LARGEST;
    if (!(value >= min && value <= LARGEST)) {
        fail(reader, path, "%.9g is outside [%g, %g]", value, min, LARGEST);
    }
    return value;
}

static void numbers(reader_t* reader, const char* path, const double* values, size_t count, sign_t sign, double* out) {
    for (size_t i = 0; i < count; i++) {
        char element[112];
        snprintf(element, sizeof element, "%s[%zu]", path, i);
        out[i] = number(reader, element, values[i], sign);
    }
}

/// Likewise of length 1, which it then has exactly.
static void unit(reader_t* reader, const char* path, const double* values, size_t count, double* out) {
    double square = 0;
    numbers(reader, path, values, count, ANY, out);
    for (size_t i = 0; i < count; i++) {
        square += out[i] * out[i];
    }
    const double norm = sqrt(square);
    if (!(fabs(norm - 1) <= UNIT_TOLERANCE)) {
        fail(reader, path, "has length %.9g, must be 1 within %g", norm, UNIT_TOLERANCE);
    }
    for (size_t i = 0; i < count; i++) {
        out[i] /= norm;
    }
}

/// All numbers of a body but its mass resist motion or turning, so each is checked by the sign that it may have.
static rb_body_t body(reader_t* reader, const char* path, const lcm_ssv_body_t* from) {
    rb_body_t b = {.mass_kg = from->mass_kg,
                   .drag_lin_kg_s = from->drag_lin_kg_s,
                   .drag_quad_kg_m = from->drag_quad_kg_m,
                   .drag_lin_ang_Nm_s = from->drag_lin_ang_Nm_s,
                   .drag_quad_ang_Nm_s2 = from->drag_quad_ang_Nm_s2};
    const struct {
        const char* key;
        const double* values;
        size_t count;
        sign_t sign;
        double* out;
    } fields[] = {
        {"mass_kg", &from->mass_kg, 1, POSITIVE, &b.mass_kg},
        {"inertia_kg_m2", from->inertia_kg_m2, 3, POSITIVE, b.inertia_kg_m2},
        {"added_mass_kg", from->added_mass_kg, 3, NOT_NEGATIVE, b.added_mass_kg},
        {"drag_lin_kg_s", &from->drag_lin_kg_s, 1, NOT_NEGATIVE, &b.drag_lin_kg_s},
        {"drag_quad_kg_m", &from->drag_quad_kg_m, 1, NOT_NEGATIVE, &b.drag_quad_kg_m},
        {"drag_lin_ang_Nm_s", &from->drag_lin_ang_Nm_s, 1, NOT_NEGATIVE, &b.drag_lin_ang_Nm_s},
        {"drag_quad_ang_Nm_s2", &from->drag_quad_ang_Nm_s2, 1, NOT_NEGATIVE, &b.drag_quad_ang_Nm_s2},
    };
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        char key[96];
        snprintf(key, sizeof key, "%s.%s", path, fields[i].key);
        if (fields[i].count == 1) {
            *fields[i].out = number(reader, key, *fields[i].values, fields[i].sign);
        } else {
            numbers(reader, key, fields[i].values, fields[i].count, fields[i].sign, fields[i].out);
        }
    }
    return b;
}

static void take_task(reader_t* reader, const lcm_ssv_scenario_t* scenario, plan_file_t* plan) {
    plan->vehicle = body(reader, "scenario.vehicle.body", &scenario->vehicle.body);
    plan->force_max_N = number(reader, "scenario.vehicle.force_max_N", scenario->vehicle.force_max_N, POSITIVE);
    for (size_t i = 0; i < PLAN_THRUSTERS; i++) {
        char path[96];
        snprintf(path, sizeof path, "scenario.vehicle.thruster[%zu].p_ST_m", i);
        numbers(reader, path, scenario->vehicle.thruster[i].p_ST_m, 3, ANY, plan->thruster[i].r_m);
        snprintf(path, sizeof path, "scenario.vehicle.thruster[%zu].n_T_S", i);
        unit(reader, path, scenario->vehicle.thruster[i].n_T_S, 3, plan->thruster[i].n);
    }
    plan->beam = body(reader, "scenario.beam.body", &scenario->beam.body);
    plan->beam.length_m = number(reader, "scenario.beam.length_m", scenario->beam.length_m, POSITIVE);
    plan->beam.strip_kg_m2 =
        number(reader, "scenario.beam.drag_strip_kg_m2", scenario->beam.drag_strip_kg_m2, NOT_NEGATIVE);
    numbers(reader, "scenario.X_IS.p_m", scenario->X_IS.p_m, 3, ANY, plan->X_IS.p_m);
    unit(reader, "scenario.X_IS.q", scenario->X_IS.q, 4, plan->X_IS.q);
    numbers(reader, "scenario.X_IB.p_m", scenario->X_IB.p_m, 3, ANY, plan->X_IB.p_m);
    unit(reader, "scenario.X_IB.q", scenario->X_IB.q, 4, plan->X_IB.q);
    numbers(reader, "scenario.port.p_IP_m", scenario->port.p_IP_m, 3, ANY, plan->p_IP_m);
    unit(reader, "scenario.port.axis_I", scenario->port.axis_I, 3, plan->axis_I);
    plan->standoff_m = number(reader, "scenario.standoff_m", scenario->standoff_m, POSITIVE);
}

/// The choice must be one that the scenario leaves open, else the plan answers another question.
static void take_choice(reader_t* reader, const lcm_ssv_scenario_t* scenario, const lcm_ssv_choice_t* choice,
                        plan_file_t* plan) {
    const lcm_ssv_options_t* const options = &scenario->options;
    if (choice->contact != 1 && choice->contact != 2) {
        fail(reader, "plan.quote.choice.contact", "%d is neither 1 nor 2", choice->contact);
    }
    if (scenario->contact != 0 && scenario->contact != choice->contact) {
        fail(reader, "plan.quote.choice.contact", "%d is not the %d of scenario.contact", choice->contact,
             scenario->contact);
    }
    plan->contact = choice->contact;

    const double h = number(reader, "plan.quote.choice.attach_height_m", choice->attach_height_m, ANY);
    const double rounding_m = 1e-9 + reader->rounding * fabs(h);
    bool listed = options->num_attach_heights <= 0 || options->attach_anywhere;
    for (int i = 0; i < options->num_attach_heights && i < 8; i++) {
        listed = fabs(options->attach_heights_m[i] - h) <= rounding_m || listed;
    }
    if (!listed) {
        fail(reader, "plan.quote.choice.attach_height_m", "%.9g is not among scenario.options.attach_heights_m", h);
    }
    if (fabs(h) > plan->beam.length_m / 2 + rounding_m) {
        fail(reader, "plan.quote.choice.attach_height_m", "%.9g is off the beam, which ends at +-%.9g", h,
             plan->beam.length_m / 2);
    }
    plan->attach_height_m = h;

    plan->ring_angle_rad = number(reader, "plan.quote.choice.ring_angle_rad", choice->ring_angle_rad, ANY);
    if (options->ring_angle_given) {
        const double asked_rad = number(reader, "scenario.options.ring_angle_rad", options->ring_angle_rad, ANY);
        if (fabs(remainder(plan->ring_angle_rad - asked_rad, 2 * PI)) > 1e-9 + reader->rounding * PI) {
            fail(reader, "plan.quote.choice.ring_angle_rad", "%.9g is not the %.9g of scenario.options.ring_angle_rad",
                 plan->ring_angle_rad, asked_rad);
        }
    }
}

/// A point at the end of a path into the scene.
static void point(reader_t* reader, const char* path, const char* key, const double from_m[3], double to_m[3]) {
    char place[96];
    snprintf(place, sizeof place, "%s.%s", path, key);
    numbers(reader, place, from_m, 3, ANY, to_m);
}

static void take_obstacle(reader_t* reader, int k, const lcm_ssv_obstacle_t* from, sim_obstacle_t* to) {
    char path[64], place[96];
    double p_m[3], axis[3] = {0};
    snprintf(path, sizeof path, "scene.obstacles[%d]", k);
    snprintf(place, sizeof place, "%s.axis_I", path);
    point(reader, path, "p_I_m", from->p_I_m, p_m);
    to->is_wall = from->kind == LCM_SSV_OBSTACLE_T_KIND_WALL;
    if (to->is_wall || from->length_m != 0) {
        unit(reader, place, from->axis_I, 3, axis);
    }
    for (int i = 0; i < 3; i++) {
        to->wall.n[i] = axis[i];
        to->wall.offset_m += axis[i] * p_m[i];
        to->capsule.a_m[i] = p_m[i];
        to->capsule.b_m[i] = p_m[i] + from->length_m * axis[i];
    }
    snprintf(place, sizeof place, "%s.length_m", path);
    number(reader, place, from->length_m, NOT_NEGATIVE);
    snprintf(place, sizeof place, "%s.radius_m", path);
    to->capsule.radius_m = number(reader, place, from->radius_m, NOT_NEGATIVE);
}

static void take_scene(reader_t* reader, const lcm_ssv_scenario_t* scenario, const lcm_ssv_scene_t* scene,
                       plan_file_t* plan) {
    sim_surroundings_t* around = &plan->around;
    const uint64_t all =
        scene->num_obstacles >= SIM_OBSTACLES ? ~UINT64_C(0) : (UINT64_C(1) << scene->num_obstacles) - 1;
    around->num_obstacles = scene->num_obstacles;
    around->chosen = (uint64_t)scenario->obstacles;
    around->left = (uint64_t)scenario->left;
    if ((around->chosen & ~all) != 0) {
        fail(reader, "scenario.obstacles", "chooses more than the %d obstacles of the scene", scene->num_obstacles);
    }
    if ((around->left & ~around->chosen) != 0) {
        fail(reader, "scenario.left", "has obstacles that scenario.obstacles does not choose");
    }
    for (int k = 0; k < scene->num_obstacles && !reader->failed; k++) {
        take_obstacle(reader, k, &scene->obstacles[k], &around->obstacle[k]);
    }
    around->tank.kind = scene->tank.kind == LCM_SSV_TANK_T_KIND_BOX        ? SIM_BOX
                        : scene->tank.kind == LCM_SSV_TANK_T_KIND_CYLINDER ? SIM_CYLINDER
                                                                           : SIM_NO_TANK;
    point(reader, "scene.tank", "from_I_m", scene->tank.from_I_m, around->tank.from_m);
    point(reader, "scene.tank", "to_I_m", scene->tank.to_I_m, around->tank.to_m);
    around->tank.radius_m = number(reader, "scene.tank.radius_m", scene->tank.radius_m, NOT_NEGATIVE);
    around->margin_m = number(reader, "scenario.margin_m", scenario->margin_m, NOT_NEGATIVE);
    around->approach_mate_m = number(reader, "scenario.approach_mate_m", scenario->approach_mate_m, NOT_NEGATIVE);
    around->approach_dock_m = number(reader, "scenario.approach_dock_m", scenario->approach_dock_m, NOT_NEGATIVE);
    around->counts = around->chosen != 0 || around->tank.kind != SIM_NO_TANK || around->margin_m > 0;
    around->hull_radius_m = number(reader, "scenario.vehicle.radius_m", scenario->vehicle.radius_m, POSITIVE);
    around->beam_radius_m = number(reader, "scenario.beam.radius_m", scenario->beam.radius_m, POSITIVE);
}

/// What the watch over a flight knows of task and choice, where anything stands around.
static void complete_surroundings(plan_file_t* plan) {
    sim_surroundings_t* around = &plan->around;
    around->beam_length_m = plan->beam.length_m;
    around->X_nb = plan->X_IS;
    around->X_nB = plan->X_IB;
    around->place = (sim_mate_place_t){plan->standoff_m, plan->attach_height_m, plan->ring_angle_rad};
    around->port.contact = plan->contact;
    memcpy(around->port.p_nP_m, plan->p_IP_m, sizeof around->port.p_nP_m);
    memcpy(around->port.axis_n, plan->axis_I, sizeof around->port.axis_n);
}

static double tolerance_at(const reader_t* reader, double t_s) {
    return PLAN_TIME_TOLERANCE_S + reader->rounding * fabs(t_s);
}

/// Where an event falls: how many segments end at or before it. An event within a segment is refused.
static size_t segments_before(reader_t* reader, const char* path, const lcm_ssv_event_t* event, int8_t kind,
                              const lcm_ssv_plan_t* from) {
    const double tolerance_s = tolerance_at(reader, event->t_s);
    if (event->kind != kind) {
        fail(reader, path, "must be of kind \"%s\": a plan mates, then docks",
             kind == LCM_SSV_EVENT_T_KIND_MATE ? "mate" : "dock");
    }
    double end_s = 0;
    size_t n = 0;
    while (n < (size_t)from->num_segments &&
           from->segments[n].t_s + from->segments[n].duration_s <= event->t_s + tolerance_s) {
        end_s = from->segments[n].t_s + from->segments[n].duration_s;
        n++;
    }
    if (!(fabs(end_s - event->t_s) <= tolerance_s)) {
        fail(reader, path, "t_s %.9g is not where a timeline segment ends", event->t_s);
    }
    return n;
}

static void take_segments(reader_t* reader, const lcm_ssv_plan_t* from, plan_file_t* plan) {
    double end_s = 0;
    for (int i = 0; i < from->num_segments; i++) {
        const lcm_ssv_segment_t* const segment = &from->segments[i];
        plan_segment_t* const to = &plan->segment[i];
        char path[64], list[96];
        snprintf(path, sizeof path, "plan.segments[%d]", i);
        if (!(fabs(segment->t_s - end_s) <= tolerance_at(reader, end_s))) {
            fail(reader, path, "starts at t_s %.9g, must start at %.9g where the one before ends", segment->t_s, end_s);
        }
        if (!(segment->duration_s > 0)) {
            fail(reader, path, "duration_s must be positive");
        }
        to->duration_s = segment->duration_s;
        end_s = segment->t_s + segment->duration_s;
        snprintf(list, sizeof list, "%s.u_start_N", path);
        numbers(reader, list, segment->u_start_N, PLAN_THRUSTERS, ANY, to->u_start_N);
        snprintf(list, sizeof list, "%s.u_end_N", path);
        numbers(reader, list, segment->u_end_N, PLAN_THRUSTERS, ANY, to->u_end_N);
        if (segment->leg < (i == 0 ? 0 : from->segments[i - 1].leg) || segment->leg >= from->num_legs) {
            fail(reader, path, "leg %d must count up from 0 and stay below the %d legs", segment->leg, from->num_legs);
        }
    }
    if (!(end_s <= MAX_DURATION_S)) {
        fail(reader, "plan.segments", "last %.9g s, at most %g s are accepted", end_s, MAX_DURATION_S);
    }
}

static void take_timeline(reader_t* reader, const lcm_ssv_plan_t* from, plan_file_t* plan) {
    plan->segment = calloc((size_t)from->num_segments + 1, sizeof *plan->segment);
    if (plan->segment == NULL) {
        fail(reader, "plan.segments", "not enough memory for %d of them", from->num_segments);
        return;
    }
    plan->num_segments = (size_t)from->num_segments;
    take_segments(reader, from, plan);
    if (from->num_events != 2) {
        fail(reader, "plan.events", "must be two: mate, then dock");
    }
    if (reader->failed) {
        return;
    }
    plan->num_transit_segments =
        segments_before(reader, "plan.events[0]", &from->events[0], LCM_SSV_EVENT_T_KIND_MATE, from);
    // Of segments that are shorter than what instants are told apart by, those after the mate are of the transfer.
    const double mate_s = from->events[0].t_s;
    while (plan->num_transit_segments > 0) {
        const lcm_ssv_segment_t* const last = &from->segments[plan->num_transit_segments - 1];
        if (from->legs[last->leg].phase == LCM_SSV_LEG_T_PHASE_TRANSIT ||
            !(fabs(last->t_s - mate_s) <= tolerance_at(reader, mate_s))) {
            break;
        }
        plan->num_transit_segments--;
    }
    if (segments_before(reader, "plan.events[1]", &from->events[1], LCM_SSV_EVENT_T_KIND_DOCK, from) !=
        plan->num_segments) {
        fail(reader, "plan.events[1]", "must be where the timeline ends");
    }
    for (int i = 0; i < from->num_segments; i++) {
        const bool transit = (size_t)i < plan->num_transit_segments;
        const int leg = from->segments[i].leg;
        if (from->legs[leg].phase != (transit ? LCM_SSV_LEG_T_PHASE_TRANSIT : LCM_SSV_LEG_T_PHASE_TRANSFER)) {
            char path[64];
            snprintf(path, sizeof path, "plan.legs[%d]", leg);
            fail(reader, path, "must be of phase \"%s\": that is when plan.segments[%d] flies it",
                 transit ? "transit" : "transfer", i);
        }
    }
}

/// The price must be that of time and impulse, and no less than its bound.
static void check_price(reader_t* reader, const lcm_ssv_scenario_t* scenario, const lcm_ssv_quote_t* quote) {
    const double w_time = number(reader, "scenario.weight_time_per_s", scenario->weight_time_per_s, NOT_NEGATIVE);
    const double w_impulse =
        number(reader, "scenario.weight_impulse_per_Ns", scenario->weight_impulse_per_Ns, NOT_NEGATIVE);
    const double cost = w_time * quote->time_s + w_impulse * quote->impulse_Ns;
    const double slack = (PRICE_TOLERANCE + PRICE_ROUNDINGS * reader->rounding) * fmax(1, cost);
    if (!(fabs(quote->cost - cost) <= slack)) {
        fail(reader, "plan.quote.cost", "%.9g is not the %.9g of time_s and impulse_Ns by the scenario's weights",
             quote->cost, cost);
    }
    if (!(quote->cost_lower_bound >= 0 && quote->cost_lower_bound <= quote->cost + slack)) {
        fail(reader, "plan.quote.cost_lower_bound", "%.9g is outside [0, %.9g], the cost", quote->cost_lower_bound,
             quote->cost);
    }
}

static void take_plan(reader_t* reader, const lcm_ssv_scenario_t* scenario, const lcm_ssv_scene_t* scene,
                      const lcm_ssv_plan_t* from, plan_file_t* plan) {
    reader->rounding = from->answer.planner.scalar == LCM_SSV_PLANNER_T_SCALAR_FLOAT ? FLOAT_ROUNDING : 0;
    plan->rounding = reader->rounding;
    plan->request_id = from->answer.asker.request_id;
    plan->time_s = number(reader, "plan.quote.time_s", from->quote.time_s, NOT_NEGATIVE);
    plan->impulse_Ns = number(reader, "plan.quote.impulse_Ns", from->quote.impulse_Ns, NOT_NEGATIVE);
    check_price(reader, scenario, &from->quote);
    take_task(reader, scenario, plan);
    take_choice(reader, scenario, &from->quote.choice, plan);
    take_scene(reader, scenario, scene, plan);
    complete_surroundings(plan);
    plan->clearance_m = number(reader, "plan.clearance.certified_m", from->clearance.certified_m, ANY);
    take_timeline(reader, from, plan);
}

/// Reads the messages from the text. A refusal comes without its question, so the status is looked at in between.
static bool read_messages(reader_t* reader, const char* text, size_t size, lcm_ssv_scenario_t* scenario,
                          lcm_ssv_scene_t* scene, lcm_ssv_plan_t* plan) {
    const wire_part_t answer = {"plan", "plan_t", plan};
    const wire_part_t question[2] = {{"scenario", "scenario_t", scenario}, {"scene", "scene_t", scene}};
    if (!wire_json_read(reader->file, text, size, &answer, 1, reader->error, reader->error_size)) {
        return false;
    }
    if (plan->quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        fail(reader, "plan.quote.status", "only an \"ok\" plan can be flown (reason: %.300s)", plan->quote.reason);
    }
    if (reader->failed || !wire_json_read(reader->file, text, size, question, 2, reader->error, reader->error_size)) {
        wire_clear("plan_t", plan);
        return false;
    }
    return true;
}

bool plan_file_read(const char* path, plan_file_t* plan, char* error, size_t error_size) {
    reader_t reader = {strcmp(path, "-") == 0 ? "standard input" : path, error, error_size, false, 0};
    tree_error_t unreadable = {error, error_size};
    lcm_ssv_scenario_t scenario;
    lcm_ssv_scene_t scene;
    lcm_ssv_plan_t message;
    size_t size = 0;
    error[0] = '\0';
    memset(plan, 0, sizeof *plan);
    char* const text = tree_file_read(path, &size, &unreadable);
    const bool read = text != NULL && read_messages(&reader, text, size, &scenario, &scene, &message);
    free(text);
    if (!read) {
        return false;
    }
    take_plan(&reader, &scenario, &scene, &message, plan);
    wire_clear("plan_t", &message);
    if (reader.failed) {
        plan_file_free(plan);
    }
    return !reader.failed;
}

void plan_file_free(plan_file_t* plan) {
    free(plan->segment);
    plan->segment = NULL;
}
