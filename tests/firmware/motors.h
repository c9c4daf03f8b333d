/* motors.h: the motors and limit switches of a firmware that runs as a program of this computer.
 *
 * A few lines of glue for each firmware call these functions; `native.py` reads the same file in
 * shared memory, turns the arm by the pulses, and says where each switch closes. The name of the
 * file is in FIRMWARE_MOTORS; without it, nothing is recorded.
 *
 * The layout has to match `MotorsFile` in native.py.
 */
#ifndef MOTORS_H
#define MOTORS_H

#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#define MOTORS_MAGIC 0x31544f4du
#define MOTORS_AXES 8
#define MOTORS_LOGGED (1u << 20)

typedef struct {
  volatile int64_t pulses;    /* forwards less backwards */
  volatile int64_t closes_at; /* the switch is closed from this count on, in the direction `way` */
  volatile int32_t way;       /* 1 or -1; 0: the switch never closes */
  volatile int32_t stuck;     /* 1 or 0: the switch sticks closed or open; -1: it works */
} motors_axis_t;

typedef struct {
  uint64_t time_ns;
  int32_t axis, direction;
} motors_step_t;

typedef struct {
  uint32_t magic;             /* written by the firmware: it reports its steps */
  volatile uint32_t enabled;  /* a bit for each motor with current */
  volatile uint64_t time_ns;  /* the firmware's clock; it goes on after a restart */
  volatile uint64_t logged;   /* how many steps have been logged */
  motors_axis_t axes[MOTORS_AXES];
  motors_step_t log[MOTORS_LOGGED]; /* a ring */
} motors_file_t;

static motors_file_t *motors_file;
static uint64_t motors_began_ns;

/* Map the file; return 0 if there is none. Every other function needs it.
 * The firmware ends with the program that started it. */
static inline int motors_open(void) {
  const char *path = getenv("FIRMWARE_MOTORS");
  int file = path ? open(path, O_RDWR) : -1;
  if (file < 0) return 0;
  void *found =
      mmap(NULL, sizeof(motors_file_t), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (found == MAP_FAILED) return 0;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  motors_file = (motors_file_t *)found;
  motors_began_ns = motors_file->time_ns;
  motors_file->enabled = 0;
  motors_file->magic = MOTORS_MAGIC;
  return 1;
}

/* Tell the time since the firmware started; call it at least every millisecond. */
static inline void motors_clock(uint64_t time_ns) {
  motors_file->time_ns = motors_began_ns + time_ns;
}

/* A bit for each motor that has current. */
static inline void motors_enable(uint32_t axes) { motors_file->enabled = axes; }

/* One motor makes one step, forwards (1) or backwards (-1). */
static inline void motors_step(int axis, int direction, uint64_t time_ns) {
  uint64_t number = motors_file->logged;
  motors_step_t *step = &motors_file->log[number % MOTORS_LOGGED];
  step->time_ns = motors_began_ns + time_ns;
  step->axis = axis;
  step->direction = direction;
  motors_file->axes[axis].pulses += direction;
  motors_file->logged = number + 1;
}

/* A bit for each limit switch that is closed. */
static inline uint32_t motors_pressed(void) {
  uint32_t pressed = 0;
  for (int i = 0; i < MOTORS_AXES; i++) {
    const motors_axis_t *axis = &motors_file->axes[i];
    int closed = axis->way && (axis->pulses - axis->closes_at) * axis->way >= 0;
    if (axis->stuck >= 0) closed = axis->stuck;
    pressed |= (uint32_t)closed << i;
  }
  return pressed;
}

#endif
