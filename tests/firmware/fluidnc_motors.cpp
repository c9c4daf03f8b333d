/* fluidnc_motors.cpp: the pins and timers of FluidNC's native build, joined to `motors.h`.
 *
 * It takes the place of FluidNC/capture/gpio.cpp, StepTimer.cpp and timing.cpp, which do nothing,
 * tick at 1 MHz and count calls. The firmware itself stays as it is; docs/background/testing.md has
 * the commands. The configuration (`native.py`) has to use these pins: axis i steps with pin 2i and
 * turns with 2i + 1; 12 + i is its limit switch; 18 takes the current off all motors.
 */
#include <time.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "Driver/StepTimer.h"
#include "Driver/delay_usecs.h"
#include "Driver/fluidnc_gpio.h"
#include "Protocol.h"

#include "motors.h"

namespace {

constexpr int AXES = 6;
constexpr int LIMIT_PIN = 12, DISABLE_PIN = 18, PINS = 64;
constexpr uint32_t TICK_NS = 50; /* the step timer of an ESP32: 20 MHz, FluidNC/esp32/StepTimer.cpp */
constexpr uint64_t LATE_NS = 100'000'000; /* later than this, pulses are no longer caught up */

uint64_t wall_ns() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return uint64_t(now.tv_sec) * 1'000'000'000u + uint64_t(now.tv_nsec);
}

const uint64_t began_ns = wall_ns();

uint64_t time_ns() { return wall_ns() - began_ns; }

bool level[PINS];
const bool reports_steps = motors_open();

struct Input {
  void* pin; /* as the firmware knows it */
  bool watched, inverted, told;
};
Input inputs[PINS];

} /* namespace */

/* --- Driver/fluidnc_gpio.h ---------------------------------------------------------------------- */

void gpio_write(pinnum_t pin, bool value) {
  if (pin < 0 || pin >= PINS || level[pin] == value) return;
  level[pin] = value;
  if (!reports_steps) return;
  if (pin < 2 * AXES && pin % 2 == 0 && value)
    motors_step(pin / 2, level[pin + 1] ? -1 : 1, time_ns());
  if (pin == DISABLE_PIN) motors_enable(value ? 0 : (1u << AXES) - 1);
}

bool gpio_read(pinnum_t pin) {
  if (pin < LIMIT_PIN || pin >= LIMIT_PIN + AXES || !reports_steps) return false;
  return motors_pressed() >> (pin - LIMIT_PIN) & 1;
}

void gpio_mode(pinnum_t pin, bool, bool output, bool, bool, bool) {
  /* the firmware only writes a level that differs from its own idea, which is low at first */
  if (pin == DISABLE_PIN && output && reports_steps && !level[pin])
    motors_enable((1u << AXES) - 1);
}

void gpio_drive_strength(pinnum_t, uint8_t) {}
void gpio_route(pinnum_t, uint32_t) {}

void gpio_set_event(int32_t pin, void* arg, bool inverted) {
  bool active = gpio_read(pinnum_t(pin)) != inverted;
  inputs[pin] = {arg, true, inverted, !active}; /* so that the first poll tells the state */
}

void gpio_clear_event(int32_t pin) { inputs[pin].watched = false; }
void gpio_disarm(int32_t pin) { inputs[pin].watched = false; }

void gpio_rearm(int32_t pin) {
  Input& input = inputs[pin];
  if (input.watched || !input.pin) return;
  input.watched = true;
  if (gpio_read(pinnum_t(pin)) == input.inverted) {
    input.told = false;
    protocol_send_event(&pinInactiveEvent, input.pin);
  }
}

/* The firmware's polling task calls it about once a millisecond. */
void poll_gpios() {
  if (reports_steps) motors_clock(time_ns());
  for (int pin = 0; pin < PINS; pin++) {
    Input& input = inputs[pin];
    if (!input.watched) continue;
    bool active = gpio_read(pinnum_t(pin)) != input.inverted;
    if (active == input.told) continue;
    input.told = active;
    protocol_send_event(active ? &pinActiveEvent : &pinInactiveEvent, input.pin);
  }
}

/* --- Driver/StepTimer.h: an interrupt becomes a thread that sleeps until the next pulse ---------- */

namespace {

bool (*pulse)(void);
std::mutex guard;
std::condition_variable started;
bool running;
uint32_t ticks = 1;

void run_timer() {
  prctl(PR_SET_TIMERSLACK, 1);
  uint64_t next_ns = wall_ns();
  for (;;) {
    {
      std::unique_lock<std::mutex> lock(guard);
      if (!running) {
        started.wait(lock, [] { return running; });
        next_ns = wall_ns();
      }
      next_ns += uint64_t(ticks) * TICK_NS;
    }
    uint64_t now_ns = wall_ns();
    if (now_ns > next_ns + LATE_NS) next_ns = now_ns;
    timespec until = {time_t(next_ns / 1'000'000'000u), long(next_ns % 1'000'000'000u)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr)) {
    }
    bool more = pulse();
    std::lock_guard<std::mutex> lock(guard);
    running = running && more;
  }
}

} /* namespace */

uint32_t stepTimerInit(bool (*callback)(void)) {
  pulse = callback;
  std::thread(run_timer).detach();
  return 1'000'000'000u / TICK_NS;
}

void stepTimerSetTicks(uint32_t count) { ticks = count; }

void stepTimerStart() {
  std::lock_guard<std::mutex> lock(guard);
  ticks = 1;
  running = true;
  started.notify_one();
}

void stepTimerStop() {
  std::lock_guard<std::mutex> lock(guard);
  running = false;
}

void stepTimerShutdown() {}

/* --- Driver/delay_usecs.h: a tick of the processor's clock is a microsecond ---------------------- */

uint32_t ticks_per_us = 1;

void timing_init() {}
int32_t getCpuTicks() { return int32_t(uint32_t(time_ns() / 1000)); }
int32_t usToCpuTicks(int32_t us) { return us; }
int32_t usToEndTicks(int32_t us) { return getCpuTicks() + us; }

/* It waits for microseconds. On a busy computer, a thread that yields waits behind all others. */
void spinUntil(int32_t end) {
  while (int32_t(uint32_t(getCpuTicks()) - uint32_t(end)) < 0) {
  }
}

void delay_us(int32_t us) { spinUntil(usToEndTicks(us)); }
