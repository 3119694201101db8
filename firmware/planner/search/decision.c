#include "planner/search/decision.h"

#include "planner/math/assert.h"
#include "planner/profile/estimate.h"
#include "planner/search/budget.h"
#include "planner/search/tolerance.h"

_Static_assert(sizeof(vec3_t) == 3 * sizeof(real_t), "the free numbers lie one after the other, as they are named");

// First steps in rad of rotations and in m of pivots, by measurement.
const ssv_free_number_t ssv_free_number[sizeof(ssv_free_numbers_t) / sizeof(real_t)] = {
    [SSV_NUMBER_OF(turn.x)] = {.first_step = REAL(0.1)},
    [SSV_NUMBER_OF(turn.y)] = {.first_step = REAL(0.1), .flips = true},
    [SSV_NUMBER_OF(turn.z)] = {.first_step = REAL(0.1), .flips = true},
    [SSV_NUMBER_OF(twist.x)] = {.first_step = REAL(0.15)},
    [SSV_NUMBER_OF(twist.y)] = {.first_step = REAL(0.15), .flips = true},
    [SSV_NUMBER_OF(twist.z)] = {.first_step = REAL(0.15), .flips = true},
    [SSV_NUMBER_OF(mate_roll)] = {.first_step = REAL(0.25), .transfer_only = true},
    [SSV_NUMBER_OF(spin[0])] = {.first_step = REAL(0.4), .transfer_only = true},
    [SSV_NUMBER_OF(spin[1])] = {.first_step = REAL(0.4), .transfer_only = true},
    [SSV_NUMBER_OF(pivot[0].x)] = {.first_step = REAL(0.12), .transfer_only = true},
    [SSV_NUMBER_OF(pivot[0].y)] = {.first_step = REAL(0.12), .transfer_only = true, .flips = true},
    [SSV_NUMBER_OF(pivot[0].z)] = {.first_step = REAL(0.12), .transfer_only = true, .flips = true},
    [SSV_NUMBER_OF(pivot[1].x)] = {.first_step = REAL(0.12), .transfer_only = true},
    [SSV_NUMBER_OF(pivot[1].y)] = {.first_step = REAL(0.12), .transfer_only = true, .flips = true},
    [SSV_NUMBER_OF(pivot[1].z)] = {.first_step = REAL(0.12), .transfer_only = true, .flips = true},
};

static const vec3_t x_axis = {REAL(1), REAL(0), REAL(0)}, y_axis = {REAL(0), REAL(1), REAL(0)},
                    z_axis = {REAL(0), REAL(0), REAL(1)};

static real_t square(vec3_t v) { return vec3_dot(v, v); }

// The rotation about an axis by an angle whose cosine and sine are in this ratio: of the two forms of half the angle
// the one that does not cancel.
static quat_t roll_about(vec3_t axis, real_t cosine, real_t sine) {
    const real_t size = real_sqrt(real_sq(cosine) + real_sq(sine));
    const bool back = cosine < REAL(0);
    const vec3_t e = vec3_scale(back ? size - cosine : sine, axis);
    return quat_unit((quat_t){back ? sine : size + cosine, e.x, e.y, e.z});
}

quat_t ssv_attitude(vec3_t a_S, vec3_t b_S, vec3_t a_I, vec3_t b_I) {
    const quat_t q = quat_between(a_S, a_I);
    const vec3_t b = quat_apply(q, b_S);
    const vec3_t from = vec3_sub(b, vec3_scale(vec3_dot(b, a_I), a_I)),
                 to = vec3_sub(b_I, vec3_scale(vec3_dot(b_I, a_I), a_I));
    if (!(real_min(vec3_norm(from), vec3_norm(to)) > SSV_NO_ROLL)) return q;
    const vec3_t u = vec3_unit(from), v = vec3_unit(to);
    return quat_mul(roll_about(a_I, vec3_dot(u, v), vec3_dot(a_I, vec3_cross(u, v))), q);
}

static quat_t rotation_of(vec3_t x) {
    const vec3_t e = vec3_scale(REAL(0.5), x);
    return quat_unit((quat_t){REAL(1), e.x, e.y, e.z});
}

quat_t ssv_turned_by(quat_t q, vec3_t rotation) { return quat_mul(q, rotation_of(rotation)); }

vec3_t ssv_half_of(quat_t q) {
    const real_t sign = q.w < REAL(0) ? REAL(-2) : REAL(2);
    return vec3_scale(real_div(sign, REAL(1) + real_abs(q.w)), vec3(q.x, q.y, q.z));
}

quat_t ssv_spin(vec3_t axis, int spin, real_t x) {
    SSV_ASSERT(0 <= spin && spin < SSV_NUM_SPINS);
    // Of half the angle.
    static const real_t cosine[SSV_NUM_SPINS] = {REAL(1), REAL(0.80901699437494745), REAL(0.30901699437494745),
                                                 REAL(-0.30901699437494734), REAL(-0.80901699437494734)};
    static const real_t sine[SSV_NUM_SPINS] = {REAL(0), REAL(0.58778525229247314), REAL(0.95105651629515353),
                                               REAL(0.95105651629515364), REAL(0.58778525229247325)};
    const real_t half = real_mul(REAL(0.5), x), scale = real_div(REAL(1), real_sqrt(REAL(1) + real_sq(half)));
    const real_t c = real_mul(scale, cosine[spin] - real_mul(half, sine[spin]));
    const real_t s = real_mul(scale, sine[spin] + real_mul(half, cosine[spin]));
    return (quat_t){c, real_mul(s, axis.x), real_mul(s, axis.y), real_mul(s, axis.z)};
}

ssv_phase_context_t ssv_transfer_context(const ssv_question_t* question, int contact, real_t height_m) {
    const ssv_scenario_t* s = &question->problem->scenario;
    ssv_phase_context_t context = {.question = question,
                                   .phase = SSV_TRANSFER,
                                   .contact = contact,
                                   .height_m = height_m,
                                   .closeness = SSV_ESTIMATE_ROUGHLY};
    const real_t from_contact = real_abs(ssv_grasp_contact(s, contact).z - height_m);
    context.transfer.axis_I[0] = quat_apply(s->X_IB.q, z_axis);
    context.transfer.axis_I[1] = contact == 1 ? s->axis_I : vec3_neg(s->axis_I);
    context.hold_I[0] = vec3_add(s->X_IB.p, vec3_scale(height_m, context.transfer.axis_I[0]));
    context.hold_I[1] = vec3_add(s->p_IP_m, vec3_scale(from_contact + question->approach_dock_m, s->axis_I));
    context.transfer.q_given = quat_identity();
    if (s->ring_angle_given) {
        const ssv_grasp_t grasp = {contact, height_m, s->ring_angle_rad};
        context.transfer.q_given =
            ssv_attitude(y_axis, x_axis, context.transfer.axis_I[0], vec3_neg(ssv_grasp_radial(s, &grasp)));
    }
    return context;
}

ssv_phase_context_t ssv_transit_context(const ssv_phase_context_t* transfer, const pose_t* X_to) {
    SSV_ASSERT(transfer->phase == SSV_TRANSFER);
    const pose_t* X_from = &transfer->question->problem->scenario.X_IS;
    const real_t approach_m = transfer->question->approach_mate_m;
    const vec3_t p_to =
        approach_m > REAL(0) ? vec3_sub(X_to->p, vec3_scale(approach_m, quat_apply(X_to->q, x_axis))) : X_to->p;
    return (ssv_phase_context_t){.question = transfer->question,
                                 .phase = SSV_TRANSIT,
                                 .contact = transfer->contact,
                                 .height_m = transfer->height_m,
                                 .hold_I = {X_from->p, p_to},
                                 .transit = {{X_from->q, X_to->q}},
                                 .closeness = transfer->closeness};
}

// What of a decision's attitudes does not depend on where the flight starts and ends.
typedef struct {
    quat_t q_middle, twist;
    vec3_t ahead_S;            // the chord of the flight's arc, in axes of the middle attitude
    vec3_t axis_S;             // the beam's as it is held
    quat_t spin[SSV_NUM_ENDS]; // of a transfer
} carriage_t;

static void carriage_of(const ssv_phase_context_t* context, const ssv_decision_t* decision, carriage_t* c) {
    const vec3_t twist = decision->free.twist;
    const quat_t turn = rotation_of(decision->free.turn);
    const real_t twisted = square(twist);
    c->q_middle = quat_mul(decision->q_IT, turn);
    c->twist = rotation_of(twist);
    c->ahead_S = quat_apply(quat_conj(turn), decision->n_S);
    // Over an arc of twice the angle a, what is across its axis shrinks by sin(a) / a: with t = tan(a / 2) that is
    // t / atan(t) / (1 + t^2), here within 1 % up to t = 1.
    if (twisted > SSV_NO_TWIST_SQ) {
        const real_t tt = real_mul(REAL(0.25), twisted);
        const real_t shrink =
            real_div(REAL(15) + real_mul(REAL(9), tt), real_mul(REAL(1) + tt, REAL(15) + real_mul(REAL(4), tt)));
        const vec3_t along = vec3_scale(real_div(vec3_dot(twist, c->ahead_S), twisted), twist);
        c->ahead_S = vec3_unit(vec3_add(along, vec3_scale(shrink, vec3_sub(c->ahead_S, along))));
    }
    if (context->phase == SSV_TRANSIT) return;
    c->axis_S = quat_apply(ssv_spin(x_axis, 0, decision->free.mate_roll), decision->axis_S);
    for (int end = 0; end < SSV_NUM_ENDS; end++) {
        c->spin[end] = ssv_spin(context->transfer.axis_I[end], decision->spin[end], decision->free.spin[end]);
    }
}

static void aim(const ssv_phase_context_t* context, const carriage_t* c, vec3_t displacement_I, ssv_attitudes_t* a) {
    const bool flies = square(displacement_I) > real_sq(SSV_NO_DIRECTION_M);
    const quat_t q =
        flies ? quat_mul(quat_between(quat_apply(c->q_middle, c->ahead_S), vec3_unit(displacement_I)), c->q_middle)
              : c->q_middle;
    a->q_IT[0] = quat_mul(q, quat_conj(c->twist));
    a->q_IT[1] = quat_mul(q, c->twist);
    for (int end = 0; end < SSV_NUM_ENDS; end++) {
        if (context->phase == SSV_TRANSIT) {
            a->q_IS[end] = context->transit.q_IS[end];
        } else if (end == 0 && context->question->problem->scenario.ring_angle_given) {
            a->q_IS[end] = quat_mul(context->transfer.q_given, roll_about(x_axis, c->axis_S.y, -c->axis_S.z));
        } else {
            const quat_t smallest = quat_between(quat_apply(a->q_IT[end], c->axis_S), context->transfer.axis_I[end]);
            a->q_IS[end] = quat_mul(c->spin[end], quat_mul(smallest, a->q_IT[end]));
        }
    }
}

void ssv_decision_attitudes(const ssv_phase_context_t* context, const ssv_decision_t* decision, vec3_t displacement_I,
                            ssv_attitudes_t* attitudes) {
    carriage_t carriage;
    carriage_of(context, decision, &carriage);
    aim(context, &carriage, displacement_I, attitudes);
}

// The turn about a pivot from one attitude to another, the shorter way round.
static ssv_maneuver_t turn_about(ssv_phase_t phase, quat_t q_from, quat_t q_to, vec3_t pivot_S) {
    const quat_t q = quat_mul(quat_conj(q_from), q_to);
    const vec3_t e = vec3_scale(q.w < REAL(0) ? REAL(-1) : REAL(1), vec3(q.x, q.y, q.z));
    const real_t sine = vec3_norm(e);
    if (!(sine > REAL(0))) return ssv_maneuver_turn(phase, x_axis, REAL(0), pivot_S);
    return ssv_maneuver_turn(phase, vec3_unit(e), real_mul(REAL(2), real_atan2(sine, real_abs(q.w))), pivot_S);
}

void ssv_decision_motion(const ssv_phase_context_t* context, const ssv_decision_t* decision, ssv_motion_t* motion) {
    const bool alone = context->phase == SSV_TRANSIT;
    const vec3_t ahead = vec3(alone ? REAL(0) : context->question->problem->scenario.standoff_m, REAL(0), REAL(0));
    const vec3_t* pivot = decision->free.pivot;
    // From hold_I[0], so that they keep their digits wherever in the tank that is.
    const vec3_t hold[SSV_NUM_ENDS] = {vec3(REAL(0), REAL(0), REAL(0)),
                                       vec3_sub(context->hold_I[1], context->hold_I[0])};
    vec3_t p_T[SSV_NUM_ENDS] = {hold[0], hold[1]};
    carriage_t carriage;
    ssv_attitudes_t a;
    carriage_of(context, decision, &carriage);
    // Where a transfer's flight starts and ends depends on how the vehicle travels, and that on the way from one to the
    // other: a few steps to and fro.
    for (int n = 0; n < (alone ? 1 : SSV_NUM_AIMS); n++) {
        aim(context, &carriage, vec3_sub(p_T[1], p_T[0]), &a);
        for (int end = 0; !alone && end < SSV_NUM_ENDS; end++) {
            const vec3_t turned = quat_apply(a.q_IS[end], vec3_sub(pivot[end], ahead));
            p_T[end] = vec3_add(hold[end], vec3_sub(turned, quat_apply(a.q_IT[end], pivot[end])));
        }
    }
    motion->X_from = (pose_t){vec3_sub(context->hold_I[0], quat_apply(a.q_IS[0], ahead)), a.q_IS[0]};
    motion->assembly = alone ? ssv_vehicle_alone(context->question->problem)
                             : ssv_vehicle_with_beam(context->question->problem, context->height_m, motion->X_from.q);
    motion->maneuver[0] = turn_about(context->phase, a.q_IS[0], a.q_IT[0], pivot[0]);
    motion->maneuver[1] =
        ssv_maneuver_between(context->phase, (pose_t){p_T[0], a.q_IT[0]}, (pose_t){p_T[1], a.q_IT[1]});
    motion->maneuver[2] = turn_about(context->phase, a.q_IT[1], a.q_IS[1], pivot[1]);
    motion->num_maneuvers = 3;
    const ssv_scenario_t* s = &context->question->problem->scenario;
    const real_t approach_m = alone ? context->question->approach_mate_m : context->question->approach_dock_m;
    if (approach_m > REAL(0)) {
        const vec3_t way_S = alone ? vec3_scale(approach_m, x_axis)
                                   : quat_apply(quat_conj(a.q_IS[1]), vec3_scale(-approach_m, s->axis_I));
        motion->maneuver[motion->num_maneuvers++] = ssv_maneuver_translate(context->phase, way_S);
    }
    for (int k = 0; k < motion->num_maneuvers; k++)
        ssv_maneuver_limit(s, &motion->assembly, k == 3, &motion->maneuver[k]);
}

ssv_grasp_t ssv_phase_grasp(const ssv_phase_context_t* context, const pose_t* X_IS) {
    const ssv_scenario_t* s = &context->question->problem->scenario;
    const vec3_t outward_B = quat_apply(quat_conj(s->X_IB.q), vec3_neg(quat_apply(X_IS->q, x_axis)));
    const real_t ring_angle = s->ring_angle_given ? s->ring_angle_rad : real_atan2(outward_B.y, outward_B.x);
    return (ssv_grasp_t){context->contact, context->height_m, ring_angle};
}

SSV_OWN_FRAME pose_t ssv_decision_start(const ssv_phase_context_t* context, const ssv_decision_t* decision) {
    ssv_motion_t motion;
    ssv_decision_motion(context, decision, &motion);
    return motion.X_from;
}

bool ssv_motion_keeps_clear(const ssv_phase_context_t* context, const ssv_motion_t* motion,
                            ssv_clearance_t* clearance) {
    const ssv_problem_t* problem = context->question->problem;
    const ssv_flight_t flight = {&problem->scenario, &problem->around, &motion->assembly,    motion->X_from,
                                 context->contact,   motion->maneuver, motion->num_maneuvers};
    return ssv_keeps_clear(&flight, SSV_SHORTFALL_BRACKET_M, clearance);
}

SSV_OWN_FRAME bool ssv_decision_keeps_clear(const ssv_phase_context_t* context, const ssv_decision_t* decision) {
    if (!context->question->problem->around.counts) return true;
    ssv_motion_t motion;
    ssv_clearance_t clearance;
    ssv_decision_motion(context, decision, &motion);
    return ssv_motion_keeps_clear(context, &motion, &clearance);
}

// What comes too near pays for it, the more the nearer it comes, so that the search slides out of what is in the way.
SSV_OWN_FRAME static real_t with_shortfall(const ssv_phase_context_t* context, const ssv_motion_t* motion,
                                           real_t price) {
    ssv_clearance_t clearance;
    if (ssv_motion_keeps_clear(context, motion, &clearance)) return price;
    const real_t lacks_m = context->question->problem->scenario.margin_m - clearance.seen_m;
    const real_t pays = real_mul(SSV_SHORTFALL_PER_M, real_max(REAL(0), real_min(SSV_SHORTFALL_MOST_M, lacks_m)));
    return real_mul(price, SSV_SHORTFALL_AT_LEAST + pays);
}

static bool estimate(const ssv_phase_context_t* context, const ssv_motion_t* motion, real_t* price) {
    if (!ssv_maneuvers_estimate(context->question, &motion->assembly, motion->maneuver, motion->num_maneuvers,
                                context->closeness, price)) {
        return false;
    }
    if (context->question->problem->around.counts) *price = with_shortfall(context, motion, *price);
    return true;
}

real_t ssv_decision_price(ssv_phase_context_t* context, const ssv_decision_t* decision) {
    SSV_ASSERT(context->transit_before == NULL || context->phase == SSV_TRANSFER);
    ssv_motion_t motion;
    real_t price, before = REAL(0);
    ssv_decision_motion(context, decision, &motion);
    context->num_priced++;
    if (!estimate(context, &motion, &price)) return SSV_NO_PRICE;
    if (context->transit_before != NULL) {
        const ssv_phase_context_t transit = ssv_transit_context(context, &motion.X_from);
        ssv_decision_motion(&transit, context->transit_before, &motion);
        if (!estimate(context, &motion, &before)) return SSV_NO_PRICE;
    }
    return price + before;
}

ssv_decision_t ssv_other_way_up(const ssv_decision_t* transfer) {
    const quat_t half_turn = {REAL(0), REAL(1), REAL(0), REAL(0)};
    ssv_decision_t other = *transfer;
    other.q_IT = quat_mul(transfer->q_IT, half_turn);
    other.n_S = quat_apply(half_turn, transfer->n_S);
    other.axis_S = vec3_neg(transfer->axis_S);
    for (int k = 0; k < SSV_NUM_FREE; k++) {
        if (ssv_free_number[k].flips) other.free.number[k] = -other.free.number[k];
    }
    return other;
}
