#include "sample.h"

#include <math.h>

static uint64_t random_state;

void sample_seed(uint64_t seed) { random_state = seed; }

// splitmix64
static uint64_t next(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double sample_between(double low, double high) { return low + (high - low) * ((double)(next() >> 11) * 0x1p-53); }

int sample_below(int n) { return (int)(next() % (uint64_t)n); }

vec3_t sample_vector(double size) {
    const double x = sample_between(-size, size), y = sample_between(-size, size), z = sample_between(-size, size);
    const vec3_t v = {real_from_double(x), real_from_double(y), real_from_double(z)};
    return v;
}

vec3_t sample_direction(void) {
    for (;;) {
        const double x = sample_between(-1, 1), y = sample_between(-1, 1), z = sample_between(-1, 1);
        const double n = sqrt(x * x + y * y + z * z);
        if (n > 0.1 && n <= 1) {
            const vec3_t v = {real_from_double(x / n), real_from_double(y / n), real_from_double(z / n)};
            return v;
        }
    }
}

quat_t sample_attitude(void) {
    for (;;) {
        const double w = sample_between(-1, 1), x = sample_between(-1, 1), y = sample_between(-1, 1),
                     z = sample_between(-1, 1);
        const double n = sqrt(w * w + x * x + y * y + z * z);
        if (n > 0.1 && n <= 1) {
            const quat_t q = {real_from_double(w / n), real_from_double(x / n), real_from_double(y / n),
                              real_from_double(z / n)};
            return q;
        }
    }
}

static void fill_thrusters(ssv_vehicle_t* vehicle, double jitter_m) {
    static const double position[SSV_NUM_THRUSTERS][3] = {{0, 0, 1},  {0, 0, -1}, {1, 0, 0},
                                                          {-1, 0, 0}, {0, 1, 0},  {0, -1, 0}};
    static const double direction[SSV_NUM_THRUSTERS][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                                           {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const vec3_t p = {real_from_double(0.3025 * position[i][0]), real_from_double(0.3025 * position[i][1]),
                          real_from_double(0.3025 * position[i][2])};
        const vec3_t n = {real_from_double(direction[i][0]), real_from_double(direction[i][1]),
                          real_from_double(direction[i][2])};
        vehicle->thruster[i].p_ST_m = vec3_add(p, sample_vector(jitter_m));
        vehicle->thruster[i].n_T_S = n;
    }
}

static vec3_t vec3_of(double x, double y, double z) {
    return vec3(real_from_double(x), real_from_double(y), real_from_double(z));
}

ssv_vehicle_t model_vehicle(void) {
    ssv_vehicle_t vehicle;
    memset(&vehicle, 0, sizeof vehicle);
    vehicle.body.mass_kg = real_from_double(76.2);
    vehicle.body.inertia_kg_m2 = vec3_of(2.7, 2.7, 2.7);
    vehicle.body.drag_lin_kg_s = real_from_double(413.685);
    vehicle.body.drag_quad_ang_Nm_s2 = real_from_double(2.2);
    vehicle.radius_m = real_from_double(0.3025);
    vehicle.force_max_N = real_from_double(6);
    fill_thrusters(&vehicle, 0);
    return vehicle;
}

ssv_beam_t model_beam(bool ease) {
    const double mass = 11.3636, outer = 0.0606, inner = outer - 0.0063, length = 3.048;
    const double transverse = mass * (3 * (outer * outer + inner * inner) + length * length) / 12;
    const double axial = mass * (outer * outer + inner * inner) / 2;
    ssv_beam_t beam;
    memset(&beam, 0, sizeof beam);
    beam.body.mass_kg = real_from_double(mass);
    beam.body.inertia_kg_m2 = ease ? vec3_of(transverse, transverse, axial) : vec3_of(0.0124, 0.0124, 0.0083);
    beam.radius_m = real_from_double(outer);
    beam.length_m = real_from_double(length);
    beam.drag_strip_kg_m2 = real_from_double(ease ? 66.66 : 0);
    return beam;
}

ssv_scenario_t scenario_case_study(bool ease) {
    ssv_scenario_t s = ssv_scenario_default();
    s.vehicle = model_vehicle();
    s.beam = model_beam(ease);
    s.X_IS.q = (quat_t){REAL(0), REAL(0), REAL(0), REAL(1)};
    s.X_IB.p = vec3_of(5, 0, 0);
    s.X_IB.q = (quat_t){real_from_double(sqrt(0.5)), REAL(0), real_from_double(sqrt(0.5)), REAL(0)};
    s.p_IP_m = vec3_of(6.524, 5, 0);
    s.axis_I = vec3_of(0, -1, 0);
    s.contact = 1;
    s.method = SSV_METHOD_PAPER;
    s.standoff_m = real_from_double(0.3025);
    s.want_candidates = true;
    return s;
}

static void vary_bodies(ssv_scenario_t* s) {
    const double vary = sample_between(0.8, 1.25);
    ssv_body_t* vehicle = &s->vehicle.body;
    vehicle->mass_kg = real_from_double(76.2 * vary);
    vehicle->inertia_kg_m2 = vec3_of(2.7, 2.7 * vary, 2.7);
    vehicle->added_mass_kg = vec3_add(sample_vector(30), vec3_of(30, 30, 30));
    vehicle->drag_lin_kg_s = real_from_double(413.685 * vary);
    vehicle->drag_quad_kg_m = real_from_double(sample_between(0, 300));
    vehicle->drag_lin_ang_Nm_s = real_from_double(sample_between(0, 1));
    fill_thrusters(&s->vehicle, 0.03);
    s->beam.body.mass_kg = real_from_double(11.3636 * vary);
    s->beam.body.added_mass_kg = vec3_add(sample_vector(5), vec3_of(5, 5, 5));
}

ssv_scenario_t sample_scenario(void) {
    static const double weights[][2] = {{1, 0}, {0, 1}, {1, 1}, {1, 0.1}, {0.01, 1}};
    ssv_scenario_t s = scenario_case_study(sample_below(2) == 1);
    if (sample_below(2) == 1) vary_bodies(&s);
    s.X_IS.p = sample_vector(8);
    s.X_IS.q = sample_attitude();
    s.X_IB.p = sample_vector(8);
    s.X_IB.q = sample_attitude();
    s.p_IP_m = sample_vector(8);
    s.axis_I = sample_direction();
    s.contact = sample_below(3);
    s.standoff_m = real_from_double(sample_below(2) == 1 ? 0.3025 : 0.3631);
    const double* const weight = weights[sample_below(5)];
    s.weight_time_per_s = real_from_double(weight[0]);
    s.weight_impulse_per_Ns = real_from_double(weight[1]);
    s.num_attach_heights = sample_below(4);
    for (int i = 0; i < s.num_attach_heights; i++) {
        s.attach_heights_m[i] = real_from_double(sample_between(-1.5, 1.5));
    }
    s.ring_angle_given = sample_below(2) == 1;
    s.ring_angle_rad = real_from_double(s.ring_angle_given ? sample_between(-6, 6) : 0);
    return s;
}

ssv_scenario_t scenario_moved(const ssv_scenario_t* scenario, pose_t X) {
    ssv_scenario_t s = *scenario;
    s.X_IS = pose_mul(X, s.X_IS);
    s.X_IB = pose_mul(X, s.X_IB);
    s.p_IP_m = vec3_add(X.p, quat_apply(X.q, s.p_IP_m));
    s.axis_I = quat_apply(X.q, s.axis_I);
    return s;
}

static vec3_t reflect(vec3_t v, mirror_axis_t axis) {
    return vec3(axis == MIRROR_X ? -v.x : v.x, axis == MIRROR_Y ? -v.y : v.y, axis == MIRROR_Z ? -v.z : v.z);
}

// With M the reflection of I in y and D that of the body in its axis, M R D = (M R M)(M D): in the first factor the
// axis of rotation is reflected and the sense reversed, the second is a half turn or nothing.
static pose_t reflect_pose(pose_t X, mirror_axis_t body_axis) {
    const quat_t q = {X.q.w, -X.q.x, X.q.y, -X.q.z};
    const quat_t half_turn = {REAL(body_axis == MIRROR_Y), REAL(body_axis == MIRROR_Z), REAL(0),
                              REAL(body_axis == MIRROR_X)};
    return (pose_t){reflect(X.p, MIRROR_Y), quat_mul(q, half_turn)};
}

ssv_scenario_t scenario_mirrored(const ssv_scenario_t* scenario, mirror_axis_t vehicle_axis, mirror_axis_t beam_axis) {
    ssv_scenario_t s = *scenario;
    s.X_IS = reflect_pose(s.X_IS, vehicle_axis);
    s.X_IB = reflect_pose(s.X_IB, beam_axis);
    s.p_IP_m = reflect(s.p_IP_m, MIRROR_Y);
    s.axis_I = reflect(s.axis_I, MIRROR_Y);
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        s.vehicle.thruster[i].p_ST_m = reflect(s.vehicle.thruster[i].p_ST_m, vehicle_axis);
        s.vehicle.thruster[i].n_T_S = reflect(s.vehicle.thruster[i].n_T_S, vehicle_axis);
    }
    const vec3_t side = reflect(vec3(real_cos(s.ring_angle_rad), real_sin(s.ring_angle_rad), REAL(0)), beam_axis);
    s.ring_angle_rad = s.ring_angle_given ? real_atan2(side.y, side.x) : REAL(0);
    if (beam_axis == MIRROR_Z) {
        s.contact = s.contact == 0 ? 0 : 3 - s.contact;
        for (int i = 0; i < s.num_attach_heights; i++) s.attach_heights_m[i] = -s.attach_heights_m[i];
    }
    return s;
}
