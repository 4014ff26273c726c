/* SPDX-License-Identifier: MIT */
/*
 * Interface of a simulator under test ("subject"), version 1.
 *
 * A shared library exports one function, palpate_subject_api_v1(), which returns a table of
 * functions. Palpate loads the library in a child process and calls the table. docs/subjects.md is
 * the manual; `palpate subject new` writes a working skeleton.
 *
 * The child process cannot read files in Palpate's cache of references and in the output folder
 * where the kernel can prevent it (Landlock).
 *
 * Conventions: C99, SI units, double precision, little-endian files. A vector is x, y, z. The
 * tissue frame is right-handed with z into the tissue; the undeformed skin is at z = 0. Calls come
 * from one thread, one after another. No function may throw, exit, or write to standard output
 * (the host sends what is written there to standard error).
 */
#ifndef PALPATE_SUBJECT_H
#define PALPATE_SUBJECT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PALPATE_SUBJECT_ABI 1

#if defined(_WIN32)
#define PALPATE_SUBJECT_EXPORT __declspec(dllexport)
#else
#define PALPATE_SUBJECT_EXPORT __attribute__((visibility("default")))
#endif

/* Result of a call. */
enum {
  PALPATE_OK = 0,
  PALPATE_DIVERGED = 1,    /* of step: the state is not finite or left the scene; the run ends */
  PALPATE_UNSUPPORTED = 2, /* the subject cannot do this; an error if it declares that it can */
  PALPATE_FAILED = 3       /* any other failure; the case ends with an error */
};

/* What a subject can do; bits of palpate_subject_api.capabilities. A case that needs a bit that is
 * not set is skipped, with the name of the bit as the reason. Names, in settings.csv and messages,
 * are as below in small letters with '-': "spring-damping". */
#define PALPATE_CAN_SPRINGS (UINT64_C(1) << 0)        /* linear springs of springs.csv */
#define PALPATE_CAN_SPRING_DAMPING (UINT64_C(1) << 1) /* viscosity of each spring */
#define PALPATE_CAN_FIXED_NODES (UINT64_C(1) << 2)    /* nodes that never move */
#define PALPATE_CAN_INITIAL_STATE (UINT64_C(1) << 3)  /* initial.csv */
#define PALPATE_CAN_LOADS (UINT64_C(1) << 4)          /* loads.csv: forces on nodes over time */
#define PALPATE_CAN_GRAVITY (UINT64_C(1) << 5)
#define PALPATE_CAN_STATE (UINT64_C(1) << 6)     /* get_state */
#define PALPATE_CAN_SET_STATE (UINT64_C(1) << 7) /* set_state */
#define PALPATE_CAN_ENERGY (UINT64_C(1) << 8)    /* energy */
#define PALPATE_CAN_NEEDLE (UINT64_C(1) << 9)    /* a sharp tool; its name is tool-needle */
#define PALPATE_CAN_PROBE (UINT64_C(1) << 10)    /* a blunt tool; its name is tool-probe */
#define PALPATE_CAN_SYRINGE (UINT64_C(1) << 11)  /* pressure of palpate_tool_output */
/* Tissue from layers.csv with its own discretisation. Such a subject is judged at the tool. It
 * need not read nodes.csv and springs.csv. */
#define PALPATE_CAN_OWN_DISCRETISATION (UINT64_C(1) << 12)
/* Volume terms, stiffening and relaxation of materials, as in model/EQUATIONS.md. */
#define PALPATE_CAN_MATERIAL_LAWS (UINT64_C(1) << 13)
/* The same calls give the same bits after reset. */
#define PALPATE_CAN_REPEAT (UINT64_C(1) << 14)

typedef struct palpate_subject palpate_subject; /* one scene in motion; defined by the subject */

/* palpate_tool_input.flags: how the tool moves. Exactly one is set. */
enum {
  PALPATE_TOOL_PRESCRIBED = 1, /* its tip follows position; the tool carries any force */
  PALPATE_TOOL_PUSHED = 2,     /* applied_force acts along direction; the subject moves the tool */
  PALPATE_TOOL_COUPLED = 4     /* position is the hand's end of a spring-damper to the tool */
};

typedef struct palpate_tool_input {
  double position[3];    /* of the tip (needle) or the centre of the face (probe) at the end of the
                          * step [m]; it moves at constant velocity during the step */
  double velocity[3];    /* during the step [m/s] */
  double direction[3];   /* of the tool's axis, into the tissue; length 1 */
  double insertion;      /* position along direction, 0 where the tool's line crosses the undeformed
                          * skin [m] */
  double insertion_rate; /* velocity along direction [m/s] */
  double applied_force;  /* of the hand along direction [N] */
  uint32_t flags;
  uint32_t reserved; /* 0 */
} palpate_tool_input;

/* Bits of palpate_tool_output.events. Several events of one step happen in this order. Two more
 * bits say whether the tool touches the tissue at the end of the step; a tool that rebounds may
 * touch and part without an event. A step without either leaves that as it was: apart before the
 * first step, touching from contact on, apart from withdrawal on. The layer of the tip and the
 * depth of the cut are recorded while the tool touches. */
enum {
  PALPATE_EVENT_CONTACT = 1,
  PALPATE_EVENT_PUNCTURE = 2,
  PALPATE_EVENT_LOSS_OF_RESISTANCE = 4,
  PALPATE_EVENT_BONE = 8,
  PALPATE_EVENT_DURAL_PUNCTURE = 16,
  PALPATE_EVENT_WITHDRAWN = 32,
  PALPATE_TOOL_TOUCHING = 64,
  PALPATE_TOOL_APART = 128
};

/* State of the tool at the end of the step. The subject fills what it has; numbers that it leaves
 * alone are NaN. A tool that begins on the skin or in it reports PALPATE_EVENT_CONTACT in the step
 * of dt = 0. */
typedef struct palpate_tool_output {
  double force[3];  /* of the tissue on the tool, tissue frame [N] */
  double cutting;   /* part of the resistance along direction, against insertion positive [N] */
  double friction;  /* likewise */
  double stiffness; /* likewise; the three sum to -force . direction */
  double insertion; /* of the tool, as in the input [m]; NaN: as prescribed */
  double insertion_rate; /* [m/s] */
  double cut;            /* largest insertion to which the tissue was cut so far [m] */
  double applied;        /* force of the hand on the tool along direction [N]; NaN: as given, or
                          * what holds a prescribed tool */
  double pressure;       /* of a syringe, gauge [Pa] */
  double event_time;     /* of the events [s]; NaN: at the end of the step */
  uint32_t events;
  uint32_t substeps; /* integration steps within the step; 0: unknown */
  double depth;      /* of the tip in undeformed tissue, which has the layer that it is in [m]; NaN:
                      * the smaller of insertion and cut. Answers on the pipe may leave it out */
} palpate_tool_output;

typedef struct palpate_subject_api {
  uint32_t abi;           /* PALPATE_SUBJECT_ABI */
  uint32_t size;          /* sizeof(palpate_subject_api); lets the table grow */
  const char* name;       /* "bullet" */
  const char* version;    /* "3.24" */
  const char* licence;    /* SPDX identifier of the simulator */
  const char* parameters; /* names that set_parameter accepts, comma-separated; or null */
  uint64_t capabilities;

  /* Any function but load, step and destroy may be null: unsupported. The last line that a subject
   * wrote to standard error is shown with the failure of a call. */

  /* Loads a scene folder (docs/subjects.md, "Scene folder") and puts it at t = 0. Not timed. A
   * failure writes one line to `error`, which has `error_size` bytes. A scene that the subject
   * cannot represent is PALPATE_UNSUPPORTED: an error of the case, unless it is listed as expected
   * (--expected), because the subject declares all that the scene needs; Palpate does not load
   * others. `options_json` is a JSON object of options of the
   * user (`--subject-options`), "{}" without any. */
  int (*load)(const char* folder, const char* options_json, palpate_subject** subject, char* error,
              size_t error_size);
  /* Returns to t = 0. Must not change what the following steps compute. Not timed. */
  int (*reset)(palpate_subject*, uint64_t seed);
  /* Advances from `time` to `time + dt` [s]. The only timed call: it may not read or write files.
   * `input` and `output` are null in scenes without a tool; in others a step of dt = 0, which only
   * fills the output for t = 0, follows load and reset. */
  int (*step)(palpate_subject*, double time, double dt, const palpate_tool_input* input,
              palpate_tool_output* output);
  /* Writes position and velocity of all nodes, in the order of nodes.csv; each array has
   * 3 * nodes values [m, m/s]. */
  int (*get_state)(palpate_subject*, double* position, double* velocity, size_t nodes);
  /* Replaces position and velocity of all nodes. Called after reset and before the first step:
   * time starts at 0, loads are those of loads.csv, no energy has been dissipated. */
  int (*set_state)(palpate_subject*, const double* position, const double* velocity, size_t nodes);
  /* Palpate sets "substeps" (integration steps per step) if `parameters` names it. Takes effect at
   * the next reset. */
  int (*set_parameter)(palpate_subject*, const char* name, double value);
  /* Kinetic, elastic and dissipated energy so far [J]; NaN: not accounted for. With all three,
   * their sum is judged against the work of the loads. */
  int (*energy)(palpate_subject*, double joule[3]);
  void (*destroy)(palpate_subject*);
} palpate_subject_api;

/* The one exported function. The table must stay valid while the library is loaded. */
PALPATE_SUBJECT_EXPORT const palpate_subject_api* palpate_subject_api_v1(void);
typedef const palpate_subject_api* (*palpate_subject_api_function)(void);

/*
 * The pipe (exec:). A program that reads frames on standard input and answers each with one frame
 * on standard output, in order. A frame is a header of 16 bytes and a payload, little-endian:
 *   uint32 length of the payload; uint16 call; uint16 status of an answer, 0 in a request;
 *   uint64 sequence, which the answer repeats.
 * Text is a uint32 length and UTF-8 bytes. Structs are packed in the order of their members.
 * A failed answer (status not 0) of `load` may carry a text, of which 2048 bytes are shown; others
 * carry nothing. A step that diverged may carry its answer or nothing.
 *
 *   call            request                                        answer
 *   1 hello         uint32 abi                                     uint32 abi, uint64 capabilities,
 *                                                                  text name, version, licence,
 *                                                                  parameters
 *   2 load          text folder, text options_json                 -
 *   3 reset         uint64 seed                                    -
 *   4 step          double time, double dt, uint32 has_tool,       double seconds of the step or
 *                   then palpate_tool_input if has_tool            NaN, then palpate_tool_output
 *                                                                  if has_tool
 *   5 get_state     uint64 nodes                                   6 * nodes doubles: positions,
 *                                                                  velocities
 *   6 set_state     uint64 nodes, then 6 * nodes doubles           -
 *   7 set_parameter text name, double value                        -
 *   8 energy        -                                              3 doubles
 *   9 close         -                                              - (destroys the scene; load may
 *                                                                  follow)
 *   10 empty        -                                              - (measures the round trip)
 * The program ends when its standard input ends. Seconds that a program reports itself are used
 * only from Palpate's own host of shared libraries; others are timed from outside.
 */
enum {
  PALPATE_CALL_HELLO = 1,
  PALPATE_CALL_LOAD = 2,
  PALPATE_CALL_RESET = 3,
  PALPATE_CALL_STEP = 4,
  PALPATE_CALL_GET_STATE = 5,
  PALPATE_CALL_SET_STATE = 6,
  PALPATE_CALL_SET_PARAMETER = 7,
  PALPATE_CALL_ENERGY = 8,
  PALPATE_CALL_CLOSE = 9,
  PALPATE_CALL_EMPTY = 10
};

#ifdef __cplusplus
}
#endif

#endif
