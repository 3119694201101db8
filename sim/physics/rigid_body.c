#include "rigid_body.h"

#include <math.h>
#include <string.h>

#define STANDARD_GRAVITY_M_S2 9.80665

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double norm(const double a[3]) { return sqrt(dot(a, a)); }

void rb_cross(const double a[3], const double b[3], double c[3]) {
    const double r[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    memcpy(c, r, sizeof r);
}

static void rotation_matrix(const double q[4], double R[3][3]) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    R[0][0] = w * w + x * x - y * y - z * z;
    R[0][1] = 2 * (x * y - w * z);
    R[0][2] = 2 * (x * z + w * y);
    R[1][0] = 2 * (x * y + w * z);
    R[1][1] = w * w - x * x + y * y - z * z;
    R[1][2] = 2 * (y * z - w * x);
    R[2][0] = 2 * (x * z - w * y);
    R[2][1] = 2 * (y * z + w * x);
    R[2][2] = w * w - x * x - y * y + z * z;
}

void rb_rotate(const double q[4], const double v_b[3], double v_n[3]) {
    double R[3][3];
    rotation_matrix(q, R);
    const double r[3] = {dot(R[0], v_b), dot(R[1], v_b), dot(R[2], v_b)};
    memcpy(v_n, r, sizeof r);
}

void rb_rotate_back(const double q[4], const double v_n[3], double v_b[3]) {
    const double conjugate[4] = {q[0], -q[1], -q[2], -q[3]};
    rb_rotate(conjugate, v_n, v_b);
}

static void quaternion_product(const double a[4], const double b[4], double c[4]) {
    c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static void normalise(double q[4]) {
    const double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) {
        q[i] /= n;
    }
}

rb_pose_t rb_compose(const rb_pose_t* X_ab, const rb_pose_t* X_bc) {
    rb_pose_t X_ac;
    rb_rotate(X_ab->q, X_bc->p_m, X_ac.p_m);
    for (int i = 0; i < 3; i++) {
        X_ac.p_m[i] += X_ab->p_m[i];
    }
    quaternion_product(X_ab->q, X_bc->q, X_ac.q);
    normalise(X_ac.q);
    return X_ac;
}

rb_pose_t rb_relative(const rb_pose_t* X_ab, const rb_pose_t* X_ac) {
    const double q_ba[4] = {X_ab->q[0], -X_ab->q[1], -X_ab->q[2], -X_ab->q[3]};
    rb_pose_t X_bc;
    for (int i = 0; i < 3; i++) {
        X_bc.p_m[i] = X_ac->p_m[i] - X_ab->p_m[i];
    }
    rb_rotate(q_ba, X_bc.p_m, X_bc.p_m);
    quaternion_product(q_ba, X_ac->q, X_bc.q);
    normalise(X_bc.q);
    return X_bc;
}

/// Velocity of a part's own frame, in its own axes, when {b} moves with nu.
static void velocity_of_part(const rb_pose_t* X_b, const double nu[6], double nu_part[6]) {
    double swept[3];
    rb_cross(nu + 3, X_b->p_m, swept);
    for (int i = 0; i < 3; i++) {
        swept[i] += nu[i];
    }
    rb_rotate_back(X_b->q, swept, nu_part);
    rb_rotate_back(X_b->q, nu + 3, nu_part + 3);
}

/// Adds a wrench about the part's origin, in its axes, to one about {b}'s origin. Momentum moves by the same rule.
static void add_wrench_of_part(const rb_pose_t* X_b, const double wrench_part[6], double wrench[6]) {
    double force[3], moment[3], lever[3];
    rb_rotate(X_b->q, wrench_part, force);
    rb_rotate(X_b->q, wrench_part + 3, moment);
    rb_cross(X_b->p_m, force, lever);
    for (int i = 0; i < 3; i++) {
        wrench[i] += force[i];
        wrench[3 + i] += moment[i] + lever[i];
    }
}

static void assemble_weight(rb_craft_t* craft) {
    for (int part = 0; part < craft->num_bodies; part++) {
        const rb_body_t* body = &craft->body[part];
        const double buoyancy_N = body->mass_kg * STANDARD_GRAVITY_M_S2 - body->net_weight_N;
        double lever[3];
        rb_rotate(craft->X_b[part].q, body->centre_of_buoyancy_m, lever);
        craft->lift_N -= body->net_weight_N;
        for (int i = 0; i < 3; i++) {
            craft->lift_moment_Nm[i] += buoyancy_N * lever[i] - body->net_weight_N * craft->X_b[part].p_m[i];
        }
    }
}

static void assemble_mass(rb_craft_t* craft) {
    memset(craft->M, 0, sizeof craft->M);
    for (int part = 0; part < craft->num_bodies; part++) {
        const rb_body_t* body = &craft->body[part];
        for (int column = 0; column < 6; column++) {
            double nu[6] = {0}, nu_part[6], momentum[6], image[6] = {0};
            nu[column] = 1;
            velocity_of_part(&craft->X_b[part], nu, nu_part);
            for (int i = 0; i < 3; i++) {
                momentum[i] = (body->mass_kg + body->added_mass_kg[i]) * nu_part[i];
                momentum[3 + i] = (body->inertia_kg_m2[i] + body->added_inertia_kg_m2[i]) * nu_part[3 + i];
            }
            add_wrench_of_part(&craft->X_b[part], momentum, image);
            for (int row = 0; row < 6; row++) {
                craft->M[row][column] += image[row];
            }
        }
    }
    memset(craft->M_chol, 0, sizeof craft->M_chol);
    for (int row = 0; row < 6; row++) {
        for (int column = 0; column <= row; column++) {
            double rest = craft->M[row][column];
            for (int k = 0; k < column; k++) {
                rest -= craft->M_chol[row][k] * craft->M_chol[column][k];
            }
            craft->M_chol[row][column] = row == column ? sqrt(rest) : rest / craft->M_chol[column][column];
        }
    }
}

static void assemble(rb_craft_t* craft) {
    craft->lift_N = 0;
    memset(craft->lift_moment_Nm, 0, sizeof craft->lift_moment_Nm);
    assemble_weight(craft);
    assemble_mass(craft);
}

void rb_craft_alone(rb_craft_t* craft, const rb_body_t* body) {
    const rb_pose_t identity = {{0, 0, 0}, {1, 0, 0, 0}};
    memset(craft, 0, sizeof *craft);
    craft->num_bodies = 1;
    craft->body[0] = *body;
    craft->X_b[0] = identity;
    assemble(craft);
}

void rb_craft_joined(rb_craft_t* craft, const rb_body_t* first, const rb_body_t* second, const rb_pose_t* X_b) {
    rb_craft_alone(craft, first);
    craft->num_bodies = 2;
    craft->body[1] = *second;
    craft->X_b[1] = *X_b;
    assemble(craft);
}

void rb_momentum(const rb_craft_t* craft, const double nu[6], double momentum[6]) {
    for (int row = 0; row < 6; row++) {
        momentum[row] = 0;
        for (int column = 0; column < 6; column++) {
            momentum[row] += craft->M[row][column] * nu[column];
        }
    }
}

void rb_velocity(const rb_craft_t* craft, const double momentum[6], double nu[6]) {
    double y[6];
    for (int row = 0; row < 6; row++) {
        y[row] = momentum[row];
        for (int k = 0; k < row; k++) {
            y[row] -= craft->M_chol[row][k] * y[k];
        }
        y[row] /= craft->M_chol[row][row];
    }
    for (int row = 5; row >= 0; row--) {
        nu[row] = y[row];
        for (int k = row + 1; k < 6; k++) {
            nu[row] -= craft->M_chol[k][row] * nu[k];
        }
        nu[row] /= craft->M_chol[row][row];
    }
}

rb_pose_t rb_take_hold(rb_craft_t* craft, rb_state_t* state, const rb_body_t* second, const rb_pose_t* X_n) {
    const rb_body_t first = craft->body[0];
    const rb_pose_t X_b = rb_relative(&state->eta, X_n);
    double momentum[6];
    rb_momentum(craft, state->nu, momentum);
    rb_craft_joined(craft, &first, second, &X_b);
    rb_velocity(craft, momentum, state->nu);
    return X_b;
}

/// Antiderivatives at x of r, x r and x^2 r with r = sqrt(x^2 + c2).
static void root_moments(double x, double c2, double out[3]) {
    const double r = sqrt(x * x + c2);
    const double arc = c2 > 0 ? c2 * asinh(x / sqrt(c2)) : 0;
    out[0] = (x * r + arc) / 2;
    out[1] = r * r * r / 3;
    out[2] = (x * (2 * x * x + c2) * r - c2 * arc) / 8;
}

/// speed[n] = integral of |a + b z| z^n over -h..h, the strips' cross-flow speeds along the tube.
static void strip_speed_moments(const double a[2], const double b[2], double h, double speed[3]) {
    static const double node[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static const double weight[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const double a2 = a[0] * a[0] + a[1] * a[1], b2 = b[0] * b[0] + b[1] * b[1], ab = a[0] * b[0] + a[1] * b[1];
    memset(speed, 0, 3 * sizeof *speed);
    if (b2 * h * h * 16 <= a2) {
        // The closed form below cancels when the tube hardly turns. The speed is then a smooth function of z, without
        // singularity within 4 h of the centre, and Gauss-Legendre with 8 points errs by less than 1e-13.
        for (int i = 0; i < 8; i++) {
            const double z = (i % 2 == 0 ? h : -h) * node[i / 2];
            const double part = weight[i / 2] * h * sqrt(fmax(a2 + 2 * ab * z + b2 * z * z, 0));
            speed[0] += part;
            speed[1] += part * z;
            speed[2] += part * z * z;
        }
        return;
    }
    // |a + b z| = |b| sqrt(x^2 + c^2) with x = z - z0, where z0 is the slowest strip and |b| c its speed.
    const double z0 = -ab / b2, across = (a[0] * b[1] - a[1] * b[0]) / b2, c2 = across * across;
    double low[3], high[3];
    root_moments(-h - z0, c2, low);
    root_moments(h - z0, c2, high);
    const double x0 = high[0] - low[0], x1 = high[1] - low[1], x2 = high[2] - low[2], slope = sqrt(b2);
    speed[0] = slope * x0;
    speed[1] = slope * (x1 + z0 * x0);
    speed[2] = slope * (x2 + 2 * z0 * x1 + z0 * z0 * x0);
}

/// Drag of one body about its centre of mass, in its own axes.
static void drag_of_body(const rb_body_t* body, const double nu[6], double tau[6]) {
    const double translation = body->drag_lin_kg_s + body->drag_quad_kg_m * norm(nu);
    const double rotation = body->drag_lin_ang_Nm_s + body->drag_quad_ang_Nm_s2 * norm(nu + 3);
    for (int i = 0; i < 3; i++) {
        tau[i] = -translation * nu[i];
        tau[3 + i] = -rotation * nu[3 + i];
    }
    if (body->strip_kg_m2 > 0) {
        // The strip at (0, 0, z) crosses the water with v + w x (0, 0, z) = a + b z.
        const double a[2] = {nu[0], nu[1]}, b[2] = {nu[4], -nu[3]};
        double speed[3];
        strip_speed_moments(a, b, body->length_m / 2, speed);
        for (int i = 0; i < 2; i++) {
            tau[i] -= body->strip_kg_m2 * (a[i] * speed[0] + b[i] * speed[1]);
        }
        tau[3] += body->strip_kg_m2 * (a[1] * speed[1] + b[1] * speed[2]);
        tau[4] -= body->strip_kg_m2 * (a[0] * speed[1] + b[0] * speed[2]);
    }
}

void rb_drag(const rb_craft_t* craft, const double nu[6], double tau[6]) {
    memset(tau, 0, 6 * sizeof *tau);
    for (int part = 0; part < craft->num_bodies; part++) {
        double nu_part[6], tau_part[6];
        velocity_of_part(&craft->X_b[part], nu, nu_part);
        drag_of_body(&craft->body[part], nu_part, tau_part);
        add_wrench_of_part(&craft->X_b[part], tau_part, tau);
    }
}

void rb_weight(const rb_craft_t* craft, const double q[4], double tau[6]) {
    const double up_n[3] = {0, 0, 1};
    double up_b[3];
    rb_rotate_back(q, up_n, up_b);
    for (int i = 0; i < 3; i++) {
        tau[i] = craft->lift_N * up_b[i];
    }
    rb_cross(craft->lift_moment_Nm, up_b, tau + 3);
}

void rb_thrust(int num_thrusters, const rb_thruster_t* thruster, const double* u_N, double tau[6]) {
    memset(tau, 0, 6 * sizeof *tau);
    for (int t = 0; t < num_thrusters; t++) {
        double moment[3];
        rb_cross(thruster[t].r_m, thruster[t].n, moment);
        for (int i = 0; i < 3; i++) {
            tau[i] += u_N[t] * thruster[t].n[i];
            tau[3 + i] += u_N[t] * moment[i];
        }
    }
}

void rb_acceleration(const rb_craft_t* craft, const double nu[6], const double tau[6], double nu_rate[6]) {
    double momentum[6], momentum_rate[6], turning[3], carried[3], spinning[3];
    rb_momentum(craft, nu, momentum);
    rb_drag(craft, nu, momentum_rate);
    rb_cross(nu + 3, momentum, turning);
    rb_cross(nu + 3, momentum + 3, spinning);
    rb_cross(nu, momentum, carried);
    for (int i = 0; i < 3; i++) {
        momentum_rate[i] += tau[i] - turning[i];
        momentum_rate[3 + i] += tau[3 + i] - spinning[i] - carried[i];
    }
    rb_velocity(craft, momentum_rate, nu_rate);
}

/// Time derivative of a state whose nu is through the water, in a state's own shape.
static rb_state_t rate_of(const rb_craft_t* craft, const rb_state_t* state, const double tau[6],
                          const double current_n_m_s[3]) {
    const double spin[4] = {0, state->nu[3] / 2, state->nu[4] / 2, state->nu[5] / 2};
    double wrench[6];
    rb_state_t rate;
    rb_weight(craft, state->eta.q, wrench);
    for (int i = 0; i < 6; i++) {
        wrench[i] += tau[i];
    }
    rb_rotate(state->eta.q, state->nu, rate.eta.p_m);
    for (int i = 0; i < 3; i++) {
        rate.eta.p_m[i] += current_n_m_s[i];
    }
    quaternion_product(state->eta.q, spin, rate.eta.q);
    rb_acceleration(craft, state->nu, wrench, rate.nu);
    return rate;
}

static void add_scaled(rb_state_t* state, double dt_s, const rb_state_t* rate) {
    for (int i = 0; i < 3; i++) {
        state->eta.p_m[i] += dt_s * rate->eta.p_m[i];
    }
    for (int i = 0; i < 4; i++) {
        state->eta.q[i] += dt_s * rate->eta.q[i];
    }
    for (int i = 0; i < 6; i++) {
        state->nu[i] += dt_s * rate->nu[i];
    }
    // Off the unit sphere R(q) would scale velocities. Projecting every trial amounts to a right-hand side that takes
    // q/|q|, so the order stays.
    normalise(state->eta.q);
}

/// Takes state->nu from over ground to through the water (sign -1), or back (sign 1).
static void add_current(rb_state_t* state, double sign, const double current_n_m_s[3]) {
    double current_b[3];
    rb_rotate_back(state->eta.q, current_n_m_s, current_b);
    for (int i = 0; i < 3; i++) {
        state->nu[i] += sign * current_b[i];
    }
}

void rb_step_in_current(const rb_craft_t* craft, rb_state_t* state, const double tau[3][6],
                        const double current_n_m_s[3], double dt_s) {
    add_current(state, -1, current_n_m_s);
    const rb_state_t k1 = rate_of(craft, state, tau[0], current_n_m_s);
    rb_state_t trial = *state;
    add_scaled(&trial, dt_s / 2, &k1);
    const rb_state_t k2 = rate_of(craft, &trial, tau[1], current_n_m_s);
    trial = *state;
    add_scaled(&trial, dt_s / 2, &k2);
    const rb_state_t k3 = rate_of(craft, &trial, tau[1], current_n_m_s);
    trial = *state;
    add_scaled(&trial, dt_s, &k3);
    const rb_state_t k4 = rate_of(craft, &trial, tau[2], current_n_m_s);

    rb_state_t mean = k1;
    for (int i = 0; i < 3; i++) {
        mean.eta.p_m[i] = (k1.eta.p_m[i] + 2 * k2.eta.p_m[i] + 2 * k3.eta.p_m[i] + k4.eta.p_m[i]) / 6;
    }
    for (int i = 0; i < 4; i++) {
        mean.eta.q[i] = (k1.eta.q[i] + 2 * k2.eta.q[i] + 2 * k3.eta.q[i] + k4.eta.q[i]) / 6;
    }
    for (int i = 0; i < 6; i++) {
        mean.nu[i] = (k1.nu[i] + 2 * k2.nu[i] + 2 * k3.nu[i] + k4.nu[i]) / 6;
    }
    add_scaled(state, dt_s, &mean);
    add_current(state, 1, current_n_m_s);
}

void rb_step(const rb_craft_t* craft, rb_state_t* state, const double tau_start[6], const double tau_end[6],
             double dt_s) {
    static const double still[3];
    double tau[3][6];
    for (int i = 0; i < 6; i++) {
        tau[0][i] = tau_start[i];
        tau[1][i] = (tau_start[i] + tau_end[i]) / 2;
        tau[2][i] = tau_end[i];
    }
    rb_step_in_current(craft, state, (const double(*)[6])tau, still, dt_s);
}
