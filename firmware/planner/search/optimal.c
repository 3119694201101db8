// Turn, fly, turn, with everything that is free decided by J (DESIGN.md 6).
#include "planner/profile/estimate.h"
#include "planner/search/search.h"

// ---- How much is tried
// --------------------------------------------------------------------------------------------------

#define MAX_TRANSITS 2
#define NUM_ROUNDS 3
// When a step of the refinement is taken, as fractions of the price; by measurement: of J, and of how often float and
// double part.
typedef struct {
    real_t worth_a_look; // what a parabola must promise
    real_t least_bend;   // what it is bent at least, whatever the prices say
    real_t clearly;      // how much lower an end must be than where the parabola leads
} caution_t;
typedef struct {
    int refined, sweeps; // how many of the cheapest, and with how many sweeps
    bool pairs;          // of numbers, too
} stage_t;
typedef struct {
    real_t closeness; // of estimates
    caution_t caution;
    int kinds, starts; // kinds of starts of a transfer, and how many of each are drawn; none if a look has done it
    stage_t rounds[NUM_ROUNDS]; // refinement of the transfer, round after round
    int transits;               // starts of the transit
    stage_t transit, joint; // refinement of the transit, and of the transfer once more with the price of both phases
} budget_t;

#define LOOK_KINDS 2
static const budget_t budgets[] = {
    [SSV_EFFORT_QUICK] = {.closeness = SSV_ESTIMATE_ROUGHLY,
                          .caution = {.worth_a_look = REAL(1e-4), .least_bend = REAL(3e-3), .clearly = REAL(2e-4)},
                          .rounds = {{SSV_LOOK_STARTS, 1, false}},
                          .transits = MAX_TRANSITS},
    [SSV_EFFORT_BEST] = {.closeness = SSV_ESTIMATE_CLOSELY,
                         .caution = {.worth_a_look = REAL(1e-5), .least_bend = REAL(1e-5), .clearly = REAL(2e-6)},
                         .kinds = 3,
                         .starts = 3,
                         .rounds = {{SSV_MAX_STARTS, 1, false}, {3, 3, false}, {1, 3, true}},
                         .transits = MAX_TRANSITS,
                         .transit = {1, 3, false},
                         .joint = {1, 4, true}}};
static const budget_t glance = {.transits = 1};

// A parabola is not trusted beyond so many steps.
#define FARTHEST REAL(2.5)
// Where no thruster acts along a leg: no vehicle that ssv_problem_init accepts is so.
#define NO_PRICE (REAL_MAX / 64)

// ---- Refinement
// ---------------------------------------------------------------------------------------------------------

// Steps of the free numbers at first: turn, twist, mate roll and spins, pivots.
static const real_t first_step[SSV_NUM_TRANSFER] = {REAL(0.1),  REAL(0.1),  REAL(0.1),  REAL(0.15), REAL(0.15),
                                                    REAL(0.15), REAL(0.25), REAL(0.4),  REAL(0.4),  REAL(0.12),
                                                    REAL(0.12), REAL(0.12), REAL(0.12), REAL(0.12), REAL(0.12)};

// Estimated price; NO_PRICE where the thrusters cannot do it.
static real_t try_price(ssv_phase_context_t* context, const ssv_decision_t* decision) {
    ssv_motion_t motion;
    real_t price, before = REAL(0);
    ssv_decision_motion(context, decision, &motion);
    context->num_priced++;
    if (!ssv_maneuvers_estimate(context->question, &motion.assembly, motion.maneuver, SSV_MAX_PHASE_MANEUVERS,
                                context->closeness, &price))
        return NO_PRICE;
    if (context->before != NULL) {
        const ssv_phase_context_t fly = ssv_transit_context(context, &motion.X_from);
        ssv_decision_motion(&fly, context->before, &motion);
        if (!ssv_maneuvers_estimate(context->question, &motion.assembly, motion.maneuver, SSV_MAX_PHASE_MANEUVERS,
                                    context->closeness, &before))
            return NO_PRICE;
    }
    return price + before;
}

static void go(const real_t direction[SSV_NUM_TRANSFER], real_t step, ssv_decision_t* decision) {
    for (int k = 0; k < SSV_NUM_TRANSFER; k++) decision->x[k] += real_mul(step, direction[k]);
}

static real_t price_at(ssv_phase_context_t* context, const ssv_decision_t* decision,
                       const real_t direction[SSV_NUM_TRANSFER], real_t step) {
    ssv_decision_t there = *decision;
    go(direction, step, &there);
    return try_price(context, &there);
}

// Prices a step down and a step up along a direction of the parameters, and goes to where the parabola through the
// three prices is lowest. How far must not hang on the last digits of prices, in which scalars differ: where a parabola
// is nearly flat it counts as bent, which keeps the step short. @return how far along the direction it went.
static real_t search_along(ssv_phase_context_t* context, const real_t direction[SSV_NUM_TRANSFER],
                           const caution_t* caution, ssv_decision_t* decision, real_t* price) {
    const real_t middle = *price, down = price_at(context, decision, direction, REAL(-1));
    const real_t up = price_at(context, decision, direction, REAL(1));
    const real_t fall = real_mul(REAL(0.5), down - up);
    const real_t bend = real_max(down + up - real_mul(REAL(2), middle), real_mul(caution->least_bend, middle));
    const bool far = real_abs(fall) >= real_mul(FARTHEST, bend);
    const real_t step = !far ? real_div(fall, bend) : fall < REAL(0) ? -FARTHEST : FARTHEST;
    const real_t promised = real_mul(step, fall - real_mul(REAL(0.5), real_mul(bend, step)));
    real_t went = REAL(0);
    if (promised > real_mul(caution->worth_a_look, middle)) {
        const real_t there = price_at(context, decision, direction, step);
        if (there < middle - real_mul(SSV_EVEN, middle)) {
            *price = there;
            went = step;
        }
    }
    const real_t end = real_min(down, up);
    if (end < *price - real_mul(caution->clearly, middle)) {
        *price = end;
        went = up < down - real_mul(SSV_EVEN, down) ? REAL(1) : REAL(-1);
    }
    go(direction, went, decision);
    return real_abs(went);
}

// Pairs of numbers, each with one that stands so far further along the list: up or down together, or one up and one
// down.
static void search_pairs(ssv_phase_context_t* context, const real_t step[SSV_NUM_TRANSFER], int apart,
                         const caution_t* caution, ssv_decision_t* decision, real_t* price) {
    for (int k = 0; k < SSV_NUM_TRANSFER; k++) {
        const int other = (k + apart) % SSV_NUM_TRANSFER;
        ssv_decision_t against = *decision;
        real_t price_against = *price, direction[SSV_NUM_TRANSFER] = {REAL(0)};
        direction[k] = step[k];
        direction[other] = step[other];
        search_along(context, direction, caution, decision, price);
        direction[other] = -step[other];
        search_along(context, direction, caution, &against, &price_against);
        if (!(price_against < *price)) continue;
        *decision = against;
        *price = price_against;
    }
}

// Each number in turn, and after each sweep the way that the sweep went as a whole. Steps shrink where nothing moves.
// Pairs go on where the price has a kink, at which neither number gains alone.
static void refine(ssv_phase_context_t* context, const caution_t* caution, const stage_t* stage,
                   ssv_decision_t* decision, real_t* price) {
    const int num = context->phase == SSV_TRANSIT ? SSV_NUM_TRANSIT : SSV_NUM_TRANSFER;
    const bool given = context->phase == SSV_TRANSFER && context->question->problem->scenario.ring_angle_given;
    real_t step[SSV_NUM_TRANSFER];
    for (int k = 0; k < num; k++) step[k] = given && k == SSV_X_SPIN ? REAL(0) : first_step[k];
    for (int n = 0; n < stage->sweeps; n++) {
        const ssv_decision_t before = *decision;
        for (int k = 0; k < num; k++) {
            if (!(step[k] > REAL(0))) continue;
            real_t direction[SSV_NUM_TRANSFER] = {REAL(0)};
            direction[k] = step[k];
            const real_t went = search_along(context, direction, caution, decision, price);
            step[k] = real_mul(step[k], real_max(REAL(0.3), real_min(REAL(1.5), went)));
        }
        if (stage->pairs) search_pairs(context, step, 1 + n, caution, decision, price);
        real_t direction[SSV_NUM_TRANSFER];
        for (int k = 0; k < SSV_NUM_TRANSFER; k++) direction[k] = decision->x[k] - before.x[k];
        search_along(context, direction, caution, decision, price);
    }
}

static real_t total(const ssv_seed_t* start) { return start->price + start->transit_price; }

// Cheapest first.
static void sort(ssv_seed_t* list, int num) {
    for (int i = 1; i < num; i++) {
        const ssv_seed_t item = list[i];
        int k = i;
        for (; k > 0 && ssv_clearly_less(total(&item), total(&list[k - 1])); k--) list[k] = list[k - 1];
        list[k] = item;
    }
}

// Drops those that cost the same as the one before: in a scene with symmetries they are its mirror images. @return how
// many stay.
static int drop_twins(ssv_seed_t* list, int num) {
    int kept = 0;
    for (int k = 0; k < num; k++) {
        if (kept > 0 && !ssv_clearly_less(total(&list[kept - 1]), total(&list[k]))) continue;
        if (kept != k) list[kept] = list[k];
        kept++;
    }
    return kept;
}

static void price_all(ssv_phase_context_t* context, ssv_seed_t* list, int num) {
    for (int k = 0; k < num; k++) list[k].price = try_price(context, &list[k].decision);
    sort(list, num);
}

static void refine_first(ssv_phase_context_t* context, const caution_t* caution, const stage_t* stage, ssv_seed_t* list,
                         int num) {
    const int most = stage->refined < num ? stage->refined : num;
    for (int k = 0; k < most; k++) refine(context, caution, stage, &list[k].decision, &list[k].price);
    sort(list, most);
}

// ---- The search
// ---------------------------------------------------------------------------------------------------------

// The same transfer with the vehicle the other way up: rolled half a turn about its contact axis.
static ssv_decision_t other_way_up(const ssv_decision_t* decision) {
    const quat_t half_turn = {REAL(0), REAL(1), REAL(0), REAL(0)};
    ssv_decision_t other = *decision;
    other.q_IT = quat_mul(decision->q_IT, half_turn);
    other.n_S = quat_apply(half_turn, decision->n_S);
    other.axis_S = vec3_neg(decision->axis_S);
    for (int k = 0; k < SSV_NUM_TRANSFER; k++) {
        if (k % 3 != 0 && (k < SSV_NUM_TRANSIT || k >= SSV_X_PIVOT)) other.x[k] = -other.x[k];
    }
    return other;
}

// Where a transfer begins.
SSV_OWN_FRAME static pose_t start_of(const ssv_phase_context_t* carry, const ssv_decision_t* transfer) {
    ssv_motion_t motion;
    ssv_decision_motion(carry, transfer, &motion);
    return motion.X_from;
}

// The cheapest transit to where this transfer begins; NULL if it is not asked for. @return its price.
static real_t find_transit(ssv_phase_context_t* carry, const ssv_capability_t* capability, const budget_t* budget,
                           const ssv_decision_t* transfer, ssv_decision_t* transit) {
    ssv_seed_t list[MAX_TRANSITS];
    const pose_t X_to = start_of(carry, transfer);
    ssv_phase_context_t fly = ssv_transit_context(carry, &X_to);
    const int num = ssv_seed_transit(&fly, capability, budget->transits, list);
    price_all(&fly, list, num);
    refine_first(&fly, &budget->caution, &budget->transit, list, num);
    carry->num_priced += fly.num_priced;
    if (transit != NULL) *transit = list[0].decision;
    return list[0].price;
}

// Adds the transit, with the vehicle whichever way up that is cheaper.
static void add_transit(ssv_phase_context_t* carry, const ssv_capability_t* capability, ssv_seed_t* start) {
    ssv_seed_t other = *start;
    other.decision = other_way_up(&start->decision);
    if (!capability->either_way_up) other.price = try_price(carry, &other.decision);
    start->transit_price = find_transit(carry, capability, &glance, &start->decision, NULL);
    other.transit_price = find_transit(carry, capability, &glance, &other.decision, NULL);
    if (ssv_clearly_less(total(&other), total(start))) *start = other;
}

// Draws and prices starts of some kinds, cheapest first.
static int draw(ssv_phase_context_t* carry, ssv_capability_t* capability, int kinds, int starts, ssv_seed_t* list) {
    int num = 0;
    for (int kind = 0; kind < kinds; kind++)
        num += ssv_seed_transfer(carry, capability, (ssv_attitude_mode_t)kind, starts, &list[num]);
    price_all(carry, list, num);
    return num;
}

real_t ssv_optimal_flights(const ssv_question_t* question, const ssv_capability_t* capability, int contact,
                           real_t height_m) {
    const ssv_scenario_t* s = &question->problem->scenario;
    const ssv_phase_context_t carry = ssv_transfer_context(question, contact, height_m);
    const real_t there = vec3_norm(vec3_sub(carry.hold_I[0], s->X_IS.p));
    const real_t on = vec3_norm(vec3_sub(carry.hold_I[1], carry.hold_I[0]));
    return real_mul(capability->least, real_max(REAL(0), there - s->standoff_m) +
                                           real_max(REAL(0), on - real_mul(REAL(2), s->standoff_m)));
}

real_t ssv_optimal_look(const ssv_question_t* question, ssv_search_t* search, int contact, real_t height_m,
                        const real_t* to_beat, int* num_priced) {
    ssv_phase_context_t carry = ssv_transfer_context(question, contact, height_m);
    ssv_seed_t* list = search->start;
    const int num = draw(&carry, &search->capability, LOOK_KINDS, SSV_LOOK_STARTS / LOOK_KINDS, list);
    // Where transfers cost the same, their transits decide, and where these do too, refinement.
    const real_t least = list[0].price;
    int alike = 0;
    for (; alike < num && ssv_alike(least, list[alike].price); alike++)
        add_transit(&carry, &search->capability, &list[alike]);
    sort(list, alike);
    *num_priced += carry.num_priced;
    const real_t price = total(&list[0]);
    if (to_beat != NULL && !ssv_clearly_less(price, *to_beat)) return price;
    search->look.num = 0;
    for (int k = 0; k < alike && ssv_alike(price, total(&list[k])); k++)
        search->look.start[search->look.num++] = list[k];
    return price;
}

// The best transfer and its transit that the budget finds.
SSV_OWN_FRAME static void find(ssv_phase_context_t* carry, ssv_search_t* search, const budget_t* budget,
                               ssv_decision_t* transfer, ssv_decision_t* transit) {
    ssv_capability_t* capability = &search->capability;
    ssv_seed_t* list = search->start;
    const bool looked = budget->kinds == 0;
    int num = looked ? search->look.num : draw(carry, capability, budget->kinds, budget->starts, list);
    for (int k = 0; looked && k < num; k++) list[k] = search->look.start[k];
    for (int k = 0; !looked && k < num; k++) add_transit(carry, capability, &list[k]);
    sort(list, num);
    num = drop_twins(list, num);
    for (int n = 0; n < NUM_ROUNDS; n++) refine_first(carry, &budget->caution, &budget->rounds[n], list, num);
    *transfer = list[0].decision;
    real_t price = list[0].price + find_transit(carry, capability, budget, transfer, transit);
    carry->before = transit;
    refine(carry, &budget->caution, &budget->joint, transfer, &price);
}

static void fly(const ssv_question_t* question, const ssv_motion_t* motion, ssv_phase_path_t* flight) {
    flight->num_maneuvers = SSV_MAX_PHASE_MANEUVERS;
    for (int k = 0; k < SSV_MAX_PHASE_MANEUVERS; k++) flight->maneuver[k] = motion->maneuver[k];
    ssv_phase_path_price(question, &motion->assembly, NULL, flight);
}

// The exact price of what was found, and its chain in *best if that is cheaper.
SSV_OWN_FRAME static ssv_candidate_t price_exactly(const ssv_phase_context_t* carry, const ssv_decision_t* transfer,
                                                   const ssv_decision_t* transit, ssv_path_t* best) {
    ssv_motion_t motion;
    ssv_phase_path_t to_port, to_beam;
    ssv_decision_motion(carry, transfer, &motion);
    const ssv_grasp_t grasp = ssv_phase_grasp(carry, &motion.X_from);
    const pose_t X_SB = motion.assembly.X_SB;
    fly(carry->question, &motion, &to_port);
    const ssv_phase_context_t go = ssv_transit_context(carry, &motion.X_from);
    ssv_decision_motion(&go, transit, &motion);
    fly(carry->question, &motion, &to_beam);
    const ssv_price_t price = ssv_path_price(&to_beam, &to_port);
    if (ssv_price_beats(&price, &best->price)) ssv_path_join(&grasp, &to_beam, &to_port, X_SB, best);
    return ssv_candidate_of(&grasp, &price);
}

ssv_candidate_t ssv_search_optimal(const ssv_question_t* question, ssv_search_t* search, int contact, real_t height_m,
                                   ssv_effort_t effort, ssv_path_t* best, int* num_priced) {
    ssv_phase_context_t carry = ssv_transfer_context(question, contact, height_m);
    carry.closeness = budgets[effort].closeness;
    ssv_decision_t transfer, transit;
    find(&carry, search, &budgets[effort], &transfer, &transit);
    *num_priced += carry.num_priced;
    return price_exactly(&carry, &transfer, &transit, best);
}
