/* avrdev: an AVR firmware image as a serial device with motors attached.
 *
 * The image runs under libsimavr. Its UART 0 (or native USB) is a pseudo-terminal, its step and
 * direction pins (or coils) turn motors whose positions are counted here, and its limit switches
 * close at positions.
 * A UDP port on the loopback interface answers questions and makes things go wrong: bytes are lost,
 * the cable is pulled, the power fails, motors lose steps.
 *
 *   avrdev IMAGE.elf --mcu atmega2560 --tty PATH [--axis X:step=F0,dir=F1,limit=E5,enable=D7]...
 *
 * Once the device is there, one line is printed: "ready TTY CONTROL_PORT". See `usage` for all
 * options and `commands` for what the control port understands.
 *
 * Time is the simulated processor's. The main loop keeps it at the pace of the wall clock; where
 * the computer is too slow for that, `stat` tells it (run_s, sim_s, given_up_s), because a motion
 * that was measured then means little.
 *
 * cc -O2 -o avrdev avrdev.c $(pkg-config --cflags --libs simavr) -lelf -lutil
 */
#define _GNU_SOURCE

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "avr_eeprom.h"
#include "avr_ioport.h"
#include "avr_uart.h"
#include "avr_usb.h"
#include "sim_avr.h"
#include "sim_elf.h"
#include "sim_irq.h"

#define NS_PER_S 1000000000ull
#define NS_PER_MS 1000000ull
#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

/* The simulated processor runs for this long between two looks at the host. */
#define SLICE_S 0.001

/* ------------------------------------------------------------------------------------------------
 * Options and state
 * --------------------------------------------------------------------------------------------- */

static const char usage[] =
    "usage: avrdev IMAGE.elf [options]\n"
    "  --mcu NAME            the processor (atmega328p)\n"
    "  --hz N                its clock (16000000)\n"
    "  --tty PATH            a symbolic link to the pseudo-terminal (ttyAVR)\n"
    "  --control PORT        the UDP port on 127.0.0.1; 0 takes any that is free (0)\n"
    "  --eeprom FILE         keep the EEPROM in a file\n"
    "  --step-log FILE       write every step: cycle,axis,direction,position\n"
    "  --axis NAME:step=PIN,dir=PIN[,limit=PIN][,enable=PIN]\n"
    "                        a motor on a step and direction driver; PIN is F0, D7 ...\n"
    "  --coil-bus strobe=PIN,edge=rise|fall,address=PINS,coils=PINS,turn=A+B+C+D,off=N\n"
    "                        latches of coil patterns; PINS is D2+D3 ..., the lowest bit first\n"
    "  --coil NAME:ADDRESS   a motor on the coil bus\n"
    "  --no-reset-on-open    opening the port does not reset the processor\n"
    "  --boot-ms N           a boot loader that eats bytes this long after a reset (0)\n"
    "  --native-usb          the port is the processor's own USB, which Arduino's core drives\n"
    "  --usb-ms N            the device's bytes reach the host in packets this far apart (1)\n"
    "  --catch-up-ms N       a longer delay of the computer is given up, not caught up (500)\n"
    "  --until-eof           end when standard input ends\n";

static struct {
  const char *image, *mcu, *tty, *eeprom, *step_log;
  uint32_t hz;
  int control_port, boot_ms, usb_ms, catch_up_ms;
  bool reset_on_open, until_eof, native_usb;
} option = {
    .mcu = "atmega328p",
    .tty = "ttyAVR",
    .hz = 16000000,
    .usb_ms = 1,
    .catch_up_ms = 500,
    .reset_on_open = true,
};

static avr_t *avr;
static volatile sig_atomic_t quitting;

static struct {
  uint64_t from_host, to_host, overruns, lost, changed, resets;
} count;

__attribute__((noreturn, format(printf, 1, 2))) static void die(const char *format, ...) {
  va_list words;
  va_start(words, format);
  fputs("avrdev: ", stderr);
  vfprintf(stderr, format, words);
  fputc('\n', stderr);
  va_end(words);
  exit(1);
}

static uint64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

/* ------------------------------------------------------------------------------------------------
 * Pace: simulated time beside the wall clock
 * --------------------------------------------------------------------------------------------- */

static struct {
  uint64_t wall_ns, cycle; /* where the two clocks agreed last */
  uint64_t held_until_ns;  /* without power, or in the boot loader */
  bool frozen;
  double run_s;      /* wall time for which the processor should have been running */
  double given_up_s; /* delays that were too long to be caught up */
  uint64_t cycles_before_reset;
} pace;

/* simavr begins to count cycles anew at each reset; the step log and `stat` do not. */
static uint64_t total_cycles(void) { return pace.cycles_before_reset + avr->cycle; }

static void agree_on_time(uint64_t wall_ns) {
  pace.wall_ns = wall_ns;
  pace.cycle = total_cycles();
}

static bool held(uint64_t wall_ns) { return pace.frozen || wall_ns < pace.held_until_ns; }

/* Sleep until the wall clock has caught up with the processor. */
static void keep_pace(void) {
  uint64_t ran_ns = (uint64_t)((double)(total_cycles() - pace.cycle) * 1e9 / option.hz);
  uint64_t due_ns = pace.wall_ns + ran_ns, wall_ns = now_ns();
  if (due_ns > wall_ns) {
    struct timespec rest = {0, (long)(due_ns - wall_ns)};
    nanosleep(&rest, NULL);
  } else if (wall_ns - due_ns > (uint64_t)option.catch_up_ms * NS_PER_MS) {
    /* Running at full speed for long after a long delay would squeeze the firmware's time. */
    pace.given_up_s += (double)(wall_ns - due_ns) / 1e9;
    agree_on_time(wall_ns);
  }
}

/* ------------------------------------------------------------------------------------------------
 * Motors: step and direction pins, coils, limit switches
 * --------------------------------------------------------------------------------------------- */

typedef struct {
  char port; /* 0: not connected */
  int bit;
} pin_t;

typedef struct {
  char name;
  pin_t step, dir, limit, enable;
  int coil_address; /* -1: a step and direction driver */
  int coil_phase;   /* which of the four full-step patterns the coils show */
  bool coil_on;

  int64_t position, steps;
  uint64_t last_cycle, shortest_interval;
  int64_t skips; /* coil patterns two phases ahead: no motor could follow */

  int64_t switch_at; /* the limit switch closes here, on the side of switch_sign; 0: never */
  int switch_sign;
  int switch_forced; /* 0 or 1: sticks open or closed; -1: follows the position */
  int switch_closed; /* as the processor was told last; -1: not told yet */

  int64_t to_lose; /* the next steps do not turn the motor */
  bool stalled;
} axis_t;

static axis_t axes[8];
static int axis_count;
static FILE *step_log;

static axis_t *axis_named(char name) {
  for (int i = 0; i < axis_count; i++)
    if (axes[i].name == name) return &axes[i];
  return NULL;
}

static avr_irq_t *pin_irq(pin_t pin) {
  return avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(pin.port), pin.bit);
}

static avr_ioport_state_t port_state(char port) {
  avr_ioport_state_t state;
  memset(&state, 0, sizeof state);
  avr_ioctl(avr, AVR_IOCTL_IOPORT_GETSTATE(port), &state);
  return state;
}

/* What is wired to each input, a bit for each pin: pull-ups, until a switch closes. simavr restores
 * these levels whenever the firmware writes to the port, so that it has to know them as well. */
static uint8_t wired[128];

static void set_input(pin_t pin, bool level) {
  uint8_t bit = (uint8_t)(1 << pin.bit), *levels = &wired[(int)pin.port];
  *levels = (uint8_t)(level ? *levels | bit : *levels & ~bit);
  avr_ioport_external_t external = {.name = pin.port, .mask = 0xff, .value = *levels};
  avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(pin.port), &external);
  if (!(port_state(pin.port).ddr & bit)) avr_raise_irq(pin_irq(pin), level);
}

static bool driven_high(pin_t pin) { return port_state(pin.port).port >> pin.bit & 1; }

/* A driver is on while its enable input is low, as is every input that nothing drives. */
static bool energised(const axis_t *axis) {
  if (axis->coil_address >= 0) return axis->coil_on;
  if (!axis->enable.port) return true;
  avr_ioport_state_t state = port_state(axis->enable.port);
  return !(state.ddr & state.port & 1 << axis->enable.bit);
}

/* Close or open the limit switch, which pulls its input to ground. */
static void update_switch(axis_t *axis) {
  if (!axis->limit.port) return;
  int64_t beyond = (axis->position - axis->switch_at) * axis->switch_sign;
  bool reached = axis->switch_sign && beyond >= 0;
  int closed = axis->switch_forced >= 0 ? axis->switch_forced : reached;
  if (closed == axis->switch_closed) return;
  axis->switch_closed = closed;
  set_input(axis->limit, !closed);
}

static void take_step(axis_t *axis, int direction) {
  uint64_t cycle = total_cycles(), interval = cycle - axis->last_cycle;
  if (axis->steps && interval < axis->shortest_interval) axis->shortest_interval = interval;
  axis->last_cycle = cycle;
  axis->steps++;
  if (axis->to_lose > 0) {
    axis->to_lose--;
  } else if (!axis->stalled) {
    axis->position += direction;
  }
  if (step_log)
    fprintf(step_log, "%llu,%c,%d,%lld\n", (unsigned long long)cycle, axis->name, direction,
            (long long)axis->position);
  update_switch(axis);
}

static bool applying_inputs;

static void on_step_pin(avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq;
  axis_t *axis = param;
  if (value & 1 && !applying_inputs) take_step(axis, driven_high(axis->dir) ? -1 : 1);
}

/* A bus with a latch for each motor: at one edge of the strobe, the latch with the address on the
 * bus takes the pattern on the bus as the coils of its motor, and keeps it through a reset. */
typedef struct {
  pin_t strobe, address[4], coils[4];
  int address_bits, coil_bits;
  bool latches_on_rise;
  int turn[4]; /* the patterns in the order of a positive turn */
  int off;     /* the pattern without current */
} coil_bus_t;

static coil_bus_t coil_bus;

static int number_on(const pin_t *pins, int bits) {
  int number = 0;
  for (int bit = 0; bit < bits; bit++) number |= driven_high(pins[bit]) << bit;
  return number;
}

static void on_coil_strobe(avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)param;
  bool high = value & 1;
  if (applying_inputs || high != coil_bus.latches_on_rise || high != driven_high(coil_bus.strobe))
    return;
  int address = number_on(coil_bus.address, coil_bus.address_bits);
  int pattern = number_on(coil_bus.coils, coil_bus.coil_bits);
  for (int i = 0; i < axis_count; i++) {
    axis_t *axis = &axes[i];
    if (axis->coil_address != address) continue;
    axis->coil_on = pattern != coil_bus.off;
    for (int phase = 0; phase < 4; phase++) {
      if (pattern != coil_bus.turn[phase]) continue;
      int turn = (phase - axis->coil_phase) & 3;
      axis->coil_phase = phase;
      if (turn == 2) axis->skips++;
      if (turn == 1 || turn == 3) take_step(axis, turn == 1 ? 1 : -1);
    }
  }
}

/* ------------------------------------------------------------------------------------------------
 * Where simavr differs from the real processor
 * --------------------------------------------------------------------------------------------- */

/* Data addresses of registers; the ATmega328P and the ATmega2560 have them in the same places. */
enum { EECR = 0x3f, EEDR = 0x40, EEARL = 0x41, TCCR0B = 0x45, TCNT0 = 0x46, ACSR = 0x50, OCR1AL = 0x88 };

/* simavr clears PINx at each reset: inputs have to read again what is wired to them. An IRQ that
 * does not change is not passed on, hence both levels. */
static void apply_inputs(void) {
  applying_inputs = true;
  for (const char *port = "ABCDEFGHJKL"; *port; port++)
    for (int bit = 0; bit < 8; bit++) {
      pin_t pin = {*port, bit};
      bool level = wired[(int)*port] >> bit & 1;
      if (!pin_irq(pin)) continue;
      avr_raise_irq(pin_irq(pin), !level);
      set_input(pin, level);
    }
  applying_inputs = false;
}

/* A timer that clears on a compare value of 0 matches at every clock, so that GRBL's first stepper
 * interrupt comes at once. simavr schedules nothing for that value: begin with another one. The
 * analog comparator, which no firmware here uses, is switched off because it costs time. */
static uint8_t timer0_control;

static void preset_registers(void) {
  timer0_control = 0;
  avr->data[ACSR] |= 0x80;
  avr->data[OCR1AL] = 0xff;
  avr->data[OCR1AL + 1] = 0;
}

/* simavr ignores a count that is written into a stopped timer. GRBL does that for its step pulse,
 * which would last 2048 cycles and merge with the next one: write the count when it starts. */
static void on_timer0_control(avr_t *mcu, avr_io_addr_t address, uint8_t value, void *param) {
  (void)address, (void)param;
  bool starts = (value & 7) && !(timer0_control & 7);
  timer0_control = value;
  if (!starts) return;
  unsigned io = AVR_DATA_TO_IO(TCNT0);
  if (mcu->io[io].w.c) mcu->io[io].w.c(mcu, TCNT0, mcu->data[TCNT0], mcu->io[io].w.param);
}

/* GRBL erases a byte of the EEPROM where it wants 0xff; simavr writes the data register instead,
 * before or after this is called: make it 0xff, and the byte as well. */
static void on_eeprom_control(avr_t *mcu, avr_io_addr_t address, uint8_t value, void *param) {
  (void)address, (void)param;
  enum { EEPE = 1 << 1, EEMPE = 1 << 2, EEPM0 = 1 << 4, EEPM1 = 1 << 5 };
  bool erases = (value & (EEPM0 | EEPM1)) == EEPM0;
  if (!erases || !(value & (EEMPE | EEPE))) return;
  mcu->data[EEDR] = 0xff;
  uint32_t at = mcu->data[EEARL] | (uint32_t)mcu->data[EEARL + 1] << 8;
  avr_eeprom_desc_t byte = {.ee = &mcu->data[EEDR], .offset = at, .size = 1};
  if (value & EEPE) avr_ioctl(mcu, AVR_IOCTL_EEPROM_SET, &byte);
}

/* ------------------------------------------------------------------------------------------------
 * The serial line: bytes at the pace of the wire, and what becomes of them on the way
 * --------------------------------------------------------------------------------------------- */

enum side { HOST, DEVICE, SIDES }; /* who speaks */
enum effect { LOSE, FLIP, REPEAT, DELAY };
enum amount { NEXT_MESSAGE, NTH_BYTE, FIRST_BYTES, SHARE };

#define MOST_RULES 64
#define MOST_LATE 64
#define MOST_MESSAGE 4096

/* One fault on one direction of the line. A message is what is read or sent at once. */
typedef struct {
  enum effect effect;
  enum amount amount;
  long number;  /* of the byte, or how many bytes are left */
  double share; /* of the bytes */
  uint64_t delay_ns, until_ns;
  bool spent;
} rule_t;

typedef struct {
  uint64_t due_ns;
  size_t length;
  uint8_t bytes[MOST_MESSAGE];
} late_t;

static struct {
  rule_t rules[MOST_RULES];
  int rule_count;
  late_t late[MOST_LATE];
  int late_count;
} wire[SIDES];

/* To the processor: the USB adapter's buffer. To the host: what waits for the pseudo-terminal. */
static struct {
  uint8_t bytes[65536];
  size_t read, written;
} to_device;
static uint8_t to_host[65536], spoken[MOST_MESSAGE];
static size_t to_host_length, spoken_length;

static avr_uart_t *uart;
static avr_irq_t *uart_input;

static size_t backlog(void) { return to_device.written - to_device.read; }

static void deliver(enum side side, const uint8_t *bytes, size_t length) {
  for (size_t i = 0; i < length; i++) {
    if (side == HOST)
      to_device.bytes[to_device.written++ % sizeof to_device.bytes] = bytes[i];
    else if (to_host_length < sizeof to_host)
      to_host[to_host_length++] = bytes[i];
  }
}

static bool strikes(rule_t *rule) {
  switch (rule->amount) {
    case NEXT_MESSAGE:
      return true;
    case NTH_BYTE:
      if (rule->spent || --rule->number > 0) return false;
      return rule->spent = true;
    case FIRST_BYTES:
      if (rule->spent) return false;
      rule->spent = --rule->number <= 0;
      return true;
    case SHARE:
      return drand48() < rule->share;
  }
  return false;
}

/* Apply one fault to a message in place; return its new length. */
static size_t apply_rule(rule_t *rule, uint8_t *bytes, size_t length, uint64_t *delay_ns) {
  static uint8_t changed[2 * MOST_MESSAGE];
  size_t made = 0, chosen = (size_t)(drand48() * (double)length);
  bool any = false;
  for (size_t i = 0; i < length && made < MOST_MESSAGE - 1; i++) {
    bool struck = strikes(rule);
    any |= struck;
    uint8_t byte = bytes[i];
    /* of a message that is changed as a whole, one byte is */
    if (struck && rule->effect == FLIP && (rule->amount != NEXT_MESSAGE || i == chosen)) {
      byte ^= (uint8_t)(1 << (int)(drand48() * 8));
      count.changed++;
    }
    if (struck && rule->effect == LOSE) {
      count.lost++;
      continue;
    }
    changed[made++] = byte;
    if (struck && rule->effect == REPEAT && rule->amount != NEXT_MESSAGE) changed[made++] = byte;
  }
  if (rule->effect == REPEAT && rule->amount == NEXT_MESSAGE && 2 * made < MOST_MESSAGE) {
    memcpy(changed + made, changed, made);
    made *= 2;
  }
  if (rule->effect == DELAY && any) *delay_ns += rule->delay_ns;
  if (rule->amount == NEXT_MESSAGE) rule->spent = true;
  memcpy(bytes, changed, made);
  return made;
}

/* Let a message pass the wire; what is behind a late message waits for it. */
static void pass(enum side side, uint8_t *bytes, size_t length) {
  uint64_t wall_ns = now_ns(), delay_ns = 0;
  int kept = 0;
  for (int i = 0; i < wire[side].rule_count; i++) {
    rule_t *rule = &wire[side].rules[i];
    if (rule->until_ns && wall_ns >= rule->until_ns) continue;
    if (length) length = apply_rule(rule, bytes, length, &delay_ns);
    if (!rule->spent) wire[side].rules[kept++] = *rule;
  }
  wire[side].rule_count = kept;
  if (!length) return;
  if (!delay_ns && !wire[side].late_count) {
    deliver(side, bytes, length);
  } else if (wire[side].late_count < MOST_LATE) {
    late_t *late = &wire[side].late[wire[side].late_count];
    late->due_ns = wall_ns + delay_ns;
    if (wire[side].late_count && late->due_ns < late[-1].due_ns) late->due_ns = late[-1].due_ns;
    late->length = length;
    memcpy(late->bytes, bytes, length);
    wire[side].late_count++;
  } else {
    count.lost += length;
  }
}

static void deliver_late(uint64_t wall_ns) {
  for (int side = 0; side < SIDES; side++)
    while (wire[side].late_count && wire[side].late[0].due_ns <= wall_ns) {
      deliver(side, wire[side].late[0].bytes, wire[side].late[0].length);
      wire[side].late_count--;
      memmove(wire[side].late, wire[side].late + 1, (size_t)wire[side].late_count * sizeof(late_t));
    }
}

static void forget_bytes(void) {
  to_device.read = to_device.written;
  spoken_length = 0;
}

/* Hand the processor one byte per byte time. */
static avr_cycle_count_t on_byte_time(avr_t *mcu, avr_cycle_count_t when, void *param) {
  (void)mcu, (void)param;
  /* simavr takes 8N1 for 11 bits a byte */
  if (uart->cycles_per_byte && uart->cycles_per_byte % 11 == 0)
    uart->cycles_per_byte = uart->cycles_per_byte / 11 * 10;
  avr_cycle_count_t byte_cycles = uart->cycles_per_byte;
  if (!byte_cycles) byte_cycles = option.hz / 11520; /* not set up yet */
  if (backlog()) {
    uint8_t byte = to_device.bytes[to_device.read++ % sizeof to_device.bytes];
    count.from_host++;
    /* The hardware holds two bytes and the one that arrives; simavr's own buffer is longer. */
    if (((uart->input.write - uart->input.read) & 63) >= 3)
      count.overruns++;
    else
      avr_raise_irq(uart_input, byte);
  }
  return when + byte_cycles;
}

/* ------------------------------------------------------------------------------------------------
 * Native USB: a host that configures a serial device, and moves a packet each way per frame
 * --------------------------------------------------------------------------------------------- */

/* Endpoints of Arduino's core; registers as distances from USBCON. */
enum { CDC_RX = 2, CDC_TX = 3, PACKET_BYTES = 64, UDCON = 8, UDINT = 9, UDIEN = 10, SOF = 1 << 2 };
enum { SET_CONFIGURATION = 9, SET_CONTROL_LINE_STATE = 0x22, DTR_AND_RTS = 3 };
enum { RESET_FRAME = 2, CONFIGURE_FRAME = 4, READY_FRAME = 6 };

static avr_usb_t *usb;
static int usb_frame, usb_lines; /* since it was attached; as the device was told last */
static bool host_listens;

static int usb_request(uint8_t type, uint8_t request, uint8_t value) {
  uint8_t setup[8] = {type, request, value};
  struct avr_io_usb packet = {.pipe = 0, .sz = sizeof setup, .buf = setup};
  return avr_ioctl(avr, AVR_IOCTL_USB_SETUP, &packet);
}

static void usb_exchange(void) {
  uint8_t bytes[PACKET_BYTES];
  size_t length = 0;
  while (length < backlog() && length < sizeof bytes - 1) {
    bytes[length] = to_device.bytes[(to_device.read + length) % sizeof to_device.bytes];
    length++;
  }
  struct avr_io_usb out = {.pipe = CDC_RX, .sz = (uint32_t)length, .buf = bytes};
  if (length && avr_ioctl(avr, AVR_IOCTL_USB_WRITE, &out) == 0) {
    to_device.read += length;
    count.from_host += length;
  }
  struct avr_io_usb in = {.pipe = CDC_TX, .sz = 0, .buf = bytes};
  if (avr_ioctl(avr, AVR_IOCTL_USB_READ, &in) != 0) return;
  for (uint32_t i = 0; i < in.sz && spoken_length < sizeof spoken; i++) {
    spoken[spoken_length++] = bytes[i];
    count.to_host++;
  }
}

/* simavr has no start of frame, at which the device hands over what it has written. */
static void start_frame(void) {
  avr->data[usb->r_usbcon + UDINT] |= SOF;
  if (!(avr->data[usb->r_usbcon + UDIEN] & SOF)) return;
  for (int i = 0; i < avr->interrupts.vector_count; i++)
    if (avr->interrupts.vector[i]->vector == usb->usb_gen_vect)
      avr_raise_interrupt(avr, avr->interrupts.vector[i]);
}

static avr_cycle_count_t on_usb_frame(avr_t *mcu, avr_cycle_count_t when, void *param) {
  (void)param;
  int lines = host_listens ? DTR_AND_RTS : 0;
  if (mcu->data[usb->r_usbcon + UDCON] & 1) {
    usb_frame = usb_lines = 0; /* detached */
  } else if (++usb_frame == RESET_FRAME) {
    avr_ioctl(mcu, AVR_IOCTL_USB_RESET, NULL);
  } else if (usb_frame == CONFIGURE_FRAME) {
    usb_request(0, SET_CONFIGURATION, 1);
  } else if (usb_frame > READY_FRAME) {
    usb_frame = READY_FRAME;
    if (lines == usb_lines) {
      usb_exchange();
    } else if (usb_request(0x21, SET_CONTROL_LINE_STATE, (uint8_t)lines) == 0) {
      usb_lines = lines;
    }
    start_frame();
  }
  return when + mcu->frequency / 1000;
}

static void on_uart_output(avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)param;
  count.to_host++;
  if (spoken_length < sizeof spoken) spoken[spoken_length++] = (uint8_t)value;
}

/* ------------------------------------------------------------------------------------------------
 * Reset and power
 * --------------------------------------------------------------------------------------------- */

static void reset(const char *why, uint64_t without_power_ms) {
  fprintf(stderr, "avrdev: reset: %s\n", why);
  count.resets++;
  pace.cycles_before_reset += avr->cycle;
  avr_reset(avr);
  pace.cycles_before_reset -= avr->cycle; /* some versions of simavr do not begin at 0 */
  forget_bytes();
  preset_registers();
  apply_inputs();
  uint64_t hold_ms = without_power_ms + (uint64_t)option.boot_ms;
  pace.held_until_ns = now_ns() + hold_ms * NS_PER_MS;
}

/* ------------------------------------------------------------------------------------------------
 * The pseudo-terminal
 * --------------------------------------------------------------------------------------------- */

static int tty_fd = -1;
static bool nobody_listens = true;
static uint64_t unplugged_until_ns;
static char tty_path[512];

static void open_tty(void) {
  int other_end;
  char name[128];
  struct termios mode;
  if (openpty(&tty_fd, &other_end, name, NULL, NULL)) die("openpty: %s", strerror(errno));
  tcgetattr(other_end, &mode);
  cfmakeraw(&mode);
  tcsetattr(other_end, TCSANOW, &mode);
  close(other_end);
  fcntl(tty_fd, F_SETFL, O_NONBLOCK);
  unlink(tty_path);
  if (symlink(name, tty_path)) die("%s: %s", tty_path, strerror(errno));
  nobody_listens = true;
  host_listens = false;
}

static void unplug(uint64_t until_ns) {
  if (tty_fd >= 0) close(tty_fd);
  tty_fd = -1;
  unlink(tty_path);
  forget_bytes();
  to_host_length = 0;
  for (int side = 0; side < SIDES; side++) wire[side].late_count = 0;
  unplugged_until_ns = until_ns;
}

static void read_host(void) {
  uint8_t bytes[MOST_MESSAGE];
  if (backlog() >= 256) return; /* a USB adapter's buffer: the rest waits in the computer */
  ssize_t length = read(tty_fd, bytes, 256);
  if (length > 0) pass(HOST, bytes, (size_t)length);
}

static void exchange_with_host(uint64_t wall_ns) {
  static uint64_t sent_ns;
  if (tty_fd < 0) {
    spoken_length = 0; /* into the void */
    if (wall_ns < unplugged_until_ns) return;
    open_tty();
    if (option.reset_on_open || usb) reset("plugged in", 0); /* native USB supplies the board */
  }
  struct pollfd events = {tty_fd, POLLIN, 0};
  poll(&events, 1, 0);
  if (events.revents & POLLHUP) {
    uint8_t nobodys[256];
    while (read(tty_fd, nobodys, sizeof nobodys) > 0) {
    }
    nobody_listens = true;
    host_listens = false;
    spoken_length = to_host_length = 0;
    return;
  }
  if (nobody_listens) {
    nobody_listens = false;
    host_listens = true;
    if (option.reset_on_open) reset("the port was opened", 0);
  }
  if (events.revents & POLLIN) read_host();
  if (spoken_length && wall_ns - sent_ns >= (uint64_t)option.usb_ms * NS_PER_MS) {
    pass(DEVICE, spoken, spoken_length);
    spoken_length = 0;
    sent_ns = wall_ns;
  }
  deliver_late(wall_ns);
  if (!to_host_length) return;
  ssize_t written = write(tty_fd, to_host, to_host_length);
  if (written > 0) {
    to_host_length -= (size_t)written;
    memmove(to_host, to_host + written, to_host_length);
  }
}

/* ------------------------------------------------------------------------------------------------
 * The control port: one command in a datagram, one answer in another
 * --------------------------------------------------------------------------------------------- */

static int control_fd = -1;
static char answer[4096];
static size_t answer_length;

__attribute__((format(printf, 1, 2))) static void say(const char *format, ...) {
  va_list words;
  va_start(words, format);
  int length = vsnprintf(answer + answer_length, sizeof answer - answer_length, format, words);
  va_end(words);
  if (length > 0) answer_length += (size_t)length;
  if (answer_length >= sizeof answer) answer_length = sizeof answer - 1;
}

static void refuse(const char *why) {
  answer_length = 0;
  say("error: %s", why);
}

static void tell_state(const char *words) {
  (void)words;
  uint64_t wall_ns = now_ns();
  say("{\"cycle\": %llu, \"hz\": %u, \"wall_s\": %.6f", (unsigned long long)total_cycles(),
      option.hz, (double)wall_ns / 1e9);
  say(", \"run_s\": %.4f, \"sim_s\": %.4f, \"given_up_s\": %.4f", pace.run_s,
      (double)total_cycles() / option.hz, pace.given_up_s);
  say(", \"powered\": %s", held(wall_ns) && !pace.frozen ? "false" : "true");
  say(", \"from_host\": %llu, \"to_host\": %llu, \"overruns\": %llu, \"lost\": %llu"
      ", \"changed\": %llu, \"resets\": %llu, \"axes\": {",
      (unsigned long long)count.from_host, (unsigned long long)count.to_host,
      (unsigned long long)count.overruns, (unsigned long long)count.lost,
      (unsigned long long)count.changed, (unsigned long long)count.resets);
  for (int i = 0; i < axis_count; i++) {
    axis_t *axis = &axes[i];
    double shortest_us = 0;
    if (axis->shortest_interval != UINT64_MAX)
      shortest_us = (double)axis->shortest_interval * 1e6 / option.hz;
    say("%s\"%c\": {\"pos\": %lld, \"steps\": %lld, \"skips\": %lld, \"shortest_us\": %.1f"
        ", \"switch\": %d, \"on\": %s}",
        i ? ", " : "", axis->name, (long long)axis->position, (long long)axis->steps,
        (long long)axis->skips, shortest_us, axis->switch_closed == 1,
        energised(axis) ? "true" : "false");
  }
  say("}}");
}

static void add_rule(enum side side, rule_t rule) {
  if (wire[side].rule_count >= MOST_RULES) {
    refuse("too many faults on the line");
    return;
  }
  wire[side].rules[wire[side].rule_count++] = rule;
}

/* wire SIDE EFFECT AMOUNT [FOR_S [DELAY_S]]; AMOUNT is next, #N, or a share of the bytes. */
static void harm_wire(const char *words) {
  static const char *const effects[] = {"lose", "flip", "repeat", "delay"};
  char side[16] = "", effect[16] = "", amount[16] = "";
  double for_s = 0, delay_s = 0;
  if (sscanf(words, "%15s %15s %15s %lf %lf", side, effect, amount, &for_s, &delay_s) < 3) {
    refuse("wire host|device lose|flip|repeat|delay next|#N|SHARE [FOR_S [DELAY_S]]");
    return;
  }
  rule_t rule = {.amount = SHARE, .delay_ns = (uint64_t)(delay_s * 1e9)};
  if (for_s > 0) rule.until_ns = now_ns() + (uint64_t)(for_s * 1e9);
  size_t known = 0;
  while (known < LENGTH(effects) && strcmp(effect, effects[known])) known++;
  if (known == LENGTH(effects) || (strcmp(side, "host") && strcmp(side, "device"))) {
    refuse("no such side or effect");
    return;
  }
  rule.effect = (enum effect)known;
  if (!strcmp(amount, "next")) {
    rule.amount = NEXT_MESSAGE;
  } else if (amount[0] == '#') {
    rule.amount = NTH_BYTE;
    rule.number = atol(amount + 1);
  } else {
    rule.share = atof(amount);
  }
  add_rule(!strcmp(side, "host") ? HOST : DEVICE, rule);
}

static void harm_next_bytes(enum side side, enum effect effect, const char *words) {
  long number = atol(words);
  rule_t rule = {.effect = effect, .amount = FIRST_BYTES, .number = number};
  if (number > 0) add_rule(side, rule);
}

static void drop_rx(const char *words) { harm_next_bytes(HOST, LOSE, words); }
static void drop_tx(const char *words) { harm_next_bytes(DEVICE, LOSE, words); }
static void corrupt_rx(const char *words) { harm_next_bytes(HOST, FLIP, words); }

static void make_garbage(const char *words) {
  long number = atol(words);
  for (long i = 0; i < number; i++) {
    uint8_t byte = (uint8_t)(drand48() * 256);
    deliver(DEVICE, &byte, 1);
  }
}

static void command_reset(const char *words) {
  (void)words;
  reset("by command", 0);
}

static void brown_out(const char *words) {
  uint64_t ms = (uint64_t)atol(words);
  reset("the power fails", ms);
}

static void command_unplug(const char *words) {
  long ms = atol(words);
  unplug(ms > 0 ? now_ns() + (uint64_t)ms * NS_PER_MS : UINT64_MAX);
}

static void replug(const char *words) {
  char path[sizeof tty_path];
  if (tty_fd < 0) unplugged_until_ns = 0;
  if (tty_fd < 0 && sscanf(words, "%511s", path) == 1) memcpy(tty_path, path, sizeof tty_path);
}

static void freeze(const char *words) { pace.frozen = atol(words) != 0; }

/* NAME NUMBER pairs: call `act` for each axis. */
static void for_axes(const char *words, void (*act)(axis_t *, long)) {
  char name;
  long number;
  int read = 0;
  while (sscanf(words, " %c %ld%n", &name, &number, &read) == 2) {
    axis_t *axis = axis_named(name);
    if (!axis) {
      refuse("no such axis");
      return;
    }
    act(axis, number);
    update_switch(axis);
    words += read;
  }
}

static void place(axis_t *axis, long number) { axis->position = number; }
static void force_switch(axis_t *axis, long number) { axis->switch_forced = (int)number; }
static void lose_steps(axis_t *axis, long number) { axis->to_lose += number; }
static void stall(axis_t *axis, long number) { axis->stalled = number != 0; }

static void command_pos(const char *words) { for_axes(words, place); }
static void command_limit(const char *words) { for_axes(words, force_switch); }
static void command_lose(const char *words) { for_axes(words, lose_steps); }
static void command_stall(const char *words) { for_axes(words, stall); }

/* limit_at AXIS POSITION SIGN: the switch closes from a position on, upwards or downwards. */
static void limit_at(const char *words) {
  char name;
  long at;
  int sign;
  axis_t *axis = sscanf(words, " %c %ld %d", &name, &at, &sign) == 3 ? axis_named(name) : NULL;
  if (!axis) {
    refuse("limit_at AXIS POSITION 1|-1|0");
    return;
  }
  axis->switch_at = at;
  axis->switch_sign = sign;
  update_switch(axis);
}

/* pin A3 1: set the level of an input. */
static void set_pin(const char *words) {
  pin_t pin;
  int level;
  if (sscanf(words, " %c%d %d", &pin.port, &pin.bit, &level) == 3 && pin_irq(pin))
    set_input(pin, level);
  else
    refuse("pin PORT_AND_BIT LEVEL");
}

static void heal(const char *words) {
  (void)words;
  for (int side = 0; side < SIDES; side++) wire[side].rule_count = 0;
  pace.frozen = false;
  if (tty_fd < 0) unplugged_until_ns = 0;
  for (int i = 0; i < axis_count; i++) {
    axes[i].to_lose = 0;
    axes[i].stalled = false;
    axes[i].switch_forced = -1;
    update_switch(&axes[i]);
  }
}

static void flush_log(const char *words) {
  (void)words;
  if (step_log) fflush(step_log);
}

static void seed(const char *words) { srand48(atol(words)); }

static void quit(const char *words) {
  (void)words;
  quitting = 1;
}

static const struct {
  const char *name;
  void (*run)(const char *words);
  const char *does;
} commands[] = {
    {"stat", tell_state, "tell positions, clocks and counts, as JSON"},
    {"wire", harm_wire, "SIDE EFFECT AMOUNT [FOR_S [DELAY_S]]: a fault on the line"},
    {"drop_rx", drop_rx, "N: lose the next bytes to the device"},
    {"drop_tx", drop_tx, "N: lose the next bytes from the device"},
    {"corrupt_rx", corrupt_rx, "N: change a bit in each of the next bytes to the device"},
    {"garbage", make_garbage, "N: noise from the device"},
    {"reset", command_reset, "reset the processor"},
    {"brown_out", brown_out, "MS: reset it, and leave it without power"},
    {"unplug", command_unplug, "MS: pull the cable; 0: until replug"},
    {"replug", replug, "[PATH]: put the cable back, under another name perhaps"},
    {"freeze", freeze, "1|0: stop the processor, and let it go on"},
    {"pos", command_pos, "AXIS N ...: say where motors stand"},
    {"lose", command_lose, "AXIS N ...: motors lose their next steps"},
    {"stall", command_stall, "AXIS 1|0 ...: motors do not turn"},
    {"limit", command_limit, "AXIS 1|0|-1 ...: a switch sticks closed or open, or works again"},
    {"limit_at", limit_at, "AXIS POSITION SIGN: where a switch closes"},
    {"pin", set_pin, "PIN LEVEL: set an input"},
    {"heal", heal, "undo all faults"},
    {"flush", flush_log, "write what is left of the step log"},
    {"seed", seed, "N: begin the chances anew"},
    {"quit", quit, "end"},
};

static void help(void) {
  for (size_t i = 0; i < LENGTH(commands); i++) say("%s %s\n", commands[i].name, commands[i].does);
}

static void answer_control(void) {
  char words[1024], name[32] = "";
  struct sockaddr_in asker;
  socklen_t size = sizeof asker;
  int skipped = 0;
  ssize_t length =
      recvfrom(control_fd, words, sizeof words - 1, MSG_DONTWAIT, (struct sockaddr *)&asker, &size);
  if (length <= 0) return;
  words[length] = 0;
  answer_length = 0;
  answer[0] = 0;
  sscanf(words, "%31s%n", name, &skipped);
  size_t known = 0;
  while (known < LENGTH(commands) && strcmp(name, commands[known].name)) known++;
  if (known < LENGTH(commands))
    commands[known].run(words + skipped);
  else
    help();
  if (!answer_length) say("ok");
  sendto(control_fd, answer, answer_length, 0, (struct sockaddr *)&asker, size);
}

/* Only programs on this computer can reach it: it asks nobody who they are. */
static int open_control(int port) {
  struct sockaddr_in address = {.sin_family = AF_INET,
                                .sin_port = htons((uint16_t)port),
                                .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  socklen_t size = sizeof address;
  control_fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (bind(control_fd, (struct sockaddr *)&address, size)) die("control: %s", strerror(errno));
  getsockname(control_fd, (struct sockaddr *)&address, &size);
  return ntohs(address.sin_port);
}

/* ------------------------------------------------------------------------------------------------
 * Start and main loop
 * --------------------------------------------------------------------------------------------- */

static pin_t parse_pin(const char *text) {
  pin_t pin;
  if (sscanf(text, "%c%d", &pin.port, &pin.bit) != 2 || pin.bit < 0 || pin.bit > 7)
    die("a pin is written F0, D7 and so on, not %s", text);
  return pin;
}

static axis_t *new_axis(const char *text) {
  if (axis_count == (int)LENGTH(axes) || !text[0] || text[1] != ':') die("bad axis %s", text);
  axis_t *axis = &axes[axis_count++];
  *axis = (axis_t){.name = text[0],
                   .coil_address = -1,
                   .shortest_interval = UINT64_MAX,
                   .switch_forced = -1,
                   .switch_closed = -1};
  return axis;
}

static void parse_axis(const char *text) {
  axis_t *axis = new_axis(text);
  char rest[128], *next = rest, *word;
  snprintf(rest, sizeof rest, "%s", text + 2);
  while ((word = strsep(&next, ","))) {
    char *value = strchr(word, '=');
    if (!value) die("bad axis %s", text);
    *value++ = 0;
    if (!strcmp(word, "step")) axis->step = parse_pin(value);
    else if (!strcmp(word, "dir")) axis->dir = parse_pin(value);
    else if (!strcmp(word, "limit")) axis->limit = parse_pin(value);
    else if (!strcmp(word, "enable")) axis->enable = parse_pin(value);
    else die("an axis has step, dir, limit and enable pins, not %s", word);
  }
  if (!axis->step.port || !axis->dir.port) die("axis %s needs a step and a dir pin", text);
}

static void parse_coil(const char *text) { new_axis(text)->coil_address = atoi(text + 2); }

static int parse_pins(char *text, pin_t *pins) {
  int count = 0;
  for (char *word; count < 4 && (word = strsep(&text, "+")); count++) pins[count] = parse_pin(word);
  return count;
}

static void parse_coil_bus(const char *text) {
  char rest[256], *next = rest, *word;
  int *turn = coil_bus.turn;
  snprintf(rest, sizeof rest, "%s", text);
  while ((word = strsep(&next, ","))) {
    char *value = strchr(word, '=');
    if (!value) die("bad coil bus %s", text);
    *value++ = 0;
    if (!strcmp(word, "strobe")) coil_bus.strobe = parse_pin(value);
    else if (!strcmp(word, "edge")) coil_bus.latches_on_rise = !strcmp(value, "rise");
    else if (!strcmp(word, "address")) coil_bus.address_bits = parse_pins(value, coil_bus.address);
    else if (!strcmp(word, "coils")) coil_bus.coil_bits = parse_pins(value, coil_bus.coils);
    else if (!strcmp(word, "off")) coil_bus.off = atoi(value);
    else if (strcmp(word, "turn") ||
             sscanf(value, "%d+%d+%d+%d", turn, turn + 1, turn + 2, turn + 3) != 4)
      die("a coil bus has strobe, edge, address, coils, turn and off, not %s", word);
  }
  if (!coil_bus.strobe.port || !coil_bus.address_bits || !coil_bus.coil_bits)
    die("a coil bus needs strobe, address and coils");
}

static void parse_options(char **words) {
  for (; *words; words++) {
    const char *word = *words;
    if (!strcmp(word, "--no-reset-on-open")) option.reset_on_open = false;
    else if (!strcmp(word, "--until-eof")) option.until_eof = true;
    else if (!strcmp(word, "--native-usb")) option.native_usb = true;
    else if (word[0] != '-') option.image = word;
    else if (!*++words) die("%s needs a value\n%s", word, usage);
    else if (!strcmp(word, "--mcu")) option.mcu = *words;
    else if (!strcmp(word, "--hz")) option.hz = (uint32_t)atol(*words);
    else if (!strcmp(word, "--tty")) option.tty = *words;
    else if (!strcmp(word, "--control")) option.control_port = atoi(*words);
    else if (!strcmp(word, "--eeprom")) option.eeprom = *words;
    else if (!strcmp(word, "--step-log")) option.step_log = *words;
    else if (!strcmp(word, "--axis")) parse_axis(*words);
    else if (!strcmp(word, "--coil")) parse_coil(*words);
    else if (!strcmp(word, "--coil-bus")) parse_coil_bus(*words);
    else if (!strcmp(word, "--boot-ms")) option.boot_ms = atoi(*words);
    else if (!strcmp(word, "--usb-ms")) option.usb_ms = atoi(*words);
    else if (!strcmp(word, "--catch-up-ms")) option.catch_up_ms = atoi(*words);
    else die("unknown option %s\n%s", word, usage);
  }
  if (!option.image) die("no image\n%s", usage);
}

static void make_processor(void) {
  elf_firmware_t image;
  memset(&image, 0, sizeof image);
  if (elf_read_firmware(option.image, &image)) die("%s is no ELF file for AVR", option.image);
  snprintf(image.mmcu, sizeof image.mmcu, "%s", option.mcu);
  image.frequency = option.hz;
  avr = avr_make_mcu_by_name(option.mcu);
  if (!avr) die("simavr knows no %s", option.mcu);
  avr_init(avr);
  avr->frequency = option.hz;
  avr->log = LOG_NONE;
  avr_load_firmware(avr, &image);
}

static void connect_usb(void) {
  for (avr_io_t *io = avr->io_port; io; io = io->next)
    if (!strcmp(io->kind, "usb")) usb = (avr_usb_t *)io;
  if (!usb) die("the %s has no native USB", option.mcu);
}

static void connect_uart(void) {
  for (avr_io_t *io = avr->io_port; io; io = io->next)
    if (!strcmp(io->kind, "uart") && ((avr_uart_t *)io)->name == '0') uart = (avr_uart_t *)io;
  if (!uart) die("the %s has no UART 0", option.mcu);
  uint32_t flags = 0; /* neither on standard output nor slowed down by simavr */
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  uart_input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT),
                          on_uart_output, NULL);
}

static void connect_motors(void) {
  for (int i = 0; i < axis_count; i++) {
    bool coils = axes[i].coil_address >= 0;
    if (coils && !coil_bus.strobe.port) die("axis %c needs a coil bus", axes[i].name);
    if (!coils) avr_irq_register_notify(pin_irq(axes[i].step), on_step_pin, &axes[i]);
  }
  if (coil_bus.strobe.port)
    avr_irq_register_notify(pin_irq(coil_bus.strobe), on_coil_strobe, NULL);
  avr_register_io_write(avr, TCCR0B, on_timer0_control, NULL);
  avr_register_io_write(avr, EECR, on_eeprom_control, NULL);
}

static void load_eeprom(void) {
  uint8_t bytes[4096];
  FILE *file = option.eeprom ? fopen(option.eeprom, "rb") : NULL;
  if (!file) return;
  size_t length = fread(bytes, 1, sizeof bytes, file);
  fclose(file);
  avr_eeprom_desc_t contents = {.ee = bytes, .offset = 0, .size = (uint32_t)length};
  avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &contents);
}

static void save_eeprom(void) {
  avr_eeprom_desc_t contents = {.ee = NULL, .offset = 0, .size = (uint32_t)avr->e2end + 1};
  avr_ioctl(avr, AVR_IOCTL_EEPROM_GET, &contents); /* what it returns differs between versions */
  FILE *file = option.eeprom && contents.ee ? fopen(option.eeprom, "wb") : NULL;
  if (!file) return;
  fwrite(contents.ee, 1, contents.size, file);
  fclose(file);
}

static void on_signal(int number) {
  (void)number;
  quitting = 1;
}

static void end_with_input(void) {
  char bytes[64];
  struct pollfd input = {STDIN_FILENO, POLLIN, 0};
  if (option.until_eof && poll(&input, 1, 0) > 0 && read(STDIN_FILENO, bytes, sizeof bytes) <= 0)
    quitting = 1;
}

static void run_slice(void) {
  avr_cycle_count_t end = avr->cycle + (avr_cycle_count_t)(option.hz * SLICE_S);
  int state = cpu_Running;
  while (avr->cycle < end && state != cpu_Done && state != cpu_Crashed) state = avr_run(avr);
  if (state == cpu_Crashed) reset("the firmware has crashed, or its watchdog has bitten", 0);
  /* a reset of the processor takes its timers with it */
  avr_cycle_timer_t line = usb ? on_usb_frame : on_byte_time;
  if (!avr_cycle_timer_status(avr, line, NULL))
    avr_cycle_timer_register(avr, option.hz / 11520, line, NULL);
}

static void run(void) {
  agree_on_time(now_ns());
  while (!quitting) {
    uint64_t began_ns = now_ns();
    bool idle = held(began_ns);
    if (!idle) run_slice();
    exchange_with_host(now_ns());
    answer_control();
    end_with_input();
    if (idle) { /* without power, or frozen: no simulated time passes */
      if (!pace.frozen) to_device.read = to_device.written;
      usleep(500);
      agree_on_time(now_ns());
    } else {
      keep_pace();
      pace.run_s += (double)(now_ns() - began_ns) / 1e9;
    }
  }
}

int main(int argument_count, char **arguments) {
  (void)argument_count;
  parse_options(arguments + 1);
  signal(SIGINT, on_signal);
  signal(SIGTERM, on_signal);
  signal(SIGPIPE, SIG_IGN);
  srand48(7);
  make_processor();
  load_eeprom();
  if (option.native_usb)
    connect_usb();
  else
    connect_uart();
  connect_motors();
  if (option.step_log && !(step_log = fopen(option.step_log, "w")))
    die("%s: %s", option.step_log, strerror(errno));
  if (step_log) fputs("cycle,axis,direction,position\n", step_log);
  snprintf(tty_path, sizeof tty_path, "%s", option.tty);
  memset(wired, 0xff, sizeof wired);
  int port = open_control(option.control_port);
  open_tty();
  preset_registers();
  apply_inputs();
  printf("ready %s %d\n", tty_path, port);
  fflush(stdout);
  run();
  if (step_log) fclose(step_log);
  unlink(tty_path);
  save_eeprom();
  return 0;
}
