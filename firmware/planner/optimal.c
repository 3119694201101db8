// Turn, translate, turn, with everything that is free decided by J (DESIGN.md 12).
//
// A straight flight costs almost the same per metre for the vehicle alone and with a beam, and it depends only on the body
// direction flown in; the turns at its ends take seconds. So travel attitudes are drawn from body directions that are cheap
// per metre, rolled about the line of flight, ranked by an estimate, and the best are refined by a pattern search on the real
// price of both turns.
#include "planner/alloc.h"
#include "planner/search.h"

#define NUM_DIRECTIONS 26
#define NUM_ROLLS 12
#define NUM_MATE_ROLLS 8
#define MAX_STARTS 6
#define MAX_PARAMETERS 6

// Directions this much dearer per metre than the cheapest are not drawn; the pattern search still finds its way in between.
#define DIRECTION_SLACK REAL(1.15)

typedef struct {
    int starts, sweeps; // travel attitudes that are refined, and sweeps of the pattern search on each
} effort_t;

static const effort_t quick = {1, 3}, best_effort = {4, 12};

// ---- Prices that need no profile ----------------------------------------------------------------------------------------

// Cost per metre of a straight flight along the body direction n at its cheapest speed, by the vehicle's linear drag: the
// thrusts are proportional to the speed, so the cheapest is the fastest.
static real_t metre_price(const ssv_problem_t* problem, vec3_t n) {
    const ssv_scenario_t* s = &problem->scenario;
    real_t u[SSV_NUM_THRUSTERS], largest = REAL(0), sum = REAL(0);
    ssv_alloc(&problem->allocation, vec3_scale(s->vehicle.body.drag_lin_kg_s, n), vec3(REAL(0), REAL(0), REAL(0)), u);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        largest = real_max(largest, real_abs(u[i]));
        sum += real_abs(u[i]);
    }
    return real_mul(s->weight_time_per_s, real_div(largest, s->vehicle.force_max_N)) + real_mul(s->weight_impulse_per_Ns, sum);
}

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
                price[num] = metre_price(problem, n[num]);
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

static ssv_price_t turn_price(const ssv_problem_t* problem, const ssv_assembly_t* assembly, const ssv_move_t* turn) {
    ssv_thrusts_t thrusts;
    ssv_profile_t profile;
    ssv_ramp_t ramp;
    ssv_move_thrusts(problem, assembly, turn->twist, &thrusts);
    return ssv_move_solve(problem, turn, &thrusts, &profile, &ramp);
}

// ---- Geometry -----------------------------------------------------------------------------------------------------------

// Smallest rotation that takes unit vector from to unit vector to.
static quat_t align(vec3_t from, vec3_t to) {
    vec3_t axis[SSV_NUM_TURN_AXES];
    real_t angle;
    ssv_grasp_turn_axes(from, to, axis, &angle);
    return quat_from_axis_angle(axis[0], angle);
}

// The shorter way round from one attitude to another, about a pivot.
static ssv_move_t turn_between(ssv_phase_t phase, quat_t q_from, quat_t q_to, vec3_t pivot_S) {
    quat_t q = quat_mul(quat_conj(q_from), q_to);
    if (q.w < REAL(0)) q = (quat_t){-q.w, -q.x, -q.y, -q.z};
    const vec3_t e = vec3(q.x, q.y, q.z);
    const real_t sine = vec3_norm(e);
    const vec3_t axis = sine > REAL(1e-12) ? vec3_unit(e) : vec3(REAL(0), REAL(0), REAL(1));
    return ssv_move_turn(phase, axis, real_mul(REAL(2), real_atan2(sine, q.w)), pivot_S);
}

static real_t angle_between(vec3_t a, vec3_t b) { return real_atan2(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b)); }

// Turn about a pivot, translate, turn about a pivot, from X_from to X_to through travel attitude q_IT.
static void lay_flight(ssv_phase_t phase, pose_t X_from, pose_t X_to, quat_t q_IT, const vec3_t pivot_S[2], ssv_flight_t* flight) {
    const ssv_move_t first = turn_between(phase, X_from.q, q_IT, pivot_S[0]);
    const ssv_move_t last = turn_between(phase, q_IT, X_to.q, pivot_S[1]);
    const pose_t X_depart = ssv_move_pose(X_from, first.twist, first.length);
    const vec3_t p_IA_m = vec3_add(X_to.p, vec3_sub(quat_apply(X_to.q, pivot_S[1]), quat_apply(q_IT, pivot_S[1])));
    flight->num_moves = SSV_MAX_PHASE_MOVES;
    flight->move[0] = first;
    flight->move[1] = ssv_move_translate(phase, quat_apply(quat_conj(X_depart.q), vec3_sub(p_IA_m, X_depart.p)));
    flight->move[2] = last;
}

// Price of a flight with real turns and the straight part by its price per metre.
static real_t estimate(const ssv_problem_t* problem, const ssv_assembly_t* assembly, const ssv_flight_t* flight, bool* feasible) {
    const ssv_price_t first = turn_price(problem, assembly, &flight->move[0]);
    const ssv_price_t last = turn_price(problem, assembly, &flight->move[2]);
    *feasible = first.outcome == SSV_FEASIBLE && last.outcome == SSV_FEASIBLE;
    return first.cost + last.cost + real_mul(flight->move[1].length, metre_price(problem, flight->move[1].twist.v));
}

// ---- What is chosen -----------------------------------------------------------------------------------------------------

// A phase's free numbers: a change of travel attitude [rad], and for the transfer the roll of the vehicle about its contact
// axis [rad] and both pivots as fractions of the way from S to C.
typedef struct {
    quat_t q_IT;
    real_t x[MAX_PARAMETERS];
} trial_t;

typedef struct {
    const ssv_problem_t* problem;
    ssv_phase_t phase;
    int contact;
    real_t height_m;
    pose_t X_from, X_to;         // of the transit
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

static quat_t travel_attitude(const trial_t* trial) {
    const vec3_t change = vec3(trial->x[0], trial->x[1], trial->x[2]);
    const real_t angle = vec3_norm(change);
    if (!(angle > REAL(0))) return trial->q_IT;
    return quat_unit(quat_mul(trial->q_IT, quat_from_axis_angle(vec3_unit(change), angle)));
}

// The transfer that travels with this attitude and mate roll. The beam's axis is where the vehicle holds it, so the smallest
// turns bring it there from where it lies and on to where it docks; they fix the ring angle and the roll of the docked beam.
static void lay_transfer(const task_t* task, const trial_t* trial, motion_t* motion) {
    const ssv_scenario_t* s = &task->problem->scenario;
    const quat_t q_IT = travel_attitude(trial);
    const vec3_t axis_S = vec3(REAL(0), real_cos(trial->x[3]), real_sin(trial->x[3]));
    const vec3_t axis_travel = quat_apply(q_IT, axis_S), axis_start = quat_apply(s->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    quat_t q_IS = quat_unit(quat_mul(align(axis_travel, axis_start), q_IT));
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
    const vec3_t outward_travel = task->contact == 1 ? vec3_neg(axis_travel) : axis_travel;
    const quat_t q_dock = quat_unit(quat_mul(align(outward_travel, vec3_neg(s->axis_I)), q_IT));
    const pose_t X_dock = {vec3_sub(s->p_IP_m, quat_apply(q_dock, p_SE)), q_dock};
    const vec3_t centre = ssv_body_centre(&motion->assembly);
    const vec3_t pivot[2] = {vec3_scale(trial->x[4], centre), vec3_scale(trial->x[5], centre)};
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
    lay_flight(SSV_TRANSIT, task->X_from, task->X_to, travel_attitude(trial), centre, &motion->flight);
}

static bool try_price(task_t* task, const trial_t* trial, real_t* price) {
    motion_t motion;
    bool feasible;
    lay(task, trial, &motion);
    *price = estimate(task->problem, &motion.assembly, &motion.flight, &feasible);
    task->num_priced++;
    return feasible;
}

// Compass search: each number in turn a step up and down, keeping what is cheaper; all steps halve after a sweep in vain.
static void refine(task_t* task, int sweeps, trial_t* trial, real_t* price) {
    static const real_t start[MAX_PARAMETERS] = {REAL(0.2), REAL(0.2), REAL(0.2), REAL(0.3), REAL(0.5), REAL(0.5)};
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

static real_t one_radian(const ssv_problem_t* problem, const ssv_assembly_t* assembly, vec3_t axis) {
    const ssv_move_t about_S = ssv_move_turn(SSV_TRANSFER, axis, REAL(1), vec3(REAL(0), REAL(0), REAL(0)));
    const ssv_price_t price = turn_price(problem, assembly, &about_S);
    return price.cost;
}

// Travel attitudes for a flight along direction_I: cheap body directions, rolled about the line.
static void draw(task_t* task, const directions_t* directions, vec3_t direction_I, real_t distance, int most, start_t* list,
                 int* num) {
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
    const real_t one_rad = one_radian(task->problem, &assembly, vec3(REAL(0), REAL(0), REAL(1)));
    *num = 0;
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
                    start.trial.x[3] = mate_roll;
                    start.price += turn_guess(one_rad, angle_between(axis_start, axis)) +
                                   turn_guess(one_rad, angle_between(axis, axis_end));
                } else {
                    const ssv_move_t first = turn_between(SSV_TRANSIT, task->X_from.q, start.trial.q_IT, vec3_scale(REAL(0), axis_end));
                    const ssv_move_t last = turn_between(SSV_TRANSIT, start.trial.q_IT, task->X_to.q, vec3_scale(REAL(0), axis_end));
                    start.price += turn_guess(one_rad, first.length) + turn_guess(one_rad, last.length);
                }
                keep(list, num, most, &start);
            }
        }
    }
}

// Refines the starts and prices the best motion in full.
static bool settle(task_t* task, const effort_t* effort, start_t* list, int num, motion_t* motion) {
    int best = -1;
    for (int k = 0; k < num; k++) {
        if (!try_price(task, &list[k].trial, &list[k].price)) continue;
        refine(task, effort->sweeps, &list[k].trial, &list[k].price);
        if (best < 0 || list[k].price < list[best].price) best = k;
    }
    if (best < 0) return false;
    lay(task, &list[best].trial, motion);
    ssv_flight_price(task->problem, &motion->assembly, motion->X_from, &motion->flight);
    return motion->flight.price.outcome == SSV_FEASIBLE;
}

void ssv_search_optimal(const ssv_problem_t* problem, int contact, real_t height_m, ssv_chain_t* best, int* num_priced) {
    const ssv_scenario_t* s = &problem->scenario;
    const effort_t* effort = s->effort == SSV_EFFORT_BEST ? &best_effort : &quick;
    directions_t directions;
    start_t list[MAX_STARTS];
    int num;
    ssv_search_paper(problem, contact, height_m, best, num_priced);
    cheap_directions(problem, &directions);

    task_t carry = {problem, SSV_TRANSFER, contact, height_m, s->X_IS, s->X_IS, MAX_PARAMETERS, 0};
    const vec3_t axis_start = quat_apply(s->X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
    const real_t from_contact = real_abs(ssv_grasp_contact(s, contact).z - height_m);
    const vec3_t way = vec3_sub(vec3_add(s->p_IP_m, vec3_scale(from_contact, s->axis_I)),
                                vec3_add(s->X_IB.p, vec3_scale(height_m, axis_start)));
    const real_t distance = vec3_norm(way);
    motion_t to_port, to_beam;
    const vec3_t line = distance > REAL(1e-6) ? vec3_unit(way) : axis_start;
    draw(&carry, &directions, line, distance, effort->starts, list, &num);
    bool found = settle(&carry, effort, list, num, &to_port);

    if (found) {
        task_t fly = {problem, SSV_TRANSIT, contact, height_m, s->X_IS, to_port.X_from, 3, 0};
        const vec3_t transit_way = vec3_sub(to_port.X_from.p, s->X_IS.p);
        const real_t transit_distance = vec3_norm(transit_way);
        draw(&fly, &directions, transit_distance > REAL(1e-6) ? vec3_unit(transit_way) : axis_start, transit_distance,
             effort->starts, list, &num);
        found = settle(&fly, effort, list, num, &to_beam);
        *num_priced += fly.num_priced;
    }
    *num_priced += carry.num_priced;
    if (!found) return;
    ssv_chain_t chain;
    ssv_chain_join(&to_port.grasp, &to_beam.flight, &to_port.flight, to_port.assembly.X_SB, &chain);
    if (ssv_price_beats(&chain.price, &best->price)) *best = chain;
}
