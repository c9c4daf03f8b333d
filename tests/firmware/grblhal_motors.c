/* grblhal_motors.c: reports the steps of grblHAL's Simulator, and closes its limit switches.
 *
 * The linker puts these functions in front of the simulator's own (`--wrap`), so its source stays
 * as it is; docs/background/testing.md has the commands. A step pulse is a write to the step port,
 * which the simulator never resets.
 */
#include "driver.h"
#include "mcu.h"
#include "simulator.h"

#include "motors.h"

#define NS_PER_S 1000000000ull
#define ALL_AXES ((1u << N_AXIS) - 1)

void __real_mcu_gpio_set(gpio_port_t *port, uint16_t pins, uint16_t mask);
void __real_simulate_serial(void);
void __wrap_mcu_gpio_set(gpio_port_t *port, uint16_t pins, uint16_t mask);
void __wrap_simulate_serial(void);

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
__attribute__((constructor)) static void begin(void) { motors_open(); }

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

/* The simulator calls it once for each byte time of its serial line. */
void __wrap_simulate_serial(void) {
  if (motors_file) {
    motors_clock(time_ns());
    update_switches();
  }
  __real_simulate_serial();
}
