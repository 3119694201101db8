#include "planner/model/body.h"

#include "planner/math/gauss.h"

static void wrench_add(ssv_wrench_t* sum, vec3_t force, vec3_t moment) {
    sum->force = vec3_add(sum->force, force);
    sum->moment = vec3_add(sum->moment, moment);
}

// A strip at height z moves across the tube with a + b z; it takes |a + b z| (a + b z) per unit of drag and length.
static void add_strips(ssv_wrench_t* sum, vec3_t a, vec3_t b, real_t z_from, real_t z_to) {
    if (!(z_to > z_from)) return;
    const real_t mid = real_mul(REAL(0.5), z_from + z_to), half = real_mul(REAL(0.5), z_to - z_from);
    for (int k = 0; k < GAUSS_8_POINTS; k++) {
        const real_t z = mid + real_mul(half, gauss_8[k].node);
        const real_t x = a.x + real_mul(b.x, z), y = a.y + real_mul(b.y, z);
        const real_t share = real_mul(real_mul(gauss_8[k].weight, half), real_sqrt(real_sq(x) + real_sq(y)));
        const real_t f_x = real_mul(share, x), f_y = real_mul(share, y);
        sum->force.x += f_x;
        sum->force.y += f_y;
        sum->moment.x -= real_mul(z, f_y);
        sum->moment.y += real_mul(z, f_x);
    }
}

// Strip theory in axes of B, moment about B. Two panels meet where the strip is slowest, if it is one of the tube's: |a
// + b z| has its kink there.
static ssv_wrench_t strip_drag(const ssv_beam_t* beam, vec3_t v_B, vec3_t w_B) {
    const real_t half = real_mul(REAL(0.5), beam->length_m);
    const vec3_t a = vec3(v_B.x, v_B.y, REAL(0));
    const vec3_t b = vec3(w_B.y, -w_B.x, REAL(0));
    const real_t bb = vec3_dot(b, b), ab = vec3_dot(a, b);
    const real_t z0 = real_abs(ab) < real_mul(half, bb) ? -real_div(ab, bb) : half;
    ssv_wrench_t sum = {vec3(REAL(0), REAL(0), REAL(0)), vec3(REAL(0), REAL(0), REAL(0))};
    add_strips(&sum, a, b, -half, z0);
    add_strips(&sum, a, b, z0, half);
    return (ssv_wrench_t){vec3_scale(beam->drag_strip_kg_m2, sum.force),
                          vec3_scale(beam->drag_strip_kg_m2, sum.moment)};
}

// a x (m a), m by axis: exactly zero where all of m is the same. Noise in its place would keep idle curves apart.
static vec3_t gyration(vec3_t m, vec3_t a) {
    return vec3(real_mul(m.z - m.y, real_mul(a.y, a.z)), real_mul(m.x - m.z, real_mul(a.z, a.x)),
                real_mul(m.y - m.x, real_mul(a.x, a.y)));
}

// What one body asks for in its own frame Q, moving with v_Q, w_Q: momenta, drag, and Kirchhoff's w x P = F and
// w x H + v x P = M, with P and H per unit of speed.
static ssv_demand_t demand_in_Q(const ssv_body_t* body, vec3_t v_Q, vec3_t w_Q) {
    const vec3_t mass = vec3(body->mass_kg + body->added_mass_kg.x, body->mass_kg + body->added_mass_kg.y,
                             body->mass_kg + body->added_mass_kg.z);
    ssv_demand_t demand = {{vec3_mul(mass, v_Q), vec3_mul(body->inertia_kg_m2, w_Q)},
                           {vec3_scale(body->drag_lin_kg_s, v_Q), vec3_scale(body->drag_lin_ang_Nm_s, w_Q)},
                           {vec3_scale(real_mul(body->drag_quad_kg_m, vec3_norm(v_Q)), v_Q),
                            vec3_scale(real_mul(body->drag_quad_ang_Nm_s2, vec3_norm(w_Q)), w_Q)}};
    wrench_add(&demand.quadratic, vec3_cross(w_Q, demand.accel.force),
               vec3_add(gyration(body->inertia_kg_m2, w_Q), gyration(mass, v_Q)));
    return demand;
}

static void add_on_S(ssv_wrench_t* sum, pose_t X_SQ, ssv_wrench_t on_Q) {
    const vec3_t force = quat_apply(X_SQ.q, on_Q.force);
    wrench_add(sum, force, vec3_add(quat_apply(X_SQ.q, on_Q.moment), vec3_cross(X_SQ.p, force)));
}

void ssv_body_demand(const ssv_assembly_t* assembly, ssv_twist_t twist, ssv_demand_t* demand) {
    *demand = demand_in_Q(&assembly->vehicle->body, twist.v, twist.w);
    if (assembly->beam != NULL) {
        const ssv_beam_t* beam = assembly->beam;
        const quat_t q_BS = quat_conj(assembly->X_SB.q);
        const vec3_t v_B = quat_apply(q_BS, vec3_add(twist.v, vec3_cross(twist.w, assembly->X_SB.p)));
        const vec3_t w_B = quat_apply(q_BS, twist.w);
        ssv_demand_t on_B = demand_in_Q(&beam->body, v_B, w_B);
        if (beam->drag_strip_kg_m2 > REAL(0)) {
            const ssv_wrench_t strip = strip_drag(beam, v_B, w_B);
            wrench_add(&on_B.quadratic, strip.force, strip.moment);
        }
        add_on_S(&demand->accel, assembly->X_SB, on_B.accel);
        if (beam->body.drag_lin_kg_s > REAL(0) || beam->body.drag_lin_ang_Nm_s > REAL(0)) {
            add_on_S(&demand->linear, assembly->X_SB, on_B.linear);
        }
        add_on_S(&demand->quadratic, assembly->X_SB, on_B.quadratic);
    }
}

vec3_t ssv_body_centre(const ssv_assembly_t* assembly) {
    if (assembly->beam == NULL) return vec3(REAL(0), REAL(0), REAL(0));
    const real_t m_S = assembly->vehicle->body.mass_kg, m_B = assembly->beam->body.mass_kg;
    return vec3_scale(real_div(m_B, m_S + m_B), assembly->X_SB.p);
}
