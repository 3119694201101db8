/// Rigid bodies in water, in six degrees of freedom: the physics that judges plans and flies vehicles, written from
/// Newton, Kirchhoff and strip theory and from nothing of the planner. Symbols of Fossen, Handbook of Marine Craft
/// Hydrodynamics and Motion Control.
///
/// Frames: {n} is inertial (I elsewhere), its z points up; {b} is fixed in the craft, origin at the centre of mass of
/// its first body, the vehicle (S elsewhere). eta = (p, q) is the pose of {b} in {n}, nu = [v; w] the velocity of {b}'s
/// origin and the turning rate, in axes of {b}; tau = [force; moment about {b}'s origin], in axes of {b}. SI units.
/// Quaternions are scalar first and take coordinates in {b} to coordinates in {n}.
///
///     M nu' + C(nu) nu + D(nu) nu + g(q) = tau,    as Kirchhoff wrote it: with momentum [P; H] = M nu,
///     P' + w x P = F,    H' + w x H + v x P = M
///
/// In a current nu is the velocity through the water, nu_r. That is exact while the current is uniform and constant, as
/// every step here takes it to be; the force of water that speeds up from one step to the next is left out.
///
/// Nothing here allocates or fails; inputs are checked by whoever reads them (masses and inertias positive, drag and
/// added mass not negative, quaternions unit).
#ifndef SIM_RIGID_BODY_H
#define SIM_RIGID_BODY_H

/// One body, about its centre of mass, in its own principal axes.
typedef struct {
    double mass_kg;
    double inertia_kg_m2[3];
    double added_mass_kg[3];        ///< water moved along with motion along x, y, z
    double added_inertia_kg_m2[3];  ///< and with turning about them
    double net_weight_N;            ///< weight less buoyancy: positive sinks
    double centre_of_buoyancy_m[3]; ///< above the centre of mass it rights the body
    double drag_lin_kg_s;           ///< force -(drag_lin + drag_quad |v|) v at the centre of mass
    double drag_quad_kg_m;
    double drag_lin_ang_Nm_s; ///< moment -(drag_lin_ang + drag_quad_ang |w|) w
    double drag_quad_ang_Nm_s2;
    double strip_kg_m2; ///< [N/(m/s)2 per m] each metre of a tube along z feels -strip |v| v, v across z
    double length_m;    ///< of that tube, centred
} rb_body_t;

typedef struct {
    double p_m[3];
    double q[4];
} rb_pose_t;

/// What moves as one piece: one body, or two rigidly joined.
typedef struct {
    int num_bodies;
    rb_body_t body[2];
    rb_pose_t X_b[2];         ///< pose of each body in {b}; the first is the identity
    double lift_N;            ///< buoyancy less weight
    double lift_moment_Nm[3]; ///< sum of lever times buoyancy less that of lever times weight, about {b}'s origin
    double M[6][6];           ///< mass matrix about {b}'s origin, added mass included
    double M_chol[6][6];      ///< its lower Cholesky factor
} rb_craft_t;

typedef struct {
    rb_pose_t eta;
    double nu[6];
} rb_state_t;

typedef struct {
    double r_m[3]; ///< position in {b}
    double n[3];   ///< unit direction of positive force in {b}
} rb_thruster_t;

void rb_craft_alone(rb_craft_t* craft, const rb_body_t* body);

/// @param X_b pose of `second` in {b}, the frame of `first`.
void rb_craft_joined(rb_craft_t* craft, const rb_body_t* first, const rb_body_t* second, const rb_pose_t* X_b);

/// The craft, one body so far, takes hold of a second that rests over ground at the pose X_n: the plastic impact that
/// leaves both with the momentum of the first. In a current, too: its share drops out of the balance.
/// @return pose of the second body in {b}, from then on fixed.
rb_pose_t rb_take_hold(rb_craft_t* craft, rb_state_t* state, const rb_body_t* second, const rb_pose_t* X_n);

/// Momentum [P; H] = M nu, H about {b}'s origin.
void rb_momentum(const rb_craft_t* craft, const double nu[6], double momentum[6]);

/// The inverse: nu = M^-1 [P; H].
void rb_velocity(const rb_craft_t* craft, const double momentum[6], double nu[6]);

/// Wrench of the water on the craft that moves through it (without added mass, which is in M): -D(nu) nu.
void rb_drag(const rb_craft_t* craft, const double nu[6], double tau[6]);

/// Wrench of weight and buoyancy at the attitude q: -g(q).
void rb_weight(const rb_craft_t* craft, const double q[4], double tau[6]);

/// Wrench of thrusters that push with u_N along their directions.
void rb_thrust(int num_thrusters, const rb_thruster_t* thruster, const double* u_N, double tau[6]);

/// nu' of the craft under the wrench tau and the drag of still water.
void rb_acceleration(const rb_craft_t* craft, const double nu[6], const double tau[6], double nu_rate[6]);

/// One Runge-Kutta step of fourth order in a constant current.
/// @param tau wrench at the start, the middle and the end of the step; drag, weight and buoyancy come on top.
/// @param current_n_m_s velocity of the water in {n}; state->nu is over ground before and after.
void rb_step_in_current(const rb_craft_t* craft, rb_state_t* state, const double tau[3][6],
                        const double current_n_m_s[3], double dt_s);

/// The same in still water, under a wrench that runs on a straight line from tau_start to tau_end.
void rb_step(const rb_craft_t* craft, rb_state_t* state, const double tau_start[6], const double tau_end[6],
             double dt_s);

/// c = a x b; c may be a or b.
void rb_cross(const double a[3], const double b[3], double c[3]);

/// v_n = R(q) v_b and v_b = R(q)^T v_n; in and out may be the same.
void rb_rotate(const double q[4], const double v_b[3], double v_n[3]);
void rb_rotate_back(const double q[4], const double v_n[3], double v_b[3]);

/// X_ac = X_ab X_bc.
rb_pose_t rb_compose(const rb_pose_t* X_ab, const rb_pose_t* X_bc);

/// X_bc = X_ab^-1 X_ac: pose of c as seen from b.
rb_pose_t rb_relative(const rb_pose_t* X_ab, const rb_pose_t* X_ac);

#endif
