/// Reads a structure file: what is to be assembled of which beams, and by which rules; host/FORMATS.md is for those who
/// write them. Plain doubles, for programs of every scalar.
///
/// What is read has been checked: names are known, every port has one slot at most, precedence has no cycle, the beam
/// of each slot reaches from port to port, and no two beams are in one place.
#ifndef SSV_SCHEDULER_STRUCTURE_H
#define SSV_SCHEDULER_STRUCTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lcm_ssv_scenario_t.h"
#include "set.h"

#define STRUCTURE_NAME_SIZE 32
#define STRUCTURE_MAX_HUBS 64
#define STRUCTURE_MAX_PORTS 12
#define STRUCTURE_MAX_BEAMS 120
#define STRUCTURE_MAX_SLOTS 96
/// Hubs and slots together, where they are in the way: so many has a scene.
#define STRUCTURE_MAX_OBSTACLES 64

/// Where a beam may be docked.
typedef struct {
    double p_IP_m[3];
    double axis_I[3]; ///< out of the hub
} structure_port_t;

typedef struct {
    char name[STRUCTURE_NAME_SIZE];
    double p_IH_m[3];
    double radius_m; ///< of the sphere that it is as an obstacle
    int num_ports;
    structure_port_t port[STRUCTURE_MAX_PORTS];
} structure_hub_t;

typedef struct {
    char name[STRUCTURE_NAME_SIZE];
    double p_IB_m[3], q_IB[4];
} structure_beam_t;

/// A place for a beam, between two ports.
typedef struct {
    char name[STRUCTURE_NAME_SIZE];
    int hub[2], port[2]; ///< the beam is docked at the first
    int line;            ///< of the file
    int beam;            ///< the only one that may go there, or -1
    set_t after;         ///< slots that must be built before, as bits
    set_t touches;       ///< slots at the same hubs
} structure_slot_t;

typedef struct {
    lcm_ssv_scenario_t task; ///< any task of it: all but start, beam's place, port and obstacles holds for every one
    double p_IS_m[3], q_IS[4];
    int num_hubs, num_beams, num_slots;
    structure_hub_t hub[STRUCTURE_MAX_HUBS];
    structure_beam_t beam[STRUCTURE_MAX_BEAMS];
    structure_slot_t slot[STRUCTURE_MAX_SLOTS];
    bool touching;  ///< whether each slot but the first must be at a hub of one that is built
    bool obstacles; ///< whether what stands is an obstacle: the hubs, and beams that are docked
    // Where a part of it is assembled already; in what is read nothing is.
    set_t stands, gone;                              ///< slots that have a beam, and beams that are used up, as bits
    int left;                                        ///< slot of the beam that the vehicle stands at, or -1
    structure_port_t stands_at[STRUCTURE_MAX_SLOTS]; ///< where the end of its beam really is, and which way that goes
} structure_t;

/// Whether the rules allow this slot next, some being built.
bool structure_may_build(const structure_t* structure, set_t built, int slot);

/// Whether a beam may go to a slot: it is not used, the slot's own if that has one, and no other slot's.
bool structure_may_take(const structure_t* structure, set_t used, int beam, int slot);

/// Reads the structure at `path`, "-" being standard input; its model is looked for like a scenario's.
/// @return true; or false with a sentence in `error` that names file, line and key.
bool structure_read(structure_t* structure, const char* path, const char* models_dir, char* error, size_t error_size);

/// Whether a file, not standard input, is meant as a structure rather than as a scenario: it can be read, and has
/// slots.
bool structure_is_meant(const char* path);

/// The same for the text of such a file, which is not opened.
bool structure_text_read(structure_t* structure, const char* path, const char* text, size_t size,
                         const char* models_dir, char* error, size_t error_size);

#endif
