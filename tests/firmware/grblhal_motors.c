/* grblhal_motors.c: reports the steps of grblHAL's Simulator, and closes its limit switches.
 *
 * The linker puts these functions in front of the simulator's own (`--wrap`), so its source stays
 * as it is; docs/background/testing.md has the commands. A step pulse is a write to the step port,
 * which the simulator never resets.
 */
#include <pthread.h>
#include <sys/prctl.h>
#include <time.h>

#include "driver.h"
#include "mcu.h"
#include "simulator.h"

#include "grbl/hal.h"

#include "motors.h"

#define NS_PER_S 1000000000ull
#define ALL_AXES ((1u << N_AXIS) - 1)
#define CATCH_UP_NS 500000000

void __real_mcu_gpio_set(gpio_port_t *port, uint16_t pins, uint16_t mask);
void __real_simulate_serial(void);
void __wrap_mcu_gpio_set(gpio_port_t *port, uint16_t pins, uint16_t mask);
void __wrap_simulate_serial(void);
int __wrap_sched_yield(void);
void __real_mcu_master_clock(void);
void __wrap_mcu_master_clock(void);
bool __real_driver_init(void);
bool __wrap_driver_init(void);

static uint64_t time_ns(void) {
  return sim.masterclock / F_CPU * NS_PER_S + sim.masterclock % F_CPU * NS_PER_S / F_CPU;
}

static void update_switches(void) {
  static uint32_t before;
  uint32_t pressed = motors_pressed() & ALL_AXES;
  if (pressed != before) mcu_gpio_in(&gpio[LIMITS_PORT0], (uint16_t)pressed, ALL_AXES);
  before = pressed;
}

/* Before the firmware starts. */
__attribute__((constructor)) static void begin(void) {
  motors_open();
  prctl(PR_SET_TIMERSLACK, 1);
}

static void ignore_settings(settings_t *settings, settings_changed_flags_t changed) {
  (void)settings;
  (void)changed;
}

/* Interrupts: the handlers run in a thread of their own here, and nothing keeps them away from the
 * main loop. Without what follows, a `?` or the end of a motion is forgotten now and then.
 */
static pthread_mutex_t interrupts = PTHREAD_MUTEX_INITIALIZER;
static _Thread_local bool handling, disabled;

static void disable_interrupts(void) {
  if (!handling && !disabled) pthread_mutex_lock(&interrupts);
  disabled = true;
}

static void enable_interrupts(void) {
  if (!handling && disabled) pthread_mutex_unlock(&interrupts);
  disabled = false;
}

void __wrap_mcu_master_clock(void) {
  pthread_mutex_lock(&interrupts);
  handling = true;
  __real_mcu_master_clock();
  handling = disabled = false;
  pthread_mutex_unlock(&interrupts);
}

static void set_bits(volatile uint_fast16_t *bits, uint_fast16_t set) {
  __atomic_fetch_or(bits, set, __ATOMIC_SEQ_CST);
}

static uint_fast16_t clear_bits(volatile uint_fast16_t *bits, uint_fast16_t clear) {
  return __atomic_fetch_and(bits, ~clear, __ATOMIC_SEQ_CST);
}

static uint_fast16_t set_value(volatile uint_fast16_t *bits, uint_fast16_t value) {
  return __atomic_exchange_n(bits, value, __ATOMIC_SEQ_CST);
}

/* Without any plugin, a soft reset makes the parser call itself for ever at the next `$n=` (gcode.c,
 * gc_init). Boards have plugins that listen to settings; so does this one.
 */
bool __wrap_driver_init(void) {
  bool started = __real_driver_init();
  hal.irq_disable = disable_interrupts;
  hal.irq_enable = enable_interrupts;
  hal.set_bits_atomic = set_bits;
  hal.clear_bits_atomic = clear_bits;
  hal.set_value_atomic = set_value;
  if (!grbl.on_settings_changed) grbl.on_settings_changed = ignore_settings;
  return started;
}

/* The main loop yields at each pass, and gets one byte of the line. On a busy computer, a thread
 * that yields waits behind all others; one that sleeps for a moment is woken at once.
 */
int __wrap_sched_yield(void) {
  const struct timespec moment = {0, 20000};
  return nanosleep(&moment, NULL);
}

void __wrap_mcu_gpio_set(gpio_port_t *port, uint16_t pins, uint16_t mask) {
  __real_mcu_gpio_set(port, pins, mask);
  if (!motors_file) return;
  if (port == &gpio[STEPPER_ENABLE_PORT]) {
    motors_enable(~pins & mask); /* drivers are enabled by a low level, as $4 has it */
  } else if (port == &gpio[STEP_PORT0] && pins & mask) {
    uint64_t now_ns = time_ns();
    for (int axis = 0; axis < N_AXIS; axis++)
      if (pins & mask & 1u << axis)
        motors_step(axis, gpio[DIR_PORT].state.value & 1u << axis ? -1 : 1, now_ns);
    update_switches();
  }
}

/* Sleep until the wall clock has caught up with the firmware's. The simulator itself runs 20 ms in
 * one go and then sleeps, and its main loop misses most of the byte times in between.
 */
static void keep_pace(void) {
  static int64_t offset_ns;
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  int64_t wall_ns = (int64_t)now.tv_sec * (int64_t)NS_PER_S + now.tv_nsec;
  int64_t ahead_ns = (int64_t)time_ns() - wall_ns - offset_ns;
  if (!offset_ns || ahead_ns < -CATCH_UP_NS) { /* so late that it is not caught up */
    offset_ns += ahead_ns;
  } else if (ahead_ns > 0) {
    const struct timespec rest = {0, (long)ahead_ns};
    nanosleep(&rest, NULL);
  }
}

/* The simulator calls it once for each byte time of its serial line. */
void __wrap_simulate_serial(void) {
  keep_pace();
  /* Its two threads race for this flag: what the firmware said last would stay in its buffer. */
  uart.tx_irq_enable = 1;
  if (motors_file) {
    motors_clock(time_ns());
    update_switches();
  }
  __real_simulate_serial();
}
