/* The surface of a knob's board on whatever compiles this: bytes and angles in, torques' bits out.

`data.h` is written by the test: FRAMES (what a host sends) and COUNTS (of the encoder). Runs on this
machine, on a bare Arm core in qemu (semihosting), and on an ATmega328P in simavr (UART). */
#include <stdint.h>

#include "surface.h"

#if defined(__AVR__)
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#define FAR PROGMEM
#define FAR_BYTE(at) pgm_read_byte(&(at))
#define FAR_COUNT(at) ((int16_t)pgm_read_word(&(at)))
#else
#include <stdio.h>
#define FAR
#define FAR_BYTE(at) (at)
#define FAR_COUNT(at) (at)
#endif

#include "data.h"

static Knob knob;

#if defined(__AVR__)
static void say(char byte) {
    while (!(UCSR0A & (1 << UDRE0))) continue;
    UDR0 = (uint8_t)byte;
}
#else
static void say(char byte) { putchar(byte); }
#endif

static void say_bits(uint32_t bits) {
    int at;
    for (at = 28; at >= 0; at -= 4) say("0123456789abcdef"[bits >> at & 15]);
    say('\n');
}

/* not inlined: it saves floating-point registers, which are switched on before it */
__attribute__((noinline)) static int run(void) {
    static const uint8_t ALIVE[] = {KNOB_ALIVE, 1};
    uint32_t bits, n;
    float torque;
    knob_begin(&knob, 0.0f);
    for (n = 0; n < sizeof FRAMES; n++) knob_receive(&knob, FAR_BYTE(FRAMES[n]));
    for (n = 0; n < sizeof COUNTS / sizeof *COUNTS; n++) {
        if (n % 20 == 0) knob_take(&knob, ALIVE, 2);
        torque = knob_step(&knob, (float)FAR_COUNT(COUNTS[n]) * 3.8349519e-4f);
        memcpy(&bits, &torque, 4);
        say_bits(bits);
    }
    say_bits(knob.refused);
    return 0;
}

#if defined(__arm__)
#include "../../tools/cortex_m_start.h"
#else
int main(void) {
#if defined(__AVR__)
    UCSR0B = 1 << TXEN0;
#endif
    run();
#if defined(__AVR__)
    cli(); /* which ends the emulation */
    sleep_mode();
#endif
    return 0;
}
#endif
