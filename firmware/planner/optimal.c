// Turn, fly, turn, with everything that is free decided by J (DESIGN.md 6).
#include "planner/alloc.h"
#include "planner/estimate.h"
#include "planner/search.h"

#define NUM_ENDS 2

// ---- How much is tried --------------------------------------------------------------------------------------------------

#define MAX_STARTS 9
#define MAX_TRANSITS 2
#define NUM_ROUNDS 3
typedef struct {
    int kinds, starts;           // kinds of starts of a transfer, and how many of each are drawn and priced
    int ways_up;                 // for how many of the cheapest a transit is sought, with the vehicle either way up
    struct {
        int refined, sweeps;
    } rounds[NUM_ROUNDS];        // how many of the cheapest are refined, round after round, with how many sweeps
    int transits;                // starts of the transit
    struct {
        int refined, sweeps;
    } transit;
    struct {
        int times, sweeps;
    } joint;                     // the best transfer once more with the price of both phases, as long as it is worth it
} budget_t;

#define LOOK_KINDS 2
static const budget_t budgets[] = {
    [SSV_EFFORT_QUICK] = {LOOK_KINDS, SSV_LOOK_STARTS / LOOK_KINDS, 1, {{1, 1}, {0, 0}, {0, 0}}, 2, {1, 1}, {0, 0}},
    [SSV_EFFORT_BEST] = {3, 3, 8, {{8, 3}, {3, 4}, {1, 4}}, MAX_TRANSITS, {1, 4}, {8, 4}}};
static const budget_t glance = {.transits = 1};

// Prices closer than this are equal: which is taken must not hang on rounding.
#define EVEN REAL(1e-9)
// A third price along a direction is worth it if a parabola promises this much, another joint refinement if the last gained so.
#define WORTH_A_LOOK REAL(3e-5)
#define WORTH_ANOTHER REAL(1e-5)
#define NO_PRICE REAL(1e9)
// Flights shorter than this have no direction.
#define NO_WAY_M REAL(1e-6)
// Steps to and fro between how the vehicle travels and where.
#define NUM_AIMS 2
// Body directions this much dearer per metre than the cheapest are not drawn; the search still finds its way in between.
#define DIRECTION_SLACK REAL(1.05)
// Rolls of a transit about its way.
#define NUM_ROLLS 4
// Spins all around, and cosine and sine of their halves. Their number is odd: half a turn could as well go the other way.
#define NUM_SPINS 7
#define SPIN_STEP REAL(0.89759790102565518)
static const real_t spin_half_cosine[NUM_SPINS] = {
    REAL(1),
    REAL(0.90096886790241915),
    REAL(0.62348980185873359),
    REAL(0.22252093395631445),
    REAL(-0.22252093395631445),
    REAL(-0.62348980185873359),
    REAL(-0.90096886790241915)};
static const real_t spin_half_sine[NUM_SPINS] = {
    REAL(0),
    REAL(0.43388373911755812),
    REAL(0.78183148246802980),
    REAL(0.97492791218182362),
    REAL(0.97492791218182362),
    REAL(0.78183148246802980),
    REAL(0.43388373911755812)};
// Swings are tried with spins up to this one, either way.
#define LAST_SWING 2
// Part of the price of a turn that it keeps when it is made on the way.
#define SWING_SHARE REAL(0.25)

// ---- What is chosen -----------------------------------------------------------------------------------------------------

// Steps of the free numbers at first: turn, twist, mate roll and spins, pivots.
static const real_t first_step[SSV_NUM_TRANSFER] = {
    REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.2), REAL(0.3),
    REAL(0.3),  REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.1)};

typedef struct {
    const ssv_problem_t* problem;
    ssv_phase_t phase;
    int contact;
    real_t height_m;
    pose_t X_from, X_to; // ends of the transit; those of a transfer are its trials' to choose
    const ssv_trial_t* transit; // what a transfer's price shall include, or NULL
    int num_priced;
} task_t;

// What a trial amounts to.
typedef struct {
    ssv_assembly_t assembly;
    pose_t X_from;
    ssv_grasp_t grasp;
    ssv_flight_t flight;
} motion_t;

// ---- Geometry -----------------------------------------------------------------------------------------------------------

// The attitude in which two unit vectors of the body, a_S and b_S, point along a_I and, as well as may be, towards b_I.
static quat_t attitude(vec3_t a_S, vec3_t b_S, vec3_t a_I, vec3_t b_I) {
    const quat_t q = quat_between(a_S, a_I);
    const vec3_t b = quat_apply(q, b_S);
    const vec3_t from = vec3_sub(b, vec3_scale(vec3_dot(b, a_I), a_I)), to = vec3_sub(b_I, vec3_scale(vec3_dot(b_I, a_I), a_I));
    if (!(real_min(vec3_norm(from), vec3_norm(to)) > REAL(1e-6))) return q;
    // Half a turn goes about a_I too.
    const vec3_t u = vec3_unit(from), v = vec3_unit(to), e = vec3_cross(u, v);
    const quat_t roll = {REAL(1) + vec3_dot(u, v), e.x, e.y, e.z}, half_turn = {REAL(0), a_I.x, a_I.y, a_I.z};
    return quat_unit(quat_mul(quat_norm(roll) > REAL(1e-6) ? quat_unit(roll) : half_turn, q));
}

static quat_t turned_by(quat_t q, vec3_t rotation) {
    const real_t angle = vec3_norm(rotation);
    if (!(angle > REAL(0))) return q;
    return quat_unit(quat_mul(q, quat_from_axis_angle(vec3_unit(rotation), angle)));
}

// Where the vehicle stands after turning about a pivot from X to another attitude.
static pose_t turned(pose_t X, quat_t q_to, vec3_t pivot_S) {
    return (pose_t){vec3_add(X.p, vec3_sub(quat_apply(X.q, pivot_S), quat_apply(q_to, pivot_S))), q_to};
}

static vec3_t beam_axis_S(real_t mate_roll) { return vec3(REAL(0), real_cos(mate_roll), real_sin(mate_roll)); }

static vec3_t beam_axis_start(const task_t* task) {
    return quat_apply(task->problem->scenario.X_IB.q, vec3(REAL(0), REAL(0), REAL(1)));
}

// The docked beam's z axis.
static vec3_t beam_axis_end(const task_t* task) {
    return vec3_scale(task->contact == 1 ? REAL(1) : REAL(-1), task->problem->scenario.axis_I);
}

// Attitudes of the vehicle where the flight's first turn begins and its last one ends. Those of a transfer follow from how it
// travels: the smallest turns that bring the beam's axis from where it lies and on to where it docks, and the spins. If the
// ring angle is given, the first turn begins there instead.
static void ends(const task_t* task, const ssv_trial_t* trial, const quat_t q_IT[NUM_ENDS], quat_t q_IS[NUM_ENDS]) {
    if (task->phase == SSV_TRANSIT) {
        q_IS[0] = task->X_from.q;
        q_IS[1] = task->X_to.q;
        return;
    }
    const ssv_scenario_t* s = &task->problem->scenario;
    const vec3_t axis_S = beam_axis_S(trial->x[SSV_X_MATE_ROLL]);
    const vec3_t axis_I[NUM_ENDS] = {beam_axis_start(task), beam_axis_end(task)};
    for (int end = 0; end < NUM_ENDS; end++) {
        const quat_t smallest = quat_mul(quat_between(quat_apply(q_IT[end], axis_S), axis_I[end]), q_IT[end]);
        q_IS[end] = quat_unit(quat_mul(quat_from_axis_angle(axis_I[end], trial->x[SSV_X_SPIN + end]), smallest));
    }
    if (s->ring_angle_given) {
        const vec3_t inward_B = vec3(-real_cos(s->ring_angle_rad), -real_sin(s->ring_angle_rad), REAL(0));
        q_IS[0] = attitude(axis_S, vec3(REAL(1), REAL(0), REAL(0)), axis_I[0], quat_apply(s->X_IB.q, inward_B));
    }
}

static vec3_t part(const ssv_trial_t* trial, int first) { return vec3(trial->x[first], trial->x[first + 1], trial->x[first + 2]); }

// Attitudes as the flight starts and ends. The vehicle flies in the direction n_S whatever else changes: that is a screw whose
// middle attitude turns the chord of its arc to the way.
static void travel_attitudes(const ssv_trial_t* trial, vec3_t way, quat_t q_IT[NUM_ENDS]) {
    const vec3_t turn = part(trial, SSV_X_TURN), twist = part(trial, SSV_X_TWIST);
    quat_t q_middle = turned_by(trial->q_IT, turn);
    const vec3_t n = quat_apply(turned_by(quat_identity(), vec3_neg(turn)), trial->n_S);
    const real_t angle = vec3_norm(twist), distance = vec3_norm(way);
    if (distance > NO_WAY_M) {
        vec3_t chord = n;
        if (angle > REAL(1e-6)) {
            const vec3_t axis = vec3_scale(real_div(REAL(1), angle), twist), along = vec3_scale(vec3_dot(axis, n), axis);
            chord = vec3_add(along, vec3_scale(real_div(real_sin(angle), angle), vec3_sub(n, along)));
        }
        q_middle = quat_mul(quat_between(quat_apply(q_middle, vec3_unit(chord)), vec3_unit(way)), q_middle);
    }
    q_IT[0] = turned_by(q_middle, vec3_neg(twist));
    q_IT[1] = turned_by(q_middle, twist);
}

// Where the beam's axis is taken hold of as it lies, and where that place is when it has docked.
static void hold_points(const task_t* task, vec3_t p_I[NUM_ENDS]) {
    const ssv_scenario_t* s = &task->problem->scenario;
    const real_t from_contact = real_abs(ssv_grasp_contact(s, task->contact).z - task->height_m);
    p_I[0] = vec3_add(s->X_IB.p, vec3_scale(task->height_m, beam_axis_start(task)));
    p_I[1] = vec3_add(s->p_IP_m, vec3_scale(from_contact, s->axis_I));
}

// Where the vehicle stands at both ends of a transfer.
static void stands(const task_t* task, const vec3_t hold_I[NUM_ENDS], const quat_t q_IS[NUM_ENDS], vec3_t p_IS[NUM_ENDS]) {
    const vec3_t ahead = vec3(task->problem->scenario.standoff_m, REAL(0), REAL(0));
    for (int end = 0; end < NUM_ENDS; end++) p_IS[end] = vec3_sub(hold_I[end], quat_apply(q_IS[end], ahead));
}

// The motion of a trial: turn about a pivot, fly on while turning from one travel attitude to the other, turn about a pivot.
static void lay(const task_t* task, const ssv_trial_t* trial, motion_t* motion) {
    const ssv_scenario_t* s = &task->problem->scenario;
    quat_t q_IT[NUM_ENDS], q_IS[NUM_ENDS];
    vec3_t p_IS[NUM_ENDS] = {task->X_from.p, task->X_to.p};
    pose_t X_IT[NUM_ENDS];
    if (task->phase == SSV_TRANSIT) {
        motion->assembly = ssv_vehicle_alone(task->problem);
        travel_attitudes(trial, vec3_sub(p_IS[1], p_IS[0]), q_IT);
        ends(task, trial, q_IT, q_IS);
        for (int end = 0; end < NUM_ENDS; end++) X_IT[end] = (pose_t){p_IS[end], q_IT[end]};
    } else {
        // Where the flight starts and ends depends on how the vehicle travels, and that on the way from one to the other: a few
        // steps to and fro.
        vec3_t hold_I[NUM_ENDS];
        hold_points(task, hold_I);
        vec3_t way = vec3_sub(hold_I[1], hold_I[0]);
        for (int n = 0; n < NUM_AIMS; n++) {
            travel_attitudes(trial, way, q_IT);
            ends(task, trial, q_IT, q_IS);
            stands(task, hold_I, q_IS, p_IS);
            for (int end = 0; end < NUM_ENDS; end++) {
                X_IT[end] = turned((pose_t){p_IS[end], q_IS[end]}, q_IT[end], part(trial, SSV_X_PIVOT + 3 * end));
            }
            way = vec3_sub(X_IT[1].p, X_IT[0].p);
        }
        const vec3_t outward_B =
            quat_apply(quat_conj(s->X_IB.q), vec3_neg(quat_apply(q_IS[0], vec3(REAL(1), REAL(0), REAL(0)))));
        const real_t ring_angle = s->ring_angle_given ? s->ring_angle_rad : real_atan2(outward_B.y, outward_B.x);
        motion->grasp = (ssv_grasp_t){task->contact, task->height_m, ring_angle};
        motion->assembly = ssv_vehicle_with_beam(task->problem, (pose_t){p_IS[0], q_IS[0]});
    }
    motion->X_from = (pose_t){p_IS[0], q_IS[0]};
    const pose_t via[] = {motion->X_from, X_IT[0], X_IT[1], {p_IS[1], q_IS[1]}};
    motion->flight.num_moves = SSV_MAX_PHASE_MOVES;
    for (int k = 0; k < SSV_MAX_PHASE_MOVES; k++) {
        motion->flight.move[k] = ssv_move_between(task->phase, via[k], via[k + 1]);
    }
}

static task_t transit_to(const task_t* carry, pose_t X_to) {
    return (task_t){carry->problem, SSV_TRANSIT, carry->contact, carry->height_m, carry->problem->scenario.X_IS, X_to, NULL, 0};
}

// Estimated price; NO_PRICE where the thrusters cannot do it.
static real_t try_price(task_t* task, const ssv_trial_t* trial) {
    motion_t motion;
    real_t price, before = REAL(0);
    lay(task, trial, &motion);
    task->num_priced++;
    if (!ssv_flight_estimate(task->problem, &motion.assembly, &motion.flight, &price)) return NO_PRICE;
    if (task->transit != NULL) {
        const task_t fly = transit_to(task, motion.X_from);
        lay(&fly, task->transit, &motion);
        if (!ssv_flight_estimate(task->problem, &motion.assembly, &motion.flight, &before)) return NO_PRICE;
    }
    return price + before;
}

// Steps up and down along a direction of the parameters, and to where the parabola through the three prices is lowest. @return
// how far along the direction it went.
static real_t search_along(task_t* task, const real_t direction[SSV_NUM_TRANSFER], ssv_trial_t* trial, real_t* price) {
    const ssv_trial_t centre = *trial;
    const real_t middle = *price;
    real_t at[2], best_step = REAL(0);
    for (int n = 0; n < 3; n++) {
        real_t step = n == 0 ? REAL(-1) : REAL(1);
        if (n == 2) {
            const real_t bend = at[0] + at[1] - real_mul(REAL(2), middle);
            if (!(bend > real_mul(EVEN, middle))) break;
            step = real_div(real_mul(REAL(0.5), at[0] - at[1]), bend);
            // What the parabola promises over the best so far.
            if (real_mul(REAL(0.5), real_mul(bend, real_sq(step))) - (middle - *price) < real_mul(WORTH_A_LOOK, middle)) break;
            step = real_max(REAL(-2.5), real_min(REAL(2.5), step));
        }
        ssv_trial_t next = centre;
        for (int k = 0; k < SSV_NUM_TRANSFER; k++) next.x[k] += real_mul(step, direction[k]);
        const real_t there = try_price(task, &next);
        if (n < 2) at[n] = there;
        if (there < *price - real_mul(EVEN, *price)) {
            *price = there;
            *trial = next;
            best_step = real_abs(step);
        }
    }
    return best_step;
}

// Each number in turn, and after each sweep the way that the sweep went as a whole. Steps shrink where nothing moves.
static void refine(task_t* task, int sweeps, ssv_trial_t* trial, real_t* price) {
    const int num = task->phase == SSV_TRANSIT ? SSV_NUM_TRANSIT : SSV_NUM_TRANSFER;
    real_t step[SSV_NUM_TRANSFER];
    for (int k = 0; k < num; k++) step[k] = first_step[k];
    for (int n = 0; n < sweeps; n++) {
        const ssv_trial_t before = *trial;
        for (int k = 0; k < num; k++) {
            if (task->phase == SSV_TRANSFER && k == SSV_X_SPIN && task->problem->scenario.ring_angle_given) continue;
            real_t direction[SSV_NUM_TRANSFER] = {REAL(0)};
            direction[k] = step[k];
            const real_t went = search_along(task, direction, trial, price);
            step[k] = real_mul(step[k], real_max(REAL(0.3), real_min(REAL(1.5), went)));
        }
        real_t direction[SSV_NUM_TRANSFER];
        for (int k = 0; k < SSV_NUM_TRANSFER; k++) direction[k] = trial->x[k] - before.x[k];
        search_along(task, direction, trial, price);
    }
}

// ---- Where the search starts --------------------------------------------------------------------------------------------

// What the beam does on the way of a transfer: it keeps the attitude that it has at one of the ends, or that but rolled about
// the way, or it swings from one to the other.
typedef enum { HELD, SWUNG, ROLLED, NUM_CARRIES } carry_t;

// Whether the thrusters serve the vehicle rolled half a turn about x as well as before: three wrenches with nothing special about
// them tell.
static bool serves_both_ways_up(const ssv_problem_t* problem) {
    static const real_t probe[3][6] = {{REAL(0.8), REAL(0.5), REAL(-0.3), REAL(0.1), REAL(0.05), REAL(0.12)},
                                       {REAL(-0.2), REAL(0.7), REAL(0.6), REAL(-0.07), REAL(0.15), REAL(-0.04)},
                                       {REAL(0.3), REAL(-0.4), REAL(0.9), REAL(0.11), REAL(-0.09), REAL(0.02)}};
    for (int k = 0; k < 3; k++) {
        const real_t* w = probe[k];
        real_t u[2][SSV_NUM_THRUSTERS], sum[2] = {REAL(0), REAL(0)}, squares[2] = {REAL(0), REAL(0)};
        for (int way = 0; way < 2; way++) {
            const real_t sign = way == 0 ? REAL(1) : REAL(-1);
            ssv_alloc(&problem->allocation, vec3(w[0], real_mul(sign, w[1]), real_mul(sign, w[2])),
                      vec3(w[3], real_mul(sign, w[4]), real_mul(sign, w[5])), u[way]);
            for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
                sum[way] += real_abs(u[way][i]);
                squares[way] += real_sq(u[way][i]);
            }
        }
        if (real_abs(sum[0] - sum[1]) > real_mul(EVEN, sum[0])) return false;
        if (real_abs(squares[0] - squares[1]) > real_mul(EVEN, squares[0])) return false;
    }
    return true;
}

void ssv_cheap_directions(const ssv_problem_t* problem, ssv_directions_t* d) {
    real_t price[SSV_NUM_DIRECTIONS], least = REAL(0);
    vec3_t n[SSV_NUM_DIRECTIONS];
    bool upright[SSV_NUM_DIRECTIONS];
    int num = 0;
    for (int x = -1; x <= 1; x++) {
        for (int y = -1; y <= 1; y++) {
            for (int z = -1; z <= 1; z++) {
                if (x == 0 && y == 0 && z == 0) continue;
                n[num] = vec3_unit(vec3(real_from_int(x), real_from_int(y), real_from_int(z)));
                upright[num] = z > 0 || (z == 0 && y >= 0);
                price[num] = ssv_metre_price(problem, n[num]);
                if (num == 0 || price[num] < least) least = price[num];
                num++;
            }
        }
    }
    d->num = d->num_upright = 0;
    d->least = least;
    for (int up = 1; up >= 0; up--) {
        for (int k = 0; k < num; k++) {
            if (price[k] > real_mul(DIRECTION_SLACK, least) || upright[k] != (up == 1)) continue;
            d->n[d->num] = n[k];
            d->price[d->num++] = price[k];
        }
        if (up == 1) d->num_upright = d->num;
    }
    if (!serves_both_ways_up(problem)) d->num_upright = d->num;
}

// Keeps the cheapest few, cheapest first.
static void keep(ssv_start_t* list, int* num, int most, const ssv_trial_t* trial, real_t price) {
    if (*num == most && price >= list[most - 1].price) return;
    int k = *num < most ? (*num)++ : most - 1;
    for (; k > 0 && price < list[k - 1].price; k--) list[k] = list[k - 1];
    list[k] = (ssv_start_t){*trial, price, REAL(0)};
}

// What turns about S ask for at unit rate about x, y and z, the beam held along +y: momentum, linear and quadratic drag.
enum { ACCEL, LINEAR, QUADRATIC, NUM_PARTS };
typedef struct {
    ssv_wrench_t wrench[NUM_PARTS][3];
    bool any[NUM_PARTS]; // whether there is such a part at all
} turns_t;

static void turns_init(const task_t* task, turns_t* turns) {
    const ssv_scenario_t* s = &task->problem->scenario;
    const vec3_t zero = vec3(REAL(0), REAL(0), REAL(0));
    ssv_assembly_t assembly = ssv_vehicle_alone(task->problem);
    if (task->phase == SSV_TRANSFER) {
        assembly.beam = &s->beam;
        assembly.X_SB = (pose_t){vec3(s->standoff_m, -task->height_m, REAL(0)),
                                 quat_between(vec3(REAL(0), REAL(0), REAL(1)), vec3(REAL(0), REAL(1), REAL(0)))};
    }
    turns->any[ACCEL] = true;
    turns->any[LINEAR] = turns->any[QUADRATIC] = false;
    for (int k = 0; k < 3; k++) {
        const vec3_t w = vec3(real_from_int(k == 0), real_from_int(k == 1), real_from_int(k == 2));
        ssv_demand_t there, back;
        ssv_body_demand(&assembly, (ssv_twist_t){zero, w}, &there);
        ssv_body_demand(&assembly, (ssv_twist_t){zero, vec3_neg(w)}, &back);
        turns->wrench[ACCEL][k] = there.accel;
        turns->wrench[LINEAR][k] = there.linear;
        // What does not change its sign with the rate is no drag.
        ssv_wrench_t* drag = &turns->wrench[QUADRATIC][k];
        drag->force = vec3_scale(REAL(0.5), vec3_sub(there.quadratic.force, back.quadratic.force));
        drag->moment = vec3_scale(REAL(0.5), vec3_sub(there.quadratic.moment, back.quadratic.moment));
        for (int part = LINEAR; part < NUM_PARTS; part++) {
            const ssv_wrench_t* wrench = &turns->wrench[part][k];
            if (vec3_norm(wrench->force) + vec3_norm(wrench->moment) > REAL(0)) turns->any[part] = true;
        }
    }
}

// A vector rolled about x.
static vec3_t rolled(vec3_t v, real_t cosine, real_t sine) {
    return vec3(v.x, real_mul(cosine, v.y) - real_mul(sine, v.z), real_mul(sine, v.y) + real_mul(cosine, v.z));
}

// What the turn q (in axes of the body) costs, roughly: W1 angle / v for the way, and for reaching v both what inertia and what
// drag ask. The beam of the demand is rolled about x to where it is, and all with it, as if the vehicle were a sphere.
static real_t turn_guess(const task_t* task, const turns_t* turns, vec3_t beam_axis_S, quat_t q) {
    const vec3_t e = vec3(q.x, q.y, q.z);
    const real_t sine = vec3_norm(e);
    if (sine < REAL(1e-4)) return REAL(0);
    const real_t angle = real_mul(REAL(2), real_atan2(sine, real_abs(q.w)));
    const vec3_t w = rolled(vec3_scale(real_div(REAL(1), sine), e), beam_axis_S.y, -beam_axis_S.z);
    real_t most[NUM_PARTS] = {REAL(0)}, sum[NUM_PARTS] = {REAL(0)}; // of the thrusts
    for (int part = 0; part < NUM_PARTS; part++) {
        if (!turns->any[part]) continue;
        const ssv_wrench_t* x = &turns->wrench[part][0];
        const vec3_t force = vec3_add(vec3_scale(w.x, x[0].force), vec3_add(vec3_scale(w.y, x[1].force), vec3_scale(w.z, x[2].force)));
        const vec3_t moment =
            vec3_add(vec3_scale(w.x, x[0].moment), vec3_add(vec3_scale(w.y, x[1].moment), vec3_scale(w.z, x[2].moment)));
        real_t u[SSV_NUM_THRUSTERS];
        ssv_alloc(&task->problem->allocation, rolled(force, beam_axis_S.y, beam_axis_S.z),
                  rolled(moment, beam_axis_S.y, beam_axis_S.z), u);
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            most[part] = real_max(most[part], real_abs(u[i]));
            sum[part] += real_abs(u[i]);
        }
    }
    const ssv_scenario_t* s = &task->problem->scenario;
    const real_t W1 = ssv_leg_weight_time(s), W2 = s->weight_impulse_per_Ns, F = s->vehicle.force_max_N, way = real_mul(W1, angle);
    const real_t rise = real_div(real_mul(W1, most[ACCEL]), F) +
                        real_mul(W2, real_mul(REAL(1.5), sum[ACCEL]) + real_mul(angle, sum[QUADRATIC]));
    const real_t hurry = real_div(real_mul(real_sq(way), most[QUADRATIC]), F);
    return real_sqrt(real_mul(REAL(4), real_mul(way, rise)) + hurry) + real_mul(W2, real_mul(angle, sum[LINEAR]));
}

// Starts of the transit: each cheap direction of the body along the way, and those that the attitudes at the ends fly along
// without a turn, rolled about the way between the attitudes that are the nearest to both ends.
SSV_OWN_FRAME static int draw_transit(const task_t* task, const ssv_directions_t* directions, int most, ssv_start_t* list) {
    const vec3_t way = vec3_sub(task->X_to.p, task->X_from.p);
    const real_t distance = vec3_norm(way);
    const bool flies = distance > NO_WAY_M;
    const vec3_t direction_I = flies ? vec3_unit(way) : vec3(REAL(1), REAL(0), REAL(0));
    const quat_t q_end[NUM_ENDS] = {task->X_from.q, task->X_to.q};
    int num = 0;
    const vec3_t y_S = vec3(REAL(0), REAL(1), REAL(0));
    turns_t turns;
    turns_init(task, &turns);
    for (int k = -NUM_ENDS; k < (flies ? directions->num : 0); k++) {
        const vec3_t n_S = k < 0 ? quat_apply(quat_conj(q_end[k + NUM_ENDS]), direction_I) : directions->n[k];
        const real_t fly = real_mul(distance, k < 0 ? ssv_metre_price(task->problem, n_S) : directions->price[k]);
        if (num == most && fly >= list[most - 1].price) continue;
        quat_t q[NUM_ENDS];
        for (int end = 0; end < NUM_ENDS; end++) {
            q[end] = quat_unit(quat_mul(quat_between(quat_apply(q_end[end], n_S), direction_I), q_end[end]));
        }
        const quat_t between = quat_mul(q[1], quat_conj(q[0]));
        const real_t sine = vec3_dot(vec3(between.x, between.y, between.z), direction_I);
        const real_t roll = real_mul(REAL(2), real_atan2(between.w < REAL(0) ? -sine : sine, real_abs(between.w)));
        for (int r = 0; r < NUM_ROLLS; r++) {
            const real_t part = real_div(real_mul(roll, real_from_int(r)), real_from_int(NUM_ROLLS - 1));
            const quat_t q_IT = quat_mul(quat_from_axis_angle(direction_I, part), q[0]);
            const real_t turning = turn_guess(task, &turns, y_S, quat_mul(quat_conj(q_end[0]), q_IT)) +
                                   turn_guess(task, &turns, y_S, quat_mul(quat_conj(q_IT), q_end[1]));
            const ssv_trial_t trial = {q_IT, n_S, {REAL(0)}};
            keep(list, &num, most, &trial, fly + turning);
            if (!flies) break;
        }
    }
    return num;
}

static vec3_t rotation_vector(quat_t q) {
    const vec3_t e = vec3_scale(q.w < REAL(0) ? REAL(-1) : REAL(1), vec3(q.x, q.y, q.z));
    const real_t sine = vec3_norm(e);
    if (!(sine > REAL(1e-9))) return vec3(REAL(0), REAL(0), REAL(0));
    return vec3_scale(real_div(real_mul(REAL(2), real_atan2(sine, real_abs(q.w))), sine), e);
}

// Sets the vehicle's roll about its contact axis and its attitude so that n_S flies ahead along direction_I and the beam points
// along axis_I; two rolls do. Where none does both, one does nearly. @return false for the second if there is but one.
static bool point_beam(int side, vec3_t direction_I, vec3_t axis_I, ssv_trial_t* trial) {
    const vec3_t n = trial->n_S;
    const real_t along = vec3_dot(direction_I, axis_I), reach = real_sqrt(real_sq(n.y) + real_sq(n.z));
    // The roll from where the beam leans on n most, by its cosine.
    real_t c = along < REAL(0) ? REAL(-1) : REAL(1), s = REAL(0);
    if (!(reach > REAL(0))) {
        c = real_from_int(side); // every roll does
    } else if (reach > real_abs(along)) {
        c = real_div(along, reach);
        s = real_mul(real_from_int(side), real_sqrt(real_max(REAL(0), REAL(1) - real_sq(c))));
    }
    const real_t y = reach > REAL(0) ? real_div(n.y, reach) : REAL(1), z = reach > REAL(0) ? real_div(n.z, reach) : REAL(0);
    const vec3_t axis_S = vec3(REAL(0), real_mul(y, c) - real_mul(z, s), real_mul(z, c) + real_mul(y, s));
    trial->x[SSV_X_MATE_ROLL] = real_atan2(axis_S.z, axis_S.y);
    trial->q_IT = attitude(n, axis_S, direction_I, axis_I);
    return side < 0 || reach > real_abs(along) || !(reach > REAL(0));
}

static void set_twist(vec3_t twist, ssv_trial_t* trial) {
    trial->x[SSV_X_TWIST] = twist.x;
    trial->x[SSV_X_TWIST + 1] = twist.y;
    trial->x[SSV_X_TWIST + 2] = twist.z;
}

// What the draws of a transfer have in common.
typedef struct {
    const task_t* task;
    vec3_t axis_I[NUM_ENDS], hold_I[NUM_ENDS], way;
    turns_t turns;
} scene_t;

static quat_t spin_about(vec3_t axis, int spin) {
    const real_t sine = spin_half_sine[spin];
    return (quat_t){spin_half_cosine[spin], real_mul(sine, axis.x), real_mul(sine, axis.y), real_mul(sine, axis.z)};
}

// Keeps a trial, and the same with the turn at one end spun about the beam's axis there, by their guessed prices.
static void keep_spins(const scene_t* scene, int spun_end, int num_spins, real_t metre_price, real_t swing, ssv_trial_t* trial,
                       int most, ssv_start_t* list, int* num) {
    const task_t* task = scene->task;
    const vec3_t axis_S = beam_axis_S(trial->x[SSV_X_MATE_ROLL]);
    quat_t q_IT[NUM_ENDS], q_IS[NUM_ENDS];
    vec3_t p_IS[NUM_ENDS];
    travel_attitudes(trial, scene->way, q_IT);
    ends(task, trial, q_IT, q_IS);
    const int other_end = 1 - spun_end;
    const quat_t unspun = q_IS[spun_end], swung = quat_mul(quat_conj(q_IT[0]), q_IT[1]);
    real_t price = turn_guess(task, &scene->turns, axis_S, quat_mul(quat_conj(q_IS[other_end]), q_IT[other_end]));
    if (swing > REAL(0)) price += real_mul(swing, turn_guess(task, &scene->turns, axis_S, swung));
    for (int spin = 0; spin < num_spins; spin++) {
        if (spin > 0) q_IS[spun_end] = quat_mul(spin_about(scene->axis_I[spun_end], spin), unspun);
        trial->x[SSV_X_SPIN + spun_end] = real_mul(SPIN_STEP, real_from_int(spin));
        stands(task, scene->hold_I, q_IS, p_IS);
        const real_t fly = real_mul(vec3_norm(vec3_sub(p_IS[1], p_IS[0])), metre_price);
        const quat_t turn = quat_mul(quat_conj(q_IS[spun_end]), q_IT[spun_end]);
        keep(list, num, most, trial, price + fly + turn_guess(task, &scene->turns, axis_S, turn));
    }
}

// Starts of the transfer. Two small turns cost more than one large: so each cheap direction of the body along the way, the beam
// pointing as it lies, or as it docks, and the turn at the other end with all its spins. Or all of the turn is made on the way.
// The spins also decide on which sides of the beam the flight begins and ends, so how long it is.
static int draw_transfer(const task_t* task, const ssv_directions_t* directions, carry_t carry, int most, ssv_start_t* list) {
    const bool given = task->problem->scenario.ring_angle_given;
    scene_t scene = {.task = task, .axis_I = {beam_axis_start(task), beam_axis_end(task)}};
    hold_points(task, scene.hold_I);
    scene.way = vec3_sub(scene.hold_I[1], scene.hold_I[0]);
    turns_init(task, &scene.turns);
    const vec3_t direction_I = vec3_norm(scene.way) > NO_WAY_M ? vec3_unit(scene.way) : scene.axis_I[0];
    const quat_t smallest = quat_between(scene.axis_I[0], scene.axis_I[1]);
    int num = 0;
    for (int variant = 0; variant < (carry == SWUNG ? NUM_SPINS : NUM_ENDS); variant++) {
        if (carry == SWUNG && variant > LAST_SWING && variant < NUM_SPINS - LAST_SWING) continue;
        // A swing goes from where the beam lies to where it docks, half of it before the middle of the way.
        const quat_t swing = quat_mul(spin_about(scene.axis_I[1], variant), smallest);
        const vec3_t half_swing = vec3_scale(REAL(0.5), rotation_vector(swing));
        const vec3_t middle_axis_I = quat_apply(turned_by(quat_identity(), half_swing), scene.axis_I[0]);
        for (int k = 0; k < directions->num_upright; k++) {
            for (int side = -1; side <= 1; side += 2) {
                ssv_trial_t trial = {quat_identity(), directions->n[k], {REAL(0)}};
                if (carry == SWUNG) {
                    if (!point_beam(side, direction_I, middle_axis_I, &trial)) continue;
                    set_twist(quat_apply(quat_conj(trial.q_IT), half_swing), &trial);
                    keep_spins(&scene, 1, 1, directions->price[k], SWING_SHARE, &trial, most, list, &num);
                    continue;
                }
                const int end = variant, other_end = 1 - end;
                if (!point_beam(side, direction_I, scene.axis_I[end], &trial)) continue;
                if (carry == ROLLED) {
                    const vec3_t axis_S = beam_axis_S(trial.x[SSV_X_MATE_ROLL]);
                    const quat_t q_other = attitude(trial.n_S, axis_S, direction_I, scene.axis_I[other_end]);
                    const vec3_t half = vec3_scale(REAL(0.5), rotation_vector(quat_mul(quat_conj(trial.q_IT), q_other)));
                    trial.q_IT = turned_by(trial.q_IT, half);
                    set_twist(end == 0 ? half : vec3_neg(half), &trial);
                }
                keep_spins(&scene, other_end, other_end == 0 && given ? 1 : NUM_SPINS, directions->price[k], REAL(0), &trial, most,
                           list, &num);
            }
        }
    }
    return num;
}

static void sort(ssv_start_t* list, int num) {
    for (int i = 1; i < num; i++) {
        const ssv_start_t item = list[i];
        int k = i;
        for (; k > 0 && item.price +item.transit_price< list[k - 1].price+list[k-1].transit_price - real_mul(EVEN, item.price); k--) list[k] = list[k - 1];
        list[k] = item;
    }
}

static void price_all(task_t* task, ssv_start_t* list, int num) {
    for (int k = 0; k < num; k++) list[k].price = try_price(task, &list[k].trial);
    sort(list, num);
}

static void refine_first(task_t* task, int most, int sweeps, ssv_start_t* list, int num) {
    for (int k = 0; k < most && k < num; k++) refine(task, sweeps, &list[k].trial, &list[k].price);
    sort(list, most < num ? most : num);
}

// ---- The search ---------------------------------------------------------------------------------------------------------

// The same transfer with the vehicle the other way up: rolled half a turn about its contact axis.
static ssv_trial_t other_way_up(const ssv_trial_t* trial) {
    const quat_t half_turn = {REAL(0), REAL(1), REAL(0), REAL(0)};
    ssv_trial_t other = *trial;
    other.q_IT = quat_mul(trial->q_IT, half_turn);
    other.n_S = quat_apply(half_turn, trial->n_S);
    other.x[SSV_X_MATE_ROLL] += REAL_PI;
    for (int k = 0; k < SSV_NUM_TRANSFER; k++) {
        if (k % 3 != 0 && (k < SSV_NUM_TRANSIT || k >= SSV_X_PIVOT)) other.x[k] = -other.x[k];
    }
    return other;
}

// Where a transfer begins.
SSV_OWN_FRAME static pose_t start_of(const task_t* carry, const ssv_trial_t* transfer) {
    motion_t motion;
    lay(carry, transfer, &motion);
    return motion.X_from;
}

// The cheapest transit to where this transfer begins. @return its price.
static real_t find_transit(task_t* carry, const ssv_directions_t* directions, const budget_t* budget, const ssv_trial_t* transfer,
                           ssv_trial_t* transit) {
    ssv_start_t list[MAX_TRANSITS];
    task_t fly = transit_to(carry, start_of(carry, transfer));
    const int num = draw_transit(&fly, directions, budget->transits, list);
    price_all(&fly, list, num);
    refine_first(&fly, budget->transit.refined, budget->transit.sweeps, list, num);
    carry->num_priced += fly.num_priced;
    *transit = list[0].trial;
    return list[0].price;
}

// Draws and prices starts of some kinds, cheapest first.
static int draw(task_t* carry, const ssv_directions_t* directions, int kinds, int starts, ssv_start_t* list) {
    int num = 0;
    for (int kind = 0; kind < kinds; kind++) num += draw_transfer(carry, directions, (carry_t)kind, starts, &list[num]);
    price_all(carry, list, num);
    return num;
}

static task_t transfer_of(const ssv_problem_t* problem, int contact, real_t height_m) {
    const pose_t X_IS = problem->scenario.X_IS;
    return (task_t){problem, SSV_TRANSFER, contact, height_m, X_IS, X_IS, NULL, 0};
}

real_t ssv_optimal_flights(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m) {
    const ssv_scenario_t* s = &problem->scenario;
    const task_t carry = transfer_of(problem, contact, height_m);
    vec3_t hold_I[NUM_ENDS];
    hold_points(&carry, hold_I);
    const real_t there = vec3_norm(vec3_sub(hold_I[0], s->X_IS.p)), on = vec3_norm(vec3_sub(hold_I[1], hold_I[0]));
    return real_mul(directions->least, real_max(REAL(0), there - s->standoff_m) +
                                           real_max(REAL(0), on - real_mul(REAL(2), s->standoff_m)));
}

real_t ssv_optimal_look(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m,
                        real_t least, ssv_look_t* look, int* num_priced) {
    task_t carry = transfer_of(problem, contact, height_m);
    ssv_start_t list[SSV_LOOK_STARTS];
    ssv_trial_t transit;
    const int num = draw(&carry, directions, LOOK_KINDS, SSV_LOOK_STARTS / LOOK_KINDS, list);
    const real_t price = list[0].price + find_transit(&carry, directions, &glance, &list[0].trial, &transit);
    *num_priced += carry.num_priced;
    if (price >= least) return price;
    look->num = num;
    for (int k = 0; k < num; k++) look->start[k] = list[k];
    return price;
}

// The best transfer and its transit that the budget finds.
SSV_OWN_FRAME static void find(task_t* carry, const ssv_directions_t* directions, const budget_t* budget,
                               const ssv_look_t* look, ssv_trial_t* transfer, ssv_trial_t* transit) {
    ssv_start_t list[MAX_STARTS];
    int num = 0;
    if (look != NULL) {
        num = look->num;
        for (int k = 0; k < num; k++) list[k] = look->start[k];
    } else {
        num = draw(carry, directions, budget->kinds, budget->starts, list);
    }
    if (num > budget->ways_up) num = budget->ways_up;
    for (int k = 0; k < num; k++) {
        ssv_start_t other = list[k];
        other.trial = other_way_up(&list[k].trial);
        other.price = try_price(carry, &other.trial);
        list[k].transit_price = find_transit(carry, directions, &glance, &list[k].trial, transit);
        other.transit_price = find_transit(carry, directions, &glance, &other.trial, transit);
        if (other.price + other.transit_price < list[k].price + list[k].transit_price) list[k] = other;
    }
    sort(list, num);
    for (int n = 0; n < NUM_ROUNDS; n++) refine_first(carry, budget->rounds[n].refined, budget->rounds[n].sweeps, list, num);
    *transfer = list[0].trial;
    real_t price = list[0].price + find_transit(carry, directions, budget, transfer, transit);
    carry->transit = transit;
    for (int n = 0; n < budget->joint.times; n++) {
        const real_t before = price;
        refine(carry, budget->joint.sweeps, transfer, &price);
        if (before - price < real_mul(WORTH_ANOTHER, before)) break;
    }
}

// The exact price of what was found, and its chain in *best if that is cheaper.
SSV_OWN_FRAME static ssv_candidate_t price_exactly(const task_t* carry, const ssv_trial_t* transfer,
                                                   const ssv_trial_t* transit, ssv_chain_t* best) {
    motion_t to_port, to_beam;
    lay(carry, transfer, &to_port);
    const task_t fly = transit_to(carry, to_port.X_from);
    lay(&fly, transit, &to_beam);
    ssv_flight_price(carry->problem, &to_beam.assembly, to_beam.X_from, &to_beam.flight);
    ssv_flight_price(carry->problem, &to_port.assembly, to_port.X_from, &to_port.flight);
    const ssv_price_t price = ssv_chain_price(&to_beam.flight, &to_port.flight);
    if (ssv_price_beats(&price, &best->price)) {
        ssv_chain_join(&to_port.grasp, &to_beam.flight, &to_port.flight, to_port.assembly.X_SB, best);
    }
    return ssv_candidate_of(&to_port.grasp, &price);
}

ssv_candidate_t ssv_search_optimal(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m,
                                   ssv_effort_t effort, const ssv_look_t* look, ssv_chain_t* best, int* num_priced) {
    task_t carry = transfer_of(problem, contact, height_m);
    ssv_trial_t transfer, transit;
    find(&carry, directions, &budgets[effort], effort == SSV_EFFORT_QUICK ? look : NULL, &transfer, &transit);
    *num_priced += carry.num_priced;
    return price_exactly(&carry, &transfer, &transit, best);
}
