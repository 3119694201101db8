#include "planner/search/seed.h"

#include "planner/math/assert.h"
#include "planner/model/body.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/price_order.h"
#include "planner/motion/question.h"
#include "planner/search/budget.h"
#include "planner/search/tolerance.h"
#include "ssv/plan.h"
#include "ssv/vec3.h"

static const vec3_t x_axis = {REAL(1), REAL(0), REAL(0)};

void ssv_seeds_insert(ssv_seeds_t* seeds, const ssv_seed_t* seed) {
    const real_t total = ssv_seed_total(seed);
    ssv_seed_t* list = seeds->seed;
    SSV_ASSERT(seeds->most > 0 && seeds->num <= seeds->most);
    if (seeds->num == seeds->most && !ssv_clearly_less(total, ssv_seed_total(&list[seeds->num - 1]))) return;
    int k = seeds->num < seeds->most ? seeds->num++ : seeds->most - 1;
    for (; k > 0 && ssv_clearly_less(total, ssv_seed_total(&list[k - 1])); k--) list[k] = list[k - 1];
    list[k] = *seed;
}

void ssv_seeds_sort(ssv_seeds_t* seeds, int num) {
    SSV_ASSERT(num <= seeds->num);
    ssv_seeds_t sorted = {seeds->seed, 0, num};
    while (sorted.num < num) {
        const ssv_seed_t seed = seeds->seed[sorted.num];
        ssv_seeds_insert(&sorted, &seed);
    }
}

void ssv_seeds_drop_duplicates(ssv_seeds_t* seeds) {
    ssv_seed_t* list = seeds->seed;
    int kept = 0;
    for (int k = 0; k < seeds->num; k++) {
        if (kept > 0 && !ssv_clearly_less(ssv_seed_total(&list[kept - 1]), ssv_seed_total(&list[k]))) continue;
        if (kept != k) list[kept] = list[k];
        kept++;
    }
    seeds->num = kept;
}

void ssv_seeds_price(ssv_phase_context_t* context, ssv_seeds_t* seeds) {
    for (int k = 0; k < seeds->num; k++) {
        seeds->seed[k].price = ssv_decision_price(context, &seeds->seed[k].decision);
    }
    ssv_seeds_sort(seeds, seeds->num);
}

// Whether a seed that costs at least this much cannot enter the list.
static bool is_full_below(const ssv_seeds_t* seeds, real_t price) {
    return seeds->num == seeds->most && price >= seeds->seed[seeds->most - 1].price;
}

void ssv_seed_transit(const ssv_phase_context_t* context, const ssv_capability_t* capability, ssv_seeds_t* seeds) {
    SSV_ASSERT(context->phase == SSV_TRANSIT && seeds->num == 0);
    const ssv_question_t* question = context->question;
    const ssv_turns_t* turns = &capability->turns;
    const vec3_t displacement_I = vec3_sub(context->hold_I[1], context->hold_I[0]);
    const real_t length = vec3_norm(displacement_I);
    const bool flies = length > SSV_NO_DIRECTION_M;
    const vec3_t direction_I = flies ? vec3_unit(displacement_I) : vec3(REAL(1), REAL(0), REAL(0));
    const quat_t* q_end = context->transit.q_IS;
    if (flies && capability->regime != SSV_LINEAR_DRAG) {
        const quat_t q = quat_mul(quat_conj(q_end[0]), q_end[1]);
        const vec3_t half = ssv_half_of(q);
        const quat_t middle = ssv_turned_by(q_end[0], half);
        const vec3_t n_S = quat_apply(quat_conj(middle), direction_I);
        const ssv_seed_t seed = {.decision = {.q_IT = middle, .n_S = n_S, .free.twist = half},
                                 .price = real_mul(length, ssv_direction_price(question, capability, n_S)) +
                                          real_mul(SSV_SWING_SHARE, ssv_turn_guess(question, turns, q))};
        ssv_seeds_insert(seeds, &seed);
    }
    // Then the directions in which the attitudes at the ends fly, and those that are cheap.
    for (int k = -SSV_NUM_ENDS; k < (flies ? capability->num : 0); k++) {
        const vec3_t n_S = k < 0 ? quat_apply(quat_conj(q_end[k + SSV_NUM_ENDS]), direction_I) : capability->n[k];
        const real_t flight =
            real_mul(length, k < 0 ? ssv_direction_price(question, capability, n_S) : capability->price[k]);
        if (is_full_below(seeds, flight)) continue;
        quat_t q[SSV_NUM_ENDS];
        for (int end = 0; end < SSV_NUM_ENDS; end++) {
            q[end] = quat_mul(quat_between(quat_apply(q_end[end], n_S), direction_I), q_end[end]);
        }
        // Rolled about the line of flight so that one of the turns is the smallest.
        for (int end = 0; end < (flies ? SSV_NUM_ENDS : 1); end++) {
            const real_t so_far = flight + ssv_turn_guess(question, turns, quat_mul(quat_conj(q_end[0]), q[end]));
            if (is_full_below(seeds, so_far)) continue;
            const real_t last = ssv_turn_guess(question, turns, quat_mul(quat_conj(q[end]), q_end[1]));
            const ssv_seed_t seed = {.decision = {.q_IT = q[end], .n_S = n_S}, .price = so_far + last};
            ssv_seeds_insert(seeds, &seed);
        }
    }
}

// Sets how the vehicle holds the beam, and its attitude, so that n_S flies ahead along direction_I and the beam points
// along axis_I. Two rolls about x do that, one for each side. Where none does, one comes closest. @return false for the
// second side if there is but one roll.
static bool point_beam(int side, vec3_t direction_I, vec3_t axis_I, ssv_decision_t* decision) {
    const vec3_t n = decision->n_S;
    const real_t along = vec3_dot(direction_I, axis_I), reach = real_sqrt(real_sq(n.y) + real_sq(n.z));
    // The roll, by its cosine and sine, from where the beam's axis has the largest part along n.
    real_t c = along < REAL(0) ? REAL(-1) : REAL(1), s = REAL(0);
    if (!(reach > REAL(0))) {
        c = real_from_int(side); // every roll does
    } else if (reach > real_abs(along)) {
        c = real_div(along, reach);
        s = real_mul(real_from_int(side), real_sqrt(real_max(REAL(0), REAL(1) - real_sq(c))));
    }
    const real_t y = reach > REAL(0) ? real_div(n.y, reach) : REAL(1),
                 z = reach > REAL(0) ? real_div(n.z, reach) : REAL(0);
    decision->axis_S = vec3(REAL(0), real_mul(y, c) - real_mul(z, s), real_mul(z, c) + real_mul(y, s));
    decision->q_IT = ssv_attitude(n, decision->axis_S, direction_I, axis_I);
    return side < 0 || reach > real_abs(along) || !(reach > REAL(0));
}

// What the seeds of a transfer in one attitude mode share.
typedef struct {
    const ssv_phase_context_t* context;
    ssv_capability_t* capability;
    vec3_t displacement_I;   // of where the beam is held
    real_t metre_price;      // along the line of flight, of what is held as it is held
    real_t swing_share;      // part of the price of the turn that is made in flight
    int spun_end, num_spins; // end at which the turn is spun about the beam's axis, and with how many spins
} transfer_seeding_t;

static real_t turn_between(const transfer_seeding_t* seeding, quat_t q_from, quat_t q_to) {
    return ssv_turn_guess(seeding->context->question, &seeding->capability->carried, quat_mul(quat_conj(q_from), q_to));
}

// The vehicle with the beam held along axis_S.
static ssv_assembly_t pair_along(const ssv_scenario_t* s, real_t height_m, vec3_t axis_S) {
    const quat_t q_SB = quat_between(vec3(REAL(0), REAL(0), REAL(1)), axis_S);
    const vec3_t ahead = vec3(s->standoff_m, REAL(0), REAL(0));
    return (ssv_assembly_t){&s->vehicle, &s->beam, {vec3_sub(ahead, vec3_scale(height_m, axis_S)), q_SB}};
}

// Takes up how the beam is held; price is that of a metre for the vehicle alone. @return false if the flight alone
// costs too much to enter the list.
static bool hold_beam(transfer_seeding_t* seeding, const ssv_decision_t* decision, real_t price,
                      const ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const ssv_scenario_t* s = &context->question->problem->scenario;
    const real_t length = real_max(SSV_SHORT_FLIGHT_M, vec3_norm(seeding->displacement_I));
    seeding->metre_price = price;
    if (seeding->capability->regime != SSV_LINEAR_DRAG) {
        const ssv_assembly_t pair = pair_along(s, context->height_m, decision->axis_S);
        seeding->metre_price = real_div(ssv_flight_guess(context->question, &pair, decision->n_S, length), length);
    }
    const real_t least_m = real_max(REAL(0), length - real_mul(REAL(2), s->standoff_m));
    if (is_full_below(seeds, real_mul(least_m, seeding->metre_price))) return false;
    ssv_turns_at(&seeding->capability->rolled, decision->axis_S, &seeding->capability->carried);
    return true;
}

// Enters a decision with each of its spins, by their guessed prices.
static void insert_spins(transfer_seeding_t* seeding, const ssv_decision_t* decision, ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const vec3_t ahead = vec3(context->question->problem->scenario.standoff_m, REAL(0), REAL(0));
    const int spun_end = seeding->spun_end, other_end = 1 - spun_end;
    ssv_attitudes_t a;
    ssv_decision_attitudes(context, decision, seeding->displacement_I, &a);
    const quat_t unspun = a.q_IS[spun_end];
    vec3_t p_IS[SSV_NUM_ENDS];
    p_IS[other_end] = vec3_sub(context->hold_I[other_end], quat_apply(a.q_IS[other_end], ahead));
    real_t turns = turn_between(seeding, a.q_IS[other_end], a.q_IT[other_end]);
    if (seeding->swing_share > REAL(0)) {
        turns += real_mul(seeding->swing_share, turn_between(seeding, a.q_IT[0], a.q_IT[1]));
    }
    ssv_seed_t seed = {.decision = *decision};
    for (int spin = 0; spin < seeding->num_spins; spin++) {
        const quat_t q_IS =
            spin > 0 ? quat_mul(ssv_spin(context->transfer.axis_I[spun_end], spin, REAL(0)), unspun) : unspun;
        p_IS[spun_end] = vec3_sub(context->hold_I[spun_end], quat_apply(q_IS, ahead));
        const real_t flight = real_mul(vec3_norm(vec3_sub(p_IS[1], p_IS[0])), seeding->metre_price);
        seed.decision.spin[spun_end] = spin;
        seed.price = turns + flight + turn_between(seeding, q_IS, a.q_IT[spun_end]);
        ssv_seeds_insert(seeds, &seed);
    }
}

// Half of the swing from where the beam lies to where it docks, with so many spins about its axis.
static vec3_t half_swing(const vec3_t axis_I[SSV_NUM_ENDS], int spin) {
    return ssv_half_of(quat_mul(ssv_spin(axis_I[1], spin, REAL(0)), quat_between(axis_I[0], axis_I[1])));
}

// A swing goes from where the beam lies to where it docks, half of it before the middle of the flight.
static void seed_swings(transfer_seeding_t* seeding, vec3_t direction_I, ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const vec3_t* axis_I = context->transfer.axis_I;
    const ssv_capability_t* capability = seeding->capability;
    for (int spin = 0; spin < SSV_NUM_SPINS; spin++) {
        if (spin > SSV_LAST_SWING && spin < SSV_NUM_SPINS - SSV_LAST_SWING) continue;
        const vec3_t half = half_swing(axis_I, spin);
        const vec3_t middle_axis_I = quat_apply(ssv_turned_by(quat_identity(), half), axis_I[0]);
        for (int k = 0; k < capability->num_upright; k++) {
            for (int side = -1; side <= 1; side += 2) {
                ssv_decision_t decision = {.n_S = capability->n[k]};
                if (!point_beam(side, direction_I, middle_axis_I, &decision)) continue;
                if (!hold_beam(seeding, &decision, capability->price[k], seeds)) continue;
                decision.free.twist = quat_apply(quat_conj(decision.q_IT), half);
                insert_spins(seeding, &decision, seeds);
            }
        }
    }
}

// The beam keeps the attitude of one end, but where it is rolled about the line of flight.
static void seed_held(transfer_seeding_t* seeding, bool rolled, vec3_t direction_I, ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const vec3_t* axis_I = context->transfer.axis_I;
    const ssv_capability_t* capability = seeding->capability;
    for (int end = 0; end < SSV_NUM_ENDS; end++) {
        const int other_end = 1 - end;
        const bool spins = !(other_end == 0 && context->question->problem->scenario.ring_angle_given);
        seeding->spun_end = other_end;
        seeding->num_spins = spins ? SSV_NUM_SPINS : 1;
        for (int k = 0; k < capability->num_upright; k++) {
            for (int side = -1; side <= 1; side += 2) {
                ssv_decision_t decision = {.n_S = capability->n[k]};
                if (!point_beam(side, direction_I, axis_I[end], &decision)) continue;
                if (!hold_beam(seeding, &decision, capability->price[k], seeds)) continue;
                if (rolled) {
                    const quat_t q_other = ssv_attitude(decision.n_S, decision.axis_S, direction_I, axis_I[other_end]);
                    const vec3_t half = ssv_half_of(quat_mul(quat_conj(decision.q_IT), q_other));
                    decision.q_IT = ssv_turned_by(decision.q_IT, half);
                    decision.free.twist = end == 0 ? half : vec3_neg(half);
                }
                insert_spins(seeding, &decision, seeds);
            }
        }
    }
}

// The beam along the line of flight, either way round, and rolled about it so that the turn at one of the ends is about
// the contact's axis or square to it.
static void seed_lengthwise(transfer_seeding_t* seeding, vec3_t direction_I, ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const ssv_capability_t* capability = seeding->capability;
    const int num_ways = capability->either_way_up ? 2 : 4;
    for (int k = 0; k < num_ways * SSV_NUM_ACROSS; k++) {
        const vec3_t line_S = capability->across[k / num_ways];
        ssv_decision_t decision = {.n_S = k % num_ways < 2 ? line_S : vec3_neg(line_S)};
        decision.axis_S = k % 2 == 0 ? decision.n_S : vec3_neg(decision.n_S);
        if (!hold_beam(seeding, &decision, capability->least, seeds)) continue;
        const vec3_t along_I = k % 2 == 0 ? direction_I : vec3_neg(direction_I);
        for (int roll = 0; roll < 2 * SSV_NUM_ENDS; roll++) {
            const vec3_t turned = vec3_cross(context->transfer.axis_I[roll / 2], along_I);
            if (!(vec3_norm(turned) > SSV_NO_ROLL)) continue;
            const vec3_t x_I = roll % 2 == 0 ? turned : vec3_cross(along_I, turned);
            // From the side on which the vehicle comes.
            const real_t side =
                vec3_dot(x_I, vec3_sub(context->hold_I[0], context->question->problem->scenario.X_IS.p));
            decision.q_IT = ssv_attitude(decision.n_S, x_axis, direction_I, side < REAL(0) ? vec3_neg(x_I) : x_I);
            insert_spins(seeding, &decision, seeds);
        }
    }
}

// The vehicle turns no more than it must to take hold of the beam, and then swings it all the way.
static void seed_steady(transfer_seeding_t* seeding, vec3_t direction_I, ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const vec3_t* axis_I = context->transfer.axis_I;
    const quat_t q_IS = context->question->problem->scenario.X_IS.q;
    const vec3_t x_I = quat_apply(q_IS, x_axis);
    const vec3_t across = vec3_sub(x_I, vec3_scale(vec3_dot(x_I, axis_I[0]), axis_I[0]));
    if (!(vec3_norm(across) > SSV_NO_ROLL)) return;
    const quat_t q_mate = quat_mul(quat_between(x_I, vec3_unit(across)), q_IS);
    const vec3_t held_S = quat_apply(quat_conj(q_mate), axis_I[0]);
    for (int spin = 0; spin < SSV_NUM_SPINS; spin++) {
        const vec3_t half = half_swing(axis_I, spin);
        ssv_decision_t decision = {.q_IT = quat_mul(ssv_turned_by(quat_identity(), half), q_mate),
                                   .axis_S = vec3_unit(vec3(REAL(0), held_S.y, held_S.z))};
        decision.n_S = quat_apply(quat_conj(decision.q_IT), direction_I);
        if (!hold_beam(seeding, &decision, seeding->capability->least, seeds)) continue;
        decision.free.twist = quat_apply(quat_conj(decision.q_IT), half);
        insert_spins(seeding, &decision, seeds);
    }
}

void ssv_seed_begin(const ssv_phase_context_t* context, ssv_capability_t* capability) {
    const ssv_problem_t* problem = context->question->problem;
    const ssv_assembly_t pair = pair_along(&problem->scenario, context->height_m, vec3(REAL(0), REAL(1), REAL(0)));
    ssv_turns_of(problem, &pair, &capability->rolled);
}

void ssv_seed_transfer(const ssv_phase_context_t* context, ssv_capability_t* capability, ssv_attitude_mode_t mode,
                       ssv_seeds_t* seeds) {
    SSV_ASSERT(context->phase == SSV_TRANSFER && seeds->num == 0);
    const vec3_t displacement_I = vec3_sub(context->hold_I[1], context->hold_I[0]);
    const bool flies = vec3_norm(displacement_I) > SSV_NO_DIRECTION_M;
    const vec3_t direction_I = flies ? vec3_unit(displacement_I) : context->transfer.axis_I[0];
    transfer_seeding_t seeding = {.context = context,
                                  .capability = capability,
                                  .displacement_I = displacement_I,
                                  .swing_share = mode == SSV_SWUNG || mode == SSV_STEADY ? SSV_SWING_SHARE : REAL(0),
                                  .spun_end = 1,
                                  .num_spins = 1};
    switch (mode) {
        case SSV_HELD:
        case SSV_ROLLED: seed_held(&seeding, mode == SSV_ROLLED, direction_I, seeds); break;
        case SSV_SWUNG: seed_swings(&seeding, direction_I, seeds); break;
        case SSV_LENGTHWISE: seed_lengthwise(&seeding, direction_I, seeds); break;
        case SSV_STEADY: seed_steady(&seeding, direction_I, seeds); break;
        case SSV_NUM_ATTITUDE_MODES: break;
    }
}
