#include "vehicles.h"

#include <math.h>

#include "sample.h"

const char* const vehicle_name[NUM_VEHICLES] = {"ease",          "paper",        "heavy",      "canted",
                                                "like BlueROV2", "like RexROV2", "free flyer", "slow to turn"};

static vec3_t vec3_of(double x, double y, double z) {
    return vec3(real_from_double(x), real_from_double(y), real_from_double(z));
}

static void set_drag(ssv_body_t* body, double lin, double quad, double lin_ang, double quad_ang) {
    body->drag_lin_kg_s = real_from_double(lin);
    body->drag_quad_kg_m = real_from_double(quad);
    body->drag_lin_ang_Nm_s = real_from_double(lin_ang);
    body->drag_quad_ang_Nm_s2 = real_from_double(quad_ang);
}

static void set_mass(ssv_body_t* body, double mass_kg, vec3_t inertia_kg_m2, vec3_t added_mass_kg) {
    body->mass_kg = real_from_double(mass_kg);
    body->inertia_kg_m2 = inertia_kg_m2;
    body->added_mass_kg = added_mass_kg;
}

static void set_thrusters(ssv_vehicle_t* vehicle, double p_m[SSV_NUM_THRUSTERS][3], double n[SSV_NUM_THRUSTERS][3]) {
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        vehicle->thruster[i].p_ST_m = vec3_of(p_m[i][0], p_m[i][1], p_m[i][2]);
        vehicle->thruster[i].n_T_S = vec3_unit(vec3_of(n[i][0], n[i][1], n[i][2]));
    }
}

static void set_canted(ssv_vehicle_t* vehicle) {
    double p_m[SSV_NUM_THRUSTERS][3], n[SSV_NUM_THRUSTERS][3];
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) {
        const double angle = i * 1.0471975511965976, side = i % 2 == 0 ? 1 : -1, r = 0.22695; // 0.2 above or below
        p_m[i][0] = r * cos(angle);
        p_m[i][1] = r * sin(angle);
        p_m[i][2] = 0.2 * side;
        n[i][0] = -0.7648 * side * sin(angle);
        n[i][1] = 0.7648 * side * cos(angle);
        n[i][2] = 0.6442;
    }
    set_thrusters(vehicle, p_m, n);
}

static void set_like_bluerov(ssv_vehicle_t* vehicle) {
    double p_m[][3] = {{0.14, -0.092, 0},      {0.14, 0.092, 0},      {-0.15, -0.092, 0},
                       {0.118, -0.215, 0.064}, {0.118, 0.215, 0.064}, {-0.118, -0.215, 0.064}};
    double n[][3] = {{1, 1, 0}, {1, -1, 0}, {1, -1, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    set_mass(&vehicle->body, 13, vec3_of(0.26, 0.23, 0.37), vec3_of(5.5, 12.7, 14.57));
    set_drag(&vehicle->body, 0, 58.42, 0, 4);
    vehicle->radius_m = real_from_double(0.25);
    vehicle->force_max_N = real_from_double(40);
    set_thrusters(vehicle, p_m, n);
}

static void set_like_rexrov(ssv_vehicle_t* vehicle) {
    double p_m[][3] = {{0.4878, 0, 0.2373},      {-0.9139, 0, 0.2449},      {0.8654, -0.6428, 0.2662},
                       {0.8654, 0.6428, 0.2662}, {-0.3228, 0.6923, 0.2404}, {-0.3228, -0.6923, 0.2404}};
    double n[][3] = {{0, 1, 0},           {0.2588, 0, 0.9659}, {0, 0.3827, 0.9239}, {0, 0.3827, -0.9239},
                     {0.9063, 0.4226, 0}, {0.9063, -0.4226, 0}};
    set_mass(&vehicle->body, 1862.87, vec3_of(525.39, 794.2, 691.23), vec3_of(779.79, 1222, 3659.9));
    set_drag(&vehicle->body, 74.82, 748.22, 268.8, 672);
    vehicle->radius_m = real_from_double(1.3);
    vehicle->force_max_N = real_from_double(500);
    set_thrusters(vehicle, p_m, n);
}

static void set_free_flyer(ssv_vehicle_t* vehicle, ssv_beam_t* beam) {
    set_mass(&vehicle->body, 12, vec3_of(0.2, 0.25, 0.3), vec3_of(0, 0, 0));
    set_drag(&vehicle->body, 0, 0, 0, 0);
    vehicle->force_max_N = real_from_double(1);
    set_mass(&beam->body, 3, vec3_of(2.3, 2.3, 0.01), vec3_of(0, 0, 0));
    beam->drag_strip_kg_m2 = REAL(0);
}

void set_vehicle(ssv_scenario_t* scenario, vehicle_kind_t kind) {
    ssv_vehicle_t* vehicle = &scenario->vehicle;
    *vehicle = model_vehicle();
    scenario->beam = model_beam(kind != VEHICLE_OF_PAPER);
    switch (kind) {
        case VEHICLE_OF_EASE:
        case VEHICLE_OF_PAPER:
        case NUM_VEHICLES: break;
        case VEHICLE_HEAVY:
            set_mass(&vehicle->body, 120, vehicle->body.inertia_kg_m2, vec3_of(60, 60, 60));
            set_drag(&vehicle->body, 0, 90, 0, 2.2);
            vehicle->force_max_N = real_from_double(25);
            break;
        case VEHICLE_CANTED: set_canted(vehicle); break;
        case VEHICLE_LIKE_BLUEROV: set_like_bluerov(vehicle); break;
        case VEHICLE_LIKE_REXROV: set_like_rexrov(vehicle); break;
        case VEHICLE_FREE_FLYER: set_free_flyer(vehicle, &scenario->beam); break;
        case VEHICLE_SLOW_TO_TURN: set_drag(&vehicle->body, 50, 20, 40, 60); break;
    }
    scenario->standoff_m = vehicle->radius_m + scenario->beam.radius_m;
}
