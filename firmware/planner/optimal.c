// Turn, fly, turn, with everything that is free decided by J (DESIGN.md 6).
#include "planner/estimate.h"
#include "planner/search.h"

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
    [SSV_EFFORT_BEST] = {3, 3, 6, {{6, 3}, {2, 4}, {1, 4}}, MAX_TRANSITS, {1, 4}, {8, 4}}};
static const budget_t glance = {.transits = 1};

// A third price along a direction is worth it if a parabola promises this much, another joint refinement if the last gained so.
#define WORTH_A_LOOK REAL(3e-5)
#define WORTH_ANOTHER REAL(1e-5)
// A parabola is not trusted beyond so many steps.
#define FARTHEST REAL(2.5)
// Where no thruster acts along a leg: no vehicle that ssv_problem_init accepts is so.
#define NO_PRICE (REAL_MAX / 64)

// ---- Refinement ---------------------------------------------------------------------------------------------------------

// Steps of the free numbers at first: turn, twist, mate roll and spins, pivots.
static const real_t first_step[SSV_NUM_TRANSFER] = {
    REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.15), REAL(0.2), REAL(0.3),
    REAL(0.3),  REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.1)};

static ssv_task_t transit_to(const ssv_task_t* carry, pose_t X_to) {
    const pose_t X_from = carry->problem->scenario.X_IS;
    return (ssv_task_t){carry->problem, SSV_TRANSIT, carry->contact, carry->height_m, X_from, X_to, NULL, 0};
}

// Estimated price; NO_PRICE where the thrusters cannot do it.
static real_t try_price(ssv_task_t* task, const ssv_trial_t* trial) {
    ssv_motion_t motion;
    real_t price, before = REAL(0);
    ssv_trial_lay(task, trial, &motion);
    task->num_priced++;
    if (!ssv_flight_estimate(task->problem, &motion.assembly, &motion.flight, &price)) return NO_PRICE;
    if (task->transit != NULL) {
        const ssv_task_t fly = transit_to(task, motion.X_from);
        ssv_trial_lay(&fly, task->transit, &motion);
        if (!ssv_flight_estimate(task->problem, &motion.assembly, &motion.flight, &before)) return NO_PRICE;
    }
    return price + before;
}

// Steps up and down along a direction of the parameters, and to where the parabola through the three prices is lowest. @return
// how far along the direction it went.
static real_t search_along(ssv_task_t* task, const real_t direction[SSV_NUM_TRANSFER], ssv_trial_t* trial, real_t* price) {
    const ssv_trial_t centre = *trial;
    const real_t middle = *price;
    real_t at[2], best_step = REAL(0);
    for (int n = 0; n < 3; n++) {
        real_t step = n == 0 ? REAL(-1) : REAL(1);
        if (n == 2) {
            const real_t bend = at[0] + at[1] - real_mul(REAL(2), middle), fall = real_mul(REAL(0.5), at[0] - at[1]);
            if (!(bend > real_mul(SSV_EVEN, middle))) break;
            const bool far = real_abs(fall) >= real_mul(FARTHEST, bend);
            step = !far ? real_div(fall, bend) : fall < REAL(0) ? -FARTHEST : FARTHEST;
            const real_t promised = real_mul(step, fall - real_mul(REAL(0.5), real_mul(bend, step))), found = middle - *price;
            if (promised - found < real_mul(WORTH_A_LOOK, middle)) break;
        }
        ssv_trial_t next = centre;
        for (int k = 0; k < SSV_NUM_TRANSFER; k++) next.x[k] += real_mul(step, direction[k]);
        const real_t there = try_price(task, &next);
        if (n < 2) at[n] = there;
        if (there < *price - real_mul(SSV_EVEN, *price)) {
            *price = there;
            *trial = next;
            best_step = real_abs(step);
        }
    }
    return best_step;
}

// Each number in turn, and after each sweep the way that the sweep went as a whole. Steps shrink where nothing moves.
static void refine(ssv_task_t* task, int sweeps, ssv_trial_t* trial, real_t* price) {
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

static real_t total(const ssv_start_t* start) { return start->price + start->transit_price; }

static void sort(ssv_start_t* list, int num) {
    for (int i = 1; i < num; i++) {
        const ssv_start_t item = list[i];
        const real_t price = total(&item), even = real_mul(SSV_EVEN, price);
        int k = i;
        for (; k > 0 && price < total(&list[k - 1]) - even; k--) list[k] = list[k - 1];
        list[k] = item;
    }
}

static void price_all(ssv_task_t* task, ssv_start_t* list, int num) {
    for (int k = 0; k < num; k++) list[k].price = try_price(task, &list[k].trial);
    sort(list, num);
}

static void refine_first(ssv_task_t* task, int most, int sweeps, ssv_start_t* list, int num) {
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
SSV_OWN_FRAME static pose_t start_of(const ssv_task_t* carry, const ssv_trial_t* transfer) {
    ssv_motion_t motion;
    ssv_trial_lay(carry, transfer, &motion);
    return motion.X_from;
}

// The cheapest transit to where this transfer begins. @return its price.
static real_t find_transit(ssv_task_t* carry, const ssv_directions_t* directions, const budget_t* budget, const ssv_trial_t* transfer,
                           ssv_trial_t* transit) {
    ssv_start_t list[MAX_TRANSITS];
    ssv_task_t fly = transit_to(carry, start_of(carry, transfer));
    const int num = ssv_draw_transit(&fly, directions, budget->transits, list);
    price_all(&fly, list, num);
    refine_first(&fly, budget->transit.refined, budget->transit.sweeps, list, num);
    carry->num_priced += fly.num_priced;
    *transit = list[0].trial;
    return list[0].price;
}

// Draws and prices starts of some kinds, cheapest first.
static int draw(ssv_task_t* carry, const ssv_directions_t* directions, int kinds, int starts, ssv_start_t* list) {
    int num = 0;
    for (int kind = 0; kind < kinds; kind++) num += ssv_draw_transfer(carry, directions, (ssv_carry_t)kind, starts, &list[num]);
    price_all(carry, list, num);
    return num;
}

static ssv_task_t transfer_of(const ssv_problem_t* problem, int contact, real_t height_m) {
    const pose_t X_IS = problem->scenario.X_IS;
    return (ssv_task_t){problem, SSV_TRANSFER, contact, height_m, X_IS, X_IS, NULL, 0};
}

real_t ssv_optimal_flights(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m) {
    const ssv_scenario_t* s = &problem->scenario;
    const ssv_task_t carry = transfer_of(problem, contact, height_m);
    vec3_t hold_I[SSV_NUM_ENDS];
    ssv_hold_points(&carry, hold_I);
    const real_t there = vec3_norm(vec3_sub(hold_I[0], s->X_IS.p)), on = vec3_norm(vec3_sub(hold_I[1], hold_I[0]));
    return real_mul(directions->least, real_max(REAL(0), there - s->standoff_m) +
                                           real_max(REAL(0), on - real_mul(REAL(2), s->standoff_m)));
}

real_t ssv_optimal_look(const ssv_problem_t* problem, const ssv_directions_t* directions, int contact, real_t height_m,
                        const real_t* to_beat, ssv_look_t* look, int* num_priced) {
    ssv_task_t carry = transfer_of(problem, contact, height_m);
    ssv_start_t list[SSV_LOOK_STARTS];
    ssv_trial_t transit;
    const int num = draw(&carry, directions, LOOK_KINDS, SSV_LOOK_STARTS / LOOK_KINDS, list);
    const real_t price = list[0].price + find_transit(&carry, directions, &glance, &list[0].trial, &transit);
    *num_priced += carry.num_priced;
    if (to_beat != NULL && price >= *to_beat) return price;
    look->num = num;
    for (int k = 0; k < num; k++) look->start[k] = list[k];
    return price;
}

// The best transfer and its transit that the budget finds.
SSV_OWN_FRAME static void find(ssv_task_t* carry, const ssv_directions_t* directions, const budget_t* budget,
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
        if (total(&other) < total(&list[k])) list[k] = other;
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
SSV_OWN_FRAME static ssv_candidate_t price_exactly(const ssv_task_t* carry, const ssv_trial_t* transfer,
                                                   const ssv_trial_t* transit, ssv_chain_t* best) {
    ssv_motion_t to_port, to_beam;
    ssv_trial_lay(carry, transfer, &to_port);
    const ssv_task_t fly = transit_to(carry, to_port.X_from);
    ssv_trial_lay(&fly, transit, &to_beam);
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
    ssv_task_t carry = transfer_of(problem, contact, height_m);
    ssv_trial_t transfer, transit;
    find(&carry, directions, &budgets[effort], effort == SSV_EFFORT_QUICK ? look : NULL, &transfer, &transit);
    *num_priced += carry.num_priced;
    return price_exactly(&carry, &transfer, &transit, best);
}
