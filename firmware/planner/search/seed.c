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
    // First the directions in which the attitudes at the ends fly, then those that are cheap.
    for (int k = -SSV_NUM_ENDS; k < (flies ? capability->num : 0); k++) {
        const vec3_t n_S = k < 0 ? quat_apply(quat_conj(q_end[k + SSV_NUM_ENDS]), direction_I) : capability->n[k];
        const real_t flight = real_mul(length, k < 0 ? ssv_metre_price(question, n_S) : capability->price[k]);
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
    const ssv_turns_t* turns; // as the beam is held
    real_t metre_price;       // along the line of flight
    real_t swing_share;       // part of the price of the turn that is made in flight
    int spun_end, num_spins;  // end at which the turn is spun about the beam's axis, and with how many spins
} transfer_seeding_t;

static real_t turn_between(const transfer_seeding_t* seeding, quat_t q_from, quat_t q_to) {
    return ssv_turn_guess(seeding->context->question, seeding->turns, quat_mul(quat_conj(q_from), q_to));
}

// Enters a decision with each of its spins, by their guessed prices.
static void insert_spins(const transfer_seeding_t* seeding, const ssv_decision_t* decision, ssv_seeds_t* seeds) {
    const ssv_phase_context_t* context = seeding->context;
    const vec3_t ahead = vec3(context->question->problem->scenario.standoff_m, REAL(0), REAL(0));
    const int spun_end = seeding->spun_end, other_end = 1 - spun_end;
    ssv_attitudes_t a;
    ssv_decision_attitudes(context, decision, vec3_sub(context->hold_I[1], context->hold_I[0]), &a);
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

// The vehicle and the beam as it is held along +y.
static ssv_assembly_t pair_along_y(const ssv_scenario_t* s, real_t height_m) {
    const quat_t q_SB = quat_between(vec3(REAL(0), REAL(0), REAL(1)), vec3(REAL(0), REAL(1), REAL(0)));
    return (ssv_assembly_t){&s->vehicle, &s->beam, {vec3(s->standoff_m, -height_m, REAL(0)), q_SB}};
}

void ssv_seed_transfer(const ssv_phase_context_t* context, ssv_capability_t* capability, ssv_attitude_mode_t mode,
                       ssv_seeds_t* seeds) {
    SSV_ASSERT(context->phase == SSV_TRANSFER && seeds->num == 0);
    const ssv_scenario_t* s = &context->question->problem->scenario;
    const vec3_t* axis_I = context->transfer.axis_I;
    const vec3_t displacement_I = vec3_sub(context->hold_I[1], context->hold_I[0]);
    const bool flies = vec3_norm(displacement_I) > SSV_NO_DIRECTION_M;
    const vec3_t direction_I = flies ? vec3_unit(displacement_I) : axis_I[0];
    const quat_t smallest = quat_between(axis_I[0], axis_I[1]);
    const bool swings = mode == SSV_SWUNG;
    const ssv_assembly_t pair = pair_along_y(s, context->height_m);
    ssv_turns_of(context->question->problem, &pair, &capability->rolled);
    // Of a swing the variant is its spin, else the end whose attitude the beam keeps.
    for (int variant = 0; variant < (swings ? SSV_NUM_SPINS : SSV_NUM_ENDS); variant++) {
        if (swings && variant > SSV_LAST_SWING && variant < SSV_NUM_SPINS - SSV_LAST_SWING) continue;
        // A swing goes from where the beam lies to where it docks, half of it before the middle of the flight.
        const vec3_t half_swing = ssv_half_of(quat_mul(ssv_spin(axis_I[1], variant, REAL(0)), smallest));
        const vec3_t middle_axis_I = quat_apply(ssv_turned_by(quat_identity(), half_swing), axis_I[0]);
        const int end = swings ? 0 : variant, other_end = 1 - end;
        const bool spins = !swings && !(other_end == 0 && s->ring_angle_given);
        for (int k = 0; k < capability->num_upright; k++) {
            const transfer_seeding_t seeding = {.context = context,
                                                .turns = &capability->carried,
                                                .metre_price = capability->price[k],
                                                .swing_share = swings ? SSV_SWING_SHARE : REAL(0),
                                                .spun_end = other_end,
                                                .num_spins = spins ? SSV_NUM_SPINS : 1};
            for (int side = -1; side <= 1; side += 2) {
                ssv_decision_t decision = {.n_S = capability->n[k]};
                if (!point_beam(side, direction_I, swings ? middle_axis_I : axis_I[end], &decision)) continue;
                ssv_turns_at(&capability->rolled, decision.axis_S, &capability->carried);
                if (swings) {
                    decision.free.twist = quat_apply(quat_conj(decision.q_IT), half_swing);
                } else if (mode == SSV_ROLLED) {
                    const quat_t q_other = ssv_attitude(decision.n_S, decision.axis_S, direction_I, axis_I[other_end]);
                    const vec3_t half = ssv_half_of(quat_mul(quat_conj(decision.q_IT), q_other));
                    decision.q_IT = ssv_turned_by(decision.q_IT, half);
                    decision.free.twist = end == 0 ? half : vec3_neg(half);
                }
                insert_spins(&seeding, &decision, seeds);
            }
        }
    }
}
