#include "guided.h"

#include <math.h>

#define STEP_S 0.05
#define TICKS 5
#define WANDER_TIME_S 60
#define GRACE_S 600

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
        .hull_radius_m = real_to_double(s->vehicle.radius_m),
        .beam_radius_m = real_to_double(s->beam.radius_m),
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

static bool attempt(sim_world_t* world, const ssv_problem_t* problem, const ssv_plan_t* plan, ssv_attempt_t what,
                    flown_t* flown) {
    const ssv_candidate_t* choice = &plan->quote.choice;
    flown->num_attempts++;
    if (what == SSV_ATTEMPT_MATE) {
        const sim_mate_place_t place = {real_to_double(problem->scenario.standoff_m),
                                        real_to_double(choice->attach_height_m),
                                        real_to_double(choice->ring_angle_rad)};
        const sim_attempt_t tried = sim_world_mate(world, &place);
        flown->mate = tried.arrival;
        flown->mated = tried.outcome == SIM_HIT;
        flown->time_mate_s = world->t_s;
        return flown->mated;
    }
    sim_port_t port = {.contact = choice->contact};
    put_vec3(problem->scenario.p_IP_m, port.p_nP_m);
    put_vec3(problem->scenario.axis_I, port.axis_n);
    const sim_attempt_t tried = sim_world_dock(world, &port);
    flown->dock = tried.arrival;
    flown->docked = tried.outcome == SIM_HIT;
    return flown->docked;
}

static void fly_step(sim_world_t* world, const ssv_plan_t* plan, const ssv_guidance_command_t* command) {
    for (int k = 0; k < TICKS; k++) {
        double u_N[SSV_NUM_THRUSTERS];
        ssv_sample_t sample;
        memset(&sample, 0, sizeof sample);
        const double tick = STEP_S / TICKS;
        const double t =
            real_to_double(command->plan_time_s) + real_to_double(command->clock_rate) * ((k + 0.5) * tick);
        const double end = real_to_double(world->beam == SIM_BEAM_WAITING ? plan->event[0].t_s : plan->quote.time_s);
        if (!command->hold && t < end) ssv_plan_sample(plan, real_from_double(t), &sample);
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            u_N[i] = real_to_double(sample.u_N[i]) + real_to_double(command->trim_N[i]);
        }
        sim_world_step(world, u_N, tick);
    }
}

// The timeline as it is: mate and dock happen when it says so.
static void fly_open_loop(sim_world_t* world, const ssv_problem_t* problem, const ssv_plan_t* plan, flown_t* flown) {
    ssv_guidance_command_t command;
    memset(&command, 0, sizeof command);
    command.clock_rate = REAL(1);
    const double mate_s = real_to_double(plan->event[0].t_s), dock_s = real_to_double(plan->quote.time_s);
    while (world->t_s < dock_s) {
        command.plan_time_s = real_from_double(world->t_s);
        fly_step(world, plan, &command);
        if (!flown->mated && world->t_s >= mate_s) (void)attempt(world, problem, plan, SSV_ATTEMPT_MATE, flown);
    }
    (void)attempt(world, problem, plan, SSV_ATTEMPT_DOCK, flown);
}

static void fly_closed_loop(sim_world_t* world, const ssv_problem_t* problem, const ssv_plan_t* plan,
                            const ssv_guidance_config_t* config, flown_t* flown) {
    static ssv_guidance_t guidance;
    static ssv_guidance_command_t command;
    ssv_guidance_init(&guidance, problem, plan, config);
    const double longest_s = 2 * real_to_double(plan->quote.time_s) + GRACE_S;
    double squares_m2 = 0, squares_rad2 = 0;
    int num_squares = 0;
    while (!flown->docked && world->t_s < longest_s && guidance.state != SSV_GUIDANCE_ABORTED) {
        sim_measurement_t measured;
        while (sim_world_measurement(world, &measured)) {
            ssv_guidance_measure(&guidance, real_from_double(world->t_s - measured.t_s), pose_of(&measured.state.eta));
        }
        if (guidance.state == SSV_GUIDANCE_DWELLING && guidance.mated) {
            const pose_t truth = pose_of(&world->state.eta);
            const double m = real_to_double(vec3_norm(vec3_sub(truth.p, guidance.estimate.X_IS.p)));
            const double rad = angle_between(truth, guidance.estimate.X_IS);
            squares_m2 += m * m;
            squares_rad2 += rad * rad;
            num_squares++;
        }
        ssv_guidance_step(&guidance, real_from_double(STEP_S), &command);
        flown->across_most_m = fmax(flown->across_most_m, real_to_double(command.error.across_m));
        flown->lag_most_m = fmax(flown->lag_most_m, real_to_double(command.error.along_m));
        flown->estimate_tip_m = real_to_double(command.error.tip_m);
        fly_step(world, plan, &command);
        if (command.attempt != SSV_ATTEMPT_NONE) {
            ssv_guidance_attempted(&guidance, attempt(world, problem, plan, command.attempt, flown));
            if (command.attempt == SSV_ATTEMPT_MATE)
                flown->grasp_rad = angle_between(pose_of(&world->X_bB), guidance.X_SB);
        }
    }
    flown->state = guidance.state;
    flown->position_rms_m = sqrt(squares_m2 / (3 * (num_squares + 1e-9)));
    flown->attitude_rms_rad = sqrt(squares_rad2 / (3 * (num_squares + 1e-9)));
}

void guided_flight(const ssv_problem_t* problem, const ssv_plan_t* plan, double force_max_N,
                   const conditions_t* conditions, uint64_t seed, flown_t* flown) {
    static sim_world_t world;
    memset(flown, 0, sizeof *flown);
    const sim_world_config_t config = config_of(&problem->scenario, force_max_N, conditions);
    if (sim_world_init(&world, &config, seed) != NULL) return;
    const ssv_guidance_config_t guidance = {real_from_double(force_max_N), real_from_double(conditions->known_lag_s)};
    if (conditions->open_loop) {
        fly_open_loop(&world, problem, plan, flown);
    } else {
        fly_closed_loop(&world, problem, plan, &guidance, flown);
    }
    flown->time_s = world.t_s;
    flown->impulse_Ns = world.impulse_Ns;
}
