/// Hierarchical task networks with ordered decomposition, as SHOP2 has them, at least cost: a search that knows no
/// domain.
///
/// A domain says which tasks there are. A primitive task has an operator: it changes the state, costs something, and
/// can be undone. A compound task has methods: each is a way to do it, a list of subtasks that are done one after the
/// other. A method may have several bindings, one for each choice of arguments that its precondition allows. A plan is
/// an order of primitive tasks that the first tasks decompose into and whose preconditions all hold when their turn
/// comes.
///
/// The search goes depth first and keeps the plan that costs least. It leaves out what provably cannot cost less than
/// the plan that it has: by the domain's bound, and by what it has proved itself about states that it meets again. When
/// it ends by itself, the plan is optimal (to rounding of sums of costs). The tests' example, blocks on a table, is a
/// whole domain in some hundred lines: tests/unit/test_htn.c.
///
/// How to write a domain:
/// - Tasks: number the kinds from 0. What a task needs to know goes to its arguments.
/// - State: one struct of the domain's own, which only operators change. `undo` gets what `apply` left in the undo
///   memory and restores the state to the last bit; calls come in reverse order.
/// - `method` answers one question: what are the subtasks by binding n of method m of this task, now? It is asked with
///   n = 0, 1, 2, and so on until it says HTN_NO_MORE; with HTN_SKIP the precondition does not hold for this n. Good
///   bindings first: the search finds good plans sooner and leaves out more.
/// - `bound` must never be more than the tasks cost that are still to be done; 0 is sound.
/// - `memory_key` is what makes large searches possible: two states with equal keys (and equal tasks still to do) must
///   have equal costs from there on. Where the tasks still to do do not follow from the state, they belong to the key.
///   Without a key a domain whose compound task can lead to itself must see to it that this ends.
#ifndef SSV_SCHEDULER_HTN_H
#define SSV_SCHEDULER_HTN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define HTN_MAX_ARGUMENTS 4
#define HTN_MAX_SUBTASKS 8
#define HTN_MAX_KEY 40
#define HTN_MAX_UNDO 64

/// How deep the search may go: tasks that are begun on the way to one plan. It bounds the stack.
#define HTN_MAX_DEPTH 4096

typedef struct {
    int kind;
    int argument[HTN_MAX_ARGUMENTS];
} htn_task_t;

/// Tasks that are still to be done, the next one first.
typedef struct htn_agenda {
    htn_task_t task;
    int level; ///< how many compound tasks it is a part of
    const struct htn_agenda* rest;
} htn_agenda_t;

typedef enum { HTN_NO_MORE, HTN_SKIP, HTN_BOUND } htn_binding_t;

/// What a method makes of a task.
typedef struct {
    int count;
    htn_task_t task[HTN_MAX_SUBTASKS];
} htn_subtasks_t;

/// What one kind of task is.
typedef struct {
    const char* name;
    int num_methods; ///< of a compound task; 0: primitive, an operator does it
} htn_kind_t;

typedef struct {
    const htn_kind_t* kinds;
    int num_kinds;
    /// Does a primitive task if its precondition holds. @return whether it was done; then *cost >= 0 is its price, and
    /// undo, HTN_MAX_UNDO bytes for any type, what `undo` needs.
    bool (*apply)(void* state, const htn_task_t* task, void* undo, double* cost);
    void (*undo)(void* state, const htn_task_t* task, const void* undo);
    /// How a compound task is done; *subtasks is filled with HTN_BOUND.
    htn_binding_t (*method)(void* state, const htn_task_t* task, int method, int binding, htn_subtasks_t* subtasks);
    /// NULL = 0.
    double (*bound)(void* state, const htn_agenda_t* agenda);
    /// Writes the key of the state, HTN_MAX_KEY bytes that are zero before. @return whether it has one now. NULL = no.
    bool (*memory_key)(void* state, const htn_agenda_t* agenda, unsigned char key[HTN_MAX_KEY]);
} htn_domain_t;

/// One task of a plan: a compound one stands before its parts, which have the next level.
typedef struct {
    htn_task_t task;
    int level;
    int method;  ///< of a compound task, else -1
    double cost; ///< of a primitive task, else 0
} htn_step_t;

/// A plan as a tree, written in the order in which it is done.
typedef struct {
    int num_steps;
    htn_step_t* steps;
    double cost;
} htn_plan_t;

/// When to stop, and whom to tell. Zero or NULL is no limit, and nobody.
typedef struct {
    uint64_t max_nodes;
    double most;                 ///< only plans that cost less are of interest
    size_t max_memories;         ///< states that are remembered
    bool (*stop)(void* context); ///< asked before each task
    /// Tells every plan, good or bad, and leaves nothing out: for tasks with few plans.
    bool all;
    /// Called with each plan that is better than all before; the plan is lent. @return whether to go on.
    bool (*found)(void* context, const htn_plan_t* plan);
    void* context; ///< of both
} htn_limits_t;

typedef enum {
    HTN_OPTIMAL, ///< the plan costs least
    HTN_NO_PLAN, ///< proved: there is none, or none that costs less than `most`
    HTN_STOPPED, ///< a limit was met: the plan, if any, is the best so far
    HTN_NO_MEMORY
} htn_status_t;

typedef struct {
    htn_status_t status;
    htn_plan_t plan;    ///< its steps are NULL if there is none; the caller frees them
    double lower_bound; ///< no plan costs less
    uint64_t nodes;     ///< tasks that were begun
    uint64_t memories;  ///< states that are remembered
    uint64_t recalled;  ///< times that a branch was left out since its state was remembered
} htn_result_t;

/// Plans the tasks from the state, which is as before afterwards.
htn_result_t htn_search(const htn_domain_t* domain, void* state, const htn_task_t* tasks, int num_tasks,
                        const htn_limits_t* limits);

#endif
