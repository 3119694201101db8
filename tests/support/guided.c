#include "guided.h"

#include <math.h>
#include <string.h>

#include "pilot.h"
#include "sil/sil.h"

#define WANDER_TIME_S 60
#define EPOCH_US INT64_C(1767225600000000)
#define BOOT_ID 41

static void put_vec3(vec3_t v, double out[3]) {
    out[0] = real_to_double(v.x);
    out[1] = real_to_double(v.y);
    out[2] = real_to_double(v.z);
}

static rb_pose_t rb_pose_of(pose_t X) {
    rb_pose_t r;
    put_vec3(X.p, r.p_m);
    r.q[0] = real_to_double(X.q.w);
    put_vec3(vec3(X.q.x, X.q.y, X.q.z), r.q + 1);
    return r;
}

static pose_t pose_of(const rb_pose_t* X) {
    const pose_t r = {
        vec3(real_from_double(X->p_m[0]), real_from_double(X->p_m[1]), real_from_double(X->p_m[2])),
        {real_from_double(X->q[0]), real_from_double(X->q[1]), real_from_double(X->q[2]), real_from_double(X->q[3])}};
    return r;
}

static rb_body_t rb_body_of(const ssv_body_t* body) {
    rb_body_t r = {.mass_kg = real_to_double(body->mass_kg),
                   .drag_lin_kg_s = real_to_double(body->drag_lin_kg_s),
                   .drag_quad_kg_m = real_to_double(body->drag_quad_kg_m),
                   .drag_lin_ang_Nm_s = real_to_double(body->drag_lin_ang_Nm_s),
                   .drag_quad_ang_Nm_s2 = real_to_double(body->drag_quad_ang_Nm_s2)};
    put_vec3(body->inertia_kg_m2, r.inertia_kg_m2);
    put_vec3(body->added_mass_kg, r.added_mass_kg);
    return r;
}

static sim_world_config_t config_of(const ssv_scenario_t* s, double force_max_N, const conditions_t* conditions) {
    sim_world_config_t config = {
        .vehicle = rb_body_of(&s->vehicle.body),
        .beam = rb_body_of(&s->beam.body),
        .X_nb = rb_pose_of(s->X_IS),
        .X_nB = rb_pose_of(s->X_IB),
        .water = {.wander_m_s = {conditions->wander_m_s, conditions->wander_m_s, conditions->wander_m_s},
                  .wander_time_s = WANDER_TIME_S},
        .thrusters = {.gain_spread = conditions->gain_spread,
                      .dead_band = conditions->dead_band_N,
                      .force_forward_max_N = force_max_N,
                      .force_reverse_max_N = force_max_N,
                      .lag_s = conditions->lag_s},
        .navigation = {.rate_Hz = conditions->rate_Hz,
                       .delay_s = conditions->delay_s,
                       .dropout = conditions->dropout,
                       .position_m = {.white = conditions->position_m},
                       .attitude_rad = {.white = conditions->attitude_rad}},
    };
    config.beam.strip_kg_m2 = real_to_double(s->beam.drag_strip_kg_m2);
    config.beam.length_m = real_to_double(s->beam.length_m);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        put_vec3(s->vehicle.thruster[i].p_ST_m, config.thruster[i].r_m);
        put_vec3(s->vehicle.thruster[i].n_T_S, config.thruster[i].n);
    }
    return config;
}

static double angle_between(pose_t one, pose_t other) {
    const quat_t q = quat_mul(quat_conj(one.q), other.q);
    return 2 * atan2(sqrt(real_to_double(q.x) * real_to_double(q.x) + real_to_double(q.y) * real_to_double(q.y) +
                          real_to_double(q.z) * real_to_double(q.z)),
                     fabs(real_to_double(q.w)));
}

void guided_configure(const ssv_problem_t* problem, const ssv_plan_t* plan, double force_max_N,
                      const conditions_t* conditions, sil_config_t* config) {
    const ssv_candidate_t* choice = &plan->quote.choice;
    memset(config, 0, sizeof *config);
    config->world = config_of(&problem->scenario, force_max_N, conditions);
    config->place = (sim_mate_place_t){real_to_double(problem->scenario.standoff_m),
                                       real_to_double(choice->attach_height_m), real_to_double(choice->ring_angle_rad)};
    config->port.contact = choice->contact;
    put_vec3(problem->scenario.p_IP_m, config->port.p_nP_m);
    put_vec3(problem->scenario.axis_I, config->port.axis_n);
    config->force_max_N = force_max_N;
    config->boot_id = 1;
}

static void take_over(const sil_t* sil, flown_t* flown) {
    flown->mate = sil->attempt[SSV_MATE].arrival;
    flown->dock = sil->attempt[SSV_DOCK].arrival;
    flown->num_attempts = sil->num_attempts[SSV_MATE] + sil->num_attempts[SSV_DOCK];
    flown->mated = sil->world.beam != SIM_BEAM_WAITING;
    flown->docked = sil->world.beam == SIM_BEAM_DOCKED;
    flown->time_s = sil->world.t_s;
    flown->impulse_Ns = sil->world.impulse_Ns;
}

// The timeline as it is: mate and dock happen when it says so.
static bool fly_open_loop(const sil_config_t* config, const ssv_plan_t* plan, uint64_t seed, flown_t* flown) {
    static pilot_t pilot;
    static ssv_timeline_t timeline;
    ssv_timeline_of_plan(plan, &timeline);
    if (pilot_init(&pilot, config, &timeline, seed) != NULL) return false;
    (void)pilot_await(&pilot, SSV_LINK_DONE, real_to_double(plan->quote.time_s) + 60);
    take_over(&pilot.sil, flown);
    return true;
}

typedef struct {
    double square_m2, square_rad2;
    int count;
} sums_t;

static void watch(const sil_t* sil, const ssv_executive_t* executive, flown_t* flown, sums_t* sums) {
    const ssv_guidance_t* guidance = &executive->guidance;
    const ssv_guidance_error_t* error = &executive->turn.command.error;
    flown->across_most_m = fmax(flown->across_most_m, real_to_double(error->across_m));
    flown->lag_most_m = fmax(flown->lag_most_m, real_to_double(error->along_m));
    flown->estimate_tip_m = real_to_double(error->tip_m);
    if (!guidance->mated) return;
    if (flown->time_mate_s == 0) {
        flown->time_mate_s = sil->world.t_s;
        flown->grasp_rad = angle_between(pose_of(&sil->world.X_bB), guidance->X_SB);
    }
    if (guidance->state != SSV_GUIDANCE_DWELLING) return;
    const pose_t truth = pose_of(&sil->world.state.eta);
    const double m = real_to_double(vec3_norm(vec3_sub(truth.p, guidance->estimate.X_IS.p)));
    const double rad = angle_between(truth, guidance->estimate.X_IS);
    sums->square_m2 += m * m;
    sums->square_rad2 += rad * rad;
    sums->count++;
}

// What is sent up, and then what is sent down, each frame shown to whoever asked for them.
static void exchange(sil_t* sil, ssv_executive_t* executive, guided_line_t line, void* context) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    size_t length;
    while ((length = ssv_executive_poll(executive, sil->now_us, frame)) > 0) {
        if (line == NULL || line(context, true, sil->now_us, frame, length))
            ssv_vehicle_receive(&sil->vehicle, sil->now_us, frame, length);
    }
    while ((length = ssv_vehicle_poll(&sil->vehicle, sil->now_us, frame)) > 0) {
        if (line == NULL || line(context, false, sil->now_us, frame, length))
            ssv_executive_receive(executive, sil->now_us, frame, length);
    }
}

static bool fly_closed_loop(const sil_config_t* config, const ssv_problem_t* problem, const ssv_plan_t* plan,
                            const conditions_t* conditions, uint64_t seed, flown_t* flown) {
    static sil_t sil;
    static ssv_executive_t executive;
    const ssv_executive_config_t own = {.link = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                                 .compid = SSV_LINK_PLANNER_COMPID,
                                                 .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                                 .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                                 .boot_id = BOOT_ID},
                                        .thruster_lag_s = real_from_double(conditions->known_lag_s)};
    const ssv_executive_order_t order = {EPOCH_US, 60000, 0, real_from_double(config->force_max_N)};
    sums_t sums = {0, 0, 0};
    if (sil_init(&sil, config, seed) != NULL) return false;
    ssv_executive_init(&executive, &own);
    if (!ssv_executive_begin(&executive, 0, problem, plan, &order)) return false;
    while (executive.outcome == SSV_EXECUTIVE_UNDER_WAY) {
        const bool is_due = sil.now_us >= executive.due_us;
        if (is_due) ssv_executive_step(&executive, sil.now_us);
        if (is_due && executive.state == SSV_EXECUTIVE_TRACKING) watch(&sil, &executive, flown, &sums);
        exchange(&sil, &executive, conditions->line, conditions->context);
        sil_step(&sil);
    }
    take_over(&sil, flown);
    flown->outcome = executive.outcome;
    flown->reason = executive.reason;
    flown->position_rms_m = sqrt(sums.square_m2 / (3 * (sums.count + 1e-9)));
    flown->attitude_rms_rad = sqrt(sums.square_rad2 / (3 * (sums.count + 1e-9)));
    return true;
}

bool guided_flight(const ssv_problem_t* problem, const ssv_plan_t* plan, double force_max_N,
                   const conditions_t* conditions, uint64_t seed, flown_t* flown) {
    static sil_config_t config;
    memset(flown, 0, sizeof *flown);
    guided_configure(problem, plan, force_max_N, conditions, &config);
    return conditions->open_loop ? fly_open_loop(&config, plan, seed, flown)
                                 : fly_closed_loop(&config, problem, plan, conditions, seed, flown);
}
