/* SPDX-License-Identifier: MIT */
#pragma once
/* Ticks of a scene behind functions of C: two builds of this library can be loaded side by side
   into one process and timed in turn (docs/bench.md). Nothing here throws; whoever calls keeps to
   one thread. */

#ifdef __cplusplus
extern "C" {
#endif

struct palpate_steps;

/* Of these functions; raised when their meaning changes. */
int palpate_steps_version(void);

/* A scene file, read and set up. Null when it cannot be: then `problem` holds why, cut to
 * `problem_size`. */
struct palpate_steps* palpate_steps_create(const char* scene_file, char* problem,
                                           unsigned long problem_size);

/* So many ticks further; 0, or 1 once the motion has diverged. */
int palpate_steps_run(struct palpate_steps* steps, long ticks);

/* Of all coordinates and velocities to the last bit: 32 hexadecimal digits and a zero. */
void palpate_steps_digest(struct palpate_steps* steps, char digest[33]);

/* Lives as long as `steps`. */
const char* palpate_steps_kernel(const struct palpate_steps* steps);

long palpate_steps_tick_count(const struct palpate_steps* steps);    /* in the scene's duration */
double palpate_steps_tick_length(const struct palpate_steps* steps); /* [s] */

void palpate_steps_destroy(struct palpate_steps* steps);

#ifdef __cplusplus
}
#endif
