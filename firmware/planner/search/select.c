// The choice among the candidates, and what it costs (DESIGN.md 6).
#include "planner/search/select.h"

#include "planner/search/bound.h"
#include "planner/search/search.h"

// The cheapest candidate that is still feasible; -1 if there is none.
static int cheapest(const ssv_quote_t* quote) {
    int best = -1;
    for (int k = 0; k < quote->num_candidates; k++) {
        const ssv_candidate_t* candidate = &quote->candidate[k];
        if (candidate->outcome != SSV_FEASIBLE) continue;
        if (best < 0 || candidate->cost < quote->candidate[best].cost) best = k;
    }
    return best;
}

// Enters what a search of a candidate found, if it is cheaper than what is there.
static void improve(ssv_candidate_t* known, ssv_candidate_t found) {
    if (known->outcome != SSV_FEASIBLE || (found.outcome == SSV_FEASIBLE && found.cost < known->cost)) *known = found;
}

static void list_candidates(const ssv_scenario_t* scenario, ssv_quote_t* quote) {
    for (int contact = 1; contact <= SSV_NUM_CONTACTS; contact++) {
        if (scenario->contact != 0 && scenario->contact != contact) continue;
        for (int k = 0; k < scenario->num_attach_heights; k++) {
            quote->candidate[quote->num_candidates++] = (ssv_candidate_t){
                contact, scenario->attach_heights_m[k], REAL(0), SSV_NO_AUTHORITY, REAL(0), REAL(0), REAL(0)};
        }
    }
}

// The paper's chain of each candidate that may be cheaper than what is known.
static void search_paper(const ssv_question_t* question, ssv_quote_t* quote, ssv_path_t* best) {
    const ssv_price_t to_beat = best->price;
    ssv_path_t path;
    ssv_phase_path_t to_beam = {.num_maneuvers = 0};
    for (int k = 0; k < quote->num_candidates; k++) {
        ssv_candidate_t* candidate = &quote->candidate[k];
        const int contact = candidate->contact;
        if (!ssv_search_paper(question, contact, candidate->attach_height_m, &to_beat, &to_beam, &path,
                              &quote->num_priced))
            continue;
        improve(candidate, ssv_candidate_of(&path.grasp, &path.price));
        if (ssv_price_beats(&path.price, &best->price)) *best = path;
    }
}

// Candidates that method optimal looks at, by effort: those with the shortest ways; and how many of the most promising
// it searches, beside those that promise the same.
static const int num_looks[] = {[SSV_EFFORT_QUICK] = 2, [SSV_EFFORT_BEST] = SSV_MAX_CANDIDATES};
static const int num_searched[] = {[SSV_EFFORT_QUICK] = 1, [SSV_EFFORT_BEST] = 2};

// The least of the prices that is not done; -1 if there is none.
static int least_of(const real_t price[SSV_MAX_CANDIDATES], const bool done[SSV_MAX_CANDIDATES], int num) {
    int least = -1;
    for (int k = 0; k < num; k++) {
        if (!done[k] && (least < 0 || ssv_clearly_less(price[k], price[least]))) least = k;
    }
    return least;
}

// Searches a candidate, with a look before if effort quick needs one.
static ssv_candidate_t search_at(const ssv_question_t* question, ssv_search_t* search, int contact, real_t height_m,
                                 ssv_effort_t effort, bool looked, ssv_path_t* best, int* num_priced) {
    if (!looked && effort == SSV_EFFORT_QUICK)
        (void)ssv_optimal_look(question, search, contact, height_m, NULL, num_priced);
    return ssv_search_optimal(question, search, contact, height_m, effort, best, num_priced);
}

// A look at the candidates with short ways, then a search of the most promising; of all if all are to be listed.
SSV_OWN_FRAME static void search_optimal(const ssv_question_t* question, ssv_search_t* search, ssv_effort_t effort,
                                         ssv_quote_t* quote, ssv_path_t* best) {
    const bool all = question->list_candidates;
    real_t promise[SSV_MAX_CANDIDATES], turns = REAL(0);
    int favourite = -1; // after the looks so far
    bool looked[SSV_MAX_CANDIDATES] = {false}, done[SSV_MAX_CANDIDATES] = {false};
    ssv_capability_init(question, &search->capability);
    for (int k = 0; k < quote->num_candidates; k++) {
        const ssv_candidate_t* candidate = &quote->candidate[k];
        promise[k] = ssv_optimal_flights(question, &search->capability, candidate->contact, candidate->attach_height_m);
    }
    for (int n = 0; n < quote->num_candidates; n++) {
        const int next = least_of(promise, looked, quote->num_candidates);
        const ssv_candidate_t* candidate = &quote->candidate[next];
        const real_t* to_beat = favourite >= 0 ? &promise[favourite] : NULL;
        looked[next] = true;
        // No look where the flights, and turns of half the price of the best so far, cost as much as that.
        const real_t flights = promise[next];
        done[next] =
            !all && to_beat != NULL && (n >= num_looks[effort] || flights + real_mul(REAL(0.5), turns) >= *to_beat);
        if (done[next]) continue;
        promise[next] = ssv_optimal_look(question, search, candidate->contact, candidate->attach_height_m, to_beat,
                                         &quote->num_priced);
        if (to_beat != NULL && !ssv_clearly_less(promise[next], *to_beat)) continue;
        favourite = next;
        turns = promise[next] - flights;
    }
    for (int n = 0; n < quote->num_candidates; n++) {
        const int next = n == 0 ? favourite : least_of(promise, done, quote->num_candidates);
        if (next < 0 || !(all || n < num_searched[effort] || ssv_alike(promise[favourite], promise[next]))) break;
        // A search rarely gains more than that on a look.
        const bool hopeless =
            best->price.outcome == SSV_FEASIBLE && promise[next] >= real_mul(REAL(1.02), best->price.cost);
        if (n > 0 && !all && hopeless) break;
        ssv_candidate_t* candidate = &quote->candidate[next];
        done[next] = true;
        improve(candidate, search_at(question, search, candidate->contact, candidate->attach_height_m, effort, n == 0,
                                     best, &quote->num_priced));
    }
}

// Steps along the beam from the best height so far to the better side, shorter where neither gains; each with a quick
// search.
#define FIRST_HEIGHT_STEP REAL(0.125) // of the beam
#define NUM_HEIGHT_STEPS 6
static void search_along_beam(const ssv_question_t* question, ssv_search_t* search, ssv_quote_t* quote,
                              ssv_path_t* best) {
    const real_t length = question->problem->scenario.beam.length_m, end = real_mul(REAL(0.5), length);
    real_t step = real_mul(FIRST_HEIGHT_STEP, length);
    for (int n = 0; n < NUM_HEIGHT_STEPS && best->price.outcome == SSV_FEASIBLE; n++) {
        const real_t from = best->grasp.height_m;
        for (int side = -1; side <= 1; side += 2) {
            const real_t height = real_max(-end, real_min(end, side < 0 ? from - step : from + step));
            if (height == from) continue;
            const int contact = best->grasp.contact;
            (void)search_at(question, search, contact, height, SSV_EFFORT_QUICK, false, best, &quote->num_priced);
        }
        if (best->grasp.height_m == from) step = real_mul(REAL(0.5), step);
    }
}

// Effort best: every candidate, and the best height between them.
static void search_closely(const ssv_question_t* question, ssv_search_t* search, ssv_quote_t* quote, ssv_path_t* best) {
    const bool between = question->problem->scenario.attach_anywhere && best->price.outcome == SSV_FEASIBLE;
    const int contact = between ? best->grasp.contact : 0;
    const real_t height_m = between ? best->grasp.height_m : REAL(0);
    search_optimal(question, search, SSV_EFFORT_BEST, quote, best);
    if (!between) return;
    (void)ssv_search_optimal(question, search, contact, height_m, SSV_EFFORT_BEST, best, &quote->num_priced);
}

_Static_assert(sizeof(ssv_search_t) <= sizeof(ssv_work_t), "the search fits the memory to work in");
_Static_assert(_Alignof(ssv_search_t) <= _Alignof(ssv_work_t), "the search may stand where that memory is");

// An empty quote with the candidates that there are.
static void begin(const ssv_question_t* question, ssv_quote_t* quote, ssv_path_t* best) {
    memset(quote, 0, sizeof *quote);
    quote->status = SSV_INFEASIBLE;
    quote->scenario_hash = question->problem->scenario_hash;
    best->price.outcome = SSV_TOO_LONG;
    list_candidates(&question->problem->scenario, quote);
}

bool ssv_choose(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote, ssv_path_t* best) {
    const ssv_scenario_t* scenario = &question->problem->scenario;
    begin(question, quote, best);
    if (question->method == SSV_METHOD_OPTIMAL) {
        // More effort starts with what less effort does, and the paper's chains follow where these could still be
        // cheaper: neither ever costs more.
        ssv_search_t* search = (ssv_search_t*)work;
        search_optimal(question, search, SSV_EFFORT_QUICK, quote, best);
        if (scenario->attach_anywhere) search_along_beam(question, search, quote, best);
        if (scenario->effort == SSV_EFFORT_BEST) search_closely(question, search, quote, best);
    }
    search_paper(question, quote, best);
    return best->price.outcome == SSV_FEASIBLE;
}

bool ssv_choose_next(const ssv_question_t* question, ssv_outcome_t outcome, ssv_quote_t* quote, ssv_path_t* path) {
    int k = cheapest(quote);
    if (k >= 0) quote->candidate[k].outcome = outcome;
    k = cheapest(quote);
    if (k < 0) return false;
    const ssv_candidate_t* candidate = &quote->candidate[k];
    ssv_phase_path_t to_beam = {.num_maneuvers = 0};
    (void)ssv_search_paper(question, candidate->contact, candidate->attach_height_m, NULL, &to_beam, path,
                           &quote->num_priced);
    return true;
}

void ssv_quote_finish_price(const ssv_question_t* question, const ssv_path_t* path, ssv_quote_t* quote) {
    quote->choice = ssv_candidate_of(&path->grasp, &path->price);
    quote->status = SSV_OK;
    quote->cost = quote->choice.cost;
    quote->time_s = quote->choice.time_s;
    quote->impulse_Ns = quote->choice.impulse_Ns;
    quote->lower_bound = ssv_least_price(question);
    for (int k = 0; k < quote->num_candidates; k++) {
        ssv_candidate_t* candidate = &quote->candidate[k];
        const bool chosen =
            candidate->contact == path->grasp.contact && candidate->attach_height_m == path->grasp.height_m;
        if (chosen) *candidate = quote->choice;
    }
    if (question->list_candidates) return;
    quote->num_candidates = 0;
    memset(quote->candidate, 0, sizeof quote->candidate);
}

ssv_status_t ssv_quote_finish_status(const ssv_question_t* question, uint32_t overflows, ssv_quote_t* quote) {
    if (real_overflows() == overflows && real_is_finite(quote->cost)) {
        // What motions that did not fit a plan added up is no price.
        if (quote->status != SSV_OK) quote->cost = quote->time_s = quote->impulse_Ns = REAL(0);
        return quote->status;
    }
    memset(quote, 0, sizeof *quote);
    quote->status = SSV_NUMERIC_OVERFLOW;
    quote->scenario_hash = question->problem->scenario_hash;
    return quote->status;
}

static ssv_status_t quote_of(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote) {
    const uint32_t overflows = real_overflows();
    ssv_path_t path;
    if (ssv_choose(question, work, quote, &path)) ssv_quote_finish_price(question, &path, quote);
    return ssv_quote_finish_status(question, overflows, quote);
}

ssv_status_t ssv_quote(const ssv_problem_t* problem, ssv_work_t* work, ssv_quote_t* quote) {
    const ssv_question_t question = ssv_question_of(problem);
    return quote_of(&question, work, quote);
}

// ---- Front
// --------------------------------------------------------------------------------------------------------------

// Weights in units in which one thruster at its limit costs as much per second as the rung says, time one.
#define NUM_RUNGS 9
static const real_t rungs[NUM_RUNGS][2] = {{REAL(1), REAL(0)},   {REAL(1), REAL(0.02)}, {REAL(1), REAL(0.1)},
                                           {REAL(1), REAL(0.5)}, {REAL(1), REAL(2)},    {REAL(1), REAL(10)},
                                           {REAL(1), REAL(100)}, {REAL(0), REAL(1)},    {REAL(0), REAL(0)}};

// Adds the point if none is at least as good in both, and drops those that it makes needless. Room is kept for spare
// more.
static void front_add(ssv_front_t* front, const ssv_candidate_t* point, int spare) {
    int kept = 0;
    for (int k = 0; k < front->num_points; k++) {
        const ssv_candidate_t* old = &front->point[k];
        if (old->time_s <= point->time_s && old->impulse_Ns <= point->impulse_Ns) return;
    }
    for (int k = 0; k < front->num_points; k++) {
        const ssv_candidate_t old = front->point[k];
        if (old.time_s < point->time_s || old.impulse_Ns < point->impulse_Ns) front->point[kept++] = old;
    }
    front->num_points = kept;
    if (kept + spare >= SSV_MAX_FRONT) return;
    int k = front->num_points++;
    for (; k > 0 && front->point[k - 1].time_s > point->time_s; k--) front->point[k] = front->point[k - 1];
    front->point[k] = *point;
}

ssv_status_t ssv_front(const ssv_problem_t* problem, ssv_work_t* work, ssv_front_t* front) {
    const ssv_question_t own = ssv_question_of(problem);
    const uint32_t overflows = real_overflows();
    ssv_quote_t quote;
    memset(front, 0, sizeof *front);
    front->status = SSV_INFEASIBLE;
    front->scenario_hash = problem->scenario_hash;
    for (int n = 0; n < NUM_RUNGS; n++) {
        // The last rung is the scenario itself, as it was asked, so that its own price is among the points.
        ssv_question_t question = own;
        if (n < NUM_RUNGS - 1) {
            question.list_candidates = true;
            question.weight_time_per_s = rungs[n][0];
            question.weight_impulse_per_Ns = real_div(rungs[n][1], problem->scenario.vehicle.force_max_N);
        }
        if (quote_of(&question, work, &quote) != SSV_OK) continue;
        front->status = SSV_OK;
        front_add(front, &quote.choice, NUM_RUNGS - 1 - n);
        for (int k = 0; k < quote.num_candidates; k++) {
            if (quote.candidate[k].outcome == SSV_FEASIBLE) front_add(front, &quote.candidate[k], NUM_RUNGS - 1 - n);
        }
    }
    for (int k = 0; k < front->num_points; k++) {
        ssv_candidate_t* point = &front->point[k];
        point->cost =
            real_mul(own.weight_time_per_s, point->time_s) + real_mul(own.weight_impulse_per_Ns, point->impulse_Ns);
    }
    if (real_overflows() != overflows) {
        memset(front, 0, sizeof *front);
        front->status = SSV_NUMERIC_OVERFLOW;
        front->scenario_hash = problem->scenario_hash;
    }
    return front->status;
}
