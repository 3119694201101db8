#include "flight.h"

static void put_vec3(vec3_t v, double out[3]) {
    out[0] = real_to_double(v.x);
    out[1] = real_to_double(v.y);
    out[2] = real_to_double(v.z);
}

static rb_pose_t pose_of(pose_t X) {
    rb_pose_t r;
    put_vec3(X.p, r.p_m);
    r.q[0] = real_to_double(X.q.w);
    put_vec3(vec3(X.q.x, X.q.y, X.q.z), r.q + 1);
    return r;
}

static rb_body_t body_of(const ssv_body_t* body) {
    rb_body_t r;
    memset(&r, 0, sizeof r);
    r.mass_kg = real_to_double(body->mass_kg);
    put_vec3(body->inertia_kg_m2, r.inertia_kg_m2);
    put_vec3(body->added_mass_kg, r.added_mass_kg);
    r.drag_lin_kg_s = real_to_double(body->drag_lin_kg_s);
    r.drag_quad_kg_m = real_to_double(body->drag_quad_kg_m);
    r.drag_lin_ang_Nm_s = real_to_double(body->drag_lin_ang_Nm_s);
    r.drag_quad_ang_Nm_s2 = real_to_double(body->drag_quad_ang_Nm_s2);
    return r;
}

plan_file_t file_of_plan(const ssv_problem_t* problem, const ssv_plan_t* plan) {
    const ssv_scenario_t* s = &problem->scenario;
    static plan_segment_t segment[SSV_MAX_SEGMENTS];
    plan_file_t file;
    memset(&file, 0, sizeof file);
    file.vehicle = body_of(&s->vehicle.body);
    file.beam = body_of(&s->beam.body);
    file.beam.strip_kg_m2 = real_to_double(s->beam.drag_strip_kg_m2);
    file.beam.length_m = real_to_double(s->beam.length_m);
    file.force_max_N = real_to_double(s->vehicle.force_max_N);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        put_vec3(s->vehicle.thruster[i].p_ST_m, file.thruster[i].r_m);
        put_vec3(s->vehicle.thruster[i].n_T_S, file.thruster[i].n);
    }
    file.X_IS = pose_of(s->X_IS);
    file.X_IB = pose_of(s->X_IB);
    put_vec3(s->p_IP_m, file.p_IP_m);
    put_vec3(s->axis_I, file.axis_I);
    file.standoff_m = real_to_double(s->standoff_m);
    file.contact = plan->quote.choice.contact;
    file.attach_height_m = real_to_double(plan->quote.choice.attach_height_m);
    file.ring_angle_rad = real_to_double(plan->quote.choice.ring_angle_rad);
    file.num_segments = (size_t)plan->num_segments;
    file.segment = segment;
    for (int k = 0; k < plan->num_segments; k++) {
        segment[k].duration_s = real_to_double(plan->segment[k].duration_s);
        for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
            segment[k].u_start_N[i] = real_to_double(plan->segment[k].u_start_N[i]);
            segment[k].u_end_N[i] = real_to_double(plan->segment[k].u_end_N[i]);
        }
        if (plan->leg[plan->segment[k].leg].phase == SSV_TRANSIT) file.num_transit_segments++;
    }
    return file;
}

bool flight_of_plan(const ssv_problem_t* problem, const ssv_plan_t* plan, replay_flight_t* flight) {
    const plan_file_t file = file_of_plan(problem, plan);
    return replay_fly(&file, NULL, flight) == REPLAY_JUDGED;
}
