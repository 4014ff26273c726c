/* SPDX-License-Identifier: MIT */
/* The skeleton of a subject with one fault, chosen by a word in its options. */
#define palpate_subject_api_v1 sound_api
#include "fixtures/subjects/skeletons/subject.c"
#undef palpate_subject_api_v1

#include <errno.h>
#include <signal.h>
#include <unistd.h>

static char fault[64];
static double* before; /* position and velocity of the step before */
static palpate_subject_api table;

static int is(const char* name) { return strcmp(fault, name) == 0; }

static int load_with_fault(const char* folder, const char* options, palpate_subject** subject,
                           char* error, size_t size) {
  static double kept_stiffness = -1.0;
  fault[0] = '\0';
  sscanf(options, "{\"fault\": \"%63[a-z-]", fault);
  const int status = load(folder, options, subject, error, size);
  if (status != PALPATE_OK) { return status; }
  palpate_subject* s = *subject;
  if (is("null-subject")) { *subject = NULL; }
  if (is("peek")) { /* the file at the end of the options: an answer that it may not read */
    const char* path = strstr(options, "\"/");
    char name[4096] = "";
    FILE* file = path != NULL && sscanf(path, "\"%4095[^\"]", name) == 1 ? fopen(name, "r") : NULL;
    snprintf(error, size, "%s %s", name, file != NULL ? "was read" : strerror(errno));
    if (file != NULL) { fclose(file); }
    return PALPATE_FAILED;
  }
  if (is("refuse") && (s->gravity[0] != 0.0 || s->gravity[1] != 0.0 || s->gravity[2] != 0.0)) { /* though it declares gravity */
    snprintf(error, size, "no gravity in this engine");
    return PALPATE_UNSUPPORTED;
  }
  if (is("move")) { /* the folder of that file, so that the next process could read it elsewhere */
    const char* path = strstr(options, "\"/");
    char name[4096] = "";
    char other[4104];
    if (path != NULL && sscanf(path, "\"%4095[^\"]", name) == 1 && strrchr(name, '/') != NULL) {
      *strrchr(name, '/') = '\0';
    }
    snprintf(other, sizeof other, "%s-moved", name);
    snprintf(error, size, "%s %s", name, rename(name, other) == 0 ? "was moved" : strerror(errno));
    return PALPATE_FAILED;
  }
  if (is("fine")) { s->substeps = 512; }
  if (is("stiffness") && s->springs > 0) {
    for (size_t n = 0; n < s->springs; ++n) { s->stiffness[n] = 50.0; }
  }
  for (size_t n = 0; is("viscosity") && n < s->springs; ++n) { s->viscosity[n] *= 1.05; }
  for (size_t n = 0; is("geometric") && n < s->springs; ++n) {
    double squared = 0.0;
    for (int k = 0; k < 3; ++k) { squared += pow(s->rest[3 * s->b[n] + k] - s->rest[3 * s->a[n] + k], 2); }
    s->length[n] = sqrt(squared);
  }
  for (size_t n = 0; is("slow-start") && n < 3 * s->nodes; ++n) { s->start_v[n] *= 0.7; s->v[n] *= 0.7; }
  if (is("cache") && s->springs > 0) {
    if (kept_stiffness < 0.0) { kept_stiffness = s->stiffness[0]; }
    for (size_t n = 0; n < s->springs; ++n) { s->stiffness[n] = kept_stiffness; }
  }
  free(before);
  before = room(6 * s->nodes, sizeof(double));
  memcpy(before, s->x, 3 * s->nodes * sizeof(double));
  memcpy(before + 3 * s->nodes, s->v, 3 * s->nodes * sizeof(double));
  return status;
}

static int step_with_fault(palpate_subject* s, double time, double dt, const palpate_tool_input* in,
                           palpate_tool_output* out) {
  memcpy(before, s->x, 3 * s->nodes * sizeof(double));
  memcpy(before + 3 * s->nodes, s->v, 3 * s->nodes * sizeof(double));
  if (is("crash") && time > 0.002) { raise(SIGSEGV); }
  if (is("exit") && time > 0.002) { exit(7); }
  if (is("hang") && time > 0.002) { sleep(3600); }
  if (is("memory")) { memset(malloc(64 << 20), 1, 64 << 20); }
  if (is("leak")) { memset(malloc(8192), 1, 8192); }
  if (is("print")) { printf("step at %g s\n", time); fflush(stdout); }
  for (int n = 0; is("chatter") && n < 256; ++n) { fprintf(stderr, "%-63g\n", time); }
  if (is("status")) { return 77; }
  if (is("reason")) {
    fprintf(stderr, "the solver found no solution\n");
    return PALPATE_FAILED;
  }
  const int status = step(s, time, dt, in, out);
  if (is("nan") && time > 0.002) { s->x[3 * (s->nodes - 1) + 2] = NAN; }
  return status;
}

static int state_with_fault(palpate_subject* s, double* position, double* velocity, size_t nodes) {
  const int status = get_state(s, position, velocity, nodes);
  if (is("late")) {
    memcpy(position, before, 3 * nodes * sizeof(double));
    memcpy(velocity, before + 3 * nodes, 3 * nodes * sizeof(double));
  }
  for (size_t n = 0; is("millimetres") && n < 3 * nodes; ++n) {
    position[n] *= 1000.0;
    velocity[n] *= 1000.0;
  }
  for (size_t n = 0; is("nan-velocity") && n < 3 * nodes; ++n) { velocity[n] = NAN; }
  for (size_t n = 0; is("velocity") && n < 3 * nodes; ++n) { velocity[n] *= 1.08; }
  for (size_t n = 0; is("aside") && n < nodes; ++n) { position[3 * n] += 1.0; }
  if (is("infinite-fixed")) { position[0] = INFINITY; }
  for (size_t n = 0; n < nodes; ++n) {
    if (is("moved-fixed") && s->fixed[n]) { position[3 * n] += 0.01; }
    if (is("fast-fixed") && s->fixed[n]) { velocity[3 * n] = 0.5; }
  }
  return is("claims") ? PALPATE_UNSUPPORTED : status;
}

static int set_with_fault(palpate_subject* s, const double* position, const double* velocity,
                          size_t nodes) {
  const int status = set_state(s, position, velocity, nodes);
  if (is("set-state")) { memset(s->v, 0, 3 * nodes * sizeof(double)); }
  return status;
}

static int energy_with_fault(palpate_subject* s, double joule[3]) {
  const int status = energy(s, joule);
  if (is("energy")) { joule[0] *= 2.0; }
  if (is("dissipation")) { joule[2] *= 0.5; }
  return is("claims") ? PALPATE_UNSUPPORTED : status;
}

static int parameter_with_fault(palpate_subject* s, const char* name, double value) {
  return set_parameter(s, name, is("substeps") ? 1.0 : is("fine") ? 512.0 : value);
}

static int reset_with_fault(palpate_subject* s, uint64_t seed) {
  double* kept = room(3 * s->nodes, sizeof(double));
  memcpy(kept, s->external, 3 * s->nodes * sizeof(double));
  const double dissipated = s->dissipated;
  const int status = reset(s, seed);
  if (is("left-energy")) { s->dissipated = dissipated; }
  if (is("left-load")) { memcpy(s->external, kept, 3 * s->nodes * sizeof(double)); }
  free(kept);
  if (is("reset")) { s->v[3 * (s->nodes - 1)] = 1e-3; }
  return status;
}

PALPATE_SUBJECT_EXPORT const palpate_subject_api* palpate_subject_api_v1(void) {
  table = *sound_api();
  table.load = load_with_fault;
  table.step = step_with_fault;
  table.get_state = state_with_fault;
  table.reset = reset_with_fault;
  table.set_parameter = parameter_with_fault;
  table.set_state = set_with_fault;
  table.energy = energy_with_fault;
  return &table;
}
