/// Random tasks at a hub with things around it, for tests of clearance; and how far bodies are apart, told by formulas
/// and in a way that the planner does not use.
#ifndef TESTS_SCENES_H
#define TESTS_SCENES_H

#include "ssv/planner.h"

/// What stands around: the hub; the beams on its two other ports besides; five beams that lie about besides; or, with
/// the two beams, the walls of a tank close around what start and goal need.
typedef enum { SCENE_BARE, SCENE_BUILT, SCENE_STREWN, SCENE_WALLS, SCENE_KINDS } scene_kind_t;

/// A random task of method optimal with its scene, which goes into *scene; margin 3 cm. The start is clear of
/// everything by 10 cm. `sample_seed` starts the sequence.
ssv_scenario_t scene_task(scene_kind_t kind, ssv_scene_t* scene);

/// How near the plan comes to anything of the scenario's scene, over so many poses a leg, less the two contacts that
/// are allowed; in double, whatever the scalar.
typedef struct {
    double clearance_m;
    int leg, obstacle;
    double s;
    bool is_beam;
} scene_nearest_t;
scene_nearest_t scene_nearest(const ssv_scenario_t* scenario, const ssv_plan_t* plan, int poses);

/// How far the body is from one obstacle of the scenario's, s along a leg.
double scene_distance(const ssv_scenario_t* scenario, const ssv_plan_t* plan, int leg, double s, bool is_beam,
                      int obstacle);

/// How far two capsules, or a capsule and a wall, are apart.
double scene_apart(const ssv_obstacle_t* capsule, const ssv_obstacle_t* obstacle);

#endif
