#include "planner/draw.h"

#include "planner/alloc.h"

// Body directions this much dearer per metre than the cheapest are not drawn; the search still finds its way in between.
#define DIRECTION_SLACK REAL(1.05)
// Rolls of a transit about its way.
#define NUM_ROLLS 4
// Spins all around, and cosine and sine of their halves. Their number is odd: half a turn could as well go the other way.
#define NUM_SPINS 5
#define SPIN_STEP REAL(1.2566370614359172)
static const real_t spin_half_cosine[NUM_SPINS] = {
    REAL(1), REAL(0.80901699437494745), REAL(0.30901699437494745), REAL(-0.30901699437494734), REAL(-0.80901699437494734)};
static const real_t spin_half_sine[NUM_SPINS] = {
    REAL(0), REAL(0.58778525229247314), REAL(0.95105651629515353), REAL(0.95105651629515364), REAL(0.58778525229247325)};
// Swings are tried with spins up to this one, either way.
#define LAST_SWING 1
// Part of the price of a turn that it keeps when it is made on the way.
#define SWING_SHARE REAL(0.25)

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
        if (real_abs(sum[0] - sum[1]) > real_mul(SSV_EVEN, sum[0])) return false;
        if (real_abs(squares[0] - squares[1]) > real_mul(SSV_EVEN, squares[0])) return false;
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

static void turns_init(const ssv_task_t* task, turns_t* turns) {
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
static real_t turn_guess(const ssv_task_t* task, const turns_t* turns, vec3_t beam_axis_S, quat_t q) {
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

int ssv_draw_transit(const ssv_task_t* task, const ssv_directions_t* directions, int most, ssv_start_t* list) {
    const vec3_t way = vec3_sub(task->X_to.p, task->X_from.p);
    const real_t distance = vec3_norm(way);
    const bool flies = distance > SSV_NO_WAY_M;
    const vec3_t direction_I = flies ? vec3_unit(way) : vec3(REAL(1), REAL(0), REAL(0));
    const quat_t q_end[SSV_NUM_ENDS] = {task->X_from.q, task->X_to.q};
    int num = 0;
    const vec3_t y_S = vec3(REAL(0), REAL(1), REAL(0));
    turns_t turns;
    turns_init(task, &turns);
    for (int k = -SSV_NUM_ENDS; k < (flies ? directions->num : 0); k++) {
        const vec3_t n_S = k < 0 ? quat_apply(quat_conj(q_end[k + SSV_NUM_ENDS]), direction_I) : directions->n[k];
        const real_t fly = real_mul(distance, k < 0 ? ssv_metre_price(task->problem, n_S) : directions->price[k]);
        if (num == most && fly >= list[most - 1].price) continue;
        quat_t q[SSV_NUM_ENDS];
        for (int end = 0; end < SSV_NUM_ENDS; end++) {
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
    trial->q_IT = ssv_attitude(n, axis_S, direction_I, axis_I);
    return side < 0 || reach > real_abs(along) || !(reach > REAL(0));
}

static void set_twist(vec3_t twist, ssv_trial_t* trial) {
    trial->x[SSV_X_TWIST] = twist.x;
    trial->x[SSV_X_TWIST + 1] = twist.y;
    trial->x[SSV_X_TWIST + 2] = twist.z;
}

// What the draws of a transfer have in common.
typedef struct {
    const ssv_task_t* task;
    vec3_t axis_I[SSV_NUM_ENDS], hold_I[SSV_NUM_ENDS], way;
    turns_t turns;
} scene_t;

static quat_t spin_about(vec3_t axis, int spin) {
    const real_t sine = spin_half_sine[spin];
    return (quat_t){spin_half_cosine[spin], real_mul(sine, axis.x), real_mul(sine, axis.y), real_mul(sine, axis.z)};
}

// Keeps a trial, and the same with the turn at one end spun about the beam's axis there, by their guessed prices.
static void keep_spins(const scene_t* scene, int spun_end, int num_spins, real_t metre_price, real_t swing, ssv_trial_t* trial,
                       int most, ssv_start_t* list, int* num) {
    const ssv_task_t* task = scene->task;
    const vec3_t axis_S = ssv_beam_axis_S(trial->x[SSV_X_MATE_ROLL]);
    quat_t q_IT[SSV_NUM_ENDS], q_IS[SSV_NUM_ENDS];
    vec3_t p_IS[SSV_NUM_ENDS];
    ssv_travel_attitudes(trial, scene->way, q_IT);
    ssv_trial_ends(task, trial, q_IT, q_IS);
    const int other_end = 1 - spun_end;
    const quat_t unspun = q_IS[spun_end], swung = quat_mul(quat_conj(q_IT[0]), q_IT[1]);
    real_t price = turn_guess(task, &scene->turns, axis_S, quat_mul(quat_conj(q_IS[other_end]), q_IT[other_end]));
    if (swing > REAL(0)) price += real_mul(swing, turn_guess(task, &scene->turns, axis_S, swung));
    for (int spin = 0; spin < num_spins; spin++) {
        if (spin > 0) q_IS[spun_end] = quat_mul(spin_about(scene->axis_I[spun_end], spin), unspun);
        trial->x[SSV_X_SPIN + spun_end] = real_mul(SPIN_STEP, real_from_int(spin));
        ssv_stands(task, scene->hold_I, q_IS, p_IS);
        const real_t fly = real_mul(vec3_norm(vec3_sub(p_IS[1], p_IS[0])), metre_price);
        const quat_t turn = quat_mul(quat_conj(q_IS[spun_end]), q_IT[spun_end]);
        keep(list, num, most, trial, price + fly + turn_guess(task, &scene->turns, axis_S, turn));
    }
}

int ssv_draw_transfer(const ssv_task_t* task, const ssv_directions_t* directions, ssv_carry_t carry, int most, ssv_start_t* list) {
    const bool given = task->problem->scenario.ring_angle_given;
    scene_t scene = {.task = task, .axis_I = {ssv_beam_axis_start(task), ssv_beam_axis_end(task)}};
    ssv_hold_points(task, scene.hold_I);
    scene.way = vec3_sub(scene.hold_I[1], scene.hold_I[0]);
    turns_init(task, &scene.turns);
    const vec3_t direction_I = vec3_norm(scene.way) > SSV_NO_WAY_M ? vec3_unit(scene.way) : scene.axis_I[0];
    const quat_t smallest = quat_between(scene.axis_I[0], scene.axis_I[1]);
    int num = 0;
    for (int variant = 0; variant < (carry == SSV_SWUNG ? NUM_SPINS : SSV_NUM_ENDS); variant++) {
        if (carry == SSV_SWUNG && variant > LAST_SWING && variant < NUM_SPINS - LAST_SWING) continue;
        // A swing goes from where the beam lies to where it docks, half of it before the middle of the way.
        const quat_t swing = quat_mul(spin_about(scene.axis_I[1], variant), smallest);
        const vec3_t half_swing = vec3_scale(REAL(0.5), rotation_vector(swing));
        const vec3_t middle_axis_I = quat_apply(ssv_turned_by(quat_identity(), half_swing), scene.axis_I[0]);
        for (int k = 0; k < directions->num_upright; k++) {
            for (int side = -1; side <= 1; side += 2) {
                ssv_trial_t trial = {quat_identity(), directions->n[k], {REAL(0)}};
                if (carry == SSV_SWUNG) {
                    if (!point_beam(side, direction_I, middle_axis_I, &trial)) continue;
                    set_twist(quat_apply(quat_conj(trial.q_IT), half_swing), &trial);
                    keep_spins(&scene, 1, 1, directions->price[k], SWING_SHARE, &trial, most, list, &num);
                    continue;
                }
                const int end = variant, other_end = 1 - end;
                if (!point_beam(side, direction_I, scene.axis_I[end], &trial)) continue;
                if (carry == SSV_ROLLED) {
                    const vec3_t axis_S = ssv_beam_axis_S(trial.x[SSV_X_MATE_ROLL]);
                    const quat_t q_other = ssv_attitude(trial.n_S, axis_S, direction_I, scene.axis_I[other_end]);
                    const vec3_t half = vec3_scale(REAL(0.5), rotation_vector(quat_mul(quat_conj(trial.q_IT), q_other)));
                    trial.q_IT = ssv_turned_by(trial.q_IT, half);
                    set_twist(end == 0 ? half : vec3_neg(half), &trial);
                }
                keep_spins(&scene, other_end, other_end == 0 && given ? 1 : NUM_SPINS, directions->price[k], REAL(0), &trial, most,
                           list, &num);
            }
        }
    }
    return num;
}
