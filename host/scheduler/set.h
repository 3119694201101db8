/// Sets of beams or of slots, a bit for each by its number.
#ifndef SSV_SCHEDULER_SET_H
#define SSV_SCHEDULER_SET_H

__extension__ typedef unsigned __int128 set_t;

static inline set_t set_of(int number) { return (set_t)1 << number; }

#endif
