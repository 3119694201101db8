#include "clearance.h"

#include <math.h>
#include <string.h>

/// Before mating the last stretch reaches this much farther than it takes to be clear by the margin [m].
#define STRETCH_ROOM_M 0.01

static const sim_nearest_t nothing = {INFINITY, 0, false, SIM_NO_OBSTACLE};

static double apart(const double a[3], const double b[3]) {
    return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

static sim_capsule_t ball(const double p_n_m[3], double radius_m) {
    sim_capsule_t sphere = {.radius_m = radius_m};
    memcpy(sphere.a_m, p_n_m, sizeof sphere.a_m);
    memcpy(sphere.b_m, p_n_m, sizeof sphere.b_m);
    return sphere;
}

static sim_tube_t beam_at(const sim_surroundings_t* around, const rb_pose_t* X_nB) {
    const double half_m = around->beam_length_m / 2;
    const rb_pose_t low_B = {{0, 0, -half_m}, {1, 0, 0, 0}}, high_B = {{0, 0, half_m}, {1, 0, 0, 0}};
    const rb_pose_t low = rb_compose(X_nB, &low_B), high = rb_compose(X_nB, &high_B);
    sim_tube_t beam = {.radius_m = around->beam_radius_m};
    memcpy(beam.a_m, low.p_m, sizeof beam.a_m);
    memcpy(beam.b_m, high.p_m, sizeof beam.b_m);
    return beam;
}

static sim_tube_t beam_when_docked(const sim_surroundings_t* around) {
    sim_tube_t beam = {.radius_m = around->beam_radius_m};
    for (int i = 0; i < 3; i++) {
        beam.a_m[i] = around->port.p_nP_m[i];
        beam.b_m[i] = beam.a_m[i] + around->beam_length_m * around->port.axis_n[i];
    }
    return beam;
}

static bool is_chosen(const sim_surroundings_t* around, int thing) {
    return thing == SIM_TANK_WALL ? around->tank.kind != SIM_NO_TANK
                                  : thing < around->num_obstacles && (around->chosen >> thing & 1) != 0;
}

static double from_ball_m(const sim_surroundings_t* around, const sim_capsule_t* sphere, int thing) {
    if (thing == SIM_TANK_WALL) {
        return sim_room_m(sphere, &around->tank);
    }
    const sim_obstacle_t* obstacle = &around->obstacle[thing];
    return obstacle->is_wall ? sim_height_m(sphere, &obstacle->wall) : sim_distance_m(sphere, &obstacle->capsule);
}

/// Exact where it is below enough_m, which is what is wanted; else some distance that is not below.
static double from_tube_m(const sim_surroundings_t* around, const sim_tube_t* tube, int thing, double enough_m) {
    if (thing == SIM_TANK_WALL) {
        return sim_tube_room_m(tube, &around->tank);
    }
    const sim_obstacle_t* obstacle = &around->obstacle[thing];
    if (obstacle->is_wall) {
        return sim_tube_height_m(tube, &obstacle->wall);
    }
    // The capsule around the tube is nearer, and quickly told.
    sim_capsule_t capsule = {.radius_m = tube->radius_m};
    memcpy(capsule.a_m, tube->a_m, sizeof capsule.a_m);
    memcpy(capsule.b_m, tube->b_m, sizeof capsule.b_m);
    const double at_least_m = sim_distance_m(&capsule, &obstacle->capsule);
    return at_least_m >= enough_m ? at_least_m : sim_tube_distance_m(tube, &obstacle->capsule);
}

static double stretch_m(double approach_m) { return approach_m > 0 ? approach_m : SIM_STRETCH_M; }

void sim_watch_init(sim_watch_t* watch, const sim_surroundings_t* around) {
    memset(watch, 0, sizeof *watch);
    watch->around = *around;
    watch->nearest = watch->held_back = nothing;
    if (!around->counts) {
        return;
    }
    const sim_mate_place_t* place = &around->place;
    const double phi = place->ring_angle_rad,
                 mated_m = place->standoff_m - around->hull_radius_m - around->beam_radius_m;
    const rb_pose_t X_BS = {{place->standoff_m * cos(phi), place->standoff_m * sin(phi), place->attach_height_m},
                            {1, 0, 0, 0}};
    const rb_pose_t X_nS = rb_compose(&around->X_nB, &X_BS);
    const double at_least_m = around->margin_m - mated_m + STRETCH_ROOM_M;
    memcpy(watch->mate_n_m, X_nS.p_m, sizeof watch->mate_n_m);
    watch->mating_m = fmax(stretch_m(around->approach_mate_m), at_least_m);
    watch->leaving_m = fmax(SIM_STRETCH_M, at_least_m);
    watch->docking_m = stretch_m(around->approach_dock_m);
    watch->is_leaving = (around->left & around->chosen) != 0;

    const sim_capsule_t hull = ball(around->X_nb.p_m, around->hull_radius_m);
    const sim_capsule_t contact = ball(around->port.p_nP_m, around->beam_radius_m + around->margin_m);
    const sim_tube_t docked = beam_when_docked(around);
    for (int thing = 0; thing < SIM_NUM_THINGS; thing++) {
        watch->depth_m[0][thing] = watch->depth_m[1][thing] = INFINITY;
        if (!is_chosen(around, thing)) {
            continue;
        }
        if (thing < SIM_OBSTACLES && (around->left >> thing & 1) != 0) {
            watch->depth_m[0][thing] = from_ball_m(around, &hull, thing);
        }
        if (from_ball_m(around, &contact, thing) < 0) {
            watch->depth_m[1][thing] = from_tube_m(around, &docked, thing, INFINITY);
        }
    }
    watch->depth_m[0][SIM_ITS_BEAM] = mated_m;
}

static void take(sim_nearest_t* nearest, double distance_m, double t_s, bool is_beam, int thing) {
    if (distance_m < nearest->least_m) {
        *nearest = (sim_nearest_t){distance_m, t_s, is_beam, thing};
    }
}

/// Takes note of one distance; a contact that is allowed here is held back, or forgotten if it is left behind.
static void note(sim_watch_t* watch, double distance_m, double t_s, bool is_beam, int thing, bool arrives) {
    const bool is_last = is_beam || thing == SIM_ITS_BEAM;
    const bool is_near = is_last ? arrives : watch->is_leaving;
    const bool is_allowed = is_near && distance_m >= watch->depth_m[is_beam ? 1 : 0][thing] - SIM_DEEPER_M;
    if (!is_allowed) {
        take(&watch->nearest, distance_m, t_s, is_beam, thing);
    } else if (is_last) {
        take(&watch->held_back, distance_m, t_s, is_beam, thing);
    }
}

/// Whether the flight is on a last stretch, near where it mates or docks.
static bool is_arriving(const sim_watch_t* watch, const rb_pose_t* X_nb, const sim_tube_t* beam, bool is_carried) {
    const sim_port_t* port = &watch->around.port;
    return is_carried ? apart(port->contact == 1 ? beam->a_m : beam->b_m, port->p_nP_m) <= watch->docking_m
                      : apart(X_nb->p_m, watch->mate_n_m) <= watch->mating_m;
}

void sim_watch_look(sim_watch_t* watch, double t_s, const rb_pose_t* X_nb, const rb_pose_t* X_nB, bool is_carried) {
    const sim_surroundings_t* around = &watch->around;
    if (!around->counts) {
        return;
    }
    const sim_tube_t beam = beam_at(around, X_nB);
    const sim_capsule_t hull = ball(X_nb->p_m, around->hull_radius_m);
    const bool arrives = is_arriving(watch, X_nb, &beam, is_carried), mated_now = is_carried && !watch->was_carried;
    watch->was_carried = is_carried;
    watch->is_leaving = watch->is_leaving && !is_carried && apart(X_nb->p_m, around->X_nb.p_m) <= watch->leaving_m;
    if (!arrives && !mated_now && watch->held_back.least_m < watch->nearest.least_m) {
        watch->nearest = watch->held_back;
    }
    if (!arrives || mated_now) {
        watch->held_back = nothing;
    }
    for (int thing = 0; thing < SIM_NUM_THINGS; thing++) {
        if (!is_chosen(around, thing)) {
            continue;
        }
        note(watch, from_ball_m(around, &hull, thing), t_s, false, thing, arrives);
        if (is_carried) {
            note(watch, from_tube_m(around, &beam, thing, watch->nearest.least_m), t_s, true, thing, arrives);
        }
    }
    if (!is_carried) {
        note(watch, sim_tube_distance_m(&beam, &hull), t_s, false, SIM_ITS_BEAM, arrives);
    }
}
