// Turn, fly, turn, with everything that is free decided by J (DESIGN.md 6).
#include "planner/search.h"

#define NUM_DIRECTIONS 26
#define NUM_ROLLS 12
#define NUM_MATE_ROLLS 8
#define MAX_STARTS 16
#define MAX_PARAMETERS 9

// Directions this much dearer per metre than the cheapest are not drawn; the pattern search still finds its way in between.
#define DIRECTION_SLACK REAL(1.15)

// Travel attitudes that are priced, how many of the cheapest are refined, and sweeps of the pattern search on each.
typedef struct {
    int starts, refined, sweeps;
} budget_t;

static const budget_t budgets[] = {[SSV_EFFORT_QUICK] = {4, 1, 2}, [SSV_EFFORT_BEST] = {MAX_STARTS, 3, 10}};

typedef struct {
    int num;
    vec3_t n[NUM_DIRECTIONS];
    real_t price[NUM_DIRECTIONS];
} directions_t;

// The axes, edges and diagonals of the body that are cheap to fly along.
static void cheap_directions(const ssv_problem_t* problem, directions_t* d) {
    vec3_t n[NUM_DIRECTIONS];
    real_t price[NUM_DIRECTIONS], least = REAL(0);
    int num = 0;
    for (int x = -1; x <= 1; x++) {
        for (int y = -1; y <= 1; y++) {
            for (int z = -1; z <= 1; z++) {
                if (x == 0 && y == 0 && z == 0) continue;
                n[num] = vec3_unit(vec3(real_from_int(x), real_from_int(y), real_from_int(z)));
                price[num] = ssv_metre_price(problem, n[num]);
                if (num == 0 || price[num] < least) least = price[num];
                num++;
            }
        }
    }
    d->num = 0;
    for (int k = 0; k < num; k++) {
        if (price[k] > real_mul(DIRECTION_SLACK, least)) continue;
        d->n[d->num] = n[k];
        d->price[d->num++] = price[k];
    }
}

// ---- Geometry -----------------------------------------------------------------------------------------------------------

// Smallest rotation that takes unit vector from to unit vector to.
static quat_t align(vec3_t from, vec3_t to) {
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    ssv_grasp_turn_axes(from, to, axis, &angle);
    return quat_from_axis_angle(axis[0], angle);
}

// Angle of the shorter turn from one attitude to another.
static real_t turn_angle(quat_t q_from, quat_t q_to) {
    const quat_t q = quat_mul(quat_conj(q_from), q_to);
    return real_mul(REAL(2), real_atan2(vec3_norm(vec3(q.x, q.y, q.z)), real_abs(q.w)));
}

static real_t angle_between(vec3_t a, vec3_t b) { return real_atan2(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b)); }

// Where the vehicle stands after turning about a pivot from X to another attitude.
static pose_t turned(pose_t X, quat_t q_to, vec3_t pivot_S) {
    return (pose_t){vec3_add(X.p, vec3_sub(quat_apply(X.q, pivot_S), quat_apply(q_to, pivot_S))), q_to};
}

// Turn about a pivot, fly on while turning from one travel attitude to the other, turn about a pivot.
static void lay_flight(ssv_phase_t phase, pose_t X_from, pose_t X_to, const quat_t q_IT[2], const vec3_t pivot_S[2],
                       ssv_flight_t* flight) {
    const pose_t via[4] = {X_from, turned(X_from, q_IT[0], pivot_S[0]), turned(X_to, q_IT[1], pivot_S[1]), X_to};
    flight->num_moves = SSV_MAX_PHASE_MOVES;
    for (int k = 0; k < SSV_MAX_PHASE_MOVES; k++) flight->move[k] = ssv_move_between(phase, via[k], via[k + 1]);
}

// ---- What is chosen -----------------------------------------------------------------------------------------------------

// A phase's free numbers: changes of the travel attitude as the flight starts and ends [rad], and for the transfer the roll of
// the vehicle about its contact axis [rad] and both pivots as fractions of the way from S to C.
typedef struct {
    quat_t q_IT;
    real_t x[MAX_PARAMETERS];
} trial_t;

typedef struct {
    const ssv_problem_t* problem;
    ssv_phase_t phase;
    int contact;
    real_t height_m;
    pose_t X_from, X_to;         // ends of the transit; those of a transfer are its trials' to choose
    int num_parameters;
    int num_priced;
} task_t;

// What a trial amounts to.
typedef struct {
    ssv_assembly_t assembly;
    pose_t X_from;
    ssv_grasp_t grasp;
    ssv_flight_t flight;
} motion_t;

static void travel_attitudes(const trial_t* trial, quat_t q_IT[2]) {
    for (int end = 0; end < 2; end++) {
        const vec3_t change = vec3(trial->x[3 * end], trial->x[3 * end + 1], trial->x[3 * end + 2]);
        const real_t angle = vec3_norm(change);
        q_IT[end] = trial->q_IT;
        if (!(angle > REAL(0))) continue;
        q_IT[end] = quat_unit(quat_mul(trial->q_IT, quat_from_axis_angle(vec3_unit(change), angle)));
    }
}

// The transfer that travels with this attitude and mate roll. The beam's axis is where the vehicle holds it, so the smallest
// turns bring it there from where it lies and on to where it docks; they fix the ring angle and the roll of the docked beam.
static void lay_transfer(const task_t* task, const trial_t* trial, motion_t* motion) {
    const ssv_scenario_t* s = &task->problem->scenario;
    quat_t q_IT[2];
    travel_attitudes(trial, q_IT);
    const vec3_t axis_S = vec3(REAL(0), real_cos(trial->x[6]), real_sin(trial->x[6]));
    const vec3_t axis_start = quat_apply(s->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    quat_t q_IS = quat_unit(quat_mul(align(quat_apply(q_IT[0], axis_S), axis_start), q_IT[0]));
    vec3_t outward_B = quat_apply(quat_conj(s->X_IB.q), vec3_neg(quat_apply(q_IS, vec3(REAL(1), REAL(0), REAL(0)))));
    motion->grasp = (ssv_grasp_t){task->contact, task->height_m, real_atan2(outward_B.y, outward_B.x)};
    if (s->ring_angle_given) {
        const real_t missing = s->ring_angle_rad - motion->grasp.ring_angle_rad;
        q_IS = quat_unit(quat_mul(quat_from_axis_angle(axis_start, missing), q_IS));
        motion->grasp.ring_angle_rad = s->ring_angle_rad;
    }
    motion->X_from = (pose_t){ssv_grasp_position(s, &motion->grasp), q_IS};
    motion->assembly = ssv_vehicle_with_beam(task->problem, motion->X_from);

    const vec3_t p_BE = ssv_grasp_contact(s, task->contact);
    const vec3_t p_SE = pose_mul(motion->assembly.X_SB, (pose_t){p_BE, quat_identity()}).p;
    const vec3_t outward = quat_apply(q_IT[1], task->contact == 1 ? vec3_neg(axis_S) : axis_S);
    const quat_t q_dock = quat_unit(quat_mul(align(outward, vec3_neg(s->axis_I)), q_IT[1]));
    const pose_t X_dock = {vec3_sub(s->p_IP_m, quat_apply(q_dock, p_SE)), q_dock};
    const vec3_t centre = ssv_body_centre(&motion->assembly);
    const vec3_t pivot[2] = {vec3_scale(trial->x[7], centre), vec3_scale(trial->x[8], centre)};
    lay_flight(SSV_TRANSFER, motion->X_from, X_dock, q_IT, pivot, &motion->flight);
}

static void lay(const task_t* task, const trial_t* trial, motion_t* motion) {
    if (task->phase == SSV_TRANSFER) {
        lay_transfer(task, trial, motion);
        return;
    }
    const vec3_t centre[2] = {{REAL(0), REAL(0), REAL(0)}, {REAL(0), REAL(0), REAL(0)}};
    motion->assembly = ssv_vehicle_alone(task->problem);
    motion->X_from = task->X_from;
    quat_t q_IT[2];
    travel_attitudes(trial, q_IT);
    lay_flight(SSV_TRANSIT, task->X_from, task->X_to, q_IT, centre, &motion->flight);
}

static bool try_price(task_t* task, const trial_t* trial, real_t* price) {
    motion_t motion;
    lay(task, trial, &motion);
    ssv_flight_price(task->problem, &motion.assembly, motion.X_from, &motion.flight);
    *price = motion.flight.price.cost;
    task->num_priced++;
    return motion.flight.price.outcome == SSV_FEASIBLE;
}

// Compass search: each number in turn a step up and down, keeping what is cheaper; all steps shrink after a sweep in vain.
static void refine(task_t* task, int sweeps, trial_t* trial, real_t* price) {
    static const real_t start[MAX_PARAMETERS] = {REAL(0.2), REAL(0.2), REAL(0.2), REAL(0.2), REAL(0.2), REAL(0.2),
                                                REAL(0.3), REAL(0.5), REAL(0.5)};
    real_t scale = REAL(1);
    for (int n = 0; n < sweeps; n++) {
        bool improved = false;
        for (int k = 0; k < task->num_parameters; k++) {
            for (int side = -1; side <= 1; side += 2) {
                trial_t next = *trial;
                real_t next_price;
                next.x[k] += real_mul(real_from_int(side), real_mul(scale, start[k]));
                if (!try_price(task, &next, &next_price) || next_price >= *price) continue;
                *trial = next;
                *price = next_price;
                improved = true;
                break;
            }
        }
        if (!improved) scale = real_mul(REAL(0.4), scale);
    }
}

// ---- Where the search starts --------------------------------------------------------------------------------------------

typedef struct {
    trial_t trial;
    real_t price;
} start_t;

// Keeps the cheapest few, cheapest first.
static void keep(start_t* list, int* num, int most, const start_t* candidate) {
    int k = *num < most ? (*num)++ : *num;
    if (k == most) {
        if (candidate->price >= list[most - 1].price) return;
        k = most - 1;
    }
    for (; k > 0 && candidate->price < list[k - 1].price; k--) list[k] = list[k - 1];
    list[k] = *candidate;
}

// What a turn by some angle costs, roughly: between the square root of the angle (inertia) and the angle (drag).
static real_t turn_guess(real_t one_rad, real_t angle) { return real_mul(one_rad, real_sqrt(real_mul(angle, real_sqrt(angle)))); }

// Price of a turn by one radian about z through S.
static real_t one_radian(const ssv_problem_t* problem, const ssv_assembly_t* assembly) {
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    const ssv_move_t turn = ssv_move_turn(SSV_TRANSFER, vec3(REAL(0), REAL(0), REAL(1)), REAL(1), zero);
    ssv_thrusts_t thrusts;
    ssv_profile_t profile;
    ssv_ramp_t ramp;
    ssv_move_thrusts(problem, assembly, turn.twist, &thrusts);
    return ssv_move_solve(problem, &turn, &thrusts, &profile, &ramp).cost;
}

// Travel attitudes for a flight along way_I: cheap body directions, rolled about the line. Where there is no way to go, along
// other_I. @return how many were written, cheapest first by estimate.
static int draw(task_t* task, const directions_t* directions, vec3_t way_I, vec3_t other_I, int most, start_t* list) {
    const real_t distance = vec3_norm(way_I);
    const vec3_t direction_I = distance > REAL(1e-6) ? vec3_unit(way_I) : other_I;
    const ssv_scenario_t* s = &task->problem->scenario;
    const bool carries = task->phase == SSV_TRANSFER;
    const vec3_t axis_start = quat_apply(s->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    const vec3_t axis_end = vec3_scale(task->contact == 1 ? REAL(1) : REAL(-1), s->axis_I);
    const int mate_rolls = carries ? NUM_MATE_ROLLS : 1;
    const real_t turn = real_mul(REAL(2), REAL_PI);
    ssv_assembly_t assembly = ssv_vehicle_alone(task->problem);
    if (carries) {
        assembly.beam = &s->beam;
        assembly.X_SB = (pose_t){vec3(s->standoff_m, -task->height_m, REAL(0)),
                                 align(vec3(REAL(0), REAL(0), REAL(1)), vec3(REAL(0), REAL(1), REAL(0)))};
    }
    const real_t one_rad = one_radian(task->problem, &assembly);
    int num = 0;
    for (int k = 0; k < directions->num; k++) {
        const quat_t q_line = align(directions->n[k], direction_I);
        for (int r = 0; r < NUM_ROLLS; r++) {
            const real_t roll = real_div(real_mul(turn, real_from_int(r)), real_from_int(NUM_ROLLS));
            start_t start;
            start.trial.q_IT = quat_unit(quat_mul(quat_from_axis_angle(direction_I, roll), q_line));
            for (int m = 0; m < mate_rolls; m++) {
                for (int i = 0; i < MAX_PARAMETERS; i++) start.trial.x[i] = REAL(0);
                start.price = real_mul(distance, directions->price[k]);
                if (carries) {
                    const real_t mate_roll = real_div(real_mul(turn, real_from_int(m)), real_from_int(NUM_MATE_ROLLS));
                    const vec3_t axis = quat_apply(start.trial.q_IT, vec3(REAL(0), real_cos(mate_roll), real_sin(mate_roll)));
                    start.trial.x[6] = mate_roll;
                    start.price += turn_guess(one_rad, angle_between(axis_start, axis)) +
                                   turn_guess(one_rad, angle_between(axis, axis_end));
                } else {
                    start.price += turn_guess(one_rad, turn_angle(task->X_from.q, start.trial.q_IT)) +
                                   turn_guess(one_rad, turn_angle(start.trial.q_IT, task->X_to.q));
                }
                keep(list, &num, most, &start);
            }
        }
    }
    return num;
}

static void sort(start_t* list, int num) {
    for (int i = 1; i < num; i++) {
        const start_t item = list[i];
        int k = i;
        for (; k > 0 && item.price < list[k - 1].price; k--) list[k] = list[k - 1];
        list[k] = item;
    }
}

// Prices the starts, refines the cheapest if asked to, and lays out the best motion.
static bool settle(task_t* task, const budget_t* budget, bool thorough, start_t* list, int num, motion_t* motion) {
    int priced = 0;
    for (int k = 0; k < num; k++) {
        if (try_price(task, &list[k].trial, &list[k].price)) list[priced++] = list[k];
    }
    if (priced == 0) return false;
    sort(list, priced);
    for (int k = 0; thorough && k < priced && k < budget->refined; k++) {
        refine(task, budget->sweeps, &list[k].trial, &list[k].price);
    }
    sort(list, priced);
    lay(task, &list[0].trial, motion);
    ssv_flight_price(task->problem, &motion->assembly, motion->X_from, &motion->flight);
    return motion->flight.price.outcome == SSV_FEASIBLE;
}

void ssv_search_optimal(const ssv_problem_t* problem, int contact, real_t height_m, ssv_effort_t effort, bool thorough,
                        ssv_chain_t* best, int* num_priced) {
    const ssv_scenario_t* s = &problem->scenario;
    const budget_t* budget = &budgets[effort];
    const vec3_t axis_start = quat_apply(s->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    directions_t directions;
    start_t list[MAX_STARTS];
    motion_t to_port, to_beam;
    cheap_directions(problem, &directions);

    // The phases hang together by little more than the height: the transfer is chosen first, the transit flies to where it starts.
    task_t carry = {problem, SSV_TRANSFER, contact, height_m, s->X_IS, s->X_IS, MAX_PARAMETERS, 0};
    const real_t from_contact = real_abs(ssv_grasp_contact(s, contact).z - height_m);
    const vec3_t way = vec3_sub(vec3_add(s->p_IP_m, vec3_scale(from_contact, s->axis_I)),
                                vec3_add(s->X_IB.p, vec3_scale(height_m, axis_start)));
    int num = draw(&carry, &directions, way, axis_start, budget->starts, list);
    const bool carried = settle(&carry, budget, thorough, list, num, &to_port);
    *num_priced += carry.num_priced;
    best->grasp = (ssv_grasp_t){contact, height_m, REAL(0)};
    best->price = (ssv_price_t){SSV_NO_AUTHORITY, REAL(0), REAL(0), REAL(0)};
    if (!carried) return;

    task_t fly = {problem, SSV_TRANSIT, contact, height_m, s->X_IS, to_port.X_from, 6, 0};
    num = draw(&fly, &directions, vec3_sub(to_port.X_from.p, s->X_IS.p), axis_start, budget->starts, list);
    const bool flown = settle(&fly, budget, thorough, list, num, &to_beam);
    *num_priced += fly.num_priced;
    if (flown) ssv_chain_join(&to_port.grasp, &to_beam.flight, &to_port.flight, to_port.assembly.X_SB, best);
}
