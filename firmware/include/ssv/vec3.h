/// Three-dimensional kernels: vectors, unit quaternions, poses. All by value, none fails, none allocates.
///
/// Notation (Drake's monogram): p_AB is the position of B's origin from A's, in axes of A unless a last letter says
/// otherwise; R_AB (here as the unit quaternion q_AB) takes coordinates in B to coordinates in A; X_AB is the pair
/// (p_AB, q_AB). Neighbouring letters cancel: p_AC = p_AB + R_AB p_BC.
#ifndef SSV_VEC3_H
#define SSV_VEC3_H

#include "ssv/real.h"

typedef struct {
    real_t x, y, z;
} vec3_t;

/// Unit quaternion, scalar first.
typedef struct {
    real_t w, x, y, z;
} quat_t;

/// Position [m] and attitude of a frame.
typedef struct {
    vec3_t p;
    quat_t q;
} pose_t;

inline vec3_t vec3(real_t x, real_t y, real_t z) {
    const vec3_t r = {x, y, z};
    return r;
}

inline vec3_t vec3_add(vec3_t a, vec3_t b) { return vec3(a.x + b.x, a.y + b.y, a.z + b.z); }
inline vec3_t vec3_sub(vec3_t a, vec3_t b) { return vec3(a.x - b.x, a.y - b.y, a.z - b.z); }
inline vec3_t vec3_neg(vec3_t a) { return vec3(-a.x, -a.y, -a.z); }

inline vec3_t vec3_scale(real_t s, vec3_t a) { return vec3(real_mul(s, a.x), real_mul(s, a.y), real_mul(s, a.z)); }

/// Product per axis.
inline vec3_t vec3_mul(vec3_t a, vec3_t b) { return vec3(real_mul(a.x, b.x), real_mul(a.y, b.y), real_mul(a.z, b.z)); }

inline real_t vec3_dot(vec3_t a, vec3_t b) { return real_mul(a.x, b.x) + real_mul(a.y, b.y) + real_mul(a.z, b.z); }

inline vec3_t vec3_cross(vec3_t a, vec3_t b) {
    return vec3(real_mul(a.y, b.z) - real_mul(a.z, b.y), real_mul(a.z, b.x) - real_mul(a.x, b.z),
                real_mul(a.x, b.y) - real_mul(a.y, b.x));
}

/// |a|. Where squares of a short one would have no digits, it is scaled first.
inline real_t vec3_norm(vec3_t a) {
    const int n = real_exponent(real_abs(a.x) + real_abs(a.y) + real_abs(a.z));
    if (n >= 0) return real_sqrt(vec3_dot(a, a));
    const vec3_t unit = vec3(real_scale(a.x, -n), real_scale(a.y, -n), real_scale(a.z, -n));
    return real_scale(real_sqrt(vec3_dot(unit, unit)), n);
}

/// a / |a|; the caller knows that |a| is not zero.
inline vec3_t vec3_unit(vec3_t a) {
    const real_t n = vec3_norm(a);
    return vec3(real_div(a.x, n), real_div(a.y, n), real_div(a.z, n));
}

/// A unit vector perpendicular to the unit vector a: from the axis that a leans on least, so well conditioned for every
/// a.
inline vec3_t vec3_perpendicular(vec3_t a) {
    const real_t x = real_abs(a.x), y = real_abs(a.y), z = real_abs(a.z);
    const vec3_t e = x <= y && x <= z ? vec3(REAL(1), REAL(0), REAL(0))
                     : y <= z         ? vec3(REAL(0), REAL(1), REAL(0))
                                      : vec3(REAL(0), REAL(0), REAL(1));
    return vec3_unit(vec3_cross(a, e));
}

inline quat_t quat_identity(void) {
    const quat_t r = {REAL(1), REAL(0), REAL(0), REAL(0)};
    return r;
}

inline quat_t quat_conj(quat_t a) {
    const quat_t r = {a.w, -a.x, -a.y, -a.z};
    return r;
}

inline real_t quat_norm(quat_t a) { return real_sqrt(real_sq(a.w) + real_sq(a.x) + real_sq(a.y) + real_sq(a.z)); }

/// a / |a|; the caller knows that |a| is not zero.
inline quat_t quat_unit(quat_t a) {
    const real_t n = quat_norm(a);
    const quat_t r = {real_div(a.w, n), real_div(a.x, n), real_div(a.y, n), real_div(a.z, n)};
    return r;
}

/// q_AC = q_AB q_BC.
inline quat_t quat_mul(quat_t a, quat_t b) {
    const quat_t r = {real_mul(a.w, b.w) - real_mul(a.x, b.x) - real_mul(a.y, b.y) - real_mul(a.z, b.z),
                      real_mul(a.w, b.x) + real_mul(a.x, b.w) + real_mul(a.y, b.z) - real_mul(a.z, b.y),
                      real_mul(a.w, b.y) - real_mul(a.x, b.z) + real_mul(a.y, b.w) + real_mul(a.z, b.x),
                      real_mul(a.w, b.z) + real_mul(a.x, b.y) - real_mul(a.y, b.x) + real_mul(a.z, b.w)};
    return r;
}

/// v_A = R_AB v_B.
inline vec3_t quat_apply(quat_t q_AB, vec3_t v_B) {
    const vec3_t e = vec3(q_AB.x, q_AB.y, q_AB.z);
    const vec3_t t = vec3_scale(REAL(2), vec3_cross(e, v_B));
    return vec3_add(v_B, vec3_add(vec3_scale(q_AB.w, t), vec3_cross(e, t)));
}

/// Rotation by angle_rad about the unit vector axis.
inline quat_t quat_from_axis_angle(vec3_t axis, real_t angle_rad) {
    const real_t half = real_mul(REAL(0.5), angle_rad);
    const vec3_t e = vec3_scale(real_sin(half), axis);
    const quat_t r = {real_cos(half), e.x, e.y, e.z};
    return r;
}

/// The smallest rotation that takes unit vector from to unit vector to; about any axis across if they are opposite.
inline quat_t quat_between(vec3_t from, vec3_t to) {
    const real_t cosine = vec3_dot(from, to);
    const vec3_t e = vec3_cross(from, to);
    quat_t r = {REAL(1) + cosine, e.x, e.y, e.z};
    if (cosine <= REAL(-0.5)) {
        // Close to opposite, 1 + cosine cancels, and the axis must be made square to from.
        const real_t sine = vec3_norm(e);
        const vec3_t square = vec3_sub(e, vec3_scale(vec3_dot(e, from), from));
        const vec3_t axis = sine > real_max(REAL(1e-8), 16 * REAL_NOISE) ? vec3_unit(square) : vec3_perpendicular(from);
        const vec3_t f = vec3_scale(REAL(1) - cosine, axis);
        r.w = sine;
        r.x = f.x;
        r.y = f.y;
        r.z = f.z;
    }
    return quat_unit(r);
}

/// X_AC = X_AB X_BC.
inline pose_t pose_mul(pose_t X_AB, pose_t X_BC) {
    const pose_t r = {vec3_add(X_AB.p, quat_apply(X_AB.q, X_BC.p)), quat_unit(quat_mul(X_AB.q, X_BC.q))};
    return r;
}

/// X_BA from X_AB.
inline pose_t pose_inv(pose_t X_AB) {
    const quat_t q_BA = quat_conj(X_AB.q);
    const pose_t r = {vec3_neg(quat_apply(q_BA, X_AB.p)), q_BA};
    return r;
}

/// X_BC from X_AB and X_AC. Positions are subtracted first: far from A, they agree in most of their digits.
inline pose_t pose_between(pose_t X_AB, pose_t X_AC) {
    const quat_t q_BA = quat_conj(X_AB.q);
    const pose_t r = {quat_apply(q_BA, vec3_sub(X_AC.p, X_AB.p)), quat_unit(quat_mul(q_BA, X_AC.q))};
    return r;
}

#endif
