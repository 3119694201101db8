/// The choice among the candidates: which path is flown, and what it costs.
#ifndef SSV_SELECT_H
#define SSV_SELECT_H

#include "planner/motion/path.h"
#include "planner/motion/question.h"
#include "ssv/planner.h"

/// Searches every candidate by the question's method. The quote's candidates are then those that were looked at; the
/// rest of it is filled in by ssv_quote_finish_price. *work is not looked at by method paper and may be NULL then.
/// @return false if none is feasible; then the quote is complete and *best has no meaning.
bool ssv_choose(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote, ssv_path_t* best);

/// Method paper: the path of the next candidate in order of price, after the one chosen turned out not to be possible,
/// for the reason given. @return as ssv_choose.
bool ssv_choose_next(const ssv_question_t* question, ssv_outcome_t outcome, ssv_quote_t* quote, ssv_path_t* path);

/// Ends every answer. If a result did not fit the scalar since real_overflows() was `overflows`, or the price is not
/// finite, all that the quote says is that; no other number of it can be trusted. @return quote->status.
ssv_status_t ssv_quote_finish_status(const ssv_question_t* question, uint32_t overflows, ssv_quote_t* quote);

/// Completes the quote with the price of the path that was chosen.
void ssv_quote_finish_price(const ssv_question_t* question, const ssv_path_t* path, ssv_quote_t* quote);

/// All three in one: the answer to a question without its plan. @return quote->status.
ssv_status_t ssv_quote_of(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote);

#endif
